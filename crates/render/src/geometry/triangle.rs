//! Watertight intersection of a ray with four triangles at once.
//!
//! Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013. Vertices are sheared into a
//! frame in which the ray is the z axis; a shared edge gives numbers that are each other's exact negatives in both
//! triangles, so that no ray slips between them. Portable lanes (`Vec4`), no fused multiply-adds: these would break
//! the symmetry.

use glam::{Vec3A, Vec4};

use super::ray::Ray;

/// What a ray contributes to the test, computed once a ray.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 3],
}

impl Shear {
    /// The frame in which the ray runs along z.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let size = ray.direction.abs();
        let z = if size.x > size.y {
            if size.x > size.z { 0 } else { 2 }
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let inverse = d[z].recip();
        Self {
            axes: [x, y, z],
            origin: ray.origin.to_array(),
            shear: [d[x] * inverse, d[y] * inverse, inverse],
        }
    }
}

/// Up to four triangles, corner by corner and axis by axis; unused lanes hold points at infinity that nothing hits.
#[derive(Clone, Copy, Debug)]
pub struct TriangleBlock {
    corners: [[Vec4; 3]; 3],
    /// Index of each triangle in the scene.
    pub triangles: [u32; 4],
}

/// A hit on one of four triangles.
#[derive(Clone, Copy, Debug)]
pub struct BlockHit {
    /// Position along the ray.
    pub t: f32,
    /// Index of the triangle in the scene.
    pub triangle: u32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

impl TriangleBlock {
    /// Packs at most four triangles given as (index, corners).
    pub fn new(triangles: &[(u32, [Vec3A; 3])]) -> Self {
        debug_assert!(!triangles.is_empty() && triangles.len() <= 4);
        let mut corners = [[Vec4::ZERO; 3]; 3];
        let mut indices = [u32::MAX; 4];
        for lane in 0..4 {
            // an unused lane repeats one corner: a triangle of no area, which no ray hits
            let (index, points) = triangles
                .get(lane)
                .copied()
                .unwrap_or((u32::MAX, [triangles[0].1[0]; 3]));
            indices[lane] = index;
            for corner in 0..3 {
                for axis in 0..3 {
                    corners[corner][axis][lane] = points[corner][axis];
                }
            }
        }
        Self {
            corners,
            triangles: indices,
        }
    }

    /// The nearest hit closer than `t_max`.
    #[inline]
    pub fn intersect(&self, shear: &Shear, t_max: f32) -> Option<BlockHit> {
        let [kx, ky, kz] = shear.axes;
        let [sx, sy, sz] = shear.shear.map(Vec4::splat);
        let (ox, oy, oz) = (
            Vec4::splat(shear.origin[kx]),
            Vec4::splat(shear.origin[ky]),
            Vec4::splat(shear.origin[kz]),
        );
        let sheared = |corner: &[Vec4; 3]| {
            let z = corner[kz] - oz;
            ((corner[kx] - ox) - sx * z, (corner[ky] - oy) - sy * z, z)
        };
        let (ax, ay, az) = sheared(&self.corners[0]);
        let (bx, by, bz) = sheared(&self.corners[1]);
        let (cx, cy, cz) = sheared(&self.corners[2]);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let lowest = u.min(v).min(w);
        let highest = u.max(v).max(w);
        let zero = Vec4::ZERO;
        let det = u + v + w;
        // inside: no two of the three have opposite signs; zeros count as inside of both neighbours
        let inside = (lowest.cmpge(zero) | highest.cmple(zero)) & det.cmpne(zero);
        if !inside.any() {
            return None;
        }
        let inverse = det.recip();
        let t = (u * az + v * bz + w * cz) * sz * inverse;
        let hit = inside & t.cmpgt(zero) & t.cmplt(Vec4::splat(t_max));
        let mut mask = hit.bitmask();
        if mask == 0 {
            return None;
        }
        let t = t.to_array();
        let mut lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        while mask != 0 {
            let other = mask.trailing_zeros() as usize;
            if t[other] < t[lane] {
                lane = other;
            }
            mask &= mask - 1;
        }
        Some(BlockHit {
            t: t[lane],
            triangle: self.triangles[lane],
            u: (v * inverse)[lane],
            v: (w * inverse)[lane],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: Vec3A, direction: Vec3A) -> Ray {
        Ray {
            origin,
            direction,
            t_max: f32::INFINITY,
        }
    }

    #[test]
    fn a_hit_gives_distance_and_barycentric_weights() {
        let corners = [Vec3A::ZERO, Vec3A::X * 2.0, Vec3A::Y * 4.0];
        let block = TriangleBlock::new(&[(7, corners)]);
        let r = ray(Vec3A::new(0.5, 1.0, 3.0), Vec3A::NEG_Z);
        let hit = block
            .intersect(&Shear::new(&r), f32::INFINITY)
            .expect("the ray points at the triangle");
        assert_eq!((hit.t, hit.triangle, hit.u, hit.v), (3.0, 7, 0.25, 0.25));
        assert!(block.intersect(&Shear::new(&r), 2.9).is_none());
        let behind = ray(Vec3A::new(0.5, 1.0, -3.0), Vec3A::NEG_Z);
        assert!(
            block
                .intersect(&Shear::new(&behind), f32::INFINITY)
                .is_none()
        );
    }

    #[test]
    fn no_ray_slips_between_two_triangles_that_share_an_edge() {
        let (a, b, c, d) = (
            Vec3A::new(-1.0, -1.0, 0.1),
            Vec3A::new(1.3, -0.9, 0.0),
            Vec3A::new(0.9, 1.1, -0.2),
            Vec3A::new(-1.2, 0.8, 0.05),
        );
        let block = TriangleBlock::new(&[(0, [a, b, c]), (1, [a, c, d])]);
        let origin = Vec3A::new(0.2, 0.1, 5.0);
        for i in 0..20_000 {
            // aimed exactly at the shared edge a–c
            let f = 0.001 + 0.998 * i as f32 / 20_000.0;
            let r = ray(origin, a + (c - a) * f - origin);
            assert!(
                block.intersect(&Shear::new(&r), f32::INFINITY).is_some(),
                "leak at {f}"
            );
        }
    }
}
