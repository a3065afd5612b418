//! Tests of coherence through specular chains, against the matrices of paraxial optics.
//!
//! On (displacement, index × angle) across a meridional ray, with the angles θ1, θ2 of incidence and refraction:
//!
//! ```text
//! free path        [[1, l/n], [0, 1]]
//! plane refraction tangential diag(cos θ2/cos θ1, cos θ1/cos θ2), sagittal 1
//! convex mirror    tangential [[1, 0], [2/(R cos θ1), 1]], sagittal [[1, 0], [2 cos θ1/R, 1]]
//! ```
//!
//! The upper right element B of the product from the receiver to the source is what a turn of the ray at the receiver
//! shifts it by: the effective distance.

use std::path::Path;

use glam::DVec3;

use super::*;
use crate::light::Intensity;
use crate::light::Sight;
use crate::material::Departure;
use crate::path::{Counters, PathOptions};
use crate::sampler::SampleStream;
use crate::scene::{Overrides, build, read_text};

/// Half-width of the lamp, metres.
const HALF: f64 = 0.001;

/// What rays next to the chief ray are turned by, times how much the distance changes with the angle, of order one.
const ONE_SIDED: f64 = 5e-3;

/// A lamp at `at`, facing `toward`, its u axis in the xz plane.
fn lamp(at: DVec3, toward: DVec3) -> String {
    let target = at + toward;
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='{HALF}'/>
            <lookat origin='{}, {}, {}' target='{}, {}, {}' up='0, 1, 0'/></transform>
            <emitter type='area'><float name='radiance' value='1'/></emitter></shape>",
        at.x, at.y, at.z, target.x, target.y, target.z
    )
}

/// Effective distances, tangential and sagittal, of a lamp that a chain shows to a receiver; `None` if it is lost.
fn distances(content: &str, from: DVec3, direction: DVec3, parts: &[Part]) -> Option<[f64; 2]> {
    let xml = format!(
        "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/></sensor>{content}</scene>"
    );
    let document = read_text(&xml, Path::new("test.xml"), &[]).expect("a scene");
    let built = build(&document, Overrides::default()).expect("a scene");
    let scene = &built.scene;
    let (options, mut counters, mut stack) =
        (PathOptions::default(), Counters::default(), scene.stack());
    let mut witness = ();
    let mut walk = Walk::<Intensity<1>, ()> {
        scene,
        options: &options,
        wavelengths: &[550.0],
        stream: SampleStream::new(1, 1, 1),
        stack: &mut stack,
        counters: &mut counters,
        witness: &mut witness,
        way: Way::new(direction.as_vec3a()),
        seen: <Intensity<1> as Light>::dark(),
    };
    let (position, direction) = (from.as_vec3a(), direction.as_vec3a());
    let frame = Frame::around(direction);
    let mut ray = Ray {
        origin: position,
        direction,
        t_max: f32::INFINITY,
    };
    for part in parts {
        let met = walk.scene.intersect(&ray, walk.stack)?;
        let surface = met.surface;
        let vertex = Vertex {
            o: surface.frame.to_local(-ray.direction),
            position: surface.position,
            frame: surface.frame,
            viewer_distance: 1.0,
            sight: Sight::BLIND,
        };
        let bent = scene.materials[met.owner.material as usize].bend(&vertex, *part, &[550.0])?;
        ray.direction = surface.frame.to_world(bent);
        ray.origin = offset_origin(
            surface.position,
            surface.error,
            surface.normal,
            ray.direction,
        );
        walk.way.note(*part, met.owner.material);
    }
    // of the order of the ways here; a patch's distance, and the measure of a caustic
    walk.way.length = 1.0;
    let departure = Departure {
        direction: Vec3A::Z,
        density: 1.0,
        part: Part::Continuous,
        eta: 1.0,
    };
    let waiting = Waiting {
        material: &scene.materials[0],
        vertex: Vertex {
            o: Vec3A::Z,
            position,
            frame,
            viewer_distance: 1.0,
            sight: Sight::BLIND,
        },
        start: (Vec3A::ZERO, direction),
        departure,
        lobe: 0.01,
    };
    let emitter = &scene.emitters[0];
    let outline = emitter.outline(scene).expect("a flat lamp");
    let start = Surface {
        position,
        error: Vec3A::ZERO,
        normal: direction,
        frame,
    };
    let way = walk.way;
    let hit = walk.neighbour(&way, &start, direction, &outline)?;
    let last = Ray {
        origin: position,
        direction,
        t_max: f32::INFINITY,
    };
    let at = Surface {
        position: hit,
        ..start
    };
    assert!((hit - outline.centre).length() < 1e-5, "{hit}");
    let patch = walk.patch_through(&waiting, emitter, &at, &last, 1.0)?;
    // a patch that is hit in its centre lies where the ray goes
    assert!((patch.direction - direction).length() < 1e-5);
    let solid_angle = f64::from(patch.solid_angle);
    let seen = patch
        .angular_root
        .map(|root| HALF / 3f64.sqrt() / f64::from(root.length()));
    let area = 4.0 * HALF * HALF;
    assert!((solid_angle / (area / (seen[0] * seen[1])) - 1.0).abs() < 1e-3);
    Some(seen)
}

fn assert_distances(what: &str, found: Option<[f64; 2]>, expected: [f64; 2]) {
    let found = found.unwrap_or_else(|| panic!("{what}: lost"));
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(
            (found / expected.abs() - 1.0).abs() < ONE_SIDED,
            "{what}: {found} for {expected}"
        );
    }
}

/// The direction in the xz plane at an angle from −z.
fn down(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, -angle.cos())
}

