//! The parameters of random heights, and what is made of them once: lobes, roots, slopes.

use mueller16::{
    AutocorrelationError, ExponentialHeights, GaussianHeights, KCorrelatedHeights, KCorrelation,
    Relief,
};
use nalgebra::Matrix2;

use super::super::microfacet::{Kind, Microfacets};
use super::lobe::Lobes;
use crate::scene::{Object, SceneError};

/// Largest phase variance in a table of Gaussian heights: beyond it the lobe is one Gaussian.
const ROUGH: f64 = 8e3;
/// The same for other correlations, whose tables are dearer; beyond it the lobe grows without change of shape.
const LONG_TAILED: f64 = 1e3;
/// Largest wave vector that their tables are made for, rad/m: a mirror of index 2 at 100 nm.
const SHORT_WAVES: f64 = 2.6e8;

/// Random heights.
#[derive(Clone, Debug)]
pub(super) struct Heights {
    pub(super) lobes: Lobes,
    /// Standard deviation, nm.
    pub(super) deviation: f32,
    /// Root D of the correlation, nm.
    pub(super) root: f32,
    /// Shadowing of the slopes, if there are slopes.
    pub(super) slopes: Option<Microfacets>,
    /// Shape of the facet distribution from which directions are drawn.
    pub(super) tail: Kind,
}

impl Heights {
    /// Reads `height`, `length`, `correlation` and `exponent`.
    pub(super) fn read(object: &Object) -> Result<Self, SceneError> {
        let length = |name: &str| {
            let value = object.micro_length(name, None)?.ok_or_else(|| {
                object.error(format!(
                    "{} has no parameter '{name}', expected a length such as '200nm'",
                    object.describe()
                ))
            })?;
            if (1e-15..=1.0).contains(&value) {
                Ok(value)
            } else {
                Err(object.error_at(
                    name,
                    format!(
                        "length '{name}' of {} is {value} m, expected one between 1e-15 m and 1 m",
                        object.describe()
                    ),
                ))
            }
        };
        let (sigma, l) = (length("height")?, length("length")?);
        let long_tailed = (sigma * SHORT_WAVES).powi(2).clamp(1.0, LONG_TAILED);
        let correlation =
            object.choice("correlation", "gaussian", &["gaussian", "exponential", "k"])?;
        let unusable = |name: &'static str| move |e: AutocorrelationError| object.error_at(name, e);
        let isotropic = Matrix2::from_diagonal_element(l);
        let heights = match correlation.as_str() {
            "exponential" => {
                let relief =
                    ExponentialHeights::new(sigma, &isotropic).map_err(unusable("length"))?;
                Self::new(&relief, sigma, l, (Kind::Ggx, long_tailed))
            }
            "k" => {
                let exponent = object.float("exponent", 2.5)?;
                let correlation =
                    KCorrelation::new(&isotropic, exponent).map_err(unusable("exponent"))?;
                let relief =
                    KCorrelatedHeights::new(sigma, correlation).map_err(unusable("height"))?;
                Self::new(&relief, sigma, l, (Kind::Ggx, long_tailed))
            }
            _ => {
                let relief = GaussianHeights::isotropic(sigma, l).map_err(unusable("length"))?;
                let root = l * std::f64::consts::FRAC_1_SQRT_2;
                Self::new(&relief, sigma, root, (Kind::Beckmann, ROUGH))
            }
        };
        let (heights, slope) = heights.map_err(|e| object.error(e))?;
        if slope > 0.5 {
            object.notice_at(
                "height",
                format!(
                    "slopes of {slope:.2} (root mean square): light that meets such a surface twice is lost, \
                     expected slopes below 0.5"
                ),
            );
        }
        Ok(heights)
    }

    /// The tables, and the root mean square slope along an axis.
    fn new(
        relief: &impl Relief,
        sigma: f64,
        root: f64,
        (tail, largest): (Kind, f64),
    ) -> Result<(Self, f64), AutocorrelationError> {
        let slope = relief.slope_covariance().map(|c| c.m11.sqrt());
        let heights = Self {
            lobes: Lobes::new(relief, sigma, largest)?,
            // single precision: g keeps 1e-7, as the wavelength does
            deviation: (sigma * 1e9) as f32,
            root: (root * 1e9) as f32,
            slopes: slope.map(|slope| {
                let alpha = (std::f64::consts::SQRT_2 * slope).max(1e-4) as f32;
                Microfacets::new(Kind::Beckmann, alpha, alpha)
            }),
            tail,
        };
        Ok((heights, slope.unwrap_or(0.0)))
    }
}
