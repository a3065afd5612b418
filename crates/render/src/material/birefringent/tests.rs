//! Tests of crystal plates: retardance, conoscopy, power, reciprocity, messages.

use std::f64::consts::TAU;

use super::super::retarder::Retarder;
use super::super::testing::{broken_reciprocity, common_axis, direction, matrix, read, vertex};
use super::*;

fn plate(parameters: &str) -> Birefringent {
    read("birefringent", parameters, Birefringent::read).unwrap_or_else(|e| panic!("{e}"))
}

const CALCITE: &str = "<float name='no' value='1.66'/><float name='ne' value='1.49'/>\
    <vector name='axis' value='0.3 -0.5 0.8'/><string name='thickness' value='5um'/>";
const BIAXIAL: &str = "<float name='n1' value='1.5'/><string name='n2' value='1.6-0.001i'/><float name='n3' value='1.7'/>\
    <vector name='axis' value='0.3 -0.5 0.8'/><vector name='axis2' value='1 1 0'/>\
    <string name='thickness' value='5um'/>";
const TWISTED: &str = "<float name='no' value='1.5'/><float name='ne' value='1.6'/><float name='twist' value='90'/>\
    <string name='thickness' value='3um'/>";

fn in_mode(parameters: &str, mode: &str) -> Birefringent {
    plate(&format!(
        "{parameters}<string name='reflections' value='{mode}'/>"
    ))
}

#[test]
fn a_crystal_is_the_retarder_that_is_slow_along_its_axis() {
    // immersed, so that the faces reflect less than 1e-5
    let thickness = 20e-6;
    let crystal = plate(
        "<float name='no' value='1.545'/><float name='ne' value='1.555'/><float name='ext_ior' value='1.55'/>\
         <vector name='axis' value='1 1 0'/><string name='thickness' value='20um'/>\
         <string name='reflections' value='single'/>",
    );
    let delta = 360.0 * thickness * 0.01 / 550e-9;
    let retarder = read(
        "retarder",
        &format!("<float name='theta' value='-45'/><float name='delta' value='{delta}'/>"),
        Retarder::read,
    )
    .unwrap();
    for degrees in [0.0, 180.0] {
        let (o, axis) = (direction(degrees, 0.0), Vec3A::X);
        let [found, expected] = [
            matrix(&crystal, (o, axis), (-o, axis), Part::Straight, 550.0),
            matrix(&retarder, (o, axis), (-o, axis), Part::Straight, 550.0),
        ];
        assert!((found - expected).amax() < 3e-5, "{found} {expected}");
        assert!(expected[(1, 3)].abs() > 0.5);
    }
}

#[test]
fn a_plate_across_its_axis_has_the_rings_of_a_converging_view() {
    // normal components of the two wave vectors: √(no² − s²) and no √(1 − s²/ne²), s = sin θ
    let crystal = plate(
        "<float name='no' value='1.66'/><float name='ne' value='1.49'/><vector name='axis' value='0 0 1'/>\
         <string name='thickness' value='5um'/><string name='reflections' value='single'/>\
         <float name='ext_ior' value='1'/>",
    );
    for degrees in [5.0, 20.0, 40.0, 70.0, 140.0] {
        let o = direction(degrees, 0.9);
        let axis = o.cross(Vec3A::Z).normalize();
        let m = matrix(&crystal, (o, axis), (-o, axis), Part::Straight, 550.0);
        let s2 = f64::to_radians(degrees).sin().powi(2);
        let (ordinary, extraordinary) = (
            (1.66f64.powi(2) - s2).sqrt(),
            1.66 * (1.0 - s2 / 1.49f64.powi(2)).sqrt(),
        );
        let expected = TAU * 5e-6 / 550e-9 * (extraordinary - ordinary);
        let turn = (m[(2, 3)].atan2(m[(2, 2)]) - expected).rem_euclid(TAU);
        assert!(turn.min(TAU - turn) < 2e-5, "{degrees}: {turn}");
        // s and p do not mix
        assert!(m[(0, 2)].abs() < 1e-6 && m[(1, 3)].abs() < 1e-6);
    }
}

