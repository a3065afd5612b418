//! `cube`: the box [−1, 1]³ of local space under any affine map; normals outward; axis U as Mitsuba's per face.

use glam::{DMat3, DMat4, DVec3, Vec3A};

use super::{Columns, Surface};
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, gamma};

/// A parallelepiped in world space.
#[derive(Clone, Debug)]
pub struct Cube {
    pub(super) centre: Vec3A,
    /// Half edges.
    pub(super) edges: [Vec3A; 3],
    /// Covectors: local coordinate i is `rows[i] · (p − centre)`.
    pub(super) rows: [Vec3A; 3],
    /// Frames of the faces −x, +x, −y, +y, −z, +z.
    pub(super) faces: [Frame; 6],
    pub(super) error: Vec3A,
    /// Areas of the faces across x, y, z.
    areas: [f32; 3],
}

impl Cube {
    /// From the local-to-world transform, which must not be singular.
    pub fn new(to_world: &DMat4, flip_normals: bool) -> Self {
        let c = Columns::of(to_world);
        let edges = [c.x, c.y, c.z];
        let inverse = DMat3::from_cols(c.x, c.y, c.z).inverse();
        let rows = [inverse.row(0), inverse.row(1), inverse.row(2)];
        // axis U of each face, as measured in Mitsuba 3.9.1
        let tangents = [c.y, c.y, c.z, -c.x, -c.y, c.y];
        let faces = std::array::from_fn(|face| {
            let outward = rows[face / 2].normalize() * if face % 2 == 1 { 1.0 } else { -1.0 };
            let frame = Frame::with_tangent(outward.as_vec3a(), tangents[face].as_vec3a());
            if flip_normals { frame.flipped() } else { frame }
        });
        let edges_f32 = edges.map(DVec3::as_vec3a);
        let reach = edges_f32.iter().fold(Vec3A::ZERO, |sum, e| sum + e.abs());
        Self {
            centre: c.origin.as_vec3a(),
            edges: edges_f32,
            rows: rows.map(DVec3::as_vec3a),
            faces,
            error: (c.origin.as_vec3a().abs() + reach) * gamma(8)
                + Vec3A::splat(reach.length() * gamma(8)),
            areas: [0, 1, 2]
                .map(|i| 4.0 * edges[(i + 1) % 3].cross(edges[(i + 2) % 3]).length() as f32),
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        let reach = self.edges.iter().fold(Vec3A::ZERO, |sum, e| sum + e.abs());
        Bounds {
            min: self.centre - reach,
            max: self.centre + reach,
        }
        .grown(self.error)
    }

    /// `u` is the index of the face.
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let from = ray.origin - self.centre;
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        let (mut near_face, mut far_face) = (0, 0);
        for axis in 0..3 {
            let o = self.rows[axis].dot(from);
            let inverse = self.rows[axis].dot(ray.direction).recip();
            let (a, b) = ((-1.0 - o) * inverse, (1.0 - o) * inverse);
            let low_first = inverse >= 0.0;
            let (enter, leave) = if low_first { (a, b) } else { (b, a) };
            // comparisons are false for NaN: a ray within the plane of a face is not clipped by it
            if enter > near {
                near = enter;
                near_face = 2 * axis + usize::from(!low_first);
            }
            if leave < far {
                far = leave;
                far_face = 2 * axis + usize::from(low_first);
            }
        }
        if near > far {
            return None;
        }
        let (t, face) = if near > 0.0 {
            (near, near_face)
        } else {
            (far, far_face)
        };
        (t > 0.0 && t < t_max).then_some((t, face as f32, 0.0))
    }

    #[inline]
    pub(super) fn surface(&self, ray: &Ray, (t, face, _): (f32, f32, f32)) -> Surface {
        let face = face as usize;
        let p = ray.origin - self.centre + ray.direction * t;
        let mut local = [0, 1, 2].map(|axis| self.rows[axis].dot(p).clamp(-1.0, 1.0));
        local[face / 2] = if face % 2 == 1 { 1.0 } else { -1.0 };
        Surface {
            position: self.centre
                + self.edges[0] * local[0]
                + self.edges[1] * local[1]
                + self.edges[2] * local[2],
            error: self.error,
            normal: self.faces[face].n,
            frame: self.faces[face],
        }
    }

    pub(super) fn area(&self) -> f32 {
        2.0 * self.areas.iter().sum::<f32>()
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec3A, Vec3A, Vec3A) {
        // choose a face by its area, then use the rest of the random number again
        let total = self.area();
        let mut rest = u[0] * total;
        let mut face = 0;
        while face < 5 && rest >= self.areas[face / 2] {
            rest -= self.areas[face / 2];
            face += 1;
        }
        let axis = face / 2;
        let fraction = (rest / self.areas[axis]).clamp(0.0, 1.0);
        let side = if face % 2 == 1 { 1.0 } else { -1.0 };
        let position = self.centre
            + self.edges[axis] * side
            + self.edges[(axis + 1) % 3] * (2.0 * fraction - 1.0)
            + self.edges[(axis + 2) % 3] * (2.0 * u[1] - 1.0);
        (position, self.error, self.faces[face].n)
    }
}
