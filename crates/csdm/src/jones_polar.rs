//! What a Jones matrix does to power and to phase: singular values, and the polar decomposition `T = U H`.

use nalgebra::Matrix2;
use num_complex::Complex64;

use crate::jones::{JonesMatrix, pauli};
use crate::scale::power_of_two;

/// A determinant below this much of the squared norm is rounding: its phase means nothing.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A Jones matrix as a diattenuator followed by a retarder.
///
/// `T = U H`: `H` is Hermitian and not negative, a diattenuator; `U` is unitary, a retarder. In two dimensions both follow
/// without iterations from the conjugate cofactor matrix `K = adj(T)†`:
///
/// ```text
/// U = (T + e^{iθ} K)/(σ₁ + σ₂),   e^{iθ} = det T/|det T|
/// σ₁ ± σ₂ = ‖T ± e^{iθ} K‖_F/√2,   σ₂ = |det T|/σ₁
/// ```
///
/// so that no difference of nearly equal numbers decides about a weak diattenuation. Where `det T = 0` (a polarizer)
/// `U` is not unique; of all phases `e^{iθ} = (tr T)²/|tr T|²` makes its retardance least, and 1 serves where the trace
/// vanishes too.
///
/// Source: Higham, Functions of Matrices, chapter 8 (polar decomposition); Lu & Chipman 1994, Homogeneous and
/// inhomogeneous Jones matrices, J. Opt. Soc. Am. A 11, 766 (diattenuation and retardance by it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JonesPolar {
    /// The unitary factor, met second.
    pub retarder: JonesMatrix,
    /// The Hermitian factor, met first; its eigenvalues are the singular values.
    pub diattenuator: JonesMatrix,
    /// The larger and the smaller singular value: amplitudes of the best and the worst transmitted light.
    pub singular_values: [f64; 2],
}

impl JonesMatrix {
    /// Determinant, complex.
    #[must_use]
    pub fn determinant(&self) -> Complex64 {
        let m = self.to_matrix();
        m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)]
    }

    /// Singular values, the larger first: their squares are the greatest and the least transmittance of any light.
    ///
    /// Absolute error of a few `f64::EPSILON` times the larger.
    ///
    /// ```
    /// let plate = csdm::JonesMatrix::partial_polarizer(0.3, 0.9)?.rotated(0.4);
    /// let [best, worst] = plate.singular_values();
    /// assert!((best - 0.9).abs() < 1e-15 && (worst - 0.3).abs() < 1e-15);
    /// # Ok::<(), csdm::ElementError>(())
    /// ```
    #[must_use]
    pub fn singular_values(&self) -> [f64; 2] {
        Parts::of(self).singular_values()
    }

    /// Diattenuation `(σ₁² − σ₂²)/(σ₁² + σ₂²)`, in `0.0..=1.0`; 0 for the zero matrix.
    ///
    /// Absolute error of a few `f64::EPSILON`, also for a weak diattenuation.
    #[must_use]
    pub fn diattenuation(&self) -> f64 {
        let Parts {
            sum, difference, ..
        } = Parts::of(self);
        if sum == 0.0 {
            return 0.0;
        }
        let ratio = difference / sum;
        (2.0 * ratio / (1.0 + ratio * ratio)).min(1.0)
    }

    /// Retardance δ of the unitary factor, radians in `0.0..=π`: the phase between its two eigenpolarizations.
    ///
    /// The least possible one where the matrix is singular. Error of a few `f64::EPSILON` over the smaller singular
    /// value (relative to the larger).
    ///
    /// ```
    /// let plate = csdm::JonesMatrix::elliptical_retarder(0.5, 0.2, 1.2);
    /// assert!((plate.retardance() - 1.2).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn retardance(&self) -> f64 {
        let unitary = self.polar().retarder.to_matrix();
        // U = e^{iφ} (cos δ/2 + i sin δ/2 f·σ): moduli of the four Pauli coefficients
        let [cosine, s1, s2, s3] = pauli().map(|sigma| 0.5 * (sigma * unitary).trace().norm());
        2.0 * s1.hypot(s2).hypot(s3).atan2(cosine)
    }

    /// The polar decomposition; the zero matrix has the identity for its retarder.
    #[must_use]
    pub fn polar(&self) -> JonesPolar {
        let parts = Parts::of(self);
        if parts.sum == 0.0 {
            return JonesPolar {
                retarder: Self::identity(),
                diattenuator: *self,
                singular_values: [0.0; 2],
            };
        }
        let unitary = parts.plus / Complex64::from(parts.sum);
        let product = unitary.adjoint() * self.to_matrix();
        // U†T is Hermitian up to rounding; the mean of it and its adjoint is so exactly
        let hermitian = (product + product.adjoint()) * Complex64::from(0.5);
        JonesPolar {
            retarder: Self::from(unitary),
            diattenuator: Self::from(hermitian),
            singular_values: parts.singular_values(),
        }
    }
}

