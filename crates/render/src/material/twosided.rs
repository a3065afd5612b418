//! `twosided`: gives one-sided matter a back, the same as the front or another.
//!
//! One or two nested bsdfs: one for both sides, or the front and the back.
//!
//! ```xml
//! <bsdf type="twosided"><bsdf type="roughconductor"/></bsdf>
//! ```
//!
//! Seen from the back the local frame is turned about axis U by 180°: a proper rotation, so that the sense of
//! polarization is kept. (Mitsuba 3.9 mirrors it, which turns the linear polarization of the back by twice the
//! azimuth of the view.)

use glam::Vec3A;

use super::{Departure, Effect, Material, Matter};
use crate::coherence::Coherence;
use crate::light::Light;

/// Matter with a front and a back.
#[derive(Clone, Debug)]
pub struct TwoSided {
    front: Box<Material>,
    back: Box<Material>,
}

/// Half a turn about axis U.
#[inline]
fn turned(v: Vec3A) -> Vec3A {
    Vec3A::new(v.x, -v.y, -v.z)
}

impl TwoSided {
    /// From the matter of its sides.
    pub fn new(front: Material, back: Material) -> Self {
        Self {
            front: Box::new(front),
            back: Box::new(back),
        }
    }

    /// Front and back.
    pub fn sides(&self) -> [&Material; 2] {
        [&self.front, &self.back]
    }
}

impl Matter for TwoSided {
    #[inline]
    fn sample(&self, o: Vec3A, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        if o.z > 0.0 {
            return self.front.sample(o, wavelengths, u);
        }
        let departure = self.back.sample(turned(o), wavelengths, u)?;
        Some(Departure {
            direction: turned(departure.direction),
            ..departure
        })
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        o: Vec3A,
        i: Vec3A,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        if o.z > 0.0 {
            return self.front.respond::<L>(o, i, wavelengths, coherence);
        }
        let (response, density) =
            self.back
                .respond::<L>(turned(o), turned(i), wavelengths, coherence);
        (L::map_axes(response, turned), density)
    }

    fn is_discrete(&self) -> bool {
        self.front.is_discrete() && self.back.is_discrete()
    }

    fn effect(&self) -> Effect {
        let [front, back] = self.sides().map(Matter::effect);
        front.and(back)
    }
}
