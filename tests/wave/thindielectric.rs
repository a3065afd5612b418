//! Panes of glass: straight through, polarized by all their internal reflections.

use brewster_tests::{Shot, assert_stokes, mean, scene};

/// Single precision in a few matrix products.
const ROUND_OFF: f64 = 3e-6;

/// Reflectances of s- and p-polarized light at one face.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.2, Eq. (21a).
fn face(n: f64, angle: f64) -> (f64, f64) {
    let below = (angle.sin() / n).asin();
    let s = (angle - below).sin() / (angle + below).sin();
    let p = (angle - below).tan() / (angle + below).tan();
    (s * s, p * p)
}

/// A pane across the view, turned about the vertical axis of the image by an angle in degrees.
fn pane(angle: f64) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='200'/><rotate y='1' angle='{angle}'/></transform>
            <bsdf type='thindielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf></shape>"
    )
}

const VIEW: &str = "origin='0, 0, 10' target='0, 0, 0' up='0, 1, 0'";

#[test]
fn a_lamp_behind_two_panes_is_polarized_by_both() {
    // s is vertical: S1 counts it negative
    let lamp = "<shape type='rectangle'><transform name='to_world'><scale value='7'/><translate z='-9'/></transform>
        <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";
    for angle in [0.0f64, 40.0, 56.31] {
        let second = pane(angle).replace("</transform>", "<translate z='-2'/></transform>");
        let image = Shot::new(4096).of_text(&scene(
            40,
            VIEW,
            0.01,
            &format!("{lamp}{}{second}", pane(angle)),
        ));
        // with what the panes throw to and fro between them: together they are a stack of two
        let stack = |r: f64| {
            let (r, t) = (2.0 * r / (1.0 + r), (1.0 - r) / (1.0 + r));
            t * t / (1.0 - r * r)
        };
        let (s, p) = if angle == 0.0 {
            (0.04, 0.04)
        } else {
            face(1.5, angle.to_radians())
        };
        let (s, p) = (stack(s), stack(p));
        let expected = [0.5 * (s + p), 0.5 * (p - s), 0.0, 0.0];
        assert_stokes("two panes", mean(&image, 0), expected, ROUND_OFF);
    }
}

#[test]
fn a_wall_is_lit_through_a_pane() {
    // light of one direction at 60° on the pane and on the white wall behind: E cos/π of what passes
    let light =
        "<emitter type='directional'><vector name='direction' x='0.8660254' y='1e-4' z='-0.5'/>
        <float name='irradiance' value='1'/></emitter>";
    let wall = "<shape type='rectangle'><transform name='to_world'><scale value='9'/><translate z='-0.5'/></transform>
        <bsdf type='diffuse'><float name='reflectance' value='1'/></bsdf></shape>";
    // seen past the pane, through its shadow
    let text = scene(
        3,
        "origin='12, 0, -0.1' target='0.8660254, 0, -0.5' up='0, 1, 0'",
        0.01,
        &format!("{light}{wall}{}", pane(0.0)),
    );
    let image = Shot::new(64).of_text(&text);
    let (s, p) = face(1.5, 60f64.to_radians());
    let through = 0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p));
    let expected = 0.5 * through / std::f64::consts::PI;
    assert_stokes(
        "wall",
        mean(&image, 0),
        [expected, 0.0, 0.0, 0.0],
        ROUND_OFF,
    );
}
