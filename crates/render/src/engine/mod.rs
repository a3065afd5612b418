//! The render loop: passes over the film in parallel tiles, until enough samples, time or accuracy.
//!
//! A pixel's samples are added in their order by whoever holds its tile, and each is a function of (seed, pixel,
//! sample) alone, so that neither the number of threads nor the size of the passes changes a bit of the image.
//!
//! `spread.rs` says how many samples each pixel gets, `worker.rs` takes those of a tile one by one, `batch.rs` side by side.

mod batch;
mod spread;
mod worker;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rayon::prelude::*;

use crate::film::{FilmGeometry, PixelSums, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::path::{Counters, PathOptions};
use crate::plan::Plan;
use crate::scene::{BuiltScene, Scene};
use crate::sensor::Camera;
use spread::Spread;
use worker::{Benches, Taken, tile_pass};

/// Everything that a rendering needs, from the scene file and the command line.
#[derive(Debug)]
pub struct Job {
    /// Geometry, matter, light.
    pub scene: Scene,
    /// The sensor.
    pub camera: Camera,
    /// The film.
    pub film: FilmGeometry,
    /// The paths.
    pub paths: PathOptions,
    /// Which wavelengths.
    pub mode: SpectralMode,
    /// Whether the image has four components, or S0 alone.
    pub polarized: bool,
    /// What is followed.
    pub plan: Plan,
    /// Separation for the degree of coherence, metres toward image right and up; `None`: coherence is not asked for.
    pub coherence: Option<[f64; 2]>,
    /// Samples a pixel; on the mean if they are spread.
    pub samples: u64,
    /// Whether samples go to the pixels that need them, rather than to all alike.
    pub adaptive: bool,
    /// Samples that are stratified together, a power of two; at most so many if they are spread. 1: independent samples.
    pub block: u64,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Job {
    /// All Stokes components of a scene in its own samples, independent ones, with seed 0 and without coherence.
    pub fn new(built: BuiltScene, mode: SpectralMode) -> Self {
        let mut scene = built.scene;
        scene.weigh_lights(mode.range());
        Self {
            plan: Plan::in_full(&scene, &mode, true),
            scene,
            camera: built.camera,
            film: built.film,
            paths: built.paths,
            mode,
            polarized: true,
            coherence: None,
            samples: built.samples,
            adaptive: false,
            block: 1,
            seed: 0,
        }
    }
}

/// When to stop before all samples are taken.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Wall time for sampling.
    pub time: Option<Duration>,
    /// Errors to reach; samples go where they serve them.
    pub error: Option<Targets>,
}

/// Largest error of each Stokes component, as [`Rendering::errors`] has it; infinite for those that may have any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Targets(pub [f64; 4]);

/// State of the work after a pass.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    rendering: &'a Rendering,
    /// Samples a pixel so far, on the mean.
    pub samples: u64,
    /// Samples a pixel that were asked for.
    pub of: u64,
    /// What tracing has cost.
    pub counters: Counters,
    /// Wall time since the start.
    pub elapsed: Duration,
}

impl Progress<'_> {
    /// Error so far, as [`Rendering::error`]: a sum over the film, for those who ask.
    pub fn error(&self) -> f64 {
        self.rendering.error()
    }
}

/// A finished (or stopped) rendering.
#[derive(Debug)]
pub struct Rendering {
    /// Sums of all pixels.
    tiles: Vec<TileSums>,
    film: FilmGeometry,
    colours: usize,
    polarized: bool,
    /// Samples of all pixels.
    pub samples: u64,
    /// Whether pixels may have different numbers of samples.
    pub adaptive: bool,
    /// Samples left out because they were not finite.
    pub rejected: u64,
    /// What tracing has cost.
    pub counters: Counters,
    /// Wall time of sampling.
    pub wall: Duration,
    /// CPU time of sampling, all threads.
    pub cpu: Duration,
    /// Whether it was stopped by an interrupt.
    pub interrupted: bool,
}

impl Rendering {
    /// Components of the image: four, or one without polarization.
    pub fn components(&self) -> usize {
        if self.polarized { 4 } else { 1 }
    }

