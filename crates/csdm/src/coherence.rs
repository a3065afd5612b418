//! What a cross-spectral density matrix says about the light: intensity, degrees of polarization and of coherence.
//!
//! Observables of one point ask first whether the matrix is one of a single point (Hermitian to 1e-12 of its largest
//! element); those of two points do not.

use num_complex::Complex64;
use stokes::StokesVector;

use crate::csdm::CrossSpectralDensity;
use crate::positivity::{CoherenceError, ROUNDING};

impl CrossSpectralDensity {
    /// The classical Stokes vector of a matrix of one point.
    ///
    /// # Errors
    ///
    /// When the matrix is not Hermitian to 1e-12 of its largest element.
    pub fn stokes(&self) -> Result<StokesVector, CoherenceError> {
        self.check_hermitian(ROUNDING)?;
        Ok(self.real_stokes())
    }

    /// Intensity `I = tr C` of a matrix of one point.
    ///
    /// Source: Eq. (S4.2).
    ///
    /// # Errors
    ///
    /// As [`CrossSpectralDensity::stokes`].
    pub fn intensity(&self) -> Result<f64, CoherenceError> {
        Ok(self.stokes()?.s0())
    }

    /// Degree of polarization of a matrix of one point; 0 where it is dark.
    ///
    /// Equals `√(1 − 4 det C/tr² C)`, evaluated as the length of `(C1, C2, C3)` over `C0`: relative error of a few
    /// `f64::EPSILON`, for nearly unpolarized light too. See [`CrossSpectralDensity::unpolarized_fraction`] for what is
    /// missing to full polarization.
    ///
    /// Source: Eq. (S4.4).
    ///
    /// # Errors
    ///
    /// As [`CrossSpectralDensity::stokes`].
    pub fn degree_of_polarization(&self) -> Result<f64, CoherenceError> {
        Ok(self.stokes()?.degree_of_polarization())
    }

    /// `1 − degree of polarization` of a matrix of one point, with its own digits near full polarization; 1 where it is
    /// dark.
    ///
    /// Evaluated as `4 det C/(tr² C (1 + P))`, the determinant by exact products: relative error of a few
    /// `f64::EPSILON` for the elements as they stand.
    ///
    /// # Errors
    ///
    /// As [`CrossSpectralDensity::stokes`].
    ///
    /// ```
    /// use num_complex::Complex64;
    /// // one photon in 10¹² with the wrong polarization
    /// let light = nalgebra::Matrix2::new(1.0, 0.0, 0.0, 1e-12).map(Complex64::from);
    /// let missing = csdm::CrossSpectralDensity::new(light)?.unpolarized_fraction()?;
    /// assert!((missing / 2e-12 - 1.0).abs() < 1e-11);
    /// # Ok::<(), csdm::CoherenceError>(())
    /// ```
    pub fn unpolarized_fraction(&self) -> Result<f64, CoherenceError> {
        let stokes = self.stokes()?;
        if stokes.s0() <= 0.0 {
            return Ok(1.0);
        }
        let degree = stokes.degree_of_polarization();
        Ok(4.0 * (self.determinant_over(stokes.s0()) / stokes.s0()) / (1.0 + degree))
    }

    /// Spectral degree of coherence `γ = tr C(r₁, r₂)/√(I(r₁) I(r₂))` for the intensities at the two points; of
    /// modulus at most 1.
    ///
    /// Source: Eq. (S4.3).
    ///
    /// # Errors
    ///
    /// When an intensity is not positive.
    pub fn spectral_degree_of_coherence(
        &self,
        first_intensity: f64,
        second_intensity: f64,
    ) -> Result<Complex64, CoherenceError> {
        if !(first_intensity > 0.0 && second_intensity > 0.0) {
            return Err(CoherenceError::Dark {
                first: first_intensity,
                second: second_intensity,
            });
        }
        Ok(self.0.trace() / (first_intensity.sqrt() * second_intensity.sqrt()))
    }

    /// Degree of cross-polarization of two points, `√(|C1|² + |C2|² + |C3|²)/|C0|`: the same in every frame, equal to
    /// the degree of polarization where the points are one, without an upper bound elsewhere.
    ///
    /// `None` where `C0` vanishes.
    ///
    /// Source: Shirai & Wolf 2007, Opt. Commun. 272, 289: `√(2 tr(C†C)/|tr C|² − 1)`, in place of Eq. (S4.9).
    #[must_use]
    pub fn degree_of_cross_polarization(&self) -> Option<f64> {
        let [c0, c1, c2, c3] = self.generalized_stokes().map(Complex64::norm);
        (c0 > 0.0).then(|| c1.hypot(c2).hypot(c3) / c0)
    }

