//! What one reads off a Stokes vector: degrees of polarization, angles, the ellipse.
//!
//! No degree is clamped: noise and signed sums may exceed 1, and hiding it would bias means. Light without
//! intensity (`S0 ≤ 0`) has degree 0 by definition, and light without a polarized part has angles 0 and handedness
//! [`Handedness::Linear`].

use std::f64::consts::{FRAC_PI_2, PI};

use crate::vector::StokesVector;

/// Sense in which the tip of the field turns, for a receiver who faces the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handedness {
    /// Clockwise, `S3 > 0`.
    Right,
    /// Counter-clockwise, `S3 < 0`.
    Left,
    /// Neither: `|S3|` is below 8 roundings of the polarized part, or there is no polarized part.
    Linear,
}

/// The ellipse that the field of the polarized part draws in the transverse plane.
///
/// Axes in the square root of the unit of `S0`; angles in radians, in the vector's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarizationEllipse {
    /// Semi-major axis; its square plus that of the minor one is the intensity of the polarized part.
    pub semi_major: f64,
    /// Semi-minor axis, not negative.
    pub semi_minor: f64,
    /// Angle of the major axis from `x`, in `[0, π)`.
    pub orientation: f64,
    /// Ellipticity angle, in `[-π/4, π/4]`; its tangent is the minor over the major axis, positive for right.
    pub ellipticity: f64,
    /// Sense of rotation.
    pub handedness: Handedness,
}

impl StokesVector {
    /// Total intensity `S0`, in the vector's unit.
    #[must_use]
    pub fn intensity(&self) -> f64 {
        self.s0()
    }

    /// Intensity of the polarized part, `√(S1² + S2² + S3²)`, without overflow.
    #[must_use]
    pub fn polarized_intensity(&self) -> f64 {
        self.linear_intensity().hypot(self.s3())
    }

    /// Intensity of the linearly polarized part, `√(S1² + S2²)`, without overflow.
    #[must_use]
    pub fn linear_intensity(&self) -> f64 {
        self.s1().hypot(self.s2())
    }

    fn per_intensity(&self, part: f64) -> f64 {
        if self.s0() > 0.0 {
            part / self.s0()
        } else {
            0.0
        }
    }

    /// Degree of polarization `√(S1² + S2² + S3²)/S0`; 0 for dark light.
    ///
    /// ```
    /// let light = stokes::StokesVector::new(2.0, 0.6, 0.0, 0.8);
    /// assert_eq!(light.degree_of_polarization(), 0.5);
    /// ```
    #[must_use]
    pub fn degree_of_polarization(&self) -> f64 {
        self.per_intensity(self.polarized_intensity())
    }

    /// Degree of linear polarization `√(S1² + S2²)/S0`; 0 for dark light.
    #[must_use]
    pub fn degree_of_linear_polarization(&self) -> f64 {
        self.per_intensity(self.linear_intensity())
    }

    /// Degree of circular polarization `S3/S0`, positive for right-handed light; 0 for dark light.
    #[must_use]
    pub fn degree_of_circular_polarization(&self) -> f64 {
        self.per_intensity(self.s3())
    }

    /// Intensity of the unpolarized part, `S0 − √(S1² + S2² + S3²)`; negative where the vector lies outside the cone.
    ///
    /// Evaluated as `(S0² − S1² − S2² − S3²)/(S0 + p)` with the numerator's rounding errors carried along, so that it
    /// keeps its digits as the light becomes fully polarized: relative error of a few `f64::EPSILON` down to
    /// `1e-16 S0`, absolute error below `1e-31 S0` beyond. Zero exactly where the four numbers lie on the cone.
    ///
    /// ```
    /// let light = stokes::StokesVector::new(1.0, 1.0 - 2f64.powi(-50), 0.0, 0.0);
    /// assert_eq!(light.unpolarized_intensity(), 2f64.powi(-50));
    /// ```
    #[must_use]
    pub fn unpolarized_intensity(&self) -> f64 {
        let polarized = self.polarized_intensity();
        if self.s0() > 0.0 && polarized.is_finite() {
            self.cone_form_over(polarized)
        } else {
            self.s0() - polarized
        }
    }

