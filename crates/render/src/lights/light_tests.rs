//! Claims: chances are those with which sources are drawn; no light is lost or counted twice, whatever the sources; and
//! the choice is worth its while.

use std::f64::consts::PI;
use std::fmt::Write;

use glam::{DVec3, Vec3A, dvec3};

use super::bundle::Seen;
use super::{BLIND, Glance};
use crate::geometry::frame::Frame;
use crate::geometry::ray::Ray;
use crate::light::Polarized;
use crate::path::{CameraSample, Counters, Start, trace};
use crate::sampler::{SampleStream, uniform_sphere};
use crate::scene::{BuiltScene, Overrides, build, read_text};

fn built(content: &str) -> BuiltScene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>
         <sensor type='perspective'/>{content}</scene>"
    );
    let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
    build(&document, Overrides::default()).unwrap()
}

/// Six uniform numbers of a source.
fn numbers(source: u64) -> [f64; 6] {
    let stream = SampleStream::new(11, 0, source);
    let [a, b, c] = [0, 2, 4].map(|dimension| stream.pair(dimension));
    [a[0], a[1], b[0], b[1], c[0], c[1]].map(f64::from)
}

/// Sources of every kind, of strengths over six decades, in a box of two metres; one in a hundred outside the scene.
fn of_all_kinds(count: u64) -> String {
    let mut content = String::from("<emitter type='constant'/>");
    for source in 1..count {
        let [x, y, z, strength, turn, tilt] = numbers(source);
        let place = format!(
            "<rotate x='1' angle='{}'/><rotate y='1' angle='{}'/><translate x='{}' y='{}' z='{}'/>",
            180.0 * tilt,
            360.0 * turn,
            2.0 * x - 1.0,
            2.0 * y - 1.0,
            2.0 * z - 1.0
        );
        let strength = 10f64.powf(6.0 * strength - 3.0);
        let placed = format!("<transform name='to_world'>{place}</transform>");
        let small = format!("<transform name='to_world'><scale value='0.02'/>{place}</transform>");
        let area =
            format!("<emitter type='area'><float name='radiance' value='{strength}'/></emitter>");
        let shape = |kind: &str| format!("<shape type='{kind}'>{small}{area}</shape>");
        content += &match source % 100 {
            0 => format!(
                "<emitter type='directional'>{placed}<float name='irradiance' value='{strength}'/></emitter>"
            ),
            1 => format!(
                "<emitter type='laser'>{placed}<float name='power' value='{strength}'/>
                 <string name='waist' value='20cm'/></emitter>"
            ),
            k if k < 20 => format!(
                "<emitter type='point'>{placed}<float name='intensity' value='{strength}'/></emitter>"
            ),
            k if k < 40 => format!(
                "<emitter type='spot'>{placed}<float name='intensity' value='{strength}'/>
                 <float name='cutoff_angle' value='{}'/></emitter>",
                1.0 + 4.0 * k as f64
            ),
            k => shape(["rectangle", "disk", "sphere", "cube", "cylinder"][(k % 5) as usize]),
        };
    }
    content
}

/// Places in and around the box, and far from it.
fn places() -> impl Iterator<Item = Vec3A> {
    (0..40).map(|k| {
        let stream = SampleStream::new(12, 0, k);
        let distance = [0.3, 1.0, 3.0, 1e4][k as usize % 4];
        uniform_sphere(stream.pair(0)) * distance
    })
}

#[test]
fn chances_sum_to_one_and_are_those_of_the_draws() {
    // a source is drawn for an interval of numbers in the blind part and one in the other, so that even numbers miss its
    // chance by at most one number at either end of both; and roundings of the number on the way down
    const DRAWS: u32 = 1 << 16;
    let bound = 4.0 / f64::from(DRAWS) + 4e-6;
    for count in [2, 3, 8, 1000] {
        let built = built(&of_all_kinds(count));
        for from in places().step_by(if count < 1000 { 1 } else { 7 }) {
            let chances: Vec<f32> = (0..count as u32)
                .map(|source| built.scene.chance_of_emitter(source, from))
                .collect();
            let sum: f64 = chances.iter().copied().map(f64::from).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{count} {from}: {sum}");
            let mut drawn = vec![0u32; chances.len()];
            for k in 0..DRAWS {
                let u = (k as f32 + 0.5) / DRAWS as f32;
                let (source, chance) = built
                    .scene
                    .lights
                    .choose(&built.scene.emitters, from, u)
                    .unwrap();
                assert_eq!(chance, chances[source as usize], "{count} {from} {source}");
                drawn[source as usize] += 1;
            }
            for (source, (drawn, chance)) in drawn.iter().zip(&chances).enumerate() {
                let off = f64::from(*drawn) / f64::from(DRAWS) - f64::from(*chance);
                assert!(off.abs() < bound, "{count} {from} {source}: {off}");
            }
        }
    }
}

