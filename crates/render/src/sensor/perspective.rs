//! `perspective`: a pinhole camera that looks along its local +z, up along local +y.
//!
//! | parameter      | type      | meaning                                                                | default |
//! |----------------|-----------|------------------------------------------------------------------------|---------|
//! | `fov`          | float     | field of view in degrees                                               | –       |
//! | `fov_axis`     | string    | what `fov` spans: `x`, `y`, `diagonal`, `smaller`, `larger`            | `x`     |
//! | `focal_length` | string    | instead of `fov`: `50mm` on 36 × 24 mm film, by its diagonal           | `50mm`  |
//! | `to_world`     | transform | place and orientation                                                  | –       |
//!
//! `near_clip` and `far_clip` are accepted and have no effect. Nested: `film`, `sampler`.
//!
//! The Stokes vector of a pixel is given in the frame of the sample's own ray: with d the viewing direction and up the
//! camera's local +y, `e_x = normalize(d × up)` (image right) and, light travelling along −d, `e_y` image up. The frame
//! turns with the camera and differs slightly from pixel to pixel.

use glam::{DVec3, Vec3A};

use crate::geometry::ray::Ray;
use crate::lanes::{Real, V3};
use crate::path::witness::View;
use crate::scene::{Object, SceneError, within_reach};
use crate::shape::abreast::Rays;

/// A pinhole camera.
#[derive(Clone, Debug)]
pub struct Perspective {
    origin: Vec3A,
    /// These three are unit vectors across each other.
    right: Vec3A,
    up: Vec3A,
    forward: Vec3A,
    /// −1 for a transform that mirrors: then right is on the other side of forward × up.
    sense: f32,
    /// Half the film's width and height at unit distance.
    half: [f32; 2],
    /// The width and height of a pixel there.
    pixel: [f32; 2],
}

/// tan of half the horizontal field of view.
fn half_width(object: &Object, aspect: f64) -> Result<f64, SceneError> {
    // the diagonal of the film over its width
    let diagonal = (1.0 + aspect.powi(-2)).sqrt();
    let axes = ["x", "y", "diagonal", "smaller", "larger"];
    let axis = object.choice("fov_axis", "x", &axes)?;
    if let Some(fov) = object.optional_float("fov")? {
        if object.has("focal_length") {
            return Err(object.error_at(
                "focal_length",
                "both 'fov' and 'focal_length' are given, expected one of them",
            ));
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(object.error_at(
                "fov",
                format!("an angle of {fov}°, expected one between 0 and 180"),
            ));
        }
        let half = (0.5 * fov.to_radians()).tan();
        let by_width = match axis.as_str() {
            "y" => false,
            "smaller" => aspect <= 1.0,
            "larger" => aspect > 1.0,
            "diagonal" => return Ok(half / diagonal),
            _ => true,
        };
        return Ok(if by_width { half } else { half * aspect });
    }
    if object.has("fov_axis") {
        object.notice_at(
            "fov_axis",
            "'fov_axis' has no effect without 'fov': 'focal_length' goes by the diagonal",
        );
    }
    let text = object.string("focal_length", "50mm")?;
    let millimetres: f64 = text
        .strip_suffix("mm")
        .and_then(|number| number.trim().parse().ok())
        .filter(|f: &f64| *f > 0.0 && f.is_finite())
        .ok_or_else(|| {
            object.error_at(
                "focal_length",
                format!("'{text}', expected a positive length such as '50mm'"),
            )
        })?;
    let film_diagonal = 36f64.hypot(24.0);
    Ok(0.5 * film_diagonal / millimetres / diagonal)
}

impl Perspective {
    /// Reads its parameters; `size` is the film's, in pixels.
    pub fn read(object: &Object, size: [u32; 2]) -> Result<Self, SceneError> {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let width = half_width(object, aspect)?;
        let half = [width, width / aspect];
        let to_world = object.transform("to_world")?;
        let [right, up, forward] =
            [DVec3::NEG_X, DVec3::Y, DVec3::Z].map(|axis| to_world.transform_vector3(axis));
        let lengths = [right, up, forward].map(DVec3::length);
        let skew = [right.dot(up), up.dot(forward), forward.dot(right)];
        let unit = lengths[2];
        if lengths.iter().any(|l| (l / unit - 1.0).abs() > 1e-5)
            || skew.iter().any(|s| s.abs() > 1e-5 * unit * unit)
        {
            return Err(object.error_at(
                "to_world",
                "a camera that is stretched or skewed, expected a transform that only moves, turns and mirrors",
            ));
        }
        let origin = to_world.transform_point3(DVec3::ZERO).as_vec3a();
        within_reach(object, origin.abs().max_element())?;
        object.without_effect(&["near_clip", "far_clip", "shutter_open", "shutter_close"]);
        // without what skew has been let pass
        let forward = forward.normalize();
        let up = up.reject_from_normalized(forward).normalize();
        let side = forward.cross(up);
        let sense = right.dot(side).signum();
        Ok(Self {
            origin,
            right: (side * sense).as_vec3a(),
            up: up.as_vec3a(),
            forward: forward.as_vec3a(),
            sense: sense as f32,
            half: half.map(|h| h as f32),
            pixel: [0, 1].map(|axis| (2.0 * half[axis] / f64::from(size[axis])) as f32),
        })
    }

