//! The way of a ray through the tree: nearest boxes first, or any hit at all; the same source for all instructions.

use super::bvh::Bvh;
use super::flat::Shear;
use super::lanes::{Lanes, Simd, Traversal};
use super::node::{FLATS, KIND, NODE, SHAPE, Slabs, WIDTH};
use super::ray::{Hit, Ray};

/// A child to be visited and where the ray enters it. Distances are not negative, so that the order of their bits is
/// their order, and that of the pair.
#[inline(always)]
fn pair(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

impl Bvh {
    /// Says that a child will be read soon.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, child: u32) {
        let index = (child & !KIND) as usize;
        if child < FLATS {
            simd.prefetch(&self.nodes[index]);
        } else if child < SHAPE {
            simd.prefetch(&self.blocks[index]);
        }
    }
}

/// Visits what a ray may hit; with `ANY` the first hit ends the search.
pub(super) struct Walk<'a, const ANY: bool, F> {
    pub(super) bvh: &'a Bvh,
    pub(super) ray: &'a Ray,
    pub(super) stack: &'a mut [u64],
    /// Intersects a primitive that is not flat, up to a distance.
    pub(super) shape: F,
}

impl<const ANY: bool, F> Traversal for Walk<'_, ANY, F>
where
    F: Fn(u32, f32) -> Option<(f32, f32, f32)>,
{
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Hit> {
        let Self {
            bvh,
            ray,
            stack,
            shape,
        } = self;
        let shear = Shear::new(ray).spread(simd);
        let slabs = Slabs::new(simd, ray, bvh.reach);
        let mut best: Option<Hit> = None;
        let mut t_max = ray.t_max;
        let mut limit = <S as Lanes<WIDTH>>::splat(simd, t_max);
        let mut pending = 0;
        let mut current = NODE;
        loop {
            if current < FLATS {
                let node = &bvh.nodes[current as usize];
                let (mut mask, near) = node.meet(simd, &slabs, limit);
                if mask != 0 {
                    let near: [f32; WIDTH] = simd.store(near);
                    let mut next = || {
                        let lane = mask.trailing_zeros() as usize % WIDTH;
                        mask &= mask - 1;
                        if !ANY || mask != 0 {
                            bvh.prefetch(simd, node.children[lane]);
                        }
                        (mask, pair(near[lane], node.children[lane]))
                    };
                    let (left, a) = next();
                    if left == 0 {
                        current = a as u32;
                        continue;
                    }
                    let (mut left, b) = next();
                    let (mut first, second) = (a.min(b), a.max(b));
                    let base = pending;
                    stack[pending] = second;
                    pending += 1;
                    while left != 0 {
                        let (rest, c) = next();
                        left = rest;
                        // insertion: the nearest ends on top
                        let mut moving = first.max(c);
                        first = first.min(c);
                        if !ANY {
                            let mut place = pending;
                            while place > base && stack[place - 1] < moving {
                                stack[place] = stack[place - 1];
                                place -= 1;
                            }
                            std::mem::swap(&mut stack[place], &mut moving);
                        } else {
                            stack[pending] = moving;
                        }
                        pending += 1;
                    }
                    current = first as u32;
                    continue;
                }
            } else {
                let index = current & !KIND;
                let found = if current < SHAPE {
                    bvh.blocks[index as usize].meet(simd, &shear, t_max)
                } else {
                    shape(index, t_max).map(|(t, u, v)| Hit {
                        t,
                        primitive: index,
                        u,
                        v,
                    })
                };
                if let Some(hit) = found {
                    best = found;
                    if ANY {
                        return best;
                    }
                    t_max = hit.t;
                    limit = <S as Lanes<WIDTH>>::splat(simd, t_max);
                }
            }
            let end = pair(t_max, 0);
            loop {
                if pending == 0 {
                    return best;
                }
                pending -= 1;
                if stack[pending] < end {
                    current = stack[pending] as u32;
                    break;
                }
            }
        }
    }
}
