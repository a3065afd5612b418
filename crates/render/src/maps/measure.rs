//! What the maps draw: one Stokes vector per pixel, which pixels are too dark, and what noise does to degrees.

use stokes::StokesVector;

use crate::image::{Colour, StokesImage};
use crate::output::{ImageError, display};

/// Degrees of polarization up to this much above 1 are round-off of 32-bit files.
const ROUND_OFF: f64 = 1e-5;

/// Which colours of a pixel make its Stokes vector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ColourChoice {
    /// All of them, weighted as the eye weights them.
    #[default]
    Luminance,
    /// One: 0, 1, 2 for red, green, blue, or the number of a band.
    Index(usize),
}

impl std::str::FromStr for ColourChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text.to_lowercase().as_str() {
            "luminance" => Self::Luminance,
            "r" => Self::Index(0),
            "g" => Self::Index(1),
            "b" => Self::Index(2),
            other => {
                Self::Index(other.parse().map_err(|_| {
                    "expected luminance, r, g, b or the number of a band".to_owned()
                })?)
            }
        })
    }
}

/// Stokes vectors of an image in one colour, with what is known about their trustworthiness.
#[derive(Debug, Clone)]
pub(super) struct Measured {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Row by row.
    pub(super) stokes: Vec<StokesVector>,
    /// Standard errors of S0 to S3, where the image has variances.
    pub(super) errors: Option<Vec<[f64; 4]>>,
    /// True where S0 is below the threshold or a component is not finite.
    pub(super) masked: Vec<bool>,
    /// The threshold on S0.
    pub(super) threshold: f64,
    /// In words, where the image has several colours.
    pub(super) colour: String,
}

/// Shares and moments that legends and the side-car state.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Statistics {
    /// Share of pixels that are masked.
    pub masked_share: f64,
    /// Share of the other pixels whose degree of polarization exceeds 1 by more than round-off (1e-5).
    pub dop_above_one_share: f64,
    /// Greatest degree of polarization of the other pixels.
    pub greatest_dop: f64,
    /// Median over the other pixels of the degree that noise alone gives to unpolarized light,
    /// √(σ1² + σ2² + σ3²)/S0; absent where the image has no variances.
    pub dop_of_noise: Option<f64>,
}

impl Measured {
    /// Takes one colour of an image and masks what is darker than `relative` times its mean S0.
    pub(super) fn new(
        image: &StokesImage,
        choice: ColourChoice,
        relative: f64,
    ) -> Result<Self, ImageError> {
        if let Some(problem) = image.inconsistency() {
            return Err(ImageError::Request(problem));
        }
        if !(relative.is_finite() && relative >= 0.0) {
            return Err(ImageError::Request(format!(
                "the threshold is {relative}, expected a number from 0 upwards"
            )));
        }
        let weights = weights(&image.colour, choice)?;
        let pixels = || (0..image.width * image.height).map(|i| (i % image.width, i / image.width));
        let stokes: Vec<StokesVector> = pixels()
            .map(|(x, y)| {
                let [s0, s1, s2, s3] = weighted(&weights, |colour| image.stokes_at(x, y, colour));
                StokesVector::new(s0, s1, s2, s3)
            })
            .collect();
        let errors = image.variance.is_some().then(|| {
            // colours of a pixel come from the same paths: their errors may add up, at worst
            let error = |x, y, c| {
                image
                    .variance_at(x, y, c)
                    .unwrap_or_default()
                    .map(|v| v.max(0.0).sqrt())
            };
            pixels()
                .map(|(x, y)| weighted(&weights, |colour| error(x, y, colour)))
                .collect()
        });
        let finite = stokes
            .iter()
            .map(StokesVector::s0)
            .filter(|s| s.is_finite());
        let (count, sum) = finite.fold((0_usize, 0.0), |(n, sum), s| (n + 1, sum + s));
        let threshold = relative * (sum / count.max(1) as f64).max(0.0);
        let dark = |s: &StokesVector| {
            !(s.s0() > 0.0 && s.s0() >= threshold && s.to_array().iter().all(|v| v.is_finite()))
        };
        Ok(Self {
            width: image.width,
            height: image.height,
            masked: stokes.iter().map(dark).collect(),
            stokes,
            errors,
            threshold,
            colour: colour_name(&image.colour, choice),
        })
    }

    /// Stokes vectors of the pixels that are not masked, with their index.
    pub(super) fn bright(&self) -> impl Iterator<Item = (usize, &StokesVector)> {
        self.stokes
            .iter()
            .enumerate()
            .filter(|(i, _)| !self.masked[*i])
    }

    /// Root mean square noise of the components `from..4` of a pixel; 0 where unknown.
    pub(super) fn noise(&self, pixel: usize, components: std::ops::Range<usize>) -> f64 {
        self.errors.as_ref().map_or(0.0, |errors| {
            errors[pixel][components]
                .iter()
                .map(|e| e * e)
                .sum::<f64>()
                .sqrt()
        })
    }

