//! Claim: surfaces neither leak nor shadow themselves, at any scale; and rays find the nearest one.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fmt::Write as _;
use std::path::Path;

use brewster_tests::{SIGMAS, Shot, assert_stokes, film_scene, mean, pixel, repository};
use glam::{DVec3, Vec3A};
use render::geometry::bvh::{Bvh, Primitive};
use render::geometry::flat::{Flat, FlatBlock, Shear};
use render::geometry::ray::Ray;
use render::sampler::SampleStream;
use render::scene::read_text;

/// Lengths of the metre.
const SCALES: [f64; 5] = [1e-6, 1e-3, 1.0, 1e3, 1e6];

/// A ball of 1280 equal-sided facets around the origin: an icosahedron, each triangle cut into four three times.
fn icosphere() -> Vec<[DVec3; 3]> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            corners.extend([
                DVec3::new(0.0, a, b),
                DVec3::new(a, b, 0.0),
                DVec3::new(b, 0.0, a),
            ]);
        }
    }
    let near = |a: DVec3, b: DVec3| (a - b).length() < 2.1;
    let mut faces = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners
                .iter()
                .skip(j + 1)
                .filter(|&&c| near(a, b) && near(b, c) && near(c, a))
            {
                let outward = (b - a).cross(c - a).dot(a) > 0.0;
                faces.push(if outward { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    for _ in 0..3 {
        let middle = |a: DVec3, b: DVec3| (a + b) / 2.0;
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]].map(|face| face.map(DVec3::normalize))
            })
            .collect();
    }
    assert_eq!(faces.len(), 1280);
    faces
}

/// The faces as an OBJ file in which neighbours share vertices.
fn write_obj(path: &Path, faces: &[[DVec3; 3]]) {
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let (mut vertices, mut indices) = (String::new(), String::new());
    for face in faces {
        indices.push('f');
        for corner in face {
            let corner = corner.as_vec3().to_array();
            let known = corners.iter().position(|c| *c == corner);
            let index = known.unwrap_or_else(|| {
                corners.push(corner);
                let [x, y, z] = corner;
                writeln!(vertices, "v {x} {y} {z}").unwrap();
                corners.len() - 1
            });
            write!(indices, " {}", index + 1).unwrap();
        }
        indices.push('\n');
    }
    std::fs::write(path, vertices + &indices).unwrap();
}

/// A ball of facets in a folder of its own.
struct Ball {
    folder: tempfile::TempDir,
}

impl Ball {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_obj(&folder.path().join("ball.obj"), &icosphere());
        Self { folder }
    }

    fn xml(&self, scale: f64, bsdf: &str) -> String {
        mesh_xml(&self.folder.path().join("ball.obj"), scale, bsdf)
    }
}

fn mesh_xml(path: &Path, scale: f64, bsdf: &str) -> String {
    format!(
        "<shape type='obj'><string name='filename' value='{}'/><boolean name='face_normals' value='true'/>
         <transform name='to_world'><scale value='{scale}'/></transform>{bsdf}</shape>",
        path.display()
    )
}

fn shape_xml(shape: &str, scale: f64, bsdf: &str) -> String {
    format!(
        "<shape type='{shape}'><transform name='to_world'><scale value='{scale}'/></transform>{bsdf}</shape>"
    )
}

fn torus() -> std::path::PathBuf {
    repository().join("scenes/big_mesh/torus_smooth.obj")
}

fn diffuse(reflectance: f64) -> String {
    format!("<bsdf type='diffuse'><float name='reflectance' value='{reflectance}'/></bsdf>")
}

const SURROUNDINGS: &str = "<emitter type='constant'><float name='radiance' value='1'/></emitter>";

/// Two uniform numbers for ray `i`.
fn pair(i: u64, dimension: u32) -> [f32; 2] {
    SampleStream::new(7, 0, i).pair(dimension)
}

