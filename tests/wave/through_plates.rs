//! Light that connections find through polarizers agrees with quadrature and with paths that find it by chance.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, film_scene, mean, scene};
use glam::DVec3;

const LAMP: &str = "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='180'/><translate z='2'/></transform>
    <emitter type='area'><float name='radiance' value='3'/></emitter></shape>";

fn polarizer(z: f64, theta: f64) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='2'/><translate z='{z}'/></transform>
         <bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf></shape>"
    )
}

/// What passes a plate of each angle: the absorbing axes (sin t, cos t, 0) are projected across the ray.
fn passed(direction: DVec3, thetas: [f64; 2]) -> f64 {
    let axes = thetas.map(|theta| {
        let a = DVec3::new(theta.sin(), theta.cos(), 0.0);
        (a - direction * a.dot(direction)).normalize()
    });
    0.5 * axes[0].dot(axes[1]).powi(2)
}

#[test]
fn a_floor_below_a_lamp_and_two_polarizers_follows_malus_for_every_ray() {
    for angle in [0.0f64, 60.0, 90.0] {
        let thetas = [10f64.to_radians(), (10.0 + angle).to_radians()];
        let plates = polarizer(1.5, 10.0) + &polarizer(1.2, 10.0 + angle);
        let floor =
            "<shape type='rectangle'><transform name='to_world'><scale value='0.5'/></transform>
            <bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf></shape>";
        let text = scene(
            5,
            "origin='2, 0, 0.5' target='0, 0, 0' up='0, 0, 1'",
            1e-3,
            &format!("{floor}{plates}{LAMP}"),
        );
        let found = mean(&Shot::new(16384).of_text(&text), 0);
        let steps = 200;
        let mut expected = 0.0;
        for row in 0..steps {
            for column in 0..steps {
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
                let to = DVec3::new(at(column), at(row), 2.0);
                let d = to.normalize();
                expected += 3.0 * d.z * d.z / to.length_squared() * passed(d, thetas) / PI * 4.0
                    / f64::from(steps * steps);
            }
        }
        // midpoint rule: 1e-5
        assert_stokes(
            &format!("{angle}°"),
            found,
            [expected, 0., 0., 0.],
            1e-4 * expected + 1e-6,
        );
    }
}

#[test]
fn connections_through_polarizers_agree_with_paths_that_cannot_connect() {
    // a pane of matter with the index of air does nothing but stand in the way of connections
    let pane = "<shape type='rectangle'><transform name='to_world'><scale value='50'/><translate z='1.7'/></transform>
        <bsdf type='dielectric'><float name='int_ior' value='1'/><float name='ext_ior' value='1'/></bsdf></shape>";
    let matter = [
        "<bsdf type='roughconductor'><string name='material' value='Al'/><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='pplastic'><float name='alpha' value='0.2'/></bsdf>",
        "<bsdf type='diffuse'/>",
    ];
    for bsdf in matter {
        let content = format!(
            "<shape type='rectangle'><transform name='to_world'><rotate x='1' y='0' angle='20'/></transform>{bsdf}</shape>{}{}",
            polarizer(1.5, 30.0) + &polarizer(1.3, 75.0),
            LAMP.replace(
                "<float name='radiance'",
                "<string name='stokes' value='1, 0.2, 0.1, 0.6'/><float name='radiance'"
            )
        );
        let render = |extra: &str, seed: u64| {
            let text = film_scene(
                7,
                "origin='0.6, -3, 1' target='0, 0, 0' up='0, 0, 1'",
                4.0,
                [4, 4],
                &format!("{content}{extra}"),
            );
            let shot = Shot {
                seed,
                ..Shot::new(1024)
            };
            mean(&shot.of_text(&text), 0)
        };
        let (with, chance) = (render("", 1), render(pane, 2));
        assert!(
            with.0[0] > 0.0 && with.1[0] < chance.1[0],
            "{with:?} {chance:?}"
        );
        let noise = std::array::from_fn(|k| with.1[k].hypot(chance.1[k]));
        assert_stokes(bsdf, (with.0, noise), chance.0, 1e-6);
    }
}
