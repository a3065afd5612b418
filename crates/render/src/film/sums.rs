//! Sums over the samples of each pixel of a tile.
//!
//! Samples come in blocks, which are independent of each other; those within one are stratified together. A run is
//! blocks of one size, one after the other: the differences between them tell the variance of their sum. A pixel may
//! have several runs; what they sum to is added, and so are the variances.

use super::SampleSums;
use crate::path::witness::CoherenceSums;

/// Pairs of components whose products are summed, beside the squares.
const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The four components of complete blocks, those of the block that is open, and the squares of complete blocks.
pub(super) type Sums = [f64; 12];

/// One product of blocks for each of [`PAIRS`].
pub(super) type Products = [f64; 6];

/// Blocks of equal size, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Samples of the pixel before it.
    pub first: u64,
    /// Samples a block: a power of two.
    pub block: u64,
    /// Its samples.
    pub samples: u64,
}

impl Run {
    /// Complete blocks.
    pub fn blocks(self) -> u64 {
        self.samples / self.block
    }

    /// Variance of the sum of a value over its samples, from sums over complete blocks of it and of its square; `None` if
    /// unknown.
    ///
    /// `size` is the sum of the sizes of the terms of `squares`: differences within their rounding are none.
    fn variance(self, sum: f64, squares: f64, size: f64) -> Option<f64> {
        if self.samples == 0 {
            return Some(0.0);
        }
        let n = self.blocks() as f64;
        if n < 2.0 {
            return None;
        }
        let mean = sum / n;
        let spread = squares / n - mean * mean;
        // a square, its weight and up to six products, the mean and its square round; sums of n grow as √n at worst
        let rounding = 16.0 * f64::EPSILON * n.sqrt() * size / n;
        if spread <= rounding {
            return Some(0.0);
        }
        Some(spread * n / (n - 1.0) * (self.samples as f64 / self.block as f64))
    }
}

/// What the runs before the last have left, of one pixel and colour.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Past {
    sums: [f64; 4],
    /// Of these sums.
    variances: [f64; 4],
    /// The same for [`PAIRS`].
    covariances: Products,
}

/// Sums over the samples of the pixels of a tile.
#[derive(Clone, Debug)]
pub struct TileSums {
    corner: [u32; 2],
    size: [u32; 2],
    colours: usize,
    /// The run of each pixel that is in progress.
    runs: Vec<Run>,
    /// Complete blocks of the runs before it; empty while no pixel has one.
    past_blocks: Vec<u64>,
    /// For each pixel and colour; empty likewise.
    past: Vec<Past>,
    /// For each pixel and colour, over the run in progress.
    sums: Vec<Sums>,
    /// The same; empty if nobody asks for weighted sums.
    products: Vec<Products>,
    /// For each pixel; empty if nobody asks for coherence.
    coherence: Vec<CoherenceSums>,
}

/// The sums of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelSums<'a> {
    run: Run,
    past_blocks: u64,
    /// For each colour, or empty.
    past: &'a [Past],
    /// For each colour.
    sums: &'a [Sums],
    /// The same, or empty.
    products: &'a [Products],
}

/// So many zeros that have been written: memory that is only promised, as `vec!` has it, interrupts all threads when the
/// first of them writes there.
fn written<T: Copy>(zeros: T, count: usize) -> Vec<T> {
    std::iter::repeat_n(zeros, count).collect()
}

impl TileSums {
    pub(super) fn new(
        corner: [u32; 2],
        size: [u32; 2],
        (colours, products, coherence): (usize, bool, bool),
    ) -> Self {
        let pixels = (size[0] * size[1]) as usize;
        let none = Run {
            first: 0,
            block: 1,
            samples: 0,
        };
        Self {
            corner,
            size,
            colours,
            runs: vec![none; pixels],
            past_blocks: Vec::new(),
            past: Vec::new(),
            sums: written([0.0; 12], pixels * colours),
            products: written([0.0; 6], pixels * colours * usize::from(products)),
            coherence: vec![CoherenceSums::default(); pixels * usize::from(coherence)],
        }
    }

