//! From the binary tree of obvhs to the eight-wide one.
//!
//! [`Choices`] say which subtrees become nodes and blocks. What is written where does not depend on the number of
//! threads: the places of all subtrees are known before they are written in parallel.

use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

use super::bounds::Primitive;
use super::choices::Choices;
use super::flat::{BLOCK, Flat, FlatBlock};
use super::node::{FLATS, NODE, Node, SHAPE, WIDTH};
use crate::intrinsics::filled_in_large_pages;

/// Levels of the wide tree that are written before the subtrees below them, each of which is written on its own.
const TOP: usize = 3;

/// The wide tree.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<FlatBlock>,
    /// Nodes on the longest way from the root.
    pub(super) depth: usize,
}

/// Numbers of wide nodes and of blocks.
#[derive(Clone, Copy, Default)]
struct Size {
    nodes: usize,
    blocks: usize,
}

impl std::ops::AddAssign for Size {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.blocks += other.blocks;
    }
}

/// A wide subtree that is written on its own: everything below its root lies side by side.
struct Part {
    /// Its root in the binary tree.
    node: usize,
    /// Its root in the wide tree.
    place: usize,
    /// Where what is below begins, and how much that is.
    first: Size,
    size: Size,
}

/// Collapses a tree of at least one primitive, one in each leaf.
pub(super) fn collapse<P>(binary: &Bvh2, primitive: &P) -> Wide
where
    P: Fn(u32) -> Primitive + Sync,
{
    Choices::new(binary, primitive).emit()
}

