//! Rays per second of Brewster's tree and of Embree's, on one thread, in turns on the same rays.
//!
//! ```text
//! rays [--embree LIBRARY] [--triangles N,N,…] [--rounds N] [--portable]
//! ```
//!
//! 512 × 512 primary rays in tiles of 8 × 8; one bounce from each hit by the cosine law, in order and shuffled; one
//! any-hit ray from each hit to a point of a small lamp. Ratios are the median over the rounds of the CPU time of
//! Embree over that of Brewster in the same round: above 1 Brewster is faster.

mod embree;
mod mesh;

use std::hint::black_box;
use std::time::Instant;

use embree::{Embree, Library};
use glam::Vec3A;
use mesh::Scene;
use render::geometry::bvh::{Bvh, Primitive};
use render::geometry::flat::Flat;
use render::geometry::ray::Ray;

const KINDS: [&str; 4] = ["primary", "bounce", "shuffled", "shadow"];

/// CPU seconds of this thread.
fn cpu_time() -> f64 {
    #[repr(C)]
    struct Time {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Time) -> i32;
    }
    let mut time = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // 3: of the thread
    unsafe { clock_gettime(3, &mut time) };
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Uniform numbers: a 64-bit linear congruential generator, high bits.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn uniform(&mut self) -> f32 {
        (self.bits() >> 7) as f32 / (1 << 24) as f32
    }
}

fn primary(scene: &Scene) -> Vec<Ray> {
    const SIZE: usize = 512;
    let forward = (scene.aim - scene.eye).normalize();
    let right = forward.cross(Vec3A::Y).normalize();
    let up = right.cross(forward);
    let mut random = Random(1);
    let mut rays = Vec::new();
    for tile in 0..SIZE * SIZE / 64 {
        for place in 0..64 {
            let x = tile % (SIZE / 8) * 8 + place % 8;
            let y = tile / (SIZE / 8) * 8 + place / 8;
            let on_film =
                |i: usize, u: f32| scene.tangent * (2.0 * (i as f32 + u) / SIZE as f32 - 1.0);
            let (px, py) = (on_film(x, random.uniform()), on_film(y, random.uniform()));
            rays.push(Ray {
                origin: scene.eye,
                direction: (forward + right * px - up * py).normalize(),
                t_max: f32::INFINITY,
            });
        }
    }
    rays
}

/// Bounces, the same shuffled, and rays to the lamp.
fn secondary(scene: &Scene, bvh: &Bvh, rays: &[Ray]) -> [Vec<Ray>; 3] {
    let (mut random, mut stack) = (Random(2), bvh.stack());
    let (mut bounces, mut shadows) = (Vec::new(), Vec::new());
    for ray in rays {
        let Some(hit) = bvh.traverse::<false>(ray, &mut stack, |_, _| None) else {
            continue;
        };
        let [a, b, c] = scene.mesh[hit.primitive as usize];
        let normal = (b - a).cross(c - a).normalize();
        let normal = if normal.dot(ray.direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let origin = ray.origin + ray.direction * hit.t + normal * 1e-4;
        let (z, phi) = (
            1.0 - 2.0 * random.uniform(),
            std::f32::consts::TAU * random.uniform(),
        );
        let r = (1.0 - z * z).sqrt();
        let sphere = Vec3A::new(r * phi.cos(), r * phi.sin(), z);
        bounces.push(Ray {
            origin,
            direction: (normal * 1.0001 + sphere).normalize(),
            t_max: f32::INFINITY,
        });
        let (centre, half) = scene.light;
        let offset = Vec3A::new(
            2.0 * random.uniform() - 1.0,
            0.0,
            2.0 * random.uniform() - 1.0,
        );
        shadows.push(Ray {
            origin,
            direction: centre + offset * half - origin,
            t_max: 0.999,
        });
    }
    let mut shuffled = bounces.clone();
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, (random.bits() % (i as u64 + 1)) as usize);
    }
    [bounces, shuffled, shadows]
}

/// CPU seconds of a pass over rays, and the sum of what was found, so that nothing is left out.
fn pass(rays: &[Ray], mut trace: impl FnMut(&Ray) -> f32) -> f64 {
    let begin = cpu_time();
    let sum: f64 = rays.iter().map(|ray| f64::from(trace(ray))).sum();
    black_box(sum);
    cpu_time() - begin
}

struct Options {
    library: Option<Library>,
    triangles: Vec<usize>,
    rounds: usize,
    portable: bool,
}

fn options() -> Result<Options, String> {
    let mut found = Options {
        library: None,
        triangles: vec![2_000, 20_000, 200_000, 2_000_000],
        rounds: 9,
        portable: false,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word}: a value is missing"));
        let number = |text: &str| text.parse().map_err(|_| format!("'{text}' is no number"));
        match word.as_str() {
            "--embree" => found.library = Some(Library::open(&value()?)?),
            "--triangles" => {
                found.triangles = value()?.split(',').map(number).collect::<Result<_, _>>()?;
            }
            "--rounds" => found.rounds = number(&value()?)?,
            "--portable" => found.portable = true,
            _ => {
                return Err(format!(
                    "unknown option '{word}', expected --embree, --triangles, --rounds or --portable"
                ));
            }
        }
    }
    Ok(found)
}

