//! The render loop: passes over the film in parallel tiles, until enough samples, time or accuracy.
//!
//! A pixel's samples are added in their order by whoever holds its tile, and each is a function of (seed, pixel,
//! sample) alone, so that neither the number of threads nor the size of the passes changes a bit of the image.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rayon::prelude::*;

use crate::colour::{rgb_weights, sample_wavelength};
use crate::film::{FilmGeometry, PixelSums, SampleColours, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::geometry::bvh::Stack;
use crate::light::{Intensity, Light, Polarized};
use crate::path::witness::{CoherenceSums, Listener, View};
use crate::path::{CameraSample, Counters, PathOptions, Start, trace};
use crate::sampler::SampleStream;
use crate::scene::{BuiltScene, Scene};
use crate::sensor::Camera;

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
    /// Whether Stokes vectors are followed; where the scene makes no polarization S0 alone gives the same image.
    pub follow_polarization: bool,
    /// Separation for the degree of coherence, metres toward image right and up; `None`: coherence is not asked for.
    pub coherence: Option<[f64; 2]>,
    /// Samples a pixel.
    pub samples: u64,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Job {
    /// All Stokes components of a scene in its own samples, with seed 0 and without coherence.
    pub fn new(built: BuiltScene, mode: SpectralMode) -> Self {
        Self {
            scene: built.scene,
            camera: built.camera,
            film: built.film,
            paths: built.paths,
            mode,
            polarized: true,
            follow_polarization: true,
            coherence: None,
            samples: built.samples,
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
pub struct Progress {
    /// Samples a pixel so far.
    pub samples: u64,
    /// Samples a pixel that were asked for.
    pub of: u64,
    /// Error so far, as [`Rendering::error`].
    pub error: f64,
    /// What tracing has cost.
    pub counters: Counters,
    /// Wall time since the start.
    pub elapsed: Duration,
}

/// A finished (or stopped) rendering.
#[derive(Debug)]
pub struct Rendering {
    /// Sums of all pixels.
    tiles: Vec<TileSums>,
    film: FilmGeometry,
    colours: usize,
    polarized: bool,
    /// Samples a pixel.
    pub samples: u64,
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
                let (mean, variance) = pixel.estimate(component, colour, self.samples);
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
        self.film.products && self.samples > 1
    }

    /// Variance of the mean of a weighted sum of the components of a pixel in one colour, from its samples.
    ///
    /// `None` where the film sums no products of components ([`FilmGeometry::products`]), or after a single sample.
    pub fn variance_of(&self, x: u32, y: u32, colour: usize, weights: &[f64; 4]) -> Option<f64> {
        let tile = &self.tiles[self.film.tile_of(x, y)];
        tile.pixel(x, y, self.colours)
            .variance_of(weights, colour, self.samples)
    }

    /// √(mean variance of the mean)/mean S0, of the worst component.
    pub fn error(&self) -> f64 {
        let mut mean = 0.0;
        let mut variances = [0.0; 4];
        self.for_each_pixel(|_, _, pixel| {
            for (component, sum) in variances.iter_mut().enumerate().take(self.components()) {
                for colour in 0..self.colours {
                    let (value, variance) = pixel.estimate(component, colour, self.samples);
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
    mut report: impl FnMut(Progress),
) -> Rendering {
    let filter = FilterSampler::new(job.film.filter);
    let colours = job.mode.colours();
    let mut rendering = Rendering {
        tiles: job.film.tiles(colours, job.coherence.is_some()),
        film: job.film.clone(),
        colours,
        polarized: job.polarized,
        samples: 0,
        rejected: 0,
        counters: Counters::default(),
        wall: Duration::ZERO,
        cpu: Duration::ZERO,
        interrupted: false,
    };
    let (start, cpu_start) = (Instant::now(), ProcessTime::now());
    let mut pass = 1;
    while rendering.samples < job.samples {
        let range = rendering.samples..(rendering.samples + pass).min(job.samples);
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
        rendering.samples = range.end;
        let error = rendering.error();
        report(Progress {
            samples: rendering.samples,
            of: job.samples,
            error,
            counters: rendering.counters,
            elapsed: start.elapsed(),
        });
        if stop.load(Ordering::Relaxed) {
            rendering.interrupted = rendering.samples < job.samples;
            break;
        }
        if limits.time.is_some_and(|limit| start.elapsed() >= limit)
            || limits
                .error
                .is_some_and(|limit| rendering.samples > 1 && error <= limit)
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

/// Adds a range of samples to every pixel of a tile.
fn tile_pass(
    job: &Job,
    filter: &FilterSampler,
    tile: &mut TileSums,
    range: std::ops::Range<u64>,
    stack: &mut Stack,
) -> (Counters, u64) {
    match (&job.mode, job.follow_polarization) {
        (SpectralMode::Single(_), false) => {
            Worker::<Intensity<1>>::new(job, filter).run(tile, range, stack)
        }
        (SpectralMode::Single(_), true) => {
            Worker::<Polarized<1>>::new(job, filter).run(tile, range, stack)
        }
        // directions that depend on the wavelength: a path for each
        (_, false) if job.scene.traits().disperses => {
            Worker::<Intensity<1>>::new(job, filter).run(tile, range, stack)
        }
        (_, true) if job.scene.traits().disperses => {
            Worker::<Polarized<1>>::new(job, filter).run(tile, range, stack)
        }
        (_, false) => Worker::<Intensity<4>>::new(job, filter).run(tile, range, stack),
        (_, true) => Worker::<Polarized<4>>::new(job, filter).run(tile, range, stack),
    }
}

/// Wavelengths of a camera sample in colour, evenly apart: as many as a path carries, or a path each.
const PER_SAMPLE: usize = 4;

/// One thread at work on one tile.
struct Worker<'a, L: Light> {
    job: &'a Job,
    filter: &'a FilterSampler,
    counters: Counters,
    light: std::marker::PhantomData<L>,
}

impl<'a, L: Light> Worker<'a, L> {
    fn new(job: &'a Job, filter: &'a FilterSampler) -> Self {
        Self {
            job,
            filter,
            counters: Counters::default(),
            light: std::marker::PhantomData,
        }
    }

    fn run(
        mut self,
        tile: &mut TileSums,
        range: std::ops::Range<u64>,
        stack: &mut Stack,
    ) -> (Counters, u64) {
        let mut colours = SampleColours::new(self.job.mode.colours());
        let mut rejected = 0;
        for (x, y) in tile.pixels() {
            for sample in range.clone() {
                colours.clear();
                let coherence = self.sample(x, y, sample, &mut colours, stack);
                if let Some(coherence) = coherence {
                    tile.add_coherence(x, y, &coherence);
                }
                if !tile.add(x, y, &colours) {
                    rejected += 1;
                }
            }
        }
        (self.counters, rejected)
    }

    /// One camera sample of the pixel at (x, y) of the crop window; also its coherence, if that is asked for.
    fn sample(
        &mut self,
        x: u32,
        y: u32,
        sample: u64,
        colours: &mut SampleColours,
        stack: &mut Stack,
    ) -> Option<CoherenceSums> {
        let job = self.job;
        let film = &job.film;
        let (column, row) = (x + film.crop_offset[0], y + film.crop_offset[1]);
        // numbered on the whole film: a crop shows the same samples as the whole image
        let pixel = u64::from(row) * u64::from(film.size[0]) + u64::from(column);
        let stream = SampleStream::new(job.seed, pixel, sample);
        let [u, v] = stream.pair(0);
        let end = [0, 1].map(|axis| film.crop_offset[axis] + film.crop_size[axis]);
        let film_x = self.filter.position(column, u, film.crop_offset[0], end[0]);
        let film_y = self.filter.position(row, v, film.crop_offset[1], end[1]);
        let start = job.camera.start(film_x, film_y);
        let [u, _] = stream.pair(2);
        let mut ear = job.coherence.map(|separation| Ear {
            job,
            view: job.camera.view(column, row),
            start: job.camera.start(column as f32 + 0.5, row as f32 + 0.5),
            separation,
            stream: SampleStream::new(!job.seed, pixel, sample),
            sums: CoherenceSums::default(),
        });
        // weights are those of the wavelengths in the coherence
        let mut path = |wavelengths: &[f32], weight: &dyn Fn(usize) -> f32| {
            if let Some(ear) = &mut ear {
                ear.listen::<L>(wavelengths, weight, stack, &mut self.counters);
            }
            let camera = CameraSample {
                start,
                wavelengths,
                stream,
            };
            trace::<L, ()>(
                &job.scene,
                &job.paths,
                camera,
                stack,
                &mut self.counters,
                &mut (),
            )
        };
        match &job.mode {
            SpectralMode::Single(wavelength) => {
                colours.add(0, path(&[*wavelength as f32], &|_| 1.0).as_ref()[0]);
            }
            SpectralMode::Bands { from, to, count } => {
                let width = (to - from) / *count as f64;
                // the same place within every band; the last path may have lanes left over
                for first in (0..*count).step_by(L::LANES) {
                    let wavelengths = L::lanes(|lane| {
                        let band = (first + lane).min(count - 1);
                        (from + width * (band as f64 + f64::from(u))) as f32
                    });
                    let seen = path(wavelengths.as_ref(), &|lane| {
                        f32::from(first + lane < *count)
                    });
                    for (lane, stokes) in seen.as_ref().iter().enumerate().take(count - first) {
                        colours.add(first + lane, *stokes);
                    }
                }
            }
            SpectralMode::Rgb => {
                let drawn: [(f32, f32); PER_SAMPLE] = std::array::from_fn(|k| {
                    sample_wavelength((u + k as f32 / PER_SAMPLE as f32).fract())
                });
                for drawn in drawn.chunks(L::LANES) {
                    let wavelengths = L::lanes(|lane| drawn[lane].0);
                    let seen = path(wavelengths.as_ref(), &|lane| {
                        luminance(drawn[lane].0) / drawn[lane].1
                    });
                    for (stokes, &(wavelength, density)) in seen.as_ref().iter().zip(drawn) {
                        let weight = (density * PER_SAMPLE as f32).recip();
                        colours.add_spectral(*stokes, wavelength, weight);
                    }
                }
            }
        }
        ear.map(|ear| ear.sums)
    }
}

/// What the eye makes of a wavelength in nm, Rec. 709.
fn luminance(wavelength: f32) -> f32 {
    let [r, g, b] = rgb_weights(wavelength);
    (0.2126 * r + 0.7152 * g + 0.0722 * b).max(0.0)
}

/// Listens for the coherence of a camera sample, along a path of its own from the middle of the pixel: over the whole
/// pixel the light's mean direction varies, and that is not its coherence.
struct Ear<'a> {
    job: &'a Job,
    view: View,
    start: Start<'a>,
    separation: [f64; 2],
    stream: SampleStream,
    sums: CoherenceSums,
}

impl Ear<'_> {
    fn listen<L: Light>(
        &mut self,
        wavelengths: &[f32],
        weight: &dyn Fn(usize) -> f32,
        stack: &mut Stack,
        counters: &mut Counters,
    ) {
        let lanes: [(f64, f64); PER_SAMPLE] = std::array::from_fn(|lane| {
            wavelengths.get(lane).map_or((0.0, 0.0), |nm| {
                let k = std::f64::consts::TAU / (f64::from(*nm) * 1e-9);
                (k, f64::from(weight(lane)))
            })
        });
        let mut listener = Listener::new(&self.view, &lanes, self.separation);
        let camera = CameraSample {
            start: self.start,
            wavelengths,
            stream: self.stream,
        };
        trace::<L, _>(
            &self.job.scene,
            &self.job.paths,
            camera,
            stack,
            counters,
            &mut listener,
        );
        self.sums.merge(&listener.sums);
    }
}
