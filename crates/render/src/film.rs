//! The film: sums of Stokes vectors per pixel, from which the image and its variance follow.

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
                    sums: vec![[0.0; 8]; pixels * colours],
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

/// The four components and their squares.
type Sums = [f64; 8];

/// One product for each of [`PAIRS`].
type Products = [f64; 6];

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

    /// Adds a sample to a pixel. A sample that is not finite is left out whole: the answer is false.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &SampleColours) -> bool {
        if !sample.values.iter().all(|v| v.is_finite()) {
            return false;
        }
        let first = self.index(x, y) * sample.values.len();
        let sums = &mut self.sums[first..][..sample.values.len()];
        for (sums, value) in sums.iter_mut().zip(&sample.values) {
            let value = value.to_array().map(f64::from);
            for k in 0..4 {
                sums[k] += value[k];
                sums[4 + k] += value[k] * value[k];
            }
        }
        if let Some(products) = self.products.get_mut(first..) {
            for (products, value) in products.iter_mut().zip(&sample.values) {
                let value = value.to_array().map(f64::from);
                for (product, (a, b)) in products.iter_mut().zip(PAIRS) {
                    *product += value[a] * value[b];
                }
            }
        }
        true
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
    /// Mean and variance of the mean of a component in one colour after `count` samples.
    pub fn estimate(&self, component: usize, colour: usize, count: u64) -> (f64, f64) {
        let n = count as f64;
        let mean = self.sums[colour][component] / n;
        let square = self.sums[colour][4 + component] / n;
        let variance = if count > 1 {
            ((square - mean * mean) / (n - 1.0)).max(0.0)
        } else {
            f64::INFINITY
        };
        (mean, variance)
    }

    /// Variance of the mean of a weighted sum of the components in one colour, after `count` samples.
    ///
    /// `None` where the film sums no products, or after a single sample.
    pub fn variance_of(&self, weights: &[f64; 4], colour: usize, count: u64) -> Option<f64> {
        let products = self.products.get(colour).filter(|_| count > 1)?;
        let n = count as f64;
        let at = |index: usize| self.sums[colour][index] / n;
        let covariance = |product: f64, a: usize, b: usize| product - at(a) * at(b);
        let squares = (0..4).map(|k| weights[k] * weights[k] * covariance(at(4 + k), k, k));
        let pairs = PAIRS.into_iter().zip(products);
        let pairs = pairs
            .map(|((a, b), product)| 2.0 * weights[a] * weights[b] * covariance(product / n, a, b));
        let sum: f64 = squares.chain(pairs).sum();
        Some((sum / (n - 1.0)).max(0.0))
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

    #[test]
    fn the_variance_of_a_sum_of_components_is_that_of_the_summed_samples() {
        let film = film(true);
        let mut tile = film.tiles(2, false).swap_remove(film.tile_of(36, 20));
        let samples = [
            vec4(1.0, 0.5, -0.25, 0.125),
            vec4(3.0, -1.0, 0.5, 2.0),
            vec4(0.5, 0.5, 0.0, 0.0),
        ];
        let mut colours = SampleColours::new(2);
        for sample in samples {
            colours.clear();
            colours.add(0, Vec4::ONE);
            colours.add(1, sample);
            assert!(tile.add(36, 20, &colours));
        }
        let weights = [0.5, -0.25, 2.0, 1.0];
        let sums = samples.map(|s| (0..4).map(|k| weights[k] * f64::from(s[k])).sum::<f64>());
        let mean = sums.iter().sum::<f64>() / 3.0;
        let expected = sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (3.0 * 2.0);
        let pixel = tile.pixel(36, 20, 2);
        let found = pixel.variance_of(&weights, 1, 3).unwrap();
        assert!(
            (found - expected).abs() < 1e-13 * expected,
            "{found} {expected}"
        );
        assert_eq!(pixel.variance_of(&weights, 0, 3), Some(0.0));
        // one component alone: the variance that the image has
        let alone = pixel.variance_of(&[0.0, 1.0, 0.0, 0.0], 1, 3).unwrap();
        assert!((alone - pixel.estimate(1, 1, 3).1).abs() < 1e-15);
    }

    #[test]
    fn a_film_without_products_knows_no_variance_of_sums() {
        let film = film(false);
        let tiles = film.tiles(1, false);
        assert_eq!(tiles[0].pixel(0, 0, 1).variance_of(&[1.0; 4], 0, 9), None);
    }
}