    pub(super) fn statistics(&self) -> Statistics {
        let dop: Vec<f64> = self
            .bright()
            .map(|(_, s)| s.degree_of_polarization())
            .collect();
        let n = dop.len().max(1) as f64;
        let noise = self.errors.as_ref().map(|_| {
            self.bright()
                .map(|(i, s)| self.noise(i, 1..4) / s.s0())
                .collect()
        });
        Statistics {
            masked_share: 1.0 - dop.len() as f64 / self.stokes.len() as f64,
            dop_above_one_share: dop.iter().filter(|&&d| d > 1.0 + ROUND_OFF).count() as f64 / n,
            greatest_dop: dop.iter().copied().fold(0.0, f64::max),
            dop_of_noise: noise.and_then(|noise: Vec<f64>| percentile(noise, 0.5)),
        }
    }
}

fn weights(colour: &Colour, choice: ColourChoice) -> Result<Vec<f64>, ImageError> {
    match choice {
        ColourChoice::Luminance => Ok(display::luminance_weights(colour)),
        ColourChoice::Index(index) if index < colour.count() => Ok((0..colour.count())
            .map(|i| f64::from(u8::from(i == index)))
            .collect()),
        ColourChoice::Index(index) => Err(ImageError::Request(format!(
            "colour {index} was asked for, the image has {} (0 to {}); give --colour luminance or a smaller number",
            colour.count(),
            colour.count() - 1
        ))),
    }
}

fn colour_name(colour: &Colour, choice: ColourChoice) -> String {
    match (colour, choice) {
        (Colour::Mono { .. }, _) => colour.name(0),
        (Colour::Rgb, ColourChoice::Luminance) => "luminance of RGB".to_owned(),
        (Colour::Bands { .. }, ColourChoice::Luminance) => {
            format!("luminance of {} bands", colour.count())
        }
        (_, ColourChoice::Index(index)) => colour.name(index),
    }
}

fn weighted(weights: &[f64], of: impl Fn(usize) -> [f64; 4]) -> [f64; 4] {
    let mut out = [0.0; 4];
    for (colour, &weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        for (out, value) in out.iter_mut().zip(of(colour)) {
            *out += weight * value;
        }
    }
    out
}

/// The value below which the share `p` of finite values lies; `None` without any.
pub(super) fn percentile(values: Vec<f64>, p: f64) -> Option<f64> {
    let mut finite: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let at = ((finite.len() - 1) as f64 * p).round() as usize;
    Some(*finite.select_nth_unstable_by(at, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: &[[f32; 4]]) -> StokesImage {
        let mut image = StokesImage::new(
            pixels.len(),
            1,
            4,
            Colour::Mono {
                wavelength_nm: None,
            },
        );
        image.stokes = pixels.as_flattened().to_vec();
        image
    }

    #[test]
    fn the_share_above_one_is_counted_among_bright_pixels() {
        let image = image(&[
            [1.0, 1.0, 0.0, 0.0],
            [1.0, 0.9, 0.9, 0.0],
            [1.0, 0.0, 0.0, 0.5],
            [1e-4, 1.0, 0.0, 0.0],
            [0.0; 4],
        ]);
        let found = Measured::new(&image, ColourChoice::Luminance, 0.01)
            .unwrap()
            .statistics();
        assert!((found.masked_share - 0.4).abs() < 1e-12);
        assert!((found.dop_above_one_share - 1.0 / 3.0).abs() < 1e-12);
        assert!((found.greatest_dop - 0.9 * 2f64.sqrt()).abs() < 1e-6);
        assert_eq!(found.dop_of_noise, None);
    }

    #[test]
    fn black_and_broken_pixels_are_always_masked() {
        let image = image(&[
            [0.0; 4],
            [f32::NAN, 0.0, 0.0, 0.0],
            [1.0, f32::INFINITY, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
        ]);
        let measured = Measured::new(&image, ColourChoice::Luminance, 0.0).unwrap();
        assert_eq!(measured.masked, [true, true, true, false]);
    }

    #[test]
    fn noise_of_unpolarized_light_is_stated() {
        let mut image = image(&[[2.0, 0.0, 0.0, 0.0]]);
        image.variance = Some(vec![9.0, 0.01, 0.02, 0.01]);
        let found = Measured::new(&image, ColourChoice::Luminance, 0.01)
            .unwrap()
            .statistics();
        assert!((found.dop_of_noise.unwrap() - 0.1).abs() < 1e-7);
    }

    #[test]
    fn colours_are_chosen_by_letter_number_or_luminance() {
        let mut image = StokesImage::new(1, 1, 4, Colour::Rgb);
        image.stokes[..3].copy_from_slice(&[1.0, 2.0, 3.0]);
        let s0 = |text: &str| {
            Measured::new(&image, text.parse().unwrap(), 0.0)
                .unwrap()
                .stokes[0]
                .s0()
        };
        assert_eq!((s0("g"), s0("2")), (2.0, 3.0));
        assert!((s0("luminance") - (0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722)).abs() < 1e-12);
        assert!("x".parse::<ColourChoice>().is_err());
        let error = Measured::new(&image, ColourChoice::Index(3), 0.0)
            .unwrap_err()
            .to_string();
        assert!(error.contains("the image has 3 (0 to 2)"), "{error}");
    }
}