    /// The complex degree `√(C1² + C2² + C3²)/C0 = √(1 − 4 det C/tr² C)` of two points, on the principal branch.
    ///
    /// What Eq. (S4.9) says literally, but for the power of `C0`: the same in every frame, with a branch cut, not a
    /// visibility. `None` where `C0` vanishes.
    #[must_use]
    pub fn complex_degree_of_polarization(&self) -> Option<Complex64> {
        let [c0, c1, c2, c3] = self.generalized_stokes();
        (c0.norm() > 0.0).then(|| {
            let [a, b, c] = [c1 / c0, c2 / c0, c3 / c0];
            (a * a + b * b + c * c).sqrt()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_ensembles::{average, fields};
    use nalgebra::{Matrix2, Vector2};
    use proptest::prelude::*;
    use stokes::FrameRotation;

    fn real(xx: f64, xy: f64, yy: f64) -> CrossSpectralDensity {
        CrossSpectralDensity(Matrix2::new(xx, xy, xy, yy).map(Complex64::from))
    }

    #[test]
    fn the_degree_of_polarization_keeps_its_digits_at_both_ends() {
        for degree in [1e-12, 1e-6, 0.3, 1.0 - 1e-6] {
            let matrix = real(0.5, 0.5 * degree, 0.5);
            assert!((matrix.degree_of_polarization().unwrap() / degree - 1.0).abs() < 1e-15);
        }
        // √(1 − 4 det/tr²) as written has lost all of it: 1 − 1e-24 is 1
        let (xx, xy) = (0.5f64, 0.5e-12f64);
        assert_eq!((1.0 - 4.0 * (xx * xx - xy * xy)).sqrt(), 0.0);
    }

    #[test]
    fn what_is_missing_to_full_polarization_has_its_own_digits() {
        // field (1, 3)/√10 and a little of the orthogonal one: numbers that f64 holds exactly
        for missing in [2f64.powi(-44), 2f64.powi(-20), 0.25] {
            // eigenvalues 10 and 10 m: 1 − P = 2 m/(1 + m), whatever the phase between the axes
            let exact = 2.0 * missing / (1.0 + missing);
            for quarter_turns in 0..4 {
                let mut matrix = real(1.0 + 9.0 * missing, 3.0 - 3.0 * missing, 9.0 + missing);
                let phase = Complex64::new(0.0, 1.0).powu(quarter_turns);
                matrix.0[(0, 1)] *= phase;
                matrix.0[(1, 0)] *= phase.conj();
                let found = matrix.unpolarized_fraction().unwrap();
                assert!((found / exact - 1.0).abs() < 1e-15, "{missing} {found}");
                matrix.check_positive(0.0).unwrap();
            }
        }
        assert_eq!(real(0.0, 0.0, 0.0).unpolarized_fraction().unwrap(), 1.0);
        for size in [1e-300, 1e-160, 1e160, 1e300] {
            let matrix = real(size, 0.0, 1e-3 * size);
            let found = matrix.unpolarized_fraction().unwrap();
            assert!((found / (2e-3 / 1.001) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_printed_degree_of_eq_s4_9_is_not_that_of_eq_s4_4() {
        // C0 = 2, P = 0.3: the printed 1/C0² gives 0.15
        let matrix = real(1.3, 0.0, 0.7);
        let degree = matrix.degree_of_polarization().unwrap();
        let [c0, c1, ..] = matrix.generalized_stokes();
        assert!((degree - 0.3).abs() < 1e-15);
        assert!((c1.norm() / c0.norm_sqr() - 0.15).abs() < 1e-15);
        assert!((matrix.degree_of_cross_polarization().unwrap() - degree).abs() < 1e-15);
        assert!((matrix.complex_degree_of_polarization().unwrap() - degree).norm() < 1e-15);
    }

    #[test]
    fn youngs_fringes_have_the_visibility_of_the_degree_of_coherence() {
        // two points of intensities 4 and 1 with the same field but for a phase, and half of the light incoherent
        let field = Vector2::new(Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0));
        let other = field * Complex64::cis(0.7);
        let coherent = CrossSpectralDensity::of_fields(field, other);
        let gamma = coherent.spectral_degree_of_coherence(4.0, 4.0).unwrap();
        assert!((gamma - 0.5 * Complex64::cis(-0.7)).norm() < 1e-15);
        assert!(coherent.spectral_degree_of_coherence(0.0, 1.0).is_err());
    }

    proptest! {
        #[test]
        fn no_frame_changes_intensity_coherence_or_degrees(fields in fields(), angle in -4.0..4.0f64) {
            let rotation = FrameRotation::from_angle(angle);
            let (here, pair) = (average(&fields, 0, 0), average(&fields, 0, 1));
            let (here_turned, turned) = (here.in_turned_frame(rotation), pair.in_turned_frame(rotation));
            let close = |a: f64, b: f64| (a - b).abs() < 1e-13;
            prop_assert!(close(here.intensity().unwrap(), here_turned.intensity().unwrap()));
            prop_assert!(close(
                here.degree_of_polarization().unwrap(), here_turned.degree_of_polarization().unwrap()));
            let (c, c_turned) = (pair.generalized_stokes(), turned.generalized_stokes());
            prop_assert!((c[0] - c_turned[0]).norm() < 1e-14 && (c[3] - c_turned[3]).norm() < 1e-14);
            prop_assume!(c[0].norm() > 1e-2);
            let cross = |m: &CrossSpectralDensity| m.degree_of_cross_polarization().unwrap();
            prop_assert!(close(cross(&pair) * c[0].norm(), cross(&turned) * c[0].norm()));
            // Shirai & Wolf's form of it; both sides are sums of terms up to |C_j|²/|C0|²
            let m = pair.to_matrix();
            let square = cross(&pair).powi(2);
            let tolerance = 2e-14 * (1.0 + square);
            let by_traces = 2.0 * (m.adjoint() * m).trace().re / m.trace().norm_sqr() - 1.0;
            prop_assert!((square - by_traces).abs() < tolerance);
            let complex = pair.complex_degree_of_polarization().unwrap();
            let determinant = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)];
            let by_determinant = 1.0 - 4.0 * determinant / m.trace().powi(2);
            prop_assert!((complex * complex - by_determinant).norm() < tolerance);
        }
    }
}
