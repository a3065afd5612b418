//! A Gaussian Schell-model beam and what ABCD systems, apertures and random screens make of it.
//!
//! Each element of the cross-spectral density matrix is a Gaussian of the mean `m` and the difference `d` of the two
//! points, and every first-order system keeps it one:
//!
//! ```text
//! W_ij = A_ij e^{ −mᵀΣ⁻¹m/2 − dᵀL⁻¹d/2 + i mᵀK d }        ⟨xxᵀ⟩ = Σ,  ⟨xθᵀ⟩ = ΣK/k,  ⟨θθᵀ⟩ = L⁻¹/k² + KᵀΣK/k²
//! Σ' = (A + BKᵀ/k) Σ (A + BKᵀ/k)ᵀ + B L⁻¹ Bᵀ/k²           L' = (A + BK/k) L (A + BK/k)ᵀ + B Σ⁻¹ Bᵀ/k²
//! Σ'K' = k (A + BKᵀ/k) Σ (C + DKᵀ/k)ᵀ + B L⁻¹ Dᵀ/k         A'_ij = A_ij √(|Σ|/|Σ'|)
//! ```
//!
//! Both widths are sums of positive matrices: nothing cancels at any distance, where recovering `L'` from the
//! moments would lose all digits. `W_ij(m, d) = ⟨E_i(m − d/2) E_j*(m + d/2)⟩` in `exp(+iωt)`, so that the spatial phase
//! `+K` is that of the diverging wave `e^{+ikr}`; at one point `S3 = −2 Im W_xy`.
//!
//! Source: second moments of a Gaussian Wigner function under `V → S V Sᵀ`; for one axis Shirai & Wolf (2004).

use nalgebra::{Matrix2, SymmetricEigen, Vector2};
use num_complex::Complex64;
use stokes::{StokesVector, Wavelength};

use super::{SchellError, one_point};
use crate::abcd::AstigmaticTransfer;
use crate::csdm::CrossSpectralDensity;
use crate::ensemble::{CorrelationLengths, PhaseScreen};
use crate::scale::power_of_two;

/// One Gaussian element of the cross-spectral density matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) amplitude: Complex64,
    /// Σ, m².
    pub(super) spread: Matrix2<f64>,
    /// L, m².
    pub(super) coherence: Matrix2<f64>,
    /// K, 1/m².
    pub(super) curvature: Matrix2<f64>,
}

impl Element {
    fn through(&self, system: &AstigmaticTransfer, k: f64) -> Self {
        let Self {
            spread: sigma,
            coherence: ell,
            curvature: kappa,
            ..
        } = *self;
        let AstigmaticTransfer { a, b, c, d } = *system;
        let bent = kappa.transpose() / k;
        let positions = a + b * bent;
        let slopes = c + d * bent;
        let twisted = a + b * kappa / k;
        let diverging = inverse(&ell) / k;
        let spread = positions * sigma * positions.transpose() + b * diverging * b.transpose() / k;
        let coherence =
            twisted * ell * twisted.transpose() + b * inverse(&sigma) * b.transpose() / (k * k);
        let joint = positions * sigma * slopes.transpose() * k + b * diverging * d.transpose();
        Self {
            amplitude: self.amplitude * (root_determinant(&sigma) / root_determinant(&spread)),
            spread,
            coherence,
            curvature: inverse(&spread) * joint,
        }
    }

    fn value(&self, mean: &Vector2<f64>, difference: &Vector2<f64>) -> Complex64 {
        let quadratic = |m: &Matrix2<f64>, v: &Vector2<f64>| v.dot(&(inverse(m) * v));
        let decay = quadratic(&self.spread, mean) + quadratic(&self.coherence, difference);
        let phase = mean.dot(&(self.curvature * difference));
        self.amplitude * (-0.5 * decay).exp() * Complex64::cis(phase)
    }
}

/// Inverse of a positive definite matrix, without overflow of its determinant.
fn inverse(m: &Matrix2<f64>) -> Matrix2<f64> {
    let scale = power_of_two(m.amax());
    let near_one = m / scale;
    Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / scale / near_one.determinant() / scale
}

/// Root of the determinant of a positive definite matrix, without overflow of the determinant.
fn root_determinant(m: &Matrix2<f64>) -> f64 {
    let scale = power_of_two(m.amax());
    (m / scale).determinant().sqrt() * scale
}

/// An electromagnetic Gaussian Schell-model beam in one transverse plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchellBeam {
    pub(super) wavelength: Wavelength,
    /// xx, yy, xy.
    pub(super) elements: [Element; 3],
}

impl SchellBeam {
    fn map(&self, change: impl FnMut(Element) -> Element) -> Self {
        Self {
            wavelength: self.wavelength,
            elements: self.elements.map(change),
        }
    }

    /// The beam behind an optical system.
    ///
    /// Source: second moments, `V → S V Sᵀ`; error of a few `f64::EPSILON` times the condition number of the widths.
    #[must_use]
    pub fn through(&self, system: &AstigmaticTransfer) -> Self {
        let k = self.wavelength.wavenumber().radians_per_metre();
        self.map(|element| element.through(system, k))
    }

