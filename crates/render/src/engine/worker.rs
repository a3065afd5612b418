//! One thread at work: camera samples of the pixels of a tile, one by one; `batch.rs` takes them side by side.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Mutex;

use super::Job;
use super::batch::{Batch, Pass};
use super::spread::{Goal, Goals};
use crate::colour::{rgb_weights, sample_wavelength};
use crate::film::{Colours, FilmGeometry, SampleColours, SampleSums, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::geometry::bvh::Stack;
use crate::lanes;
use crate::light::abreast::{Abreast, Stokes};
use crate::light::{Intensity, Light};
use crate::path::witness::{CoherenceSums, Listener, View};
use crate::path::{CameraSample, Counters, Start, trace};
use crate::plan::{Components, Wavelengths};
use crate::sampler::{PixelStream, SampleStream};

/// What a pass over a tile, or over all of them, has taken.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taken {
    /// What tracing has cost.
    pub(super) counters: Counters,
    /// Camera samples.
    pub(super) samples: u64,
    /// Of these, those left out because they were not finite.
    pub(super) rejected: u64,
    /// Pixels that have not reached their goal.
    pub(super) open: u64,
}

impl std::ops::AddAssign for Taken {
    fn add_assign(&mut self, other: Self) {
        self.counters.paths += other.counters.paths;
        self.counters.rays += other.counters.rays;
        self.samples += other.samples;
        self.rejected += other.rejected;
        self.open += other.open;
    }
}

/// What a thread works with.
struct Bench {
    stack: Stack,
    /// For paths side by side, where they can go so.
    batch: Option<Batch>,
}

impl Bench {
    /// For the tiles of a job.
    fn new(job: &Job) -> Self {
        Self {
            stack: job.scene.stack(),
            batch: Batch::new(job),
        }
    }
}

/// What threads work with, kept from one pass to the next.
pub(super) struct Benches<'a> {
    job: &'a Job,
    idle: Mutex<Vec<Bench>>,
}

/// What a thread works with, until it is dropped.
pub(super) struct Lent<'a> {
    bench: Option<Bench>,
    back: &'a Mutex<Vec<Bench>>,
}

impl<'a> Benches<'a> {
    /// For the tiles of a job; none yet.
    pub(super) fn new(job: &'a Job) -> Self {
        Self {
            job,
            idle: Mutex::default(),
        }
    }

    /// One that nobody uses, or a new one.
    pub(super) fn lend(&self) -> Lent<'_> {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        Lent {
            bench: Some(idle.unwrap_or_else(|| Bench::new(self.job))),
            back: &self.idle,
        }
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        if let (Ok(mut idle), Some(bench)) = (self.back.lock(), self.bench.take()) {
            idle.push(bench);
        }
    }
}

/// Brings every pixel of a tile nearer to its goal, by at most `most` samples.
pub(super) fn tile_pass(
    job: &Job,
    filter: &FilterSampler,
    tile: &mut TileSums,
    goals: (&Goals, u64),
    lent: &mut Lent<'_>,
) -> Taken {
    let bench = lent.bench.get_or_insert_with(|| Bench::new(job));
    let apart = job.plan.wavelengths != Wavelengths::Together;
    let pass = match (job.plan.stokes, apart) {
        (Components::Intensity, false) => pass::<Intensity<4>>,
        (Components::Intensity, true) => pass::<Intensity<1>>,
        (Components::Linear, false) => pass::<Stokes<4, 3>>,
        (Components::Linear, true) => pass::<Stokes<1, 3>>,
        (Components::All, false) => pass::<Stokes<4, 4>>,
        (Components::All, true) => pass::<Stokes<1, 4>>,
    };
    pass(job, filter, tile, goals, bench)
}

fn pass<L: Abreast>(
    job: &Job,
    filter: &FilterSampler,
    tile: &mut TileSums,
    (goals, most): (&Goals, u64),
    bench: &mut Bench,
) -> Taken {
    let stack = &mut bench.stack;
    match &mut bench.batch {
        Some(batch) => lanes::run(Pass::<L> {
            job,
            filter,
            tile,
            goals,
            most,
            stack,
            batch,
            light: PhantomData,
        }),
        None => Worker::<L::Single>::new(job, filter).run(tile, goals, most, stack),
    }
}

