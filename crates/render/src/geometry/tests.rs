//! Rays that aim at what is difficult: nothing is lost, at any scale, and whatever the instructions.

use glam::{DVec3, Vec3A};

use super::bvh::{Bounds, Bvh, Primitive};
use super::flat::{Flat, FlatBlock, Shear};
use super::node::{FLATS, KIND, NODE, Node};
use super::ray::Ray;

const SCALES: [f32; 5] = [1e-6, 1e-3, 1.0, 1e3, 1e6];

/// Uniform numbers: the high bits of a linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn signed(&mut self) -> f32 {
        2.0 * self.next() - 1.0
    }

    fn point(&mut self) -> Vec3A {
        Vec3A::new(self.signed(), self.signed(), self.signed())
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f32) as usize).min(n - 1)
    }
}

fn flat(corners: [Vec3A; 3]) -> Flat {
    Flat {
        corners,
        parallelogram: false,
    }
}

/// A closed body around the origin: `2 (n − 1) 2 n` triangles between meridians and parallels, neither round nor
/// aligned with the axes everywhere; corners are shared to the last bit.
fn body(n: usize, scale: f32) -> Vec<Flat> {
    let point = |i: usize, j: usize| {
        let theta = std::f64::consts::PI * i as f64 / n as f64;
        let phi = std::f64::consts::PI * (j % (2 * n)) as f64 / n as f64;
        let sine = if i == n { 0.0 } else { theta.sin() };
        let direction = DVec3::new(sine * phi.cos(), sine * phi.sin(), theta.cos());
        let radius = 1.0 + 0.2 * (3.0 * theta).sin() * sine * (2.0 * phi).cos();
        (direction * radius).as_vec3a() * scale
    };
    let mut flats = Vec::new();
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b] = [point(i, j), point(i, j + 1)];
            let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
            if i > 0 {
                flats.push(flat([a, b, c]));
            }
            if i < n - 1 {
                flats.push(flat([a, c, d]));
            }
        }
    }
    flats
}

/// Triangles of all shapes, a third of them slivers, and parallelograms.
fn soup(random: &mut Random, count: usize, scale: f32) -> Vec<Flat> {
    (0..count)
        .map(|i| {
            let centre = random.point() * scale;
            let size = scale * 0.5f32.powf(1.0 + 8.0 * random.next());
            let mut edge = || random.point() * size;
            let (b, mut c) = (edge(), edge());
            if i % 3 == 0 {
                c = b * 0.7 + c * 1e-4;
            }
            Flat {
                corners: [centre, centre + b, centre + c],
                parallelogram: i % 5 == 0,
            }
        })
        .collect()
}

/// A ray that aims at a flat primitive: inside, at an edge, at a corner, along an axis, in its own plane.
fn aimed(random: &mut Random, flats: &[Flat], kind: usize, origin: Vec3A) -> Ray {
    let [a, b, c] = flats[random.below(flats.len())].corners;
    let (u, v) = (random.next(), random.next());
    let on_edge = a + (b - a) * u;
    let direction = match kind {
        0 => a + (b - a) * (u * (1.0 - v)) + (c - a) * v - origin,
        1 => on_edge - origin,
        2 => c - origin,
        3 => {
            // zeros of either sign
            let mut along = [-0.0, 0.0, if u < 0.5 { -0.0 } else { 0.0 }];
            along[random.below(3)] = if v < 0.5 { -1.0 } else { 1.0 };
            Vec3A::from_array(along)
        }
        _ => (on_edge - c) + (b - a) * v,
    };
    let origin = match kind {
        // through the corner or the edge itself
        3 => [on_edge, c][random.below(2)] - direction * (origin.length() * random.next()),
        4 => on_edge - direction * (4.0 * random.next()),
        _ => origin,
    };
    Ray {
        origin,
        direction,
        t_max: f32::INFINITY,
    }
}

fn tree(flats: &[Flat], others: &[Bounds]) -> Bvh {
    let flats = flats.iter().copied().map(Primitive::Flat);
    let others = others.iter().copied().map(Primitive::Other);
    Bvh::build(&flats.chain(others).collect::<Vec<_>>())
}

/// Balls, in double precision: what stands for shapes of other kinds.
struct Balls {
    first: usize,
    balls: Vec<(DVec3, f64)>,
}

