//! Polarization of a source: one state for all its light, in a frame that its rays carry with them.
//!
//! Every emitter but `egsm` and `rayleighsky`, which are polarized by themselves, takes
//!
//! | parameter | type   | meaning                                                                     | default |
//! |-----------|--------|-----------------------------------------------------------------------------|---------|
//! | `stokes`  | string | S0, S1, S2, S3 relative to S0; the first is 1                               | 1, 0, 0, 0 |
//! | `frame`   | vector | first axis of the Stokes frame, world; only with `stokes`                   | local x |
//!
//! ```xml
//! <emitter type="point"><string name="stokes" value="1, 0.3, 0, 0"/><vector name="frame" x="1" y="0" z="0"/></emitter>
//! ```
//!
//! The first axis is projected across the ray; with the propagation direction k the second is k × first. Without
//! `frame` it is the local x of the source: of its `to_world`, for shapes of the `to_world` of the shape, and the world's
//! x where there is none. Along a ray that is parallel to the axis (within 1e-5) nothing is left to project: there the
//! local y is projected instead, or with `frame` the world axis that is farthest from it.

use glam::{DMat4, DVec3, Vec3, Vec3A};

use crate::geometry::frame::Frame;
use crate::scene::{Object, SceneError};

/// One state of polarization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polarization {
    /// S1, S2, S3 over S0.
    pub state: Vec3,
    /// First axis before projection, world, unit.
    axis: Vec3A,
    /// What is projected along rays that are parallel to `axis`.
    spare: Vec3A,
}

impl Polarization {
    /// Reads `stokes` and `frame`; `to_world` places the source. `None`: unpolarized.
    ///
    /// # Errors
    ///
    /// Four numbers that are no state of light, or a frame of nothing.
    pub fn read(object: &Object, to_world: &DMat4) -> Result<Option<Self>, SceneError> {
        let stokes = object.optional_string("stokes")?;
        let frame = object.optional_vector("frame")?;
        let Some(text) = stokes else {
            return match frame {
                Some(_) => Err(object.error_at(
                    "frame",
                    format!(
                        "'frame' of {} without 'stokes', expected both or none",
                        object.describe()
                    ),
                )),
                None => Ok(None),
            };
        };
        let state = state_of(&text).map_err(|found| {
            object.error_at(
                "stokes",
                format!("'stokes' of {} {found}", object.describe()),
            )
        })?;
        let (axis, spare) = match frame {
            Some(frame) => {
                let axis = DVec3::from(frame).try_normalize().ok_or_else(|| {
                    object.error_at(
                        "frame",
                        "an axis of no length, expected a vector other than 0",
                    )
                })?;
                let least = axis.abs().min_element();
                let spare = [DVec3::X, DVec3::Y, DVec3::Z]
                    .into_iter()
                    .find(|a| axis.dot(*a).abs() <= least)
                    .unwrap_or(DVec3::X);
                (axis, spare)
            }
            None => (
                to_world.transform_vector3(DVec3::X).normalize(),
                to_world.transform_vector3(DVec3::Y).normalize(),
            ),
        };
        let polarization = Self {
            state: state.as_vec3(),
            axis: axis.as_vec3a(),
            spare: spare.as_vec3a(),
        };
        Ok((state != DVec3::ZERO).then_some(polarization))
    }

    /// First axis of the frame of a ray along `k`.
    #[inline]
    pub fn axis_across(&self, k: Vec3A) -> Vec3A {
        across(self.axis, self.spare, k)
    }
}

/// `axis` projected across `k`, or `spare` where `axis` is parallel to `k`; unit.
#[inline]
pub(crate) fn across(axis: Vec3A, spare: Vec3A, k: Vec3A) -> Vec3A {
    let projected = axis - k * k.dot(axis);
    let squared = projected.length_squared();
    if squared > 1e-10 {
        projected / squared.sqrt()
    } else {
        Frame::with_tangent(k, spare).s
    }
}

/// S1, S2, S3 out of a text of four numbers; what is wrong with it otherwise.
fn state_of(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text
        .split(|c: char| c == ',' || c.is_whitespace())
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    let Some([s0, s1, s2, s3]) = numbers.and_then(|n| <[f64; 4]>::try_from(n).ok()) else {
        return Err(format!(
            "is '{text}', expected four numbers ('1, 0.3, 0, 0')"
        ));
    };
    if s0 != 1.0 {
        return Err(format!(
            "begins with {s0}, expected 1: the strength of the source is another parameter"
        ));
    }
    let state = DVec3::new(s1, s2, s3);
    let degree = state.length();
    // a state written with six digits may miss 1 by rounding
    if degree > 1.0 + 1e-6 {
        return Err(format!(
            "has a degree of polarization of {degree:.6}, expected at most 1"
        ));
    }
    Ok(state / degree.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_four_numbers_that_light_can_have() {
        assert_eq!(state_of("1, 0.3, 0, -0.5"), Ok(DVec3::new(0.3, 0.0, -0.5)));
        assert_eq!(state_of("1 0 0 1"), Ok(DVec3::Z));
        for (text, expected) in [
            ("1, 0.3, 0", "is '1, 0.3, 0', expected four numbers"),
            ("1, x, 0, 0", "is '1, x, 0, 0', expected four numbers"),
            ("1, nan, 0, 0", "is '1, nan, 0, 0', expected four numbers"),
            ("2, 0.3, 0, 0", "begins with 2, expected 1"),
            (
                "1, 0.8, 0.7, 0",
                "has a degree of polarization of 1.063015, expected at most 1",
            ),
        ] {
            let message = state_of(text).unwrap_err();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn the_axis_is_projected_and_has_a_spare() {
        let p = Polarization {
            state: Vec3::X,
            axis: Vec3A::X,
            spare: Vec3A::Y,
        };
        let k = Vec3A::new(1.0, 0.0, 1.0).normalize();
        let expected = Vec3A::new(1.0, 0.0, -1.0).normalize();
        assert!((p.axis_across(k) - expected).length() < 1e-6);
        assert_eq!(p.axis_across(Vec3A::X), Vec3A::Y);
        assert_eq!(p.axis_across(Vec3A::NEG_X), Vec3A::Y);
    }
}
