//! Jones matrices, and the Mueller matrix that each of them implies.

use std::ops::Mul;

use nalgebra::{Matrix2, Matrix4, Vector2};
use num_complex::Complex64;
use stokes::{Mueller, StokesVector};

const ZERO: Complex64 = Complex64::new(0.0, 0.0);
const ONE: Complex64 = Complex64::new(1.0, 0.0);
const I: Complex64 = Complex64::new(0.0, 1.0);

/// Jones matrix: 2×2, complex, dimensionless; takes `(E_x, E_y)` in the frame of the incident light to that of the
/// outgoing light, both in `exp(+iωt)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JonesMatrix(Matrix2<Complex64>);

impl JonesMatrix {
    /// The matrix `[[xx, xy], [yx, yy]]`.
    #[must_use]
    pub fn new(xx: Complex64, xy: Complex64, yx: Complex64, yy: Complex64) -> Self {
        Self(Matrix2::new(xx, xy, yx, yy))
    }

    /// An element that keeps the two axes apart: `diag(x, y)`.
    #[must_use]
    pub fn diagonal(x: Complex64, y: Complex64) -> Self {
        Self::new(x, ZERO, ZERO, y)
    }

    /// Matter that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self::diagonal(ONE, ONE)
    }

    /// Optically active matter: turns the field by `angle` radians, counter-clockwise for the receiver.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    #[must_use]
    pub fn rotator(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self::new(cos.into(), (-sin).into(), sin.into(), cos.into())
    }

    /// Ideal polarizer that passes fields along `x`.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    #[must_use]
    #[doc(alias = "diattenuator_perfect")]
    pub fn linear_polarizer() -> Self {
        Self::diagonal(ONE, ZERO)
    }

    /// Linear retarder with its fast axis along `x`: `diag(1, e^{−iδ})`, `retardance` δ in radians.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    ///
    /// A quarter-wave plate turns +45° light into left circular light:
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    /// let out = csdm::JonesMatrix::linear_retarder(FRAC_PI_2).mueller() * stokes::StokesVector::DIAGONAL;
    /// assert!((out - stokes::StokesVector::LEFT_CIRCULAR).to_vector().norm() < 1e-15);
    /// ```
    #[must_use]
    #[doc(alias = "retarder_linear")]
    pub fn linear_retarder(retardance: f64) -> Self {
        Self::diagonal(ONE, Complex64::cis(-retardance))
    }

    /// Ideal polarizer that passes right circular light (`S3 > 0`), the field `(1, i)/√2`.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    #[must_use]
    pub fn right_circular_polarizer() -> Self {
        Self(Matrix2::new(ONE, -I, I, ONE) * Complex64::from(0.5))
    }

    /// Ideal polarizer that passes left circular light (`S3 < 0`), the field `(1, −i)/√2`.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    #[must_use]
    pub fn left_circular_polarizer() -> Self {
        Self(Matrix2::new(ONE, I, -I, ONE) * Complex64::from(0.5))
    }

    /// The matrix as nalgebra holds it.
    #[must_use]
    pub fn to_matrix(self) -> Matrix2<Complex64> {
        self.0
    }

    /// The same element with all amplitudes times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: Complex64) -> Self {
        Self(self.0 * factor)
    }

    /// The element turned by `angle` radians about the ray, counter-clockwise for a receiver who faces the source;
    /// the frames stay.
    #[must_use]
    pub fn rotated(&self, angle: f64) -> Self {
        Self::rotator(angle) * *self * Self::rotator(-angle)
    }

    /// The matrix for light that retraces the path through reciprocal matter, `Z Jᵀ Z` with `Z = diag(1, −1)`.
    ///
    /// Frames: `(x, y, z)` forward become `(x, −y, −z)` backward on each side.
    ///
    /// Source: Sekera 1966, Scattering matrices and reciprocity relationships, J. Opt. Soc. Am. 56, 1732.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let m = &self.0;
        Self::new(m[(0, 0)], -m[(1, 0)], -m[(0, 1)], m[(1, 1)])
    }

    /// The field that leaves the element when `field` enters it.
    #[must_use]
    pub fn apply(&self, field: Vector2<Complex64>) -> Vector2<Complex64> {
        self.0 * field
    }

    /// The Mueller matrix of this element: `M_lj = ½ tr(σ_l T σ_j T†)`, with `σ` the identity and the Pauli
    /// matrices in the order of the Stokes parameters.
    ///
    /// Source: Eq. (S4.12) of the supplemental of Steinberg & Yan 2021 with fields in `exp(+iωt)`. Error of a
    /// few `f64::EPSILON` times the squared norm of the matrix.
    #[must_use]
    pub fn mueller(&self) -> Mueller {
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| self.0[at]);
        let [aa, bb, cc, dd] = [a, b, c, d].map(|z| 0.5 * z.norm_sqr());
        // the sums written out; without loops it is ten times faster
        let (first, second) = (a * b.conj(), c * d.conj());
        let (ac, bd, ad, bc) = (a * c.conj(), b * d.conj(), a * d.conj(), b * c.conj());
        let elements = Matrix4::new(
            aa + bb + cc + dd,
            aa - bb + cc - dd,
            (first + second).re,
            (first + second).im,
            aa + bb - cc - dd,
            aa - bb - cc + dd,
            (first - second).re,
            (first - second).im,
            (ac + bd).re,
            (ac - bd).re,
            (ad + bc).re,
            (ad - bc).im,
            -(ac + bd).im,
            -(ac - bd).im,
            -(ad + bc).im,
            (ad - bc).re,
        );
        Mueller::from(elements)
    }
}

