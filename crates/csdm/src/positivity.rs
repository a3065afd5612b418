//! Whether a matrix can be the cross-spectral density of any light: of one point, or of a pair.

use nalgebra::Matrix4;
use num_complex::Complex64;
use stokes::StokesVector;
use thiserror::Error;

use crate::csdm::CrossSpectralDensity;
use crate::doubled::Doubled;
use crate::scale::power_of_two;

/// Deviation from a Hermitian matrix, relative to its largest element, that one-point observables still accept.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Why a matrix is no cross-spectral density, or not one of a single point.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CoherenceError {
    /// An element is infinite or not a number.
    #[error(
        "cross-spectral density: element ({row}, {column}) is {value}, expected a finite number"
    )]
    NotFinite {
        /// Row of the element, from 0.
        row: usize,
        /// Column of the element, from 0.
        column: usize,
        /// What was found.
        value: Complex64,
    },
    /// The matrix is not Hermitian, as it has to be where the two points are one.
    #[error(
        "cross-spectral density: element ({row}, {column}) is {found} and the conjugate of its mirror image is \
         {expected}: they differ by {difference}, expected at most {limit} at a single point"
    )]
    NotHermitian {
        /// Row of the element, from 0.
        row: usize,
        /// Column of the element, from 0.
        column: usize,
        /// The element.
        found: Complex64,
        /// The conjugate of the element mirrored at the diagonal.
        expected: Complex64,
        /// Modulus of their difference.
        difference: f64,
        /// Largest difference allowed.
        limit: f64,
    },
    /// An eigenvalue that has to be a power is negative.
    #[error(
        "cross-spectral density: the {what} has the eigenvalue {eigenvalue} at trace {trace}, expected at least \
         {least}: no field has this coherence"
    )]
    Negative {
        /// `"matrix"` of one point, or `"pair of points"`.
        what: &'static str,
        /// The smallest eigenvalue.
        eigenvalue: f64,
        /// Sum of all eigenvalues.
        trace: f64,
        /// Least eigenvalue allowed.
        least: f64,
    },
    /// The degree of coherence of a point without light was asked for.
    #[error(
        "spectral degree of coherence: the intensities are {first} and {second}, expected two positive numbers"
    )]
    Dark {
        /// Intensity at the first point.
        first: f64,
        /// Intensity at the second point.
        second: f64,
    },
}

impl CrossSpectralDensity {
    /// Asks whether the matrix is Hermitian within `tolerance` times its largest element, as it is where the two points
    /// are one.
    ///
    /// # Errors
    ///
    /// With the element that deviates most, and by how much; or with one that is infinite or not a number.
    pub fn check_hermitian(&self, tolerance: f64) -> Result<(), CoherenceError> {
        Self::new(self.0)?;
        let limit = tolerance * self.0.camax();
        let worst = [(0, 0), (0, 1), (1, 1)]
            .map(|(row, column)| {
                let (found, expected) = (self.0[(row, column)], self.0[(column, row)].conj());
                (row, column, found, expected, (found - expected).norm())
            })
            .into_iter()
            .max_by(|a, b| a.4.total_cmp(&b.4));
        match worst {
            Some((row, column, found, expected, difference)) if difference > limit => {
                Err(CoherenceError::NotHermitian {
                    row,
                    column,
                    found,
                    expected,
                    difference,
                    limit,
                })
            }
            _ => Ok(()),
        }
    }

    /// Asks whether the matrix is that of light at one point: Hermitian, with no eigenvalue below `−tolerance` times
    /// its trace.
    ///
    /// # Errors
    ///
    /// When it is not Hermitian, or with the smaller eigenvalue.
    pub fn check_positive(&self, tolerance: f64) -> Result<(), CoherenceError> {
        self.check_hermitian(tolerance.max(ROUNDING))?;
        let stokes = self.real_stokes();
        let trace = stokes.s0();
        let larger = 0.5 * (trace + stokes.polarized_intensity());
        // the product of the two has its digits; their difference from the trace has not
        let eigenvalue = if larger > 0.0 {
            self.determinant_over(larger)
        } else {
            0.5 * (trace - stokes.polarized_intensity())
        };
        let least = -tolerance * trace.abs();
        if eigenvalue < least {
            return Err(CoherenceError::Negative {
                what: "matrix",
                eigenvalue,
                trace,
                least,
            });
        }
        Ok(())
    }

