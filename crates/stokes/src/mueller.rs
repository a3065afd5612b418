//! The real 4×4 matrix that acts on Stokes vectors, and the four numbers that stand for most of them.

use std::ops::Mul;

use nalgebra::{Matrix4, Vector3};
use num_complex::Complex64;

use crate::frame::FrameRotation;
use crate::vector::StokesVector;

/// Mueller matrix: 4×4, dimensionless; takes `[S0, S1, S2, S3]` in the frame of the incident light to that of the
/// outgoing light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mueller(Matrix4<f64>);

impl Mueller {
    /// The matrix with these rows.
    #[must_use]
    pub fn from_rows(rows: [[f64; 4]; 4]) -> Self {
        Self(Matrix4::from_fn(|row, column| rows[row][column]))
    }

    /// Matter that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self(Matrix4::identity())
    }

    /// Ideal depolarizer that passes the fraction `transmittance` of the intensity: only element (0, 0) is not zero.
    #[must_use]
    pub fn depolarizer(transmittance: f64) -> Self {
        let mut matrix = Matrix4::zeros();
        matrix[(0, 0)] = transmittance;
        Self(matrix)
    }

    /// Change of frame: `Mueller::rotation(r) * s` equals `s.rotated(r)`.
    ///
    /// ```text
    /// 1    0     0    0
    /// 0  cos2  sin2   0
    /// 0 −sin2  cos2   0
    /// 0    0     0    1
    /// ```
    #[must_use]
    pub fn rotation(rotation: FrameRotation) -> Self {
        let FrameRotation { cos2, sin2 } = rotation;
        Self::from_rows([
            [1.0, 0.0, 0.0, 0.0],
            [0.0, cos2, sin2, 0.0],
            [0.0, -sin2, cos2, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ])
    }

    /// Element in row `row` and column `column`, both in `0..4`.
    ///
    /// # Panics
    ///
    /// When an index is not below 4.
    #[must_use]
    pub fn element(&self, row: usize, column: usize) -> f64 {
        self.0[(row, column)]
    }

    /// The matrix as nalgebra holds it.
    #[must_use]
    pub fn to_matrix(self) -> Matrix4<f64> {
        self.0
    }

    /// The same matter, written between turned frames: `M' = R(outgoing) M R(incident)ᵀ`.
    ///
    /// Each rotation leads from the frame used so far to the new one, on its side.
    #[must_use]
    pub fn in_frames(&self, incident: FrameRotation, outgoing: FrameRotation) -> Self {
        Self::rotation(outgoing) * *self * Self::rotation(incident.inverse())
    }

    /// The element itself turned by `angle` radians about the ray, counter-clockwise for a receiver who faces the
    /// source; the frames stay.
    ///
    /// ```
    /// use stokes::{Mueller, StokesVector};
    /// let polarizer = Mueller::from_rows([[0.5, 0.5, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0; 4], [0.0; 4]]);
    /// let out = polarizer.rotated(std::f64::consts::FRAC_PI_4) * StokesVector::UNPOLARIZED;
    /// assert!((out - StokesVector::DIAGONAL * 0.5).to_vector().norm() < 1e-15);
    /// ```
    #[must_use]
    pub fn rotated(&self, angle: f64) -> Self {
        let back = FrameRotation::from_angle(-angle);
        self.in_frames(back, back)
    }

    /// The matrix for light that retraces the path through reciprocal matter, `X Mᵀ X` with `X = diag(1, 1, −1, 1)`.
    ///
    /// Frames: `(x, y, z)` forward become `(x, −y, −z)` backward on each side ([`crate::Frame::reversed`]). Does
    /// not hold for magneto-optic matter.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self(Matrix4::from_fn(|row, column| {
            let sign = if (row == 2) == (column == 2) {
                1.0
            } else {
                -1.0
            };
            sign * self.0[(column, row)]
        }))
    }

    /// Whether no light gains power, forward or backward: `M00 + |(M01, M02, M03)| ≤ 1 + tolerance`, and the same
    /// for the first column.
    #[must_use]
    pub fn is_passive(&self, tolerance: f64) -> bool {
        let m = &self.0;
        let row = Vector3::new(m[(0, 1)], m[(0, 2)], m[(0, 3)]).norm();
        let column = Vector3::new(m[(1, 0)], m[(2, 0)], m[(3, 0)]).norm();
        m[(0, 0)] + row.max(column) <= 1.0 + tolerance
    }
}

