//! `rectangle`: the square [−1, 1]² of the local xy plane, normal along local +z, axis U along local +x.
//!
//! As a light source it is sampled by solid angle if it is a rectangle in the world too and near: far ones, of which the
//! density by area varies little, those seen almost from their plane, and skewed ones are sampled by area.

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
/// There the density by area, r³/(A h) at the height h, varies with the distance r alone: from 1/8 to 3.4 of what it is in
/// the middle, and far less for who faces the lamp. Solid angles of farther lamps cost more than they are worth.
pub(super) const FAR: f32 = 4.0;

/// Height over the plane, in half diagonals, below which points are drawn by area: single precision does not know it.
pub(super) const LOW: f64 = 1e-5;

/// A parallelogram in world space.
#[derive(Clone, Debug)]
pub struct Rectangle {
    pub(super) centre: Vec3A,
    pub(super) half_u: Vec3A,
    pub(super) half_v: Vec3A,
    pub(super) frame: Frame,
    pub(super) error: Vec3A,
    area: f32,
    /// Half of its sides if these are perpendicular within 1e-6; zero if not.
    pub(super) half: [f32; 2],
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

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3, dvec3};

    use super::*;
    use crate::geometry::ray::Ray;
    use crate::shape::Shape;

    fn rectangle(half: [f64; 2], turn: DQuat, scale: f64) -> Rectangle {
        let size = dvec3(half[0], half[1], 1.0) * scale;
        let place = dvec3(0.3, -0.2, 0.5) * scale;
        Rectangle::new(
            &DMat4::from_scale_rotation_translation(size, turn, place),
            false,
        )
    }

    fn turns() -> [DQuat; 2] {
        [
            DQuat::IDENTITY,
            DQuat::from_rotation_arc(DVec3::Z, dvec3(0.48, 0.6, 0.64)),
        ]
    }

    /// Directions from the middle to points that see the front: over it, beside it, far, near, grazing.
    const AWAY: [DVec3; 8] = [
        dvec3(0.0, 0.0, 2.0),
        dvec3(0.1, 0.2, 0.05),
        dvec3(0.9, -0.9, 1e-3),
        dvec3(2.0, 0.5, 0.3),
        dvec3(1.5, 1.5, 1e-3),
        dvec3(-4.0, 1.0, 0.01),
        dvec3(3.0, 4.0, 2.0),
        dvec3(30.0, 40.0, 20.0),
    ];

    /// A point in front of a rectangle, its place in units of the longer half side.
    fn before(at: &Rectangle, away: DVec3, turn: DQuat) -> Vec3A {
        let unit = at.half[0].max(at.half[1]);
        at.centre + (turn * away).as_vec3a() * unit
    }

    #[test]
    fn a_hit_has_the_density_with_which_its_point_is_drawn() {
        let mut by_solid_angle = 0;
        for (half, turn) in [[1.0, 1.0], [1.0, 1e-3], [0.2, 3.0]]
            .into_iter()
            .flat_map(|h| turns().map(|t| (h, t)))
        {
            for scale in [1e-6, 1.0, 1e6] {
                let at = rectangle(half, turn, scale);
                for away in AWAY {
                    let from = before(&at, away, turn);
                    for u in [[0.0, 0.0], [0.3, 0.8], [0.999_999, 0.5]] {
                        let drawn = at.sample(from, u).unwrap();
                        let to = drawn.position - from;
                        let ray = Ray {
                            origin: from,
                            direction: to,
                            t_max: f32::INFINITY,
                        };
                        // where the ray meets the plane, as the search tree hands it on
                        let t = (at.centre - from).dot(at.frame.n) / to.dot(at.frame.n);
                        let place = from + ray.direction * t - at.centre;
                        let share =
                            |half: Vec3A| 0.5 + 0.5 * place.dot(half) / half.length_squared();
                        let hit = at.surface(share(at.half_u), share(at.half_v));
                        let ratio = at.pdf(from, &hit) / drawn.pdf;
                        if at.seen(from).is_some() {
                            by_solid_angle += 1;
                            assert_eq!(ratio, 1.0, "{half:?} {scale} {away} {u:?}");
                        } else {
                            // places round by 3e-7 of the size, and heights are 1e-3 of it
                            assert!(
                                (ratio - 1.0).abs() < 1e-3,
                                "{half:?} {scale} {away} {u:?}: {ratio}"
                            );
                        }
                    }
                }
            }
        }
        assert!(by_solid_angle > 100, "{by_solid_angle}");
    }

    /// Irradiance of the rectangle for a radiance of 1, at a point with a normal.
    ///
    /// Source: Lambert, Photometria, 1760.
    fn irradiance(at: &Rectangle, from: Vec3A, normal: Vec3A) -> f64 {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(u, v)| (at.surface(u, v).position.as_dvec3() - from.as_dvec3()).normalize());
        let edge = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let across = a.cross(b);
            0.5 * across.length().atan2(a.dot(b)) * across.normalize().dot(normal.as_dvec3())
        };
        (0..4).map(edge).sum::<f64>().abs()
    }

    /// Mean and variance of what even numbers make of the irradiance, drawn by solid angle or by area.
    fn estimate(at: &Rectangle, from: Vec3A, normal: Vec3A, area: bool) -> [f64; 2] {
        const STEPS: u32 = 300;
        let (mut sum, mut square) = (0.0, 0.0);
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
            let u = [i, j].map(|k| (k as f32 + 0.5) / STEPS as f32);
            let drawn = if area {
                let at_u = at.surface(u[0], u[1]);
                by_area((at_u.position, at_u.error, at_u.normal), at.area, from)
            } else {
                at.sample(from, u)
            }
            .unwrap();
            let to = (drawn.position - from).normalize();
            let light = f64::from(to.dot(normal).max(0.0) / drawn.pdf);
            sum += light;
            square += light * light;
        }
        let n = f64::from(STEPS * STEPS);
        [sum / n, square / n - (sum / n).powi(2)]
    }

    #[test]
    fn the_irradiance_is_lamberts_with_less_noise_than_by_area() {
        for (half, turn) in [[1.0, 1.0], [1.0, 0.02], [0.2, 3.0]]
            .into_iter()
            .flat_map(|h| turns().map(|t| (h, t)))
        {
            let at = rectangle(half, turn, 1.0);
            for away in AWAY {
                let from = before(&at, away, turn);
                // all of the lamp is above the horizon
                let normal = -at.frame.n;
                let expected = irradiance(&at, from, normal);
                let [mean, variance] = estimate(&at, from, normal, false);
                let [_, by_area] = estimate(&at, from, normal, true);
                // single precision knows a height of 1e-3 within 1e-4 of itself; even steps err by far less
                let bound = 1e-3;
                println!(
                    "{half:?} {away}: {mean:.6e} for {expected:.6e}; variance {variance:.3e}, by area {by_area:.3e}"
                );
                assert!(
                    (mean / expected - 1.0).abs() < bound,
                    "{half:?} {away}: {mean} {expected}"
                );
                if at.seen(from).is_some() {
                    assert!(variance < by_area, "{half:?} {away}: {variance} {by_area}");
                }
            }
        }
    }

    #[test]
    fn skewed_far_and_touching_lamps_are_drawn_by_area() {
        let skewed = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        assert!(Rectangle::new(&skewed, false).seen(Vec3A::Z).is_none());
        let upright = Rectangle::new(&DMat4::IDENTITY, false);
        assert!(upright.seen(Vec3A::Z).is_some());
        assert!(upright.seen(Vec3A::Z * 2.8).is_some());
        assert!(upright.seen(Vec3A::Z * 2.9).is_none());
        assert!(upright.seen(Vec3A::Z * 1e-6).is_none());
        assert!(upright.seen(Vec3A::ZERO).is_none());
        // and seen from behind they are dark all the same: who connects looks at the normal
        let from_behind = Shape::Rectangle(upright)
            .sample(-Vec3A::Z, [0.5, 0.5])
            .unwrap();
        assert!(from_behind.normal.dot(from_behind.position + Vec3A::Z) > 0.0);
    }
}