fn measure(scene: &Scene, options: &Options) {
    let primitives: Vec<Primitive> = scene
        .mesh
        .iter()
        .map(|&corners| {
            Primitive::Flat(Flat {
                corners,
                parallelogram: false,
            })
        })
        .collect();
    let begin = Instant::now();
    let bvh = Bvh::build(&primitives);
    let built = begin.elapsed().as_secs_f64();
    let bytes = |bytes: f64| bytes / scene.mesh.len() as f64;
    let (nodes, blocks) = bvh.size();
    println!("\n{}: {nodes} nodes, {blocks} blocks\n", scene.name);
    println!("| tree | build, s | bytes a triangle |\n|---|---|---|");
    println!(
        "| Brewster | {built:.3} | {:.0} |",
        bytes(bvh.bytes() as f64)
    );
    let portable = options.portable.then(|| Bvh::build(&primitives).portable());
    let peers: Vec<(&str, Embree)> = options
        .library
        .iter()
        .flat_map(|library| [("Embree robust", library, true), ("Embree", library, false)])
        .map(|(name, library, robust)| {
            let begin = Instant::now();
            let embree = Embree::build(library, &scene.mesh, robust);
            let built = begin.elapsed().as_secs_f64();
            println!(
                "| {name} | {built:.3} | {:.0} |",
                bytes(embree.bytes as f64)
            );
            (name, embree)
        })
        .collect();

    let first = primary(scene);
    let [bounces, shuffled, shadows] = secondary(scene, &bvh, &first);
    let sets = [first, bounces, shuffled, shadows];
    let nothing = |_: u32, _: f32| None;
    let ours = |bvh: &Bvh, kind: usize| {
        let mut stack = bvh.stack();
        if kind == 3 {
            pass(&sets[kind], |ray| {
                f32::from(u8::from(
                    bvh.traverse::<true>(ray, &mut stack, nothing).is_some(),
                ))
            })
        } else {
            pass(&sets[kind], |ray| {
                bvh.traverse::<false>(ray, &mut stack, nothing)
                    .map_or(0.0, |hit| hit.t)
            })
        }
    };
    let theirs = |embree: &Embree, kind: usize| {
        if kind == 3 {
            pass(&sets[kind], |ray| f32::from(u8::from(embree.any(ray))))
        } else {
            pass(&sets[kind], |ray| {
                let t = embree.nearest(ray);
                if t < f32::INFINITY { t } else { 0.0 }
            })
        }
    };

    // [what is compared][kind][round]
    let columns = peers.len() + usize::from(options.portable);
    let mut ratios = vec![vec![Vec::new(); KINDS.len()]; columns];
    let mut seconds = vec![Vec::new(); KINDS.len()];
    for _ in 0..=options.rounds {
        for kind in 0..KINDS.len() {
            let own = ours(&bvh, kind);
            seconds[kind].push(own);
            for (column, (_, embree)) in peers.iter().enumerate() {
                ratios[column][kind].push(theirs(embree, kind) / own);
            }
            if let Some(portable) = &portable {
                ratios[columns - 1][kind].push(ours(portable, kind) / own);
            }
        }
    }
    let mut names: Vec<String> = peers
        .iter()
        .map(|(name, _)| format!("time of {name} over ours"))
        .collect();
    names.extend(portable.iter().map(|_| "of portable".to_owned()));
    println!("\n| rays | 10⁶ a second | {} |", names.join(" | "));
    println!("{}|", "|---".repeat(2 + columns));
    for (kind, name) in KINDS.iter().enumerate() {
        // the first round only warms up
        let rate = sets[kind].len() as f64 / median(seconds[kind][1..].to_vec()) / 1e6;
        print!("| {name} | {rate:.2} |");
        for column in &ratios {
            print!(" {:.2} |", median(column[kind][1..].to_vec()));
        }
        println!();
    }
    for (name, embree) in &peers {
        let mut stack = bvh.stack();
        let differing = sets[..3].iter().flatten().filter(|ray| {
            let own = bvh
                .traverse::<false>(ray, &mut stack, nothing)
                .map_or(f32::INFINITY, |h| h.t);
            let other = embree.nearest(ray);
            own != other && (own - other).abs() > 1e-6 + 1e-5 * own.min(other)
        });
        println!(
            "\n{} rays where {name} finds something else",
            differing.count()
        );
    }
}

fn main() {
    let options = options().unwrap_or_else(|error| {
        eprintln!("rays: {error}");
        std::process::exit(2);
    });
    measure(&mesh::cornell(), &options);
    for &triangles in &options.triangles {
        measure(
            &mesh::ball((triangles as f64 / 2.0).sqrt().round() as usize),
            &options,
        );
    }
}
