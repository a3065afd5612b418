//! `polarizer`: a thin ideal linear polarizer.
//!
//! | parameter       | type     | meaning                                                                | default |
//! |-----------------|----------|------------------------------------------------------------------------|---------|
//! | `theta`         | float    | degrees; transmits along (cos θ, −sin θ) in (U, V): clockwise from the front | 0 |
//! | `transmittance` | spectrum | factor on what passes                                                  | 1       |
//! | `polarizing`    | boolean  | `false`: a neutral filter of half the transmittance                    | true    |
//!
//! ```xml
//! <shape type="rectangle"><bsdf type="polarizer"><float name="theta" value="30"/></bsdf></shape>
//! ```
//!
//! Both sides; counts as a bounce. Tilted, its absorbing axis is projected across the ray; nothing else is lost.
//!
//! Source: Korger et al., The polarization properties of a tilted polarizer, Opt. Express 21(22), 2013.

use glam::{DVec3, Vec3A};
use mueller16::element;

use super::{Departure, Effect, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// A linear polarizer.
#[derive(Clone, Debug)]
pub struct Polarizer {
    /// Sine and cosine of `theta`.
    turn: (f64, f64),
    transmittance: Spectrum,
    polarizing: bool,
}

impl Polarizer {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            turn: object.float("theta", 0.0)?.to_radians().sin_cos(),
            transmittance: object.factor("transmittance")?,
            polarizing: object.boolean("polarizing", true)?,
        })
    }
}

impl Polarizer {
    /// What it does, but for its transmittance.
    #[inline(always)]
    pub(super) fn element(&self) -> Element {
        if self.polarizing {
            Element::from(element::linear_polarizer())
        } else {
            Element {
                mean: 0.5,
                difference: 0.0,
                cosine: 0.5,
                sine: 0.0,
            }
        }
    }

    /// The axis in the plate along which the field is absorbed; `None` if it does not polarize.
    #[inline(always)]
    pub(super) fn absorbing_axis(&self) -> Option<Vec3A> {
        let (sin, cos) = self.turn;
        self.polarizing
            .then(|| Vec3A::new(sin as f32, cos as f32, 0.0))
    }

    /// What it lets through of the light that it does not absorb.
    #[inline(always)]
    pub(super) fn transmittance(&self) -> &Spectrum {
        &self.transmittance
    }
}

/// A local axis that the theorem crates give for a ray along `k`, back in single precision.
#[inline]
pub(super) fn axis_for(k: Vec3A, axis: impl Fn([f64; 3]) -> [f64; 3]) -> Vec3A {
    DVec3::from(axis(k.as_dvec3().to_array())).as_vec3a()
}

impl Matter for Polarizer {
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
        let transmittance = |lane: usize| self.transmittance.value(wavelengths[lane]);
        let ideal = self.element();
        let axis = if self.polarizing {
            axis_for(o, |k| element::polarizer_transmitted_axis(self.turn, k))
        } else {
            Frame::around(o).s
        };
        (
            L::diattenuating_retarder(axis, |lane| ideal.scaled(transmittance(lane))),
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
            makes_linear: self.polarizing,
            ..Effect::default()
        }
    }
}
