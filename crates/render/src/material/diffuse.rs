//! `diffuse`: an ideally matt surface (Lambert). It depolarizes completely.
//!
//! | parameter     | type     | meaning                                   | default |
//! |---------------|----------|-------------------------------------------|---------|
//! | `reflectance` | spectrum | reflected fraction of the power, in [0, 1] | 0.5     |
//!
//! ```xml
//! <bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.25, 0.7"/></bsdf>
//! ```
//!
//! One-sided: black from the back. Put it into `twosided` for both.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::{Departure, Effect, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A Lambertian surface.
#[derive(Clone, Debug)]
pub struct Diffuse {
    reflectance: Spectrum,
}

impl Default for Diffuse {
    /// Reflects half the power: what a shape is made of that names no matter and does not shine.
    fn default() -> Self {
        Self {
            reflectance: Spectrum::constant(0.5),
        }
    }
}

impl Diffuse {
    /// Reflects nothing: what a shining shape is made of that names no matter.
    pub fn black() -> Self {
        Self {
            reflectance: Spectrum::constant(0.0),
        }
    }

    /// Its reflectance.
    #[inline(always)]
    pub(super) fn reflectance(&self) -> &Spectrum {
        &self.reflectance
    }

    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: object.spectrum(
                "reflectance",
                SpectrumUse::Reflectance,
                Spectrum::constant(0.5),
            )?,
        })
    }
}

impl Matter for Diffuse {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        let i = cosine_hemisphere([u[1], u[2]]);
        (o.z > 0.0 && i.z > 0.0).then_some(Departure {
            direction: i,
            density: i.z * FRAC_1_PI,
            part: Part::Continuous,
            eta: 1.0,
        })
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        let density = if o.z > 0.0 && i.z > 0.0 {
            i.z * FRAC_1_PI
        } else {
            0.0
        };
        (
            L::depolarizing(|lane| self.reflectance.value(wavelengths[lane]) * density),
            density,
        )
    }

    fn traits(&self) -> Traits {
        Traits {
            black: self.reflectance == Spectrum::constant(0.0),
            ..Traits::default()
        }
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.reflectance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        Effect {
            depolarizes: true,
            ..Effect::default()
        }
    }
}
