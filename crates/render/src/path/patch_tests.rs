//! Claim: how an emitter is cut into patches does not show, whichever way its light takes to the vertex.
//!
//! The matter is a Gaussian lobe (`material/lobe.rs`); what it sends to the camera is integrated over the lamp in
//! double precision. Few patches are only connected to, many also hit, and behind a mirror they are only hit.

use glam::{DVec3, Vec3A, dvec3};

use super::lobe::MOST_SUMMED_HERE;
use super::{CameraSample, Counters, PathOptions, Start, trace};
use crate::geometry::frame::Frame;
use crate::geometry::ray::Ray;
use crate::light::Polarized;
use crate::material::{Material, lobe::Lobe};
use crate::sampler::SampleStream;
use crate::scene::{BuiltScene, Overrides, build, read_text};

/// Sine and cosine of the angle at which the camera looks at the matter.
const SIN: f64 = 0.5;
fn cos() -> f64 {
    (1.0 - SIN * SIN).sqrt()
}

/// The matter: a large square around the origin that faces +z.
const GROUND: &str =
    "<shape type='rectangle'><transform name='to_world'><scale value='50'/></transform>
    <bsdf type='diffuse'/></shape>";

/// A lamp, and directions toward it with their solid angles.
struct Lamp {
    xml: String,
    directions: Vec<(DVec3, f64)>,
}

/// Steps of the quadrature along each axis of a lamp.
const STEPS: u32 = 400;

fn midpoints() -> impl Iterator<Item = (f64, f64)> {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(STEPS);
    (0..STEPS).flat_map(move |a| (0..STEPS).map(move |b| (at(a), at(b))))
}

/// A flat lamp of radiance 1 around a point, with half axes that nearly face the origin.
fn flat(round: bool, centre: DVec3, half_u: DVec3, half_v: DVec3) -> Lamp {
    let across = half_u.cross(half_v);
    let normal = across.normalize() * -across.dot(centre).signum();
    let cell = across.length() / f64::from(STEPS * STEPS);
    let directions = midpoints()
        .map(|(a, b)| {
            let (x, y, area) = if round {
                let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
                (a * cos, a * sin, cell * std::f64::consts::TAU * a)
            } else {
                (2.0 * a - 1.0, 2.0 * b - 1.0, 4.0 * cell)
            };
            let to = centre + half_u * x + half_v * y;
            let distance = to.length();
            (to / distance, -normal.dot(to) * area / distance.powi(3))
        })
        .collect();
    Lamp {
        xml: flat_xml(round, [half_u, half_v, normal, centre], 1.0),
        directions,
    }
}

fn flat_xml(round: bool, columns: [DVec3; 4], radiance: f64) -> String {
    let row = |axis: usize| columns.map(|c| c[axis].to_string()).join(" ");
    format!(
        "<shape type='{}'><transform name='to_world'><matrix value='{} {} {} 0 0 0 1'/></transform>
         <emitter type='area'><float name='radiance' value='{radiance}'/></emitter></shape>",
        if round { "disk" } else { "rectangle" },
        row(0),
        row(1),
        row(2)
    )
}

fn sphere(centre: DVec3, radius: f64) -> Lamp {
    let axis = Frame::around(centre.normalize().as_vec3a());
    let [s, t, n] = [axis.s, axis.t, axis.n].map(Vec3A::as_dvec3);
    let cap = 1.0 - (1.0 - (radius / centre.length()).powi(2)).sqrt();
    let directions = midpoints()
        .map(|(a, b)| {
            let z = 1.0 - cap * a;
            let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
            let d = (s * cos + t * sin) * (1.0 - z * z).sqrt() + n * z;
            (d, std::f64::consts::TAU * cap / f64::from(STEPS * STEPS))
        })
        .collect();
    Lamp {
        xml: format!(
            "<shape type='sphere'><point name='center' x='{}' y='{}' z='{}'/><float name='radius' value='{radius}'/>
             <emitter type='area'/></shape>",
            centre.x, centre.y, centre.z
        ),
        directions,
    }
}

/// What a lobe of the given width sends to the camera of the directions that are not blocked.
fn exact(lamp: &Lamp, width: f64, free: impl Fn(DVec3) -> bool) -> f64 {
    let norm = std::f64::consts::TAU * width * width;
    lamp.directions
        .iter()
        .filter(|(d, _)| free(*d))
        .map(|(d, solid_angle)| {
            let offset = (d.x + SIN).powi(2) + d.y * d.y;
            (-0.5 * offset / (width * width)).exp() / norm * d.z * solid_angle
        })
        .sum()
}

