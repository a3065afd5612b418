//! `laser`: a parallel beam of finite width, coherent across all of it.
//!
//! | parameter   | type        | meaning                                                            | default    |
//! |-------------|-------------|--------------------------------------------------------------------|------------|
//! | `power`     | spectrum    | W in the whole beam                                                | 1          |
//! | `waist`     | length      | radius: where a Gaussian beam has fallen to 1/e² of its middle; of a top hat, its rim | 1 mm |
//! | `profile`   | string      | `gaussian` or `tophat`                                             | `gaussian` |
//! | `position`  | point       | middle of the aperture                                             | origin     |
//! | `direction` | vector      | in which the light travels                                         | +z         |
//! | `to_world`  | transform   | instead of both: the beam leaves its origin along its local +z     | –          |
//! | `stokes`, `frame` |       | polarization, as for all emitters; the local x is that of `to_world` | –        |
//!
//! ```xml
//! <emitter type="laser">
//!     <string name="waist" value="0.5mm"/><float name="power" value="0.005"/><string name="stokes" value="1, 1, 0, 0"/>
//!     <transform name="to_world"><lookat origin="0, 0, 1" target="0, 0, 0" up="0, 1, 0"/></transform>
//! </emitter>
//! ```
//!
//! The coherent limit of a source: no angular width, so that matter answers to it as to a plane wave. The beam does not
//! widen: it is meant for distances far below the Rayleigh length π waist²/λ. It is seen where it falls on matter that
//! scatters; neither the camera nor a mirror looks into it.

use glam::{DMat4, DVec3, Vec3A};

use super::{Connection, Target};
use crate::coherence::Coherence;
use crate::lights::Glance;
use crate::scene::{Object, SceneError, within_reach};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A parallel beam.
#[derive(Clone, Debug)]
pub struct Laser {
    origin: Vec3A,
    along: Vec3A,
    waist: f32,
    gaussian: bool,
    /// Power in the whole beam.
    pub power: Spectrum,
}

impl Laser {
    /// Reads its parameters; returns the transform that its polarization refers to.
    pub fn read(object: &Object) -> Result<(Self, DMat4), SceneError> {
        let to_world = object.transform("to_world")?;
        let position = object.optional_point("position")?;
        let direction = object.optional_vector("direction")?;
        if object.has("to_world") {
            for (name, given) in [
                ("position", position.is_some()),
                ("direction", direction.is_some()),
            ] {
                if given {
                    return Err(object.error_at(
                        name,
                        format!("both '{name}' and 'to_world' are given, expected one of them"),
                    ));
                }
            }
        }
        let along = match direction {
            Some(direction) => DVec3::from(direction).try_normalize().ok_or_else(|| {
                object.error_at(
                    "direction",
                    "a direction of no length, expected a vector other than 0",
                )
            })?,
            None => to_world.transform_vector3(DVec3::Z).normalize(),
        };
        let origin = position.map_or(to_world.transform_point3(DVec3::ZERO), DVec3::from);
        within_reach(object, origin.as_vec3a().abs().max_element())?;
        let waist = object.micro_length("waist", Some(1e-3))?.unwrap_or(1e-3);
        if waist <= 0.0 {
            return Err(object.error_at(
                "waist",
                format!("a radius of {waist} m, expected a positive length"),
            ));
        }
        let profile = object.choice("profile", "gaussian", &["gaussian", "tophat"])?;
        let laser = Self {
            origin: origin.as_vec3a(),
            along: along.as_vec3a(),
            waist: waist as f32,
            gaussian: profile == "gaussian",
            power: object.spectrum("power", SpectrumUse::Emission, Spectrum::constant(1.0))?,
        };
        Ok((laser, to_world))
    }

    /// Irradiance across the beam at a distance from its axis, for a beam of 1 W.
    fn profile(&self, off: f32) -> f32 {
        let ratio = off / self.waist;
        let mean = (std::f32::consts::PI * self.waist * self.waist).recip();
        match self.gaussian {
            true => 2.0 * mean * (-2.0 * ratio * ratio).exp(),
            false if ratio < 1.0 => mean,
            false => 0.0,
        }
    }

    /// Distance of a point from the aperture along the beam, and the irradiance there for a beam of 1 W.
    #[inline]
    fn at(&self, point: Vec3A) -> (f32, f32) {
        let offset = point - self.origin;
        let distance = offset.dot(self.along);
        if distance <= 0.0 {
            return (distance, 0.0);
        }
        let across = (offset - self.along * distance).length();
        (distance, self.profile(across))
    }

    /// Irradiance across the beam at a point, 1/m²: for a beam of 1 W.
    #[inline]
    pub fn irradiance(&self, point: Vec3A) -> f32 {
        self.at(point).1
    }

    pub(super) fn glance(&self, range: [f64; 2]) -> Glance {
        Glance::Beam(self.power.mean(range))
    }

    #[inline]
    pub(super) fn connect(&self, from: Vec3A) -> Option<Connection> {
        let (distance, weight) = self.at(from);
        (weight > 0.0).then(|| Connection {
            direction: -self.along,
            target: Some(Target {
                position: from - self.along * distance,
                error: Vec3A::ZERO,
                normal: Vec3A::ZERO,
            }),
            density: 1.0,
            discrete: true,
            weight,
            coherence: Coherence::PLANE_WAVE,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_beam_holds_its_power() {
        for gaussian in [true, false] {
            let laser = Laser {
                origin: Vec3A::ZERO,
                along: Vec3A::Z,
                waist: 2e-3,
                gaussian,
                power: Spectrum::constant(1.0),
            };
            let step = 1e-6f64;
            let sum: f64 = (0..12_000)
                .map(|i| {
                    let r = (f64::from(i) + 0.5) * step;
                    f64::from(laser.profile(r as f32)) * std::f64::consts::TAU * r * step
                })
                .sum();
            // midpoint rule; beyond six waists nothing is left
            assert!((sum - 1.0).abs() < 1e-5, "{gaussian}: {sum}");
        }
    }
}