    /// Its pixels in the crop window.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let ([x, y], [width, height]) = (self.corner, self.size);
        (y..y + height).flat_map(move |row| (x..x + width).map(move |column| (column, row)))
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        ((y - self.corner[1]) * self.size[0] + (x - self.corner[0])) as usize
    }

    /// Samples that a pixel has so far.
    #[inline]
    pub fn taken(&self, x: u32, y: u32) -> u64 {
        let run = self.runs[self.index(x, y)];
        run.first + run.samples
    }

    /// Has a pixel go on with the run of blocks of `block` that begins after `first` samples, or begin it.
    pub fn go_on(&mut self, x: u32, y: u32, first: u64, block: u64) {
        let pixel = self.index(x, y);
        let run = self.runs[pixel];
        if (run.first, run.block) == (first, block) {
            return;
        }
        if run.samples > 0 {
            self.end_run(x, y);
        }
        self.runs[pixel] = Run {
            first,
            block,
            samples: 0,
        };
    }

    fn end_run(&mut self, x: u32, y: u32) {
        if self.past.is_empty() {
            self.past = vec![Past::default(); self.sums.len()];
            self.past_blocks = vec![0; self.runs.len()];
        }
        let pixel = self.index(x, y);
        let colours = pixel * self.colours..(pixel + 1) * self.colours;
        let sums = self.pixel(x, y);
        let past: Vec<Past> = (0..self.colours)
            .map(|colour| Past {
                sums: std::array::from_fn(|k| sums.sum(k, colour)),
                variances: std::array::from_fn(|k| sums.variance(k, colour)),
                covariances: std::array::from_fn(|k| sums.covariance(k, colour)),
            })
            .collect();
        self.past_blocks[pixel] = sums.blocks();
        self.past[colours.clone()].copy_from_slice(&past);
        self.sums[colours.clone()].fill([0.0; 12]);
        if let Some(products) = self.products.get_mut(colours) {
            products.fill([0.0; 6]);
        }
    }

    /// Goes on with the open block of a pixel: sample after sample, however many of them come at a time.
    #[inline]
    pub fn open(&self, x: u32, y: u32, sums: &mut SampleSums) {
        let first = self.index(x, y) * self.colours;
        for (colour, sum) in sums.sums.iter_mut().enumerate() {
            sum.copy_from_slice(&self.sums[first + colour][4..8]);
        }
    }

    /// Leaves the block of a pixel open, when it has so many samples.
    #[inline]
    pub fn keep(&mut self, x: u32, y: u32, sums: &SampleSums, taken: u64) {
        let pixel = self.index(x, y);
        self.runs[pixel].samples = taken - self.runs[pixel].first;
        let first = pixel * self.colours;
        for (colour, sum) in sums.sums.iter().enumerate() {
            self.sums[first + colour][4..8].copy_from_slice(sum);
        }
    }

    /// Adds a complete block to a pixel, and empties it.
    #[inline]
    pub fn close(&mut self, x: u32, y: u32, sums: &mut SampleSums) {
        let first = self.index(x, y) * self.colours;
        for (colour, sum) in sums.sums.iter_mut().enumerate() {
            let block = std::mem::take(sum);
            let all = &mut self.sums[first + colour];
            for k in 0..4 {
                all[k] += block[k];
                all[8 + k] += block[k] * block[k];
            }
            if let Some(products) = self.products.get_mut(first + colour) {
                for (product, (a, b)) in products.iter_mut().zip(PAIRS) {
                    *product += block[a] * block[b];
                }
            }
        }
    }

    /// Adds the coherence of a sample to a pixel of a film that has room for it.
    #[inline]
    pub fn add_coherence(&mut self, x: u32, y: u32, sample: &CoherenceSums) {
        let pixel = self.index(x, y);
        if let Some(sums) = self.coherence.get_mut(pixel) {
            sums.merge(sample);
        }
    }

    /// The coherence of each pixel, where it was asked for.
    pub fn coherence(&self) -> impl Iterator<Item = ((u32, u32), &CoherenceSums)> {
        self.pixels().zip(&self.coherence)
    }

    /// The sums of a pixel of the tile.
    pub fn pixel(&self, x: u32, y: u32) -> PixelSums<'_> {
        let pixel = self.index(x, y);
        let colours = pixel * self.colours..(pixel + 1) * self.colours;
        PixelSums {
            run: self.runs[pixel],
            past_blocks: self.past_blocks.get(pixel).copied().unwrap_or_default(),
            past: self.past.get(colours.clone()).unwrap_or_default(),
            sums: &self.sums[colours.clone()],
            products: self.products.get(colours).unwrap_or_default(),
        }
    }

    /// Visits all pixels.
    pub fn for_each(&self, visit: &mut impl FnMut(u32, u32, PixelSums<'_>)) {
        for (x, y) in self.pixels() {
            visit(x, y, self.pixel(x, y));
        }
    }
}