impl From<Matrix4<f64>> for Mueller {
    fn from(matrix: Matrix4<f64>) -> Self {
        Self(matrix)
    }
}

/// Matter in sequence: the right factor is met first.
impl Mul for Mueller {
    type Output = Self;
    fn mul(self, first: Self) -> Self {
        Self(self.0 * first.0)
    }
}

impl Mul<f64> for Mueller {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

impl Mul<StokesVector> for Mueller {
    type Output = StokesVector;
    fn mul(self, light: StokesVector) -> StokesVector {
        StokesVector::from(self.0 * light.to_vector())
    }
}

/// Mueller matrix of any element that keeps the two axes of its frame apart: interfaces, films, linear polarizers
/// and retarders.
///
/// ```text
/// mean        difference  0        0
/// difference  mean        0        0
/// 0           0           cosine   sine
/// 0           0          −sine     cosine
/// ```
///
/// With amplitudes `x` along the first axis and `y` along the second: `mean = (|x|² + |y|²)/2`,
/// `difference = (|x|² − |y|²)/2`, `cosine + i sine = x y*` (fields in `exp(+iωt)`).
///
/// Source: Bohren & Huffman, Absorption and Scattering of Light by Small Particles, section 2.11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiattenuatingRetarder {
    /// Transmittance (or reflectance) for unpolarized light.
    pub mean: f64,
    /// Half the difference of the two axes' transmittances.
    pub difference: f64,
    /// Product of the amplitudes times the cosine of the retardance.
    pub cosine: f64,
    /// Product of the amplitudes times the sine of the retardance.
    pub sine: f64,
}

impl DiattenuatingRetarder {
    /// The element whose Jones matrix is `diag(x, y)`, in `exp(+iωt)`.
    ///
    /// ```
    /// use num_complex::Complex64;
    /// // quarter-wave plate, fast axis first: diag(1, e^{−iπ/2})
    /// let plate = stokes::DiattenuatingRetarder::from_amplitudes(Complex64::new(1.0, 0.0), Complex64::new(0.0, -1.0));
    /// let out = plate.apply(stokes::StokesVector::DIAGONAL);
    /// assert_eq!(out, stokes::StokesVector::LEFT_CIRCULAR);
    /// ```
    #[inline]
    #[must_use]
    pub fn from_amplitudes(x: Complex64, y: Complex64) -> Self {
        let (xx, yy) = (x.re * x.re + x.im * x.im, y.re * y.re + y.im * y.im);
        Self {
            mean: 0.5 * (xx + yy),
            difference: 0.5 * (xx - yy),
            cosine: x.re * y.re + x.im * y.im,
            sine: x.im * y.re - x.re * y.im,
        }
    }

    /// The element whose Jones matrix is `diag(x, y)` with real `x` and `y`.
    #[inline]
    #[must_use]
    pub fn from_real_amplitudes(x: f64, y: f64) -> Self {
        Self {
            mean: 0.5 * (x * x + y * y),
            difference: 0.5 * (x * x - y * y),
            cosine: x * y,
            sine: 0.0,
        }
    }

    /// The 4×4 matrix.
    #[must_use]
    pub fn to_mueller(self) -> Mueller {
        let Self {
            mean: a,
            difference: b,
            cosine: c,
            sine: s,
        } = self;
        Mueller::from_rows([
            [a, b, 0.0, 0.0],
            [b, a, 0.0, 0.0],
            [0.0, 0.0, c, s],
            [0.0, 0.0, -s, c],
        ])
    }

