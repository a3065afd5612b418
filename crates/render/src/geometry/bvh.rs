//! The bounding volume hierarchy: obvhs builds the binary tree, which is collapsed to eight children a node.
//!
//! The only place, with `collapse.rs`, that knows obvhs. Leaves hold either up to four flat primitives, tested at
//! once, or one shape of another kind, which the caller intersects.

use std::time::Duration;

use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2};

use super::collapse::collapse;
use super::flat::FlatBlock;
use super::node::{KIND, Node, WIDTH};
use super::ray::{Hit, Ray};
use super::simd::{Instructions, in_large_pages};

pub use super::bounds::{Bounds, Primitive};

/// Most primitives that a scene may have.
pub const MAX_PRIMITIVES: usize = !KIND as usize;

/// The tree over all primitives of a scene.
#[derive(Debug, Default)]
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<FlatBlock>,
    /// The largest coordinate.
    pub(super) reach: f32,
    depth: usize,
    /// Where there is one primitive and it is not flat.
    only: Option<u32>,
    instructions: Instructions,
}

/// Scratch space of a traversal: one a thread, so that tracing allocates nothing.
#[derive(Debug)]
pub struct Stack(Vec<u64>);

impl Bvh {
    /// Builds the tree over primitives, which are known by their place in the list.
    ///
    /// Rays are traced with the best instructions that the processor has, or with portable ones where the environment
    /// says `BREWSTER_SIMD=portable`; the hits are the same.
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
        let wide = collapse(&binary, primitives);
        let whole = binary.nodes[0].aabb;
        Self {
            nodes: in_large_pages(wide.nodes),
            blocks: in_large_pages(wide.blocks),
            reach: whole.min.abs().max(whole.max.abs()).max_element(),
            depth: wide.depth,
            only: matches!(primitives, [Primitive::Other(_)]).then_some(0),
            instructions: Instructions::choose(),
        }
    }

    /// The same tree, traced with instructions that every processor has.
    #[must_use]
    pub fn portable(mut self) -> Self {
        self.instructions = Instructions::Portable;
        self
    }

    /// Scratch space large enough for this tree.
    pub fn stack(&self) -> Stack {
        Stack(vec![0; (WIDTH - 1) * self.depth + 1])
    }

    /// Number of nodes and of blocks of flat primitives.
    pub fn size(&self) -> (usize, usize) {
        (self.nodes.len(), self.blocks.len())
    }

    /// Memory of nodes and blocks, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
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
        if let Some(primitive) = self.only {
            // its box would cost as much as the primitive itself
            let (t, u, v) = shape(primitive, ray.t_max)?;
            return Some(Hit { t, primitive, u, v });
        }
        self.instructions
            .walk::<ANY>(self, ray, &mut stack.0, shape)
    }
}