/// `T + e^{iθ}K`, and the sum and the difference of the singular values, all of `T` over `scale`.
struct Parts {
    scale: f64,
    plus: Matrix2<Complex64>,
    determinant: f64,
    sum: f64,
    difference: f64,
}

impl Parts {
    fn of(jones: &JonesMatrix) -> Self {
        let m = jones.to_matrix();
        let largest = m.iter().fold(0.0, |largest: f64, e| {
            largest.max(e.re.abs()).max(e.im.abs())
        });
        let scale = power_of_two(largest);
        let m = m.map(|e| e / scale);
        let determinant = JonesMatrix::from(m).determinant();
        let known = determinant.norm() > ROUNDING * m.norm_squared();
        let phase = if known {
            determinant / determinant.norm()
        } else {
            let trace = m.trace();
            if trace.norm() > ROUNDING * m.norm() {
                (trace / trace.norm()).powi(2)
            } else {
                Complex64::from(1.0)
            }
        };
        let cofactors = Matrix2::new(
            m[(1, 1)].conj(),
            -m[(1, 0)].conj(),
            -m[(0, 1)].conj(),
            m[(0, 0)].conj(),
        ) * phase;
        let (plus, minus) = (m + cofactors, m - cofactors);
        Self {
            scale,
            plus,
            determinant: determinant.norm(),
            sum: plus.norm() * std::f64::consts::FRAC_1_SQRT_2,
            difference: minus.norm() * std::f64::consts::FRAC_1_SQRT_2,
        }
    }