    /// Mean and variance of the mean for every pixel, `[row][column][component][colour]`, row 0 on top.
    pub fn image(&self) -> (Vec<f32>, Vec<f32>) {
        let [width, height] = self.film.crop_size;
        let stride = self.components() * self.colours;
        let mut means = vec![0.0; width as usize * height as usize * stride];
        let mut variances = means.clone();
        self.for_each_pixel(|x, y, pixel| {
            let start = (y as usize * width as usize + x as usize) * stride;
            for k in 0..stride {
                let (component, colour) = (k / self.colours, k % self.colours);
                let (mean, variance) = pixel.estimate(component, colour);
                means[start + k] = mean as f32;
                variances[start + k] = variance as f32;
            }
        });
        (means, variances)
    }

    /// Samples a pixel, on the mean.
    pub fn mean_samples(&self) -> f64 {
        self.samples as f64 / self.film.pixels() as f64
    }

    /// Samples of each pixel, `[row][column]`.
    pub fn samples_of_pixels(&self) -> Vec<u64> {
        let mut all = vec![0; self.film.pixels() as usize];
        self.for_each_pixel(|x, y, pixel| {
            all[y as usize * self.film.crop_size[0] as usize + x as usize] = pixel.samples();
        });
        all
    }

    /// Complete blocks of the pixel that has fewest.
    pub fn fewest_blocks(&self) -> u64 {
        let mut fewest = u64::MAX;
        self.for_each_pixel(|_, _, pixel| fewest = fewest.min(pixel.blocks()));
        fewest
    }

    /// Coherence of the light of every pixel as in [`crate::image::StokesImage::coherence`], if it was asked for.
    pub fn coherence(&self) -> Option<Vec<[f32; 4]>> {
        let [width, height] = self.film.crop_size.map(|n| n as usize);
        let mut all = vec![[f32::NAN; 4]; width * height];
        let mut any = false;
        for ((x, y), sums) in self.tiles.iter().flat_map(TileSums::coherence) {
            any = true;
            if let Some((ellipse, degree)) = sums.coherence() {
                all[y as usize * width + x as usize] = [
                    ellipse.semi_major,
                    ellipse.semi_minor,
                    ellipse.orientation,
                    degree,
                ]
                .map(|v| v as f32);
            }
        }
        any.then_some(all)
    }

    /// Whether [`Self::variance_of`] is known.
    pub fn sums_products(&self) -> bool {
        self.film.products && self.fewest_blocks() > 1
    }

    /// Variance of the mean of a weighted sum of the components of a pixel in one colour, from its samples.
    ///
    /// `None` where the film sums no products of components ([`FilmGeometry::products`]), or has fewer than two
    /// complete blocks.
    pub fn variance_of(&self, x: u32, y: u32, colour: usize, weights: &[f64; 4]) -> Option<f64> {
        let tile = &self.tiles[self.film.tile_of(x, y)];
        tile.pixel(x, y).variance_of(weights, colour)
    }

    /// √(mean variance of the mean)/mean S0, of the worst component.
    pub fn error(&self) -> f64 {
        self.errors().into_iter().fold(0.0, f64::max)
    }

    /// √(mean variance of the mean)/mean S0 of each component; 0 of those that the image lacks, and of a black image.
    pub fn errors(&self) -> [f64; 4] {
        let mut mean = 0.0;
        let mut variances = [0.0; 4];
        self.for_each_pixel(|_, _, pixel| {
            for (component, sum) in variances.iter_mut().enumerate().take(self.components()) {
                for colour in 0..self.colours {
                    let (value, variance) = pixel.estimate(component, colour);
                    *sum += variance;
                    if component == 0 {
                        mean += value;
                    }
                }
            }
        });
        let n = self.film.pixels() as f64 * self.colours as f64;
        variances.map(|sum| {
            if mean > 0.0 {
                (sum / n).sqrt() / (mean / n)
            } else {
                0.0
            }
        })
    }

