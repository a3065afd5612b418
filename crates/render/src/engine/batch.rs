//! One thread at work on paths side by side: camera samples of the pixels of a tile, some hundred at a time.

use std::marker::PhantomData;
use std::ops::Range;

use super::Job;
use super::spread::{Goal, Goals};
use super::worker::{PER_SAMPLE, Taken, go_on, listen, pixel_number};
use crate::colour::sample_wavelengths;
use crate::film::{Colours, SampleSums, SpectralMode, TileSums};
use crate::filter::FilterSampler;
use crate::geometry::bvh::Stack;
use crate::lanes::{Bits, COLUMNS, MOST, Real, Task};
use crate::light::Light;
use crate::light::abreast::Abreast;
use crate::path::wavefront::{Beginnings, Wavefront};
use crate::plan::Wavelengths;
use crate::sampler::{PixelStream, Stream, split};
use crate::sensor::Camera;

/// Samples of a pixel, one after the other.
struct Run {
    pixel: [u32; 2],
    first: u64,
    count: usize,
    /// Where the blocks of the pixel begin, and the last place of each: a power of two less one.
    block_start: u64,
    last: u64,
}

/// Words of samples that lanes read, a word each; the last samples are followed by as many as a lane may read beyond.
#[derive(Default)]
struct Words([Vec<u32>; 9]);

/// Column and row of the pixel, its stream, the sample's number, that of the first of its block, its place in there.
const COLUMN: usize = 0;
const ROW: usize = 1;
const PIXEL: usize = 2;
const NUMBER: usize = 4;
const START: usize = 6;
const PLACE: usize = 8;

impl Words {
    #[inline(always)]
    fn get<R: Real>(&self, word: usize, first: usize) -> R::B {
        let from = &self.0[word][first..first + R::LANES];
        R::B::from_fn(|lane| from[lane % R::LANES])
    }

    #[inline(always)]
    fn pair<R: Real>(&self, word: usize, first: usize) -> [R::B; 2] {
        [self.get::<R>(word, first), self.get::<R>(word + 1, first)]
    }
}

/// Camera samples that are traced together, and room for their paths.
pub(super) struct Batch {
    runs: Vec<Run>,
    words: Words,
    /// Whether they are stratified: all of them are, or none.
    stratified: bool,
    front: Wavefront,
    /// Wavelengths that were drawn, in nm, and their densities.
    drawn: Vec<[(f32, f32); PER_SAMPLE]>,
    colours: Colours,
    open: SampleSums,
}

impl Batch {
    /// Room for those of a job, if it can be done this way: matter that asks for the coherence of light follows paths one
    /// by one.
    pub(super) fn new(job: &Job) -> Option<Self> {
        if job.plan.dark || !Wavefront::follows(&job.scene, &job.camera) {
            return None;
        }
        let colours = job.mode.colours();
        let room = COLUMNS + MOST;
        Some(Self {
            runs: vec![],
            words: Words(std::array::from_fn(|_| vec![0; room])),
            stratified: false,
            front: Wavefront::new(&job.scene),
            drawn: vec![[(0.0, 0.0); PER_SAMPLE]; room],
            colours: Colours::new(colours, room),
            open: SampleSums::new(colours),
        })
    }

    /// Appends samples of a pixel from column `first` on.
    fn append(&mut self, job: &Job, first: usize, run: Run) {
        let film = &job.film;
        let [x, y] = run.pixel;
        let place = [x + film.crop_offset[0], y + film.crop_offset[1]];
        let stream = PixelStream::new(job.seed, pixel_number(film, place)).words();
        let words = &mut self.words.0;
        let all = first..first + run.count;
        let fixed = [place[0], place[1], stream[0], stream[1]];
        for (to, word) in words.iter_mut().zip(fixed) {
            to[all.clone()].fill(word);
        }
        for (number, at) in (run.first..).zip(all) {
            let place = (number - run.block_start) & run.last;
            let ([low, high], [start, start_high]) = (split(number), split(number - place));
            let varied = [low, high, start, start_high, place as u32];
            for (to, word) in words[NUMBER..].iter_mut().zip(varied) {
                to[at] = word;
            }
        }
        self.stratified = run.last > 0;
        self.runs.push(run);
    }
}

