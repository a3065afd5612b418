//! The classical Stokes vector, and its pairing with the frame in which it is written.

use std::ops::{Add, Mul, Sub};

use nalgebra::Vector4;

use crate::frame::{Frame, FrameRotation};

/// Stokes vector `[S0, S1, S2, S3]`, in any unit of intensity or radiance.
///
/// Written in a transverse [`Frame`] that the caller keeps beside it ([`FramedStokes`] does so); signs as in the
/// table of the crate page. Nothing forces `S1² + S2² + S3² ≤ S0²`: sums with signed weights, such as estimates
/// and errors, are Stokes vectors too. [`StokesVector::is_physical`] asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StokesVector(Vector4<f64>);

impl StokesVector {
    /// No light.
    pub const DARK: Self = Self::new(0.0, 0.0, 0.0, 0.0);
    /// Unpolarized light of unit intensity.
    pub const UNPOLARIZED: Self = Self::new(1.0, 0.0, 0.0, 0.0);
    /// Linear light along the frame's `x`, unit intensity.
    pub const HORIZONTAL: Self = Self::new(1.0, 1.0, 0.0, 0.0);
    /// Linear light along the frame's `y`, unit intensity.
    pub const VERTICAL: Self = Self::new(1.0, -1.0, 0.0, 0.0);
    /// Linear light along `x + y`, unit intensity.
    pub const DIAGONAL: Self = Self::new(1.0, 0.0, 1.0, 0.0);
    /// Linear light along `x − y`, unit intensity.
    pub const ANTIDIAGONAL: Self = Self::new(1.0, 0.0, -1.0, 0.0);
    /// Right circular light, unit intensity: clockwise for a receiver who faces the source.
    pub const RIGHT_CIRCULAR: Self = Self::new(1.0, 0.0, 0.0, 1.0);
    /// Left circular light, unit intensity: counter-clockwise for a receiver who faces the source.
    pub const LEFT_CIRCULAR: Self = Self::new(1.0, 0.0, 0.0, -1.0);

    /// The vector `[s0, s1, s2, s3]`.
    #[must_use]
    pub const fn new(s0: f64, s1: f64, s2: f64, s3: f64) -> Self {
        Self(Vector4::new(s0, s1, s2, s3))
    }

    /// Linear light of unit intensity that vibrates at `angle` radians from `x`, counter-clockwise for a receiver
    /// who faces the source.
    #[must_use]
    pub fn linear(angle: f64) -> Self {
        let (sin2, cos2) = (2.0 * angle).sin_cos();
        Self::new(1.0, cos2, sin2, 0.0)
    }

    /// Total intensity, `S0`.
    #[inline]
    #[must_use]
    pub fn s0(&self) -> f64 {
        self.0.x
    }

    /// Horizontal minus vertical intensity, `S1`.
    #[inline]
    #[must_use]
    pub fn s1(&self) -> f64 {
        self.0.y
    }

    /// Intensity along `x + y` minus that along `x − y`, `S2`.
    #[inline]
    #[must_use]
    pub fn s2(&self) -> f64 {
        self.0.z
    }

    /// Right minus left circular intensity, `S3`.
    #[inline]
    #[must_use]
    pub fn s3(&self) -> f64 {
        self.0.w
    }

    /// The four numbers as an nalgebra vector.
    #[must_use]
    pub fn to_vector(self) -> Vector4<f64> {
        self.0
    }

    /// The four numbers as an array.
    #[must_use]
    pub fn to_array(self) -> [f64; 4] {
        self.0.into()
    }

    /// The same light written in a frame turned by `rotation`.
    ///
    /// ```
    /// use stokes::{FrameRotation, StokesVector};
    /// // horizontal light, written in axes turned by +45°, lies on their −45° diagonal
    /// let turned = StokesVector::HORIZONTAL.rotated(FrameRotation { cos2: 0.0, sin2: 1.0 });
    /// assert_eq!(turned, StokesVector::ANTIDIAGONAL);
    /// ```
    #[inline]
    #[must_use]
    pub fn rotated(&self, rotation: FrameRotation) -> Self {
        let FrameRotation { cos2, sin2 } = rotation;
        Self::new(
            self.s0(),
            cos2 * self.s1() + sin2 * self.s2(),
            cos2 * self.s2() - sin2 * self.s1(),
            self.s3(),
        )
    }

    /// Whether light of this kind exists: `S0 ≥ 0` and `S1² + S2² + S3² ≤ S0²`, with a slack of `tolerance · S0`.
    #[must_use]
    pub fn is_physical(&self, tolerance: f64) -> bool {
        self.s0() >= 0.0 && self.polarized_intensity() <= self.s0() * (1.0 + tolerance)
    }
}

impl From<[f64; 4]> for StokesVector {
    fn from([s0, s1, s2, s3]: [f64; 4]) -> Self {
        Self::new(s0, s1, s2, s3)
    }
}

impl From<Vector4<f64>> for StokesVector {
    fn from(v: Vector4<f64>) -> Self {
        Self(v)
    }
}

/// Incoherent superposition: intensities add.
impl Add for StokesVector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for StokesVector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul<f64> for StokesVector {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

/// A Stokes vector together with its frame: light on one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramedStokes {
    /// The four numbers, written in `frame`.
    pub stokes: StokesVector,
    /// The frame they are written in; its `z` is the direction of the light.
    pub frame: Frame,
}

impl FramedStokes {
    /// The same light written in `frame`, which must belong to the same ray.
    ///
    /// # Panics
    ///
    /// In debug builds, when the frame belongs to another direction.
    #[must_use]
    pub fn in_frame(&self, frame: Frame) -> Self {
        Self {
            stokes: self.stokes.rotated(self.frame.rotation_to(&frame)),
            frame,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    #[test]
    fn light_along_a_turned_axis_is_horizontal_there() {
        let frame = Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap();
        let angle = 0.4;
        let light = FramedStokes {
            stokes: StokesVector::linear(angle),
            frame,
        };
        let seen = light.in_frame(frame.turned(angle)).stokes;
        assert!((seen - StokesVector::HORIZONTAL).to_vector().norm() < 1e-15);
    }

    #[test]
    fn adding_orthogonal_states_gives_unpolarized_light() {
        for (a, b) in [
            (StokesVector::HORIZONTAL, StokesVector::VERTICAL),
            (StokesVector::DIAGONAL, StokesVector::ANTIDIAGONAL),
            (StokesVector::RIGHT_CIRCULAR, StokesVector::LEFT_CIRCULAR),
        ] {
            assert_eq!(a + b, StokesVector::UNPOLARIZED * 2.0);
        }
    }

    proptest! {
        #[test]
        fn frames_change_neither_degree_nor_handedness(
            s in prop::array::uniform3(-1.0..1.0f64), angle in -10.0..10.0f64,
        ) {
            let light = StokesVector::new(2.0, s[0], s[1], s[2]);
            let turned = light.rotated(FrameRotation::from_angle(angle));
            prop_assert_eq!(turned.s3(), light.s3());
            prop_assert!((turned.degree_of_polarization() - light.degree_of_polarization()).abs() < 1e-15);
            let back = turned.rotated(FrameRotation::from_angle(-angle));
            prop_assert!((back - light).to_vector().norm() < 1e-14);
        }
    }
}
