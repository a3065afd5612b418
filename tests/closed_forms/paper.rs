//! Light through plates onto white paper.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, pixel, scene};

use crate::elements::{
    Four, LAMP, SURROUNDINGS, circular, cross, degrees, dot, plate, polarizer, polarizer_xml,
    retarder, unit,
};

/// Light from all around through plates over white paper: the share of the irradiance that reaches the paper.
///
/// 1/π ∫ T cos θ dω over the upper half; T(k) by Mueller calculus for light that travels along k.
fn share_on_paper(passes: impl Fn([f64; 3]) -> f64) -> f64 {
    let (steps, turns) = (500, 720);
    let mut sum = 0.0;
    for j in 0..steps {
        // by projected solid angle: sin² θ is uniform
        let sin = ((f64::from(j) + 0.5) / f64::from(steps)).sqrt();
        let cos = (1.0 - sin * sin).sqrt();
        for turn in 0..turns {
            let phi = (f64::from(turn) + 0.5) / f64::from(turns) * 2.0 * PI;
            sum += passes([sin * phi.cos(), sin * phi.sin(), -cos]);
        }
    }
    sum / f64::from(steps * turns)
}

/// Angles of vectors seen along a downward k: in a frame across it, against image right of who looks up.
struct Downward {
    k: [f64; 3],
    e_x: [f64; 3],
}

impl Downward {
    fn new(k: [f64; 3]) -> Self {
        let e_x = unit(cross(k, [0.3, 0.7, 0.2]));
        Self { k, e_x }
    }

    /// Angle of the direction `a`, projected across k.
    fn angle(&self, a: [f64; 3]) -> f64 {
        dot(a, cross(self.k, self.e_x)).atan2(dot(a, self.e_x))
    }

    fn polarizer(&self, theta: f64, s: Four) -> Four {
        let (sin, cos) = degrees(theta).sin_cos();
        polarizer(self.angle([sin, cos, 0.0]) - PI / 2.0, s)
    }

    /// Its angle counts counter-clockwise from the front, and the light leaves through the back.
    fn retarder(&self, theta: f64, delta: f64, s: Four) -> Four {
        let fast = self.angle([1.0, 0.0, 0.0]) - degrees(theta);
        retarder(fast, degrees(delta) * self.k[2].abs(), s)
    }
}

#[test]
fn white_paper_is_lit_by_what_passes_the_plates_above_it() {
    let at = |bsdf: &str, z: f64| plate(bsdf, &format!("<scale value='1e4'/><translate z='{z}'/>"));
    let retarder_xml = "<bsdf type='retarder'><float name='theta' value='20'/><float name='delta' value='90'/></bsdf>";
    let circular_xml = "<bsdf type='circular'/>";
    let paper = plate(
        "<bsdf type='diffuse'><float name='reflectance' value='1'/></bsdf>",
        "<scale value='1e4'/>",
    );
    let see = |plates: &str| {
        // under the plates, where paper is all that the camera sees
        let camera = "origin='0, 0, 0.05' target='0.05, 0, 0' up='0, 1, 0'";
        let text = scene(6, camera, 0.01, &format!("{SURROUNDINGS}{paper}{plates}"));
        pixel(&Shot::new(200_000).of_text(&text), 0, 0, 0)
    };
    // the plates of 1e4 m end 1e-5 above the horizon; quadrature: doubling its points changes the sixth digit
    let check = |what: &str, plates: &str, share: f64| {
        assert_stokes(what, see(plates), [share, 0.0, 0.0, 0.0], 1e-5);
    };
    let crossed = |theta: f64| {
        share_on_paper(|k| {
            let seen = Downward::new(k);
            seen.polarizer(0.0, seen.polarizer(theta, LAMP))[0]
        })
    };
    for theta in [0.0, 45.0, 70.0] {
        let plates = format!(
            "{}{}",
            at(&polarizer_xml(0.0), 0.1),
            at(&polarizer_xml(theta), 0.2)
        );
        check(
            &format!("polarizers at 0 and {theta}"),
            &plates,
            crossed(theta),
        );
    }
    let elliptic = share_on_paper(|k| {
        let seen = Downward::new(k);
        circular(1.0, seen.retarder(20.0, 90.0, seen.polarizer(60.0, LAMP)))[0]
    });
    assert!(
        (elliptic - 0.25).abs() > 0.02,
        "the sense of rotation matters: {elliptic}"
    );
    let plates = [
        at(circular_xml, 0.1),
        at(retarder_xml, 0.2),
        at(&polarizer_xml(60.0), 0.3),
    ]
    .concat();
    check("polarizer, retarder, circular polarizer", &plates, elliptic);
}
