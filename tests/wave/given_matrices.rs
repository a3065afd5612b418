//! Rotators, and elements given by their Mueller matrices.

use brewster_tests::{Shot, assert_stokes, brewster, mean, scene};
use render::film::SpectralMode;

const ROUND_OFF: f64 = 1e-6;

/// What a camera on the z axis sees of plates before a lamp, from the far one to the near one.
fn seen(plates: &[(&str, &str)], nm: f64) -> ([f64; 4], [f64; 4]) {
    let plates = plates.iter().enumerate().map(|(i, (bsdf, placement))| {
        format!(
            "<shape type='rectangle'><transform name='to_world'>{placement}<translate z='{i}'/></transform>{bsdf}</shape>"
        )
    });
    let content: String = plates.collect();
    let lamp = "<shape type='rectangle'><transform name='to_world'><scale value='100'/><translate z='-3'/></transform>
        <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";
    let text = scene(
        12,
        "origin='0, 0, 50' target='0, 0, 0' up='0, 1, 0'",
        0.01,
        &(content + lamp),
    );
    let image = Shot {
        mode: SpectralMode::Single(nm),
        ..Shot::new(4)
    }
    .of_text(&text);
    mean(&image, 0)
}

const POLARIZER: &str = "<bsdf type='polarizer'/>";
const TURNED_ROUND: &str = "<rotate x='1' angle='180'/>";

#[test]
fn a_rotator_turns_light_the_same_way_from_both_sides() {
    let rotator = "<bsdf type='rotator'><float name='angle' value='30'/></bsdf>";
    let (sin, cos) = 60f64.to_radians().sin_cos();
    for placement in ["", TURNED_ROUND] {
        let found = seen(&[(POLARIZER, ""), (rotator, placement)], 550.0);
        assert_stokes(
            placement,
            found,
            [0.5, 0.5 * cos, 0.5 * sin, 0.0],
            ROUND_OFF,
        );
    }
}

#[test]
fn activity_falls_with_the_square_of_the_wavelength() {
    let rotator = "<bsdf type='rotator'><float name='rotatory_power' value='21700'/><string name='thickness' value='2mm'/>
        <string name='reference' value='589.3nm'/></bsdf>";
    for nm in [450.0f64, 589.3, 700.0] {
        let angle = 2.0 * (43.4f64 * (589.3 / nm).powi(2)).to_radians();
        let found = seen(&[(POLARIZER, ""), (rotator, "")], nm);
        // the wavelength in single precision
        assert_stokes(
            &format!("{nm} nm"),
            found,
            [0.5, 0.5 * angle.cos(), 0.5 * angle.sin(), 0.0],
            2e-6,
        );
    }
}

#[test]
fn a_polarizer_given_as_a_matrix_obeys_malus() {
    for theta in [0.0f64, 30.0, 45.0, 90.0, 110.0] {
        let matrix = format!(
            "<bsdf type='mueller'><float name='theta' value='{theta}'/>
             <string name='matrix' value='.5 .5 0 0 .5 .5 0 0 0 0 0 0 0 0 0 0'/></bsdf>"
        );
        let (sin, cos) = (2.0 * theta.to_radians()).sin_cos();
        let power = 0.5 * theta.to_radians().cos().powi(2);
        // turned round about U, the axis is at −θ
        for (placement, sign) in [("", 1.0), (TURNED_ROUND, -1.0)] {
            assert_stokes(
                &format!("{theta} degrees {placement}"),
                seen(&[(POLARIZER, ""), (&matrix, placement)], 550.0),
                [power, power * cos, sign * power * sin, 0.0],
                ROUND_OFF,
            );
        }
    }
}

#[test]
fn what_cannot_be_rendered_is_refused_at_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    let run = |bsdf: &str, options: &[&str]| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'/>\n<shape type='rectangle'>{bsdf}</shape></scene>"
        );
        std::fs::write(&path, text).unwrap();
        let out = brewster()
            .args(["render", "scene.xml", "--spp", "1", "--size", "2x2"])
            .args(options)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (
            out.status.code(),
            String::from_utf8_lossy(&out.stderr).into_owned(),
        )
    };
    let mirrored = "<bsdf type='mueller'><string name='matrix' value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 -1'/></bsdf>";
    let (status, message) = run(mirrored, &[]);
    assert_eq!(status, Some(2));
    assert!(
        message.contains("scene.xml:2:46: 'matrix' of bsdf 'mueller': eigenvalue -0.500000"),
        "{message}"
    );
    let table = "<bsdf type='layered'><string name='thickness' value='100nm'/>\
        <spectrum name='ior' value='400:1.47, 700:1.455'/></bsdf>";
    let (status, message) = run(table, &["--rgb"]);
    assert_eq!(status, Some(2));
    assert!(
        message.contains("scene.xml:2:86: 'ior' of bsdf 'layered' is known from 400 to 700 nm"),
        "{message}"
    );
    assert_eq!(run(table, &["--wavelength", "500nm"]).0, Some(0));
}
