//! What linear polarization a sensor sees through a path: matter that reflects and transmits chooses by it.

use glam::{Vec2, Vec3A, vec2};

use super::frames::double_angle;

/// Which linearly polarized light makes more S0 at the sensor than unpolarized light does.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// First axis of its frame, across the ray.
    axis: Vec3A,
    /// S0 at the sensor that unit S1 and S2 make, over that of unit S0: at most 1 long.
    linear: Vec2,
}

impl Sight {
    /// All light looks alike.
    pub const BLIND: Self = Self {
        axis: Vec3A::X,
        linear: Vec2::ZERO,
    };

    /// From S0 at the sensor that unit S0, S1 and S2 make, in the frame of `axis`.
    #[inline]
    pub fn new(axis: Vec3A, [all, linear @ ..]: [f32; 3]) -> Self {
        let linear = Vec2::from(linear) / all;
        if all > 0.0 && linear.is_finite() {
            let linear = linear.clamp_length_max(1.0);
            Self { axis, linear }
        } else {
            Self::BLIND
        }
    }

    /// With its axis turned, into a surface's frame say.
    #[inline]
    #[must_use]
    pub fn map_axis(self, turn: impl Fn(Vec3A) -> Vec3A) -> Self {
        Self {
            axis: turn(self.axis),
            ..self
        }
    }

    /// How much rather it sees light polarized along `axis` than across it, −1 to 1; `k` is the light's direction.
    #[inline]
    pub fn along(&self, axis: Vec3A, k: Vec3A) -> f32 {
        if self.linear == Vec2::ZERO {
            return 0.0;
        }
        let (cos, sin) = double_angle(self.axis, axis, k);
        self.linear.dot(vec2(cos, sin))
    }
}