impl Balls {
    fn intersect(&self, primitive: u32, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let (centre, radius) = self.balls[primitive as usize - self.first];
        let (o, d) = (ray.origin.as_dvec3() - centre, ray.direction.as_dvec3());
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - radius * radius);
        let root = (b * b - a * c).sqrt();
        [-b - root, -b + root]
            .map(|t| (t / a) as f32)
            .into_iter()
            .find(|&t| t > 0.0 && t < t_max)
            .map(|t| (t, 0.25, 0.5))
    }
}

/// A third of these lie on others, so that costs are equal; enough for all that the build does in parallel.
fn crowd() -> (Vec<Flat>, Vec<Bounds>) {
    let mut random = Random(17);
    let mut flats = soup(&mut random, 80_000, 1.0);
    flats.extend_from_within(..40_000);
    let others = (0..50).map(|_| Bounds::of([random.point(), random.point()]));
    (flats, others.collect())
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let (flats, others) = crowd();
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| tree(&flats, &others))
    };
    let one = build(1);
    for threads in [2, 3, 8] {
        let many = build(threads);
        assert!(one.nodes == many.nodes, "nodes, {threads} threads");
        assert!(one.blocks == many.blocks, "blocks, {threads} threads");
        assert_eq!(one.depth, many.depth, "{threads} threads");
    }
}

#[test]
fn each_node_and_each_block_has_one_parent_and_siblings_lie_side_by_side() {
    let (flats, others) = crowd();
    let tree = tree(&flats, &others);
    let (mut nodes, mut blocks, mut deepest) = (1, 0, 0);
    let mut work = vec![(0, 1)];
    while let Some((node, depth)) = work.pop() {
        deepest = deepest.max(depth);
        let node: &Node = &tree.nodes[node];
        let children = node.children.iter().filter(|&&child| child != 0);
        let inner: Vec<u32> = children
            .clone()
            .copied()
            .filter(|c| c & KIND == NODE)
            .collect();
        // the order of the walk is that of the memory: depth first, siblings together
        for &child in &inner {
            assert_eq!(child as usize, nodes);
            nodes += 1;
        }
        work.extend(inner.iter().rev().map(|&child| (child as usize, depth + 1)));
        for &child in children.filter(|&&child| child & KIND == FLATS) {
            assert_eq!((child & !KIND) as usize, blocks);
            blocks += 1;
        }
    }
    assert_eq!((nodes, blocks), tree.size());
    assert_eq!(deepest, tree.depth);
    assert!(deepest > 4, "no subtree is written on its own");
}

#[test]
fn all_instructions_find_the_same_hits_to_the_last_bit() {
    let mut random = Random(11);
    let mut hits = 0;
    for scale in SCALES {
        let mut flats = body(12, scale);
        flats.extend(soup(&mut random, 1500, scale));
        let balls: Vec<(DVec3, f64)> = (0..40)
            .map(|_| {
                let centre = (random.point() * scale).as_dvec3();
                (centre, f64::from(scale * 0.1 * random.next()))
            })
            .collect();
        let boxes: Vec<Bounds> = balls
            .iter()
            .map(|&(centre, radius)| {
                let reach = DVec3::splat(radius * (1.0 + 1e-6));
                Bounds::of([(centre - reach).as_vec3a(), (centre + reach).as_vec3a()])
                    .grown(Vec3A::splat(1e-6 * scale))
            })
            .collect();
        let balls = Balls {
            first: flats.len(),
            balls,
        };
        let (chosen, portable) = (tree(&flats, &boxes), tree(&flats, &boxes).portable());
        let mut stack = chosen.stack();
        for i in 0..400_000 {
            let origin = random.point() * scale * [0.7, 3.0][i / 5 % 2];
            let mut ray = aimed(&mut random, &flats, i % 5, origin);
            if i / 10 % 7 == 0 {
                ray.t_max = random.next();
            }
            let shape = |primitive, t_max| balls.intersect(primitive, &ray, t_max);
            let [one, two] = [&chosen, &portable].map(|bvh| {
                let hit = bvh.traverse::<false>(&ray, &mut stack, shape);
                let any = bvh.traverse::<true>(&ray, &mut stack, shape);
                assert_eq!(hit.is_some(), any.is_some(), "any hit, {i}, {ray:?}");
                hit.map(|h| (h.primitive, [h.t, h.u, h.v].map(f32::to_bits)))
            });
            assert_eq!(one, two, "scale {scale}, ray {i}, {ray:?}");
            hits += usize::from(one.is_some());
        }
    }
    assert!(hits > 1_000_000, "{hits}");
}