#[test]
fn what_is_thought_dark_sends_nothing() {
    let built = built(&of_all_kinds(1000));
    let frame = Frame::around(Vec3A::Z);
    let mut dark = 0;
    for emitter in &built.scene.emitters {
        let Glance::Near(bundle) = emitter.glance(&built.scene, [550.0; 2]) else {
            continue;
        };
        let seen = Seen::one(&bundle, 1.0);
        for from in places().filter(|&from| seen.irradiance(from) <= 0.0) {
            dark += 1;
            for k in 0..8 {
                let u = SampleStream::new(13, 0, k).pair(0);
                let connection = emitter.connect(&built.scene, from, &frame, u);
                assert!(connection.is_none(), "{from} {emitter:?}");
            }
        }
    }
    // of flat lamps half of the places are behind them
    assert!(dark > 1000, "{dark}");
}

#[test]
fn the_choice_among_lamps_of_equal_strength_follows_their_distance() {
    // the second moment of a sum Σ E drawn with chances p is Σ E²/p, at least (Σ E)²: even chances against those of the tree
    let lamps: String = (0..1000)
        .map(|lamp| {
            let [x, y, z, ..] = numbers(lamp);
            format!(
                "<emitter type='point'><point name='position' x='{x}' y='{y}' z='{z}'/></emitter>"
            )
        })
        .collect();
    let built = built(&lamps);
    let (mut even, mut chosen) = (0.0, 0.0);
    for k in 0..200 {
        let at = |source| {
            let [x, y, z, ..] = numbers(source);
            dvec3(x, y, z).as_vec3a()
        };
        let from = at(5000 + k);
        let irradiance: Vec<f64> = (0..1000)
            .map(|lamp| f64::from(at(lamp).distance_squared(from).recip()))
            .collect();
        let least = irradiance.iter().sum::<f64>().powi(2);
        even += 1000.0 * irradiance.iter().map(|e| e * e).sum::<f64>() / least;
        chosen += (0..)
            .zip(&irradiance)
            .map(|(lamp, e)| e * e / f64::from(built.scene.chance_of_emitter(lamp, from)))
            .sum::<f64>()
            / least;
    }
    println!(
        "second moments over the least, mean of 200 places: even {}, chosen {}",
        even / 200.0,
        chosen / 200.0
    );
    // in the midst of its lamps a box says little of the nearest: half of what even chances lose is a modest demand
    assert!(chosen < 0.5 * even, "{chosen} {even}");
}

/// Albedo of the floor.
const ALBEDO: f64 = 0.6;

/// A diffuse floor below lamps, seen at the origin.
fn floor(lamps: &str) -> BuiltScene {
    built(&format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='100'/></transform>
         <bsdf type='diffuse'><spectrum name='reflectance' value='{ALBEDO}'/></bsdf></shape>{lamps}"
    ))
}

/// S0 that a camera sees of the origin, and its variance.
fn seen(built: &BuiltScene, wavelength: f32, samples: u64) -> (f64, f64) {
    let mut stack = built.scene.stack();
    let mut counters = Counters::default();
    let (mut sum, mut square) = (0.0, 0.0);
    for sample in 0..samples {
        let camera = CameraSample {
            start: Start::Ray {
                ray: Ray {
                    origin: Vec3A::new(0.05, 0.0, 0.1),
                    direction: Vec3A::new(-0.05, 0.0, -0.1).normalize(),
                    t_max: f32::INFINITY,
                },
                axis: Vec3A::Y,
            },
            wavelengths: &[wavelength],
            stream: SampleStream::new(7, 0, sample),
        };
        let [stokes] = trace::<Polarized<1>, _>(
            &built.scene,
            &built.paths,
            camera,
            &mut stack,
            &mut counters,
            &mut (),
        );
        sum += f64::from(stokes.x);
        square += f64::from(stokes.x).powi(2);
    }
    let mean = sum / samples as f64;
    (mean, square / samples as f64 - mean * mean)
}

