//! A Stokes image in memory: pixels, their variances, and what is known about them.

use std::collections::BTreeMap;

/// What the numbers of one Stokes component stand for in a pixel.
#[derive(Debug, Clone, PartialEq)]
pub enum Colour {
    /// One number.
    Mono {
        /// Vacuum wavelength in nanometres, where one is known.
        wavelength_nm: Option<f64>,
    },
    /// Red, green, blue: linear, Rec. 709 primaries; components and colours may be negative.
    Rgb,
    /// One number per wavelength.
    Bands {
        /// Vacuum wavelengths in nanometres; NaN where unknown (a `.npy` file holds none).
        wavelengths_nm: Vec<f64>,
    },
}

impl Colour {
    /// How many numbers there are per Stokes component.
    pub fn count(&self) -> usize {
        match self {
            Self::Mono { .. } => 1,
            Self::Rgb => 3,
            Self::Bands { wavelengths_nm } => wavelengths_nm.len(),
        }
    }

    /// The name of colour `index` as a user reads it: `R`, `550 nm`, `band 3`; empty for one number without a wavelength.
    pub fn name(&self, index: usize) -> String {
        let nanometres = |nm: f64| {
            if nm.is_finite() {
                format!("{nm} nm")
            } else {
                format!("band {index}")
            }
        };
        match self {
            Self::Mono { wavelength_nm } => wavelength_nm.map_or_else(String::new, nanometres),
            Self::Rgb => ["R", "G", "B"]
                .get(index)
                .copied()
                .unwrap_or("?")
                .to_owned(),
            Self::Bands { wavelengths_nm } => {
                nanometres(wavelengths_nm.get(index).copied().unwrap_or(f64::NAN))
            }
        }
    }
}

/// An image of Stokes vectors.
///
/// Row 0 is the top row. Each pixel has its own frame: x is the image's right, y its up, the light comes towards the
/// viewer. S1 > 0 is horizontal light, S2 > 0 has its field along right-and-up, S3 > 0 turns clockwise for an observer
/// who faces the source.
#[derive(Debug, Clone, PartialEq)]
pub struct StokesImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Stokes components per pixel: 4, or 1 where only S0 was rendered.
    pub components: usize,
    /// What the numbers of a component stand for.
    pub colour: Colour,
    /// `[row][column][component][colour]`, W/(m² sr) in physical scenes. 32 bits: seven digits, as in the files.
    pub stokes: Vec<f32>,
    /// Variance of each number of `stokes` as an estimate of the converged value; same layout.
    pub variance: Option<Vec<f32>>,
    /// Coherence of each pixel's light where it first meets matter that is not specular, `[row][column]`: semi-axes of the
    /// ellipse of separations over which it is coherent, the larger first, m; angle of the larger from image right
    /// counter-clockwise, radians in `[0, π)`; degree of coherence at one separation. NaN without light.
    pub coherence: Option<Vec<[f32; 4]>>,
    /// Samples of each pixel, `[row][column]`, where they differ.
    pub samples: Option<Vec<u64>>,
    /// Free text that travels with the image in its file: scene, seed, samples, …
    pub metadata: BTreeMap<String, String>,
}

/// Metadata key of the samples a pixel, on the mean where they differ.
pub const SAMPLES: &str = "samples";

/// Metadata key of the independent blocks of samples that the variance comes from, of the pixel that has fewest.
pub const BLOCKS: &str = "blocks";

impl StokesImage {
    /// A black image without variances and metadata.
    pub fn new(width: usize, height: usize, components: usize, colour: Colour) -> Self {
        let count = width * height * components * colour.count();
        Self {
            width,
            height,
            components,
            colour,
            stokes: vec![0.0; count],
            variance: None,
            coherence: None,
            samples: None,
            metadata: BTreeMap::new(),
        }
    }

    /// Independent blocks of samples that its variance comes from, where the metadata tell; of the pixel that has fewest.
    pub fn blocks(&self) -> Option<u64> {
        self.metadata.get(BLOCKS)?.parse().ok()
    }

    /// Where the number of a component and a colour of pixel (x, y) lies in `stokes`.
    pub fn index(&self, x: usize, y: usize, component: usize, colour: usize) -> usize {
        debug_assert!(x < self.width && y < self.height && component < self.components);
        ((y * self.width + x) * self.components + component) * self.colour.count() + colour
    }

