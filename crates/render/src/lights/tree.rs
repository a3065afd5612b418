//! A binary tree over light sources, down which one of them is drawn by what each half may send.
//!
//! Source: Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, PACMCGIT 1(2), 2018,
//! without their splitting; the last few sources are compared one by one.

use glam::Vec3A;

use super::bundle::{Bundle, Seen};
use crate::geometry::bvh::Bounds;

/// A bundle, and what it is made of.
#[derive(Clone, Copy, Debug)]
struct Node {
    seen: Seen,
    /// The first of its two halves, which lie side by side; or of its sources.
    first: u32,
    /// How many sources it holds; 0: two halves.
    count: u32,
}

/// Sources in bundles of bundles; the first node is all of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// In the order of the nodes that hold them: their numbers, and what is seen of them.
    numbers: Vec<u32>,
    sources: Vec<Seen>,
    /// Where each number is.
    places: Vec<Place>,
}

/// The way down to a source.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Bit k is set where the second half is taken at depth k.
    trail: u64,
    /// Index in [`Tree::sources`].
    index: u32,
}

/// As many sources are looked at one by one, or weighed in all lanes at once: bundles of few say little of each.
pub(super) const FEW: usize = 8;

/// Slabs along each axis, between which a cut may be.
const SLABS: usize = 12;

/// Below this depth bundles are halved by number, so that 64 bits are enough for every trail.
const DEEPEST: u32 = 30;

/// Largest number below 1.
pub(super) const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

impl Tree {
    /// Over some of `count` sources, each with its number; `unit` is the intensity that counts as 1.
    pub(super) fn new(mut sources: Vec<(u32, Bundle)>, count: usize, unit: f64) -> Self {
        let mut tree = Self {
            places: vec![Place::default(); count],
            ..Self::default()
        };
        if let Some(all) = together(&sources) {
            tree.nodes.push(Node::of(&all, unit));
            tree.grow(&mut sources, unit, 0, (0, 0));
        }
        tree
    }

    /// Grows a node that stands for some sources, at the end of a trail.
    fn grow(
        &mut self,
        sources: &mut [(u32, Bundle)],
        unit: f64,
        node: usize,
        (trail, depth): (u64, u32),
    ) {
        if sources.len() <= FEW {
            self.nodes[node].first = self.sources.len() as u32;
            self.nodes[node].count = sources.len() as u32;
            for (number, bundle) in sources {
                let index = self.sources.len() as u32;
                self.places[*number as usize] = Place { trail, index };
                self.numbers.push(*number);
                self.sources.push(Seen::one(bundle, unit));
            }
            return;
        }
        let middle = cut(sources, depth);
        let (left, right) = sources.split_at_mut(middle);
        let first = self.nodes.len();
        self.nodes[node].first = first as u32;
        let halves = [&*left, &*right].map(together);
        self.nodes
            .extend(halves.iter().flatten().map(|half| Node::of(half, unit)));
        self.grow(left, unit, first, (trail, depth + 1));
        self.grow(right, unit, first + 1, (trail | 1 << depth, depth + 1));
    }

    /// All of it as one; there must be some.
    #[inline(always)]
    pub(super) fn whole(&self) -> &Seen {
        &self.nodes[0].seen
    }

    /// What is seen of each source, in the order of [`Tree::numbers`].
    #[inline(always)]
    pub(super) fn sources(&self) -> &[Seen] {
        &self.sources
    }

    /// The numbers of the sources.
    #[inline(always)]
    pub(super) fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The irradiance that all of it may send to a point.
    #[inline]
    pub(super) fn irradiance(&self, from: Vec3A) -> f32 {
        self.nodes
            .first()
            .map_or(0.0, |all| all.seen.irradiance(from))
    }

    /// The chance of the first of the two halves of a node.
    #[inline]
    fn left(&self, node: &Node, from: Vec3A) -> f32 {
        let first = node.first as usize;
        let [a, b] = [first, first + 1].map(|n| self.nodes[n].seen.irradiance(from));
        share(a, b)
    }

    /// The chances of the sources of a node without halves.
    #[inline]
    fn shares(&self, node: &Node, from: Vec3A) -> [f32; FEW] {
        let (first, count) = (node.first as usize, node.count as usize);
        let mut shares = [0.0; FEW];
        let mut sum = 0.0;
        for (share, source) in shares.iter_mut().zip(&self.sources[first..first + count]) {
            *share = source.irradiance(from);
            sum += *share;
        }
        if sum > 0.0 {
            shares.map(|share| share / sum)
        } else {
            shares[..count].fill((count as f32).recip());
            shares
        }
    }

