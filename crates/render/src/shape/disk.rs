//! `disk`: the unit disk of the local xy plane, normal along local +z, axis U radial.

use glam::{DMat4, Vec3A};

use super::{Columns, Surface};
use crate::emitter::patch::Outline;
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, gamma};

/// An ellipse in world space.
#[derive(Clone, Debug)]
pub struct Disk {
    centre: Vec3A,
    radius_u: Vec3A,
    radius_v: Vec3A,
    to_u: Vec3A,
    to_v: Vec3A,
    normal: Vec3A,
    error: Vec3A,
    area: f32,
}

impl Disk {
    /// From the local-to-world transform. With `flip_normals` the front is the side of local −z.
    pub fn new(to_world: &DMat4, flip_normals: bool) -> Self {
        let c = Columns::of(to_world);
        let across = c.x.cross(c.y);
        let (radius_u, radius_v) = (c.x.as_vec3a(), c.y.as_vec3a());
        let squared = across.length_squared();
        // a mirroring transform keeps the front on the side of local +z
        let normal = (across.normalize() * across.dot(c.z).signum()).as_vec3a();
        Self {
            centre: c.origin.as_vec3a(),
            radius_u,
            radius_v,
            to_u: (c.y.cross(across) / squared).as_vec3a(),
            to_v: (across.cross(c.x) / squared).as_vec3a(),
            normal: if flip_normals { -normal } else { normal },
            error: (c.origin.as_vec3a().abs() + radius_u.abs() + radius_v.abs()) * gamma(8)
                + Vec3A::splat((radius_u.length() + radius_v.length()) * gamma(8)),
            area: (std::f64::consts::PI * across.length()) as f32,
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        let reach = (self.radius_u * self.radius_u + self.radius_v * self.radius_v).map(f32::sqrt);
        Bounds {
            min: self.centre - reach,
            max: self.centre + reach,
        }
        .grown(self.error)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let to_centre = self.centre - ray.origin;
        let t = to_centre.dot(self.normal) / ray.direction.dot(self.normal);
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let p = ray.direction * t - to_centre;
        let (u, v) = (self.to_u.dot(p), self.to_v.dot(p));
        (u * u + v * v <= 1.0).then_some((t, u, v))
    }

    #[inline]
    pub(super) fn surface(&self, u: f32, v: f32) -> Surface {
        let radial = self.radius_u * u + self.radius_v * v;
        Surface {
            position: self.centre + radial,
            error: self.error,
            normal: self.normal,
            frame: Frame::with_tangent(self.normal, radial),
        }
    }

    pub(crate) fn outline(&self) -> Outline {
        Outline {
            centre: self.centre,
            half_u: self.radius_u,
            half_v: self.radius_v,
            normal: self.normal,
            round: true,
            error: self.error,
        }
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3A, Vec3A, Vec3A) {
        let (x, y) = crate::sampler::unit_disk(u);
        (
            self.centre + self.radius_u * x + self.radius_v * y,
            self.error,
            self.normal,
        )
    }
}