#[test]
fn clear_plates_keep_all_power() {
    for parameters in [CALCITE, TWISTED] {
        for mode in ["incoherent", "coherent"] {
            let matter = in_mode(parameters, mode);
            for degrees in [0.0, 35.0, 70.0, 120.0, 180.0] {
                let i = direction(degrees, 0.6);
                let of = |o: Vec3A, part| {
                    let axis = common_axis(o, i);
                    matrix(&matter, (o, axis), (i, axis), part, 550.0)[(0, 0)]
                };
                let total = of(mirror(i, Vec3A::Z), Part::Discrete(0)) + of(-i, Part::Straight);
                assert!(
                    (total - 1.0).abs() < 2e-6,
                    "{parameters} {mode} {degrees}: {total}"
                );
            }
        }
    }
    // the direct light alone is less, and so is that of plates that absorb
    for (parameters, mode) in [(CALCITE, "single"), (BIAXIAL, "coherent")] {
        let o = direction(35.0, 0.6);
        let axis = common_axis(o, -o);
        let m = matrix(
            &in_mode(parameters, mode),
            (o, axis),
            (-o, axis),
            Part::Straight,
            550.0,
        );
        assert!(m[(0, 0)] < 0.95 && m[(0, 0)] > 0.5);
    }
}

#[test]
fn plates_are_reciprocal() {
    for parameters in [CALCITE, BIAXIAL, TWISTED] {
        for mode in ["single", "incoherent", "coherent"] {
            let matter = in_mode(parameters, mode);
            for (degrees, azimuth) in [(20.0, 0.0), (65.0, 2.5)] {
                let o = direction(degrees, azimuth);
                let through = broken_reciprocity(&matter, (o, -o), Part::Straight, 550.0, 1.0);
                let mirrored = (o, mirror(o, Vec3A::Z));
                let back = broken_reciprocity(&matter, mirrored, Part::Discrete(0), 550.0, 1.0);
                assert!(
                    through.max(back) < 3e-6,
                    "{parameters} {mode}: {through} {back}"
                );
            }
        }
    }
}

#[test]
fn a_thick_twisted_cell_guides_linear_light() {
    // Mauguin: many waves of retardance over a quarter turn take the polarization along with the axes
    let cell = plate(
        "<float name='no' value='1.5'/><float name='ne' value='1.7'/><float name='twist' value='90'/>\
         <string name='thickness' value='60um'/><string name='reflections' value='single'/>\
         <float name='ext_ior' value='1.6'/>",
    );
    let m = matrix(
        &cell,
        (Vec3A::Z, Vec3A::X),
        (-Vec3A::Z, Vec3A::X),
        Part::Straight,
        550.0,
    );
    // along U at the back, along V at the front
    let crossed = 0.5 * (m[(0, 0)] + m[(0, 1)] - m[(1, 0)] - m[(1, 1)]);
    assert!(crossed > 0.97, "{crossed}");
}

#[test]
fn axes_twist_from_u_toward_v_on_the_way_to_the_front() {
    let cell = plate(
        "<float name='no' value='1.5'/><float name='ne' value='1.7'/><float name='twist' value='45'/>\
         <string name='thickness' value='60um'/><string name='reflections' value='single'/>\
         <float name='ext_ior' value='1.6'/>",
    );
    // light along U enters at the back
    let m = matrix(
        &cell,
        (Vec3A::Z, Vec3A::X),
        (-Vec3A::Z, Vec3A::X),
        Part::Straight,
        550.0,
    );
    let diagonal = m[(2, 0)] + m[(2, 1)];
    assert!((diagonal - 1.0).abs() < 0.05, "{diagonal}");
}

