//! Matter of populations in scenes: `f = (1/λ²) F{R γ}(φ_t)`, sharp parts, envelopes.

use std::f64::consts::TAU;

use brewster_tests::{Shot, assert_stokes, brewster, mean, scene};
use render::scene::{Overrides, build, read_text};

const LAMBDA: f64 = 550e-9;

/// A scene of a wall in the plane z = 0 with matter from a file, and the file.
fn wall(populations: &str, view: f64, content: &str) -> (tempfile::NamedTempFile, String) {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), format!("{{\"populations\": [{populations}]}}")).expect("a file");
    let (sin, cos) = view.to_radians().sin_cos();
    let text = scene(
        2,
        &format!(
            "origin='{}, 0, {}' target='0, 0, 0' up='0, 1, 0'",
            5.0 * sin,
            5.0 * cos
        ),
        0.01,
        &format!(
            "{content}<shape type='rectangle'><bsdf type='scatterer16'><string name='filename' value='{}'/></bsdf></shape>",
            file.path().display()
        ),
    );
    (file, text)
}

fn directional(angle: f64) -> String {
    let (sin, cos) = angle.to_radians().sin_cos();
    format!(
        "<emitter type='directional'><vector name='direction' x='{sin}' y='0' z='{}'/><float name='irradiance' value='1'/></emitter>",
        -cos
    )
}

#[test]
fn one_gaussian_scatters_its_fourier_transform() {
    // all that is scattered is polarized along U, which lies across the image
    let (_file, text) = wall(
        r#"{"T": [[0.9, 0], [0, 0]], "R": {"kind": "gaussian", "S": [[1e-12, 0], [0, 4e-12]]}}"#,
        30.0,
        &directional(34.0),
    );
    let image = Shot::new(16).of_text(&text);
    let k = TAU / LAMBDA;
    // the view looks from +x, the light comes from −x
    let phi = k * (30f64.to_radians().sin() - 34f64.to_radians().sin());
    let lobe = TAU * 2e-12 * (-0.5 * 1e-12 * phi * phi).exp();
    let s0 = 0.5 * 0.81 * lobe / (LAMBDA * LAMBDA) * 34f64.to_radians().cos();
    assert!(s0 > 1.0);
    // positions of single precision, 1e-7 of k (o + i) l = 0.7
    assert_stokes("lobe", mean(&image, 0), [s0, s0, 0.0, 0.0], 1e-4 * s0);
}

#[test]
fn a_lamp_is_averaged_over_its_directions() {
    // a square lamp of half-width 0.05 at 2 m above the wall, lobes of 1.3° by 0.65°: sum over the lamp by the midpoint rule
    let lamp = "<shape type='rectangle'><transform name='to_world'><scale value='0.05'/><rotate y='1' angle='180'/>
        <translate x='-0.12' z='2'/></transform><emitter type='area'><float name='radiance' value='3'/></emitter></shape>";
    let (_file, text) = wall(
        r#"{"M": [[0.8,0,0,0],[0,0.4,0,0],[0,0,-0.4,0],[0,0,0,-0.2]], "R": {"kind": "gaussian", "S": [[1.5e-11, 0], [0, 6e-11]]}}"#,
        5.0,
        lamp,
    );
    let image = Shot::new(2048).of_text(&text);
    let k = TAU / LAMBDA;
    let n = 1000;
    let mut sum = 0.0;
    for place in 0..n * n {
        let at = |c: usize| ((c as f64 + 0.5) / n as f64 * 2.0 - 1.0) * 0.05;
        let (x, y) = (-0.12 + at(place / n), at(place % n));
        let r = (x * x + y * y + 4.0f64).sqrt();
        let cos = 2.0 / r;
        let (a, b) = (k * (5f64.to_radians().sin() + x / r), k * y / r);
        let lobe = TAU * f64::sqrt(9e-22) * (-0.5 * (1.5e-11 * a * a + 6e-11 * b * b)).exp();
        sum += lobe / (LAMBDA * LAMBDA) * cos * cos / (r * r) * (0.1 / n as f64).powi(2);
    }
    let expected = 0.8 * 3.0 * sum;
    // patches of half a lobe's width: what is frozen at their centres errs by the square of 0.01 rad
    assert_stokes(
        "lamp",
        mean(&image, 0),
        [expected, 0.0, 0.0, 0.0],
        1e-3 * expected,
    );
}

#[test]
fn a_mirror_part_and_a_straight_part_are_sharp() {
    // half of the matter is a mirror, a third of it passes with its first field alone
    let populations = r#"{"M": [[0.5,0,0,0],[0,0.5,0,0],[0,0,-0.5,0],[0,0,0,-0.5]], "R": {"kind": "constant"}},
        {"T": [[0.5773502691896258, 0], [0, 0]], "R": {"kind": "constant"}, "side": "transmission"}"#;
    let lamps = "<emitter type='constant'><float name='radiance' value='1'/></emitter>
        <shape type='rectangle'><transform name='to_world'><scale value='50'/><translate z='-3'/></transform>
        <emitter type='area'><float name='radiance' value='2'/></emitter></shape>";
    let (_file, text) = wall(populations, 40.0, lamps);
    let image = Shot::new(65536).of_text(&text);
    // the mirror sees the surroundings, the straight way the lamp: 2 · (1/6)(1, 1)
    let passed = 2.0 / 6.0;
    assert_stokes(
        "sharp",
        mean(&image, 0),
        [0.5 + passed, passed, 0.0, 0.0],
        1e-5,
    );
}

#[test]
fn wide_and_narrow_lobes_keep_the_power() {
    // uniform surroundings: R(0) M00
    let (_file, text) = wall(
        r#"{"M": [[0.4,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0]], "R": {"kind": "gaussian_sum", "weights": [0.5, 0.5],
            "S_list": [[[1e-11, 0], [0, 1e-11]], [[1e-12, 0], [0, 1e-12]]]}},
           {"M": [[0.4,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0]], "R": {"kind": "constant"}}"#,
        20.0,
        "<emitter type='constant'><float name='radiance' value='1'/></emitter>",
    );
    let image = Shot::new(16384).of_text(&text);
    // standard deviations 0.028 and 0.088 about a sine of 0.34: all propagates, to 1e-9
    assert_stokes("power", mean(&image, 0), [0.8, 0.0, 0.0, 0.0], 1e-5);
}

#[test]
fn impossible_matter_is_refused_with_its_place_and_eigenvalue() {
    let (file, text) = wall(
        r#"{"M": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,-1]], "R": {"kind": "constant"}}"#,
        20.0,
        "",
    );
    let document = read_text(&text, "test.xml".as_ref(), &[]).expect("a document");
    let error = build(&document, Overrides::default()).expect_err("no matter");
    let message = error.to_string();
    let expected = format!(
        "{}: key 'populations[0].M': Mueller matrix: eigenvalue 3 of its coherency matrix is -0.5",
        file.path().display()
    );
    assert!(
        message.starts_with("test.xml:") && message.contains(&expected),
        "{message}"
    );
    // and by the program, with exit status 2
    let scene = tempfile::NamedTempFile::with_suffix(".xml").expect("a temporary file");
    std::fs::write(scene.path(), text).expect("a file");
    let out = brewster()
        .arg("inspect")
        .arg(scene.path())
        .output()
        .expect("the program runs");
    assert_eq!(out.status.code(), Some(2));
}
