//! Right-handed transverse frames, and the rotation from one to another about the same ray.
//!
//! No trigonometry: a rotation of the Stokes frame needs only the cosine and sine of twice the angle, and both
//! are polynomials in dot products of the axes.

use nalgebra::Vector3;
use thiserror::Error;

/// Why two directions do not make a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// The propagation vector is zero or not finite.
    #[error("frame: the propagation vector is zero or not finite, expected a direction")]
    NoPropagation,
    /// The reference vector is zero, not finite, or parallel to the propagation.
    #[error(
        "frame: the reference vector is zero, not finite or parallel to the propagation, expected a direction across it"
    )]
    NoReference,
}

/// The frame in which a Stokes vector is written: unit vectors `x`, `y = z × x`, and `z` along the propagation of
/// the *light*.
///
/// `S1 > 0` is light whose field vibrates along `x`, `S2 > 0` along `x + y`. Angles are counter-clockwise about
/// `z`, that is, counter-clockwise for an observer who faces the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    x: Vector3<f64>,
    y: Vector3<f64>,
    z: Vector3<f64>,
}

impl Frame {
    /// The frame whose `x` axis is `reference` projected across `propagation`.
    ///
    /// Neither vector has to be of unit length, nor perpendicular to the other.
    ///
    /// # Errors
    ///
    /// When a vector is zero or not finite, or the two are parallel (sine of their angle below 1e-12).
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// let frame = stokes::Frame::with_x_along(Vector3::z(), Vector3::new(2.0, 0.0, 5.0))?;
    /// assert_eq!(frame.x(), Vector3::x());
    /// assert_eq!(frame.y(), Vector3::y());
    /// # Ok::<(), stokes::FrameError>(())
    /// ```
    pub fn with_x_along(
        propagation: Vector3<f64>,
        reference: Vector3<f64>,
    ) -> Result<Self, FrameError> {
        let z = unit(propagation).ok_or(FrameError::NoPropagation)?;
        let reference = unit(reference).ok_or(FrameError::NoReference)?;
        let across = z.cross(&reference);
        if across.norm() < 1e-12 {
            return Err(FrameError::NoReference);
        }
        let y = across.normalize();
        Ok(Self {
            x: y.cross(&z),
            y,
            z,
        })
    }

    /// The frame whose `x` axis is `reference × propagation`, hence perpendicular to the plane of the two.
    ///
    /// With a surface normal as reference, `x` is the s axis of the plane of incidence and `y` the p axis. With a
    /// camera's up vector, `x` points to the right of the image and `y` up, as an observer who faces the light
    /// sees it.
    ///
    /// # Errors
    ///
    /// As [`Frame::with_x_along`].
    pub fn with_x_across(
        propagation: Vector3<f64>,
        reference: Vector3<f64>,
    ) -> Result<Self, FrameError> {
        let up = Self::with_x_along(propagation, reference)?;
        Ok(Self {
            x: -up.y,
            y: up.x,
            z: up.z,
        })
    }

    /// First transverse axis, unit length.
    #[must_use]
    pub fn x(&self) -> Vector3<f64> {
        self.x
    }

    /// Second transverse axis, `z × x`, unit length.
    #[must_use]
    pub fn y(&self) -> Vector3<f64> {
        self.y
    }

    /// Direction in which the light travels, unit length.
    #[must_use]
    pub fn z(&self) -> Vector3<f64> {
        self.z
    }

    /// This frame turned by `angle` radians, counter-clockwise about its propagation.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            x: self.x * cos + self.y * sin,
            y: self.y * cos - self.x * sin,
            z: self.z,
        }
    }

    /// The frame of light that retraces the ray: `(x, −y, −z)`, as reciprocity wants it.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            x: self.x,
            y: -self.y,
            z: -self.z,
        }
    }

    /// The rotation that takes this frame to `other`, which must belong to the same ray.
    ///
    /// From dot products only; error of a few `f64::EPSILON`.
    ///
    /// # Panics
    ///
    /// In debug builds, when the two propagation directions differ by more than 1e-6.
    #[inline]
    #[must_use]
    pub fn rotation_to(&self, other: &Self) -> FrameRotation {
        debug_assert!(
            (self.z - other.z).norm() < 1e-6,
            "frames of two different rays"
        );
        FrameRotation::from_axis(self.x.dot(&other.x), self.y.dot(&other.x))
    }
}

fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = v.amax();
    if !largest.is_finite() || largest == 0.0 {
        return None;
    }
    Some((v / largest).normalize())
}

