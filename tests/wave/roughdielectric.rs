//! Ground glass: one facet takes one direction of light into the view, and polarizes as Fresnel says.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};

const ALPHA: f64 = 0.3;
const N: f64 = 1.5;

/// A wall of ground glass in the plane z = 0, its air on the side of +z, seen from there at an angle in degrees, and lit along a
/// direction (x, z).
fn wall(view: f64, [x, z]: [f64; 2]) -> String {
    let (sin, cos) = view.to_radians().sin_cos();
    scene(
        2,
        &format!("origin='{}, 0, {}' target='0, 0, 0' up='0, 1, 0'", 5.0 * sin, 5.0 * cos),
        0.01,
        &format!(
            "<emitter type='directional'><vector name='direction' x='{x}' y='0' z='{z}'/><float name='irradiance' value='1'/></emitter>
            <shape type='rectangle'><bsdf type='roughdielectric'><float name='int_ior' value='{N}'/><float name='ext_ior' value='1'/>
                <float name='alpha' value='{ALPHA}'/><string name='distribution' value='ggx'/></bsdf></shape>"
        ),
    )
}

/// Walter's D and G1 of GGX for a cosine.
fn d(cos: f64) -> f64 {
    let (a2, c2) = (ALPHA * ALPHA, cos * cos);
    a2 / (PI * c2 * c2 * (a2 + (1.0 - c2) / c2).powi(2))
}

fn g1(cos: f64) -> f64 {
    2.0 / (1.0 + (1.0 + ALPHA * ALPHA * (1.0 - cos * cos) / (cos * cos)).sqrt())
}

/// Reflectances of s and p.
fn face(angle: f64) -> (f64, f64) {
    let below = (angle.sin() / N).asin();
    let s = (angle - below).sin() / (angle + below).sin();
    let p = (angle - below).tan() / (angle + below).tan();
    (s * s, p * p)
}

#[test]
fn a_facet_reflects_as_walter_and_fresnel_say() {
    // view at 50°, light at 62° on the other side: the facet is tilted by 6°, met at 56°
    let (view, light) = (50f64.to_radians(), 62f64.to_radians());
    let image = Shot::new(16).of_text(&wall(50.0, [light.sin(), -light.cos()]));
    let tilt = 0.5 * (light - view);
    let common = d(tilt.cos()) * g1(view.cos()) * g1(light.cos()) / (4.0 * view.cos());
    let (s, p) = face(0.5 * (view + light));
    // s is vertical in the image
    let expected = [common * 0.5 * (s + p), common * 0.5 * (p - s), 0.0, 0.0];
    assert!(expected[0] > 0.05);
    assert_stokes("reflection", mean(&image, 0), expected, 1e-5 * expected[0]);
}

#[test]
fn a_facet_refracts_as_walter_and_fresnel_say() {
    // the facet of tilt 8°, seen at 40° from its normal: the light within is at asin(sin 40°/n) from it
    let (tilt, outside) = (8f64.to_radians(), 40f64.to_radians());
    let inside = (outside.sin() / N).asin();
    let view = outside + tilt;
    // angle of the light's direction of travel from the normal of the wall
    let within = inside + tilt;
    let image = Shot::new(16).of_text(&wall(view.to_degrees(), [within.sin(), within.cos()]));
    let (s, p) = face(outside);
    let denominator = outside.cos() - N * inside.cos();
    // irradiance across the ray: |cos i| is in f cos i
    let common = d(tilt.cos()) * g1(view.cos()) * g1(within.cos()) * outside.cos() * inside.cos()
        / (view.cos() * denominator * denominator);
    let (s, p) = (1.0 - s, 1.0 - p);
    let expected = [common * 0.5 * (s + p), common * 0.5 * (p - s), 0.0, 0.0];
    assert!(expected[0] > 0.05 && expected[1] > 0.0);
    assert_stokes("refraction", mean(&image, 0), expected, 1e-5 * expected[0]);
}
