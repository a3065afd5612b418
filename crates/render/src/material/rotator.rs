//! `rotator`: natural optical activity; turns the plane of polarization.
//!
//! | parameter          | type          | meaning                                                                   | default |
//! |--------------------|---------------|---------------------------------------------------------------------------|---------|
//! | `angle`            | spectrum      | degrees; counter-clockwise for a receiver who faces the light where positive | 45   |
//! | `rotatory_power`   | spectrum      | degrees a metre, instead of `angle`; times `thickness`                    | –       |
//! | `thickness`        | string, float | `10cm`, or metres; with `rotatory_power`                                  | –       |
//! | `reference`        | string, float | wavelength (`589.3nm`) for which the angle holds; it then goes as 1/λ²    | all     |
//! | `transmittance`    | spectrum      | factor on what passes                                                     | 1       |
//!
//! ```xml
//! <bsdf type="rotator">
//!     <float name="rotatory_power" value="21700"/><string name="thickness" value="1mm"/>
//!     <string name="reference" value="589.3nm"/>
//! </bsdf>
//! ```
//!
//! Both sides, the same sense for the receiver from either: light that comes back through it is turned back. Thin and
//! ideal: no reflection, and the same angle for oblique light. Sugar turns clockwise (dextrorotatory) by the sign of
//! chemists, positive for them and negative here.
//!
//! Source: Biot's law; Hecht, Optics, 5th ed., section 8.10.

use glam::{Mat4, Vec3A, vec4};

use super::{Departure, Effect, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::Light;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// An optically active plate.
#[derive(Clone, Debug)]
pub struct Rotator {
    /// Degrees, before `factor`.
    angle: Spectrum,
    factor: f64,
    /// Wavelength of the angle in nm, where it goes as 1/λ².
    reference: Option<f64>,
    transmittance: Spectrum,
}

impl Rotator {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let power = object.optional_spectrum("rotatory_power", SpectrumUse::Unbounded)?;
        let thickness = object.positive_length("thickness")?;
        let angle = object.optional_spectrum("angle", SpectrumUse::Unbounded)?;
        let (angle, factor) = match (angle, power, thickness) {
            (angle, None, None) => (angle.unwrap_or(Spectrum::constant(45.0)), 1.0),
            (None, Some(power), Some(thickness)) => (power, thickness),
            (Some(_), ..) => {
                return Err(object.error_at(
                    "angle",
                    "'angle' beside 'rotatory_power' or 'thickness', expected either it or both of them",
                ));
            }
            (None, ..) => {
                return Err(object.error(
                    "'rotatory_power' and 'thickness' of bsdf 'rotator' belong together, expected both or neither",
                ));
            }
        };
        Ok(Self {
            angle,
            factor,
            reference: object.positive_length("reference")?.map(|m| m * 1e9),
            transmittance: object.factor("transmittance")?,
        })
    }

    /// Radians, counter-clockwise for the receiver.
    fn turn(&self, wavelength: f32) -> f64 {
        let angle = f64::from(self.angle.value(wavelength)) * self.factor;
        let dispersion = self
            .reference
            .map_or(1.0, |reference| (reference / f64::from(wavelength)).powi(2));
        (angle * dispersion).to_radians()
    }
}

impl Matter for Rotator {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], _: [f32; 3]) -> Option<Departure> {
        Some(Departure::straight(at.o, 1.0))
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        _: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        // the same in every frame
        let axis = Frame::around(at.o).s;
        let response = L::general(axis, axis, |lane| {
            let (sine, cosine) = (2.0 * self.turn(wavelengths[lane])).sin_cos();
            let (s, c) = (sine as f32, cosine as f32);
            Mat4::from_cols(
                vec4(1., 0., 0., 0.),
                vec4(0., c, s, 0.),
                vec4(0., -s, c, 0.),
                vec4(0., 0., 0., 1.),
            ) * self.transmittance.value(wavelengths[lane])
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
        self.reference.is_none()
            && self.angle.is_constant_over(range)
            && self.transmittance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        // linear light stays linear
        Effect::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(parameters: &str) -> Result<Rotator, String> {
        super::super::testing::read("rotator", parameters, Rotator::read)
    }

    #[test]
    fn quartz_turns_sodium_light_by_21_7_degrees_a_millimetre_and_blue_light_by_more() {
        let rotator = read(
            "<float name='rotatory_power' value='21700'/><string name='thickness' value='1mm'/>\
             <string name='reference' value='589.3nm'/>",
        )
        .unwrap();
        assert!((rotator.turn(589.3).to_degrees() - 21.7).abs() < 1e-5);
        // 1/λ²: four times at half the wavelength
        assert!((rotator.turn(294.65).to_degrees() - 86.8).abs() < 1e-4);
        let plain = read("<float name='angle' value='30'/>").unwrap();
        assert!((plain.turn(400.0).to_degrees() - 30.0).abs() < 1e-12);
    }

    #[test]
    fn half_a_rotatory_power_is_refused() {
        for (parameters, expected) in [
            (
                "<float name='rotatory_power' value='1'/>",
                "scene.xml:1:24: 'rotatory_power' and 'thickness' of bsdf 'rotator' belong together, expected both or \
                 neither",
            ),
            (
                "<float name='angle' value='1'/><string name='thickness' value='1mm'/>",
                "scene.xml:2:1: 'angle' beside 'rotatory_power' or 'thickness', expected either it or both of them",
            ),
            (
                "<float name='angel' value='1'/>",
                "scene.xml:2:1: unknown parameter 'angel' in bsdf 'rotator', did you mean 'angle'?",
            ),
        ] {
            assert_eq!(read(parameters).unwrap_err(), expected);
        }
    }
}