fn direction(i: u64) -> Vec3A {
    let [u, v] = pair(i, 0);
    let (z, phi) = (1.0 - 2.0 * u, std::f32::consts::TAU * v);
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3A::new(r * phi.cos(), r * phi.sin(), z)
}

/// A point on a triangle: on the inside, on an edge, or a corner, in turn.
fn target(corners: [Vec3A; 3], i: u64) -> Vec3A {
    let [u, v] = pair(i, 2);
    let [a, b, c] = corners;
    match i % 3 {
        0 => a + (b - a) * u.min(1.0 - v) + (c - a) * v.min(1.0 - u),
        1 => a + (b - a) * u,
        _ => c,
    }
}

#[test]
fn the_nearest_hit_is_that_of_all_triangles_tried_one_by_one() {
    let document = read_text(
        &film_scene(
            2,
            "origin='0, 0, 9' target='0, 0, 0' up='0, 1, 0'",
            30.0,
            [1, 1],
            &mesh_xml(&torus(), 1.0, ""),
        ),
        Path::new("test.xml"),
        &[],
    );
    let scene = Shot::new(1).job(&document.unwrap()).scene;
    let mesh = &scene.meshes[0];
    let flats: Vec<Flat> = (0..mesh.len())
        .map(|t| Flat {
            corners: mesh.corners(t),
            parallelogram: false,
        })
        .collect();
    let bvh = Bvh::build(
        &flats
            .iter()
            .copied()
            .map(Primitive::Flat)
            .collect::<Vec<_>>(),
    );
    let blocks: Vec<FlatBlock> = flats
        .chunks(4)
        .map(|four| FlatBlock::new(&four.iter().map(|&flat| (0, flat)).collect::<Vec<_>>()))
        .collect();
    let (mut stack, mut hits) = (bvh.stack(), 0);
    const RAYS: u64 = 200_000;
    for i in 0..RAYS {
        let aim = target(flats[(i * 7919) as usize % flats.len()].corners, i);
        // from outside, from within the ring, from the surface itself
        let origin = direction(i) * [4.0, 0.5, 1.1][(i / 3) as usize % 3];
        let ray = Ray {
            origin,
            direction: aim - origin,
            t_max: f32::INFINITY,
        };
        let shear = Shear::new(&ray);
        let slow = blocks.iter().fold(f32::INFINITY, |t, block| {
            block.intersect(&shear, t).map_or(t, |hit| hit.t)
        });
        let none = |_: u32, _: f32| None;
        let fast = bvh
            .traverse::<false>(&ray, &mut stack, none)
            .map_or(f32::INFINITY, |hit| hit.t);
        // triangles that share the corner differ by roundings, and boxes may decide between them
        let same = fast == slow || (fast - slow).abs() <= 4.0 * f32::EPSILON * slow;
        assert!(same, "ray {i}: {fast}, expected {slow}: {ray:?}");
        let mut any = |t_max: f32| {
            bvh.traverse::<true>(&Ray { t_max, ..ray }, &mut stack, none)
                .is_some()
        };
        assert_eq!(any(f32::INFINITY), slow < f32::INFINITY, "any hit, ray {i}");
        if slow < f32::INFINITY {
            hits += 1;
            assert!(!any(slow * (1.0 - 1e-6)), "ray {i} hits before {slow}");
            assert!(any(slow * (1.0 + 1e-6)), "ray {i} misses at {slow}");
        }
    }
    assert!(hits > RAYS * 9 / 10, "{hits}");
}

