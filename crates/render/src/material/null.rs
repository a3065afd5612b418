//! `null`: nothing; light passes as if the surface were not there. It still counts as a bounce.
//!
//! No parameters.
//!
//! ```xml
//! <bsdf type="null"/>
//! ```

use glam::Vec3A;

use super::{Departure, Effect, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Element, Light};

/// An invisible surface.
#[derive(Clone, Copy, Debug)]
pub struct Null;

impl Matter for Null {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], _: [f32; 3]) -> Option<Departure> {
        Some(Departure::straight(at.o, 1.0))
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        _: Vec3A,
        _: Part,
        _: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        let nothing = Element {
            mean: 1.0,
            difference: 0.0,
            cosine: 1.0,
            sine: 0.0,
        };
        (
            L::diattenuating_retarder(Frame::around(o).s, |_| nothing),
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

    fn is_grey(&self, _: [f64; 2]) -> bool {
        true
    }

    fn effect(&self) -> Effect {
        Effect::default()
    }
}
