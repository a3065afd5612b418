//! Rough surfaces whose heights have a K-correlation: `R = e^(−g(1−ρ))` with ρ a mixture of Gaussians.
//!
//! ρ is a positive mixture over rates, so R is one too: its measure is the compound Poisson law that makes g jumps on the
//! average, each drawn from the rates of ρ. The law is built by convolutions of few points ([`super::rates`]); its part
//! without jumps, `e^(−g)`, is the mirror. At large g only ρ near 0 counts: for `c = 1.5` R tends to `e^(−g|x|/l)`, above
//! `c = 2` to the Gaussian of the slopes.
//!
//! The error is measured against the exact R at every call ([`super::phase`]).

use nalgebra::Matrix2;
use stokes::plane;

use super::error::{check_deviation, roughness};
use super::k_correlation::KCorrelation;
use super::phase::{self, Diffuse, Height};
use super::rates::{Budget, Point, compound_poisson};
use super::{Autocorrelation, AutocorrelationError};
use crate::accuracy::{Approximation, Tolerance};
use crate::relief::Relief;

/// Least mean of `u²/4` over the lobe.
const FINEST: f64 = 1e-24;

/// Normally distributed heights with a K-correlation ([`KCorrelation`]): `⟨h(x') h(x' − x)⟩ = σ² ρ(x)`.
///
/// `R = e^(−g(1−ρ))` with `g = (φ_z σ)²`, by one mixture of positive Gaussians for every g up to 1e8. The reach of the
/// correlation is not used: the error is that over the lobe's largest value, for light of at most ten
/// times its angular width. It is measured at every call and stated; for
/// exponents below 1.4 and tolerances below 1e-6 it may be more than what was asked for.
///
/// Cost: some six convolutions of two mixtures for g below 1 and one more for each doubling, 0.1 ms to 1 s from small g
/// and large tolerances to large g and small ones; a program that meets many directions keeps the results by `φ_z`. For
/// the exponent 1.5, [`crate::ExponentialHeights`] takes less than a millisecond up to g = 1e4.
///
/// ```
/// use mueller16::{KCorrelatedHeights, KCorrelation, Relief, Tolerance};
/// use nalgebra::{Matrix2, Vector2};
/// let correlation = KCorrelation::new(&Matrix2::from_diagonal_element(4e-6), 2.5)?;
/// let surface = KCorrelatedHeights::new(50e-9, correlation)?;
/// // g = 1, and ρ = (1 + u) e^(−u): R = e^(−(1 − 2/e)) at one correlation length
/// let (r, chosen) = surface.autocorrelation(2e7, Tolerance::relative(1e-4)?)?;
/// assert!((r.value(&Vector2::new(4e-6, 0.0)).re - 0.767_788).abs() < 1e-4);
/// assert!(chosen.error < 1e-4);
/// // slopes of standard deviation σ/l = 0.0125
/// let slopes = surface.slope_covariance().ok_or("no slope")?;
/// assert!((slopes.m11 - 0.0125f64.powi(2)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct KCorrelatedHeights {
    deviation: f64,
    correlation: KCorrelation,
    /// ρ to rounding.
    profile: Vec<Height>,
    mean_rate: Option<f64>,
}

impl KCorrelatedHeights {
    /// Heights of standard deviation σ, m, and this correlation.
    ///
    /// # Errors
    ///
    /// When σ is not between 0 and 1e24 m.
    pub fn new(deviation: f64, correlation: KCorrelation) -> Result<Self, AutocorrelationError> {
        check_deviation(deviation)?;
        Ok(Self {
            deviation,
            correlation,
            profile: profile(&correlation),
            mean_rate: correlation.mean_rate(),
        })
    }

    /// Standard deviation of the heights, m.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Their correlation ρ.
    #[must_use]
    pub fn correlation(&self) -> &KCorrelation {
        &self.correlation
    }
}

impl Relief for KCorrelatedHeights {
    /// # Errors
    ///
    /// When g exceeds 1e8, or is so large that the lobe is made by detail finer than 1e-12 correlation lengths, which
    /// happens for exponents near 1: give the correlation an inner scale.
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let g = roughness(phi_z, self.deviation, phase::ROUGHEST)?;
        let root = self.correlation.root();
        if g == 0.0 {
            return phase::with_mirror(root, g, (vec![], 0.0));
        }
        let diffuse = Diffuse::new(g, self.profile.iter().copied());
        let tau = 0.5 * diffuse.area;
        if tau < FINEST * -(-g).exp_m1() {
            return Err(AutocorrelationError::Number {
                what: "roughness (φ_z σ)²",
                value: g,
                expected: "less, or an inner scale of the correlation: detail below 1e-12 correlation lengths makes the lobe",
            });
        }
        let share = |m: f64| diffuse.share(m);
        let mut best: Option<(Vec<Point>, f64)> = None;
        let mut asked = tolerance.get();
        for _ in 0..4 {
            let jumps = self.jumps(g, share, asked);
            let budget = Budget {
                tolerance: asked / 4.0,
                share: &share,
                end: 0.5 * diffuse.end(asked / 4.0),
                times: 1.0,
            };
            let points = compound_poisson(&jumps, g, &budget);
            let error = diffuse.error(&points);
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((points, error));
            }
            if error <= tolerance.get() {
                break;
            }
            asked = (asked / 4.0).max(1e-15);
        }
        phase::with_mirror(root, g, best.unwrap_or_default())
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        let inverse = plane::inverse(self.correlation.root());
        let scale = self.deviation * self.deviation * self.mean_rate?;
        Some(plane::product(&inverse, &inverse.transpose()) * scale)
    }
}

impl KCorrelatedHeights {
    /// The rates of ρ and their weights, cut where what is finer adds less than the tolerance to the lobe of R: at most
    /// `g` times its weight jumps reach there, and each has at most the `share` of its rate.
    fn jumps(&self, g: f64, share: impl Fn(f64) -> f64, tolerance: f64) -> Vec<Point> {
        let mut above = 0.0;
        let mixture = self.correlation.mixture_until(tolerance, |node| {
            above += node.mass;
            let below = node.rest_of_weight(&self.correlation);
            (g * below / (above + below)).min(1.0) * share(0.5 / node.t)
        });
        let terms = mixture.terms.iter();
        terms.map(|term| [term.rate, term.weight]).collect()
    }
}

/// ρ at the radii of the measurement, from its mixture down to the narrowest Gaussian.
fn profile(correlation: &KCorrelation) -> Vec<Height> {
    let exact = correlation.mixture_until(1e-14, |_| 1.0).terms;
    let at = |u2: f64| {
        let (mut rho, mut structure) = (0.0, 0.0);
        for term in &exact {
            let x = -0.5 * term.rate * u2;
            rho += term.weight * x.exp();
            structure -= term.weight * x.exp_m1();
        }
        Height { u2, rho, structure }
    };
    phase::radii().map(at).collect()
}
