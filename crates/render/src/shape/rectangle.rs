//! `rectangle`: the square [−1, 1]² of the local xy plane, normal along local +z, axis U along local +x.

use glam::{DMat4, Vec3A};

use super::{Columns, Surface};
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, gamma};

/// A parallelogram in world space.
#[derive(Clone, Debug)]
pub struct Rectangle {
    centre: Vec3A,
    half_u: Vec3A,
    half_v: Vec3A,
    /// Covectors: `u = to_u · (p − centre)`.
    to_u: Vec3A,
    to_v: Vec3A,
    frame: Frame,
    error: Vec3A,
    area: f32,
}

impl Rectangle {
    /// From the local-to-world transform. With `flip_normals` the front is the side of local −z.
    pub fn new(to_world: &DMat4, flip_normals: bool) -> Self {
        let c = Columns::of(to_world);
        let across = c.x.cross(c.y);
        // a mirroring transform keeps the front on the side of local +z
        let n = across.normalize() * across.dot(c.z).signum();
        let frame = Frame::with_tangent(n.as_vec3a(), c.x.as_vec3a());
        let (half_u, half_v) = (c.x.as_vec3a(), c.y.as_vec3a());
        let squared = across.length_squared();
        Self {
            centre: c.origin.as_vec3a(),
            half_u,
            half_v,
            to_u: (c.y.cross(across) / squared).as_vec3a(),
            to_v: (across.cross(c.x) / squared).as_vec3a(),
            frame: if flip_normals { frame.flipped() } else { frame },
            error: (c.origin.as_vec3a().abs() + half_u.abs() + half_v.abs()) * gamma(8)
                + Vec3A::splat((half_u.length() + half_v.length()) * gamma(8)),
            area: 4.0 * across.length() as f32,
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        let reach = self.half_u.abs() + self.half_v.abs();
        Bounds {
            min: self.centre - reach,
            max: self.centre + reach,
        }
        .grown(self.error)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let to_centre = self.centre - ray.origin;
        let t = to_centre.dot(self.frame.n) / ray.direction.dot(self.frame.n);
        // false for NaN too: a ray within the plane
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let p = ray.direction * t - to_centre;
        let (u, v) = (self.to_u.dot(p), self.to_v.dot(p));
        (u.abs() <= 1.0 && v.abs() <= 1.0).then_some((t, u, v))
    }

    #[inline]
    pub(super) fn surface(&self, u: f32, v: f32) -> Surface {
        Surface {
            position: self.centre + self.half_u * u + self.half_v * v,
            error: self.error,
            normal: self.frame.n,
            frame: self.frame,
        }
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3A, Vec3A, Vec3A) {
        let at = self.surface(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
        (at.position, at.error, at.normal)
    }
}
