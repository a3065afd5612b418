//! The bounding volume hierarchy: obvhs builds the binary tree, which is collapsed to eight children a node.
//!
//! The only place, with `choices.rs` and `collapse.rs`, that knows obvhs. Leaves hold either up to four flat primitives,
//! tested at once, or one shape of another kind, which the caller intersects.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::PlocBuilder;
use rayon::prelude::*;

use super::collapse::collapse;
use super::flat::FlatBlock;
use super::lanes::Instructions;
use super::node::{KIND, Node, WIDTH};
use super::ray::{Hit, Ray};
use super::walk::Walk;

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
    /// Nodes on the longest way from the root.
    pub(super) depth: usize,
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
        Self::over(primitives.len(), |index| primitives[index as usize])
    }

    /// Builds the tree over so many primitives, each of which is asked for when it is needed: two or three times, in any
    /// order.
    pub fn over(count: usize, primitive: impl Fn(u32) -> Primitive + Sync) -> Self {
        if count == 0 {
            return Self::default();
        }
        let binary = binary_tree(count, &primitive);
        let wide = collapse(&binary, &primitive);
        let whole = binary.nodes[0].aabb();
        let is_flat = |index| matches!(primitive(index), Primitive::Flat(_));
        Self {
            nodes: wide.nodes,
            blocks: wide.blocks,
            reach: whole.min.abs().max(whole.max.abs()).max_element(),
            depth: wide.depth,
            only: (count == 1 && !is_flat(0)).then_some(0),
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
        // the numbers of a hit one by one: together they would go through memory
        let (t, primitive, u, v) = if let Some(primitive) = self.only {
            // its box would cost as much as the primitive itself
            let (t, u, v) = shape(primitive, ray.t_max)?;
            (t, primitive, u, v)
        } else {
            let hit = self.instructions.trace(Walk::<ANY, _> {
                bvh: self,
                ray,
                stack: &mut stack.0,
                shape,
            })?;
            (hit.t, hit.primitive, hit.u, hit.v)
        };
        Some(Hit { t, primitive, u, v })
    }
}

/// The binary tree, one primitive in each leaf.
fn binary_tree(count: usize, primitive: &(impl Fn(u32) -> Primitive + Sync)) -> Bvh2 {
    /// In the order along the curve, how far to look for the neighbour to join.
    const SEARCH_DISTANCE: usize = 14;
    let parameters = BvhBuildParams::medium_build();
    let mut builder = PlocBuilder::new();
    builder.current_nodes = (0..count as u32)
        .into_par_iter()
        .map(|index| {
            let bounds = primitive(index).bounds();
            let (min, max) = (bounds.min, bounds.max);
            Bvh2Node::new(Aabb { min, max }, 1, index)
        })
        .collect();
    let whole = builder
        .current_nodes
        .iter()
        .fold(Aabb::empty(), |whole, node| whole.union(node.aabb()));
    let mut tree = Bvh2::zeroed(count);
    tree.primitive_indices = (0..count as u32).collect();
    builder.build_ploc_from_leaves::<SEARCH_DISTANCE, false>(
        &mut tree,
        whole,
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    drop(builder);
    let mut optimizer = ReinsertionOptimizer::default();
    let (ratio, again) = (
        parameters.reinsertion_batch_ratio,
        parameters.post_collapse_reinsertion_batch_ratio_multiplier,
    );
    optimizer.run(&mut tree, ratio, None);
    optimizer.run(&mut tree, ratio * again, None);
    // only for changes of the tree
    tree.parents = Vec::new();
    tree
}
