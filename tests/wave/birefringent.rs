//! Crystal plates between polarizers.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};
use render::film::SpectralMode;

fn plate(bsdf: &str, placement: &str, z: f64) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'>{placement}<translate z='{z}'/></transform>{bsdf}</shape>"
    )
}

fn polarizer(theta: f64) -> String {
    format!("<bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf>")
}

const LAMP: &str = "<shape type='rectangle'><transform name='to_world'><scale value='100'/><translate z='-3'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";

#[test]
fn a_plate_between_crossed_polarizers_passes_sin_2_2a_sin_2_half_delta() {
    // immersed in its mean index: the faces reflect 1e-5
    const THICKNESS: f64 = 50e-6;
    for (nm, degrees) in [(450.0, 45.0f64), (550.0, 20.0), (633.0, -70.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let crystal = format!(
            "<bsdf type='birefringent'><float name='no' value='1.545'/><float name='ne' value='1.555'/>
             <float name='ext_ior' value='1.55'/><string name='thickness' value='50um'/>
             <vector name='axis' x='{cos}' y='{sin}' z='0'/></bsdf>"
        );
        let delta = 2.0 * PI * THICKNESS * 0.01 / (nm * 1e-9);
        let expected =
            0.5 * (2.0 * degrees.to_radians()).sin().powi(2) * (0.5 * delta).sin().powi(2);
        for turn in ["", "<rotate x='1' angle='180'/>"] {
            let content = [
                plate(&polarizer(0.0), "", -1.0),
                // turned about U the axis is mirrored: the same power
                plate(&crystal, turn, 0.0),
                plate(&polarizer(90.0), "", 1.0),
                LAMP.to_owned(),
            ]
            .concat();
            let text = scene(
                6,
                "origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'",
                0.01,
                &content,
            );
            let image = Shot {
                mode: SpectralMode::Single(nm),
                ..Shot::new(4096)
            }
            .of_text(&text);
            // what passes is vertical
            assert_stokes(
                &format!("{nm} nm, axis at {degrees} degrees"),
                mean(&image, 0),
                [expected, -expected, 0.0, 0.0],
                3e-5,
            );
        }
    }
}

#[test]
fn a_quarter_wave_of_crystal_makes_circular_light_of_the_hand_of_its_slow_axis() {
    // the slow axis (of the larger index) at +45° to the light: left circular, the other side turned about U: right
    let crystal = "<bsdf type='birefringent'><float name='no' value='1.545'/><float name='ne' value='1.555'/>
        <float name='ext_ior' value='1.55'/><string name='thickness' value='13.75um'/><vector name='axis' value='1 1 0'/></bsdf>";
    for (turn, hand) in [("", -0.5), ("<rotate x='1' angle='180'/>", 0.5)] {
        let content = [
            plate(&polarizer(0.0), "", -1.0),
            plate(crystal, turn, 0.0),
            LAMP.to_owned(),
        ]
        .concat();
        let text = scene(
            6,
            "origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'",
            0.01,
            &content,
        );
        let image = Shot::new(4096).of_text(&text);
        assert_stokes(turn, mean(&image, 0), [0.5, 0.0, 0.0, hand], 3e-5);
    }
}
