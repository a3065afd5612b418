//! Thin films: colours, polarization and power by Airy's formula.

use std::f64::consts::TAU;

use brewster_tests::{Shot, assert_stokes, mean, scene};
use render::film::SpectralMode;

/// Single precision in the direction of the ray, times the phase of the film.
const ROUND_OFF: f64 = 1e-5;

const SOAP: &str =
    "<bsdf type='layered'><string name='thickness' value='320nm'/><float name='ior' value='1.33'/>
    <float name='ext_ior' value='1'/></bsdf>";

/// Reflectances of s- and p-polarized light at a free film.
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., section 7.6.1, Eq. (9): the two faces of a plate.
fn free_film(n: f64, thickness: f64, angle: f64, nm: f64) -> [f64; 2] {
    let inside = (angle.sin() / n).asin();
    let face = [
        ((angle.cos() - n * inside.cos()) / (angle.cos() + n * inside.cos())).powi(2),
        ((n * angle.cos() - inside.cos()) / (n * angle.cos() + inside.cos())).powi(2),
    ];
    let half = TAU * n * thickness * inside.cos() / (nm * 1e-9);
    face.map(|r| {
        let finesse = 4.0 * r / (1.0 - r).powi(2) * half.sin().powi(2);
        finesse / (1.0 + finesse)
    })
}

/// A plate in the plane z = 0, seen from above at an angle, and what else there is.
fn seen_at(angle: f64, bsdf: &str, rest: &str) -> String {
    let camera = format!(
        "origin='{}, 0, {}' target='0, 0, 0' up='0, 1, 0'",
        4.0 * angle.sin(),
        4.0 * angle.cos()
    );
    scene(
        4,
        &camera,
        0.01,
        &format!("<shape type='rectangle'>{bsdf}</shape>{rest}"),
    )
}

/// A lamp of radiance 1 in the plane z = 6, facing down.
const LAMP_ABOVE: &str =
    "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='180'/>
    <scale value='100'/><translate z='6'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";

/// The same in the plane z = −6, facing up.
const LAMP_BELOW: &str = "<shape type='rectangle'><transform name='to_world'>
    <scale value='100'/><translate z='-6'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";

#[test]
fn a_soap_film_has_the_colours_and_the_polarization_of_airys_formula() {
    for nm in [430.0, 550.0, 680.0] {
        for degrees in [15.0f64, 45.0, 70.0] {
            let angle = degrees.to_radians();
            let [s, p] = free_film(1.33, 320e-9, angle, nm);
            // s is up and down in the image
            let reflected = [0.5 * (s + p), -0.5 * (s - p), 0.0, 0.0];
            let passed = [1.0 - reflected[0], -reflected[1], 0.0, 0.0];
            for (lamp, expected) in [(LAMP_ABOVE, reflected), (LAMP_BELOW, passed)] {
                let image = Shot {
                    mode: SpectralMode::Single(nm),
                    ..Shot::new(4096)
                }
                .of_text(&seen_at(angle, SOAP, lamp));
                assert_stokes(
                    &format!("{nm} nm, {degrees} degrees"),
                    mean(&image, 0),
                    expected,
                    ROUND_OFF,
                );
            }
        }
    }
}

#[test]
fn a_soap_bubble_in_uniform_light_is_invisible() {
    let bubble = format!(
        "<shape type='sphere'>{SOAP}</shape><emitter type='constant'><float name='radiance' value='1'/></emitter>"
    );
    let text = scene(
        64,
        "origin='0, 0, 4' target='0, 0, 0' up='0, 1, 0'",
        30.0,
        &bubble,
    );
    let image = Shot::new(4096).of_text(&text);
    assert_stokes("bubble", mean(&image, 0), [1.0, 0.0, 0.0, 0.0], 1e-4);
}

#[test]
fn a_film_before_a_lamp_takes_what_it_reflects() {
    // a small lamp far above a diffuse floor, with and without a film between: found by looking for it through the film
    let text = |film: &str| {
        let content = format!(
            "<shape type='rectangle'><bsdf type='diffuse'/></shape>
             <shape type='rectangle'><transform name='to_world'><scale value='0.1'/><rotate x='1' angle='180'/>
             <translate z='20'/></transform><emitter type='area'><float name='radiance' value='1000'/></emitter></shape>{film}"
        );
        scene(
            3,
            "origin='0.5, 0, 0.5' target='0, 0, 0' up='0, 1, 0'",
            0.01,
            &content,
        )
    };
    let film = format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='30'/><translate z='10'/></transform>{SOAP}</shape>"
    );
    let shot = Shot::new(4096);
    let (bare, bare_error) = mean(&shot.of_text(&text("")), 0);
    let (dimmed, dimmed_error) = mean(&shot.of_text(&text(&film)), 0);
    let expected = 1.0 - free_film(1.33, 320e-9, 0.0, 550.0)[0];
    let error = (dimmed_error[0] / bare[0]).hypot(bare_error[0] / bare[0]);
    let found = dimmed[0] / bare[0];
    // the lamp is seen at up to 0.3 degrees
    assert!(
        (found - expected).abs() < 5.0 * error + 1e-5 && error < 1e-3,
        "{found} ± {error}, expected {expected}"
    );
}