impl PixelSums<'_> {
    /// Samples.
    pub fn samples(&self) -> u64 {
        self.run.first + self.run.samples
    }

    /// Complete blocks.
    pub fn blocks(&self) -> u64 {
        self.past_blocks + self.run.blocks()
    }

    /// Mean and variance of the mean of a component in one colour; infinite if it is unknown.
    pub fn estimate(&self, component: usize, colour: usize) -> (f64, f64) {
        let n = self.samples() as f64;
        (
            self.sum(component, colour) / n,
            self.variance(component, colour) / (n * n),
        )
    }

    /// Variance of one sample of a component, as far as those of the run in progress show it, all colours together.
    pub fn variance_in_run(&self, component: usize) -> f64 {
        let of = |s: &Sums| (self.run).variance(s[component], s[8 + component], s[8 + component]);
        let all: Option<f64> = self.sums.iter().map(of).sum();
        all.map_or(f64::INFINITY, |all| all / self.run.samples.max(1) as f64)
    }

    /// Variance of the mean of a weighted sum of the components in one colour.
    ///
    /// `None` where the film sums no products, or has fewer than two blocks.
    pub fn variance_of(&self, weights: &[f64; 4], colour: usize) -> Option<f64> {
        let products = self.products.get(colour)?;
        let sums = &self.sums[colour];
        let complete = (0..4).map(|k| weights[k] * sums[k]).sum();
        let squares = (0..4).map(|k| weights[k] * weights[k] * sums[8 + k]);
        let pairs = PAIRS.into_iter().zip(products);
        let pairs = pairs.map(|((a, b), product)| 2.0 * weights[a] * weights[b] * product);
        let (all, size) = squares.chain(pairs).fold((0.0, 0.0), |(sum, size), term| {
            (sum + term, size + term.abs())
        });
        let past = self.past.get(colour).map_or(0.0, |past| {
            let own = (0..4).map(|k| weights[k] * weights[k] * past.variances[k]);
            let pairs = PAIRS.into_iter().zip(past.covariances);
            let pairs = pairs.map(|((a, b), of)| 2.0 * weights[a] * weights[b] * of);
            own.chain(pairs).sum::<f64>().max(0.0)
        });
        let variance = self.joined(past, self.run.variance(complete, all, size));
        let n = self.samples() as f64;
        variance.is_finite().then(|| variance / (n * n))
    }

    /// Of a component in one colour over all samples.
    fn sum(&self, component: usize, colour: usize) -> f64 {
        let sums = &self.sums[colour];
        let past = self.past.get(colour).map_or(0.0, |p| p.sums[component]);
        past + sums[component] + sums[4 + component]
    }

    /// Of that sum.
    fn variance(&self, component: usize, colour: usize) -> f64 {
        let (sums, past) = (&self.sums[colour], self.past.get(colour));
        let own = (self.run).variance(sums[component], sums[8 + component], sums[8 + component]);
        self.joined(past.map_or(0.0, |p| p.variances[component]), own)
    }

    /// Of two such sums, one of [`PAIRS`]; 0 where the film sums no products.
    fn covariance(&self, pair: usize, colour: usize) -> f64 {
        let past = self.past.get(colour).map_or(0.0, |p| p.covariances[pair]);
        let Some(products) = self.products.get(colour) else {
            return 0.0;
        };
        let (sums, (a, b), n) = (&self.sums[colour], PAIRS[pair], self.run.blocks() as f64);
        let own = (n >= 2.0).then(|| {
            let spread = products[pair] / n - (sums[a] / n) * (sums[b] / n);
            spread * n / (n - 1.0) * (self.run.samples as f64 / self.run.block as f64)
        });
        self.joined(past, own)
    }

    /// The variance over all runs. A run that is too short to show its own is taken for as noisy as those before it.
    fn joined(&self, past: f64, own: Option<f64>) -> f64 {
        let (before, here) = (self.run.first as f64, self.run.samples as f64);
        match own {
            Some(own) => past + own,
            None if self.run.first > 0 => past * (1.0 + here / before),
            None => f64::INFINITY,
        }
    }
}

#[cfg(test)]
#[path = "sums_tests.rs"]
mod tests;
