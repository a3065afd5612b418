//! The film: sums of Stokes vectors per pixel, from which the image and its variance follow.
//!
//! Samples come in blocks, which are independent of each other; the samples within one are not.

use glam::Vec4;

use crate::colour::{FIRST_NM, LAST_NM, rgb_weights};
use crate::filter::Filter;
use crate::path::witness::CoherenceSums;

/// Which wavelengths an image shows, and how many colours it has.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectralMode {
    /// One wavelength, nm.
    Single(f64),
    /// Equal bands between two wavelengths in nm; each pixel holds the mean over its band.
    Bands {
        /// Lower end of the first band.
        from: f64,
        /// Upper end of the last.
        to: f64,
        /// How many.
        count: usize,
    },
    /// Linear sRGB from 360 to 830 nm.
    Rgb,
}

impl SpectralMode {
    /// First and last wavelength that paths may carry, nm.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Self::Single(wavelength) => [wavelength; 2],
            Self::Bands { from, to, .. } => [from, to],
            Self::Rgb => [FIRST_NM, LAST_NM],
        }
    }

    /// Colours of the image.
    pub fn colours(&self) -> usize {
        match self {
            Self::Single(_) => 1,
            Self::Bands { count, .. } => *count,
            Self::Rgb => 3,
        }
    }

    /// Centres of the bands, nm.
    pub fn band_centres(&self) -> Vec<f64> {
        match self {
            Self::Single(wavelength) => vec![*wavelength],
            Self::Bands { from, to, count } => (0..*count)
                .map(|i| from + (to - from) * (i as f64 + 0.5) / *count as f64)
                .collect(),
            Self::Rgb => Vec::new(),
        }
    }
}

/// Size, crop window and filter of the film.
#[derive(Clone, Debug)]
pub struct FilmGeometry {
    /// Whole film, pixels.
    pub size: [u32; 2],
    /// Top left corner of the crop window.
    pub crop_offset: [u32; 2],
    /// Size of the crop window: that of the image.
    pub crop_size: [u32; 2],
    /// Reconstruction filter.
    pub filter: Filter,
    /// Whether products of two components are summed too, so that the variance of every weighted sum of them is known.
    pub products: bool,
}

/// Edge of a tile, pixels.
const TILE: u32 = 16;

impl FilmGeometry {
    /// Memory that the sums take, bytes; with or without those of coherence.
    pub fn bytes(&self, colours: usize, coherence: bool) -> u64 {
        let pixels = u64::from(self.crop_size[0]) * u64::from(self.crop_size[1]);
        let products = usize::from(self.products) * size_of::<Products>();
        let stokes = ((size_of::<Sums>() + products) * colours) as u64;
        pixels * (stokes + u64::from(coherence) * size_of::<CoherenceSums>() as u64)
    }

    /// Empty tiles that cover the crop window, from left to right and from top to bottom.
    pub fn tiles(&self, colours: usize, coherence: bool) -> Vec<TileSums> {
        let [width, height] = self.crop_size;
        let corners = (0..height)
            .step_by(TILE as usize)
            .flat_map(|y| (0..width).step_by(TILE as usize).map(move |x| [x, y]));
        corners
            .map(|[x, y]| {
                let size = [TILE.min(width - x), TILE.min(height - y)];
                let pixels = (size[0] * size[1]) as usize;
                TileSums {
                    corner: [x, y],
                    size,
                    sums: vec![[0.0; 12]; pixels * colours],
                    products: vec![[0.0; 6]; pixels * colours * usize::from(self.products)],
                    coherence: vec![CoherenceSums::default(); pixels * usize::from(coherence)],
                }
            })
            .collect()
    }

    /// Which of the tiles holds the pixel at (x, y) of the crop window.
    pub fn tile_of(&self, x: u32, y: u32) -> usize {
        (y / TILE * self.crop_size[0].div_ceil(TILE) + x / TILE) as usize
    }
}

/// Pairs of components whose products are summed, beside the squares.
const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The four components of complete blocks, those of the block that is open, and the squares of complete blocks.
type Sums = [f64; 12];

/// One product of blocks for each of [`PAIRS`].
type Products = [f64; 6];

/// How many samples a pixel has, and in what blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// Samples.
    pub samples: u64,
    /// Samples a block.
    pub block: u64,
}

impl Count {
    /// Complete blocks.
    pub fn blocks(self) -> u64 {
        self.samples / self.block
    }

    /// Variance of the mean of a value, from sums over complete blocks of it and of its square; infinite if unknown.
    ///
    /// `size` is the sum of the sizes of the terms of `squares`: differences within their rounding are none.
    fn variance(self, sum: f64, squares: f64, size: f64) -> f64 {
        let n = self.blocks() as f64;
        if n < 2.0 {
            return f64::INFINITY;
        }
        let mean = sum / n;
        let spread = squares / n - mean * mean;
        // a square, its weight and up to six products, the mean and its square round; sums of n grow as √n at worst
        let rounding = 16.0 * f64::EPSILON * n.sqrt() * size / n;
        if spread <= rounding {
            return 0.0;
        }
        spread * n / (n - 1.0) / (self.block as f64 * self.samples as f64)
    }
}

