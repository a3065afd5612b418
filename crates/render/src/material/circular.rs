//! `circular`: a thin ideal circular polarizer.
//!
//! | parameter       | type     | meaning                                     | default |
//! |-----------------|----------|---------------------------------------------|---------|
//! | `transmittance` | spectrum | factor on what passes                       | 1       |
//! | `left_handed`   | boolean  | passes S3 < 0 instead of S3 > 0             | false   |
//!
//! ```xml
//! <shape type="rectangle"><bsdf type="circular"/></shape>
//! ```
//!
//! The same from both sides; counts as a bounce.

use glam::{Mat4, Vec3A};
use mueller16::element;

use super::{Departure, Effect, Matter, Part, Traits, Vertex, narrowed};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::Light;
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// A circular polarizer.
#[derive(Clone, Debug)]
pub struct Circular {
    matrix: Mat4,
    transmittance: Spectrum,
}

impl Circular {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let ideal = element::circular_polarizer(object.boolean("left_handed", false)?);
        Ok(Self {
            matrix: narrowed(&ideal),
            transmittance: object.factor("transmittance")?,
        })
    }
}

impl Circular {
    /// Its matrix, the same in all frames, but for its transmittance.
    #[inline(always)]
    pub(super) fn matrix(&self) -> &Mat4 {
        &self.matrix
    }

    /// What it lets through of the light that it does not absorb.
    #[inline(always)]
    pub(super) fn transmittance(&self) -> &Spectrum {
        &self.transmittance
    }
}

impl Matter for Circular {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], _: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        Some(Departure::straight(o, 1.0))
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        _: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        // the matrix does not depend on the frame
        let axis = Frame::around(o).s;
        (
            L::general(axis, axis, |lane| {
                self.matrix * self.transmittance.value(wavelengths[lane])
            }),
            0.0,
        )
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: true,
            ..Traits::default()
        }
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.transmittance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_circular: true,
            ..Effect::default()
        }
    }
}
