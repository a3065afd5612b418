//! `constant`: surroundings of the same radiance in all directions.
//!
//! | parameter  | type     | meaning                | default |
//! |------------|----------|------------------------|---------|
//! | `radiance` | spectrum | W/(m² sr) | 1       |
//!
//! ```xml
//! <emitter type="constant"><float name="radiance" value="0.2"/></emitter>
//! ```

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::Connection;
use crate::geometry::frame::Frame;
use crate::lights::Glance;
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// Constant surroundings.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Radiance.
    pub radiance: Spectrum,
}

impl Constant {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            radiance: object.spectrum(
                "radiance",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
        })
    }

    /// By the cosine at the vertex: matter that reflects sees nothing of the other half.
    #[inline]
    pub(super) fn connect(&self, frame: &Frame, u: [f32; 2]) -> Option<Connection> {
        let local = cosine_hemisphere(u);
        let density = local.z * FRAC_1_PI;
        (density > 0.0)
            .then(|| Connection::to_point((frame.to_world(local), f32::INFINITY), None, density))
    }

    /// Density of `Constant::connect`.
    #[inline]
    pub fn density(&self, frame: &Frame, direction: Vec3A) -> f32 {
        frame.n.dot(direction).max(0.0) * FRAC_1_PI
    }

    pub(super) fn glance(&self, range: [f64; 2]) -> Glance {
        Glance::Outside(std::f64::consts::PI * self.radiance.mean(range))
    }
}
