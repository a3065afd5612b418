//! Degrees of coherence and of cross-polarization: what one measures of light at two points.
//!
//! Degrees of polarization, angles and the polarization ellipse belong to one point: they are those of
//! [`GeneralizedStokes::stokes`]. Nothing here is clamped. Light without intensity (`C0(0) ≤ 0`) has degree 0 by
//! definition, as in [`crate::StokesVector`].

use nalgebra::Vector2;
use num_complex::Complex64;

use crate::beam::GeneralizedStokes;
use crate::components::Components;
use crate::series::HermiteSeries;

impl GeneralizedStokes {
    /// The series of `C0` and its factor.
    pub(crate) fn total(&self) -> Option<(f64, &HermiteSeries)> {
        match self.components() {
            Components::Shared { modes, stokes } => Some((stokes.s0(), modes)),
            Components::Separate(series) => series[0].as_ref().map(|series| (1.0, series)),
        }
    }

    /// Spectral intensity `C0(0)`, in the unit of the light.
    ///
    /// Source: Eq. (S4.7).
    #[must_use]
    pub fn intensity(&self) -> f64 {
        self.total().map_or(0.0, |(amplitude, series)| {
            amplitude * series.value_at_zero(self.shape()) / (self.distance() * self.distance())
        })
    }

    /// Degree of coherence `γ(ξ) = C0(ξ)/C0(0)` of two points `separation` metres apart across the ray; 0 for dark
    /// light.
    ///
    /// Its modulus is the visibility of the fringes of two pinholes there, 1 at zero separation and at most 1 for
    /// light that exists; its argument is their shift. In the far field both points have the same intensity.
    ///
    /// Source: Eq. (S4.8).
    #[must_use]
    pub fn degree_of_coherence(&self, separation: &Vector2<f64>) -> Complex64 {
        match self.total() {
            Some((_, series)) if self.intensity() > 0.0 => {
                let w = self.far_field_argument(separation);
                series.value(self.shape(), &w) / series.value_at_zero(self.shape())
            }
            _ => Complex64::ZERO,
        }
    }

    /// Degree of cross-polarization `√(|C1|² + |C2|² + |C3|²)/|C0|` of two points `separation` metres apart.
    ///
    /// Real, the same in every frame, and what correlations of intensity measure; the degree of polarization at zero
    /// separation. It may exceed 1 elsewhere, and is infinite where `C0` alone vanishes. Where all four vanish it
    /// is 0, unless they share their modes: then it is the same number everywhere.
    ///
    /// Source: Shirai & Wolf, Opt. Commun. 272 (2007); Eq. (S4.9) with moduli and the first power of `C0`.
    #[must_use]
    pub fn degree_of_cross_polarization(&self, separation: &Vector2<f64>) -> f64 {
        let [c0, rest @ ..] = self.ratios(separation);
        let [c1, c2, c3] = rest.map(Complex64::norm);
        let polarized = c1.hypot(c2).hypot(c3);
        if polarized == 0.0 {
            0.0
        } else {
            polarized / c0.norm()
        }
    }

    /// The complex degree of cross-polarization, `√(C1² + C2² + C3²)/C0` (no moduli); `None` where `C0` vanishes or is
    /// too small to divide by.
    ///
    /// Equals `√(1 − 4 det C/tr² C)`, which is Eq. (S4.4) at a separation; of the two roots the one with
    /// non-negative real part. The same in every frame. Its modulus is at most
    /// [`GeneralizedStokes::degree_of_cross_polarization`].
    ///
    /// Source: Eq. (S4.9) with the first power of `C0`.
    #[must_use]
    pub fn complex_degree_of_cross_polarization(
        &self,
        separation: &Vector2<f64>,
    ) -> Option<Complex64> {
        let [c0, rest @ ..] = self.ratios(separation);
        let (modulus, most) = (
            c0.norm(),
            rest.iter().fold(0.0, |most: f64, c| most.max(c.norm())),
        );
        if modulus == 0.0 {
            return None;
        }
        if most == 0.0 {
            return Some(Complex64::ZERO);
        }
        // numbers of modulus near 1, whose squares neither over- nor underflow
        let turn = (c0 / modulus).conj();
        let squares = rest.map(|c| (c / most * turn).powi(2));
        let factor = most / modulus;
        factor
            .is_finite()
            .then(|| squares.iter().sum::<Complex64>().sqrt() * factor)
    }

    /// Four numbers in the ratio of the `C_j`: where they share their modes, the four amplitudes.
    fn ratios(&self, separation: &Vector2<f64>) -> [Complex64; 4] {
        match self.components() {
            Components::Shared { stokes, .. } => stokes.to_array().map(Complex64::from),
            Components::Separate(_) => self.at_separation(separation),
        }
    }
}
