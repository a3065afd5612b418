//! `sphere`: centre and radius, normal outward, axis U along increasing azimuth about the local z axis.
//!
//! A transform that mirrors turns it inside out, as in Mitsuba 3: the normal points inward unless `flip_normals` is given.
//!
//! Intersected in double precision: a sphere seen from a thousand radii stays round.

use std::f32::consts::{PI, TAU};

use glam::{DMat4, DVec3, Vec3A};

use super::{AreaSample, Columns, Surface, by_area, solid_angle_density};
use crate::emitter::Target;
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, gamma};

/// A sphere in world space.
#[derive(Clone, Debug)]
pub struct Sphere {
    pub(super) centre: Vec3A,
    pub(super) centre_f64: DVec3,
    pub(super) radius: f32,
    pub(super) radius_f64: f64,
    pub(super) pole: Vec3A,
    /// +1: the front is outside.
    pub(super) side: f32,
    /// −1 for a transform that mirrors: azimuth runs the other way round.
    pub(super) sense: f32,
    pub(super) error: Vec3A,
}

impl Sphere {
    /// From centre and radius in local space and the local-to-world transform, which may move, turn, mirror and scale
    /// uniformly; `None` if it does anything else.
    pub fn new(centre: DVec3, radius: f64, to_world: &DMat4, flip_normals: bool) -> Option<Self> {
        let c = Columns::of(to_world);
        let scale = c.uniform_scale()?;
        let centre = to_world.transform_point3(centre).as_vec3a();
        let radius = (radius * scale) as f32;
        let sense = c.x.cross(c.y).dot(c.z).signum() as f32;
        Some(Self {
            centre,
            centre_f64: centre.as_dvec3(),
            radius,
            radius_f64: f64::from(radius),
            pole: c.z.normalize().as_vec3a(),
            side: if flip_normals { -sense } else { sense },
            sense,
            error: (centre.abs() + Vec3A::splat(radius)) * gamma(6),
        })
    }

    pub(super) fn bounds(&self) -> Bounds {
        let reach = Vec3A::splat(self.radius);
        Bounds {
            min: self.centre - reach,
            max: self.centre + reach,
        }
        .grown(self.error)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let d = ray.direction.as_dvec3();
        let to_centre = self.centre_f64 - ray.origin.as_dvec3();
        let (squared, along) = (d.length_squared(), to_centre.dot(d));
        // distance of the ray from the centre, without the cancellation of b² − 4ac; the division waits for nothing else
        let across = to_centre.cross(d);
        let half = self.radius_f64 * self.radius_f64 * squared - across.length_squared();
        if half < 0.0 {
            return None;
        }
        let (half, scale) = (half.sqrt(), squared.recip());
        let (near, far) = (
            ((along - half) * scale) as f32,
            ((along + half) * scale) as f32,
        );
        let t = if near > 0.0 { near } else { far };
        (t > 0.0 && t < t_max).then_some((t, 0.0, 0.0))
    }

    #[inline]
    pub(super) fn surface(&self, ray: &Ray, t: f32) -> Surface {
        let from_centre = ray.origin - self.centre + ray.direction * t;
        let along_u = self.pole.cross(from_centre) * self.sense;
        let (distance2, across2) = (from_centre.length_squared(), along_u.length_squared());
        // the two roots do not wait for each other
        let (outward, u) = (from_centre / distance2.sqrt(), along_u / across2.sqrt());
        let normal = outward * self.side;
        let frame = if across2 > 1e-4 * distance2 {
            // a cross product is perpendicular to its factors within a few roundings, and nearer to the poles after one
            // correction: so small that it leaves the length as it is
            let s = if across2 > 0.25 * distance2 {
                u
            } else {
                u - normal * normal.dot(u)
            };
            Frame {
                s,
                t: normal.cross(s),
                n: normal,
            }
        } else {
            Frame::with_tangent(normal, self.pole.cross(outward) * self.sense)
        };
        Surface {
            position: self.centre + outward * self.radius,
            error: self.error,
            normal,
            frame,
        }
    }

    pub(super) fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    /// sin² of the half angle under which the sphere is seen, if the reference point is outside.
    fn half_angle_sin2(&self, reference: Vec3A) -> Option<f32> {
        let distance2 = (self.centre - reference).length_squared();
        let sin2 = self.radius * self.radius / distance2;
        (sin2 < 1.0 - 1e-4).then_some(sin2)
    }

    /// The cone under which the front is seen from outside: its axis, 1 − cos of its half angle, distance of the centre.
    pub(crate) fn cone(&self, from: Vec3A) -> Option<(Frame, f32, f32)> {
        let sin2 = self.half_angle_sin2(from).filter(|_| self.side > 0.0)?;
        let to = self.centre - from;
        let distance = to.length();
        Some((
            Frame::around(to / distance),
            Self::one_minus_cos(sin2),
            distance,
        ))
    }

    /// The first point along a direction, or the nearest to it if rounding misses the rim.
    pub(crate) fn nearest_along(&self, from: Vec3A, direction: Vec3A) -> Target {
        let to_centre = self.centre_f64 - from.as_dvec3();
        let d = direction.as_dvec3();
        let along = to_centre.dot(d);
        let across = d * along - to_centre;
        let radius = f64::from(self.radius);
        let depth = (radius * radius - across.length_squared()).max(0.0).sqrt();
        let outward = (across - d * depth).normalize().as_vec3a();
        Target {
            position: self.centre + outward * self.radius,
            error: self.error,
            normal: outward * self.side,
        }
    }

    /// 1 − cos of the half angle, without cancellation.
    fn one_minus_cos(sin2: f32) -> f32 {
        sin2 / (1.0 + (1.0 - sin2).sqrt())
    }

    /// Uniform over the cone under which the sphere is seen; by area from inside or very near.
    pub(super) fn sample(&self, reference: Vec3A, u: [f32; 2]) -> Option<AreaSample> {
        let Some(sin2_max) = self.half_angle_sin2(reference) else {
            let z = 1.0 - 2.0 * u[0];
            let (sin, cos) = (TAU * u[1]).sin_cos();
            let outward = Vec3A::new(cos, sin, 0.0) * (1.0 - z * z).max(0.0).sqrt() + Vec3A::Z * z;
            let point = (
                self.centre + outward * self.radius,
                self.error,
                outward * self.side,
            );
            return by_area(point, self.area(), reference);
        };
        let cap = Self::one_minus_cos(sin2_max);
        // angle at the reference point, then at the centre: Pharr et al., PBR 4th ed., section 6.2.4
        let rise = cap * u[0];
        let sin2 = rise * (2.0 - rise);
        let cos = 1.0 - rise;
        let cos_alpha = sin2 / sin2_max.sqrt() + cos * (1.0 - sin2 / sin2_max).max(0.0).sqrt();
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        let axis = Frame::around((reference - self.centre).normalize());
        let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
        let outward = axis.to_world(Vec3A::new(
            sin_alpha * cos_phi,
            sin_alpha * sin_phi,
            cos_alpha,
        ));
        Some(AreaSample {
            position: self.centre + outward * self.radius,
            error: self.error,
            normal: outward * self.side,
            pdf: (TAU * cap).recip(),
        })
    }

    pub(super) fn pdf(&self, reference: Vec3A, at: &Surface) -> f32 {
        match self.half_angle_sin2(reference) {
            Some(sin2) => (TAU * Self::one_minus_cos(sin2)).recip(),
            None => solid_angle_density(self.area(), reference, at.position, at.normal),
        }
    }
}