/// Five standard errors and single precision.
fn assert_seen(
    what: &str,
    built: &BuiltScene,
    wavelength: f32,
    samples: u64,
    expected: f64,
) -> f64 {
    let (mean, variance) = seen(built, wavelength, samples);
    let error = (variance / samples as f64).sqrt();
    println!("{what}: {mean:.6} ± {error:.6} for {expected:.6}, variance {variance:.4e}");
    assert!(
        (mean - expected).abs() < 5.0 * error + 1e-5 * expected,
        "{what}: {mean} ± {error} for {expected}"
    );
    variance
}

/// Direction number `k` of `count` evenly over the upper half, but for the lowest sixth.
fn fibonacci(k: u32, count: u32) -> DVec3 {
    let z = 1.0 - 5.0 / 6.0 * (f64::from(k) + 0.5) / f64::from(count);
    let (sin, cos) = (f64::from(k) * PI * (3.0 - 5f64.sqrt())).sin_cos();
    let r = (1.0 - z * z).sqrt();
    dvec3(r * cos, r * sin, z)
}

/// A ball toward a direction, seen under an angle of given sine, and its irradiance for a radiance of 1.
fn ball(toward: DVec3, distance: f64, sine: f64, radiance: &str) -> (String, f64) {
    let c = toward * distance;
    let xml = format!(
        "<shape type='sphere'><point name='center' x='{}' y='{}' z='{}'/><float name='radius' value='{}'/>
         <emitter type='area'>{radiance}</emitter></shape>",
        c.x,
        c.y,
        c.z,
        distance * sine
    );
    (xml, PI * sine * sine * toward.z)
}

#[test]
fn three_hundred_lamps_give_their_sum_with_less_noise_than_even_chances() {
    const LAMPS: u32 = 300;
    let mut content = String::new();
    let mut irradiance = 0.0;
    for lamp in 0..LAMPS {
        let [strength, far, ..] = numbers(u64::from(lamp));
        let radiance = 10f64.powf(4.0 * strength - 2.0);
        let radiance_xml = format!("<float name='radiance' value='{radiance}'/>");
        let distance = 10f64.powf(1.5 * far - 0.5);
        // neighbours are 0.13 apart
        let (xml, each) = ball(fibonacci(lamp, LAMPS), distance, 0.03, &radiance_xml);
        content += &xml;
        irradiance += radiance * each;
    }
    let mut built = floor(&content);
    let expected = ALBEDO / PI * irradiance;
    let chosen = assert_seen("chosen", &built, 550.0, 100_000, expected);
    built.scene.weigh_lights_evenly();
    let even = assert_seen("even", &built, 550.0, 100_000, expected);
    assert!(chosen < 0.5 * even, "{chosen} {even}");
}

/// Irradiance at the origin, normal +z, of a polygon above it of radiance 1.
///
/// Source: Lambert, Photometria, 1760.
fn irradiance_of_polygon(corners: &[DVec3]) -> f64 {
    (0..corners.len())
        .map(|k| {
            let [a, b] = [corners[k], corners[(k + 1) % corners.len()]].map(DVec3::normalize);
            let across = a.cross(b);
            0.5 * across.length().atan2(a.dot(b)) * across.normalize().z
        })
        .sum::<f64>()
        .abs()
}

/// A rectangle that faces the origin's side of its plane, from its middle and half sides.
fn panel(centre: DVec3, half_u: DVec3, half_v: DVec3, radiance: f64) -> (String, f64) {
    let normal = half_u.cross(half_v).normalize();
    let normal = normal * -normal.dot(centre).signum();
    let columns = [half_u, half_v, normal, centre];
    let row = |axis: usize| {
        columns.iter().fold(String::new(), |mut row, column| {
            let _ = write!(row, "{} ", column[axis]);
            row
        })
    };
    let xml = format!(
        "<shape type='rectangle'><transform name='to_world'><matrix value='{}{}{}0 0 0 1'/></transform>
         <emitter type='area'><float name='radiance' value='{radiance}'/></emitter></shape>",
        row(0),
        row(1),
        row(2)
    );
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| centre + half_u * x + half_v * y);
    (xml, radiance * irradiance_of_polygon(&corners))
}

