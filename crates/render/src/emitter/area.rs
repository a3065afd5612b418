//! `area`: a shape that shines, from its front side.
//!
//! | parameter  | type     | meaning                | default |
//! |------------|----------|------------------------|---------|
//! | `radiance` | spectrum | W/(m² sr) | 1       |
//!
//! ```xml
//! <shape type="rectangle"><emitter type="area"><float name="radiance" value="12"/></emitter></shape>
//! ```
//!
//! A shape that shines and holds no bsdf is black: it reflects nothing (others without bsdf are `diffuse`).

use glam::Vec3A;

use super::{Connection, Target};
use crate::lights::{Bundle, Glance};
use crate::scene::{Body, Object, Scene, SceneError};
use crate::shape::Surface;
use crate::spectrum::{Spectrum, SpectrumUse};

/// A shining shape.
#[derive(Clone, Debug)]
pub struct Area {
    /// Radiance.
    pub radiance: Spectrum,
    /// The shape, as the scene numbers it.
    pub body: Body,
}

impl Area {
    /// Reads its parameters.
    pub fn read(object: &Object, body: Body) -> Result<Self, SceneError> {
        Ok(Self {
            radiance: object.spectrum(
                "radiance",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
            body,
        })
    }

    #[inline]
    pub(super) fn connect(&self, scene: &Scene, from: Vec3A, u: [f32; 2]) -> Option<Connection> {
        let sample = match self.body {
            Body::Shape(index) => scene.shapes[index as usize].sample(from, u),
            Body::Mesh(index) => scene.meshes[index as usize].sample(from, u),
        }?;
        let to = sample.position - from;
        let distance = to.length();
        let direction = to / distance;
        let target = Target {
            position: sample.position,
            error: sample.error,
            normal: sample.normal,
        };
        (direction.dot(sample.normal) < 0.0)
            .then(|| Connection::to_point((direction, distance), Some(target), sample.pdf))
    }

    #[inline]
    pub(super) fn density(&self, scene: &Scene, from: Vec3A, at: &Surface) -> f32 {
        match self.body {
            Body::Shape(index) => scene.shapes[index as usize].pdf(from, at),
            Body::Mesh(index) => scene.meshes[index as usize].pdf(from, at),
        }
    }

    /// By its mean radiance over some wavelengths.
    pub(super) fn glance(&self, scene: &Scene, range: [f64; 2]) -> Glance {
        let radiance = self.radiance.mean(range);
        Glance::Near(match self.body {
            Body::Mesh(index) => scene.meshes[index as usize].glance(radiance),
            Body::Shape(index) => {
                let shape = &scene.shapes[index as usize];
                let (bounds, area) = (shape.bounds(), f64::from(shape.area()));
                match shape.outline() {
                    Some(outline) => Bundle::facing(outline.normal, bounds, radiance * area),
                    // a convex body shows a quarter of its surface
                    None => Bundle::even(bounds, 0.25 * radiance * area),
                }
            }
        })
    }
}