    /// Eigenvalues of the coherency matrix `⟨E_i E_j*⟩`, the larger first: `(S0 ± √(S1² + S2² + S3²))/2`.
    ///
    /// In the unit of `S0`. The one that would cancel is evaluated as [`StokesVector::unpolarized_intensity`]. Light
    /// exists when neither is negative.
    ///
    /// Source: Born & Wolf, Principles of Optics, 7th ed., section 10.9.2.
    ///
    /// ```
    /// let light = stokes::StokesVector::new(2.0, 0.6, 0.0, 0.8);
    /// assert_eq!(light.eigenvalues(), [1.5, 0.5]);
    /// ```
    #[must_use]
    pub fn eigenvalues(&self) -> [f64; 2] {
        let polarized = self.polarized_intensity();
        let larger = if self.s0() < 0.0 && polarized.is_finite() {
            -(*self * -1.0).cone_form_over(polarized)
        } else {
            self.s0() + polarized
        };
        [0.5 * larger, 0.5 * self.unpolarized_intensity()]
    }

    /// `(S0² − S1² − S2² − S3²)/(S0 + polarized)`, `S0` positive and `polarized` finite, without overflow.
    fn cone_form_over(&self, polarized: f64) -> f64 {
        let exponent = libm::ilogb(self.to_vector().amax());
        let [s0, s1, s2, s3] = self.to_array().map(|s| libm::scalbn(s, -exponent));
        // each square and each sum with its rounding error
        let (mut sum, mut error) = (s0 * s0, s0.mul_add(s0, -(s0 * s0)));
        for s in [s1, s2, s3] {
            let square = s * s;
            let next = sum - square;
            let back = next - sum;
            error += (sum - (next - back)) - (square + back) - s.mul_add(s, -square);
            sum = next;
        }
        libm::scalbn(
            (sum + error) / (s0 + libm::scalbn(polarized, -exponent)),
            exponent,
        )
    }