/// A scene whose material number k is the lobe `lobes[k]`, if there is one.
fn built(depth: i64, content: &str, lobes: &[Lobe]) -> BuiltScene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='{depth}'/></integrator>
         <sensor type='perspective'/>{content}</scene>"
    );
    let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
    let mut built = build(&document, Overrides::default()).unwrap();
    for (material, lobe) in built.scene.materials.iter_mut().zip(lobes) {
        *material = Material::Lobe(*lobe);
    }
    built.scene.index();
    built
}

fn lobe(width: f64) -> Lobe {
    Lobe {
        width: width as f32,
        albedo: 1.0,
        straight: 0.0,
    }
}

/// S0 that a camera sees of the origin, its standard error, and what it has cost.
fn seen(built: &BuiltScene, patch: f32, samples: u64) -> (f64, f64, Counters) {
    let options = PathOptions {
        patch,
        ..built.paths
    };
    let toward = Vec3A::new(SIN as f32, 0.0, cos() as f32);
    let mut stack = built.scene.stack();
    let mut counters = Counters::default();
    let (mut sum, mut square) = (0.0, 0.0);
    for sample in 0..samples {
        let camera = CameraSample {
            start: &Start::Ray {
                ray: Ray {
                    origin: toward * 0.5,
                    direction: -toward,
                    t_max: f32::INFINITY,
                },
                axis: Vec3A::Y,
            },
            wavelengths: &[550.0],
            stream: SampleStream::new(5, 0, sample),
        };
        let [stokes] = trace::<Polarized<1>, _>(
            &built.scene,
            &options,
            camera,
            &mut stack,
            &mut counters,
            &mut (),
        );
        sum += f64::from(stokes.x);
        square += f64::from(stokes.x).powi(2);
    }
    let n = samples as f64;
    let mean = sum / n;
    let error = ((square / n - mean * mean).max(0.0) / n).sqrt();
    (mean, error, counters)
}

/// Five standard errors, single precision, and what freezing cosines and distances at the centres of patches leaves.
fn assert_seen(what: &str, built: &BuiltScene, patch: f32, samples: u64, expected: f64, bias: f64) {
    let (found, error, _) = seen(built, patch, samples);
    println!(
        "{what}, patch {patch}: {found:.6} ± {error:.6}, exact {expected:.6}, off by {:+.4} %",
        100.0 * (found / expected - 1.0)
    );
    assert!(
        (found - expected).abs() <= 5.0 * error + (bias + 1e-5) * expected,
        "{what}, patch {patch}: {found} ± {error} for {expected}"
    );
}

/// The direction in which the lobe looks, and two axes across it.
fn view() -> [DVec3; 3] {
    [dvec3(-SIN, 0.0, cos()), dvec3(cos(), 0.0, SIN), DVec3::Y]
}

const PATCHES: [f32; 4] = [0.0, 0.1, 0.25, 0.5];

/// Largest relative bias of a patch: 0.2 % at the default size, and falling with its area.
fn bias(patch: f32) -> f64 {
    0.002 * f64::from(patch / 0.5).powi(2)
}

#[test]
fn the_cut_of_a_lamp_does_not_show() {
    let [to, across, up] = view();
    // beside the lobe's centre, so that the rim lies on its slope; the sizes are a few lobes
    let centre = (to + across * 0.03) * 2.0;
    for (what, width, lamp) in [
        (
            "a rectangle",
            0.03,
            flat(false, centre, (across + to * 0.3) * 0.1, up * 0.06),
        ),
        (
            "a large rectangle",
            0.03,
            flat(false, centre, across * 0.5, up * 0.4),
        ),
        ("a disk", 0.03, flat(true, centre, across * 0.12, up * 0.08)),
        (
            "a large disk",
            0.03,
            flat(true, centre, (across + to * 0.4) * 0.4, up * 0.3),
        ),
        ("a sphere", 0.03, sphere(centre, 0.1)),
        ("a near sphere", 0.1, sphere(centre * 0.6, 0.9)),
        (
            "a rectangle under a wide lobe",
            0.5,
            flat(false, centre, across * 0.2, up * 0.2),
        ),
    ] {
        let built = built(2, &format!("{GROUND}{}", lamp.xml), &[lobe(width)]);
        let expected = exact(&lamp, width, |_| true);
        for patch in PATCHES {
            // under a wide lobe patches are as wide as they may be, 0.05 rad: twice its square
            let frozen = if patch > 0.0 && width > 0.1 {
                0.005
            } else {
                0.0
            };
            assert_seen(what, &built, patch, 60_000, expected, bias(patch) + frozen);
        }
    }
}

