//! Electromagnetic Gaussian Schell-model sources: polarization over direction and over distance.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};
use render::film::SpectralMode;

fn shot(samples: u64) -> Shot {
    Shot {
        mode: SpectralMode::Single(632.8),
        ..Shot::new(samples)
    }
}

/// The state of the middle of a spot, seen under an angle in its plane of x and z.
fn state(angle: f64, parameters: &str) -> [f64; 4] {
    let content = format!(
        "<shape type='disk'><transform name='to_world'><scale value='0.05'/></transform>
         <emitter type='egsm'><string name='sigma' value='1cm'/>{parameters}</emitter></shape>"
    );
    let lookat = format!(
        "origin='{:.9}, 0, {:.9}' target='0, 0, 0' up='0, 1, 0'",
        angle.sin(),
        angle.cos()
    );
    let (s, _) = mean(&shot(4).of_text(&scene(2, &lookat, 1e-4, &content)), 0);
    s.map(|v| v / s[0])
}

#[test]
fn an_unpolarized_source_is_polarized_by_direction() {
    let widths = "<string name='delta_xx' value='1um'/><string name='delta_yy' value='2 um'/>";
    // two Gaussian cones of widths 1/kδ; digits of the closed form
    for (angle, expected) in [
        (0.0, -0.6),
        (0.02, -0.58074),
        (0.05, -0.46873),
        (0.08, -0.21740),
        (0.0969727, 0.0),
        (0.12, 0.35093),
        (0.2, 0.97693),
    ] {
        let s = state(angle, widths);
        // half a unit of the last digit, and what 1e-7 of the angle changes
        assert!(
            (s[1] - expected).abs() < 1e-5,
            "{angle}: {s:?}, expected {expected}"
        );
        assert!(s[2].abs() < 1e-5 && s[3].abs() < 1e-5, "{angle}: {s:?}");
    }
}

#[test]
fn correlated_components_make_all_of_a_stokes_vector() {
    let s = state(
        0.1,
        "<string name='delta_xx' value='1um'/><string name='delta_yy' value='2um'/>\
         <string name='delta_xy' value='1.8um'/><string name='B_xy' value='0.3, 0.2'/>",
    );
    let expected = [1.0, 0.043778, 0.337541, -0.225027];
    for k in 0..4 {
        assert!((s[k] - expected[k]).abs() < 1e-5, "{s:?}");
    }
    let degree = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
    assert!((degree - 0.408029).abs() < 1e-5, "{degree}");
}

/// Irradiance on the axis at a distance, of a spot of σ = 1 cm, through plates right before the screen.
fn on_axis(distance: f64, emitter: &str, plates: &str) -> ([f64; 4], [f64; 4]) {
    let content = format!(
        "<shape type='disk'><transform name='to_world'><scale value='0.05'/></transform>
         <emitter type='egsm'><string name='sigma' value='1cm'/>{emitter}</emitter></shape>
         <shape type='rectangle'><transform name='to_world'><scale value='0.1'/><rotate y='1' angle='180'/>\
         <translate z='{distance}'/></transform>
         <bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf></shape>
         <shape type='rectangle'><transform name='to_world'><scale value='0.05'/><translate z='{}'/></transform>{plates}</shape>",
        distance - 0.3
    );
    let lookat = format!(
        "origin='1, 0, {}' target='0, 0, {distance}' up='0, 1, 0'",
        distance - 0.2
    );
    let text = scene(4, &lookat, 1e-4, &content);
    let (s, error) = mean(&shot(16384).of_text(&text), 0);
    (s.map(|v| v * PI), error.map(|v| v * PI))
}

#[test]
fn a_source_spreads_and_polarizes_with_distance() {
    let delta = |name: &str, value: &str| format!("<string name='{name}' value='{value}'/>");
    let null = "<bsdf type='null'/>";
    // one component: the spectral density on the axis falls as 1/Δ²
    let one = delta("delta_xx", "0.2mm") + "<float name='A_y' value='0'/>";
    for (distance, expected) in [(10.0, 0.7976998701), (100.0, 0.03793564595)] {
        let found = on_axis(distance, &one, null);
        assert!(found.1[0] < 0.02 * expected, "too noisy to tell: {found:?}");
        // cosines at the rim of the spot: (σ/z)²
        assert_stokes(
            &format!("{distance} m"),
            found,
            [expected, 0., 0., 0.],
            2e-6,
        );
    }
    // both: a polarizer tells them apart, one has the width of the row above, the other Δ² of its own δ
    let both = delta("delta_xx", "0.1mm") + &delta("delta_yy", "0.2mm");
    let distance = 10.0;
    let spread = |delta: f64| {
        let (sigma, k) = (0.01f64, 2.0 * PI / 632.8e-9);
        let l2 = 1.0 / (0.25 / (sigma * sigma) + 1.0 / (delta * delta));
        1.0 / (1.0 + distance * distance / (k * k * sigma * sigma * l2))
    };
    for (theta, expected) in [(0.0, spread(0.1e-3)), (90.0, spread(0.2e-3))] {
        let plate = format!("<bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf>");
        let found = on_axis(distance, &both, &plate);
        assert_stokes(
            &format!("polarizer at {theta}°"),
            found,
            [expected, 0., 0., 0.],
            2e-6,
        );
    }
}