    /// Orientation of the polarization ellipse, `½ atan2(S2, S1)`, radians from `x` in `(-π/2, π/2]`, positive towards
    /// `y`; 0 where there is no linear part.
    ///
    /// Source: Eq. (S4.11), with the quadrant that its printed arctangent loses. Error below 4e-16 for any state.
    ///
    /// ```
    /// let light = stokes::StokesVector::new(1.0, 0.3, -0.2, 0.5);
    /// assert!((light.orientation_angle() + 0.294_001_301_773_783_8).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn orientation_angle(&self) -> f64 {
        if self.s1() == 0.0 && self.s2() == 0.0 {
            return 0.0;
        }
        let half = 0.5 * self.s2().atan2(self.s1());
        // S2 = −0 and S2 below the rounding of π
        if half > -FRAC_PI_2 { half } else { FRAC_PI_2 }
    }

    /// Angle of linear polarization, [`StokesVector::orientation_angle`] modulo π, in `[0, π)`; 0 where there is no
    /// linear part.
    ///
    /// Error below 4e-16 for any state.
    #[must_use]
    pub fn angle_of_linear_polarization(&self) -> f64 {
        let half = self.orientation_angle();
        let angle = if half < 0.0 { half + PI } else { half };
        // a negative angle below the rounding of π wraps to 0
        if angle < PI { angle } else { 0.0 }
    }

    /// Ellipticity angle `½ atan2(S3, √(S1² + S2²))`, radians in `[-π/4, π/4]`, positive for right-handed light.
    ///
    /// Stable at both ends: no difference of nearly equal numbers is taken.
    #[must_use]
    pub fn ellipticity_angle(&self) -> f64 {
        0.5 * self.s3().atan2(self.linear_intensity())
    }

    /// The ellipse of the polarized part.
    ///
    /// Source: Born & Wolf, Principles of Optics, 7th ed., section 1.4.2 with
    /// `a² = (p + l)/2`, `b² = (p − l)/2`, `p` the polarized and `l` the linear intensity; `b` is evaluated as
    /// `|S3|/√(2(p + l))`, which does not cancel as the light becomes linear.
    ///
    /// ```
    /// use stokes::{Handedness, StokesVector};
    /// let ellipse = StokesVector::new(1.0, 0.6, 0.0, -0.8).ellipse();
    /// assert!((ellipse.semi_major - 0.8f64.sqrt()).abs() < 1e-15);
    /// assert!((ellipse.semi_minor - 0.2f64.sqrt()).abs() < 1e-15);
    /// assert_eq!(ellipse.handedness, Handedness::Left);
    /// ```
    #[must_use]
    pub fn ellipse(&self) -> PolarizationEllipse {
        let polarized = self.polarized_intensity();
        let twice_major = (2.0 * (polarized + self.linear_intensity())).sqrt();
        let semi_minor = if twice_major > 0.0 {
            self.s3().abs() / twice_major
        } else {
            0.0
        };
        let handedness = if self.s3().abs() <= 8.0 * f64::EPSILON * polarized {
            Handedness::Linear
        } else if self.s3() > 0.0 {
            Handedness::Right
        } else {
            Handedness::Left
        };
        PolarizationEllipse {
            semi_major: 0.5 * twice_major,
            semi_minor,
            orientation: self.angle_of_linear_polarization(),
            ellipticity: self.ellipticity_angle(),
            handedness,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_4;

    /// Samples the real field `Re[(ax, ay e^{iφ}) e^{iωt}]` over a period: an oracle without Stokes parameters.
    fn field(ax: f64, ay: f64, phase: f64) -> Vec<[f64; 2]> {
        (0..7200)
            .map(|i| {
                let wt = 2.0 * PI * f64::from(i) / 7200.0;
                [ax * wt.cos(), ay * (wt + phase).cos()]
            })
            .collect()
    }

    /// Stokes parameters as six intensity measurements would give them, circular ones by sense of rotation.
    fn stokes_of(ax: f64, ay: f64, phase: f64) -> StokesVector {
        StokesVector::new(
            ax * ax + ay * ay,
            ax * ax - ay * ay,
            2.0 * ax * ay * phase.cos(),
            2.0 * ax * ay * phase.sin(),
        )
    }

    #[test]
    fn the_ellipse_is_the_one_that_the_field_draws() {
        for (ax, ay, phase) in [
            (1.0, 0.4, 0.7),
            (0.3, 1.2, -2.0),
            (1.0, 1.0, FRAC_PI_2),
            (0.8, 0.8, -0.3),
        ] {
            let points = field(ax, ay, phase);
            let length = |p: &[f64; 2]| p[0].hypot(p[1]);
            let longest = points
                .iter()
                .max_by(|a, b| length(a).total_cmp(&length(b)))
                .expect("the field has points");
            let shortest = points.iter().map(length).fold(f64::INFINITY, f64::min);
            // twice the signed area swept: positive when counter-clockwise for x right, y up
            let area: f64 = points
                .iter()
                .zip(points.iter().cycle().skip(1))
                .map(|(p, q)| p[0] * q[1] - p[1] * q[0])
                .sum();
            let ellipse = stokes_of(ax, ay, phase).ellipse();
            // 7200 samples place an extremum within 4.4e-4 rad: lengths to 1e-7
            assert!((ellipse.semi_major - length(longest)).abs() < 1e-6);
            assert!((ellipse.semi_minor - shortest).abs() < 1e-6);
            let clockwise = area < 0.0;
            assert_eq!(ellipse.handedness == Handedness::Right, clockwise);
            if ellipse.semi_major - ellipse.semi_minor > 1e-3 {
                let psi = longest[1].atan2(longest[0]).rem_euclid(PI);
                assert!((ellipse.orientation - psi).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn named_states_have_their_angles() {
        let angle = |s: StokesVector| s.angle_of_linear_polarization();
        assert_eq!(angle(StokesVector::HORIZONTAL), 0.0);
        assert_eq!(angle(StokesVector::DIAGONAL), FRAC_PI_4);
        assert_eq!(angle(StokesVector::VERTICAL), FRAC_PI_2);
        assert_eq!(angle(StokesVector::ANTIDIAGONAL), 3.0 * FRAC_PI_4);
        assert_eq!(StokesVector::RIGHT_CIRCULAR.ellipticity_angle(), FRAC_PI_4);
        assert_eq!(StokesVector::LEFT_CIRCULAR.ellipticity_angle(), -FRAC_PI_4);
    }

    #[test]
    fn dark_and_unpolarized_light_have_no_ellipse() {
        for light in [
            StokesVector::DARK,
            StokesVector::UNPOLARIZED,
            StokesVector::new(1.0, -0.0, 0.0, -0.0),
        ] {
            assert_eq!(light.degree_of_polarization(), 0.0);
            assert_eq!(light.degree_of_circular_polarization(), 0.0);
            let ellipse = light.ellipse();
            assert_eq!((ellipse.semi_major, ellipse.semi_minor), (0.0, 0.0));
            assert_eq!((ellipse.orientation, ellipse.ellipticity), (0.0, 0.0));
            assert_eq!(ellipse.handedness, Handedness::Linear);
        }
    }

    #[test]
    fn a_thin_ellipse_keeps_its_minor_axis() {
        // b/a = tan χ ≈ S3/2 for unit linear light; (p − l)/2 would cancel to 0 here
        let ellipse = StokesVector::new(1.0, 1.0, 0.0, 1e-9).ellipse();
        assert!((ellipse.semi_minor / 0.5e-9 - 1.0).abs() < 1e-14);
        assert_eq!(ellipse.handedness, Handedness::Right);
    }

    #[test]
    fn an_angle_just_below_zero_wraps_below_pi() {
        let angle = StokesVector::new(1.0, 1.0, -1e-300, 0.0).angle_of_linear_polarization();
        assert!((0.0..PI).contains(&angle));
    }

    #[test]
    fn orientation_keeps_the_quadrant() {
        let angle = |s1: f64, s2: f64| StokesVector::new(1.0, s1, s2, 0.2).orientation_angle();
        assert_eq!(angle(-0.5, 0.0), FRAC_PI_2);
        assert_eq!(angle(-0.5, -0.0), FRAC_PI_2);
        assert_eq!(angle(-0.5, -1e-300), FRAC_PI_2);
        assert_eq!(angle(0.0, -0.5), -FRAC_PI_4);
        assert_eq!(angle(-0.0, -0.0), 0.0);
        // printed without its quadrant this would be −π/8
        assert_eq!(angle(-0.3, 0.3), 3.0 * FRAC_PI_4 / 2.0);
    }

    #[test]
    fn almost_polarized_light_keeps_its_smaller_eigenvalue() {
        // Pythagorean quadruple 2² + 3² + 6² = 7²: exactly on the cone
        let on_cone = StokesVector::new(7.0, 2.0, 3.0, 6.0);
        assert_eq!(on_cone.unpolarized_intensity(), 0.0);
        assert_eq!(on_cone.eigenvalues(), [7.0, 0.0]);
        // 7 + e above it: S0 − p = e exactly, for any e that 7 + e still holds
        for e in [1e-3, 1e-9, 8.0 * f64::EPSILON, -8.0 * f64::EPSILON] {
            let s0 = 7.0 + e;
            let unpolarized = StokesVector::new(s0, 2.0, 3.0, 6.0).unpolarized_intensity();
            let expected = s0 - 7.0;
            assert!((unpolarized / expected - 1.0).abs() <= 2.0 * f64::EPSILON);
        }
        // S3 → 0 and units in which no square is a number
        for scale in [1e-250, 1.0, 1e300] {
            let [larger, smaller] = (StokesVector::new(1.0, 1.0, 0.0, 1e-9) * scale).eigenvalues();
            // √(1 + 1e-18) = 1 + 5e-19
            assert!((larger / scale - 1.0).abs() <= f64::EPSILON);
            assert!((smaller / scale / -2.5e-19 - 1.0).abs() <= 8.0 * f64::EPSILON);
        }
        assert_eq!(StokesVector::DARK.eigenvalues(), [0.0, 0.0]);
        // the mirror image in the cone's tip
        let negative = StokesVector::new(-7.0 - 1e-9, 2.0, 3.0, 6.0).eigenvalues();
        let positive = StokesVector::new(7.0 + 1e-9, 2.0, 3.0, 6.0).eigenvalues();
        assert_eq!(negative, [-positive[1], -positive[0]]);
    }

    proptest! {
        #[test]
        fn eigenvalues_are_those_of_the_coherency_matrix(
            s in prop::array::uniform3(prop_oneof![-1.0..1.0f64, -1e-9..1e-9]),
            above in prop_oneof![-1.0..2.0f64, -1e-12..1e-12, Just(0.0)],
        ) {
            let p = StokesVector::new(0.0, s[0], s[1], s[2]).polarized_intensity();
            let light = StokesVector::new(p + above, s[0], s[1], s[2]);
            let [larger, smaller] = light.eigenvalues();
            // trace, and determinant xx·yy − |xy|² in an order of its own
            let (xx, yy) = (0.5 * (light.s0() + s[0]), 0.5 * (light.s0() - s[0]));
            let det = xx * yy - 0.25 * (s[1] * s[1] + s[2] * s[2]);
            let scale = light.s0().abs() + p;
            prop_assert!((larger + smaller - xx - yy).abs() <= 4.0 * f64::EPSILON * scale);
            prop_assert!((larger * smaller - det).abs() <= 4.0 * f64::EPSILON * scale * scale);
            prop_assert!(larger >= smaller);
        }

        #[test]
        fn near_the_cone_the_unpolarized_part_is_that_of_exact_arithmetic(
            s in prop::array::uniform3(-(1i64 << 50)..1 << 50), above in -5i64..=5,
        ) {
            let [s1, s2, s3] = s.map(|s| s as f64);
            let p = StokesVector::new(0.0, s1, s2, s3).polarized_intensity();
            let s0 = p.round() as i64 + above;
            let square = |s: i64| i128::from(s) * i128::from(s);
            let form = square(s0) - s.map(square).iter().sum::<i128>();
            let light = StokesVector::new(s0 as f64, s1, s2, s3);
            let expected = form as f64 / (s0 as f64 + p);
            // p, sum and quotient round once each, the form twice, and 1e-31 of S0 is left of its squares
            let tolerance = 8.0 * f64::EPSILON * expected.abs() + 1e-31 * s0 as f64;
            prop_assert!((light.unpolarized_intensity() - expected).abs() <= tolerance);
        }

        #[test]
        fn ellipse_and_vector_say_the_same(
            psi in 0.0..PI,
            chi in prop_oneof![-FRAC_PI_4..FRAC_PI_4, -1e-12..1e-12, Just(FRAC_PI_4)],
            degree in prop_oneof![1e-12..1.0f64, Just(1.0)],
        ) {
            let light = StokesVector::new(
                3.0,
                3.0 * degree * (2.0 * chi).cos() * (2.0 * psi).cos(),
                3.0 * degree * (2.0 * chi).cos() * (2.0 * psi).sin(),
                3.0 * degree * (2.0 * chi).sin(),
            );
            let e = light.ellipse();
            prop_assert!((light.degree_of_polarization() / degree - 1.0).abs() < 1e-14);
            prop_assert!((e.ellipticity - chi).abs() < 1e-15);
            prop_assert!((e.semi_minor - e.semi_major * chi.abs().tan()).abs() < 2e-15);
            let power = e.semi_major.powi(2) + e.semi_minor.powi(2);
            prop_assert!((power / (3.0 * degree) - 1.0).abs() < 1e-14);
            // the direction of a nearly circular ellipse is lost with its linear part
            let off = (e.orientation - psi + 0.5 * PI).rem_euclid(PI) - 0.5 * PI;
            prop_assert!(off.abs() * (2.0 * chi).cos() < 1e-15 * 4.0);
        }
    }
}