impl From<Matrix2<Complex64>> for JonesMatrix {
    fn from(matrix: Matrix2<Complex64>) -> Self {
        Self(matrix)
    }
}

/// The identity, then the Pauli matrices in the order of S1, S2, S3.
pub(crate) fn pauli() -> [Matrix2<Complex64>; 4] {
    [
        Matrix2::new(ONE, ZERO, ZERO, ONE),
        Matrix2::new(ONE, ZERO, ZERO, -ONE),
        Matrix2::new(ZERO, ONE, ONE, ZERO),
        Matrix2::new(ZERO, -I, I, ZERO),
    ]
}

/// Elements in sequence: the right factor is met first.
impl Mul for JonesMatrix {
    type Output = Self;
    fn mul(self, first: Self) -> Self {
        Self(self.0 * first.0)
    }
}

/// The Stokes vector of a fully polarized field `(E_x, E_y)` in `exp(+iωt)`; unit: that of `|E|²`.
///
/// ```
/// use num_complex::Complex64;
/// // Re[(1, i) e^{iωt}] = (cos ωt, −sin ωt): clockwise for x right, y up, hence S3 > 0
/// let field = nalgebra::Vector2::new(Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0));
/// assert_eq!(csdm::stokes_vector(field).s3(), 2.0);
/// ```
#[must_use]
pub fn stokes_vector(field: Vector2<Complex64>) -> StokesVector {
    let (xx, yy) = (field.x.norm_sqr(), field.y.norm_sqr());
    let xy = field.x * field.y.conj();
    StokesVector::new(xx + yy, xx - yy, 2.0 * xy.re, -2.0 * xy.im)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
    use stokes::DiattenuatingRetarder;

    /// Twice the signed area per period that `Re[E e^{iωt}]` sweeps, over 2π: positive when counter-clockwise.
    fn sense_of_the_real_field(field: Vector2<Complex64>) -> f64 {
        let at = |t: f64| {
            let phase = Complex64::new(t.cos(), t.sin());
            ((field.x * phase).re, (field.y * phase).re)
        };
        let steps = 64;
        (0..steps)
            .map(|i| {
                let (x0, y0) = at(TAU * f64::from(i) / f64::from(steps));
                let (x1, y1) = at(TAU * f64::from(i + 1) / f64::from(steps));
                x0 * y1 - x1 * y0
            })
            .sum()
    }

    #[test]
    fn s3_is_positive_where_the_real_field_turns_clockwise() {
        for (x, y) in [
            ((1.0, 0.0), (0.0, 1.0)),
            ((0.3, 0.4), (-0.2, 0.7)),
            ((0.1, -1.0), (0.5, 0.5)),
        ] {
            let field = Vector2::new(Complex64::new(x.0, x.1), Complex64::new(y.0, y.1));
            let clockwise = sense_of_the_real_field(field) < 0.0;
            assert_eq!(stokes_vector(field).s3() > 0.0, clockwise);
        }
    }

    #[test]
    fn a_slow_axis_lags_in_time() {
        // E_y(t) = cos(ωt − π/2) reaches its crest a quarter period after E_x: x → y, counter-clockwise, S3 < 0
        let diagonal = Vector2::new(ONE, ONE);
        let out = JonesMatrix::linear_retarder(FRAC_PI_2).apply(diagonal);
        assert!(sense_of_the_real_field(out) > 0.0);
        assert!(stokes_vector(out).s3() < 0.0);
    }

    #[test]
    fn circular_polarizers_pass_their_own_hand_only() {
        let right = JonesMatrix::right_circular_polarizer().mueller();
        let left = JonesMatrix::left_circular_polarizer().mueller();
        assert_eq!(
            right * StokesVector::RIGHT_CIRCULAR,
            StokesVector::RIGHT_CIRCULAR
        );
        assert_eq!(right * StokesVector::LEFT_CIRCULAR, StokesVector::DARK);
        assert_eq!(
            left * StokesVector::UNPOLARIZED,
            StokesVector::LEFT_CIRCULAR * 0.5
        );
        let expected = [
            [0.5, 0.0, 0.0, 0.5],
            [0.0; 4],
            [0.0; 4],
            [0.5, 0.0, 0.0, 0.5],
        ];
        assert_eq!(right, Mueller::from_rows(expected));
    }

    #[test]
    fn a_half_wave_plate_mirrors_linear_light_about_its_axis() {
        let plate = JonesMatrix::linear_retarder(2.0 * FRAC_PI_2)
            .rotated(0.3)
            .mueller();
        let out = plate * StokesVector::linear(0.5);
        assert!((out - StokesVector::linear(0.1)).to_vector().norm() < 1e-15);
    }

    #[test]
    fn a_rotator_turns_the_plane_of_polarization() {
        let out = JonesMatrix::rotator(FRAC_PI_4).mueller() * StokesVector::HORIZONTAL;
        assert!((out - StokesVector::DIAGONAL).to_vector().norm() < 1e-15);
    }

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || {
            prop_oneof![
                4 => -2.0..2.0f64,
                1 => -1e-9..1e-9f64,
                1 => Just(0.0),
            ]
        };
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        (complex(), complex(), complex(), complex())
            .prop_map(|(xx, xy, yx, yy)| JonesMatrix::new(xx, xy, yx, yy))
    }

    proptest! {
        #[test]
        fn fields_and_stokes_vectors_tell_the_same_story(t in matrix(), x in complex(), y in complex()) {
            let field = Vector2::new(x, y);
            let by_field = stokes_vector(t.apply(field));
            let by_stokes = t.mueller() * stokes_vector(field);
            let scale = 1.0 + by_field.s0() + t.to_matrix().norm_squared();
            prop_assert!((by_field - by_stokes).to_vector().norm() < 4e-15 * scale * (1.0 + field.norm_squared()));
        }

        #[test]
        fn a_diagonal_element_is_a_diattenuating_retarder(x in complex(), y in complex()) {
            let slow = JonesMatrix::diagonal(x, y).mueller().to_matrix();
            let fast = DiattenuatingRetarder::from_amplitudes(x, y).to_mueller().to_matrix();
            prop_assert!((slow - fast).amax() < 8e-15);
        }

        #[test]
        fn sequences_reversals_and_turns_commute_with_mueller(a in matrix(), b in matrix(), angle in -4.0..4.0f64) {
            let close = |x: Mueller, y: Mueller| (x.to_matrix() - y.to_matrix()).amax() < 1e-12;
            prop_assert!(close((a * b).mueller(), a.mueller() * b.mueller()));
            prop_assert!(close(a.reversed().mueller(), a.mueller().reversed()));
            prop_assert!(close(a.rotated(angle).mueller(), a.mueller().rotated(angle)));
        }

        #[test]
        fn polarized_light_stays_polarized(t in matrix(), x in complex(), y in complex()) {
            let out = stokes_vector(t.apply(Vector2::new(x, y)));
            prop_assert!(out.is_physical(1e-14));
            prop_assert!(out.s0() == 0.0 || (out.degree_of_polarization() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn mueller_matrices_are_traces_with_the_pauli_matrices() {
        let z = |re, im| Complex64::new(re, im);
        let jones = JonesMatrix::new(z(0.3, -0.8), z(1.1, 0.2), z(-0.4, 0.5), z(0.7, 0.9));
        let (t, sigma) = (jones.to_matrix(), pauli());
        let expected =
            Matrix4::from_fn(|l, j| 0.5 * (sigma[l] * t * sigma[j] * t.adjoint()).trace().re);
        assert!((jones.mueller().to_matrix() - expected).amax() < 1e-15);
    }
}
