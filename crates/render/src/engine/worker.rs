//! One thread at work: camera samples of the pixels of a tile.

use super::Job;
use super::spread::Goals;
use crate::colour::{rgb_weights, sample_wavelength};
use crate::film::{SampleColours, SampleSums, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::geometry::bvh::Stack;
use crate::lanes::{Bits, Real, Task, run};
use crate::light::abreast::Abreast;
use crate::light::{Intensity, Light, Polarized};
use crate::path::abreast::{self, QUEUE, Queue};
use crate::path::witness::{CoherenceSums, Listener, View};
use crate::path::{CameraSample, Counters, Start, trace};
use crate::plan::Wavelengths;
use crate::sampler::{PixelStream, SampleStream};
use crate::sensor::Camera;

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

/// Brings every pixel of a tile nearer to its goal, by at most `most` samples.
pub(super) fn tile_pass(
    job: &Job,
    filter: &FilterSampler,
    tile: &mut TileSums,
    (goals, most): (&Goals, u64),
    stack: &mut Stack,
) -> Taken {
    match (job.plan.stokes, job.plan.wavelengths) {
        (false, Wavelengths::Together) => {
            run(Worker::<Intensity<4>>::new(job, filter).pass(tile, goals, most, stack))
        }
        (true, Wavelengths::Together) => {
            run(Worker::<Polarized<4>>::new(job, filter).pass(tile, goals, most, stack))
        }
        (false, Wavelengths::One | Wavelengths::Apart) => {
            run(Worker::<Intensity<1>>::new(job, filter).pass(tile, goals, most, stack))
        }
        (true, Wavelengths::One | Wavelengths::Apart) => {
            run(Worker::<Polarized<1>>::new(job, filter).pass(tile, goals, most, stack))
        }
    }
}

/// A pixel of the film.
struct Pixel {
    /// Column and row on the whole film.
    place: [u32; 2],
    /// Numbered on the whole film: a crop shows the same samples as the whole image.
    number: u64,
    stream: PixelStream,
}

impl Pixel {
    /// At (x, y) of the crop window.
    fn new(job: &Job, x: u32, y: u32) -> Self {
        let film = &job.film;
        let place = [x + film.crop_offset[0], y + film.crop_offset[1]];
        let number = u64::from(place[1]) * u64::from(film.size[0]) + u64::from(place[0]);
        Self {
            place,
            number,
            stream: PixelStream::new(job.seed, number),
        }
    }
}

/// Wavelengths of a camera sample in colour, evenly apart: as many as a path carries, or a path each.
const PER_SAMPLE: usize = 4;

/// Samples of a pixel, one after the other.
struct Samples<'a> {
    pixel: &'a Pixel,
    first: u64,
    count: usize,
    /// Place of the first in its block, and the last place of a block.
    place: u32,
    last: u32,
}

/// A pass of a worker over a tile.
struct Pass<'a, 't, L: Abreast> {
    worker: Worker<'a, L>,
    tile: &'t mut TileSums,
    goals: &'t Goals,
    most: u64,
    stack: &'t mut Stack,
}

impl<L: Abreast> Task for Pass<'_, '_, L> {
    type Output = Taken;

    #[inline(always)]
    fn run<R: Real>(self) -> Taken {
        self.worker
            .run::<R>(self.tile, self.goals, self.most, self.stack)
    }
}

/// One thread at work on one tile.
struct Worker<'a, L: Abreast> {
    job: &'a Job,
    filter: &'a FilterSampler,
    taken: Taken,
    light: std::marker::PhantomData<L>,
}

impl<'a, L: Abreast> Worker<'a, L> {
    fn new(job: &'a Job, filter: &'a FilterSampler) -> Self {
        Self {
            job,
            filter,
            taken: Taken::default(),
            light: std::marker::PhantomData,
        }
    }