/// Sums over the samples of the pixels of a tile.
#[derive(Clone, Debug)]
pub struct TileSums {
    corner: [u32; 2],
    size: [u32; 2],
    /// For each pixel and colour.
    sums: Vec<Sums>,
    /// The same; empty if nobody asks for weighted sums.
    products: Vec<Products>,
    /// For each pixel; empty if nobody asks for coherence.
    coherence: Vec<CoherenceSums>,
}

/// The sums of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelSums<'a> {
    /// For each colour.
    sums: &'a [Sums],
    /// The same, or empty.
    products: &'a [Products],
}

impl TileSums {
    /// Its pixels in the crop window.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let ([x, y], [width, height]) = (self.corner, self.size);
        (y..y + height).flat_map(move |row| (x..x + width).map(move |column| (column, row)))
    }

    /// Goes on with the open block of a pixel: sample after sample, however many of them come at a time.
    #[inline]
    pub fn open(&self, x: u32, y: u32, sums: &mut SampleSums) {
        let first = self.index(x, y) * sums.sums.len();
        for (colour, sum) in sums.sums.iter_mut().enumerate() {
            sum.copy_from_slice(&self.sums[first + colour][4..8]);
        }
    }

    /// Leaves the block of a pixel open.
    #[inline]
    pub fn keep(&mut self, x: u32, y: u32, sums: &SampleSums) {
        let first = self.index(x, y) * sums.sums.len();
        for (colour, sum) in sums.sums.iter().enumerate() {
            self.sums[first + colour][4..8].copy_from_slice(sum);
        }
    }

    /// Adds a complete block to a pixel, and empties it.
    #[inline]
    pub fn close(&mut self, x: u32, y: u32, sums: &mut SampleSums) {
        let first = self.index(x, y) * sums.sums.len();
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

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        ((y - self.corner[1]) * self.size[0] + (x - self.corner[0])) as usize
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
    pub fn pixel(&self, x: u32, y: u32, colours: usize) -> PixelSums<'_> {
        let first = self.index(x, y) * colours;
        PixelSums {
            sums: &self.sums[first..][..colours],
            products: self
                .products
                .get(first..first + colours)
                .unwrap_or_default(),
        }
    }

    /// Visits all pixels.
    pub fn for_each(&self, colours: usize, visit: &mut impl FnMut(u32, u32, PixelSums<'_>)) {
        for (x, y) in self.pixels() {
            visit(x, y, self.pixel(x, y, colours));
        }
    }
}

impl PixelSums<'_> {
    /// Mean and variance of the mean of a component in one colour.
    pub fn estimate(&self, component: usize, colour: usize, count: Count) -> (f64, f64) {
        let sums = &self.sums[colour];
        let all = sums[component] + sums[4 + component];
        let variance = count.variance(sums[component], sums[8 + component], sums[8 + component]);
        (all / count.samples as f64, variance)
    }

    /// Variance of the mean of a weighted sum of the components in one colour.
    ///
    /// `None` where the film sums no products, or has fewer than two blocks.
    pub fn variance_of(&self, weights: &[f64; 4], colour: usize, count: Count) -> Option<f64> {
        let products = self.products.get(colour).filter(|_| count.blocks() > 1)?;
        let sums = &self.sums[colour];
        let complete = (0..4).map(|k| weights[k] * sums[k]).sum();
        let squares = (0..4).map(|k| weights[k] * weights[k] * sums[8 + k]);
        let pairs = PAIRS.into_iter().zip(products);
        let pairs = pairs.map(|((a, b), product)| 2.0 * weights[a] * weights[b] * product);
        let (all, size) = squares.chain(pairs).fold((0.0, 0.0), |(sum, size), term| {
            (sum + term, size + term.abs())
        });
        Some(count.variance(complete, all, size))
    }
}

/// One sample's contribution to each colour, reused from sample to sample.
#[derive(Clone, Debug)]
pub struct SampleColours {
    values: Vec<Vec4>,
}

impl SampleColours {
    /// All dark, for so many colours.
    pub fn new(colours: usize) -> Self {
        Self {
            values: vec![Vec4::ZERO; colours],
        }
    }

    /// Starts a sample.
    #[inline]
    pub fn clear(&mut self) {
        self.values.fill(Vec4::ZERO);
    }

    /// Adds a Stokes vector to one colour.
    #[inline]
    pub fn add(&mut self, colour: usize, stokes: Vec4) {
        self.values[colour] += stokes;
    }

    /// Adds a Stokes vector at a wavelength in nm to linear sRGB, times `weight` nm.
    #[inline]
    pub fn add_spectral(&mut self, stokes: Vec4, wavelength: f32, weight: f32) {
        let response = rgb_weights(wavelength);
        for (value, r) in self.values.iter_mut().zip(response) {
            *value += stokes * (r * weight);
        }
    }