    /// The beam behind an aperture of Gaussian amplitude transmittance `e^{−x²/w_x² − y²/w_y²}`, the same for both
    /// polarizations; widths in metres along x and y of the plane; an infinite width is no aperture.
    ///
    /// With equal widths this is what [`crate::GaussianAperture`] does as an element. One that has another width for
    /// each polarization takes light from this class of beams.
    ///
    /// # Errors
    ///
    /// When a width is not positive.
    pub fn through_aperture(&self, widths: [f64; 2]) -> Result<Self, SchellError> {
        let curb = widths.map(|w| 1.0 / (w * w));
        for (value, curb) in widths.into_iter().zip(curb) {
            if !(value > 0.0 && curb.is_finite()) {
                return Err(SchellError::Number {
                    what: "an aperture's width",
                    value,
                    expected: "a positive length",
                });
            }
        }
        let curb = Matrix2::from_diagonal(&curb.into());
        // e^{−r1²/w² − r2²/w²} = e^{−2m²/w² − d²/(2w²)}
        Ok(self.map(|element| {
            let spread = inverse(&(inverse(&element.spread) + curb * 4.0));
            Element {
                spread,
                coherence: inverse(&(inverse(&element.coherence) + curb)),
                ..element
            }
        }))
    }

    /// The beam behind a random phase screen whose correlations are taken for parabolas, `e^{−d²/l²} ≈ 1 − d²/l²`.
    ///
    /// Exact at one point. Between two points it differs from what [`PhaseScreen`] does as an element by
    /// `s_i s_j c_ij (d/l)⁴/2`, relative: little wherever a strong screen leaves coherence.
    ///
    /// Source: Shirai & Wolf 2004, J. Opt. Soc. Am. A 21, 1907.
    ///
    /// # Errors
    ///
    /// When the two phases are anticorrelated over so short a length that the parabola grows faster than the beam's own
    /// coherence decays.
    pub fn through_phase_screen(&self, screen: &PhaseScreen) -> Result<Self, SchellError> {
        let [sx, sy] = screen.deviations();
        let CorrelationLengths { xx, yy, xy } = screen.lengths();
        let pairs = [
            (sx, sx, 1.0, xx),
            (sy, sy, 1.0, yy),
            (sx, sy, screen.correlation(), xy),
        ];
        let mut screened = *self;
        for (element, (s, t, c, l)) in screened.elements.iter_mut().zip(pairs) {
            // ⟨e^{i(φ_i − φ_j)}⟩ = e^{−(s² + t²)/2 + s t c e^{−d²/l²}}
            element.amplitude *= (-0.5 * (s - t) * (s - t) - s * t * (1.0 - c)).exp();
            let washed = Matrix2::from_diagonal_element(2.0 * s * t * c / (l * l));
            let coherence = inverse(&element.coherence) + washed;
            let least = SymmetricEigen::new(coherence).eigenvalues.min();
            if least.is_nan() || least <= 0.0 {
                return Err(SchellError::Number {
                    what: "the inverse square of the cross-coherence behind the screen",
                    value: least,
                    expected: "a positive number: anticorrelated phases need a longer correlation length",
                });
            }
            element.coherence = inverse(&coherence);
        }
        Ok(screened)
    }

    /// The matrix `⟨E(r₁) E(r₂)†⟩` of the points `first` and `second` of the plane, in metres.
    ///
    /// A beam that diverges with the radius R has the phase `−k (|r₁|² − |r₂|²)/(2R)`, as fields `e^{−ikr}` in
    /// `exp(+iωt)` have it.
    #[must_use]
    pub fn cross_spectral_density(
        &self,
        first: &Vector2<f64>,
        second: &Vector2<f64>,
    ) -> CrossSpectralDensity {
        let (mean, difference) = ((first + second) * 0.5, second - first);
        let [xx, yy, xy] = self.elements.map(|e| e.value(&mean, &difference));
        let [.., xy_exchanged] = self.elements.map(|e| e.value(&mean, &-difference));
        CrossSpectralDensity(Matrix2::new(xx, xy, xy_exchanged.conj(), yy))
    }

    /// The Stokes vector at one point of the plane, in the beam's frame.
    #[must_use]
    pub fn stokes(&self, at: &Vector2<f64>) -> StokesVector {
        one_point(self.elements.map(|e| e.value(at, &Vector2::zeros())))
    }

    /// Covariances `Σ` of the elements xx, yy and xy over the plane, m².
    #[must_use]
    pub fn spreads(&self) -> [Matrix2<f64>; 3] {
        self.elements.map(|element| element.spread)
    }

    /// Matrices `L` of the elements xx, yy and xy: they fall to e^(−1/2) where `dᵀL⁻¹d = 1`; m².
    #[must_use]
    pub fn coherences(&self) -> [Matrix2<f64>; 3] {
        self.elements.map(|element| element.coherence)
    }
}

#[cfg(test)]
mod tests;