    /// The ray through a film position in pixels (0, 0 is the top left corner), and the first axis of its Stokes frame.
    #[inline]
    pub fn ray(&self, x: f32, y: f32) -> (Ray, Vec3A) {
        let right = x * self.pixel[0] - self.half[0];
        let up = self.half[1] - y * self.pixel[1];
        let toward = self.forward + self.right * right + self.up * up;
        // toward × up
        let across = (self.right - self.forward * right) * self.sense;
        let across2 = 1.0 + right * right;
        let (direction, axis) = (toward / (across2 + up * up).sqrt(), across / across2.sqrt());
        (
            Ray {
                origin: self.origin,
                direction,
                t_max: f32::INFINITY,
            },
            axis,
        )
    }

    /// The same for film positions side by side.
    #[inline(always)]
    pub fn rays<R: Real>(&self, x: R, y: R) -> (Rays<R>, V3<R>) {
        let right = x * R::splat(self.pixel[0]) - R::splat(self.half[0]);
        let up = R::splat(self.half[1]) - y * R::splat(self.pixel[1]);
        let above = V3::splat(self.up);
        let toward = V3::splat(self.forward) + V3::splat(self.right) * right + above * up;
        let across =
            (V3::splat(self.right) - V3::splat(self.forward) * right) * R::splat(self.sense);
        let across2 = R::one() + right * right;
        let rays = Rays {
            origin: V3::splat(self.origin),
            direction: toward * (across2 + up * up).sqrt().recip(),
            t_max: R::splat(f32::INFINITY),
        };
        (rays, across * across2.sqrt().recip())
    }

    /// The view through the middle of a pixel of the film.
    pub fn view(&self, column: u32, row: u32) -> View {
        let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
        let (Ray { direction, .. }, right) = self.ray(x, y);
        // directions uniform over the pixel
        let spread = |dx: f32, dy: f32| {
            let ends = [-0.5, 0.5].map(|t| self.ray(x + t * dx, y + t * dy).0.direction);
            (ends[1] - ends[0]) / 12f32.sqrt()
        };
        View {
            direction,
            right,
            root: [spread(1.0, 0.0), spread(0.0, 1.0)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Start;
    use crate::scene::{Overrides, build, read_text};

    #[test]
    fn the_frame_of_a_ray_is_across_it_and_level_with_the_camera() {
        let forward = DVec3::new(-3.0, -1.5, -2.0).normalize();
        let up = DVec3::new(0.2, 1.0, 0.1)
            .reject_from_normalized(forward)
            .normalize();
        for mirror in ["", "<scale x='-1'/>"] {
            let text = format!(
                "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='100'/>
                 <transform name='to_world'>{mirror}
                 <lookat origin='1, 2, 3' target='-2, 0.5, 1' up='0.2, 1, 0.1'/></transform></sensor></scene>"
            );
            let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
            let built = build(&document, Overrides::default()).unwrap();
            let [width, height] = built.film.size.map(|n| n as f32);
            let look = |x: f32, y: f32| match built.camera.start(x * width, y * height) {
                Start::Ray { ray, axis } => (ray.direction.as_dvec3(), axis.as_dvec3()),
                Start::Plane(_) => panic!("a ray expected"),
            };
            for k in 0..121 {
                let (x, y) = ((k % 11) as f32 / 10.0, (k / 11) as f32 / 10.0);
                let (direction, axis) = look(x, y);
                // a dozen roundings of numbers up to 1
                let close = |a: f64, b: f64| (a - b).abs() < 12.0 * f64::from(f32::EPSILON / 2.0);
                assert!(close(direction.length(), 1.0) && close(axis.length(), 1.0));
                let expected = direction.cross(up).normalize();
                assert!(close((axis - expected).length(), 0.0), "{axis} {expected}");
            }
            let along = (look(0.6, 0.5).0 - look(0.4, 0.5).0).dot(look(0.5, 0.5).1);
            assert_eq!(along > 0.0, mirror.is_empty());
            assert!((look(0.5, 0.4).0 - look(0.5, 0.6).0).dot(up) > 0.0);
        }
    }
}