/// The number of a pixel of the whole film: a crop shows the same samples as the whole image.
pub(super) fn pixel_number(film: &FilmGeometry, [column, row]: [u32; 2]) -> u64 {
    u64::from(row) * u64::from(film.size[0]) + u64::from(column)
}

/// A pixel of the film.
struct Pixel {
    /// Column and row on the whole film.
    place: [u32; 2],
    number: u64,
    stream: PixelStream,
}

impl Pixel {
    /// At (x, y) of the crop window.
    fn new(job: &Job, x: u32, y: u32) -> Self {
        let film = &job.film;
        let place = [x + film.crop_offset[0], y + film.crop_offset[1]];
        let number = pixel_number(film, place);
        Self {
            place,
            number,
            stream: PixelStream::new(job.seed, number),
        }
    }
}

/// Wavelengths of a camera sample in colour, evenly apart: as many as a path carries, or a path each.
pub(super) const PER_SAMPLE: usize = 4;

/// One thread at work on one tile.
struct Worker<'a, L: Light> {
    job: &'a Job,
    filter: &'a FilterSampler,
    /// Whether light is followed elsewhere, and only its coherence here.
    listens: bool,
    taken: Taken,
    light: PhantomData<L>,
}

/// Adds the coherence of samples of a pixel, those from number `samples.start` on, of a run of blocks.
pub(super) fn listen<L: Light>(
    (job, filter): (&Job, &FilterSampler),
    tile: &mut TileSums,
    [x, y]: [u32; 2],
    samples: Range<u64>,
    (block_start, last): (u64, u64),
    stack: &mut Stack,
) -> Counters {
    let mut worker = Worker::<L>::new(job, filter);
    worker.listens = true;
    let pixel = Pixel::new(job, x, y);
    let mut colours = Colours::new(job.mode.colours(), 1);
    for sample in samples {
        let stream = stream_of(sample, (sample - block_start) & last, last);
        if let Some(coherence) = worker.sample(&pixel, &stream, colours.sample(0), stack) {
            tile.add_coherence(x, y, &coherence);
        }
    }
    worker.taken.counters
}

/// The random numbers of a sample of a pixel: number `place` of its block of `last + 1`.
fn stream_of(sample: u64, place: u64, last: u64) -> impl Fn(PixelStream) -> SampleStream {
    move |of| match last {
        0 => of.alone(sample),
        _ => of.in_block(sample, place as u32),
    }
}

/// Goes on with the run of a pixel, by at most `most` samples: its goal, and the samples to take. `None` at the goal.
pub(super) fn go_on(
    tile: &mut TileSums,
    (goals, most): (&Goals, u64),
    (x, y): (u32, u32),
    taken: &mut Taken,
) -> Option<(Goal, Range<u64>)> {
    let (next, goal) = (tile.taken(x, y), goals.of(x, y));
    let end = goal.end.min(next.saturating_add(most));
    if next >= end {
        return None;
    }
    taken.samples += end - next;
    taken.open += u64::from(end < goal.end);
    tile.go_on(x, y, goal.first, goal.block);
    Some((goal, next..end))
}

impl<'a, L: Light> Worker<'a, L> {
    fn new(job: &'a Job, filter: &'a FilterSampler) -> Self {
        Self {
            job,
            filter,
            listens: false,
            taken: Taken::default(),
            light: PhantomData,
        }
    }

    fn run(mut self, tile: &mut TileSums, goals: &Goals, most: u64, stack: &mut Stack) -> Taken {
        let mut colours = Colours::new(self.job.mode.colours(), 1);
        let mut open = SampleSums::new(self.job.mode.colours());
        for (x, y) in tile.pixels() {
            let work = go_on(tile, (goals, most), (x, y), &mut self.taken);
            let Some((goal, samples)) = work else {
                continue;
            };
            tile.open(x, y, &mut open);
            let pixel = Pixel::new(self.job, x, y);
            // a power of two
            let last = goal.block - 1;
            for sample in samples.clone() {
                let place = (sample - goal.first) & last;
                let stream = stream_of(sample, place, last);
                colours.clear(1);
                let coherence = self.sample(&pixel, &stream, colours.sample(0), stack);
                if let Some(coherence) = coherence {
                    tile.add_coherence(x, y, &coherence);
                }
                if !open.add(colours.values(0)) {
                    self.taken.rejected += 1;
                }
                if place == last {
                    tile.close(x, y, &mut open);
                }
            }
            tile.keep(x, y, &open, samples.end);
        }
        self.taken
    }

