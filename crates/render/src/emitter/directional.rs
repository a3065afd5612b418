//! `directional`: parallel light from infinitely far, or light from a small round source there.
//!
//! | parameter    | type      | meaning                                                        | default |
//! |--------------|-----------|----------------------------------------------------------------|---------|
//! | `irradiance` | spectrum  | W/m² across the beam                                           | 1       |
//! | `direction`  | vector    | in which the light travels; or `to_world`                      | +z      |
//! | `to_world`   | transform | the light travels along its local +z                           | –       |
//! | `angular_diameter` | float | degrees under which the source is seen, below 180; the sun has 0.53 | 0 |
//! | `stokes`, `frame` |      | polarization, as for all emitters; the local x is that of `to_world` | –  |
//!
//! ```xml
//! <emitter type="directional"><vector name="direction" x="0" y="-1" z="-1"/></emitter>
//! ```
//!
//! With an angular diameter shadows have a penumbra, and matter that answers to coherence sees the disc in patches;
//! without it the light is coherent over all of the matter. The disc lights what scatters; neither the camera nor a mirror
//! sees it.

use std::f32::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::Connection;
use super::patch::{Cut, cone_direction};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::lights::Glance;
use crate::sampler::unit_disk;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A source of parallel light.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Its normal is the unit vector toward the source.
    toward: Frame,
    /// 1 − cos of half the angular diameter.
    cap: f32,
    /// What makes radiance of irradiance: 1 over the disc's solid angle, weighted by the cosine to its middle; or 1.
    pub(super) scale: f32,
    /// Irradiance across the beam.
    pub irradiance: Spectrum,
}

impl Directional {
    /// Reads its parameters; returns the transform that its polarization refers to.
    pub fn read(object: &Object) -> Result<(Self, DMat4), SceneError> {
        let to_world = object.transform("to_world")?;
        let along_z = to_world.transform_vector3(DVec3::Z);
        let direction = match object.optional_vector("direction")? {
            Some(_) if object.has("to_world") => {
                return Err(object.error_at(
                    "direction",
                    "both 'direction' and 'to_world' are given, expected one of them",
                ));
            }
            Some(direction) => DVec3::from(direction).try_normalize().ok_or_else(|| {
                object.error_at(
                    "direction",
                    "a direction of no length, expected a vector other than 0",
                )
            })?,
            None => along_z.normalize(),
        };
        let diameter = object.float("angular_diameter", 0.0)?;
        if !(0.0..180.0).contains(&diameter) {
            return Err(object.error_at(
                "angular_diameter",
                format!("an angle of {diameter}°, expected one from 0 to below 180"),
            ));
        }
        let quarter = 0.25 * diameter.to_radians();
        let directional = Self {
            toward: Frame::around(-direction.as_vec3a()),
            cap: (2.0 * quarter.sin().powi(2)) as f32,
            scale: if diameter > 0.0 {
                ((2.0 * quarter).sin().powi(2) as f32 * PI).recip()
            } else {
                1.0
            },
            irradiance: object.spectrum(
                "irradiance",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
        };
        Ok((directional, to_world))
    }

    #[inline]
    pub(super) fn connect(&self, u: [f32; 2]) -> Option<Connection> {
        let (direction, density) = if self.cap > 0.0 {
            let (x, y) = unit_disk(u);
            let direction = cone_direction(&self.toward, self.cap, glam::vec2(x, y));
            (direction, (TAU * self.cap).recip())
        } else {
            (self.toward.n, 1.0)
        };
        Some(Connection {
            direction,
            target: None,
            density,
            discrete: true,
            weight: 1.0,
            coherence: Coherence::PLANE_WAVE,
        })
    }

    pub(super) fn glance(&self, range: [f64; 2]) -> Glance {
        Glance::Outside(self.irradiance.mean(range))
    }

    /// Whether its light is parallel: it looks like a point.
    pub(super) fn is_parallel(&self) -> bool {
        self.cap <= 0.0
    }

    /// The disc in patches; `None` for parallel light.
    pub(super) fn cut(&self, largest: f32) -> Option<Cut<'static>> {
        (!self.is_parallel()).then(|| Cut::cone(self.toward, self.cap, largest))
    }
}