#[test]
fn connections_and_hits_share_lamps_of_very_different_powers() {
    // panels near and far, upright and skewed, beside a ball, a point and a sky; what hides what is known
    let panels = [
        panel(dvec3(0.0, 1.5, 2.0), DVec3::X, dvec3(0.0, 0.5, 0.0), 0.02),
        panel(
            dvec3(-1.5, 0.0, 0.6),
            dvec3(0.0, 0.7, 0.0),
            dvec3(0.0, 0.0, 0.5),
            3.0,
        ),
        panel(
            dvec3(1.5, 0.0, 1.0),
            dvec3(0.0, 0.5, 0.3),
            dvec3(0.1, 0.0, 0.4),
            0.5,
        ),
        panel(
            dvec3(0.2, -9.0, 7.0),
            dvec3(0.3, 0.0, 0.0),
            dvec3(0.0, 0.2, 0.2),
            200.0,
        ),
    ];
    let mut content: String = panels.iter().map(|panel| panel.0.as_str()).collect();
    let mut irradiance: f64 = panels.iter().map(|panel| panel.1).sum();
    let up = dvec3(0.1, 0.05, 1.0).normalize();
    let (xml, each) = ball(up, 0.5, 0.2, "<float name='radiance' value='0.7'/>");
    content += &xml;
    irradiance += 0.7 * each;
    content += "<emitter type='point'><point name='position' x='-1' y='-1' z='1'/><float name='intensity' value='0.01'/></emitter>";
    irradiance += 0.01 / 3.0 / 3f64.sqrt();
    let without_sky = floor(&content);
    assert_seen(
        "lamps",
        &without_sky,
        550.0,
        400_000,
        ALBEDO / PI * irradiance,
    );
    // each lamp hides what it covers of a sky
    let covered: f64 = panels
        .iter()
        .zip([0.02, 3.0, 0.5, 200.0])
        .map(|(panel, radiance)| panel.1 / radiance)
        .sum();
    let sky = 0.3;
    content += "<emitter type='constant'><float name='radiance' value='0.3'/></emitter>";
    irradiance += sky * (PI - covered - each);
    let with_sky = floor(&content);
    assert_seen(
        "lamps and sky",
        &with_sky,
        550.0,
        400_000,
        ALBEDO / PI * irradiance,
    );
}

#[test]
fn an_infrared_lamp_is_found_by_the_light_that_counts() {
    let table = |from: u32, to: u32, value: f64| {
        format!("<spectrum name='radiance' value='{from}:{value}, {to}:{value}'/>")
    };
    let (red, [aside, above]) = (table(8000, 12_000, 2.0), [dvec3(0.6, 0.0, 0.8), DVec3::Z]);
    let (infrared, each) = ball(above, 1.0, 0.1, &red);
    let lamps = infrared
        + &ball(aside, 1.0, 0.1, &table(300, 900, 50.0)).0
        + &ball(-aside.with_z(-0.8), 1.0, 0.1, &table(300, 900, 50.0)).0;
    let mut built = floor(&lamps);
    let expected = ALBEDO / PI * 2.0 * each;
    // weighed by what the eye sees it is dark, but never out of the game
    let chance = built.scene.chance_of_emitter(0, Vec3A::ZERO);
    assert_eq!(chance, BLIND / 3.0);
    let visible = assert_seen("by visible light", &built, 10_000.0, 40_000, expected);
    built.scene.weigh_lights([9000.0, 11_000.0]);
    let chance = built.scene.chance_of_emitter(0, Vec3A::ZERO);
    // all but the blind choices of the two others
    assert!(
        (chance - (1.0 - BLIND * 2.0 / 3.0)).abs() < 1e-6,
        "{chance}"
    );
    let infrared = assert_seen("by its own", &built, 10_000.0, 40_000, expected);
    assert!(infrared < 0.1 * visible, "{infrared} {visible}");
}

#[test]
fn a_single_lamp_is_certain() {
    let built = built("<emitter type='point'/>");
    for from in places() {
        for u in [0.0, 0.1, 0.999_999] {
            let (_, chance) = built.scene.choose_emitter(from, u).unwrap();
            assert_eq!(chance, 1.0);
        }
        assert_eq!(built.scene.chance_of_emitter(0, from), 1.0);
    }
}