    /// The Stokes vector of each colour.
    pub fn values(&self) -> &[Vec4] {
        &self.values
    }
}

/// Sums over the samples of the open block of a pixel.
#[derive(Clone, Debug)]
pub struct SampleSums {
    sums: Vec<[f64; 4]>,
}

impl SampleSums {
    /// Nothing yet, for so many colours.
    pub fn new(colours: usize) -> Self {
        Self {
            sums: vec![[0.0; 4]; colours],
        }
    }

    /// Adds a sample. One that is not finite is left out whole: the answer is false.
    #[inline]
    pub fn add(&mut self, sample: &SampleColours) -> bool {
        if !sample.values.iter().all(|v| v.is_finite()) {
            return false;
        }
        for (sums, value) in self.sums.iter_mut().zip(&sample.values) {
            for (sum, value) in sums.iter_mut().zip(value.to_array()) {
                *sum += f64::from(value);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec4;

    fn film(products: bool) -> FilmGeometry {
        FilmGeometry {
            size: [40, 40],
            crop_offset: [0, 0],
            crop_size: [37, 21],
            filter: Filter::Box,
            products,
        }
    }

    #[test]
    fn the_tile_of_a_pixel_is_found() {
        let film = film(true);
        let tiles = film.tiles(3, false);
        for (index, tile) in tiles.iter().enumerate() {
            assert!(tile.pixels().all(|(x, y)| film.tile_of(x, y) == index));
        }
    }

    /// Adds a sample, in the second of two colours, as a pass of its own.
    fn add(tile: &mut TileSums, x: u32, y: u32, sample: Vec4, complete: bool) {
        let mut colours = SampleColours::new(2);
        colours.add(0, Vec4::ONE);
        colours.add(1, sample);
        let mut sums = SampleSums::new(2);
        tile.open(x, y, &mut sums);
        assert!(sums.add(&colours));
        if complete {
            tile.close(x, y, &mut sums);
        }
        tile.keep(x, y, &sums);
    }

    #[test]
    fn the_variance_of_a_sum_of_components_is_that_of_the_summed_blocks() {
        let film = film(true);
        let mut tile = film.tiles(2, false).swap_remove(film.tile_of(36, 20));
        // three blocks of two samples, and one that is not complete
        let samples = [
            vec4(1.0, 0.5, -0.25, 0.125),
            vec4(3.0, -1.0, 0.5, 2.0),
            vec4(0.5, 0.5, 0.0, 0.0),
            vec4(2.5, 0.0, 1.0, -1.0),
            vec4(4.0, -2.0, 0.5, 0.25),
            vec4(0.125, 0.0, 0.0, 0.0),
            vec4(7.0, 1.0, 1.0, 1.0),
        ];
        for (k, sample) in samples.into_iter().enumerate() {
            add(&mut tile, 36, 20, sample, k % 2 == 1);
        }
        let count = Count {
            samples: 7,
            block: 2,
        };
        let pixel = tile.pixel(36, 20, 2);
        let variance = |weights: [f64; 4]| {
            let value = |s: Vec4| (0..4).map(|k| weights[k] * f64::from(s[k])).sum::<f64>();
            let blocks: Vec<f64> = samples[..6]
                .chunks(2)
                .map(|b| 0.5 * (value(b[0]) + value(b[1])))
                .collect();
            let mean = blocks.iter().sum::<f64>() / 3.0;
            // of a block's mean; that of the mean of all falls as the number of samples
            let of_one = blocks.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / 2.0;
            of_one * 2.0 / 7.0
        };
        let weights = [0.5, -0.25, 2.0, 1.0];
        let (found, expected) = (pixel.variance_of(&weights, 1, count), variance(weights));
        assert!(found.is_some_and(|f| (f / expected - 1.0).abs() < 1e-12));
        assert_eq!(pixel.variance_of(&weights, 0, count), Some(0.0));
        // one component alone: the mean and the variance that the image has
        let (mean, alone) = pixel.estimate(1, 1, count);
        let expected = samples.iter().map(|s| f64::from(s.y)).sum::<f64>() / 7.0;
        assert!((mean - expected).abs() < 1e-15);
        assert!((alone / variance([0.0, 1.0, 0.0, 0.0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_block_tells_no_variance_and_neither_does_a_film_without_products() {
        let mut tiles = film(false).tiles(2, false);
        for _ in 0..3 {
            add(&mut tiles[0], 0, 0, Vec4::ONE, false);
        }
        let pixel = tiles[0].pixel(0, 0, 2);
        let count = |block| Count { samples: 3, block };
        assert_eq!(pixel.estimate(0, 1, count(2)), (1.0, f64::INFINITY));
        assert_eq!(pixel.variance_of(&[1.0; 4], 0, count(1)), None);
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut colours = SampleColours::new(1);
        colours.add(0, vec4(1.0, f32::NAN, 0.0, 0.0));
        let mut sums = SampleSums::new(1);
        assert!(!sums.add(&colours));
        assert_eq!(sums.sums, [[0.0; 4]]);
    }
}