    fn singular_values(&self) -> [f64; 2] {
        let larger = 0.5 * (self.sum + self.difference);
        let smaller = if larger > 0.0 {
            self.determinant / larger
        } else {
            0.0
        };
        [larger, smaller].map(|value| value * self.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn norm(m: Matrix2<Complex64>) -> f64 {
        m.norm()
    }

    #[test]
    fn a_polarizer_has_full_diattenuation_and_no_retardance() {
        let polarizer = JonesMatrix::elliptical_polarizer(0.7, 0.2);
        assert!((polarizer.diattenuation() - 1.0).abs() < 1e-15);
        assert!(polarizer.retardance() < 1e-14);
        let polar = JonesMatrix::linear_polarizer().polar();
        assert!(norm(polar.retarder.to_matrix() - Matrix2::identity()) < 1e-15);
    }

    #[test]
    fn a_polarizer_that_turns_its_light_has_the_angle_for_retardance() {
        // passes x, sends out light at 30°: the gentlest rotation between the two states is 2·30° on the sphere
        let angle = PI / 6.0;
        let element = JonesMatrix::rotator(angle) * JonesMatrix::linear_polarizer();
        assert!((element.retardance() - 2.0 * angle).abs() < 1e-15);
        // orthogonal states: every rotation is by π
        let flip = JonesMatrix::rotator(FRAC_PI_2) * JonesMatrix::linear_polarizer();
        assert!((flip.retardance() - PI).abs() < 1e-15);
    }

    #[test]
    fn a_weak_diattenuation_keeps_its_digits() {
        let weak = 1e-9;
        let element = JonesMatrix::homogeneous(0.3, 0.1, (1.0 + weak).into(), (1.0 - weak).into());
        // (σ₁² − σ₂²)/(σ₁² + σ₂²) = 2 ε/(1 + ε²)
        assert!((element.diattenuation() - 2.0 * weak).abs() < 1e-15);
    }

    #[test]
    fn nothing_comes_out_of_the_zero_matrix() {
        let dark = JonesMatrix::diagonal(0.0.into(), 0.0.into());
        assert_eq!(dark.singular_values(), [0.0, 0.0]);
        assert_eq!((dark.diattenuation(), dark.retardance()), (0.0, 0.0));
    }

    #[test]
    fn elements_of_any_size_have_the_same_degrees() {
        for size in [1e-300, 1e-160, 1e-100, 1e100, 1e160, 1e300] {
            let plate = JonesMatrix::homogeneous(0.3, 0.1, 1.0.into(), Complex64::new(0.0, 0.5));
            let scaled = plate.scaled(size.into());
            assert!((scaled.diattenuation() - 0.6).abs() < 1e-15);
            assert!((scaled.retardance() - FRAC_PI_2).abs() < 1e-14);
            let [best, worst] = scaled.singular_values();
            assert!((best / size - 1.0).abs() < 1e-14 && (worst / size - 0.5).abs() < 1e-14);
        }
    }

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || prop_oneof![4 => -2.0..2.0f64, 1 => -1e-9..1e-9f64, 1 => Just(0.0)];
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        prop::array::uniform4(complex()).prop_map(|[a, b, c, d]| JonesMatrix::new(a, b, c, d))
    }

    proptest! {
        #[test]
        fn planted_factors_are_found(
            larger in 0.1..1.0f64, ratio in prop_oneof![0.01..0.99f64, 0.999999..1.0f64],
            axis in (-1.5..1.5f64, -0.7..0.7f64), fast in (-1.5..1.5f64, -0.7..0.7f64), retardance in 0.0..PI,
        ) {
            let smaller = larger * ratio;
            let diattenuator = JonesMatrix::homogeneous(axis.0, axis.1, larger.into(), smaller.into());
            let retarder = JonesMatrix::elliptical_retarder(fast.0, fast.1, retardance);
            let element = retarder * diattenuator;
            let polar = element.polar();
            let tolerance = 1e-14 / ratio;
            prop_assert!((polar.singular_values[0] - larger).abs() < 1e-14);
            prop_assert!((polar.singular_values[1] - smaller).abs() < 1e-14);
            prop_assert!((element.retardance() - retardance).abs() < tolerance);
            prop_assert!(norm(polar.retarder.to_matrix() - retarder.to_matrix()) < tolerance);
            prop_assert!(norm(polar.diattenuator.to_matrix() - diattenuator.to_matrix()) < tolerance);
            let d = (larger * larger - smaller * smaller) / (larger * larger + smaller * smaller);
            prop_assert!((element.diattenuation() - d).abs() < 1e-14);
        }

        #[test]
        fn the_factors_multiply_back_to_the_matrix(t in matrix()) {
            let polar = t.polar();
            let scale = t.to_matrix().norm();
            let product = (polar.retarder * polar.diattenuator).to_matrix();
            prop_assert!(norm(product - t.to_matrix()) <= 1e-14 * scale);
            let u = polar.retarder.to_matrix();
            prop_assert!(norm(u.adjoint() * u - Matrix2::identity()) < 1e-14);
        }

        #[test]
        fn an_element_is_passive_when_its_larger_singular_value_is_at_most_1(t in matrix()) {
            // M00 + |(M01, M02, M03)| is the greatest transmittance of any light, σ₁²
            let m = t.mueller().to_matrix();
            let row = m.fixed_view::<1, 3>(0, 1).norm();
            let column = m.fixed_view::<3, 1>(1, 0).norm();
            let best = t.singular_values()[0].powi(2);
            prop_assert!((m[(0, 0)] + row - best).abs() <= 1e-14 * best);
            prop_assert!((m[(0, 0)] + column - best).abs() <= 1e-14 * best);
        }
    }
}