#[test]
fn no_ray_leaves_a_closed_mesh_through_edges_or_vertices() {
    let ball = Ball::new();
    let text = film_scene(
        2,
        "origin='0, 0, 9' target='0, 0, 0' up='0, 1, 0'",
        30.0,
        [1, 1],
        &ball.xml(1.0, ""),
    );
    let scene = Shot::new(1)
        .job(&read_text(&text, Path::new("test.xml"), &[]).unwrap())
        .scene;
    let mesh = &scene.meshes[0];
    let planes: Vec<(DVec3, f64)> = (0..mesh.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(Vec3A::as_dvec3);
            let normal = (b - a).cross(c - a).normalize();
            (normal, normal.dot(a))
        })
        .collect();
    let mut stack = scene.stack();
    for i in 0..200_000 {
        let aim = target(mesh.corners((i * 7919) as usize % mesh.len()), i);
        let origin = direction(i) * pair(i, 4)[0] * 0.9;
        let ray = Ray {
            origin,
            direction: (aim - origin).normalize(),
            t_max: f32::INFINITY,
        };
        let Some(hit) = scene.intersect(&ray, &mut stack) else {
            panic!("ray {i} leaves: {ray:?}")
        };
        // a convex body: the way out is the nearest of all planes
        let (o, d) = (origin.as_dvec3(), ray.direction.as_dvec3());
        let out = planes
            .iter()
            .filter(|(n, _)| n.dot(d) > 0.0)
            .map(|(n, distance)| (distance - n.dot(o)) / n.dot(d))
            .fold(f64::INFINITY, f64::min);
        let found = (hit.surface.position.as_dvec3() - o).length();
        // single precision of coordinates near one, steepened by rays that graze (no flatter than 0.08)
        assert!(
            (found - out).abs() < 1e-5,
            "ray {i}: {found}, expected {out}"
        );
    }
}

#[test]
fn the_inside_of_a_closed_black_body_is_black_at_every_scale() {
    let ball = Ball::new();
    for scale in SCALES {
        for (what, body, at) in [
            (
                "ball of facets",
                ball.xml(scale, &diffuse(0.0)),
                [0.1, 0.2, -0.05],
            ),
            (
                "torus of facets",
                mesh_xml(&torus(), scale, &diffuse(0.0)),
                [1.0, 0.02, 0.03],
            ),
            (
                "sphere",
                shape_xml("sphere", scale, &diffuse(0.0)),
                [0.1, 0.2, -0.05],
            ),
            (
                "cube",
                shape_xml("cube", scale, &diffuse(0.0)),
                [0.1, 0.2, -0.05],
            ),
        ] {
            let [x, y, z] = at.map(|v| v * scale);
            let lookat = format!(
                "origin='{x}, {y}, {z}' target='{}, {y}, {z}' up='0, 0, 1'",
                x + 0.4 * scale
            );
            let text = film_scene(
                4,
                &lookat,
                170.0,
                [64, 64],
                &format!("{SURROUNDINGS}{body}"),
            );
            let image = Shot::new(16).of_text(&text);
            assert!(
                image.stokes.iter().all(|&v| v == 0.0),
                "light leaks into a {what} at scale {scale}"
            );
        }
    }
}

#[test]
fn a_convex_white_body_does_not_shadow_itself_at_any_scale() {
    let ball = Ball::new();
    for scale in SCALES {
        for (what, body) in [
            ("ball of facets", ball.xml(scale, &diffuse(1.0))),
            ("sphere", shape_xml("sphere", scale, &diffuse(1.0))),
            ("cube", shape_xml("cube", scale, &diffuse(1.0))),
        ] {
            let lookat = format!(
                "origin='{}, {}, {}' target='0, 0, 0' up='0, 0, 1'",
                scale,
                2.0 * scale,
                3.0 * scale
            );
            let text = film_scene(3, &lookat, 40.0, [48, 48], &format!("{SURROUNDINGS}{body}"));
            let image = Shot::new(16).of_text(&text);
            for s0 in image.stokes.chunks(4).map(|s| s[0]) {
                // light and body have the same density: no noise, a few roundings
                assert!(
                    (s0 - 1.0).abs() < 1e-5,
                    "a {what} of size {scale} is {s0}, expected 1"
                );
            }
        }
    }
}

