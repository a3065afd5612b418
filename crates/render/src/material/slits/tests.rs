use std::path::Path;

use mueller16::Tolerance;
use nalgebra::{Vector2, Vector3};
use stokes::Wavelength;

use super::*;
use crate::geometry::frame::Frame;
use crate::light::{MuellerResponse, Polarized, Sight};
use crate::material::Material;
use crate::sampler::SampleStream;
use crate::scene::{Overrides, build, read_text};

const GREEN: f32 = 550.0;

fn slits(shape: &str, parameters: &[(&str, &str)]) -> Result<Slits, String> {
    let strings: String = parameters
        .iter()
        .map(|(name, value)| match *name {
            "count" => format!("<integer name='{name}' value='{value}'/>"),
            _ => format!("<string name='{name}' value='{value}'/>"),
        })
        .collect();
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/>\n<shape type='{shape}'>\
         <transform name='to_world'><scale value='0.0005'/></transform>\n<bsdf type='slits'>{strings}</bsdf></shape></scene>"
    );
    let document =
        read_text(&text, Path::new("test.xml"), &[]).map_err(|error| error.to_string())?;
    let built = build(&document, Overrides::default()).map_err(|error| error.to_string())?;
    match built.scene.materials.into_iter().next_back() {
        Some(Material::Slits(slits)) => Ok(*slits),
        other => panic!("{other:?}"),
    }
}

const THREE: [(&str, &str); 4] = [
    ("count", "3"),
    ("width", "12um"),
    ("height", "30um"),
    ("spacing", "150um"),
];

fn vertex(o: Vec3A, viewer_distance: f32) -> Vertex {
    Vertex {
        o,
        position: Vec3A::ZERO,
        frame: Frame {
            s: Vec3A::X,
            t: Vec3A::Y,
            n: Vec3A::Z,
        },
        viewer_distance,
        sight: Sight::BLIND,
    }
}

fn direction(x: f32, y: f32, side: f32) -> Vec3A {
    Vec3A::new(x, y, side * (1.0 - x * x - y * y).sqrt())
}

fn at(v: Vec3A, distance: f64) -> Vector3<f64> {
    Vector3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z)).normalize() * distance
}

#[test]
fn openings_near_the_viewer_have_paths_of_their_own() {
    let slits = slits("rectangle", &THREE).unwrap();
    let opening = |x: f64| mueller16::Opening::clear(Vector2::new(x, 0.0), 12e-6, 30e-6);
    let reference =
        mueller16::Openings::new(vec![opening(-150e-6), opening(0.0), opening(150e-6)], 1e-6)
            .unwrap();
    let green = Wavelength::from_metres(550e-9).unwrap();
    let loose = Tolerance::relative(0.1).unwrap();
    // 0.3 mm across at 0.1 m: the curvature is a third of a wave
    for (x, y) in [(0.0, 0.0), (0.004, 0.001), (-0.02, 0.003)] {
        let (o, i) = (direction(x, y, 1.0), direction(0.003, -0.002, -1.0));
        let view = reference
            .seen_between(at(i, 0.2), at(o, 0.1), green, loose)
            .unwrap();
        let expected = view.transfer().element(0, 0);
        let found = slits.transfer(&vertex(o, 0.1), i, GREEN, &Coherence::from_point(0.2));
        // directions of single precision give phases of 150 µm an error of 1e-4
        assert!(
            (found / expected - 1.0).abs() < 2e-3,
            "{x} {y}: {found} {expected}"
        );
        let back = slits.transfer(&vertex(i, 0.2), o, GREEN, &Coherence::from_point(0.1));
        assert!((found / back - 1.0).abs() < 1e-9);
    }
}

