//! Claim: the coherence of a pixel's light is what the van Cittert-Zernike theorem makes of the lamps that light it.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::sync::atomic::AtomicBool;

use brewster_tests::{SIGMAS, Shot, brewster, film_scene};
use render::engine::{Job, Limits, Rendering, render};
use render::film::SpectralMode;
use render::output;
use render::scene::read_text;

/// Width of the film: each pixel is an estimate of its own, and their scatter tells the noise.
pub(super) const SIZE: usize = 8;
/// A diffuse plane around the origin.
const PLANE: &str = "<shape type='rectangle'><bsdf type='diffuse'/></shape>";
/// Looks at the origin from the front and above: image right is +x, image up on the plane +y.
const FROM_FRONT: &str = "origin='0, -2, 2' target='0, 0, 0' up='0, 0, 1'";

/// A lamp above the origin, facing down.
pub(super) fn lamp(shape: &str, scale: [f64; 2], turn: f64, x: f64, radiance: f64) -> String {
    let [w, h] = scale;
    format!(
        "<shape type='{shape}'><transform name='to_world'>
            <scale x='{w}' y='{h}'/><rotate x='1' angle='180'/><rotate z='1' angle='{turn}'/><translate x='{x}' z='1'/>
        </transform><emitter type='area'><float name='radiance' value='{radiance}'/></emitter></shape>"
    )
}

