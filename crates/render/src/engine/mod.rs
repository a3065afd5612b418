//! The render loop: passes over the film in parallel tiles, until enough samples, time or accuracy.
//!
//! A pixel's samples are added in their order by whoever holds its tile, and each is a function of (seed, pixel,
//! sample) alone, so that neither the number of threads nor the size of the passes changes a bit of the image.
//!
//! `worker.rs` takes the samples of a tile.

mod worker;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rayon::prelude::*;

use crate::film::{Count, FilmGeometry, PixelSums, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::path::{Counters, PathOptions};
use crate::plan::Plan;
use crate::scene::{BuiltScene, Scene};
use crate::sensor::Camera;
use worker::tile_pass;

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
    /// Samples a pixel.
    pub samples: u64,
    /// Samples that are stratified together, see [`crate::sampler::Generator::block`]; 1: independent samples.
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
    /// Relative error to reach: see [`Rendering::error`].
    pub error: Option<f64>,
}

/// State of the work after a pass.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    rendering: &'a Rendering,
    /// Samples a pixel so far.
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
    /// Samples a pixel, and in what blocks.
    pub count: Count,
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
                let (mean, variance) = pixel.estimate(component, colour, self.count);
                means[start + k] = mean as f32;
                variances[start + k] = variance as f32;
            }
        });
        (means, variances)
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
        self.film.products && self.count.blocks() > 1
    }

    /// Variance of the mean of a weighted sum of the components of a pixel in one colour, from its samples.
    ///
    /// `None` where the film sums no products of components ([`FilmGeometry::products`]), or has fewer than two
    /// complete blocks.
    pub fn variance_of(&self, x: u32, y: u32, colour: usize, weights: &[f64; 4]) -> Option<f64> {
        let tile = &self.tiles[self.film.tile_of(x, y)];
        tile.pixel(x, y, self.colours)
            .variance_of(weights, colour, self.count)
    }

    /// √(mean variance of the mean)/mean S0, of the worst component.
    pub fn error(&self) -> f64 {
        let mut mean = 0.0;
        let mut variances = [0.0; 4];
        self.for_each_pixel(|_, _, pixel| {
            for (component, sum) in variances.iter_mut().enumerate().take(self.components()) {
                for colour in 0..self.colours {
                    let (value, variance) = pixel.estimate(component, colour, self.count);
                    *sum += variance;
                    if component == 0 {
                        mean += value;
                    }
                }
            }
        });
        let n = f64::from(self.film.crop_size[0])
            * f64::from(self.film.crop_size[1])
            * self.colours as f64;
        let worst = variances.into_iter().fold(0.0, f64::max);
        if mean > 0.0 {
            (worst / n).sqrt() / (mean / n)
        } else {
            0.0
        }
    }

    fn for_each_pixel(&self, mut visit: impl FnMut(u32, u32, PixelSums<'_>)) {
        for tile in &self.tiles {
            tile.for_each(self.colours, &mut visit);
        }
    }
}

/// Renders until all samples are taken, a limit is met or `stop` is set; `report` hears of every pass.
pub fn render(
    job: &Job,
    limits: Limits,
    stop: &AtomicBool,
    mut report: impl FnMut(Progress<'_>),
) -> Rendering {
    let filter = FilterSampler::new(job.film.filter);
    let colours = job.mode.colours();
    let mut rendering = Rendering {
        tiles: job.film.tiles(colours, job.coherence.is_some()),
        film: job.film.clone(),
        colours,
        polarized: job.polarized,
        count: Count {
            samples: 0,
            block: job.block,
        },
        rejected: 0,
        counters: Counters::default(),
        wall: Duration::ZERO,
        cpu: Duration::ZERO,
        interrupted: false,
    };
    let (start, cpu_start) = (Instant::now(), ProcessTime::now());
    let mut pass = 1;
    while rendering.count.samples < job.samples {
        let taken = rendering.count.samples;
        let range = taken..(taken + pass).min(job.samples);
        let pass_start = Instant::now();
        let results: Vec<(Counters, u64)> = rendering
            .tiles
            .par_iter_mut()
            .map_init(
                || job.scene.stack(),
                |stack, tile| tile_pass(job, &filter, tile, range.clone(), stack),
            )
            .collect();
        for (counters, rejected) in results {
            rendering.counters.paths += counters.paths;
            rendering.counters.rays += counters.rays;
            rendering.rejected += rejected;
        }
        let taken = range.end - range.start;
        rendering.count.samples = range.end;
        report(Progress {
            rendering: &rendering,
            samples: rendering.count.samples,
            of: job.samples,
            counters: rendering.counters,
            elapsed: start.elapsed(),
        });
        if stop.load(Ordering::Relaxed) {
            rendering.interrupted = rendering.count.samples < job.samples;
            break;
        }
        if limits.time.is_some_and(|limit| start.elapsed() >= limit)
            || limits
                .error
                .is_some_and(|limit| rendering.count.blocks() > 1 && rendering.error() <= limit)
        {
            break;
        }
        // passes of about half a second, or what is left of the time
        let seconds = pass_start.elapsed().as_secs_f64().max(1e-4) / taken as f64;
        let left = limits.time.map_or(0.5, |limit| {
            limit.saturating_sub(start.elapsed()).as_secs_f64().min(0.5)
        });
        pass = ((left / seconds) as u64).clamp(1, 4 * pass);
    }
    rendering.wall = start.elapsed();
    rendering.cpu = cpu_start.elapsed();
    rendering
}