impl<P: Fn(u32) -> Primitive + Sync> Choices<'_, P> {
    /// The roots of the best forest of at most `slots` trees over a subtree.
    fn forest(&self, node: usize, slots: usize, roots: &mut Vec<usize>) {
        let shares = if slots > 1 {
            self.choice(node).shares(slots)
        } else {
            [0, 0]
        };
        match self.pair(node) {
            Some(pair) if shares != [0, 0] => {
                self.forest(pair[0], shares[0], roots);
                self.forest(pair[1], shares[1], roots);
            }
            _ => roots.push(node),
        }
    }

    /// The binary roots of a wide node's children.
    fn children(&self, node: usize, roots: &mut Vec<usize>) {
        roots.clear();
        let choice = self.choice(node);
        match self.pair(node) {
            Some(pair) if !choice.is_block() => {
                let shares = choice.all_shares();
                self.forest(pair[0], shares[0], roots);
                self.forest(pair[1], shares[1], roots);
            }
            // a tree of one leaf still needs a node
            _ => roots.push(node),
        }
    }

    /// Whether a child is a node of its own.
    fn is_inner(&self, root: usize) -> bool {
        !self.choice(root).is_block() && self.pair(root).is_some()
    }

    /// Collects the flat primitives of a subtree.
    fn collect(&self, node: usize, found: &mut Vec<(u32, Flat)>) {
        if let Some(pair) = self.pair(node) {
            for child in pair {
                self.collect(child, found);
            }
            return;
        }
        let index = self.index(node);
        if let Primitive::Flat(flat) = (self.primitive)(index) {
            found.push((index, flat));
        }
    }

    /// What the first `levels` of a wide subtree have below its root, and the nodes whose children come after these.
    fn survey(&self, root: usize, levels: usize) -> (Size, Vec<usize>) {
        let (mut size, mut after) = (Size::default(), Vec::new());
        let (mut work, mut roots) = (vec![(root, levels)], Vec::new());
        while let Some((node, levels)) = work.pop() {
            if levels == 0 {
                after.push(node);
                continue;
            }
            self.children(node, &mut roots);
            size.blocks += roots
                .iter()
                .filter(|&&root| self.choice(root).is_block())
                .count();
            let inner = || roots.iter().filter(|&&root| self.is_inner(root));
            size.nodes += inner().count();
            work.extend(inner().rev().map(|&root| (root, levels - 1)));
        }
        (size, after)
    }

    /// A wide node. Its inner children get the next numbers and are left in `work` with their depth, the first on top;
    /// its blocks are written, the first of them at `blocks[0]`.
    fn node(
        &self,
        (node, depth): (usize, usize),
        next: &mut Size,
        blocks: &mut [FlatBlock],
        work: &mut Vec<(usize, usize, usize)>,
    ) -> Node {
        let (mut roots, mut flats) = (Vec::with_capacity(WIDTH), Vec::with_capacity(BLOCK));
        self.children(node, &mut roots);
        let (below, mut blocks) = (work.len(), blocks.iter_mut());
        let mut wide = Node::EMPTY;
        for (lane, &root) in roots.iter().enumerate() {
            let child = if self.choice(root).is_block() {
                flats.clear();
                self.collect(root, &mut flats);
                if let Some(block) = blocks.next() {
                    *block = FlatBlock::new(&flats);
                }
                next.blocks += 1;
                FLATS | (next.blocks - 1) as u32
            } else if self.pair(root).is_none() {
                SHAPE | self.index(root)
            } else {
                work.push((root, next.nodes, depth + 1));
                next.nodes += 1;
                NODE | (next.nodes - 1) as u32
            };
            let bounds = self.binary.nodes[root].aabb();
            wide.place(lane, bounds.min.to_array(), bounds.max.to_array(), child);
        }
        work[below..].reverse();
        wide
    }

    /// Writes the wide nodes: siblings side by side, then depth first.
    fn emit(&self) -> Wide {
        let (top, after) = self.survey(0, TOP);
        let sizes: Vec<Size> = after
            .into_par_iter()
            .map(|node| self.survey(node, usize::MAX).0)
            .collect();
        let mut total = Size {
            nodes: 1 + top.nodes,
            blocks: top.blocks,
        };
        sizes.iter().for_each(|&size| total += size);
        let mut nodes = filled_in_large_pages(Node::EMPTY, total.nodes);
        let mut blocks = filled_in_large_pages(FlatBlock::EMPTY, total.blocks);

        let (mut next, mut parts) = (
            Size {
                nodes: 1,
                blocks: 0,
            },
            Vec::new(),
        );
        let (mut work, mut depth) = (vec![(0, 0, 1)], 0);
        let mut sizes = sizes.into_iter();
        while let Some((node, place, at)) = work.pop() {
            depth = depth.max(at);
            if at > TOP {
                let (first, size) = (next, sizes.next().unwrap_or_default());
                next += size;
                parts.push(Part {
                    node,
                    place,
                    first,
                    size,
                });
            } else {
                let blocks = &mut blocks[next.blocks..];
                nodes[place] = self.node((node, at), &mut next, blocks, &mut work);
            }
        }

        let (mut rest, mut done) = ((&mut nodes[..], &mut blocks[..]), Size::default());
        let mut tasks = Vec::with_capacity(parts.len());
        for part in &parts {
            let (first, size) = (part.first, part.size);
            let (_, after) = rest.0.split_at_mut(first.nodes - done.nodes);
            let (own_nodes, after_nodes) = after.split_at_mut(size.nodes);
            let (_, after) = rest.1.split_at_mut(first.blocks - done.blocks);
            let (own_blocks, after_blocks) = after.split_at_mut(size.blocks);
            rest = (after_nodes, after_blocks);
            done = first;
            done += size;
            tasks.push((part, own_nodes, own_blocks));
        }
        let written: Vec<(Node, usize)> = tasks
            .into_par_iter()
            .map(|(part, nodes, blocks)| self.write(part, nodes, blocks))
            .collect();
        for (part, (node, below)) in parts.iter().zip(written) {
            nodes[part.place] = node;
            depth = depth.max(below);
        }
        Wide {
            nodes,
            blocks,
            depth,
        }
    }

    /// Writes what is below a part's root; returns the root and the depth of the deepest node.
    fn write(&self, part: &Part, nodes: &mut [Node], blocks: &mut [FlatBlock]) -> (Node, usize) {
        let (mut next, mut work) = (part.first, Vec::new());
        let root = self.node((part.node, TOP + 1), &mut next, blocks, &mut work);
        let mut depth = TOP + 1;
        while let Some((node, place, at)) = work.pop() {
            depth = depth.max(at);
            let blocks = &mut blocks[next.blocks - part.first.blocks..];
            nodes[place - part.first.nodes] = self.node((node, at), &mut next, blocks, &mut work);
        }
        (root, depth)
    }
}
