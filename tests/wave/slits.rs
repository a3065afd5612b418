//! Slits: fringes as visible as van Cittert and Zernike's theorem says.

use std::f64::consts::{PI, TAU};

use brewster_tests::{Shot, mean, pixel, scene};

const LAMBDA: f64 = 550e-9;
const WIDTH: f64 = 4e-6;
const SPACING: f64 = 60e-6;
/// Half the width of the rectangle with the slits.
const HALF: f64 = 0.1e-3;
const DISTANCE: f64 = 2.0;

/// Radiance of the screen seen under a sine along U, and its standard error; the source is `shape` a metre behind.
fn radiance(shape: &str, sine: f64, spp: u64) -> (f64, f64) {
    let (x, z) = (DISTANCE * sine, DISTANCE * (1.0 - sine * sine).sqrt());
    // the pixel is well within the rectangle
    let fov = (0.5 * HALF / DISTANCE).to_degrees();
    let text = scene(
        2,
        &format!("origin='{x}, 0, {z}' target='0, 0, 0' up='0, 1, 0'"),
        fov,
        &format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='{HALF}'/></transform>
             <bsdf type='slits'><string name='width' value='4um'/><string name='height' value='4um'/>
             <string name='spacing' value='60um'/></bsdf></shape>
             {shape}<emitter type='area'><float name='radiance' value='1'/></emitter></shape>"
        ),
    );
    let (s, error) = mean(&Shot::new(spp).of_text(&text), 0);
    (s[0], error[0])
}

fn rectangle(x: f64, y: f64) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale x='{}' y='{}'/><translate z='-1'/></transform>",
        0.5 * x,
        0.5 * y
    )
}

fn disk(angle: f64) -> String {
    format!(
        "<shape type='disk'><transform name='to_world'><scale value='{}'/><translate z='-1'/></transform>",
        0.5 * angle
    )
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-9 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

/// Radiance of the rectangle for a source of solid angle Ω: `Ω/(λ²A) 2 (ab)² sinc² (1 + V cos kdx)`.
fn expected(solid_angle: f64, visibility: f64, sine: f64) -> f64 {
    let area = 4.0 * HALF * HALF;
    let envelope = sinc(sine * WIDTH / LAMBDA);
    let one = (WIDTH * WIDTH * envelope).powi(2) / (LAMBDA * LAMBDA * area);
    solid_angle * 2.0 * one * (1.0 + visibility * (TAU / LAMBDA * SPACING * sine).cos())
}

/// Bright, dark and between.
fn sines() -> [f64; 3] {
    [0.0, 0.5, 1.25].map(|fringes| fringes * LAMBDA / SPACING)
}

fn check(what: &str, shape: &str, solid_angle: f64, visibility: f64, spp: u64) {
    let mut seen = [0.0; 2];
    for (k, sine) in sines().into_iter().enumerate() {
        let (found, error) = radiance(shape, sine, spp);
        let expected = expected(solid_angle, visibility, sine);
        // Gaussian patches: 4e-4; γ constant over a slit, and the envelope over the source: (a α/λ)²/… below 1 %
        let bright =
            2.0 * solid_angle * (WIDTH * WIDTH).powi(2) / (LAMBDA * LAMBDA * 4.0 * HALF * HALF);
        assert!(
            (found - expected).abs() < 5.0 * error + 0.01 * bright,
            "{what} at {sine}: {found:e} ± {error:e}, {expected:e}"
        );
        if k < 2 {
            seen[k] = found / sinc(sine * WIDTH / LAMBDA).powi(2);
        }
    }
    let found = (seen[0] - seen[1]) / (seen[0] + seen[1]);
    assert!(
        (found - visibility).abs() < 0.02,
        "{what}: {found} {visibility}"
    );
}

#[test]
fn a_slit_source_gives_fringes_of_visibility_sinc() {
    for ratio in [0.02, 0.3, 0.6, 1.0, 1.4] {
        let alpha = ratio * LAMBDA / SPACING;
        // low enough to be one row of patches
        let low = 1e-4;
        check(
            &format!("αd/λ = {ratio}"),
            &rectangle(alpha, low),
            alpha * low,
            sinc(ratio),
            2000,
        );
    }
}

#[test]
fn a_disk_gives_fringes_of_visibility_j1() {
    for ratio in [0.3, 0.8, 1.22, 1.6] {
        let alpha = ratio * LAMBDA / SPACING;
        let u = PI * ratio;
        // J1 by its integral, (1/π)∫ cos(τ − u sin τ) dτ
        let n = 200;
        let j1 = (0..n)
            .map(|k| {
                let tau = PI * (f64::from(k) + 0.5) / f64::from(n);
                (tau - u * tau.sin()).cos() / f64::from(n)
            })
            .sum::<f64>();
        check(
            &format!("disk αd/λ = {ratio}"),
            &disk(alpha),
            PI * (0.5 * alpha).powi(2),
            2.0 * j1 / u,
            20_000,
        );
    }
}

#[test]
fn the_scene_of_double_slits_shows_the_fringes_of_its_table() {
    fringes_of_the_scene(None);
}

#[test]
fn points_of_the_source_show_the_same_fringes_as_its_patches() {
    // the slits are small, their screens are not: light from a point is no plane wave to a screen
    fringes_of_the_scene(Some(0.0));
}

fn fringes_of_the_scene(patch: Option<f32>) {
    let (width, spacing) = (5e-6, 25e-6);
    let shot = Shot {
        size: Some([33, 22]),
        patch,
        ..Shot::new(3000)
    };
    let image = shot.of_scene("double_slit");
    // pixel rows within the rows of screens
    for (row, ratio) in [(2, 0.05), (6, 0.4), (10, 0.7), (15, 1.0), (19, 1.4)] {
        let alpha = ratio * LAMBDA / spacing;
        // the screen of a column is at x, lit and seen from 1 m: one slit's envelope and two slits' fringes over the source
        let expected: Vec<f64> = (-16..=16)
            .map(|j| {
                let x = f64::from(j) * 1.25e-3;
                let n = 200;
                (0..n)
                    .map(|k| {
                        let source = alpha * ((f64::from(k) + 0.5) / f64::from(n) - 0.5);
                        let sine = source - 2.0 * x;
                        let fringe = 1.0 + (TAU / LAMBDA * spacing * sine).cos();
                        fringe * sinc(sine * width / LAMBDA).powi(2)
                    })
                    .sum()
            })
            .collect();
        let found: Vec<_> = (0..33)
            .map(|x| {
                let (s, error) = pixel(&image, x, row, 0);
                (s[0], error[0])
            })
            .collect();
        let [all_found, all_expected] = [
            found.iter().map(|f| f.0).sum::<f64>(),
            expected.iter().sum::<f64>(),
        ];
        assert!(all_found > 0.0);
        let brightest = expected.iter().copied().fold(0.0, f64::max) / all_expected;
        for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
            let [value, error] = [found.0 / all_found, found.1 / all_found];
            // pixels at the ends reach 0.05 mm beyond their screen; other rows' light is below 1e-3
            assert!(
                (value - expected / all_expected).abs() < 5.0 * error + 0.02 * brightest,
                "row {row}, column {j}: {value} ± {error}, {}",
                expected / all_expected
            );
        }
    }
}