/// A room with a lamp, a metal ball, a glass cube and a faceted ball.
fn room(ball: &Ball, s: f64) -> String {
    let wall = |placement: &str| {
        format!(
            "<shape type='rectangle'><transform name='to_world'>{placement}<scale value='{s}'/></transform>{}</shape>",
            diffuse(0.7)
        )
    };
    let content = [
        wall("<rotate x='1' angle='-90'/><translate y='-1'/>"),
        wall("<rotate x='1' angle='90'/><translate y='1'/>"),
        wall("<translate z='-1'/>"),
        wall("<rotate y='1' angle='90'/><translate x='-1'/>"),
        wall("<rotate y='1' angle='-90'/><translate x='1'/>"),
        format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='0.4'/><rotate x='1' angle='90'/>
             <translate y='0.98'/><scale value='{s}'/></transform>
             <emitter type='area'><float name='radiance' value='10'/></emitter></shape>
             <shape type='sphere'><float name='radius' value='0.35'/><point name='center' x='-0.4' y='-0.6' z='-0.3'/>
             <transform name='to_world'><scale value='{s}'/></transform>
             <bsdf type='conductor'><spectrum name='eta' value='0.2'/><spectrum name='k' value='3.2'/></bsdf></shape>
             <shape type='cube'><transform name='to_world'><scale value='0.25'/><rotate y='1' angle='28'/>
             <translate x='0.4' y='-0.7' z='0.1'/><scale value='{s}'/></transform>
             <bsdf type='dielectric'><float name='int_ior' value='1.5'/></bsdf></shape>"
        ),
        ball.xml(0.2 * s, &diffuse(0.5)),
    ];
    let lookat = format!("origin='0, 0, {}' target='0, 0, 0' up='0, 1, 0'", 4.6 * s);
    film_scene(8, &lookat, 29.0, [48, 48], &content.concat())
}

#[test]
fn a_scene_looks_the_same_at_every_scale() {
    let ball = Ball::new();
    let shot = Shot::new(64);
    let one = shot.of_text(&room(&ball, 1.0));
    for scale in SCALES {
        let other = shot.of_text(&room(&ball, scale));
        let mut changed = 0;
        for y in 0..48 {
            for x in 0..48 {
                let ((a, ea), (b, eb)) = (pixel(&one, x, y, 0), pixel(&other, x, y, 0));
                assert!(
                    (0..4).all(|k| (a[k] - b[k]).abs() <= 2.0 * SIGMAS * ea[k].hypot(eb[k]) + 1e-5),
                    "{scale}: {a:?} {b:?}"
                );
                changed += usize::from((0..4).any(|k| (a[k] - b[k]).abs() > 1e-3 * a[0]));
            }
        }
        // the same random numbers: only paths that pass an edge within a rounding go elsewhere
        assert!(
            changed < 48 * 48 / 100,
            "{changed} pixels of 2304 differ at scale {scale}"
        );
        let ((a, e), (b, _)) = (mean(&one, 0), mean(&other, 0));
        assert!(
            (a[0] - b[0]).abs() < 0.2 * e[0],
            "scale {scale}: {a:?} {b:?}"
        );
    }
}

#[test]
fn a_faceted_glass_ball_in_uniform_light_is_invisible() {
    let ball = Ball::new();
    let glass = "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf>";
    for scale in [1e-6, 1.0, 1e6] {
        let lookat = format!(
            "origin='0, 0, {}' target='0, 0, 0' up='0, 1, 0'",
            3.0 * scale
        );
        let text = film_scene(
            1000,
            &lookat,
            45.0,
            [32, 32],
            &format!("{SURROUNDINGS}{}", ball.xml(scale, glass)),
        );
        let image = Shot::new(256).of_text(&text);
        assert_stokes(
            &format!("glass ball of size {scale}"),
            mean(&image, 0),
            [1.0, 0.0, 0.0, 0.0],
            1e-6,
        );
    }
}
