//! Watertight intersection of a ray with four flat primitives at once: triangles and parallelograms.
//!
//! Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013. Vertices are sheared into a
//! frame in which the ray is the z axis; a shared edge gives numbers that are each other's exact negatives in both
//! triangles, so that no ray slips between them. No fused multiply-adds: these would break the symmetry.

use glam::Vec3A;

use super::lanes::{Lanes, Portable};
use super::ray::{Hit, Ray};

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

/// [`Shear`] in every lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpreadShear<F> {
    axes: [usize; 3],
    origin: [F; 3],
    shear: [F; 3],
}

impl Shear {
    #[inline(always)]
    pub(super) fn spread<S: Lanes<BLOCK>>(&self, simd: S) -> SpreadShear<S::F> {
        let ([x, y, z], o, [sx, sy, sz]) = (self.axes, self.origin, self.shear);
        SpreadShear {
            axes: self.axes,
            origin: [simd.splat(o[x]), simd.splat(o[y]), simd.splat(o[z])],
            shear: [simd.splat(sx), simd.splat(sy), simd.splat(sz)],
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

/// Flat primitives in a block.
pub(super) const BLOCK: usize = 4;

/// Marks a parallelogram; the rest is the index in the scene.
const PARALLELOGRAM: u32 = 1 << 31;

/// Up to four flat primitives, corner by corner and axis by axis; unused lanes have no area, so that nothing hits them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct FlatBlock {
    corners: [[[f32; BLOCK]; 3]; 3],
    /// Index of each in the scene, and whether it is a parallelogram.
    tags: [u32; BLOCK],
}

impl FlatBlock {
    /// A block that nothing hits.
    pub(super) const EMPTY: Self = Self {
        corners: [[[0.0; BLOCK]; 3]; 3],
        tags: [0; BLOCK],
    };

    /// Packs at most four primitives given with their index.
    pub fn new(flats: &[(u32, Flat)]) -> Self {
        debug_assert!(!flats.is_empty() && flats.len() <= BLOCK);
        // an unused lane repeats one corner
        let unused = (
            0,
            Flat {
                corners: [flats[0].1.corners[0]; 3],
                parallelogram: false,
            },
        );
        let mut block = Self::EMPTY;
        for lane in 0..BLOCK {
            let (index, flat) = flats.get(lane).copied().unwrap_or(unused);
            block.tags[lane] = index | if flat.parallelogram { PARALLELOGRAM } else { 0 };
            for (axes, point) in block.corners.iter_mut().zip(flat.corners) {
                for (axis, lanes) in axes.iter_mut().enumerate() {
                    lanes[lane] = point[axis];
                }
            }
        }
        block
    }

    /// The nearest hit closer than `t_max`.
    pub fn intersect(&self, shear: &Shear, t_max: f32) -> Option<Hit> {
        self.meet(Portable, &shear.spread(Portable), t_max)
    }

    /// The nearest hit closer than `t_max`.
    #[inline(always)]
    pub(super) fn meet<S: Lanes<BLOCK>>(
        &self,
        simd: S,
        shear: &SpreadShear<S::F>,
        t_max: f32,
    ) -> Option<Hit> {
        let [kx, ky, kz] = shear.axes;
        // said once, so that the accesses below need no check
        assert!(kx < 3 && ky < 3 && kz < 3, "axes are x, y, z");
        let [ox, oy, oz] = shear.origin;
        let [sx, sy, sz] = shear.shear;
        let sheared = |corner: &[[f32; BLOCK]; 3]| {
            let z = simd.sub(simd.load(&corner[kz]), oz);
            let x = simd.sub(simd.load(&corner[kx]), ox);
            let y = simd.sub(simd.load(&corner[ky]), oy);
            (
                simd.sub(x, simd.mul(sx, z)),
                simd.sub(y, simd.mul(sy, z)),
                z,
            )
        };
        let (ax, ay, az) = sheared(&self.corners[0]);
        let (bx, by, bz) = sheared(&self.corners[1]);
        let (cx, cy, cz) = sheared(&self.corners[2]);
        let edge = |px, qy, qx, py| simd.sub(simd.mul(px, qy), simd.mul(qx, py));
        let u = edge(cx, by, bx, cy);
        let v = edge(ax, cy, cx, ay);
        let w = edge(bx, ay, ax, by);
        let det = simd.add(simd.add(u, v), w);
        // a triangle ends where one of the three changes sign, a parallelogram where v or w leaves 0 … det;
        // zeros count as inside of both neighbours
        let (mut third, mut other) = (u, u);
        let tags = simd.load_signs(&self.tags);
        if simd.signs(tags) != 0 {
            let (p, q) = (simd.sub(det, v), simd.sub(det, w));
            third = simd.select(tags, simd.min(p, q), u);
            other = simd.select(tags, simd.max(p, q), u);
        }
        let zero = simd.splat(0.0);
        let lowest = simd.min(simd.min(third, v), w);
        let highest = simd.max(simd.max(other, v), w);
        let inside = simd.le(zero, lowest) | simd.le(highest, zero);
        if inside == 0 {
            return None;
        }
        let inverse = simd.div(simd.splat(1.0), det);
        let depth = simd.add(simd.add(simd.mul(u, az), simd.mul(v, bz)), simd.mul(w, cz));
        // where the area vanishes this is not a number, and no hit
        let t = simd.mul(simd.mul(depth, sz), inverse);
        let mut mask = inside & simd.lt(zero, t) & simd.lt(t, simd.splat(t_max));
        if mask == 0 {
            return None;
        }
        let t = simd.store(t);
        let mut lane = mask.trailing_zeros() as usize % BLOCK;
        mask &= mask - 1;
        while mask != 0 {
            let other = mask.trailing_zeros() as usize % BLOCK;
            if t[other] < t[lane] {
                lane = other;
            }
            mask &= mask - 1;
        }
        Some(Hit {
            t: t[lane],
            primitive: self.tags[lane] & !PARALLELOGRAM,
            u: simd.store(simd.mul(v, inverse))[lane],
            v: simd.store(simd.mul(w, inverse))[lane],
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
