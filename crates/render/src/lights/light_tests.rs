//! Claims about what a camera sees: no light is lost or counted twice, whatever the sources, and the choice among them is
//! worth its while.

use std::f64::consts::PI;
use std::fmt::Write;

use glam::{DVec3, Vec3A, dvec3};

use super::BLIND;
use super::testing::{built, numbers};
use crate::geometry::ray::Ray;
use crate::light::Polarized;
use crate::path::{CameraSample, Counters, Start, trace};
use crate::sampler::SampleStream;
use crate::scene::BuiltScene;

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
            start: &Start::Ray {
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

/// Three hundred lamps of very different powers and distances, number `set` of such sets, and their irradiance.
fn three_hundred_lamps(set: u64) -> (String, f64) {
    const LAMPS: u32 = 300;
    let mut content = String::new();
    let mut irradiance = 0.0;
    for lamp in 0..LAMPS {
        let [strength, far, ..] = numbers(1000 * set + u64::from(lamp));
        let radiance = 10f64.powf(4.0 * strength - 2.0);
        let radiance_xml = format!("<float name='radiance' value='{radiance}'/>");
        let distance = 10f64.powf(1.5 * far - 0.5);
        // neighbours are 0.13 apart
        let (xml, each) = ball(fibonacci(lamp, LAMPS), distance, 0.03, &radiance_xml);
        content += &xml;
        irradiance += radiance * each;
    }
    (content, irradiance)
}

#[test]
fn three_hundred_lamps_give_their_sum_with_less_noise_than_even_chances() {
    // how much it helps depends on where the brightest of them stand: twice in the mean over some sets of them
    const SETS: u64 = 8;
    let mut logarithms = 0.0;
    for set in 0..SETS {
        let (content, irradiance) = three_hundred_lamps(set);
        let mut built = floor(&content);
        let expected = ALBEDO / PI * irradiance;
        let chosen = assert_seen("chosen", &built, 550.0, 100_000, expected);
        built.scene.weigh_lights_evenly();
        let even = assert_seen("even", &built, 550.0, 100_000, expected);
        assert!(chosen < even, "set {set}: {chosen} {even}");
        logarithms += (chosen / even).ln();
    }
    let ratio = (logarithms / SETS as f64).exp();
    assert!(ratio < 0.5, "{ratio}");
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