#[test]
fn oblique_light_across_the_axis_is_ordinary() {
    // nearly immersed: directions and faces change by a hundredth
    let axis = Vec3A::new(0.3, 0.8, 0.5).normalize();
    let crystal = plate(
        "<float name='no' value='1.545'/><float name='ne' value='1.555'/><float name='ext_ior' value='1.55'/>\
         <vector name='axis' value='0.3 0.8 0.5'/><string name='thickness' value='20um'/>\
         <string name='reflections' value='single'/>",
    );
    for (degrees, azimuth) in [(30.0, 0.9), (50.0, -2.0), (140.0, 2.2)] {
        let o = direction(degrees, azimuth);
        let ordinary = o.cross(axis).normalize();
        let m = matrix(
            &crystal,
            (o, ordinary),
            (-o, ordinary),
            Part::Straight,
            550.0,
        );
        let mixed = m
            .fixed_view::<2, 2>(0, 2)
            .amax()
            .max(m.fixed_view::<2, 2>(2, 0).amax());
        assert!(mixed < 0.03 && m[(1, 1)] > 0.97, "{degrees}: {m}");
    }
}

#[test]
fn ways_are_drawn_with_their_probability() {
    let matter = plate(CALCITE);
    for degrees in [5.0, 80.0, 150.0] {
        let at = vertex(direction(degrees, 2.0));
        let first = matter.sample(&at, &[550.0], [0.0; 3]).unwrap();
        let other = matter.sample(&at, &[550.0], [0.999_999, 0.0, 0.0]).unwrap();
        assert!((first.density + other.density - 1.0).abs() < 1e-6);
        assert_eq!(
            (first.part, other.part),
            (Part::Discrete(0), Part::Straight)
        );
        let edge = first.density;
        for (u, part) in [(edge - 1e-4, first.part), (edge + 1e-4, other.part)] {
            let d = matter.sample(&at, &[550.0], [u, 0.0, 0.0]).unwrap();
            assert_eq!(d.part, part);
        }
    }
}

#[test]
fn what_is_no_plate_is_refused() {
    let message = |parameters: &str| {
        read("birefringent", parameters, Birefringent::read)
            .err()
            .unwrap_or_default()
    };
    let uniaxial = "<float name='no' value='1.6'/><float name='ne' value='1.5'/>";
    for (parameters, expected) in [
        (
            uniaxial.to_owned(),
            "scene.xml:1:24: bsdf 'birefringent' has no parameter 'thickness', expected a length such as '0.2mm'",
        ),
        (
            format!("<string name='thickness' value='0um'/>{uniaxial}"),
            "scene.xml:2:1: 'thickness' of bsdf 'birefringent' is 0 m, expected a positive length",
        ),
        (
            "<string name='thickness' value='1um'/><float name='no' value='1.6'/>".to_owned(),
            "scene.xml:1:24: the indices of bsdf 'birefringent' are not complete, expected either 'no' and 'ne', or \
             'n1', 'n2' and 'n3'",
        ),
        (
            format!("<vector name='axis' value='0 0 0'/><string name='thickness' value='1um'/>{uniaxial}"),
            "scene.xml:2:1: the axis of bsdf 'birefringent' is (0, 0, 0), expected a vector of some length, in (U, V, \
             normal)",
        ),
        (
            "<vector name='axis2' value='2 0 0'/><string name='thickness' value='1um'/><float name='n1' value='1.6'/>\
             <float name='n2' value='1.6'/><float name='n3' value='1.6'/>"
                .to_owned(),
            "scene.xml:2:1: 'axis' (1, 0, 0) and 'axis2' (2, 0, 0) of bsdf 'birefringent' span no plane, expected two \
             vectors that are not parallel",
        ),
        (
            format!(
                "<string name='reflections' value='coherant'/><string name='thickness' value='1um'/>{uniaxial}"
            ),
            "scene.xml:2:1: parameter 'reflections' of bsdf 'birefringent' is 'coherant', expected 'single', \
             'incoherent' or 'coherent', did you mean 'coherent'?",
        ),
        (
            format!("<vector name='axis2' value='0 1 0'/><string name='thickness' value='1um'/>{uniaxial}"),
            "scene.xml:2:1: unknown parameter 'axis2' in bsdf 'birefringent', did you mean 'axis'?",
        ),
    ] {
        assert_eq!(message(&parameters), expected);
    }
}
