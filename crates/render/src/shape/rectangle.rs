//! `rectangle`: the square [−1, 1]² of the local xy plane, normal along local +z, axis U along local +x.

use glam::{DMat4, Vec3A};

use super::{Columns, Surface};
use crate::emitter::patch::Outline;
use crate::geometry::bvh::Bounds;
use crate::geometry::flat::Flat;
use crate::geometry::frame::Frame;
use crate::geometry::ray::gamma;

/// A parallelogram in world space.
#[derive(Clone, Debug)]
pub struct Rectangle {
    centre: Vec3A,
    half_u: Vec3A,
    half_v: Vec3A,
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
        Self {
            centre: c.origin.as_vec3a(),
            half_u,
            half_v,
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

    /// It as the search tree intersects it; the hit has parameters in [0, 1].
    pub(super) fn flat(&self) -> Flat {
        let corner = self.centre - self.half_u - self.half_v;
        Flat {
            corners: [
                corner,
                corner + self.half_u * 2.0,
                corner + self.half_v * 2.0,
            ],
            parallelogram: true,
        }
    }

    /// The surface at parameters in [0, 1] along U and V.
    #[inline]
    pub(super) fn surface(&self, u: f32, v: f32) -> Surface {
        Surface {
            position: self.centre + self.half_u * (2.0 * u - 1.0) + self.half_v * (2.0 * v - 1.0),
            error: self.error,
            normal: self.frame.n,
            frame: self.frame,
        }
    }

    pub(crate) fn outline(&self) -> Outline {
        Outline {
            centre: self.centre,
            half_u: self.half_u,
            half_v: self.half_v,
            normal: self.frame.n,
            round: false,
            error: self.error,
        }
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3A, Vec3A, Vec3A) {
        let at = self.surface(u[0], u[1]);
        (at.position, at.error, at.normal)
    }
}
