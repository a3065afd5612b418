//! Where samples go: to all pixels alike, or to those that need them.
//!
//! The mean variance of an image is least for a given number of samples if each pixel has them in proportion to the
//! standard deviation of one. That is estimated, and an estimate must not choose its own number of samples: a pixel
//! that has missed a rare bright path would look quiet and get no more, and the image would be too dark. So a pixel's
//! number follows from its neighbours alone, and from them only through samples of which every pixel has as many. Its
//! own light enters only through the one factor that all pixels share, so that what remains of the bias is smaller by
//! the number of pixels.
//!
//! Rounds: all pixels get samples alike, until each has E; the last of these tell how many each gets of 4 E on the mean.
//! Then E doubles.
//!
//! Source: the allocation is Neyman's, On the Two Different Aspects of the Representative Method, 1934; the bias of
//! estimates that choose their own samples: Kirk and Arvo, Unbiased Sampling Techniques for Image Synthesis, SIGGRAPH 1991.

use super::{Job, Limits};
use crate::film::TileSums;
use crate::sampler::SampleStream;

/// Blocks of the samples that all pixels get alike in a round.
const ALIKE: u64 = 4;

/// First samples of every pixel where nobody knows how many there will be.
const FIRST: u64 = 64;

/// Of all samples every pixel gets at least this part of the mean.
const EVEN: u64 = 4;

/// No pixel gets more than so many times the mean: light of one rare path must not draw all samples to it.
const CAP: f64 = 16.0;

/// Blocks of the samples that a pixel gets for itself in a round: so many, or up to twice as many.
const OWN: u64 = 8;

/// Steps in which these are taken if the error is judged between them.
const STEPS: u64 = 8;

/// How far neighbours look, pixels.
const REACH: u32 = 2;

/// A run of blocks of a pixel, see [`crate::film::Run`], and how far it shall go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Goal {
    /// Samples before the run.
    pub(super) first: u64,
    /// Samples a block.
    pub(super) block: u64,
    /// Samples to have, with those before.
    pub(super) end: u64,
}

/// How many samples each pixel shall have.
#[derive(Clone, Debug)]
pub(super) enum Goals {
    /// The same for all.
    Same(Goal),
    /// Each its own, `[row][column]` of the crop window.
    Own {
        /// Pixels in a row.
        width: u32,
        /// Of each pixel.
        goals: Vec<Goal>,
    },
}

impl Goals {
    /// Of the pixel at (x, y) of the crop window.
    #[inline]
    pub(super) fn of(&self, x: u32, y: u32) -> Goal {
        match self {
            Self::Same(goal) => *goal,
            Self::Own { width, goals } => goals[y as usize * *width as usize + x as usize],
        }
    }
}

/// The goals of a rendering, one after the other; each is a function of the job and of the samples so far.
#[derive(Debug)]
pub(super) struct Spread {
    size: [u32; 2],
    /// Samples of a pixel on the mean, at most.
    most: u64,
    /// Samples a block, at most.
    largest_block: u64,
    /// Whether nobody knows how many samples there will be.
    open_ended: bool,
    /// Whether the error is judged between goals.
    judged: bool,
    /// What one unit of the variance of each component counts; `None`: what makes their means equal.
    weights: Option<[f64; 4]>,
    stage: Stage,
    /// Samples that all pixels have had alike.
    even: u64,
}

#[derive(Debug)]
enum Stage {
    /// Nothing yet.
    Begin,
    /// Runs for all pixels, in steps.
    Steps {
        runs: Vec<Goal>,
        step: u64,
        of: u64,
        /// Whether all pixels get the same; if not, each its own.
        alike: bool,
    },
    /// No more goals.
    Finished,
}

impl Spread {
    pub(super) fn new(job: &Job, limits: &Limits) -> Self {
        Self {
            size: job.film.crop_size,
            most: job.samples,
            largest_block: job.block,
            open_ended: limits.error.is_some() || limits.time.is_some(),
            judged: limits.error.is_some(),
            weights: limits
                .error
                .map(|error| error.0.map(|target| target.powi(-2))),
            stage: Stage::Begin,
            even: 0,
        }
    }

