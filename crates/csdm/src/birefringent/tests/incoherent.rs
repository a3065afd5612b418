//! Sums of powers of internal reflections against averages and series.

use super::*;
use nalgebra::{Matrix4, Vector3};
use std::f64::consts::{PI, TAU};

#[test]
fn thick_incoherent_plates_average_the_fringes() {
    // isotropic, oblique: the mean over a period of thickness, exact for the trapezoidal rule with R^64 ≪ 1
    use crate::film::{Layer, Stack};
    let (n, cos_i) = (Complex64::from(2.0), 0.4f64);
    let w = crate::fresnel::normal_index_of(1.0.into(), n, cos_i).re;
    let plate = stack(1.0, vec![layer(&isotropic(2.0), 50.0)], 1.4);
    let sum = plate.incoherent(&at(cos_i, 0.0), light(), 0.0).unwrap();
    let mut mean = [Matrix4::zeros(), Matrix4::zeros()];
    for i in 0..64 {
        let thickness = (50.0 + f64::from(i) / 64.0 * 0.5 / w) * LAMBDA;
        let film = Stack::new(
            1.0,
            vec![Layer {
                index: n,
                thickness,
            }],
            1.4.into(),
        )
        .unwrap();
        let film = film.amplitudes(cos_i, light());
        mean[0] += film.reflection_mueller().to_matrix() / 64.0;
        mean[1] += film.transmission_mueller().unwrap().to_matrix() / 64.0;
    }
    assert!((sum.front.reflection.to_matrix() - mean[0]).amax() < 1e-12);
    assert!((sum.front.transmission.to_matrix() - mean[1]).amax() < 1e-12);
}

#[test]
fn a_thick_absorbing_window_obeys_the_series_of_powers() {
    // R = R₁ + T₁ T₁' R₂ A²/(1 − R₁ R₂ A²), with |t t'|² of the amplitudes, which differ from 1 − R
    let n = Complex64::new(1.8, -0.01);
    let window = layer(&Crystal::isotropic(n).unwrap(), 5.0);
    let found = stack(1.0, vec![window], 1.5)
        .incoherent(&at(1.0, 0.0), light(), 0.0)
        .unwrap();
    let r1 = ((n - 1.0) / (n + 1.0)).norm_sqr();
    let r2 = ((n - 1.5) / (n + 1.5)).norm_sqr();
    let through = (4.0 * n / (n + 1.0).powi(2)).norm_sqr();
    let a = (-4.0 * PI * 5.0 * 0.01f64).exp();
    let expected = r1 + through * r2 * a * a / (1.0 - r1 * r2 * a * a);
    assert!((found.front.reflection.to_matrix()[(0, 0)] - expected).abs() < 1e-14);
    let t = (4.0 * n / ((n + 1.0) * (n + 1.5))).norm_sqr() * 1.5 * a / (1.0 - r1 * r2 * a * a);
    assert!((found.front.transmission.to_matrix()[(0, 0)] - t).abs() < 1e-14);
}

#[test]
fn incoherent_retarders_sum_their_bounces() {
    // normal incidence: bounce by bounce, along the two axes
    let (no, ne, depth) = (1.66, 1.49, 31.3);
    let crystal = Crystal::uniaxial(no.into(), ne.into(), Vector3::x()).unwrap();
    let plate = stack(1.0, vec![layer(&crystal, depth)], 1.0);
    let found = plate.incoherent(&at(1.0, 0.0), light(), 0.0).unwrap();
    let mut expected = Matrix4::zeros();
    let along = |n: f64, bounce: i32| {
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        (1.0 - r) * r.powi(bounce) * (-I * TAU * depth * n * f64::from(2 * bounce + 1)).exp()
    };
    for bounce in 0..20 {
        let jones = JonesMatrix::diagonal(along(ne, bounce), along(no, bounce));
        expected += jones.mueller().to_matrix();
    }
    assert!((found.front.transmission.to_matrix() - expected).amax() < 1e-12);
}

#[test]
fn coatings_of_a_thick_plate_stay_coherent() {
    // a quarter wave of √n on both faces: nothing is reflected
    let n = 2.25;
    let coat = layer(&isotropic(1.5), 0.25 / 1.5);
    let window = layer(&isotropic(n), 1000.0);
    let plate = stack(1.0, vec![coat.clone(), window, coat], 1.0);
    let green = plate.incoherent(&at(1.0, 0.0), light(), LAMBDA).unwrap();
    assert!(green.front.reflection.to_matrix().amax() < 1e-15);
    assert!((green.front.transmission.to_matrix() - Matrix4::identity()).amax() < 1e-11);
    // without the films' interference: three times two faces of R = 4 %
    let dull = plate.incoherent(&at(1.0, 0.0), light(), 0.0).unwrap();
    assert!(dull.front.reflection.to_matrix()[(0, 0)] > 0.1);
}