    fn pass<'t>(
        self,
        tile: &'t mut TileSums,
        goals: &'t Goals,
        most: u64,
        stack: &'t mut Stack,
    ) -> Pass<'a, 't, L> {
        Pass {
            worker: self,
            tile,
            goals,
            most,
            stack,
        }
    }

    /// Whether paths go side by side: matter that asks for the coherence of light, and what listens for it, follows them
    /// one by one.
    fn goes_abreast(&self) -> bool {
        let job = self.job;
        !job.scene.traits().coherent
            && job.coherence.is_none()
            && !job.plan.dark
            && matches!(job.camera, Camera::Perspective(_))
    }

    #[inline(always)]
    fn run<R: Real>(
        mut self,
        tile: &mut TileSums,
        goals: &Goals,
        most: u64,
        stack: &mut Stack,
    ) -> Taken {
        let abreast = self.goes_abreast();
        let mut colours = SampleColours::new(self.job.mode.colours());
        let mut side_by_side = vec![colours.clone(); if abreast { QUEUE } else { 0 }];
        let mut open = SampleSums::new(self.job.mode.colours());
        for (x, y) in tile.pixels() {
            let (taken, goal) = (tile.taken(x, y), goals.of(x, y));
            let end = goal.end.min(taken.saturating_add(most));
            if taken >= end {
                continue;
            }
            self.taken.samples += end - taken;
            self.taken.open += u64::from(end < goal.end);
            tile.go_on(x, y, goal.first, goal.block);
            tile.open(x, y, &mut open);
            let pixel = Pixel::new(self.job, x, y);
            // a power of two
            let last = goal.block - 1;
            if abreast {
                for first in (taken..end).step_by(QUEUE) {
                    let count = (end - first).min(QUEUE as u64) as usize;
                    let place = (first - goal.first) & last;
                    let samples = Samples {
                        pixel: &pixel,
                        first,
                        count,
                        place: place as u32,
                        last: last as u32,
                    };
                    self.samples::<R>(&samples, &mut side_by_side, stack);
                    for (colours, sample) in side_by_side.iter().take(count).zip(first..) {
                        if !open.add(colours) {
                            self.taken.rejected += 1;
                        }
                        if (sample - goal.first) & last == last {
                            tile.close(x, y, &mut open);
                        }
                    }
                }
                tile.keep(x, y, &open, end);
                continue;
            }
            for sample in taken..end {
                let place = (sample - goal.first) & last;
                let stream = |of: PixelStream| match last {
                    0 => of.alone(sample),
                    _ => of.in_blocks(sample, place as u32, last as u32),
                };
                colours.clear();
                let coherence = self.sample(&pixel, &stream, &mut colours, stack);
                if let Some(coherence) = coherence {
                    tile.add_coherence(x, y, &coherence);
                }
                if !open.add(&colours) {
                    self.taken.rejected += 1;
                }
                if place == last {
                    tile.close(x, y, &mut open);
                }
            }
            tile.keep(x, y, &open, end);
        }
        self.taken
    }

    /// Camera samples of a pixel side by side.
    #[inline(always)]
    fn samples<R: Real>(
        &mut self,
        samples: &Samples<'_>,
        colours: &mut [SampleColours],
        stack: &mut Stack,
    ) {
        let job = self.job;
        for colours in colours.iter_mut() {
            colours.clear();
        }
        let one = job.plan.wavelengths == Wavelengths::One;
        let paths = match &job.mode {
            SpectralMode::Bands { count, .. } if !one => count.div_ceil(L::LANES),
            SpectralMode::Rgb if !one => PER_SAMPLE / L::LANES,
            _ => 1,
        };
        let mut drawn = [[(0.0, 0.0); PER_SAMPLE]; QUEUE];
        let mut seen = [L::dark(); QUEUE];
        for path in 0..paths {
            let first = path * L::LANES;
            let mut queue = Queue::default();
            while queue.count < samples.count {
                self.queue_up::<R>(samples, first, &mut queue, &mut drawn);
            }
            abreast::trace::<R, L>(
                &job.scene,
                &job.paths,
                &queue,
                stack,
                &mut self.taken.counters,
                &mut seen,
            );
            for (k, colours) in colours.iter_mut().enumerate().take(samples.count) {
                let seen = seen[k].as_ref();
                match &job.mode {
                    SpectralMode::Single(_) => colours.add(0, seen[0]),
                    SpectralMode::Bands { count, .. } if one => {
                        (0..*count).for_each(|band| colours.add(band, seen[0]));
                    }
                    SpectralMode::Rgb if one => colours.add_grey(seen[0]),
                    SpectralMode::Bands { count, .. } => {
                        for (w, stokes) in seen.iter().enumerate().take(count - first) {
                            colours.add(first + w, *stokes);
                        }
                    }
                    SpectralMode::Rgb => {
                        for (stokes, (wavelength, density)) in seen.iter().zip(&drawn[k][first..])
                        {
                            if job.plan.grey {
                                colours.add_grey(*stokes / PER_SAMPLE as f32);
                            } else {
                                let weight = (density * PER_SAMPLE as f32).recip();
                                colours.add_spectral(*stokes, *wavelength, weight);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Appends a few samples to the queue, with the wavelengths from number `path` on; notes those that are drawn.
    #[inline(always)]
    fn queue_up<R: Real>(
        &self,
        samples: &Samples<'_>,
        path: usize,
        queue: &mut Queue,
        drawn: &mut [[(f32, f32); PER_SAMPLE]; QUEUE],
    ) {
        let job = self.job;
        let Camera::Perspective(camera) = &job.camera else {
            return;
        };
        let (film, pixel, begun) = (&job.film, samples.pixel, queue.count);
        let first = samples.first + begun as u64;
        let stream = match samples.last {
            0 => pixel.stream.alone::<R>(first),
            last => {
                let place = (samples.place + begun as u32) & last;
                pixel.stream.in_blocks::<R>(first, place, last)
            }
        };
        let [column, row] = pixel.place;
        let [u, v] = stream.pairs(R::B::splat(0));
        let end = [
            film.crop_offset[0] + film.crop_size[0],
            film.crop_offset[1] + film.crop_size[1],
        ];
        let x = self.filter.positions(column, u, film.crop_offset[0], end[0]);
        let y = self.filter.positions(row, v, film.crop_offset[1], end[1]);
        let (rays, axes) = camera.rays(x, y);
        let count = (samples.count - begun).min(R::LANES);
        let one = job.plan.wavelengths == Wavelengths::One;
        let mut wavelengths = L::values(R::zero());
        match &job.mode {
            SpectralMode::Single(wavelength) => {
                wavelengths = L::values(R::splat(*wavelength as f32));
            }
            mode if one => wavelengths = L::values(R::splat(mode.range()[0] as f32)),
            SpectralMode::Bands { from, to, count } => {
                let place = stream.pairs(R::B::splat(2))[0].lanes();
                let width = (to - from) / *count as f64;
                for (w, value) in wavelengths.as_mut().iter_mut().enumerate() {
                    let band = (path + w).min(count - 1) as f64;
                    *value =
                        R::from_fn(|lane| (from + width * (band + f64::from(place[lane]))) as f32);
                }
            }
            SpectralMode::Rgb => {
                let place = stream.pairs(R::B::splat(2))[0].lanes();
                for (drawn, u) in drawn[begun..].iter_mut().zip(place).take(count) {
                    *drawn = std::array::from_fn(|k| {
                        sample_wavelength((u + k as f32 / PER_SAMPLE as f32).fract())
                    });
                }
                for (w, value) in wavelengths.as_mut().iter_mut().enumerate() {
                    let last = QUEUE - 1;
                    *value = R::from_fn(|lane| drawn[(begun + lane).min(last)][path + w].0);
                }
            }
        }
        queue.append(
            (rays.origin, rays.direction, axes),
            wavelengths.as_ref(),
            &stream,
            count,
        );
    }

    /// One camera sample of a pixel; also its coherence, if that is asked for.
    #[inline]
    fn sample(
        &mut self,
        pixel: &Pixel,
        stream_of: &impl Fn(PixelStream) -> SampleStream,
        colours: &mut SampleColours,
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
