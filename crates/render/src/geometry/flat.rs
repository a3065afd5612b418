//! Watertight intersection of a ray with four flat primitives at once: triangles and parallelograms.
//!
//! Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013. Vertices are sheared into a
//! frame in which the ray is the z axis; a shared edge gives numbers that are each other's exact negatives in both
//! triangles, so that no ray slips between them. Portable lanes (`Vec4`), no fused multiply-adds: these would break
//! the symmetry.

use glam::{BVec4A, Vec3A, Vec4};

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

/// A triangle, or the parallelogram of which three corners are given (the fourth is `b + c − a`).
#[derive(Clone, Copy, Debug)]
pub struct Flat {
    /// Corners a, b, c.
    pub corners: [Vec3A; 3],
    /// Whether it goes on to the fourth corner.
    pub parallelogram: bool,
}

/// Up to four flat primitives, corner by corner and axis by axis; unused lanes have no area, so that nothing hits them.
#[derive(Clone, Copy, Debug)]
pub struct FlatBlock {
    corners: [[Vec4; 3]; 3],
    /// Lanes that are parallelograms.
    parallelograms: BVec4A,
    /// Index of each in the scene.
    indices: [u32; 4],
}

/// A hit on one of the four.
#[derive(Clone, Copy, Debug)]
pub struct BlockHit {
    /// Position along the ray.
    pub t: f32,
    /// Index of the primitive in the scene.
    pub primitive: u32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

impl FlatBlock {
    /// Packs at most four primitives given with their index.
    pub fn new(flats: &[(u32, Flat)]) -> Self {
        debug_assert!(!flats.is_empty() && flats.len() <= 4);
        let mut corners = [[Vec4::ZERO; 3]; 3];
        let mut indices = [u32::MAX; 4];
        let mut parallelograms = [false; 4];
        for lane in 0..4 {
            // an unused lane repeats one corner
            let unused = (
                u32::MAX,
                Flat {
                    corners: [flats[0].1.corners[0]; 3],
                    parallelogram: false,
                },
            );
            let (index, flat) = flats.get(lane).copied().unwrap_or(unused);
            indices[lane] = index;
            parallelograms[lane] = flat.parallelogram;
            for (axes, point) in corners.iter_mut().zip(flat.corners) {
                for (axis, lanes) in axes.iter_mut().enumerate() {
                    lanes[lane] = point[axis];
                }
            }
        }
        Self {
            corners,
            parallelograms: BVec4A::from_array(parallelograms),
            indices,
        }
    }

    /// The nearest hit closer than `t_max`.
    #[inline]
    pub fn intersect(&self, shear: &Shear, t_max: f32) -> Option<BlockHit> {
        let [kx, ky, kz] = shear.axes;
        // said once, so that the accesses below need no check
        assert!(kx < 3 && ky < 3 && kz < 3, "axes are x, y, z");
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
        let zero = Vec4::ZERO;
        let det = u + v + w;
        // a triangle ends where one of the three changes sign, a parallelogram where v or w leaves 0 … det;
        // zeros count as inside of both neighbours
        let third = Vec4::select(self.parallelograms, (det - v).min(det - w), u);
        let other = Vec4::select(self.parallelograms, (det - v).max(det - w), u);
        let lowest = third.min(v).min(w);
        let highest = other.max(v).max(w);
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
            primitive: self.indices[lane],
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

    fn triangle(corners: [Vec3A; 3]) -> Flat {
        Flat {
            corners,
            parallelogram: false,
        }
    }

    #[test]
    fn a_parallelogram_is_its_two_triangles() {
        let (a, b, c) = (
            Vec3A::new(-1.0, -0.5, 0.0),
            Vec3A::new(1.2, -0.3, 0.4),
            Vec3A::new(-0.7, 0.9, -0.1),
        );
        let whole = FlatBlock::new(&[(
            0,
            Flat {
                corners: [a, b, c],
                parallelogram: true,
            },
        )]);
        let halves = FlatBlock::new(&[(0, triangle([a, b, c])), (0, triangle([b, b + c - a, c]))]);
        let origin = Vec3A::new(0.3, 0.2, 3.0);
        let mut hits = 0;
        for i in 0..200 {
            for j in 0..200 {
                let target = Vec3A::new(-2.0 + 0.0217 * i as f32, -2.0 + 0.0213 * j as f32, 0.0);
                let r = ray(origin, target - origin);
                let [one, two] =
                    [&whole, &halves].map(|b| b.intersect(&Shear::new(&r), f32::INFINITY));
                assert_eq!(one.is_some(), two.is_some(), "{target}");
                if let (Some(one), Some(two)) = (one, two) {
                    hits += 1;
                    assert!((one.t - two.t).abs() < 1e-5);
                    let p = a + (b - a) * one.u + (c - a) * one.v;
                    assert!((origin + r.direction * one.t - p).length() < 1e-5);
                }
            }
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn a_hit_gives_distance_and_barycentric_weights() {
        let corners = [Vec3A::ZERO, Vec3A::X * 2.0, Vec3A::Y * 4.0];
        let block = FlatBlock::new(&[(7, triangle(corners))]);
        let r = ray(Vec3A::new(0.5, 1.0, 3.0), Vec3A::NEG_Z);
        let hit = block
            .intersect(&Shear::new(&r), f32::INFINITY)
            .expect("the ray points at the triangle");
        assert_eq!((hit.t, hit.primitive, hit.u, hit.v), (3.0, 7, 0.25, 0.25));
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
        let block = FlatBlock::new(&[(0, triangle([a, b, c])), (1, triangle([a, c, d]))]);
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
