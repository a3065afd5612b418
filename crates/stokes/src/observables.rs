//! What one reads off a Stokes vector: degrees of polarization, angles, the ellipse.
//!
//! No degree is clamped: noise and signed sums may exceed 1, and hiding it would bias means. Light without
//! intensity (`S0 ≤ 0`) has degree 0 by definition, and light without a polarized part has angles 0 and handedness
//! [`Handedness::Linear`].

use std::f64::consts::FRAC_PI_2;

use crate::plane;
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

    /// Degree of polarization `√(S1² + S2² + S3²)/S0`; in `0.0..=1.0` for light that exists, 0 for dark light.
    ///
    /// Source: Eq. (S4.4).
    ///
    /// ```
    /// let light = stokes::StokesVector::new(2.0, 0.6, 0.0, 0.8);
    /// assert_eq!(light.degree_of_polarization(), 0.5);
    /// ```
    #[must_use]
    pub fn degree_of_polarization(&self) -> f64 {
        self.per_intensity(self.polarized_intensity())
    }

    /// Degree of linear polarization `√(S1² + S2²)/S0`; in `0.0..=1.0` for light that exists, 0 for dark light.
    #[must_use]
    pub fn degree_of_linear_polarization(&self) -> f64 {
        self.per_intensity(self.linear_intensity())
    }

    /// Degree of circular polarization `S3/S0`, positive for right-handed light; in `-1.0..=1.0` for light that exists, 0
    /// for dark light.
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
        plane::axis_angle(self.orientation_angle())
    }

    /// Ellipticity angle `½ atan2(S3, √(S1² + S2²))`, radians in `[-π/4, π/4]`, positive for right-handed light.
    ///
    /// Stable at both ends: no difference of nearly equal numbers is taken.
    ///
    /// Source: Born & Wolf, Principles of Optics, 7th ed., section 1.4.2.
    #[must_use]
    pub fn ellipticity_angle(&self) -> f64 {
        0.5 * self.s3().atan2(self.linear_intensity())
    }

    /// The ellipse of the polarized part.
    ///
    /// Source: Eq. (S4.10), corrected; Born & Wolf, Principles of Optics, 7th ed., section 1.4.2, with
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
