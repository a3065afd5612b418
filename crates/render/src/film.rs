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
}

/// Edge of a tile, pixels.
const TILE: u32 = 16;

impl FilmGeometry {
    /// Memory that the sums take, bytes; with or without those of coherence.
    pub fn bytes(&self, colours: usize, coherence: bool) -> u64 {
        let pixels = u64::from(self.crop_size[0]) * u64::from(self.crop_size[1]);
        let stokes = 8 * colours as u64 * size_of::<f64>() as u64;
        pixels * (stokes + u64::from(coherence) * size_of::<CoherenceSums>() as u64)
    }

    /// Empty tiles that cover the crop window.
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
                    sums: vec![0.0; pixels * 8 * colours],
                    coherence: vec![CoherenceSums::default(); pixels * usize::from(coherence)],
                }
            })
            .collect()
    }
}

/// Sums over the samples of the pixels of a tile.
#[derive(Clone, Debug)]
pub struct TileSums {
    corner: [u32; 2],
    size: [u32; 2],
    /// For each pixel `[component][colour]`, then the squares in the same order.
    sums: Vec<f64>,
    /// For each pixel; empty if nobody asks for coherence.
    coherence: Vec<CoherenceSums>,
}

/// The sums of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelSums<'a>(&'a [f64]);

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
        let colours = sample.values.len();
        let pixel = self.index(x, y);
        let sums = &mut self.sums[pixel * 8 * colours..][..8 * colours];
        for (colour, value) in sample.values.iter().enumerate() {
            for (component, x) in value.to_array().into_iter().enumerate() {
                let x = f64::from(x);
                sums[component * colours + colour] += x;
                sums[(4 + component) * colours + colour] += x * x;
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

    /// Visits all pixels.
    pub fn for_each(&self, colours: usize, visit: &mut impl FnMut(u32, u32, PixelSums<'_>)) {
        for ((x, y), sums) in self.pixels().zip(self.sums.chunks_exact(8 * colours)) {
            visit(x, y, PixelSums(sums));
        }
    }
}

impl PixelSums<'_> {
    /// Mean and variance of the mean after `count` samples; `index` counts through `[component][colour]`.
    pub fn estimate(&self, index: usize, count: u64) -> (f64, f64) {
        let n = count as f64;
        let mean = self.0[index] / n;
        let square = self.0[self.0.len() / 2 + index] / n;
        let variance = if count > 1 {
            ((square - mean * mean) / (n - 1.0)).max(0.0)
        } else {
            f64::INFINITY
        };
        (mean, variance)
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