    /// The one goal of a rendering whose pixels have the same number of samples.
    pub(super) fn uniform(job: &Job) -> Goals {
        Goals::Same(Goal {
            first: 0,
            block: job.block,
            end: job.samples,
        })
    }

    /// The next goal, when the one before is reached; `None`: that was the last.
    pub(super) fn next(&mut self, tiles: &[TileSums]) -> Option<Goals> {
        loop {
            match std::mem::replace(&mut self.stage, Stage::Finished) {
                Stage::Finished => return None,
                Stage::Begin => {
                    let part = ALIKE * power_of_two(self.most / (EVEN * ALIKE));
                    let first = if self.open_ended {
                        part.min(FIRST)
                    } else {
                        part
                    };
                    self.stage = self.alike(tiles, first.min(self.most));
                }
                Stage::Steps {
                    runs,
                    step,
                    of,
                    alike,
                } if step < of => {
                    let goals = runs.iter().map(|run| run.cut(step + 1, of)).collect();
                    self.stage = Stage::Steps {
                        runs,
                        step: step + 1,
                        of,
                        alike,
                    };
                    return Some(Goals::Own {
                        width: self.size[0],
                        goals,
                    });
                }
                Stage::Steps { alike: true, .. } => {
                    let taken = self.of_pixels(tiles, TileSums::taken);
                    let variances = self.of_pixels(tiles, |tile, x, y| {
                        let pixel = tile.pixel(x, y);
                        std::array::from_fn(|k| pixel.variance_in_run(k))
                    });
                    let total = self.even.saturating_mul(EVEN).min(self.most);
                    let shares = self.shares(&variances, total);
                    let runs = (0..)
                        .zip(taken)
                        .zip(shares)
                        .map(|((pixel, taken), share)| self.own_run(pixel, taken, share))
                        .collect();
                    self.stage = Stage::Steps {
                        runs,
                        step: 0,
                        of: if self.judged { STEPS } else { 1 },
                        alike: false,
                    };
                }
                Stage::Steps { alike: false, .. } => {
                    let left = self.most.saturating_sub(self.even.saturating_mul(EVEN));
                    if left >= ALIKE {
                        let more = ALIKE * power_of_two(self.even.min(left) / ALIKE);
                        self.stage = self.alike(tiles, more);
                    }
                }
            }
        }
    }

    /// So many samples more for all pixels.
    fn alike(&mut self, tiles: &[TileSums], more: u64) -> Stage {
        self.even += more;
        let block = power_of_two(more / ALIKE).min(self.largest_block);
        Stage::Steps {
            runs: self.of_pixels(tiles, |tile, x, y| {
                let first = tile.taken(x, y);
                Goal {
                    first,
                    block,
                    end: first + more,
                }
            }),
            step: 0,
            of: if self.judged { ALIKE } else { 1 },
            alike: true,
        }
    }

    /// Of each pixel, `[row][column]`.
    fn of_pixels<T: Copy + Default>(
        &self,
        tiles: &[TileSums],
        value: impl Fn(&TileSums, u32, u32) -> T,
    ) -> Vec<T> {
        let [width, height] = self.size.map(|n| n as usize);
        let mut list = vec![T::default(); width * height];
        for tile in tiles {
            for (x, y) in tile.pixels() {
                list[y as usize * width + x as usize] = value(tile, x, y);
            }
        }
        list
    }

