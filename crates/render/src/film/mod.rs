//! The film: sums of Stokes vectors per pixel, from which the image and its variance follow.
//!
//! `sums.rs` keeps them, here are the film's size and a sample on its way there.

mod sums;

use glam::Vec4;
use rayon::prelude::*;
pub use sums::{PixelSums, Run, TileSums};

use crate::colour::{FIRST_NM, LAST_NM, grey_weights, rgb_weights};
use crate::filter::Filter;
use crate::path::witness::CoherenceSums;
use sums::{Past, Products, Sums};

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
    /// Memory that the sums take, bytes; with or without those of coherence, and of pixels with different numbers of
    /// samples.
    pub fn bytes(&self, colours: usize, coherence: bool, adaptive: bool) -> u64 {
        let products = usize::from(self.products) * size_of::<Products>();
        let past = usize::from(adaptive) * size_of::<Past>();
        let stokes = (size_of::<Sums>() + products + past) * colours;
        let coherence = usize::from(coherence) * size_of::<CoherenceSums>();
        self.pixels() * (stokes + coherence + size_of::<Run>()) as u64
    }

    /// Pixels of the crop window.
    pub fn pixels(&self) -> u64 {
        u64::from(self.crop_size[0]) * u64::from(self.crop_size[1])
    }

    /// Empty tiles that cover the crop window, from left to right and from top to bottom.
    pub fn tiles(&self, colours: usize, coherence: bool) -> Vec<TileSums> {
        let [width, height] = self.crop_size;
        let columns = width.div_ceil(TILE);
        (0..columns * height.div_ceil(TILE))
            .into_par_iter()
            .map(|tile| {
                let [x, y] = [tile % columns * TILE, tile / columns * TILE];
                let size = [TILE.min(width - x), TILE.min(height - y)];
                TileSums::new([x, y], size, (colours, self.products, coherence))
            })
            .collect()
    }

    /// Which of the tiles holds the pixel at (x, y) of the crop window.
    pub fn tile_of(&self, x: u32, y: u32) -> usize {
        (y / TILE * self.crop_size[0].div_ceil(TILE) + x / TILE) as usize
    }
}

/// What some samples contribute to each colour: room that is used again and again.
#[derive(Clone, Debug)]
pub struct Colours {
    count: usize,
    /// Sample by sample.
    values: Vec<Vec4>,
    /// Linear sRGB of a spectrum of constant value 1.
    grey: [f32; 3],
}

impl Colours {
    /// All dark: so many colours of so many samples.
    pub fn new(count: usize, samples: usize) -> Self {
        Self {
            count,
            values: vec![Vec4::ZERO; count * samples],
            grey: grey_weights(),
        }
    }

    /// Darkens the first samples.
    #[inline]
    pub fn clear(&mut self, samples: usize) {
        match &mut self.values[..self.count * samples] {
            // without a call
            [one] => *one = Vec4::ZERO,
            all => all.fill(Vec4::ZERO),
        }
    }

    /// One of the samples, to be added to.
    #[inline]
    pub fn sample(&mut self, sample: usize) -> SampleColours<'_> {
        SampleColours {
            values: &mut self.values[sample * self.count..][..self.count],
            grey: &self.grey,
        }
    }

    /// The Stokes vectors of a sample, one for each colour.
    #[inline]
    pub fn values(&self, sample: usize) -> &[Vec4] {
        &self.values[sample * self.count..][..self.count]
    }
}

/// What one sample contributes to each colour.
#[derive(Debug)]
pub struct SampleColours<'a> {
    values: &'a mut [Vec4],
    grey: &'a [f32; 3],
}

impl SampleColours<'_> {
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

    /// Adds a Stokes vector that is the same at all wavelengths to linear sRGB.
    #[inline]
    pub fn add_grey(&mut self, stokes: Vec4) {
        for (value, w) in self.values.iter_mut().zip(self.grey) {
            *value += stokes * *w;
        }
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

    /// Adds a sample, a Stokes vector for each colour. One that is not finite is left out whole: the answer is false.
    #[inline]
    pub fn add(&mut self, sample: &[Vec4]) -> bool {
        if !sample.iter().all(|v| v.is_finite()) {
            return false;
        }
        for (sums, value) in self.sums.iter_mut().zip(sample) {
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

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut sums = SampleSums::new(1);
        assert!(!sums.add(&[vec4(1.0, f32::NAN, 0.0, 0.0)]));
        assert_eq!(sums.sums, [[0.0; 4]]);
    }
}
