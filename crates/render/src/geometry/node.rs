//! Eight boxes side by side, and the test of a ray against them, which loses nothing.
//!
//! The test of a flat primitive ([`super::flat`]) works with sheared corners that are each wrong by up to 7 ε L, where
//! ε = 2⁻²⁴ and L is the largest coordinate of the corner seen from the ray's origin. What it finds may therefore lie
//! beside the ray by that much: if `P` is the point of the primitive that it finds and `q` the point of the ray beside
//! it at parameter `t`, then
//!
//! ```text
//! |q − P| ≤ 7 ε (|P − o| + extent of the primitive) in every coordinate,   |P − o| ≈ t |d_z|,
//! ```
//!
//! with `d_z` the largest component of the direction. The extent's part is in the boxes ([`super::bounds`]). The rest is
//! relative to `t`: on axis x the slab's near side is moved nearer by the factor 1 − 32 ε |d_z/d_x|, the far side
//! farther by 1 + 32 ε |d_z/d_x|. 32 is above 1.125 × (3 × 7.1 + 5.1): three corners stand for the fourth one of a
//! parallelogram, five roundings are the slab's own, and 1.125 bounds what the product of both factors takes back.
//! Where |d_x| is so small that the factor would leave 1 ± 1/8, the slab is widened instead by 32 ε of the largest
//! coordinate distance in the scene. A box is thus passed over only if no primitive in it can be found nearer than
//! `t_max`, up to the rounding of that distance; and this holds at every scale.
//!
//! Source of the relative margin: Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013.

use glam::Vec3A;

use super::lanes::Lanes;
use super::ray::Ray;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Eight boxes, side by side, and what is in them: four cache lines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `[axis][0: lowest, 1: highest]`.
    bounds: [[[f32; WIDTH]; 2]; 3],
    /// Two bits of kind, thirty of index.
    pub(super) children: [u32; WIDTH],
}

/// Kinds of children, in the two highest bits.
pub(super) const KIND: u32 = 0xC000_0000;
/// Another node.
pub(super) const NODE: u32 = 0x0000_0000;
/// Up to four flat primitives.
pub(super) const FLATS: u32 = 0x4000_0000;
/// One primitive of another kind.
pub(super) const SHAPE: u32 = 0x8000_0000;

impl Node {
    /// Eight boxes that nothing hits.
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [0; WIDTH],
    };

    /// Puts a child into a lane.
    pub(super) fn place(&mut self, lane: usize, min: [f32; 3], max: [f32; 3], child: u32) {
        for axis in 0..3 {
            self.bounds[axis][0][lane] = min[axis];
            self.bounds[axis][1][lane] = max[axis];
        }
        self.children[lane] = child;
    }

    /// Which boxes the ray meets before `t_max`, and where it enters them.
    #[inline(always)]
    pub(super) fn meet<S: Lanes<WIDTH>>(
        &self,
        simd: S,
        slabs: &Slabs<S::F>,
        t_max: S::F,
    ) -> (u32, S::F) {
        let (mut near, mut far) = (slabs.zero, t_max);
        for axis in 0..3 {
            let (bounds, slab) = (&self.bounds[axis], &slabs.axes[axis]);
            let low = simd.load(&bounds[(slab.side ^ 1) & 1]);
            let high = simd.load(&bounds[slab.side & 1]);
            let low = simd.mul(simd.sub(low, slab.origin[0]), slab.inverse[0]);
            let high = simd.mul(simd.sub(high, slab.origin[1]), slab.inverse[1]);
            // the accumulator comes second: it survives a NaN (a ray within the plane of a side)
            near = simd.max(low, near);
            far = simd.min(high, far);
        }
        (simd.le(near, far), near)
    }
}

/// What a ray contributes to the test on one axis; of the sides that come nearer and farther along it.
#[derive(Clone, Copy, Debug)]
struct Slab<F> {
    /// Which side is the far one.
    side: usize,
    origin: [F; 2],
    inverse: [F; 2],
}

/// What a ray contributes to the test, computed once a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs<F> {
    axes: [Slab<F>; 3],
    zero: F,
}

/// In units of the largest component of the direction over that of the axis.
const MARGIN: f32 = 16.0 * f32::EPSILON;

impl<F: Copy> Slabs<F> {
    /// `reach` is the largest coordinate in the scene.
    #[inline(always)]
    pub(super) fn new<S: Lanes<WIDTH, F = F>>(simd: S, ray: &Ray, reach: f32) -> Self {
        let margin = MARGIN * ray.direction.abs().max_element();
        let widening = MARGIN * (ray.origin.abs().max_element() + reach);
        // the three axes at once
        let (origin, inverse) = (ray.origin, ray.direction.recip());
        let slack = inverse.abs() * margin;
        let is_small = slack.cmple(Vec3A::splat(0.125));
        let widening = Vec3A::splat(widening).copysign(ray.direction);
        let widening = Vec3A::select(is_small, Vec3A::ZERO, widening);
        let slack = Vec3A::select(is_small, slack, Vec3A::ZERO);
        let origins = [origin + widening, origin - widening].map(|v| v.to_array());
        let inverses = [inverse * (1.0 - slack), inverse * (1.0 + slack)].map(|v| v.to_array());
        // of the inverse: a component of −0 runs toward −∞
        let negative = inverse.is_negative_bitmask();
        let slab = |axis: usize| Slab {
            side: usize::from(negative & 1 << axis == 0),
            origin: origins.map(|o| simd.splat(o[axis])),
            inverse: inverses.map(|i| simd.splat(i[axis])),
        };
        Self {
            axes: [slab(0), slab(1), slab(2)],
            zero: simd.splat(0.0),
        }
    }
}