    /// Samples that each pixel should have, `total` on the mean, by the variances of a sample of those around it.
    fn shares(&self, variances: &[[f64; 4]], total: u64) -> Vec<f64> {
        let mut sums = [0.0; 4];
        for variances in variances {
            for (sum, variance) in sums.iter_mut().zip(variances) {
                *sum += variance;
            }
        }
        let alike = sums.map(|sum| if sum > 0.0 { sum.recip() } else { 0.0 });
        let weights = self.weights.unwrap_or(alike);
        let noise: Vec<f64> = variances
            .iter()
            .map(|of| (0..4).map(|k| weights[k] * of[k]).sum())
            .collect();
        let wanted: Vec<f64> = (0..self.size[1])
            .flat_map(|y| (0..self.size[0]).map(move |x| (x, y)))
            .map(|(x, y)| self.around(&noise, x, y).sqrt())
            .collect();
        fill(&wanted, self.even as f64, total as f64)
    }

    /// Mean over the neighbours of a pixel, without itself: the ring next to it counts as much as the one beyond.
    fn around(&self, noise: &[f64], x: u32, y: u32) -> f64 {
        let [width, height] = self.size;
        let (mut sum, mut weight) = (0.0, 0.0);
        for row in y.saturating_sub(REACH)..=(y + REACH).min(height - 1) {
            for column in x.saturating_sub(REACH)..=(x + REACH).min(width - 1) {
                let own = match row.abs_diff(y).max(column.abs_diff(x)) {
                    0 => 0.0,
                    1 => 2.0,
                    _ => 1.0,
                };
                sum += own * noise[row as usize * width as usize + column as usize];
                weight += own;
            }
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }

    /// The run that brings a pixel from the samples that it has to its share.
    fn own_run(&self, pixel: u64, taken: u64, share: f64) -> Goal {
        let more = share - taken as f64;
        let block = power_of_two((more / OWN as f64) as u64).min(self.largest_block);
        // rounded up or down by chance, so that the mean stays; a single block would not tell its variance
        let [chance, _] = SampleStream::new(ROUNDING, pixel, self.even).pair(0);
        let blocks = match more / block as f64 {
            few if few < 2.0 => 2 * u64::from(2.0 * f64::from(chance) < few),
            many => (many + f64::from(chance)) as u64,
        };
        Goal {
            first: taken,
            block,
            end: taken + blocks * block,
        }
    }
}

impl Goal {
    /// The goal of a step of a run.
    fn cut(&self, step: u64, of: u64) -> Self {
        let blocks = (self.end - self.first) / self.block;
        Self {
            end: self.first + blocks * step / of * self.block,
            ..*self
        }
    }
}

/// Seed of the chance that rounds numbers of blocks.
const ROUNDING: u64 = 0x726f_756e_6469_6e67;

/// The largest power of two up to a number; 1 below it.
fn power_of_two(number: u64) -> u64 {
    1 << number.max(1).ilog2()
}

/// Numbers in proportion to `wanted`, but at least `least` and at most [`CAP`] times their mean, which is `mean`.
fn fill(wanted: &[f64], least: f64, mean: f64) -> Vec<f64> {
    let cap = (CAP * mean).max(least);
    // what is not known asks for nothing
    let known = |w: f64| if w.is_finite() { w } else { 0.0 };
    let share = |factor: f64| move |w: &f64| (factor * known(*w)).clamp(least, cap);
    let all = mean * wanted.len() as f64;
    let sum = |factor: f64| wanted.iter().map(share(factor)).sum::<f64>();
    let asked: f64 = wanted.iter().map(|w| known(*w)).sum();
    let mut factor = 0.0;
    if asked > 0.0 {
        // the sum grows with the factor, from `least` of each to `cap` of those that want anything
        let (mut low, mut high) = (0.0, all / asked);
        for _ in 0..200 {
            if sum(high) >= all {
                break;
            }
            low = high;
            high *= 2.0;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sum(middle) < all {
                low = middle;
            } else {
                high = middle;
            }
        }
        factor = low;
    }
    let rest = (all - sum(factor)).max(0.0) / wanted.len() as f64;
    wanted.iter().map(share(factor)).map(|n| n + rest).collect()
}

#[cfg(test)]
#[path = "spread_tests.rs"]
mod tests;