const GLASS: &str = "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf>";
const REFRACTED: Part = Part::Discrete(1);
const MIRRORED: Part = Part::Discrete(0);

fn plane(z: f64, turn: f64, bsdf: &str) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='5'/><rotate x='1' angle='{turn}'/><translate z='{z}'/></transform>{bsdf}</shape>"
    )
}

#[test]
fn nothing_on_the_way_leaves_the_distance() {
    let found = distances(
        &lamp(down(0.3) * 2.0, -down(0.3)),
        DVec3::ZERO,
        down(0.3),
        &[],
    );
    assert_distances("free path", found, [2.0, 2.0]);
}

#[test]
fn lengths_add_through_flat_mirrors() {
    // down at 0.5 to z = 0, up to a second mirror at z = 1, down to the lamp
    let (up, c) = (DVec3::new(0.5f64.sin(), 0.0, 0.5f64.cos()), 0.5f64.cos());
    let at = up / c + down(0.5) * 0.4;
    let mirror = "<bsdf type='conductor'/>";
    let content = lamp(at, -down(0.5)) + &plane(0.0, 0.0, mirror) + &plane(1.0, 180.0, mirror);
    let found = distances(&content, -down(0.5) * 0.6, down(0.5), &[MIRRORED; 2]);
    let expected = 0.6 + 1.0 / c + 0.4;
    assert_distances("two mirrors", found, [expected; 2]);
}

#[test]
fn a_plane_refraction_is_astigmatic() {
    let (l_r, l_s, theta) = (0.5, 0.8, 60f64.to_radians());
    let below = (theta.sin() / 1.5).asin();
    let ratio = below.cos() / theta.cos();
    let content = lamp(down(below) * l_s, -down(below)) + &plane(0.0, 0.0, GLASS);
    let found = distances(&content, -down(theta) * l_r, down(theta), &[REFRACTED]);
    let expected = [l_r * ratio + l_s / 1.5 / ratio, l_r + l_s / 1.5];
    assert_distances("refraction", found, expected);
}

#[test]
fn the_way_back_from_glass_is_as_long_times_the_index() {
    // K is symmetric, dm/dθ = n/K
    let (l_r, l_s, theta) = (0.5, 0.8, 40f64.to_radians());
    let below = (theta.sin() / 1.5).asin();
    let ratio = below.cos() / theta.cos();
    let expected = [l_r * ratio + l_s / 1.5 / ratio, l_r + l_s / 1.5];
    let content = lamp(-down(theta) * l_r, down(theta)) + &plane(0.0, 0.0, GLASS);
    let found = distances(&content, down(below) * l_s, -down(below), &[REFRACTED]);
    assert_distances("back", found, expected.map(|s| 1.5 * s));
}

#[test]
fn a_parallel_plate_is_astigmatic() {
    let (l1, l2, thick, theta) = (0.3, 0.4, 0.6, 1.0f64);
    let below = (theta.sin() / 1.5).asin();
    let inside = thick / below.cos();
    let at = down(below) * inside + down(theta) * l2;
    let content = lamp(at, -down(theta)) + &plane(0.0, 0.0, GLASS) + &plane(-thick, 180.0, GLASS);
    let found = distances(&content, -down(theta) * l1, down(theta), &[REFRACTED; 2]);
    let sagittal = l1 + l2 + inside / 1.5;
    let tangential = l1 + l2 + inside / 1.5 * (theta.cos() / below.cos()).powi(2);
    assert_distances("plate", found, [tangential, sagittal]);
}

#[test]
fn spherical_mirrors_bend_wave_fronts() {
    let (l1, l2, theta) = (0.5, 0.7, 0.6f64);
    let up = DVec3::new(theta.sin(), 0.0, theta.cos());
    for (convex, radius) in [(true, 2.0), (false, 3.0)] {
        // touches z = 0 at the origin, its shining side up
        let z = if convex { -radius } else { radius };
        let content = lamp(up * l2, -up)
            + &format!(
                "<shape type='sphere'><point name='center' x='0' y='0' z='{z}'/><float name='radius' value='{radius}'/>
                 <boolean name='flip_normals' value='{}'/><bsdf type='conductor'/></shape>",
                !convex
            );
        let found = distances(&content, -down(theta) * l1, down(theta), &[MIRRORED]);
        let bend = if convex { 2.0 / radius } else { -2.0 / radius };
        let b = |power: f64| l1 + l2 + power * l1 * l2;
        let expected = [b(bend / theta.cos()), b(bend * theta.cos())];
        assert_distances(&format!("mirror {radius}"), found, expected);
    }
}

#[test]
fn near_a_caustic_and_past_an_edge_the_way_is_lost() {
    // a concave mirror, receiver and lamp near its centre: B = 0.998 + 0.999 - 2 * 0.998 * 0.999 = 0.003
    let content = lamp(DVec3::new(0.0, 0.0, 0.999), DVec3::NEG_Z)
        + "<shape type='sphere'><point name='center' x='0' y='0' z='1'/><boolean name='flip_normals' value='true'/><bsdf type='conductor'/></shape>";
    let from = DVec3::new(0.0, 0.0, 0.998);
    assert_eq!(distances(&content, from, DVec3::NEG_Z, &[MIRRORED]), None);
    // a mirror smaller than what neighbouring rays need
    let content = lamp(DVec3::new(0.0, 0.0, 1.0), DVec3::NEG_Z)
        + "<shape type='rectangle'><transform name='to_world'><scale value='0.0001'/></transform><bsdf type='conductor'/></shape>";
    let from = DVec3::new(0.0, 0.0, 0.5);
    assert_eq!(distances(&content, from, DVec3::NEG_Z, &[MIRRORED]), None);
}