    /// One camera sample of a pixel; also its coherence, if that is asked for.
    #[inline]
    fn sample(
        &mut self,
        pixel: &Pixel,
        stream_of: &impl Fn(PixelStream) -> SampleStream,
        mut colours: SampleColours<'_>,
        stack: &mut Stack,
    ) -> Option<CoherenceSums> {
        let job = self.job;
        let film = &job.film;
        let [column, row] = pixel.place;
        let stream = stream_of(pixel.stream);
        let [u, v] = stream.pair(0);
        let end = [0, 1].map(|axis| film.crop_offset[axis] + film.crop_size[axis]);
        let film_x = self.filter.position(column, u, film.crop_offset[0], end[0]);
        let film_y = self.filter.position(row, v, film.crop_offset[1], end[1]);
        let start = job.camera.start(film_x, film_y);
        let mut ear = job.coherence.map(|separation| Ear {
            job,
            view: job.camera.view(column, row),
            start: job.camera.start(column as f32 + 0.5, row as f32 + 0.5),
            separation,
            stream: stream_of(PixelStream::new(!job.seed, pixel.number)),
            sums: CoherenceSums::default(),
        });
        // weights are those of the wavelengths in the coherence
        let mut path = |wavelengths: &[f32], weight: &dyn Fn(usize) -> f32| {
            if job.plan.dark {
                self.taken.counters.paths += 1;
                return L::dark();
            }
            if let Some(ear) = &mut ear {
                ear.listen::<L>(wavelengths, weight, stack, &mut self.taken.counters);
            }
            if self.listens {
                return L::dark();
            }
            let camera = CameraSample {
                start: &start,
                wavelengths,
                stream,
            };
            trace::<L, ()>(
                &job.scene,
                &job.paths,
                camera,
                stack,
                &mut self.taken.counters,
                &mut (),
            )
        };
        // where it does not depend on the wavelength
        let one = job.plan.wavelengths == Wavelengths::One;
        // where within its bands a sample looks
        let place = || stream.pair(2)[0];
        match &job.mode {
            SpectralMode::Single(wavelength) => {
                colours.add(0, path(&[*wavelength as f32], &|_| 1.0).as_ref()[0]);
            }
            SpectralMode::Bands { from, count, .. } if one => {
                let seen = path(&[*from as f32], &|_| 1.0).as_ref()[0];
                for band in 0..*count {
                    colours.add(band, seen);
                }
            }
            SpectralMode::Rgb if one => {
                let [first, _] = job.mode.range();
                colours.add_grey(path(&[first as f32], &|_| 1.0).as_ref()[0]);
            }
            SpectralMode::Bands { from, to, count } => {
                let (u, width) = (place(), (to - from) / *count as f64);
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
                let u = place();
                let drawn: [(f32, f32); PER_SAMPLE] = std::array::from_fn(|k| {
                    sample_wavelength((u + k as f32 / PER_SAMPLE as f32).fract())
                });
                for drawn in drawn.chunks(L::LANES) {
                    let wavelengths = L::lanes(|lane| drawn[lane].0);
                    let seen = path(wavelengths.as_ref(), &|lane| {
                        luminance(drawn[lane].0) / drawn[lane].1
                    });
                    for (stokes, &(wavelength, density)) in seen.as_ref().iter().zip(drawn) {
                        if job.plan.grey {
                            colours.add_grey(*stokes / PER_SAMPLE as f32);
                        } else {
                            let weight = (density * PER_SAMPLE as f32).recip();
                            colours.add_spectral(*stokes, wavelength, weight);
                        }
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
            start: &self.start,
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
