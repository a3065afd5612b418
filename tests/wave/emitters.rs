//! Polarized emitters: their states in their frames, seen directly and through plates, and how strong they are.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};

use crate::mueller::{Four, circular, polarizer, retarder, turned};

/// What single precision may cost: a few products of numbers around one, and directions that differ within a pixel.
const ROUND_OFF: f64 = 5e-6;

const STATE: Four = [1.0, 0.3, 0.4, -0.5];
const STATE_XML: &str = "<string name='stokes' value='1, 0.3, 0.4, -0.5'/>";

fn seen(content: &str) -> ([f64; 4], [f64; 4]) {
    let text = scene(
        4,
        "origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'",
        0.001,
        content,
    );
    mean(&Shot::new(4).of_text(&text), 0)
}

#[test]
fn a_lamp_shows_its_state_in_the_frame_of_its_shape() {
    for shape in ["rectangle", "disk", "sphere", "cube"] {
        for turn in [0.0, 30.0, -75.0] {
            let lamp = format!(
                "<shape type='{shape}'><transform name='to_world'><rotate z='1' angle='{turn}'/></transform>
                 <emitter type='area'>{STATE_XML}</emitter></shape>"
            );
            let expected = turned(-f64::to_radians(turn), STATE);
            assert_stokes(
                &format!("{shape} turned by {turn}"),
                seen(&lamp),
                expected,
                ROUND_OFF,
            );
        }
    }
}

#[test]
fn a_frame_is_a_vector_in_the_world() {
    let sources = [
        format!(
            "<shape type='rectangle'><emitter type='area'>{STATE_XML}<vector name='frame' x='1' y='2' z='7'/></emitter></shape>"
        ),
        format!(
            "<emitter type='constant'>{STATE_XML}<vector name='frame' x='1' y='2' z='7'/></emitter>"
        ),
    ];
    let expected = turned(-2f64.atan2(1.0), STATE);
    for source in sources {
        assert_stokes(&source, seen(&source), expected, ROUND_OFF);
    }
    let world = format!("<emitter type='constant'>{STATE_XML}</emitter>");
    assert_stokes("world x", seen(&world), STATE, ROUND_OFF);
}

/// Sources whose light falls along −z on the origin, with the irradiance there.
fn lamps() -> Vec<(&'static str, String, f64)> {
    let down = "<lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/>";
    let placed = format!("<transform name='to_world'>{down}</transform>");
    vec![
        (
            "point",
            format!(
                "<emitter type='point'>{placed}<float name='intensity' value='8'/>{STATE_XML}</emitter>"
            ),
            2.0,
        ),
        (
            "spot",
            format!(
                "<emitter type='spot'>{placed}<float name='intensity' value='8'/>{STATE_XML}</emitter>"
            ),
            2.0,
        ),
        (
            "directional",
            format!(
                "<emitter type='directional'><vector name='direction' x='0' y='0' z='-1'/>{STATE_XML}</emitter>"
            ),
            1.0,
        ),
        (
            "gaussian laser",
            format!(
                "<emitter type='laser'>{placed}<string name='waist' value='10cm'/><float name='power' value='0.01'/>{STATE_XML}</emitter>"
            ),
            2.0 * 0.01 / (PI * 0.01),
        ),
        (
            "top-hat laser",
            format!(
                "<emitter type='laser'>{placed}<string name='waist' value='2 cm'/><float name='power' value='0.001'/>\
                 <string name='profile' value='tophat'/>{STATE_XML}</emitter>"
            ),
            0.001 / (PI * 0.0004),
        ),
    ]
}

/// A white diffuse plane under a lamp, a plate between them that the camera does not look through.
fn lit_through(lamp: &str, plates: &str) -> ([f64; 4], [f64; 4]) {
    let content = format!(
        "<shape type='rectangle'><bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf></shape>{plates}{lamp}"
    );
    let text = scene(
        6,
        "origin='2, 0, 0.5' target='0, 0, 0' up='0, 0, 1'",
        0.001,
        &content,
    );
    mean(&Shot::new(16).of_text(&text), 0)
}

fn plate(z: f64, bsdf: &str) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='0.1'/><translate z='{z}'/></transform>{bsdf}</shape>"
    )
}

#[test]
fn malus_law_holds_for_every_lamp_that_only_connections_can_find() {
    // the light's frame is (x, −y): a polarizer's clockwise angle from the front counts forward in it, a retarder's back
    for (name, lamp, irradiance) in lamps() {
        let white = irradiance / PI;
        let check = |what: &str, plates: &str, passed: Four| {
            let expected = [white * passed[0], 0.0, 0.0, 0.0];
            assert_stokes(
                &format!("{name} through {what}"),
                lit_through(&lamp, plates),
                expected,
                ROUND_OFF,
            );
        };
        check("nothing", "", STATE);
        check("null", &plate(1.0, "<bsdf type='null'/>"), STATE);
        for theta in [0.0, 20.0, 45.0, 90.0, 135.0] {
            let turn = f64::to_radians(theta);
            let first =
                format!("<bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf>");
            let second = "<bsdf type='polarizer'><float name='theta' value='70'/></bsdf>";
            check("a polarizer", &plate(1.0, &first), polarizer(turn, STATE));
            check(
                "two polarizers",
                &(plate(1.0, &first) + &plate(0.8, second)),
                polarizer(f64::to_radians(70.0), polarizer(turn, STATE)),
            );
            let wave = format!(
                "<bsdf type='retarder'><float name='theta' value='{theta}'/><float name='delta' value='70'/></bsdf>"
            );
            let delayed = retarder(-turn, f64::to_radians(70.0), STATE);
            check(
                "a retarder and a polarizer",
                &(plate(1.0, &wave) + &plate(0.8, second)),
                polarizer(f64::to_radians(70.0), delayed),
            );
            check(
                "a retarder and a circular polarizer",
                &(plate(1.0, &wave) + &plate(0.8, "<bsdf type='circular'/>")),
                circular(delayed),
            );
        }
    }
}

