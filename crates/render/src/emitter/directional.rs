//! `directional`: parallel light from infinitely far.
//!
//! | parameter    | type      | meaning                                                        | default |
//! |--------------|-----------|----------------------------------------------------------------|---------|
//! | `irradiance` | spectrum  | W/m² across the beam, unpolarized                              | 1       |
//! | `direction`  | vector    | in which the light travels; or `to_world`                      | +z      |
//! | `to_world`   | transform | the light travels along its local +z                           | –       |
//!
//! ```xml
//! <emitter type="directional"><vector name="direction" x="0" y="-1" z="-1"/></emitter>
//! ```

use glam::{DVec3, Vec3A};

use super::Connection;
use crate::coherence::Coherence;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A source of parallel light.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Unit vector toward the source.
    toward: Vec3A,
    /// Irradiance across the beam.
    pub irradiance: Spectrum,
}

impl Directional {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let along_z = object.transform("to_world")?.transform_vector3(DVec3::Z);
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
        Ok(Self {
            toward: -direction.as_vec3a(),
            irradiance: object.spectrum(
                "irradiance",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
        })
    }

    #[inline]
    pub(super) fn connect(&self) -> Option<Connection> {
        Some(Connection {
            direction: self.toward,
            target: None,
            density: 1.0,
            discrete: true,
            weight: 1.0,
            coherence: Coherence::PLANE_WAVE,
        })
    }
}