#[test]
fn light_of_a_patch_is_the_average_over_its_directions() {
    let slits = slits("rectangle", &THREE).unwrap();
    let o = vertex(direction(0.001, 0.0, 1.0), 1e4);
    let i = direction(0.0, 0.0, -1.0);
    let rows = [Vec3A::new(4e-4, 1e-4, 0.0), Vec3A::new(0.0, 5e-4, 0.0)];
    let coherence = Coherence {
        angular_root: rows,
        distance: f32::INFINITY,
    };
    let found = slits.transfer(&o, i, GREEN, &coherence);
    let (mut sum, mut weights) = (0.0, 0.0);
    for a in -30..=30 {
        for b in -30..=30 {
            let (x, y) = (a as f32 * 0.2, b as f32 * 0.2);
            let turned = i + rows[0] * x + rows[1] * y;
            let weight = f64::from((-0.5 * (x * x + y * y)).exp());
            sum += weight * slits.transfer(&o, turned.normalize(), GREEN, &Coherence::PLANE_WAVE);
            weights += weight;
        }
    }
    // γ is taken as constant over each opening: the envelope sinc²(k b θ/2) of 30 µm loses 3e-3
    assert!(
        (found / (sum / weights) - 1.0).abs() < 6e-3,
        "{found} {}",
        sum / weights
    );
}

#[test]
fn what_passes_is_what_is_open_and_directions_follow_their_density() {
    let slits = slits("rectangle", &THREE).unwrap();
    let at = vertex(direction(0.1, 0.05, 1.0), 1e6);
    let n = 400_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for k in 0..n {
        let stream = SampleStream::new(3, 0, k);
        let ([a, b], [c, _]) = (stream.pair(0), stream.pair(2));
        let Some(departure) = slits.sample(&at, &[GREEN], [a, b, c]) else {
            continue;
        };
        let (response, density) = slits.respond::<Polarized<1>>(
            &at,
            departure.direction,
            Part::Continuous,
            &[GREEN],
            &Coherence::PLANE_WAVE,
        );
        let MuellerResponse::General { matrices, .. } = response else {
            panic!("one direction is behind the screen");
        };
        assert!((density / departure.density - 1.0).abs() < 1e-3);
        let value = f64::from(matrices[0].x_axis.x / density);
        assert!(matrices[0].x_axis.x == matrices[0].z_axis.z);
        sum += value;
        squares += value * value;
    }
    let mean = sum / n as f64;
    let error = ((squares / n as f64 - mean * mean) / n as f64).sqrt();
    let open = 3.0 * 12e-6 * 30e-6 / 1e-6;
    // evanescent: λ/(π² a) of each width, 0.5 % and 0.2 %
    let lost = 550e-9 / 9.87 * (1.0 / 12e-6 + 1.0 / 30e-6);
    assert!(
        (mean - open * (1.0 - lost)).abs() < 5.0 * error + open * 2e-3,
        "{mean} ± {error}, {open}"
    );
    assert!(error < 0.01 * mean, "{error}");
}

#[test]
fn bad_screens_are_refused_in_words() {
    for (shape, parameters, expected) in [
        (
            "disk",
            &THREE[..],
            "bsdf 'slits' on shape 'disk', expected it on a rectangle",
        ),
        (
            "rectangle",
            &THREE[..3],
            "bsdf 'slits' has no parameter 'spacing'",
        ),
        (
            "rectangle",
            &[("count", "100")],
            "100 openings, expected 1 to 64",
        ),
        (
            "rectangle",
            &[("openings", "0um 0um 3um")],
            "the opening '0um 0um 3um', expected four lengths",
        ),
        (
            "rectangle",
            &[("openings", ";")],
            "0 openings, expected 1 to 64",
        ),
        (
            "rectangle",
            &[("openings", "0um 0um 3um 3um; 1um 0um 3um 3um")],
            "overlap",
        ),
        (
            "rectangle",
            &[("openings", "600um 0um 3um 3um")],
            "expected it to be on it",
        ),
        (
            "rectangle",
            &[("width", "3um"), ("height", "0um"), ("spacing", "6um")],
            "expected a positive length",
        ),
    ] {
        let message = slits(shape, parameters).unwrap_err();
        assert!(
            message.starts_with("test.xml:") && message.contains(expected),
            "{message}"
        );
    }
}