    /// What the element makes of `light` written in its frame.
    #[inline]
    #[must_use]
    pub fn apply(&self, light: StokesVector) -> StokesVector {
        StokesVector::new(
            self.mean * light.s0() + self.difference * light.s1(),
            self.difference * light.s0() + self.mean * light.s1(),
            self.cosine * light.s2() + self.sine * light.s3(),
            self.cosine * light.s3() - self.sine * light.s2(),
        )
    }
}

impl From<DiattenuatingRetarder> for Mueller {
    fn from(element: DiattenuatingRetarder) -> Self {
        element.to_mueller()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn polarizer() -> Mueller {
        DiattenuatingRetarder::from_real_amplitudes(1.0, 0.0).to_mueller()
    }

    #[test]
    fn two_polarizers_obey_malus() {
        for degrees in (0..=90).step_by(15) {
            let angle = f64::from(degrees).to_radians();
            let out = polarizer().rotated(angle) * (polarizer() * StokesVector::UNPOLARIZED);
            assert!((out.s0() - 0.5 * angle.cos().powi(2)).abs() < 1e-15);
        }
    }

    #[test]
    fn crossed_polarizers_are_dark() {
        let crossed = polarizer().rotated(std::f64::consts::FRAC_PI_2) * polarizer();
        assert!(crossed.to_matrix().amax() < 1e-16);
    }

    #[test]
    fn a_polarizer_at_an_angle_passes_light_at_that_angle() {
        for angle in [0.3, 1.2, 2.9, -0.7] {
            let light = StokesVector::linear(angle);
            let out = polarizer().rotated(angle) * light;
            assert!((out - light).to_vector().norm() < 1e-15);
        }
    }

    #[test]
    fn a_plate_seen_from_behind_is_mirrored() {
        let plate = DiattenuatingRetarder::from_amplitudes(
            Complex64::new(0.9, 0.1),
            Complex64::new(0.2, -0.6),
        )
        .to_mueller();
        let behind = plate.rotated(0.4).reversed();
        assert!((behind.to_matrix() - plate.rotated(-0.4).to_matrix()).norm() < 1e-15);
    }

    #[test]
    fn natural_activity_turns_the_same_way_from_both_sides() {
        let rotator = Mueller::rotation(FrameRotation::from_angle(0.3));
        assert_eq!(rotator.reversed(), rotator);
    }

    #[test]
    fn passivity_counts_the_best_polarized_light() {
        assert!(polarizer().is_passive(0.0));
        assert!(!(polarizer() * 1.001).is_passive(1e-4));
        assert!(
            !Mueller::from_rows([[0.8, 0.0, 0.0, 0.3], [0.0; 4], [0.0; 4], [0.0; 4]])
                .is_passive(0.0)
        );
        assert!(Mueller::depolarizer(1.0).is_passive(0.0));
    }

    proptest! {
        #[test]
        fn a_change_of_frames_is_seen_by_no_light(
            a in -4.0..4.0f64, b in -4.0..4.0f64, m in prop::array::uniform16(-1.0..1.0f64),
        ) {
            let matter = Mueller::from(Matrix4::from_column_slice(&m));
            let (a, b) = (FrameRotation::from_angle(a), FrameRotation::from_angle(b));
            let light = StokesVector::new(1.0, 0.3, -0.2, 0.4);
            let seen = matter.in_frames(a, b) * light.rotated(a);
            prop_assert!((seen - (matter * light).rotated(b)).to_vector().norm() < 1e-14);
        }

        #[test]
        fn the_four_numbers_act_as_their_matrix(n in prop::array::uniform4(-1.0..1.0f64)) {
            let element = DiattenuatingRetarder::from_amplitudes(
                Complex64::new(n[0], n[1]), Complex64::new(n[2], n[3]));
            let light = StokesVector::new(1.0, 0.3, -0.2, 0.4);
            prop_assert!((element.apply(light) - element.to_mueller() * light).to_vector().norm() < 1e-15);
        }
    }
}