/// A pixel with samples still to take.
struct Unfinished {
    pixel: (u32, u32),
    goal: Goal,
    samples: Range<u64>,
}

/// Brings every pixel of a tile nearer to its goal, by at most `most` samples.
pub(super) struct Pass<'a, L> {
    pub(super) job: &'a Job,
    pub(super) filter: &'a FilterSampler,
    pub(super) tile: &'a mut TileSums,
    pub(super) goals: &'a Goals,
    pub(super) most: u64,
    pub(super) stack: &'a mut Stack,
    pub(super) batch: &'a mut Batch,
    pub(super) light: PhantomData<L>,
}

impl<L: Abreast> Task for Pass<'_, L> {
    type Output = Taken;

    #[inline(always)]
    fn run<R: Real>(mut self) -> Taken {
        let mut taken = Taken::default();
        let mut sums = vec![L::Single::dark(); COLUMNS + MOST];
        let mut pixels = self.tile.pixels();
        let mut unfinished = None;
        loop {
            let count = self.gather(&mut pixels, &mut unfinished, &mut taken);
            if count == 0 {
                return taken;
            }
            self.trace::<R>(count, &mut sums, &mut taken);
            self.settle(&mut taken);
        }
    }
}

impl<L: Abreast> Pass<'_, L> {
    /// Gathers samples of the pixels that follow, and says how many.
    fn gather(
        &mut self,
        pixels: &mut impl Iterator<Item = (u32, u32)>,
        unfinished: &mut Option<Unfinished>,
        taken: &mut Taken,
    ) -> usize {
        let mut count = 0;
        self.batch.runs.clear();
        while count < COLUMNS {
            let mut work = match unfinished.take() {
                Some(work) => work,
                None => {
                    let Some(pixel) = pixels.next() else {
                        break;
                    };
                    let work = go_on(self.tile, (self.goals, self.most), pixel, taken);
                    let Some((goal, samples)) = work else {
                        continue;
                    };
                    Unfinished {
                        pixel,
                        goal,
                        samples,
                    }
                }
            };
            if count > 0 && self.batch.stratified != (work.goal.block > 1) {
                *unfinished = Some(work);
                break;
            }
            let (x, y) = work.pixel;
            let left = work.samples.end - work.samples.start;
            let some = left.min((COLUMNS - count) as u64) as usize;
            let run = Run {
                pixel: [x, y],
                first: work.samples.start,
                count: some,
                block_start: work.goal.first,
                last: work.goal.block - 1,
            };
            self.batch.append(self.job, count, run);
            count += some;
            work.samples.start += some as u64;
            if !work.samples.is_empty() {
                *unfinished = Some(work);
            }
        }
        count
    }

    /// Traces them.
    #[inline(always)]
    fn trace<R: Real>(&mut self, count: usize, sums: &mut [L::Stokes], taken: &mut Taken) {
        let job = self.job;
        self.batch.colours.clear(count);
        let one = job.plan.wavelengths == Wavelengths::One;
        let paths = match &job.mode {
            SpectralMode::Bands { count, .. } if !one => count.div_ceil(L::LANES),
            SpectralMode::Rgb if !one => PER_SAMPLE / L::LANES,
            _ => 1,
        };
        for path in 0..paths {
            let first_wave = path * L::LANES;
            self.batch.front.clear();
            for first in (0..count).step_by(R::LANES) {
                self.begin::<R>(first, count, first_wave);
            }
            sums[..count].fill(L::Single::dark());
            self.batch.front.trace::<R, L>(
                &job.scene,
                &job.paths,
                self.stack,
                &mut taken.counters,
                sums,
            );
            self.colour(&sums[..count], first_wave);
        }
    }

    /// Begins the paths of a few samples from number `first` on, with the wavelengths from number `first_wave` on.
    #[inline(always)]
    fn begin<R: Real>(&mut self, first: usize, count: usize, first_wave: usize) {
        let job = self.job;
        let Camera::Perspective(camera) = &job.camera else {
            return;
        };
        let (film, batch) = (&job.film, &mut *self.batch);
        let words = &batch.words;
        let (pixel, number) = (
            words.pair::<R>(PIXEL, first),
            words.pair::<R>(NUMBER, first),
        );
        let stream: Stream<R> = if batch.stratified {
            let start = words.pair::<R>(START, first);
            Stream::in_block(pixel, number, start, words.get::<R>(PLACE, first))
        } else {
            Stream::alone(pixel, number)
        };
        let [u, v] = stream.pairs(R::B::splat(0));
        let [left, top] = film.crop_offset;
        let [right, bottom] = [left + film.crop_size[0], top + film.crop_size[1]];
        let column = words.get::<R>(COLUMN, first);
        let x = self.filter.positions(column, u, left, right);
        let row = words.get::<R>(ROW, first);
        let y = self.filter.positions(row, v, top, bottom);
        let (rays, axis) = camera.rays(x, y);
        let count = (count - first).min(R::LANES);
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
                    let band = (first_wave + w).min(count - 1) as f64;
                    *value =
                        R::from_fn(|lane| (from + width * (band + f64::from(place[lane]))) as f32);
                }
            }
            SpectralMode::Rgb => {
                let place = stream.pairs(R::B::splat(2))[0];
                let drawn = &mut batch.drawn[first..first + R::LANES];
                for k in 0..PER_SAMPLE {
                    let u = place + R::splat(k as f32 / PER_SAMPLE as f32);
                    let beyond = R::one().only(u.ge(R::one()));
                    let (nm, density) = sample_wavelengths(u - beyond);
                    let (all_nm, densities) = (nm.lanes(), density.lanes());
                    for (lane, drawn) in drawn.iter_mut().enumerate() {
                        drawn[k] = (all_nm[lane], densities[lane]);
                    }
                    let of_path = k.checked_sub(first_wave);
                    if let Some(value) = of_path.and_then(|w| wavelengths.as_mut().get_mut(w)) {
                        *value = nm;
                    }
                }
            }
        }
        let start = Beginnings {
            origin: rays.origin,
            direction: rays.direction,
            axis,
        };
        batch
            .front
            .begin::<R, L>(&start, &wavelengths, &stream, count);
    }

    /// Adds what was seen at the wavelengths from number `first_wave` on to the colours of the samples.
    fn colour(&mut self, sums: &[L::Stokes], first_wave: usize) {
        let job = self.job;
        let one = job.plan.wavelengths == Wavelengths::One;
        let batch = &mut *self.batch;
        for (sample, (seen, drawn)) in sums.iter().zip(&batch.drawn).enumerate() {
            let (mut colours, seen) = (batch.colours.sample(sample), seen.as_ref());
            match &job.mode {
                SpectralMode::Single(_) => colours.add(0, seen[0]),
                SpectralMode::Bands { count, .. } if one => {
                    (0..*count).for_each(|band| colours.add(band, seen[0]));
                }
                SpectralMode::Rgb if one => colours.add_grey(seen[0]),
                SpectralMode::Bands { count, .. } => {
                    for (w, stokes) in seen.iter().enumerate().take(count - first_wave) {
                        colours.add(first_wave + w, *stokes);
                    }
                }
                SpectralMode::Rgb => {
                    for (stokes, (wavelength, density)) in seen.iter().zip(&drawn[first_wave..]) {
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

    /// Adds the samples to their pixels.
    fn settle(&mut self, taken: &mut Taken) {
        let Batch {
            runs,
            colours,
            open,
            ..
        } = &mut *self.batch;
        let mut samples = 0..;
        for run in runs {
            let [x, y] = run.pixel;
            let end = run.first + run.count as u64;
            self.tile.open(x, y, open);
            for (number, sample) in (run.first..end).zip(&mut samples) {
                if !open.add(colours.values(sample)) {
                    taken.rejected += 1;
                }
                if (number - run.block_start) & run.last == run.last {
                    self.tile.close(x, y, open);
                }
            }
            self.tile.keep(x, y, open, end);
            if self.job.coherence.is_some() {
                let counters = listen::<L::Single>(
                    (self.job, self.filter),
                    self.tile,
                    run.pixel,
                    run.first..end,
                    (run.block_start, run.last),
                    self.stack,
                );
                taken.counters.paths += counters.paths;
                taken.counters.rays += counters.rays;
            }
        }
    }
}
