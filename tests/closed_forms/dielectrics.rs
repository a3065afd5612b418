//! Smooth glass: Fresnel, the furnace, radiance inside.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, film_scene, mean, pixel};

use crate::elements::{Four, LAMP, ROUND_OFF, SURROUNDINGS, degrees, reflectances, turned};

#[test]
fn a_glass_sphere_in_uniform_light_is_invisible() {
    let image = Shot {
        size: Some([48, 48]),
        ..Shot::new(64)
    }
    .of_scene("furnace_sphere");
    // 64 bounces: what is cut off is below 1e-9
    assert_stokes("whole image", mean(&image, 0), LAMP, ROUND_OFF);
    for y in 0..48 {
        for x in 0..48 {
            let (s, _) = pixel(&image, x, y, 0);
            // each path chooses in proportion to what the sensor sees on either way: S0 has no noise, only the rounding of
            // at most 64 vertices, ten operations each
            assert!(
                (s[0] - 1.0).abs() < 640.0 * f64::from(f32::EPSILON),
                "{x}, {y}: {s:?}"
            );
            if (x as f64 - 23.5).hypot(y as f64 - 23.5) > 24.0 {
                assert_eq!(s, LAMP, "outside the sphere at {x}, {y}");
            }
        }
    }
}

#[test]
fn a_glass_sphere_reflects_tangentially_polarized_light_by_fresnels_formulas() {
    const SIZE: usize = 64;
    let image = Shot {
        size: Some([SIZE as u32; 2]),
        ..Shot::new(256)
    }
    .of_scene("fresnel_sphere");
    // by ring of equal distance from the centre: sums over pixels of mean and variance
    const RINGS: usize = 10;
    let mut found = [[[0.0; 4]; 2]; RINGS];
    let mut expected = [[0.0; 4]; RINGS];
    let mut count = [0.0; RINGS];
    let half = degrees(16.0).tan();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let (s, error) = pixel(&image, x, y, 0);
            let (mut radial, mut inside) = ([0.0; 4], 0);
            const FINE: usize = 16;
            let at = |i: usize, k: usize| {
                ((i as f64 + (k as f64 + 0.5) / FINE as f64) / SIZE as f64 * 2.0 - 1.0) * half
            };
            for k in 0..FINE * FINE {
                let (right, up) = (at(x, k % FINE), -at(y, k / FINE));
                // the camera at distance 4 from the centre of the unit sphere looks along (right, up, -1)
                let sine = 4.0 * right.hypot(up) / (right.hypot(up)).hypot(1.0);
                if sine >= 1.0 {
                    radial[0] += 1.0;
                    continue;
                }
                inside += 1;
                let (r_s, r_p) = reflectances(1.5, sine.asin());
                // s is tangential: across the direction from the centre of the image
                let tangent = up.atan2(right) + PI / 2.0;
                let linear = 0.5 * (r_s - r_p);
                radial[0] += 0.5 * (r_s + r_p);
                radial[1] += linear * (2.0 * tangent).cos();
                radial[2] += linear * (2.0 * tangent).sin();
            }
            radial = radial.map(|v| v / (FINE * FINE) as f64);
            // where even the corner next to the centre of the image looks past the sphere
            let near = |i: usize| {
                let edge = |i: usize| (i as f64 / SIZE as f64 * 2.0 - 1.0) * half;
                0f64.clamp(edge(i), edge(i + 1))
            };
            let r = near(x).hypot(near(y));
            if 4.0 * r / r.hypot(1.0) > 1.0 + 1e-5 {
                assert_eq!(s, LAMP, "outside the sphere at {x}, {y}");
                continue;
            }
            if inside < FINE * FINE {
                continue;
            }
            assert_eq!(s[3], 0.0, "no circular light at {x}, {y}");
            let distance =
                (x as f64 + 0.5 - SIZE as f64 / 2.0).hypot(y as f64 + 0.5 - SIZE as f64 / 2.0);
            let ring = (distance / (SIZE as f64 / 2.0) * RINGS as f64) as usize;
            let angle = -2.0
                * (SIZE as f64 / 2.0 - y as f64 - 0.5).atan2(x as f64 + 0.5 - SIZE as f64 / 2.0);
            let turn = |s: Four| turned(-0.5 * angle, s);
            let (turned_s, turned_e) = (turn(s), turn(radial));
            // variances of S1 and S2 mix when the frame turns
            let (c, sn) = (angle.cos().powi(2), angle.sin().powi(2));
            let v = error.map(|e| e * e);
            let variance = [
                v[0],
                2.0 * (c * v[1] + sn * v[2]),
                2.0 * (sn * v[1] + c * v[2]),
                0.0,
            ];
            for k in 0..4 {
                found[ring][0][k] += turned_s[k];
                found[ring][1][k] += variance[k];
                expected[ring][k] += turned_e[k];
            }
            count[ring] += 1.0;
        }
    }
    for ring in (0..RINGS).filter(|&r| count[r] > 0.0) {
        let n = count[ring];
        let means = found[ring][0].map(|v| v / n);
        let errors = found[ring][1].map(|v| v.sqrt() / n);
        assert_stokes(
            &format!("ring {ring}"),
            (means, errors),
            expected[ring].map(|v| v / n),
            ROUND_OFF,
        );
        assert!(
            means[1] < 0.0 || ring == 0,
            "tangential light is negative in the radial frame"
        );
    }
}

#[test]
fn radiance_inside_glass_is_higher_by_the_square_of_its_index() {
    let content = format!(
        "{SURROUNDINGS}<shape type='sphere'><bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf></shape>"
    );
    // 0.3 from the centre no ray is totally reflected: sin = 0.3 < 1/1.5
    let text = film_scene(
        256,
        "origin='0.3, 0, 0' target='0, 0.5, 1' up='0, 1, 0'",
        90.0,
        [8, 8],
        &content,
    );
    let image = Shot::new(4096).of_text(&text);
    assert_stokes("inside glass", mean(&image, 0), [2.25, 0.0, 0.0, 0.0], 1e-5);
}