/// Rotation of a transverse frame, as the cosine and sine of *twice* the angle from the old to the new `x` axis,
/// counter-clockwise about the propagation.
///
/// ```text
/// S1' =  cos2 S1 + sin2 S2
/// S2' = −sin2 S1 + cos2 S2        S0, S3 unchanged
/// ```
///
/// Source: Goldstein, Polarized Light, 3rd ed., chapter 6 (the rotator), with the sense of rotation above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRotation {
    /// Cosine of twice the angle.
    pub cos2: f64,
    /// Sine of twice the angle.
    pub sin2: f64,
}

impl FrameRotation {
    /// The rotation by nothing.
    pub const IDENTITY: Self = Self {
        cos2: 1.0,
        sin2: 0.0,
    };

    /// The rotation by `angle` radians.
    #[must_use]
    pub fn from_angle(angle: f64) -> Self {
        let (sin2, cos2) = (2.0 * angle).sin_cos();
        Self { cos2, sin2 }
    }

    /// The rotation to a new `x` axis with components `along_x`, `along_y` in the old frame (any length but zero;
    /// both signs of the axis are the same rotation).
    #[inline]
    #[must_use]
    pub fn from_axis(along_x: f64, along_y: f64) -> Self {
        let (xx, yy) = (along_x * along_x, along_y * along_y);
        let scale = 1.0 / (xx + yy);
        Self {
            cos2: (xx - yy) * scale,
            sin2: 2.0 * along_x * along_y * scale,
        }
    }

    /// The rotation back.
    #[inline]
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            cos2: self.cos2,
            sin2: -self.sin2,
        }
    }

    /// This rotation followed by `next`.
    #[inline]
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self {
            cos2: self.cos2 * next.cos2 - self.sin2 * next.sin2,
            sin2: self.sin2 * next.cos2 + self.cos2 * next.sin2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn frames_are_right_handed() {
        let frame =
            Frame::with_x_along(Vector3::new(1.0, 2.0, -3.0), Vector3::new(0.0, 1.0, 0.5)).unwrap();
        assert!((frame.x().cross(&frame.y()) - frame.z()).norm() < 1e-15);
        let back = frame.reversed();
        assert!((back.x().cross(&back.y()) - back.z()).norm() < 1e-15);
    }

    #[test]
    fn a_camera_sees_x_to_the_right_and_y_up() {
        // a camera that looks along −z with +y up: light travels along +z, world +x is at the right
        let frame = Frame::with_x_across(Vector3::z(), Vector3::y()).unwrap();
        assert_eq!(frame.x(), Vector3::x());
        assert_eq!(frame.y(), Vector3::y());
    }

    #[test]
    fn the_first_axis_at_a_surface_is_perpendicular_to_the_plane_of_incidence() {
        let (k, n) = (Vector3::new(0.6, 0.0, -0.8), Vector3::z());
        let frame = Frame::with_x_across(k, n).unwrap();
        assert!((frame.x() - n.cross(&k).normalize()).norm() < 1e-15);
    }

    #[test]
    fn parallel_vectors_make_no_frame() {
        let z = Vector3::z();
        assert_eq!(
            Frame::with_x_along(z, -2.0 * z),
            Err(FrameError::NoReference)
        );
        assert_eq!(
            Frame::with_x_across(Vector3::zeros(), z),
            Err(FrameError::NoPropagation)
        );
        assert_eq!(
            Frame::with_x_along(z, Vector3::new(f64::NAN, 0.0, 0.0)),
            Err(FrameError::NoReference)
        );
    }

    proptest! {
        #[test]
        fn dot_products_give_the_angle_between_frames(
            angle in prop_oneof![-7.0..7.0, -1e-9..1e-9, Just(std::f64::consts::FRAC_PI_2)],
            px in -1.0..1.0f64, py in -1.0..1.0f64,
        ) {
            let frame = Frame::with_x_along(Vector3::new(px, py, 1.0), Vector3::x()).unwrap();
            let found = frame.rotation_to(&frame.turned(angle));
            let expected = FrameRotation::from_angle(angle);
            prop_assert!((found.cos2 - expected.cos2).abs() < 4e-15);
            prop_assert!((found.sin2 - expected.sin2).abs() < 4e-15);
        }

        #[test]
        fn there_and_back_is_no_rotation(a in -4.0..4.0f64, b in -4.0..4.0f64) {
            let (a, b) = (FrameRotation::from_angle(a), FrameRotation::from_angle(b));
            let none = a.then(b).then(b.inverse()).then(a.inverse());
            prop_assert!((none.cos2 - 1.0).abs() < 4e-15 && none.sin2.abs() < 4e-15);
        }
    }
}