    fn for_each_pixel(&self, mut visit: impl FnMut(u32, u32, PixelSums<'_>)) {
        for tile in &self.tiles {
            tile.for_each(&mut visit);
        }
    }
}

/// Samples of the first pass, of all pixels together, if that is more than one each.
const BEGINNING: u64 = 1 << 18;

/// Renders until all samples are taken, a limit is met or `stop` is set; `report` hears of every pass.
pub fn render(
    job: &Job,
    limits: Limits,
    stop: &AtomicBool,
    mut report: impl FnMut(Progress<'_>),
) -> Rendering {
    let (start, cpu_start) = (Instant::now(), ProcessTime::now());
    let filter = FilterSampler::new(job.film.filter);
    let colours = job.mode.colours();
    let mut rendering = Rendering {
        tiles: job.film.tiles(colours, job.coherence.is_some()),
        film: job.film.clone(),
        colours,
        polarized: job.polarized,
        samples: 0,
        adaptive: job.adaptive || limits.error.is_some(),
        rejected: 0,
        counters: Counters::default(),
        wall: Duration::ZERO,
        cpu: Duration::ZERO,
        interrupted: false,
    };
    let mut spread = rendering.adaptive.then(|| Spread::new(job, &limits));
    let mut goals = match &mut spread {
        Some(spread) => spread.next(&rendering.tiles),
        None => Some(Spread::uniform(job)),
    };
    // unless time is short, small films begin with some samples: every pass has to open and close each pixel
    let mut most = match limits.time {
        Some(_) => 1,
        None => (BEGINNING / job.film.pixels()).max(1),
    };
    let benches = Benches::new(job);
    'work: while let Some(current) = &goals {
        loop {
            let pass_start = Instant::now();
            let pass: Vec<Taken> = rendering
                .tiles
                .par_iter_mut()
                .map_init(
                    || benches.lend(),
                    |lent, tile| tile_pass(job, &filter, tile, (current, most), lent),
                )
                .collect();
            let mut taken = Taken::default();
            pass.into_iter().for_each(|of| taken += of);
            rendering.samples += taken.samples;
            rendering.rejected += taken.rejected;
            rendering.counters.paths += taken.counters.paths;
            rendering.counters.rays += taken.counters.rays;
            report(Progress {
                rendering: &rendering,
                samples: rendering.mean_samples() as u64,
                of: job.samples,
                counters: rendering.counters,
                elapsed: start.elapsed(),
            });
            if taken.open > 0 && stop.load(Ordering::Relaxed) {
                rendering.interrupted = true;
                break 'work;
            }
            if limits.time.is_some_and(|limit| start.elapsed() >= limit) {
                break 'work;
            }
            // passes of about half a second, or what is left of the time
            let seconds = pass_start.elapsed().as_secs_f64().max(1e-4);
            let left = limits.time.map_or(0.5, |limit| {
                limit.saturating_sub(start.elapsed()).as_secs_f64().min(0.5)
            });
            let samples = left / seconds * taken.samples as f64;
            if taken.open == 0 {
                most = ((samples / job.film.pixels() as f64) as u64).clamp(1, 4 * most);
                break;
            }
            most = ((samples / taken.open as f64) as u64).clamp(1, 4 * most);
        }
        // judged at goals alone, so that the image does not depend on how long a pass takes
        if let Some(Targets(targets)) = limits.error
            && rendering.fewest_blocks() > 1
            && (rendering.errors().iter().zip(targets)).all(|(error, target)| *error <= target)
        {
            break;
        }
        goals = spread
            .as_mut()
            .and_then(|spread| spread.next(&rendering.tiles));
        if goals.is_some() && stop.load(Ordering::Relaxed) {
            rendering.interrupted = true;
            break;
        }
    }
    rendering.wall = start.elapsed();
    rendering.cpu = cpu_start.elapsed();
    rendering
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Overrides, build, read_text};

    /// Renders until all samples are taken, or so many of all pixels together.
    fn rendered(adaptive: bool, until: u64) -> Rendering {
        let text = "<scene version='3.0.0'>
            <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='8'/>
                <integer name='height' value='8'/></film></sensor>
            <emitter type='constant'/>
            <shape type='sphere'><point name='center' x='0' y='0' z='4'/></shape></scene>";
        let document = read_text(text, "test.xml".as_ref(), &[]).unwrap();
        let built = build(&document, Overrides::default()).unwrap();
        let job = Job {
            samples: 64,
            adaptive,
            block: 4,
            ..Job::new(built, SpectralMode::Single(550.0))
        };
        let stop = AtomicBool::new(false);
        render(&job, Limits::default(), &stop, |progress| {
            if progress.rendering.samples >= until {
                stop.store(true, Ordering::Relaxed);
            }
        })
    }

    #[test]
    fn only_an_unfinished_image_has_been_interrupted() {
        let whole = [false, true].map(|adaptive| rendered(adaptive, u64::MAX));
        assert!(whole.iter().all(|rendering| !rendering.interrupted));
        for (adaptive, whole) in [false, true].into_iter().zip(&whole) {
            let late = rendered(adaptive, whole.samples);
            assert_eq!((late.samples, late.interrupted), (whole.samples, false));
        }
        let early = rendered(true, 1);
        assert!(early.samples < whole[1].samples && early.interrupted);
    }
}
