//! `rectangle`: the square [−1, 1]² of the local xy plane, normal along local +z, axis U along local +x.
//!
//! As a light source it is sampled by solid angle if it is a rectangle in the world too and near: far ones, of which the
//! density by area hardly varies, and skewed ones are sampled by area.

use glam::{DMat4, Vec3A};

use super::spherical_rectangle::SphericalRectangle;
use super::{AreaSample, Columns, Surface, by_area, solid_angle_density};
use crate::emitter::patch::Outline;
use crate::geometry::bvh::Bounds;
use crate::geometry::flat::Flat;
use crate::geometry::frame::Frame;
use crate::geometry::ray::gamma;

/// Squared distance of the middle, in squared half diagonals, beyond which points are drawn by area.
///
/// There the density by area, r³/(A h) at the height h, varies with the distance r alone: from 0.51 to 1.73 of what it is
/// in the middle.
const FAR: f32 = 25.0;

/// Height over the plane, in half diagonals, below which points are drawn by area: single precision does not know it.
const LOW: f64 = 1e-5;

/// A parallelogram in world space.
#[derive(Clone, Debug)]
pub struct Rectangle {
    centre: Vec3A,
    half_u: Vec3A,
    half_v: Vec3A,
    frame: Frame,
    error: Vec3A,
    area: f32,
    /// Half of its sides if these are perpendicular within 1e-6; zero if not.
    half: [f32; 2],
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
        let half = [c.x.length(), c.y.length()];
        let upright = c.x.dot(c.y).abs() <= 1e-6 * half[0] * half[1];
        Self {
            centre: c.origin.as_vec3a(),
            half_u,
            half_v,
            frame: if flip_normals { frame.flipped() } else { frame },
            error: (c.origin.as_vec3a().abs() + half_u.abs() + half_v.abs()) * gamma(8)
                + Vec3A::splat((half_u.length() + half_v.length()) * gamma(8)),
            area: 4.0 * across.length() as f32,
            half: half.map(|half| if upright { half as f32 } else { 0.0 }),
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

    /// It on the sphere of directions around a point, and where the foot of the perpendicular is; `None` if the point
    /// draws by area.
    #[inline]
    fn seen(&self, from: Vec3A) -> Option<(SphericalRectangle, [f64; 2])> {
        let [a, b] = self.half;
        let squared = a * a + b * b;
        if (from - self.centre).length_squared() > FAR * squared {
            return None;
        }
        let [a, b] = self.half.map(f64::from);
        let to = from.as_dvec3() - self.centre.as_dvec3();
        let height = to.dot(self.frame.n.as_dvec3()).abs();
        if height * height <= LOW * LOW * f64::from(squared) {
            return None;
        }
        let foot = [
            to.dot(self.half_u.as_dvec3()) / a,
            to.dot(self.half_v.as_dvec3()) / b,
        ];
        let sides = |half: f64, foot: f64| [-half - foot, half - foot];
        let seen = SphericalRectangle::new(sides(a, foot[0]), sides(b, foot[1]), height)?;
        Some((seen, foot))
    }

    /// A random point, for light that reaches `reference`.
    #[inline]
    pub(super) fn sample(&self, reference: Vec3A, u: [f32; 2]) -> Option<AreaSample> {
        let Some((seen, foot)) = self.seen(reference) else {
            let at = self.surface(u[0], u[1]);
            return by_area((at.position, at.error, at.normal), self.area, reference);
        };
        let at = seen.point(u);
        let [u, v] = [0, 1].map(|i| {
            let along = (at[i] + foot[i]) / f64::from(self.half[i]);
            (0.5 + 0.5 * along).clamp(0.0, 1.0) as f32
        });
        let at = self.surface(u, v);
        Some(AreaSample {
            position: at.position,
            error: at.error,
            normal: at.normal,
            pdf: seen.solid_angle().recip(),
        })
    }

    /// Density of [`Rectangle::sample`], per steradian.
    #[inline]
    pub(super) fn pdf(&self, reference: Vec3A, at: &Surface) -> f32 {
        match self.seen(reference) {
            Some((seen, _)) => seen.solid_angle().recip(),
            None => solid_angle_density(self.area, reference, at.position, at.normal),
        }
    }
}
