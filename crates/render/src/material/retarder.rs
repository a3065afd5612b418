//! `retarder`: a thin ideal linear retarder (wave plate).
//!
//! | parameter       | type     | meaning                                                                      | default |
//! |-----------------|----------|------------------------------------------------------------------------------|---------|
//! | `theta`         | float    | degrees; fast axis (cos θ, sin θ) in (U, V): counter-clockwise from the front | 0       |
//! | `delta`         | spectrum | retardance in degrees: 90 quarter-wave, 180 half-wave                        | 90      |
//! | `transmittance` | spectrum | factor on what passes                                                        | 1       |
//!
//! ```xml
//! <shape type="rectangle"><bsdf type="retarder"><float name="delta" value="180"/></bsdf></shape>
//! ```
//!
//! Both sides; counts as a bounce. Tilted, axis U is projected across the ray, θ counts from there, and the
//! retardance falls with the cosine. (Mitsuba 3.9 does not project the axis: its plates are right at normal incidence and for tilts about U
//! only, with a jump where the ray crosses the plane of U.) Note that `polarizer` counts its angle the other way round.

use glam::Vec3A;
use mueller16::element;

use super::polarizer::axis_for;
use super::{Departure, Effect, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A linear retarder.
#[derive(Clone, Debug)]
pub struct Retarder {
    /// Sine and cosine of `theta`.
    turn: (f64, f64),
    delta: Spectrum,
    transmittance: Spectrum,
}

impl Retarder {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            turn: object.float("theta", 0.0)?.to_radians().sin_cos(),
            delta: object.spectrum("delta", SpectrumUse::Unbounded, Spectrum::constant(90.0))?,
            transmittance: object.factor("transmittance")?,
        })
    }
}

impl Retarder {
    /// Sine and cosine of the angle of the fast axis.
    #[inline(always)]
    pub(super) fn turn(&self) -> (f64, f64) {
        self.turn
    }

    /// Retardance in degrees, and transmittance.
    #[inline(always)]
    pub(super) fn spectra(&self) -> [&Spectrum; 2] {
        [&self.delta, &self.transmittance]
    }
}

impl Matter for Retarder {
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
        let axis = axis_for(o, |k| element::retarder_fast_axis(self.turn, k));
        let response = L::diattenuating_retarder(axis, |lane| {
            let delta = f64::from(self.delta.value(wavelengths[lane])).to_radians();
            let tilted = element::oblique_retardance(delta, o.as_dvec3().to_array());
            Element::from(element::linear_retarder(tilted))
                .scaled(self.transmittance.value(wavelengths[lane]))
        });
        (response, 0.0)
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: true,
            ..Traits::default()
        }
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.delta.is_constant_over(range) && self.transmittance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        Effect {
            retards: true,
            ..Effect::default()
        }
    }
}
