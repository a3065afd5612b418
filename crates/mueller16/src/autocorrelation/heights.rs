//! Surfaces whose heights are a Gaussian process with a Gaussian correlation.

use nalgebra::Matrix2;
use stokes::plane;

use super::error::{check, check_deviation, roughness};
use super::poisson;
use super::{Autocorrelation, AutocorrelationError, GaussianFamily};
use crate::accuracy::{Approximation, Tolerance};
use crate::relief::Relief;

/// Largest `g` that is taken.
const LARGEST: f64 = 1e24;

/// Heights, zero-mean and jointly Gaussian, statistically the same everywhere.
///
/// ```text
/// ⟨h(x₁) h(x₂)⟩ = σ_h² ρ(x₁ − x₂)       ρ(x) = e^(−xᵀ (DᵀD)⁻¹ x/2);  isotropic e^(−|x|²/l²), D = l/√2
/// R = e^(−g(1−ρ)) = e^(−g) + Σ_(m≥1) e^(−g) g^m/m! ρ^m                  g = (φ_z σ_h)²
/// ```
///
/// The first part of R does not decay: it is the mirror. The rest is one family of Gaussians with the root D: a Gauss rule
/// for the Poisson weights, the Poisson sum itself where the rule would need more than 24 nodes, or the Gaussian of rate
/// g once `2/g` is below half of the tolerance. That last one is Beckmann's lobe, of slopes with the variance
/// `2 σ_h²/l²` along each axis: its own error is `1/g` at the peak, and in the tails `t²/(2g)` of the value there,
/// t the exponent of the Gaussian.
///
/// Accuracy: the error of the diffuse lobe over its largest value is at most half of the tolerance, for a plane wave and
/// for incoherent sources of any shape ([`Approximation::error`] is the bound, at most some 30 times the error). `R(0) = 1`
/// to rounding. In the tails of a lobe, where it is small beside its peak, the relative error is larger.
///
/// Source: Beckmann and Spizzichino 1963, The Scattering of Electromagnetic Waves from Rough Surfaces, chapter 5.
///
/// ```
/// use mueller16::{GaussianHeights, Relief, Tolerance};
/// // heights of 50 nm, 5 µm apart, green light at normal incidence
/// let steel = GaussianHeights::isotropic(50e-9, 5e-6)?;
/// let phi_z = 4.0 * std::f64::consts::PI / 550e-9;
/// let (r, chosen) = steel.autocorrelation(phi_z, Tolerance::relative(1e-3)?)?;
/// // e^(−g), g = 1.3051: 27 % stay in the mirror direction
/// assert!((r.delta_weight() - 0.271_153).abs() < 1e-6);
/// // four Gaussians and the mirror
/// assert_eq!(chosen.terms, 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianHeights {
    deviation: f64,
    /// The root D, checked; no terms.
    correlation: GaussianFamily,
}

impl GaussianHeights {
    /// Heights of standard `deviation` σ_h with the correlation `e^(−|x|²/length²)`; both in metres.
    ///
    /// # Errors
    ///
    /// When the deviation is not between 0 and 1e24 m, or the length not between 1.5e-30 and 1e30 m.
    pub fn isotropic(deviation: f64, length: f64) -> Result<Self, AutocorrelationError> {
        let root = Matrix2::from_diagonal_element(length * std::f64::consts::FRAC_1_SQRT_2);
        Self::new(deviation, &root)
    }

    /// Heights of standard `deviation` σ_h, m, with the correlation `e^(−xᵀ (DᵀD)⁻¹ x/2)`; `root` is D, 2×2, m.
    ///
    /// # Errors
    ///
    /// When the deviation is not between 0 and 1e24 m, or the root as [`GaussianFamily::new`] says.
    pub fn new(deviation: f64, root: &Matrix2<f64>) -> Result<Self, AutocorrelationError> {
        check_deviation(deviation)?;
        let correlation = GaussianFamily::new(root, [])?;
        Ok(Self {
            deviation,
            correlation,
        })
    }

    /// σ_h, m.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// D, 2×2, m.
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        self.correlation.root()
    }

    /// `g = (φ_z σ_h)²`, the variance of the phase; `phi_z` in rad/m.
    #[must_use]
    pub fn phase_variance(&self, phi_z: f64) -> f64 {
        (phi_z * self.deviation).powi(2)
    }
}

impl Autocorrelation {
    /// `⟨e^(iψ(x')) e^(−iψ(x'−x))⟩ = e^(−variance (1 − ρ(x)))` of a Gaussian phase ψ, `ρ = e^(−xᵀ (DᵀD)⁻¹ x/2)`.
    ///
    /// `variance` in rad²; `root` is D, 2×2, m. Accuracy as [`GaussianHeights`].
    ///
    /// # Errors
    ///
    /// When the variance is not between 0 and 1e24, or the root as [`GaussianFamily::new`] says.
    pub fn of_gaussian_phase(
        variance: f64,
        root: &Matrix2<f64>,
        tolerance: Tolerance,
    ) -> Result<(Self, Approximation), AutocorrelationError> {
        let expected = "a number between 0 and 1e24 rad²";
        check("variance of the phase", variance, 0.0..=LARGEST, expected)?;
        let shape = GaussianFamily::new(root, [])?;
        let (terms, chosen) = poisson::exponential(variance, tolerance);
        Ok((shape.with_terms(terms).into(), chosen))
    }
}

impl Relief for GaussianHeights {
    /// # Errors
    ///
    /// When g is not a number, or above 1e24.
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let g = roughness(phi_z, self.deviation, LARGEST)?;
        let (terms, chosen) = poisson::exponential(g, tolerance);
        Ok((self.correlation.with_terms(terms).into(), chosen))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        // σ² D⁻¹ D⁻ᵀ
        let inverse = plane::inverse(self.root());
        let slopes = plane::product(&inverse, &inverse.transpose());
        Some(slopes * self.deviation.powi(2))
    }
}
