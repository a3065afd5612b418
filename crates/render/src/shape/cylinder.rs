//! `cylinder`: an open tube from p0 to p1, normal outward, axis U along increasing azimuth about p0 → p1.
//!
//! Intersected in double precision.

use std::f32::consts::TAU;

use glam::{DMat4, DVec3, Vec3A};

use super::{Columns, Surface};
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, gamma};

/// A tube in world space.
#[derive(Clone, Debug)]
pub struct Cylinder {
    start: DVec3,
    axis: DVec3,
    length: f64,
    radius: f64,
    side: f32,
    sense: f32,
    error: Vec3A,
}

impl Cylinder {
    /// From its end points and radius in local space; the transform may move, turn, mirror and scale uniformly, `None`
    /// if it does anything else or if the tube has no length.
    pub fn new(
        p0: DVec3,
        p1: DVec3,
        radius: f64,
        to_world: &DMat4,
        flip_normals: bool,
    ) -> Option<Self> {
        let c = Columns::of(to_world);
        let scale = c.uniform_scale()?;
        let (start, end) = (to_world.transform_point3(p0), to_world.transform_point3(p1));
        let axis = (end - start).try_normalize()?;
        let reach = start.abs().max(end.abs()).as_vec3a() + Vec3A::splat((radius * scale) as f32);
        Some(Self {
            start,
            axis,
            length: start.distance(end),
            radius: radius * scale,
            side: if flip_normals { -1.0 } else { 1.0 },
            sense: c.x.cross(c.y).dot(c.z).signum() as f32,
            error: reach * gamma(8),
        })
    }

    pub(super) fn bounds(&self) -> Bounds {
        let end = self.start + self.axis * self.length;
        let reach = (DVec3::ONE - self.axis * self.axis)
            .max(DVec3::ZERO)
            .map(f64::sqrt)
            * self.radius;
        let corners = [
            self.start - reach,
            self.start + reach,
            end - reach,
            end + reach,
        ];
        Bounds::of(corners.map(DVec3::as_vec3a)).grown(self.error)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let d = ray.direction.as_dvec3();
        let from = ray.origin.as_dvec3() - self.start;
        let d_across = d - self.axis * d.dot(self.axis);
        let o_across = from - self.axis * from.dot(self.axis);
        let a = d_across.length_squared();
        if a == 0.0 {
            return None;
        }
        let along = -o_across.dot(d_across) / a;
        let nearest = o_across + d_across * along;
        let half = (self.radius * self.radius - nearest.length_squared()) / a;
        if half < 0.0 {
            return None;
        }
        let half = half.sqrt();
        [along - half, along + half].into_iter().find_map(|t| {
            let height = from.dot(self.axis) + t * d.dot(self.axis);
            let t = t as f32;
            (t > 0.0 && t < t_max && (0.0..=self.length).contains(&height)).then_some((t, 0.0, 0.0))
        })
    }

    fn at(&self, outward: DVec3, height: f64) -> Surface {
        let normal = outward.as_vec3a() * self.side;
        Surface {
            position: (self.start + self.axis * height + outward * self.radius).as_vec3a(),
            error: self.error,
            normal,
            frame: Frame::with_tangent(normal, self.axis.cross(outward).as_vec3a() * self.sense),
        }
    }

    #[inline]
    pub(super) fn surface(&self, ray: &Ray, t: f32) -> Surface {
        let p = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(t) - self.start;
        let height = p.dot(self.axis);
        self.at((p - self.axis * height).normalize(), height)
    }

    pub(super) fn area(&self) -> f32 {
        TAU * (self.radius * self.length) as f32
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3A, Vec3A, Vec3A) {
        let frame = Frame::around(self.axis.as_vec3a());
        let (sin, cos) = (TAU * u[0]).sin_cos();
        let at = self.at(
            frame.to_world(Vec3A::new(cos, sin, 0.0)).as_dvec3(),
            f64::from(u[1]) * self.length,
        );
        (at.position, at.error, at.normal)
    }
}
