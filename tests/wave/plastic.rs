//! Plastic under one light: the base between two polarizing passages.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};

/// Transmittances of s- and p-polarized light into index n.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.2, Eq. (21a).
fn passage(n: f64, angle: f64) -> (f64, f64) {
    let below = (angle.sin() / n).asin();
    let s = (angle - below).sin() / (angle + below).sin();
    let p = (angle - below).tan() / (angle + below).tan();
    (1.0 - s * s, 1.0 - p * p)
}

/// A floor in the plane y = 0 seen from an angle in degrees, lit by a directional light from another, both in the plane x = 0.
fn floor(view: f64, light: f64, bsdf: &str) -> String {
    let (sin, cos) = view.to_radians().sin_cos();
    let (dz, dy) = light.to_radians().sin_cos();
    scene(
        2,
        &format!("origin='0, {}, {}' target='0, 0, 0' up='0, 1, 0'", 5.0 * cos, 5.0 * sin),
        0.01,
        &format!(
            "<emitter type='directional'><vector name='direction' x='0' y='{}' z='{}'/><float name='irradiance' value='1'/></emitter>
            <shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/></transform>{bsdf}</shape>",
            -dy, -dz
        ),
    )
}

#[test]
fn smooth_plastic_polarizes_what_its_base_returns() {
    let bsdf =
        "<bsdf type='plastic'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>
        <float name='diffuse_reflectance' value='0.6'/></bsdf>";
    for (view, light) in [(60.0f64, 20.0f64), (75.0, -50.0)] {
        let image = Shot::new(16).of_text(&floor(view, light, bsdf));
        let (s, p) = passage(1.5, view.to_radians());
        let (s_in, p_in) = passage(1.5, light.abs().to_radians());
        // Egan and Hilgeman's diffuse reflectance at 1/1.5 from inside
        let inner = 0.0636 * 1.5 + 0.6681 + 0.7099 / 1.5 - 1.4399 / 2.25;
        let weight =
            0.6 / (1.0 - inner) / (PI * 2.25) * light.to_radians().cos() * 0.5 * (s_in + p_in);
        // s is horizontal in the image
        let expected = [weight * 0.5 * (s + p), weight * 0.5 * (s - p), 0.0, 0.0];
        assert_stokes("plastic", mean(&image, 0), expected, 3e-6);
    }
}

#[test]
fn nearly_smooth_rough_plastic_away_from_its_highlight_is_smooth_plastic() {
    let smooth = "<bsdf type='plastic'><float name='int_ior' value='1.5'/><boolean name='nonlinear' value='true'/></bsdf>";
    let rough = smooth
        .replace("plastic", "roughplastic")
        .replace("<float", "<float name='alpha' value='0.01'/><float");
    let [a, b] =
        [smooth, &rough].map(|bsdf| mean(&Shot::new(16).of_text(&floor(55.0, 10.0, bsdf)), 0));
    // facets tilted by 0.01, and 1.5 % of F by the mean over 64 cosines, of which half is reflected again
    assert!(
        a.0[0] > 0.05 && (a.0[0] / b.0[0] - 1.0).abs() < 2e-2,
        "{a:?} {b:?}"
    );
    let degree = |(s, _): ([f64; 4], [f64; 4])| s[1] / s[0];
    assert!((degree(a) - degree(b)).abs() < 1e-3, "{a:?} {b:?}");
}