#[test]
fn no_ray_leaves_a_closed_body_at_any_scale() {
    let mut random = Random(12);
    for scale in SCALES {
        let flats = body(40, scale);
        let bvh = tree(&flats, &[]);
        let mut stack = bvh.stack();
        for i in 0..300_000 {
            // well inside: the body's smallest radius is above 0.75
            let origin = random.point() * (0.4 * scale);
            let kind = [0, 1, 2, 3][i % 4];
            let mut ray = aimed(&mut random, &flats, kind, origin);
            if kind == 3 {
                // two components of the aim, the third from the inside
                let along = ray.direction.abs();
                ray.origin = ray.origin * (Vec3A::ONE - along) * 0.4;
            }
            for end in [f32::INFINITY, 4.0 * scale / ray.direction.length()] {
                let ray = Ray { t_max: end, ..ray };
                let hit = bvh.traverse::<false>(&ray, &mut stack, |_, _| None);
                assert!(hit.is_some(), "scale {scale}, ray {i} leaves: {ray:?}");
            }
        }
    }
}

/// Whether the point at `t` is on a flat primitive as well as roundings can tell, 24 ε of the coordinates. Where a
/// primitive is thinner than that, the test finds it at points beside it too, which boxes rightly leave out.
fn lies_on(flat: &Flat, ray: &Ray, t: f32) -> bool {
    let [a, b, c] = flat.corners.map(Vec3A::as_dvec3);
    let fourth = if flat.parallelogram { b + c - a } else { a };
    let (low, high) = (a.min(b).min(c).min(fourth), a.max(b).max(c).max(fourth));
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let reach = (low - o).abs().max((high - o).abs()).max_element();
    let point = o + d * f64::from(t);
    let beside = (low - point).max(point - high).max_element();
    beside <= 12.0 * f64::from(f32::EPSILON) * reach
}

#[test]
fn boxes_lose_nothing_that_the_test_of_a_triangle_finds() {
    let mut random = Random(13);
    let (mut hits, mut nearer) = (0, 0);
    for scale in SCALES {
        let flats = soup(&mut random, 400, scale);
        let bvh = tree(&flats, &[]);
        let blocks: Vec<FlatBlock> = (0..)
            .zip(&flats)
            .map(|(i, &flat)| FlatBlock::new(&[(i, flat)]))
            .collect();
        let mut stack = bvh.stack();
        for i in 0..20_000 {
            let origin = random.point() * scale * [1.0, 30.0][i / 5 % 2];
            let ray = aimed(&mut random, &flats, i % 5, origin);
            let shear = Shear::new(&ray);
            let slow =
                blocks
                    .iter()
                    .zip(&flats)
                    .fold(f32::INFINITY, |t, (block, flat)| {
                        match block.intersect(&shear, t) {
                            Some(hit) if lies_on(flat, &ray, hit.t) => hit.t,
                            _ => t,
                        }
                    });
            let fast = bvh
                .traverse::<false>(&ray, &mut stack, |_, _| None)
                .map_or(f32::INFINITY, |hit| hit.t);
            // nearer hits than that of the tree are within the rounding of distances: 8 ε of the coordinates
            let rounding = 16.0 * f32::EPSILON * (ray.origin.abs().max_element() + 2.0 * scale);
            let along = ray.direction.abs().max_element();
            nearer += usize::from(slow < fast);
            assert!(
                fast == slow || (fast - slow) * along <= rounding,
                "scale {scale}, ray {i}: {fast}, expected {slow}: {ray:?}"
            );
            hits += usize::from(slow < f32::INFINITY);
        }
    }
    assert!(hits > 40_000 && nearer < hits / 1000, "{hits} {nearer}");
}

#[test]
fn a_tree_of_equal_primitives_or_of_one_is_a_tree() {
    let one = flat([Vec3A::ZERO, Vec3A::X, Vec3A::Y]);
    let ray = Ray {
        origin: Vec3A::new(0.25, 0.25, 1.0),
        direction: Vec3A::NEG_Z,
        t_max: f32::INFINITY,
    };
    for count in [1, 4, 5, 8, 33, 5000] {
        let bvh = tree(&vec![one; count], &[]);
        let hit = bvh.traverse::<false>(&ray, &mut bvh.stack(), |_, _| None);
        assert_eq!(hit.map(|h| h.t), Some(1.0), "{count}");
    }
    let nothing = tree(&[], &[]);
    assert!(
        nothing
            .traverse::<true>(&ray, &mut nothing.stack(), |_, _| None)
            .is_none()
    );
}
