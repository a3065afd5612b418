//! `spot`: a point source that shines into a cone around its local +z axis.
//!
//! | parameter      | type      | meaning                                                         | default          |
//! |----------------|-----------|-----------------------------------------------------------------|------------------|
//! | `intensity`    | spectrum  | W/sr along the axis                                | 1                |
//! | `cutoff_angle` | float     | degrees from the axis beyond which it is dark                   | 20               |
//! | `beam_width`   | float     | degrees from the axis up to which it shines fully; falls linearly in between | 3/4 of the cutoff |
//! | `to_world`     | transform | place and axis                                                  | –                |
//!
//! ```xml
//! <emitter type="spot">
//!     <transform name="to_world"><lookat origin="0, 3, 0" target="0, 0, 0" up="0, 0, 1"/></transform>
//! </emitter>
//! ```

use glam::{DVec3, Vec3A};

use super::Connection;
use super::point::connect_to;
use crate::geometry::bvh::Bounds;
use crate::lights::{Bundle, Glance};
use crate::scene::{Object, SceneError, within_reach};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A spot light.
#[derive(Clone, Debug)]
pub struct Spot {
    position: Vec3A,
    axis: Vec3A,
    cutoff: f32,
    beam: f32,
    /// Radiant intensity along the axis.
    pub intensity: Spectrum,
}

impl Spot {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let to_world = object.transform("to_world")?;
        let cutoff = object.float("cutoff_angle", 20.0)?;
        let beam = object.float("beam_width", 0.75 * cutoff)?;
        if !(cutoff > 0.0 && cutoff <= 180.0) {
            return Err(object.error_at(
                "cutoff_angle",
                format!("an angle of {cutoff}°, expected one between 0 and 180"),
            ));
        }
        if !(0.0..=cutoff).contains(&beam) {
            return Err(object.error_at(
                "beam_width",
                format!(
                    "an angle of {beam}°, expected one between 0 and 'cutoff_angle' ({cutoff}°)"
                ),
            ));
        }
        let position = to_world.transform_point3(DVec3::ZERO).as_vec3a();
        within_reach(object, position.abs().max_element())?;
        Ok(Self {
            position,
            axis: to_world.transform_vector3(DVec3::Z).normalize().as_vec3a(),
            cutoff: cutoff.to_radians() as f32,
            beam: beam.to_radians() as f32,
            intensity: object.spectrum(
                "intensity",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
        })
    }

    /// Fraction of the full intensity at an angle from the axis.
    fn falloff(&self, angle: f32) -> f32 {
        if angle <= self.beam {
            1.0
        } else if angle >= self.cutoff {
            0.0
        } else {
            (self.cutoff - angle) / (self.cutoff - self.beam)
        }
    }

    #[inline]
    pub(super) fn connect(&self, from: Vec3A) -> Option<Connection> {
        let connection = connect_to(self.position, from)?;
        // acos loses half its digits at 0; sine and cosine together do not
        let angle = self
            .axis
            .cross(connection.direction)
            .length()
            .atan2(-self.axis.dot(connection.direction));
        let falloff = self.falloff(angle);
        (falloff > 0.0).then_some(Connection {
            weight: connection.weight * falloff,
            ..connection
        })
    }

    pub(super) fn glance(&self, range: [f64; 2]) -> Glance {
        Glance::Near(Bundle {
            spread: self.beam,
            edge: self.cutoff - self.beam,
            ..Bundle::facing(
                self.axis,
                Bounds::of([self.position]),
                self.intensity.mean(range),
            )
        })
    }
}