#[test]
fn all_patches_or_one_is_the_same() {
    let [to, across, up] = view();
    let lamp = flat(true, (to + across * 0.03) * 2.0, across * 0.12, up * 0.08);
    let built = built(2, &format!("{GROUND}{}", lamp.xml), &[lobe(0.03)]);
    let expected = exact(&lamp, 0.03, |_| true);
    for most in [0, u32::MAX] {
        MOST_SUMMED_HERE.set(most);
        for patch in [0.1, 0.5] {
            let what = format!("at most {most} summed");
            // the sum has no noise, but takes its time
            let samples = if most == 0 { 60_000 } else { 1000 };
            assert_seen(&what, &built, patch, samples, expected, bias(patch));
        }
    }
}

#[test]
#[ignore = "a measurement: prints variance times time, relative to the mean, of both ways to connect to patches"]
fn what_summing_patches_costs() {
    let [to, across, up] = view();
    println!("half-width of the lamp over the lobe's, patch: plane waves / all summed / one drawn");
    for size in [0.02, 0.06, 0.12, 0.25, 0.5] {
        let lamp = flat(false, (to + across * 0.03) * 2.0, across * size, up * size);
        // half of the light is in the shadow of a slanting edge
        let edge = "<shape type='rectangle'><transform name='to_world'><scale value='5'/><rotate z='1' angle='30'/>
            <translate x='1.98' y='-4.33' z='0.9'/></transform><bsdf type='diffuse'>
            <float name='reflectance' value='0'/></bsdf></shape>";
        for shadow in ["", edge] {
            let built = built(2, &format!("{GROUND}{}{shadow}", lamp.xml), &[lobe(0.03)]);
            let cost = |patch: f32, most: u32| {
                MOST_SUMMED_HERE.set(most);
                let start = cpu_time::ProcessTime::now();
                let (mean, error, _) = seen(&built, patch, 100_000);
                (error / mean).powi(2) * start.elapsed().as_secs_f64() * 1e6
            };
            for patch in [0.25, 0.5] {
                println!(
                    "{:.1} lobes, patch {patch}, {}: {:.1} / {:.1} / {:.1}",
                    size / 2.0 / 0.03,
                    if shadow.is_empty() { "free" } else { "edge" },
                    cost(0.0, 0),
                    cost(patch, u32::MAX),
                    cost(patch, 0)
                );
            }
        }
    }
}

#[test]
fn lamps_of_different_brightness_add_up() {
    let [to, across, up] = view();
    let (width, right, left) = (0.03, (to + across * 0.08) * 2.0, (to - across * 0.08) * 2.0);
    for size in [0.14, 0.5] {
        let halves = [across * 0.14, up * size];
        let lamps = [right, left].map(|centre| flat(false, centre, halves[0], halves[1]));
        let bright = lamps[1].xml.replace("value='1'", "value='5'");
        let point = "<emitter type='point'><point name='position' x='9' y='0' z='1'/></emitter>";
        let built = built(
            2,
            &format!("{GROUND}{}{bright}{point}", lamps[0].xml),
            &[lobe(width)],
        );
        let expected = exact(&lamps[0], width, |_| true) + 5.0 * exact(&lamps[1], width, |_| true);
        for patch in PATCHES {
            assert_seen("two lamps", &built, patch, 100_000, expected, bias(patch));
        }
    }
}

#[test]
fn a_lamp_in_a_flat_mirror_is_a_lamp_farther_off() {
    let [to, across, up] = view();
    let width = 0.03;
    let centre = (to + across * 0.03) * 3.0;
    let half = [(across + to * 0.3) * 0.15, up * 0.1];
    for round in [false, true] {
        let lamp = flat(round, centre, half[0], half[1]);
        // the lamp's image lies behind the plane x = −1
        let turned = |v: DVec3| dvec3(-v.x, v.y, v.z);
        let normal = turned(half[0].cross(half[1]).normalize());
        let place = turned(centre) - dvec3(2.0, 0.0, 0.0);
        let normal = normal * normal.dot(dvec3(-1.0, 0.0, place.z * 0.5) - place).signum();
        let columns = [turned(half[0]), turned(half[1]), normal, place];
        let mirror = "<shape type='rectangle'><transform name='to_world'><rotate y='1' angle='90'/>
            <scale value='20'/><translate x='-1'/></transform><bsdf type='conductor'/></shape>";
        let content = format!("{GROUND}{}{mirror}", flat_xml(round, columns, 1.0));
        let built = built(3, &content, &[lobe(width)]);
        for patch in PATCHES {
            let what = if round {
                "a disk in a mirror"
            } else {
                "a rectangle in a mirror"
            };
            assert_seen(
                what,
                &built,
                patch,
                100_000,
                exact(&lamp, width, |_| true),
                bias(patch),
            );
        }
    }
}

