//! The bounding volume hierarchy: obvhs builds the binary tree, which is collapsed to four children a node.
//!
//! The only place that knows obvhs. Leaves hold either up to four flat primitives, tested at once, or one shape of
//! another kind, which the caller intersects. Boxes are tested with a rounding margin, so that nothing inside is lost.

use std::time::Duration;

use glam::{BVec4A, Vec3A, Vec4};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::Bvh2, bvh2::builder::build_bvh2};

use super::flat::{Flat, FlatBlock, Shear};
use super::ray::{Hit, Ray, gamma};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Lowest corner.
    pub min: Vec3A,
    /// Highest corner.
    pub max: Vec3A,
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub fn of(points: impl IntoIterator<Item = Vec3A>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// Grown by `margin` on every side.
    pub fn grown(self, margin: Vec3A) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }
}

/// What lies behind a child of a node.
#[derive(Clone, Copy, Debug)]
enum Child {
    Node(u32),
    Flats(u32),
    Shape(u32),
}

const KIND: u32 = 0xC000_0000;
const NODE: u32 = 0x0000_0000;
const FLATS: u32 = 0x4000_0000;
const SHAPE: u32 = 0x8000_0000;

/// Most primitives that a scene may have.
pub const MAX_PRIMITIVES: usize = !KIND as usize;

/// Four boxes, side by side, and what is in them.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// `[axis][0: lowest, 1: highest]`.
    bounds: [[Vec4; 2]; 3],
    /// Two bits of kind, thirty of index.
    children: [u32; 4],
}

/// What the tree holds.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// A triangle or a parallelogram.
    Flat(Flat),
    /// Something else, known by its box.
    Other(Bounds),
}

impl Primitive {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Flat(Flat {
                corners: [a, b, c],
                parallelogram,
            }) => {
                let bounds =
                    Bounds::of([*a, *b, *c, if *parallelogram { *b + *c - *a } else { *a }]);
                // the fourth corner is rounded
                let reach = bounds.min.abs().max(bounds.max.abs()) * gamma(4);
                if *parallelogram {
                    bounds.grown(reach)
                } else {
                    bounds
                }
            }
            Self::Other(bounds) => *bounds,
        }
    }
}

/// The tree over all primitives of a scene.
#[derive(Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<FlatBlock>,
    depth: usize,
}

/// Scratch space of a traversal: one a thread, so that tracing allocates nothing.
#[derive(Debug)]
pub struct Stack(Vec<(u32, f32)>);

impl Bvh {
    /// Builds the tree over primitives, which are known by their place in the list.
    pub fn build(primitives: &[Primitive]) -> Self {
        let boxes: Vec<Aabb> = primitives
            .iter()
            .map(Primitive::bounds)
            .map(|b| Aabb {
                min: b.min,
                max: b.max,
            })
            .collect();
        if boxes.is_empty() {
            return Self::default();
        }
        let mut parameters = BvhBuildParams::medium_build();
        parameters.max_prims_per_leaf = 1;
        let binary = build_bvh2(&boxes, parameters, &mut Duration::default());
        let mut collapse = Collapse {
            binary: &binary,
            primitives,
            bvh: Self::default(),
        };
        collapse.root();
        collapse.bvh
    }

    /// Scratch space large enough for this tree.
    pub fn stack(&self) -> Stack {
        Stack(vec![(0, 0.0); 3 * self.depth + 4])
    }

    /// Number of nodes and of blocks of flat primitives.
    pub fn size(&self) -> (usize, usize) {
        (self.nodes.len(), self.blocks.len())
    }

    /// Visits what the ray may hit, nearest boxes first; `t_max` shrinks with every hit that is reported.
    ///
    /// `shape(primitive, t_max)` intersects a primitive that is not flat. With `ANY` the first hit ends the search.
    #[inline]
    pub fn traverse<const ANY: bool>(
        &self,
        ray: &Ray,
        stack: &mut Stack,
        shape: impl Fn(u32, f32) -> Option<(f32, f32, f32)>,
    ) -> Option<Hit> {
        if self.nodes.is_empty() {
            return None;
        }
        let stack = &mut stack.0[..];
        let shear = Shear::new(ray);
        let inverse = ray.direction.recip();
        // of the inverse: a component of −0 runs toward −∞
        let far_side = inverse.cmpge(Vec3A::ZERO).bitmask() as usize;
        let side = [far_side & 1, far_side >> 1 & 1, far_side >> 2 & 1];
        let origin = [
            Vec4::splat(ray.origin.x),
            Vec4::splat(ray.origin.y),
            Vec4::splat(ray.origin.z),
        ];
        let inverse = [
            Vec4::splat(inverse.x),
            Vec4::splat(inverse.y),
            Vec4::splat(inverse.z),
        ];
        // a box counts as hit although rounding moved its far side before its near side
        let margin = Vec4::splat(1.0 + 2.0 * gamma(3));
        let mut best: Option<Hit> = None;
        let mut t_max = ray.t_max;
        let mut pending = 0;
        let mut current = NODE;
        loop {
            match current & KIND {
                NODE => {
                    let node = &self.nodes[current as usize];
                    let mut near = Vec4::ZERO;
                    let mut far = Vec4::splat(t_max);
                    for axis in 0..3 {
                        let [low, high] = [side[axis] ^ 1, side[axis]]
                            .map(|s| (node.bounds[axis][s & 1] - origin[axis]) * inverse[axis]);
                        // the accumulator comes second: it survives a NaN (a ray within the plane of a side)
                        near = low.max(near);
                        far = high.min(far);
                    }
                    let hit: BVec4A = near.cmple(far * margin);
                    let mut mask = hit.bitmask();
                    if mask != 0 {
                        let near = near.to_array();
                        let first = mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        if mask == 0 {
                            current = node.children[first];
                            continue;
                        }
                        let base = pending;
                        stack[pending] = (node.children[first], near[first]);
                        pending += 1;
                        while mask != 0 {
                            let lane = mask.trailing_zeros() as usize;
                            mask &= mask - 1;
                            // insertion: the nearest ends on top
                            let mut place = pending;
                            while place > base && stack[place - 1].1 < near[lane] {
                                stack[place] = stack[place - 1];
                                place -= 1;
                            }
                            stack[place] = (node.children[lane], near[lane]);
                            pending += 1;
                        }
                        pending -= 1;
                        current = stack[pending].0;
                        continue;
                    }
                }
                FLATS => {
                    if let Some(hit) =
                        self.blocks[(current & !KIND) as usize].intersect(&shear, t_max)
                    {
                        t_max = hit.t;
                        best = Some(Hit {
                            t: hit.t,
                            primitive: hit.primitive,
                            u: hit.u,
                            v: hit.v,
                        });
                        if ANY {
                            return best;
                        }
                    }
                }
                SHAPE => {
                    let index = current & !KIND;
                    if let Some((t, u, v)) = shape(index, t_max) {
                        t_max = t;
                        best = Some(Hit {
                            t,
                            primitive: index,
                            u,
                            v,
                        });
                        if ANY {
                            return best;
                        }
                    }
                }
                _ => unreachable!("children are nodes, flat primitives or shapes"),
            }
            loop {
                if pending == 0 {
                    return best;
                }
                pending -= 1;
                let (child, near) = stack[pending];
                if near < t_max {
                    current = child;
                    break;
                }
            }
        }
    }
}

