//! Polarizers, retarders and circular polarizers, straight on and tilted.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, film_scene, pixel};

use crate::elements::{
    Four, LAMP, LAMP_XML, circular, cross, degrees, dot, plate, polarizer, polarizer_xml, retarder,
    unit,
};

/// The twelve cells of `polarizer_stack`, row by row from the top left, in degrees of the scene file: a polarizer's
/// angle counts clockwise, a retarder's counter-clockwise, seen from the front.
fn cells() -> [Four; 12] {
    let p = |theta: f64, s| polarizer(degrees(-theta), s);
    let r = |theta: f64, delta: f64, s| retarder(degrees(theta), degrees(delta), s);
    // turned by 40 degrees about the vertical: the absorbing axis (sin 35, cos 35, 0) in the plane of the plate,
    // seen along z, has its first coordinate shortened
    let tilted = |s| {
        let (sin, cos) = degrees(35.0).sin_cos();
        polarizer((-sin * degrees(40.0).cos()).atan2(cos), s)
    };
    // about U by 150 degrees: seen from the back, where V points down; the retardance falls with the cosine
    let from_behind = |s| retarder(degrees(-10.0), degrees(90.0) * degrees(30.0).cos(), s);
    [
        p(0.0, LAMP),
        p(30.0, LAMP),
        p(45.0, LAMP),
        p(90.0, LAMP),
        p(90.0, p(0.0, LAMP)),
        p(90.0, p(45.0, p(0.0, LAMP))),
        r(0.0, 90.0, p(45.0, LAMP)),
        r(0.0, 90.0, p(-45.0, LAMP)),
        r(22.5, 180.0, p(0.0, LAMP)),
        r(30.0, 90.0, circular(1.0, LAMP)),
        circular(-1.0, r(60.0, 70.0, p(20.0, LAMP))),
        from_behind(tilted(LAMP)),
    ]
}

#[test]
fn every_cell_of_the_polarizer_stack_follows_mueller_calculus() {
    let image = Shot {
        size: Some([256, 192]),
        ..Shot::new(2)
    }
    .of_scene("polarizer_stack");
    for (cell, expected) in cells().into_iter().enumerate() {
        // cells are 1.05 apart on a film 4.33 wide
        let scale = 256.0 / (2.0 * 5000.0 * degrees(0.0248).tan());
        let x = 128.0 + ((cell % 4) as f64 - 1.5) * 1.05 * scale;
        let y = 96.0 + ((cell / 4) as f64 - 1.0) * 1.05 * scale;
        for (dx, dy) in [(0.0, 0.0), (0.3, 0.3), (-0.3, 0.2), (0.1, -0.3)] {
            let (s, error) = pixel(
                &image,
                (x + dx * scale) as usize,
                (y + dy * scale) as usize,
                0,
            );
            // the far camera sees the cells under up to 4e-4 rad, which turns projected axes by as much at most
            assert_stokes(&format!("cell {cell}"), (s, error), expected, 4e-4);
        }
    }
}

/// The tilted retarder that `a_tilted_retarder_has_no_seam` looks through: fast axis at `theta` from axis U, projected
/// across each ray; retardance by the cosine.
fn behind_tilted_retarder(right: f64, up: f64, tilt: f64, theta: f64) -> Four {
    let k = unit([-right, -up, 1.0]);
    let e_x = unit(cross(k.map(|v| -v), [0.0, 1.0, 0.0]));
    let e_y = cross(k, e_x);
    let across = |a: [f64; 3]| unit([0, 1, 2].map(|i| a[i] - dot(a, k) * k[i]));
    let angle = |a: [f64; 3]| dot(a, e_y).atan2(dot(a, e_x));
    // the polarizer lies across the axis of the camera and absorbs (sin 30, cos 30, 0)
    let absorbing = across([0.5, degrees(30.0).cos(), 0.0]);
    let light = polarizer(angle(absorbing) - PI / 2.0, LAMP);
    // the retarder is turned about U + V; the half turn of its angles is on the side that faces the camera
    let (s, c) = tilt.sin_cos();
    let h = 0.5f64.sqrt();
    let turn = |v: [f64; 3]| {
        let axis = [h, h, 0.0];
        let (a, x) = (dot(axis, v), cross(axis, v));
        [0, 1, 2].map(|i| v[i] * c + x[i] * s + axis[i] * a * (1.0 - c))
    };
    let (u, n) = (turn([1.0, 0.0, 0.0]), turn([0.0, 0.0, 1.0]));
    retarder(angle(across(u)) + theta, PI / 2.0 * dot(n, k).abs(), light)
}

#[test]
fn a_tilted_retarder_has_no_seam() {
    const SIZE: usize = 40;
    let tilt = 30.0;
    let content = format!(
        "{LAMP_XML}{}{}",
        plate(&polarizer_xml(30.0), "<scale value='60'/>"),
        plate(
            "<bsdf type='retarder'><float name='theta' value='20'/><float name='delta' value='90'/></bsdf>",
            &format!(
                "<scale value='60'/><rotate x='0.7071067811865476' y='0.7071067811865476' angle='{tilt}'/><translate z='7'/>"
            )
        )
    );
    let text = film_scene(
        8,
        "origin='0, 0, 10' target='0, 0, 0' up='0, 1, 0'",
        60.0,
        [SIZE as u32; 2],
        &content,
    );
    let image = Shot::new(256).of_text(&text);
    let half = degrees(30.0).tan();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let at = |i: usize, k: usize| {
                ((i as f64 + (k as f64 + 0.5) / 4.0) / SIZE as f64 * 2.0 - 1.0) * half
            };
            let mut expected = [0.0; 4];
            for k in 0..16 {
                let s = behind_tilted_retarder(
                    at(x, k % 4),
                    -at(y, k / 4),
                    degrees(tilt),
                    degrees(20.0),
                );
                expected = [0, 1, 2, 3].map(|i| expected[i] + s[i] / 16.0);
            }
            // the midpoint rule over a quarter of a pixel is good to 2e-5
            assert_stokes(
                &format!("pixel {x}, {y}"),
                pixel(&image, x, y, 0),
                expected,
                3e-5,
            );
        }
    }
}