    /// Asks whether a field can have this matrix between two points that have the matrices `at_first` and `at_second`
    /// each: whether `[[C(r₁,r₁), C(r₁,r₂)], [C(r₂,r₁), C(r₂,r₂)]]` has no eigenvalue below `−tolerance` times its
    /// trace.
    ///
    /// This, and not `|(C1, C2, C3)| ≤ |C0|`, is what holds of two points.
    ///
    /// # Errors
    ///
    /// When one of the two is not Hermitian, an element is infinite or not a number, or with the smallest eigenvalue.
    pub fn check_pair(
        &self,
        at_first: &Self,
        at_second: &Self,
        tolerance: f64,
    ) -> Result<(), CoherenceError> {
        Self::new(self.0)?;
        at_first.check_hermitian(tolerance.max(ROUNDING))?;
        at_second.check_hermitian(tolerance.max(ROUNDING))?;
        let mut whole = Matrix4::zeros();
        whole.fixed_view_mut::<2, 2>(0, 0).copy_from(&at_first.0);
        whole.fixed_view_mut::<2, 2>(0, 2).copy_from(&self.0);
        whole
            .fixed_view_mut::<2, 2>(2, 0)
            .copy_from(&self.0.adjoint());
        whole.fixed_view_mut::<2, 2>(2, 2).copy_from(&at_second.0);
        // near 1, so that no square in the search for eigenvalues overflows
        let scale = power_of_two(whole.camax());
        let whole = whole.map(|e| e / scale);
        let trace = whole.trace().re * scale;
        let eigenvalue = whole.symmetric_eigenvalues().min() * scale;
        let least = -tolerance * trace.abs();
        if eigenvalue < least {
            return Err(CoherenceError::Negative {
                what: "pair of points",
                eigenvalue,
                trace,
                least,
            });
        }
        Ok(())
    }

    /// The real parts of the four parameters.
    pub(crate) fn real_stokes(&self) -> StokesVector {
        self.generalized_stokes().map(|c| c.re).into()
    }

