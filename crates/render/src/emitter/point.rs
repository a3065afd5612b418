//! `point`: a source without extent that shines evenly in all directions.
//!
//! | parameter   | type      | meaning                                   | default |
//! |-------------|-----------|-------------------------------------------|---------|
//! | `intensity` | spectrum  | W/sr                         | 1       |
//! | `position`  | point     | place; or `to_world`, whose origin it is  | origin  |
//! | `to_world`  | transform | place                                     | –       |
//!
//! ```xml
//! <emitter type="point"><point name="position" x="0" y="2" z="0"/><float name="intensity" value="5"/></emitter>
//! ```

use glam::{DVec3, Vec3A};

use super::{Connection, Target};
use crate::coherence::Coherence;
use crate::geometry::bvh::Bounds;
use crate::lights::{Bundle, Glance};
use crate::scene::{Object, SceneError, within_reach};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A point source.
#[derive(Clone, Debug)]
pub struct Point {
    position: Vec3A,
    /// Radiant intensity.
    pub intensity: Spectrum,
}

/// The connection to a point: the weight is 1/r².
#[inline]
pub(super) fn connect_to(position: Vec3A, from: Vec3A) -> Option<Connection> {
    let to = position - from;
    let squared = to.length_squared();
    (squared > 0.0).then(|| Connection {
        direction: to / squared.sqrt(),
        target: Some(Target {
            position,
            error: Vec3A::ZERO,
            normal: Vec3A::ZERO,
        }),
        density: 1.0,
        discrete: true,
        weight: squared.recip(),
        coherence: Coherence::from_point(squared.sqrt()),
    })
}

impl Point {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let placed = object.transform("to_world")?.transform_point3(DVec3::ZERO);
        let position: DVec3 = match object.optional_point("position")? {
            Some(_) if object.has("to_world") => {
                return Err(object.error_at(
                    "position",
                    "both 'position' and 'to_world' are given, expected one of them",
                ));
            }
            Some(position) => position.into(),
            None => placed,
        };
        let position = position.as_vec3a();
        within_reach(object, position.abs().max_element())?;
        Ok(Self {
            position,
            intensity: object.spectrum(
                "intensity",
                SpectrumUse::Emission,
                Spectrum::constant(1.0),
            )?,
        })
    }

    #[inline]
    pub(super) fn connect(&self, from: Vec3A) -> Option<Connection> {
        connect_to(self.position, from)
    }

    pub(super) fn glance(&self, range: [f64; 2]) -> Glance {
        let bounds = Bounds::of([self.position]);
        Glance::Near(Bundle::even(bounds, self.intensity.mean(range)))
    }
}