#[test]
fn a_sun_of_some_width_has_a_penumbra_and_its_full_irradiance() {
    let sun = "<emitter type='directional'><vector name='direction' x='0' y='0' z='-1'/>
        <float name='irradiance' value='3'/><float name='angular_diameter' value='2'/></emitter>";
    let edge = "<shape type='rectangle'><transform name='to_world'><scale x='5' y='5'/><translate x='5' z='1'/></transform>
        <bsdf type='diffuse'><spectrum name='reflectance' value='0'/></bsdf></shape>";
    let floor = "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform>
        <bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf></shape>";
    let radius = f64::to_radians(1.0).tan();
    for place in [-2.0, -0.6, 0.0, 0.3, 0.9, 2.0] {
        let x = place * radius;
        let lookat = format!(
            "origin='{}, 0, 0.5' target='{x}, 0, 0' up='0, 0, 1'",
            x - 1.0
        );
        let text = scene(3, &lookat, 0.0001, &format!("{floor}{edge}{sun}"));
        // the part of a disc on one side of a line
        let at = (-place).clamp(-1.0, 1.0);
        let lit = 0.5 + (at.asin() + at * (1.0 - at * at).sqrt()) / PI;
        assert_stokes(
            &format!("{place} radii"),
            mean(&Shot::new(4096).of_text(&text), 0),
            [3.0 / PI * lit, 0.0, 0.0, 0.0],
            // the tangent of an angle for its sine
            3e-4,
        );
    }
}

#[test]
fn what_no_emitter_can_be_is_refused_with_its_place() {
    let refused = |content: &str| {
        let text =
            format!("<scene version='3.0.0'><sensor type='perspective'/>\n{content}</scene>");
        let document = render::scene::read_text(&text, "test.xml".as_ref(), &[]).expect("xml");
        match render::scene::build(&document, Default::default()) {
            Ok(_) => panic!("accepted: {content}"),
            Err(error) => error.to_string(),
        }
    };
    let in_disk = |inside: &str| {
        format!("<shape type='disk'><emitter type='egsm'>{inside}</emitter></shape>")
    };
    let lengths = "<string name='sigma' value='1mm'/><string name='delta_xx' value='1um'/><string name='delta_yy' value='2um'/>";
    for (content, expected) in [
        (
            "<emitter type='point'><string name='stokes' value='1, 0.8, 0.8, 0'/></emitter>".to_owned(),
            "test.xml:2:23: 'stokes' of emitter 'point' has a degree of polarization of 1.131371, expected at most 1",
        ),
        (
            "<emitter type='constant'><string name='stokes' value='0.5, 0, 0, 0'/></emitter>".to_owned(),
            "test.xml:2:26: 'stokes' of emitter 'constant' begins with 0.5, expected 1: the strength of the source is another parameter",
        ),
        (
            "<emitter type='spot'><vector name='frame' x='1' y='0' z='0'/></emitter>".to_owned(),
            "'frame' of emitter 'spot' without 'stokes', expected both or none",
        ),
        (
            "<emitter type='laser'><string name='waist' value='0mm'/></emitter>".to_owned(),
            "a radius of 0 m, expected a positive length",
        ),
        (
            "<emitter type='directional'><float name='angular_diameter' value='180'/></emitter>".to_owned(),
            "an angle of 180°, expected one from 0 to below 180",
        ),
        (
            "<emitter type='rayleighsky'><vector name='sun_direction' x='1' y='-1' z='0'/></emitter>".to_owned(),
            "the sun is -45.000° above the horizon, expected at least 0.1°",
        ),
        (
            "<emitter type='egsm'/>".to_owned(),
            "emitter 'egsm' stands alone, expected it inside a shape",
        ),
        (
            "<shape type='sphere'><emitter type='egsm'/></shape>".to_owned(),
            "emitter 'egsm' inside shape 'sphere', expected it inside a rectangle or a disk",
        ),
        (
            in_disk(&format!("{lengths}<float name='B_xy' value='0.81'/>")),
            "expected |B_xy| of at most δxx δyy/δxy² = 0.800000",
        ),
        (
            in_disk(&format!("{lengths}<float name='B_xy' value='0.1'/><string name='delta_xy' value='1.5um'/>")),
            "expected at least √((δxx² + δyy²)/2) = 1.58113",
        ),
        (
            in_disk(&format!("{lengths}<string name='stokes' value='1, 0, 0, 0'/>")),
            "unknown parameter 'stokes' in emitter 'egsm'",
        ),
    ] {
        let message = refused(&content);
        assert!(
            message.starts_with("test.xml:2:") && message.contains(expected),
            "{message}\nexpected {expected}"
        );
    }
    let edge = in_disk(&format!("{lengths}<float name='B_xy' value='0.8'/>"));
    let text = format!("<scene version='3.0.0'><sensor type='perspective'/>{edge}</scene>");
    let document = render::scene::read_text(&text, "test.xml".as_ref(), &[]).expect("xml");
    assert!(render::scene::build(&document, Default::default()).is_ok());
}