    /// Draws a source, and says with which chance. There must be one.
    #[inline]
    pub(super) fn draw(&self, from: Vec3A, mut u: f32) -> (u32, f32) {
        let mut node = &self.nodes[0];
        let mut chance = 1.0;
        while node.count == 0 {
            let left = self.left(node, from);
            // what is left of `u` is uniform again
            let second = u >= left;
            let (below, part) = if second {
                (left, 1.0 - left)
            } else {
                (0.0, left)
            };
            u = ((u - below) / part).min(BELOW_ONE);
            chance *= part;
            node = &self.nodes[node.first as usize + usize::from(second)];
        }
        if node.count == 1 {
            return (self.numbers[node.first as usize], chance);
        }
        let shares = self.shares(node, from);
        let mut drawn = 0;
        for (index, &share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            drawn = index;
            if u < share {
                break;
            }
            u -= share;
        }
        let number = self.numbers[node.first as usize + drawn];
        (number, chance * shares[drawn])
    }

    /// The chance with which [`Tree::draw`] draws a source.
    #[inline]
    pub(super) fn chance(&self, source: u32, from: Vec3A) -> f32 {
        let Place { mut trail, index } = self.places[source as usize];
        let mut node = &self.nodes[0];
        let mut chance = 1.0;
        while node.count == 0 {
            let left = self.left(node, from);
            let second = trail & 1 == 1;
            trail >>= 1;
            chance *= if second { 1.0 - left } else { left };
            node = &self.nodes[node.first as usize + usize::from(second)];
        }
        if node.count == 1 {
            return chance;
        }
        chance * self.shares(node, from)[(index - node.first) as usize]
    }
}

/// The share of the first of two that may send light; a half where neither can.
#[inline]
pub(super) fn share(a: f32, b: f32) -> f32 {
    let sum = a + b;
    if sum > 0.0 { a / sum } else { 0.5 }
}

impl Node {
    fn of(bundle: &Bundle, unit: f64) -> Self {
        Self {
            seen: Seen::many(bundle, unit),
            first: 0,
            count: 0,
        }
    }
}

fn together(sources: &[(u32, Bundle)]) -> Option<Bundle> {
    let bundles = sources.iter().map(|(_, bundle)| *bundle);
    bundles.reduce(|all, one| all.and(&one))
}

/// Puts two or more sources in the order of the best cut, and says where it is.
fn cut(sources: &mut [(u32, Bundle)], depth: u32) -> usize {
    let middles = Bounds::of(sources.iter().map(|(_, bundle)| bundle.centre()));
    let size = middles.max - middles.min;
    let best = (0..3)
        .filter(|&axis| depth < DEEPEST && size[axis] > 0.0)
        .flat_map(|axis| {
            let slabs = Slabs {
                axis,
                low: middles.min[axis],
                size: size[axis],
            };
            // cuts across the short axes make long bundles
            let stretch = f64::from(size.max_element() / size[axis]);
            let costs = slabs.costs(sources);
            (0..SLABS - 1).map(move |after| (slabs, after, stretch * costs[after]))
        })
        .filter(|(.., cost)| cost.is_finite())
        .min_by(|a, b| a.2.total_cmp(&b.2));
    let Some((slabs, after, _)) = best else {
        return sources.len() / 2;
    };
    sources.sort_by_key(|(_, bundle)| slabs.of(bundle) > after);
    sources.partition_point(|(_, bundle)| slabs.of(bundle) <= after)
}

/// Equal slabs along an axis, into which sources fall by their middles.
#[derive(Clone, Copy)]
struct Slabs {
    axis: usize,
    low: f32,
    size: f32,
}

impl Slabs {
    fn of(&self, bundle: &Bundle) -> usize {
        let place = (bundle.centre()[self.axis] - self.low) / self.size;
        ((place * SLABS as f32) as usize).min(SLABS - 1)
    }

    /// What a cut after each slab costs; infinite where one side is empty.
    fn costs(&self, sources: &[(u32, Bundle)]) -> [f64; SLABS] {
        let mut slabs = [None::<Bundle>; SLABS];
        for (_, bundle) in sources {
            let slab = &mut slabs[self.of(bundle)];
            *slab = Some(slab.map_or(*bundle, |all| all.and(bundle)));
        }
        let join = |all: Option<Bundle>, one: Option<Bundle>| match (all, one) {
            (Some(all), Some(one)) => Some(all.and(&one)),
            (all, one) => all.or(one),
        };
        let cost = |bundle: Option<Bundle>| bundle.map_or(f64::INFINITY, |b| b.cost());
        let mut costs = [0.0; SLABS];
        let mut left = None;
        for (sum, slab) in costs.iter_mut().zip(slabs) {
            left = join(left, slab);
            *sum += cost(left);
        }
        let mut right = None;
        for after in (0..SLABS).rev() {
            costs[after] += cost(right);
            right = join(right, slabs[after]);
        }
        costs
    }
}
