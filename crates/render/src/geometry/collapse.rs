//! From the binary tree of obvhs to the eight-wide one, at the least expected cost.
//!
//! Source: Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017,
//! section 3.1: for each binary subtree, the cost of the best forest of at most `i` wide subtrees, bottom-up.

use obvhs::bvh2::Bvh2;

use super::bounds::Primitive;
use super::flat::{BLOCK, Flat, FlatBlock};
use super::node::{FLATS, NODE, Node, SHAPE, WIDTH};

/// What visiting a block of flat primitives costs, in visits of a node.
const BLOCK_COST: f32 = 0.6;

/// The wide tree.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<FlatBlock>,
    /// Nodes on the longest way from the root.
    pub(super) depth: usize,
}

/// Costs of the best forests of at most 1, 2, … 7 trees.
type Costs = [f32; WIDTH - 1];

struct Collapse<'a> {
    binary: &'a Bvh2,
    primitives: &'a [Primitive],
    costs: Vec<Costs>,
    /// How many flat primitives a subtree has; more than a block holds where it has too many or anything else.
    flats: Vec<u8>,
}

/// Collapses a tree of at least one primitive, one in each leaf.
pub(super) fn collapse(binary: &Bvh2, primitives: &[Primitive]) -> Wide {
    let mut collapse = Collapse {
        binary,
        primitives,
        costs: vec![[0.0; WIDTH - 1]; binary.nodes.len()],
        flats: vec![0; binary.nodes.len()],
    };
    collapse.weigh();
    collapse.emit()
}

impl Collapse<'_> {
    /// The children of a binary node.
    fn pair(&self, node: usize) -> Option<[usize; 2]> {
        let n = &self.binary.nodes[node];
        let first = n.first_index as usize;
        (n.prim_count == 0).then_some([first, first + 1])
    }

    fn is_block(&self, node: usize) -> bool {
        usize::from(self.flats[node]) <= BLOCK
    }

    /// The primitive in a leaf.
    fn primitive(&self, leaf: usize) -> u32 {
        self.binary.primitive_indices[self.binary.nodes[leaf].first_index as usize]
    }

    /// Cost of the best forest of at most `slots` trees over two subtrees, and how many of them the first one gets.
    fn split(&self, [a, b]: [usize; 2], slots: usize) -> (f32, usize) {
        (1..slots)
            .map(|k| (self.costs[a][k - 1] + self.costs[b][slots - k - 1], k))
            .fold((f32::INFINITY, 1), |best, other| {
                if other.0 < best.0 { other } else { best }
            })
    }

    /// Fills in the costs, children before parents.
    fn weigh(&mut self) {
        let mut order = vec![0];
        let mut next = 0;
        while next < order.len() {
            order.extend(self.pair(order[next]).into_iter().flatten());
            next += 1;
        }
        for &node in order.iter().rev() {
            let area = self.binary.nodes[node].aabb.half_area();
            let Some(pair) = self.pair(node) else {
                let flat = matches!(
                    self.primitives[self.primitive(node) as usize],
                    Primitive::Flat(_)
                );
                self.flats[node] = if flat { 1 } else { BLOCK as u8 + 1 };
                self.costs[node] = [area * BLOCK_COST; WIDTH - 1];
                continue;
            };
            let count = pair.map(|child| self.flats[child]).iter().sum::<u8>();
            self.flats[node] = count.min(BLOCK as u8 + 1);
            let mut costs: Costs = [0.0; WIDTH - 1];
            let block = if self.is_block(node) {
                area * BLOCK_COST
            } else {
                f32::INFINITY
            };
            costs[0] = block.min(area + self.split(pair, WIDTH).0);
            for slots in 2..WIDTH {
                costs[slots - 1] = costs[slots - 2].min(self.split(pair, slots).0);
            }
            self.costs[node] = costs;
        }
    }

    /// The roots of the best forest of at most `slots` trees over a subtree.
    fn forest(&self, node: usize, slots: usize, roots: &mut Vec<usize>) {
        let costs = &self.costs[node];
        match self.pair(node) {
            Some(pair) if slots > 1 && costs[slots - 1] < costs[0] => {
                let (cost, k) = self.split(pair, slots);
                if costs[slots - 1] < cost {
                    self.forest(node, slots - 1, roots);
                } else {
                    self.forest(pair[0], k, roots);
                    self.forest(pair[1], slots - k, roots);
                }
            }
            _ => roots.push(node),
        }
    }

    /// Collects the flat primitives of a subtree.
    fn collect(&self, node: usize, found: &mut Vec<(u32, Flat)>) {
        if let Some(pair) = self.pair(node) {
            for child in pair {
                self.collect(child, found);
            }
            return;
        }
        let index = self.primitive(node);
        if let Primitive::Flat(flat) = self.primitives[index as usize] {
            found.push((index, flat));
        }
    }

    /// Whether a subtree becomes one block of flat primitives.
    fn ends_in_block(&self, node: usize) -> bool {
        let block = self.binary.nodes[node].aabb.half_area() * BLOCK_COST;
        self.is_block(node) && block <= self.costs[node][0]
    }

    /// Writes the wide nodes: siblings side by side, then depth first.
    fn emit(&self) -> Wide {
        let mut wide = Wide {
            nodes: vec![Node::EMPTY],
            blocks: Vec::new(),
            depth: 0,
        };
        let (mut work, mut roots, mut flats) = (vec![(0, 0, 1)], Vec::new(), Vec::new());
        while let Some((node, place, depth)) = work.pop() {
            wide.depth = wide.depth.max(depth);
            roots.clear();
            match self.pair(node) {
                Some(pair) if !self.ends_in_block(node) => {
                    let (_, k) = self.split(pair, WIDTH);
                    self.forest(pair[0], k, &mut roots);
                    self.forest(pair[1], WIDTH - k, &mut roots);
                }
                // a tree of one leaf still needs a node
                _ => roots.push(node),
            }
            let below = work.len();
            for (lane, &root) in roots.iter().enumerate() {
                let child = if self.ends_in_block(root) {
                    flats.clear();
                    self.collect(root, &mut flats);
                    wide.blocks.push(FlatBlock::new(&flats));
                    FLATS | (wide.blocks.len() - 1) as u32
                } else if self.pair(root).is_none() {
                    SHAPE | self.primitive(root)
                } else {
                    wide.nodes.push(Node::EMPTY);
                    let child = wide.nodes.len() - 1;
                    work.push((root, child, depth + 1));
                    NODE | child as u32
                };
                let bounds = self.binary.nodes[root].aabb;
                wide.nodes[place].place(lane, bounds.min.to_array(), bounds.max.to_array(), child);
            }
            // the first sibling comes next
            work[below..].reverse();
        }
        wide
    }
}