    /// Determinant of the Hermitian part, `xx yy − |xy|²`, over a `size` not far from the trace; to a few roundings of
    /// itself, without overflow.
    pub(crate) fn determinant_over(&self, size: f64) -> f64 {
        let scale = power_of_two(size);
        let m = self.0.map(|e| e / scale);
        let cross = 0.5 * (m[(0, 1)] + m[(1, 0)].conj());
        let determinant = Doubled::product(m[(0, 0)].re, m[(1, 1)].re)
            + Doubled::product(-cross.re, cross.re)
            + Doubled::product(-cross.im, cross.im);
        determinant.0 / (size / scale) * scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_ensembles::{average, fields};
    use nalgebra::Matrix2;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

    fn real(xx: f64, xy: f64, yy: f64) -> CrossSpectralDensity {
        CrossSpectralDensity(Matrix2::new(xx, xy, xy, yy).map(Complex64::from))
    }

    #[test]
    fn a_matrix_of_two_points_is_no_matrix_of_one() {
        let mut matrix = real(1.0, 0.25, 1.0);
        matrix.0[(0, 1)] += Complex64::new(0.0, 1e-6);
        let error = matrix.degree_of_polarization().unwrap_err();
        let CoherenceError::NotHermitian {
            row,
            column,
            difference,
            ..
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!((row, column), (0, 1));
        assert!((difference - 1e-6).abs() < 1e-15);
        assert!(matrix.check_hermitian(1e-5).is_ok());
        // an imaginary intensity is as wrong
        matrix.0[(1, 1)] = Complex64::new(1.0, 0.5);
        assert!(matches!(
            matrix.intensity(),
            Err(CoherenceError::NotHermitian {
                row: 1,
                column: 1,
                ..
            })
        ));
    }

    #[test]
    fn more_polarized_light_than_there_is_light_is_refused_with_the_eigenvalue() {
        // eigenvalues 1.2 and −0.2
        let error = real(0.5, 0.7, 0.5).check_positive(1e-9).unwrap_err();
        let CoherenceError::Negative {
            eigenvalue, trace, ..
        } = error
        else {
            panic!("{error}");
        };
        assert!((eigenvalue + 0.2).abs() < 1e-15 && trace == 1.0);
        // as much circular light as that
        let mut circular = real(0.5, 0.0, 0.5);
        circular.0[(0, 1)] = Complex64::new(0.0, -0.7);
        circular.0[(1, 0)] = Complex64::new(0.0, 0.7);
        assert!(circular.check_positive(1e-9).is_err());
        assert!(real(0.5, 0.5, 0.5).check_positive(0.0).is_ok());
        assert!(real(-1.0, 0.0, -1.0).check_positive(1e-9).is_err());
    }

    #[test]
    fn the_printed_cone_of_eq_s4_6_does_not_hold_of_two_points() {
        // x from directions ±1, y from ±3 (incoherent plane waves): C_xx = ½cos d, C_yy = ½cos 3d
        let at = |d: f64| real(0.5 * d.cos(), 0.0, 0.5 * (3.0 * d).cos());
        let (here, pair) = (at(0.0), at(FRAC_PI_4));
        // it is a field
        pair.check_pair(&here, &here, 1e-15).unwrap();
        // and yet |(C1, C2, C3)| = 0.707 > |C0| = 0
        let [c0, c1, ..] = pair.generalized_stokes();
        assert!(c0.norm() < 1e-16 && (c1.re - FRAC_1_SQRT_2).abs() < 1e-15);
        // at one point the cone holds
        here.check_positive(0.0).unwrap();
    }

    #[test]
    fn a_pair_of_points_cannot_be_more_coherent_than_bright() {
        let here = real(0.5, 0.0, 0.5);
        assert!(real(0.5, 0.0, 0.5).check_pair(&here, &here, 1e-15).is_ok());
        let error = real(0.6, 0.0, 0.5).check_pair(&here, &here, 1e-15);
        let Err(CoherenceError::Negative {
            eigenvalue, what, ..
        }) = error
        else {
            panic!("{error:?}");
        };
        assert!((eigenvalue + 0.1).abs() < 1e-15 && what == "pair of points");
    }

    #[test]
    fn pairs_of_any_size_are_judged() {
        for size in [1e-300, 1e-160, 1e160, 1e300] {
            let here = real(size, 0.0, 0.5 * size);
            assert!(here.check_pair(&here, &here, 1e-15).is_ok());
            let brighter = real(1.1 * size, 0.0, 0.5 * size);
            assert!(brighter.check_pair(&here, &here, 1e-15).is_err());
        }
        let here = real(1e308, 0.0, 1e308);
        let overflown = here.plus(&here);
        assert!(matches!(
            overflown.check_pair(&here, &here, 1e-15),
            Err(CoherenceError::NotFinite { .. })
        ));
    }

    proptest! {
        #[test]
        fn any_ensemble_passes_every_check(fields in fields()) {
            let (first, second) = (average(&fields, 0, 0), average(&fields, 1, 1));
            let between = average(&fields, 0, 1);
            prop_assert!(first.check_positive(1e-14).is_ok());
            prop_assert!(between.check_pair(&first, &second, 1e-14).is_ok());
            let (i1, i2) = (first.intensity().unwrap(), second.intensity().unwrap());
            prop_assume!(i1 > 0.0 && i2 > 0.0);
            prop_assert!(between.spectral_degree_of_coherence(i1, i2).unwrap().norm() < 1.0 + 1e-14);
        }
    }
}
