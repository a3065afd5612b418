//! The clear sky: radiance and polarization in every direction, and what it lights.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, mean, scene};
use glam::DVec3;
use render::film::SpectralMode;

const SUN: DVec3 = DVec3::new(0.8, 0.45, -0.3);
const SKY: &str = "<emitter type='rayleighsky'><vector name='sun_direction' x='0.8' y='0.45' z='-0.3'/>
    <float name='optical_depth' value='0.1'/><float name='dop_max' value='0.9'/><float name='irradiance' value='20'/>
    <float name='ground' value='0.07'/></emitter>";

/// Radiance of a plane layer that scatters once.
fn radiance(toward: DVec3, tau: f64) -> f64 {
    let sun = SUN.normalize();
    let (mu, mu0, c) = (toward.y, sun.y, toward.dot(sun));
    20.0 / (4.0 * PI) * 0.75 * (1.0 + c * c) * mu0 / (mu0 - mu)
        * ((-tau / mu0).exp() - (-tau / mu).exp())
}

/// What a camera with the given view and upward direction sees of it.
fn closed_form(toward: DVec3, up: DVec3, tau: f64) -> [f64; 4] {
    let sun = SUN.normalize();
    let c = toward.dot(sun);
    let degree = 0.9 * (1.0 - c * c) / (1.0 + c * c);
    let across = sun.cross(toward).normalize();
    let right = toward.cross(up).normalize();
    let above = (-toward).cross(right);
    let angle = across.dot(above).atan2(across.dot(right));
    let l = radiance(toward, tau);
    [
        l,
        l * degree * (2.0 * angle).cos(),
        l * degree * (2.0 * angle).sin(),
        0.0,
    ]
}

#[test]
fn every_direction_has_its_radiance_degree_and_angle() {
    let mut count = 0;
    for height in [4.0f64, 20.0, 45.0, 70.0, 86.0] {
        for azimuth in [10.0f64, 100.0, 165.0, 250.0, 340.0] {
            let (h, a) = (height.to_radians(), azimuth.to_radians());
            let toward = DVec3::new(h.cos() * a.cos(), h.sin(), h.cos() * a.sin());
            let up = DVec3::new(0.2, 0.5, 0.9);
            let lookat = format!(
                "origin='0, 0, 0' target='{:.9}, {:.9}, {:.9}' up='0.2, 0.5, 0.9'",
                toward.x, toward.y, toward.z
            );
            for (wavelength, tau) in [(550.0, 0.1), (440.0, 0.1 * (550f64 / 440.0).powi(4))] {
                let shot = Shot {
                    mode: SpectralMode::Single(wavelength),
                    ..Shot::new(4)
                };
                let found = mean(&shot.of_text(&scene(1, &lookat, 1e-4, SKY)), 0);
                let expected = closed_form(toward, up, tau);
                // single precision of directions, which counts 1/μ near the horizon
                assert_stokes(
                    &format!("{height} {azimuth}"),
                    found,
                    expected,
                    2e-5 * expected[0],
                );
                count += 1;
            }
        }
    }
    assert_eq!(count, 50);
}

#[test]
fn below_the_horizon_is_ground() {
    let text = scene(
        1,
        "origin='0, 0, 0' target='1, -0.1, 0' up='0, 1, 0'",
        1e-3,
        SKY,
    );
    let (s, _) = mean(&Shot::new(4).of_text(&text), 0);
    assert_eq!(s.map(|v| v as f32), [0.07, 0.0, 0.0, 0.0]);
}

/// Irradiance on a plane with the given normal, by quadrature over the sphere.
fn irradiance(normal: DVec3) -> f64 {
    let (rows, columns) = (800, 800);
    let cell = 4.0 * PI / f64::from(rows * columns);
    let mut sum = 0.0;
    for row in 0..rows {
        let y = (f64::from(row) + 0.5) / f64::from(rows) * 2.0 - 1.0;
        let r = (1.0 - y * y).sqrt();
        for column in 0..columns {
            let phi = (f64::from(column) + 0.5) / f64::from(columns) * 2.0 * PI;
            let d = DVec3::new(r * phi.cos(), y, r * phi.sin());
            let l = if y > 0.0 { radiance(d, 0.1) } else { 0.07 };
            sum += l * d.dot(normal).max(0.0) * cell;
        }
    }
    sum
}

#[test]
fn planes_under_the_sky_get_its_irradiance() {
    // lying, standing and hanging
    for (turn, normal) in [(-90.0, DVec3::Y), (0.0, DVec3::Z), (90.0, DVec3::NEG_Y)] {
        let plane = format!(
            "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='{turn}'/></transform>
             <bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf></shape>"
        );
        let eye = normal * 2.0 + DVec3::X * 0.5;
        let lookat = format!(
            "origin='{}, {}, {}' target='0, 0, 0' up='1, 0.1, 0.2'",
            eye.x, eye.y, eye.z
        );
        let found = mean(
            &Shot::new(16384).of_text(&scene(2, &lookat, 1e-3, &format!("{plane}{SKY}"))),
            0,
        );
        let expected = irradiance(normal) / PI;
        assert!(found.1[0] < 0.02 * expected, "too noisy to tell: {found:?}");
        // midpoint rule at the horizon, where the sky has its only edge
        assert_stokes(
            &format!("{normal}"),
            found,
            [expected, 0., 0., 0.],
            1e-3 * expected,
        );
    }
}