#[test]
fn flat_matter_on_the_way_passes_light_once() {
    let [to, across, up] = view();
    let (width, centre) = (0.03, (to + across * 0.03) * 2.0);
    let plate = |z: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='20'/><translate z='{z}'/></transform>
             <bsdf type='null'/></shape>"
        )
    };
    for size in [0.1, 0.5] {
        let lamp = flat(false, centre, across * 0.1, up * size);
        let expected = exact(&lamp, width, |_| true);
        let content = format!("{GROUND}{}{}{}", lamp.xml, plate(0.8), plate(1.2));
        for patch in PATCHES {
            let clear = built(4, &content, &[lobe(width)]);
            assert_seen("two plates", &clear, patch, 60_000, expected, bias(patch));
            let short = built(3, &content, &[lobe(width)]);
            assert_eq!(
                seen(&short, patch, 1000).0,
                0.0,
                "paths are too short for two plates"
            );
            // a veil that takes light out of its way and scatters nothing back
            let veil = Lobe {
                albedo: 0.0,
                straight: 0.6,
                ..lobe(0.2)
            };
            let veiled = format!("{GROUND}{}{}", plate(1.2), lamp.xml);
            let veiled = built(3, &veiled, &[lobe(width), veil]);
            assert_seen(
                "a veil",
                &veiled,
                patch,
                100_000,
                0.6 * expected,
                bias(patch),
            );
        }
    }
}

#[test]
fn plain_matter_sees_the_surroundings_through_flat_matter() {
    // Lambert of reflectance 1/2 under uniform light behind a neutral filter of 1/2
    let filter = "<shape type='sphere'><float name='radius' value='2'/><bsdf type='polarizer'>
        <boolean name='polarizing' value='false'/></bsdf></shape><emitter type='constant'/>";
    let built = built(3, &format!("{GROUND}{filter}"), &[]);
    assert_seen("a filter dome", &built, 0.5, 50_000, 0.25, 0.0);
    let hidden = self::built(3, &format!("{GROUND}<emitter type='constant'/>"), &[]);
    assert_seen("no dome", &hidden, 0.5, 50_000, 0.5, 0.0);
}

#[test]
fn the_shadow_of_an_edge_is_soft_by_the_size_of_a_patch() {
    let [to, across, up] = view();
    let (width, centre) = (0.03, to * 2.0);
    for (what, size) in [("few patches", 0.12), ("many patches", 0.5)] {
        let lamp = flat(false, centre, across * size, up * size);
        for shift in [-0.02, 0.0, 0.02] {
            // an edge half way, parallel to y
            let edge = -SIN + shift;
            let occluder = format!(
                "<shape type='rectangle'><transform name='to_world'><scale value='5'/><translate x='{}' z='{}'/>
                 </transform><bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf></shape>",
                edge - 5.0,
                cos()
            );
            let content = format!("{GROUND}{}{occluder}", lamp.xml);
            let built = built(2, &content, &[lobe(width)]);
            let whole = exact(&lamp, width, |_| true);
            let expected = exact(&lamp, width, |d| d.x / d.z * cos() > edge);
            for patch in PATCHES {
                let (found, error, _) = seen(&built, patch, 50_000);
                let off = (found - expected) / whole;
                println!(
                    "edge at {shift:+.2}, {what}, patch {patch}: off by {off:+.4} ± {:.4} of the lamp",
                    error / whole
                );
                // the light of a patch is spread evenly over it, and of several edges only one crosses
                let bound = 0.03 * f64::from(patch / 0.5);
                assert!(
                    (found - expected).abs() <= 5.0 * error + (bound + 1e-5) * whole,
                    "edge at {shift}, {what}, patch {patch}: {found} ± {error} for {expected}"
                );
            }
        }
    }
}

#[test]
fn light_lost_between_mirrors_comes_to_an_end() {
    // a small piece of matter inside a mirror ball
    let content = "<shape type='rectangle'><transform name='to_world'><scale value='0.01'/></transform>
        <bsdf type='diffuse'/></shape>
        <shape type='sphere'><boolean name='flip_normals' value='true'/><bsdf type='conductor'/></shape>";
    let built = built(-1, content, &[lobe(0.3)]);
    let (_, _, counters) = seen(&built, 0.5, 200);
    // twenty bounces between deaths with a probability of 1/20, and six before
    assert!(
        counters.rays < 40 * counters.paths,
        "{} rays a path",
        counters.rays / counters.paths
    );
}