    /// One number of a pixel.
    pub fn value(&self, x: usize, y: usize, component: usize, colour: usize) -> f32 {
        self.stokes[self.index(x, y, component, colour)]
    }

    /// `[S0, S1, S2, S3]` of pixel (x, y) in one colour; S1 to S3 are 0 where only S0 was rendered.
    pub fn stokes_at(&self, x: usize, y: usize, colour: usize) -> [f64; 4] {
        self.gather(&self.stokes, x, y, colour)
    }

    /// Variances of `[S0, S1, S2, S3]` of pixel (x, y) in one colour, where the image has them.
    pub fn variance_at(&self, x: usize, y: usize, colour: usize) -> Option<[f64; 4]> {
        let variance = self.variance.as_ref()?;
        Some(self.gather(variance, x, y, colour))
    }

    /// One component and colour as a plane of `height × width` numbers.
    pub fn plane(&self, component: usize, colour: usize) -> Vec<f32> {
        self.plane_of(&self.stokes, component, colour)
    }

    /// The variance of one component and colour as a plane, where the image has variances.
    pub fn variance_plane(&self, component: usize, colour: usize) -> Option<Vec<f32>> {
        let variance = self.variance.as_ref()?;
        Some(self.plane_of(variance, component, colour))
    }

    /// What is wrong with the sizes, in words; `None` when all fit together.
    pub(crate) fn inconsistency(&self) -> Option<String> {
        let expected = self.width * self.height * self.components * self.colour.count();
        if self.width == 0 || self.height == 0 {
            return Some(format!(
                "the image is {}x{}, expected at least one pixel",
                self.width, self.height
            ));
        }
        if self.components != 1 && self.components != 4 {
            return Some(format!(
                "{} Stokes components, expected 4 or 1",
                self.components
            ));
        }
        if self.colour.count() == 0 {
            return Some("no bands, expected at least one wavelength".to_owned());
        }
        if self.stokes.len() != expected {
            return Some(format!(
                "{} numbers, expected {expected}",
                self.stokes.len()
            ));
        }
        let variances = self.variance.as_ref().map_or(expected, Vec::len);
        if variances != expected {
            return Some(format!("{variances} variances, expected {expected}"));
        }
        let (coherences, pixels) = (
            self.coherence.as_ref().map(Vec::len),
            self.width * self.height,
        );
        let samples = self.samples.as_ref().map(Vec::len);
        let wrong = |of: &str, n: Option<usize>| {
            n.filter(|&n| n != pixels)
                .map(|n| format!("{of} of {n} pixels, expected {pixels}"))
        };
        wrong("coherence", coherences).or_else(|| wrong("samples", samples))
    }

    fn gather(&self, data: &[f32], x: usize, y: usize, colour: usize) -> [f64; 4] {
        let mut out = [0.0; 4];
        for (k, value) in out.iter_mut().enumerate().take(self.components) {
            *value = f64::from(data[self.index(x, y, k, colour)]);
        }
        out
    }

    fn plane_of(&self, data: &[f32], component: usize, colour: usize) -> Vec<f32> {
        let stride = self.components * self.colour.count();
        let first = component * self.colour.count() + colour;
        data.iter().skip(first).step_by(stride).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_pixels_read_the_same_numbers() {
        let mut image = StokesImage::new(3, 2, 4, Colour::Rgb);
        for (i, value) in image.stokes.iter_mut().enumerate() {
            *value = i as f32;
        }
        assert_eq!(image.stokes_at(1, 1, 2), [50.0, 53.0, 56.0, 59.0]);
        assert_eq!(image.plane(3, 2)[4], 59.0);
        assert_eq!(image.plane(0, 0).len(), 6);
        assert_eq!(image.variance_at(0, 0, 0), None);
        assert_eq!(image.inconsistency(), None);
    }

    #[test]
    fn an_unpolarized_image_has_no_s1_to_s3() {
        let mut image = StokesImage::new(
            1,
            1,
            1,
            Colour::Mono {
                wavelength_nm: None,
            },
        );
        image.stokes[0] = 2.0;
        assert_eq!(image.stokes_at(0, 0, 0), [2.0, 0.0, 0.0, 0.0]);
    }
}