/// Turns the binary tree into the four-wide one.
struct Collapse<'a> {
    binary: &'a Bvh2,
    primitives: &'a [Primitive],
    bvh: Bvh,
}

impl Collapse<'_> {
    fn root(&mut self) {
        let top = self.binary.nodes[0].aabb;
        match self.child(0, 1) {
            // a tree of one leaf still needs a node
            leaf @ (Child::Flats(_) | Child::Shape(_)) => {
                self.bvh.nodes.push(empty_node());
                self.place(0, 0, top, leaf);
                self.bvh.depth = 1;
            }
            Child::Node(index) => debug_assert_eq!(index, 0, "the root is made first"),
        }
    }

    /// What the binary subtree at `node` becomes.
    fn child(&mut self, node: usize, depth: usize) -> Child {
        self.bvh.depth = self.bvh.depth.max(depth);
        let mut flats = Vec::with_capacity(4);
        if self.few_flats(node, &mut flats) {
            self.bvh.blocks.push(FlatBlock::new(&flats));
            return Child::Flats(self.bvh.blocks.len() as u32 - 1);
        }
        let n = &self.binary.nodes[node];
        if n.prim_count > 0 {
            return Child::Shape(self.binary.primitive_indices[n.first_index as usize]);
        }
        // open the largest box until there are four
        let mut open = vec![n.first_index as usize, n.first_index as usize + 1];
        while open.len() < 4 {
            let largest = (0..open.len())
                .filter(|&i| {
                    self.binary.nodes[open[i]].prim_count == 0
                        && !self.few_flats(open[i], &mut Vec::new())
                })
                .max_by(|&i, &j| {
                    let area = |i: usize| self.binary.nodes[open[i]].aabb.half_area();
                    area(i).total_cmp(&area(j))
                });
            let Some(i) = largest else { break };
            let first = self.binary.nodes[open[i]].first_index as usize;
            open[i] = first;
            open.push(first + 1);
        }
        let index = self.bvh.nodes.len();
        self.bvh.nodes.push(empty_node());
        for (lane, &node) in open.iter().enumerate() {
            let child = self.child(node, depth + 1);
            self.place(index, lane, self.binary.nodes[node].aabb, child);
        }
        Child::Node(index as u32)
    }

    /// Collects the flat primitives of a subtree; false if there are more than four or anything else in it.
    fn few_flats(&self, node: usize, found: &mut Vec<(u32, Flat)>) -> bool {
        let n = &self.binary.nodes[node];
        if n.prim_count == 0 {
            let first = n.first_index as usize;
            return self.few_flats(first, found) && self.few_flats(first + 1, found);
        }
        let index = self.binary.primitive_indices[n.first_index as usize];
        match self.primitives[index as usize] {
            Primitive::Flat(flat) if found.len() < 4 => {
                found.push((index, flat));
                true
            }
            _ => false,
        }
    }

    fn place(&mut self, node: usize, lane: usize, bounds: Aabb, child: Child) {
        let node = &mut self.bvh.nodes[node];
        for axis in 0..3 {
            node.bounds[axis][0][lane] = bounds.min[axis];
            node.bounds[axis][1][lane] = bounds.max[axis];
        }
        node.children[lane] = match child {
            Child::Node(i) => NODE | i,
            Child::Flats(i) => FLATS | i,
            Child::Shape(i) => SHAPE | i,
        };
    }
}

/// Four boxes that nothing hits.
fn empty_node() -> Node {
    Node {
        bounds: [[Vec4::INFINITY, Vec4::NEG_INFINITY]; 3],
        children: [0; 4],
    }
}