fn rendered(shot: &Shot, scene: &str, separation: [f64; 2], threads: usize) -> Rendering {
    let document = read_text(scene, std::path::Path::new("test.xml"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let job = Job {
        coherence: Some(separation),
        ..shot.job(&document)
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap_or_else(|error| panic!("{error}"));
    pool.install(|| render(&job, Limits::default(), &AtomicBool::new(false), |_| ()))
}

/// A mean and its standard error.
pub(super) type Estimate = (f64, f64);

/// What the pixels say: the spreads of kθ (xx, xy, yy) over k² at 550 nm, and the degree of coherence.
fn measured(shot: &Shot, lookat: &str, content: &str, separation: [f64; 2]) -> [Estimate; 4] {
    let scene = film_scene(3, lookat, 0.01, [SIZE as u32; 2], content);
    measured_in(shot, &scene, separation)
}

/// The same of a scene with a film of `SIZE` × `SIZE` pixels.
pub(super) fn measured_in(shot: &Shot, scene: &str, separation: [f64; 2]) -> [Estimate; 4] {
    let rendering = rendered(shot, scene, separation, 2);
    let coherence = rendering.coherence().unwrap_or_default();
    assert_eq!(coherence.len(), SIZE * SIZE);
    let k = wavenumber(550e-9);
    let rows: Vec<[f64; 4]> = coherence
        .iter()
        .map(|c| {
            let [major, minor, angle, degree] = c.map(f64::from);
            let [small, large] = [major, minor].map(|l| (k * l).powi(-2));
            let (sin, cos) = angle.sin_cos();
            [
                small * cos * cos + large * sin * sin,
                (small - large) * sin * cos,
                small * sin * sin + large * cos * cos,
                degree,
            ]
        })
        .collect();
    let n = rows.len() as f64;
    std::array::from_fn(|i| {
        let mean = rows.iter().map(|r| r[i]).sum::<f64>() / n;
        let variance = rows.iter().map(|r| (r[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    })
}

pub(super) fn wavenumber(wavelength: f64) -> f64 {
    TAU / wavelength
}

/// Checks within the noise and what is left out: `relative` of the expected number.
pub(super) fn assert_near(what: &str, (found, error): Estimate, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= SIGMAS * error + relative * expected.abs(),
        "{what}: found {found:.6e} ± {error:.1e}, expected {expected:.6e}"
    );
}

/// J1 by its integral, (1/π) ∫ cos(t − x sin t) dt over 0 to π; the midpoint rule is exact to rounding.
fn bessel_j1(x: f64) -> f64 {
    const STEPS: usize = 64;
    let term = |i: usize| {
        let t = PI * (i as f64 + 0.5) / STEPS as f64;
        (t - x * t.sin()).cos()
    };
    (0..STEPS).map(term).sum::<f64>() / STEPS as f64
}

pub(super) fn besinc(u: f64) -> f64 {
    2.0 * bessel_j1(u) / u
}

pub(super) fn sinc(x: f64) -> f64 {
    x.sin() / x
}

/// Samples a pixel; a pixel's own mean direction takes 1/N of the spread away.
pub(super) const SAMPLES: u64 = 1024;
pub(super) const OWN_MEAN: f64 = 1.0 - 1.0 / SAMPLES as f64;
/// What is left out: tangents for angles of 0.01 (3e-5), and the noise that adds to a modulus (1/2N).
pub(super) const LEFT_OUT: f64 = 1e-3;

#[test]
fn a_round_lamp_has_an_airy_pattern_of_coherence() {
    let a = 0.02;
    let k = wavenumber(550e-9);
    // u = 2: the degree has fallen to J1(2)
    let separation = 2.0 * 2.0 / (k * a);
    let content = PLANE.to_owned() + &lamp("disk", [0.5 * a; 2], 0.0, 0.0, 1.0);
    let shot = Shot::new(SAMPLES);
    let [xx, xy, yy, degree] = measured(
        &shot,
        FROM_FRONT,
        &content,
        [0.6 * separation, -0.8 * separation],
    );
    let spread = OWN_MEAN * a * a / 16.0;
    assert_near("xx", xx, spread, LEFT_OUT);
    assert_near("yy", yy, spread, LEFT_OUT);
    assert_near("xy", xy, 0.0, 0.0);
    assert!((besinc(2.0) - 0.576_724_807_756_873_4).abs() < 1e-12);
    assert_near("degree", degree, besinc(2.0), LEFT_OUT);
}

#[test]
fn a_long_lamp_makes_a_long_ellipse_across_it() {
    // sides of 0.02 and 0.008 seen from the origin, the long one at 30° from image right
    let (a, b, turn) = (0.02, 0.008, PI / 6.0);
    let k = wavenumber(550e-9);
    let content = PLANE.to_owned() + &lamp("rectangle", [0.5 * a, 0.5 * b], 30.0, 0.0, 1.0);
    let (sin, cos) = turn.sin_cos();
    let separation = 1.5 * 2.0 / (k * a);
    let shot = Shot::new(SAMPLES);
    let expected = |sin: f64| {
        let (large, small) = (OWN_MEAN * a * a / 12.0, OWN_MEAN * b * b / 12.0);
        [
            large * cos * cos + small * sin * sin,
            (large - small) * sin * cos,
            large * sin * sin + small * cos * cos,
        ]
    };
    let along = [separation * cos, separation * sin];
    let [xx, xy, yy, degree] = measured(&shot, FROM_FRONT, &content, along);
    for (what, found, expected) in [
        ("xx", xx, expected(sin)[0]),
        ("xy", xy, expected(sin)[1]),
        ("yy", yy, expected(sin)[2]),
        ("degree", degree, sinc(1.5)),
    ] {
        assert_near(what, found, expected, LEFT_OUT);
    }

    // in a mirror the plane looks mirrored, and so do the ellipse and the separation
    let content = content
        + "<shape type='rectangle'><transform name='to_world'>
            <scale value='0.3'/><lookat origin='0, -1, 1' target='0, 0, 1' up='0, 0, 1'/>
        </transform><bsdf type='conductor'/></shape>";
    let lookat = "origin='0, 0, 2' target='0, -1, 1' up='0, 0, 1'";
    let along = [-along[0], along[1]];
    let [xx, xy, yy, degree] = measured(&shot, lookat, &content, along);
    for (what, found, expected) in [
        ("mirrored xx", xx, expected(-sin)[0]),
        ("mirrored xy", xy, expected(-sin)[1]),
        ("mirrored yy", yy, expected(-sin)[2]),
        ("mirrored degree", degree, sinc(1.5)),
    ] {
        assert_near(what, found, expected, LEFT_OUT);
    }
}

#[test]
fn two_lamps_spread_by_their_distance_and_beat() {
    // p of the light from the left
    let (a, apart, p) = (0.008, 0.02, 0.25);
    let k = wavenumber(550e-9);
    let content = PLANE.to_owned()
        + &lamp("disk", [0.5 * a; 2], 0.0, -0.5 * apart, 1.0)
        + &lamp("disk", [0.5 * a; 2], 0.0, 0.5 * apart, 3.0);
    let separation = 2.0 / (k * apart);
    let shot = Shot::new(SAMPLES);
    let [xx, _, yy, degree] = measured(&shot, FROM_FRONT, &content, [separation, 0.0]);
    let own = a * a / 16.0;
    // the weights of the two lamps in a pixel are random too: 1/N of a few
    assert_near(
        "xx",
        xx,
        own + p * (1.0 - p) * apart * apart,
        5.0 * LEFT_OUT,
    );
    assert_near("yy", yy, own, 5.0 * LEFT_OUT);
    let beat = (p * p + (1.0 - p) * (1.0 - p) + 2.0 * p * (1.0 - p) * 2f64.cos()).sqrt();
    let expected = besinc(0.5 * k * a * separation) * beat;
    assert_near("degree", degree, expected, 2.0 * LEFT_OUT);
}

#[test]
fn a_band_is_as_coherent_as_its_mean_square_wavenumber() {
    let a = 0.02;
    let content = PLANE.to_owned() + &lamp("disk", [0.5 * a; 2], 0.0, 0.0, 1.0);
    let shot = Shot {
        mode: SpectralMode::Bands {
            from: 450.0,
            to: 650.0,
            count: 6,
        },
        ..Shot::new(256)
    };
    let [xx, _, _, _] = measured(&shot, FROM_FRONT, &content, [1e-6, 0.0]);
    // the mean of 1/λ² from λ1 to λ2 is 1/(λ1 λ2); in units of k² at 550 nm
    let expected = a * a / 16.0 * 550.0 * 550.0 / (450.0 * 650.0);
    assert_near("xx", xx, expected * (1.0 - 1.0 / 256.0), 2.0 * LEFT_OUT);
}

#[test]
fn light_of_one_direction_is_coherent() {
    let content = PLANE.to_owned()
        + "<emitter type='point'><point name='position' x='0.4' y='0.1' z='1'/><float name='intensity' value='1'/></emitter>";
    let scene = film_scene(3, FROM_FRONT, 1.0, [4, 4], &content);
    let rendering = rendered(&Shot::new(64), &scene, [1e-2, 0.0], 1);
    for [major, minor, angle, degree] in rendering.coherence().unwrap_or_default() {
        assert_eq!((major, minor, angle), (f32::INFINITY, f32::INFINITY, 0.0));
        assert!((degree - 1.0).abs() < 1e-6, "{degree}");
    }
}

#[test]
fn a_lamp_seen_directly_has_the_coherence_of_its_pixel() {
    let content =
        "<emitter type='constant'><float name='radiance' value='1'/></emitter>".to_owned();
    let scene = film_scene(3, FROM_FRONT, 1.0, [4, 4], &content);
    let pixel = 2.0 * 0.5f64.to_radians().tan() / 4.0;
    let k = wavenumber(550e-9);
    // directions uniform over a square pixel: a spread of a²/12 a side
    let rendering = rendered(&Shot::new(4), &scene, [1.0 / (k * pixel), 0.0], 1);
    for c in rendering.coherence().unwrap_or_default() {
        let [major, minor, _, degree] = c.map(f64::from);
        let expected = 12f64.sqrt() / (k * pixel);
        assert!((major / expected - 1.0).abs() < 1e-3, "{major} {expected}");
        assert!((minor / expected - 1.0).abs() < 1e-3, "{minor} {expected}");
        // the Gaussian of that spread
        assert!((degree - (-1.0f64 / 24.0).exp()).abs() < 1e-4, "{degree}");
    }
}

#[test]
fn coherence_changes_no_bit_of_the_image_and_threads_change_none_of_it() {
    let content = PLANE.to_owned() + &lamp("disk", [0.3; 2], 0.0, 0.2, 1.0);
    let scene = film_scene(3, FROM_FRONT, 60.0, [37, 21], &content);
    let shot = Shot {
        mode: SpectralMode::Rgb,
        ..Shot::new(8)
    };
    let bits = |rendering: &Rendering| -> Vec<u32> {
        let coherence = rendering.coherence().unwrap_or_default();
        coherence
            .as_flattened()
            .iter()
            .map(|v| v.to_bits())
            .collect()
    };
    let [one, three] = [1, 3].map(|threads| rendered(&shot, &scene, [1e-6, 0.0], threads));
    assert!(!bits(&one).is_empty() && bits(&one) == bits(&three));
    assert_eq!(one.image().0, shot.of_text(&scene).stokes);
}

#[test]
fn the_program_writes_reads_and_draws_it() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let scene = film_scene(
        3,
        FROM_FRONT,
        60.0,
        [32, 24],
        &(PLANE.to_owned() + &lamp("disk", [0.1; 2], 0.0, 0.2, 1.0)),
    );
    fs::write(folder.path().join("a.xml"), scene)?;
    let run = |arguments: &str| {
        brewster()
            .current_dir(folder.path())
            .args(arguments.split_whitespace())
            .output()
    };
    let done = run("render a.xml --spp 16 --coherence 10um,-5um --maps coherence-ellipses")?;
    assert!(done.status.success(), "{done:?}");
    for file in ["a_coherence-ellipses.png", "a_coherence-ellipses.svg"] {
        assert!(
            fs::metadata(folder.path().join(file))?.len() > 1000,
            "{file}"
        );
    }
    let image = output::read(&folder.path().join("a.exr"))?;
    assert_eq!(image.coherence.as_ref().map(Vec::len), Some(32 * 24));
    assert_eq!(
        image.metadata["coherenceSeparation"],
        "1e-5 m toward image right, -5e-6 m toward image up"
    );
    assert!(run("maps a.exr --data")?.status.success());
    for file in ["a_coherence.npy", "a_coherence-degree.png"] {
        assert!(
            fs::metadata(folder.path().join(file))?.len() > 1000,
            "{file}"
        );
    }
    let done = run("render a.xml --spp 1 --coherence 10um -o b.npy")?;
    assert!(done.status.success(), "{done:?}");
    assert_eq!(
        fs::metadata(folder.path().join("b_coherence.npy"))?.len(),
        128 + 32 * 24 * 16
    );

    for (arguments, message) in [
        ("render a.xml --coherence 10", "such as 10um"),
        ("render a.xml --maps coherence", "ask for it by --coherence"),
        (
            "render a.xml --coherence 1um --mitsuba-channels",
            "cannot be used with",
        ),
        ("maps b.npy --maps coherence", "the image has no coherence"),
    ] {
        let output = run(arguments)?;
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {text}");
        assert!(text.contains(message), "{arguments}: {text}");
    }
    Ok(())
}
