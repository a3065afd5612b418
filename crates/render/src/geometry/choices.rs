//! What becomes of each subtree of the binary tree, at the least expected cost.
//!
//! Source: Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017,
//! section 3.1: for each binary subtree, the cost of the best forest of at most `i` wide subtrees, bottom-up.

use std::collections::{HashMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};

use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

use super::bounds::Primitive;
use super::flat::BLOCK;
use super::node::WIDTH;

/// What visiting a block of flat primitives costs, in visits of a node.
const BLOCK_COST: f32 = 0.6;

/// So many subtrees are weighed in parallel, where there are as many.
const PARTS: usize = 512;

/// What the parent of a binary subtree has to know.
#[derive(Clone, Copy)]
struct Weight {
    /// Costs of the best forests of at most 1, 2, … 7 trees.
    costs: [f32; WIDTH - 1],
    /// How many flat primitives it has; more than a block holds where it has too many or anything else.
    flats: u8,
}

/// The best forests of a binary subtree, in 40 bits: for 2, 3, … 7 slots how many of them its two children get, zeros
/// where it is better one tree; how many the first child gets of eight; and whether one tree is one block.
#[derive(Clone, Copy, Default)]
pub(super) struct Choice(u64);

impl Choice {
    pub(super) fn shares(self, slots: usize) -> [usize; 2] {
        let both = (self.0 >> (6 * (slots - 2))) as usize;
        [both & 7, (both >> 3) & 7]
    }

    fn set_shares(&mut self, slots: usize, [a, b]: [usize; 2]) {
        self.0 |= ((a | (b << 3)) as u64) << (6 * (slots - 2));
    }

    /// Of the eight slots of a node.
    pub(super) fn all_shares(self) -> [usize; 2] {
        let first = (self.0 >> 36) as usize & 7;
        [first, WIDTH - first]
    }

    pub(super) fn is_block(self) -> bool {
        self.0 >> 39 & 1 == 1
    }
}

/// A binary tree of at least one primitive, one in each leaf, and what is best for each of its subtrees.
pub(super) struct Choices<'a, P> {
    pub(super) binary: &'a Bvh2,
    pub(super) primitive: &'a P,
    /// A [`Choice`] a binary node: each is written once, by whoever weighs the subtree.
    choices: Vec<AtomicU64>,
}

/// Cost of the best forest of at most `slots` trees over two subtrees, and how many of them the first one gets.
fn split([a, b]: [&Weight; 2], slots: usize) -> (f32, usize) {
    (1..slots)
        .map(|k| (a.costs[k - 1] + b.costs[slots - k - 1], k))
        .fold((f32::INFINITY, 1), |best, other| {
            if other.0 < best.0 { other } else { best }
        })
}

impl<'a, P: Fn(u32) -> Primitive + Sync> Choices<'a, P> {
    /// Weighs all subtrees.
    pub(super) fn new(binary: &'a Bvh2, primitive: &'a P) -> Self {
        let mut choices = Vec::new();
        choices.resize_with(binary.nodes.len(), AtomicU64::default);
        let all = Self {
            binary,
            primitive,
            choices,
        };
        all.weigh();
        all
    }

    /// The children of a binary node.
    pub(super) fn pair(&self, node: usize) -> Option<[usize; 2]> {
        let n = &self.binary.nodes[node];
        let first = n.first_index as usize;
        (n.prim_count == 0).then_some([first, first + 1])
    }

    /// The primitive in a leaf.
    pub(super) fn index(&self, leaf: usize) -> u32 {
        self.binary.primitive_indices[self.binary.nodes[leaf].first_index as usize]
    }

    pub(super) fn choice(&self, node: usize) -> Choice {
        Choice(self.choices[node].load(Ordering::Relaxed))
    }

    fn choose(&self, node: usize, choice: Choice) {
        self.choices[node].store(choice.0, Ordering::Relaxed);
    }

    /// Chooses for all nodes, children before parents.
    fn weigh(&self) {
        let (mut top, mut parts) = (Vec::new(), VecDeque::from([0]));
        let mut leaves = 0;
        while let Some(node) = parts.pop_front() {
            if let Some(pair) = self.pair(node) {
                top.push(node);
                parts.extend(pair);
                leaves = 0;
            } else {
                parts.push_back(node);
                leaves += 1;
            }
            if parts.len() >= PARTS || leaves == parts.len() {
                break;
            }
        }
        let mut weights: HashMap<usize, Weight> = parts
            .into_par_iter()
            .map(|node| (node, self.weigh_subtree(node)))
            .collect();
        for &node in top.iter().rev() {
            if let Some(pair) = self.pair(node) {
                let weight = self.weigh_inner(node, pair.map(|child| &weights[&child]));
                weights.insert(node, weight);
            }
        }
    }

    fn weigh_subtree(&self, root: usize) -> Weight {
        let (mut work, mut weights) = (vec![(root, false)], Vec::new());
        while let Some((node, ready)) = work.pop() {
            match self.pair(node) {
                None => weights.push(self.weigh_leaf(node)),
                Some([a, b]) if !ready => work.extend([(node, true), (b, false), (a, false)]),
                Some(_) => {
                    let below = weights.len() - 2;
                    let weight = self.weigh_inner(node, [&weights[below], &weights[below + 1]]);
                    weights.truncate(below);
                    weights.push(weight);
                }
            }
        }
        weights[0]
    }

    fn weigh_leaf(&self, leaf: usize) -> Weight {
        let is_flat = matches!((self.primitive)(self.index(leaf)), Primitive::Flat(_));
        self.choose(leaf, Choice(u64::from(is_flat) << 39));
        Weight {
            costs: [self.binary.nodes[leaf].aabb().half_area() * BLOCK_COST; WIDTH - 1],
            flats: if is_flat { 1 } else { BLOCK as u8 + 1 },
        }
    }

    fn weigh_inner(&self, node: usize, pair: [&Weight; 2]) -> Weight {
        let area = self.binary.nodes[node].aabb().half_area();
        let flats = (pair[0].flats + pair[1].flats).min(BLOCK as u8 + 1);
        let block = if usize::from(flats) <= BLOCK {
            area * BLOCK_COST
        } else {
            f32::INFINITY
        };
        let (cost, first) = split(pair, WIDTH);
        let mut costs = [0.0; WIDTH - 1];
        costs[0] = block.min(area + cost);
        let is_block = usize::from(flats) <= BLOCK && block <= costs[0];
        let mut choice = Choice((first as u64) << 36 | u64::from(is_block) << 39);
        let mut shares = [0, 0];
        for slots in 2..WIDTH {
            let (cost, k) = split(pair, slots);
            let best = costs[slots - 2].min(cost);
            costs[slots - 1] = best;
            // fewer slots where those do as well
            if best >= cost {
                shares = [k, slots - k];
            }
            if best < costs[0] {
                choice.set_shares(slots, shares);
            }
        }
        self.choose(node, choice);
        Weight { costs, flats }
    }
}
