//! Liquid-crystal cells, as stacks of turned slices, against their closed forms.

use super::*;
use crate::stokes_vector;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A layer of director along x at the front, turned by `twist` at the back, in `slices` slices.
fn twisted(no: f64, ne: f64, wavelengths: f64, twist: f64, slices: u32) -> Vec<CrystalLayer> {
    let director = Crystal::uniaxial(no.into(), ne.into(), Vector3::x()).unwrap();
    let slices_f = f64::from(slices);
    (0..slices)
        .map(|i| {
            let angle = twist * (f64::from(i) + 0.5) / slices_f;
            layer(&director.turned(angle), wavelengths / slices_f)
        })
        .collect()
}

#[test]
fn a_twisted_nematic_cell_is_dark_at_the_minima_of_gooch_and_tarry() {
    // u = 2 d Δn/λ: between parallel polarizers T = sin²(π/2 √(1 + u²))/(1 + u²)
    let (no, ne) = (1.5, 1.51);
    for (u, expected) in [(3f64.sqrt(), 0.0), (15f64.sqrt(), 0.0), (1.0, 0.31656)] {
        let cell = twisted(no, ne, u / (2.0 * (ne - no)), FRAC_PI_2, 300);
        let t = stack(1.505, cell, 1.505).single_pass(&at(1.0, 0.0), light());
        let parallel = t.front.transmission.to_matrix()[(0, 0)].norm_sqr();
        let closed = (FRAC_PI_2 * (1.0 + u * u).sqrt()).sin().powi(2) / (1.0 + u * u);
        assert!((closed - expected).abs() < 1e-5);
        // slices: (π/2/300)²; faces: (Δn/2n)² of power
        assert!((parallel - closed).abs() < 5e-5, "{u}: {parallel} {closed}");
    }
}

#[test]
fn a_twisted_cell_has_the_jones_matrix_of_its_closed_form() {
    let (no, ne, twist, depth) = (1.5, 1.501, 1.1f64, 700.0);
    let cell = twisted(no, ne, depth, twist, 400);
    let t = stack(1.5005, cell, 1.5005).single_pass(&at(1.0, 0.0), light());
    let half = PI * depth * (ne - no);
    let x = half.hypot(twist);
    let (c, s) = (Complex64::from(x.cos()), x.sin() / x);
    // in the frame that turns with the director, slow along x
    let inner = JonesMatrix::new(
        c - I * half * s,
        (twist * s).into(),
        (-twist * s).into(),
        c + I * half * s,
    );
    let mean = (-I * TAU * depth * 0.5 * (no + ne)).exp();
    let expected = scaled(JonesMatrix::rotator(twist) * inner, mean);
    // slices: error of the order (twist/400)² · half
    assert!(distance(&t.front.transmission, &expected) < 3e-5);
}

#[test]
fn a_slowly_twisted_cell_leads_the_polarization_along() {
    // Mauguin: twist ≪ π d Δn/λ; what is left behind is (twist/half)²
    let cell = twisted(1.5, 1.6, 200.0, FRAC_PI_2, 400);
    let t = stack(1.55, cell, 1.55).single_pass(&at(1.0, 0.0), light());
    let out = t
        .front
        .transmission
        .apply(Vector2::new(Complex64::ONE, Complex64::ZERO));
    let stokes = stokes_vector(out);
    let half: f64 = PI * 200.0 * 0.1;
    let left_behind = 0.5 * (1.0 + stokes.s1() / stokes.s0());
    assert!(left_behind < (FRAC_PI_2 / half).powi(2), "{left_behind}");
    assert!(stokes.s0() > 0.99);
}

#[test]
fn a_cholesteric_mirror_reflects_the_circular_light_of_its_own_helix() {
    // director (cos qz, sin qz): a right-handed screw, as is Re (1, i) e^{−ikz}, S3 > 0; R = tanh²(πΔn L/λ)
    let (no, ne) = (1.49, 1.51);
    let pitch = 1.0 / 1.5;
    let turns = 20.0;
    let cell = twisted(no, ne, turns * pitch, TAU * turns, 20 * 60);
    let r = stack(1.5, cell, 1.5)
        .coherent(&at(1.0, 0.0), light())
        .front
        .reflection_mueller();
    let right = r * stokes::StokesVector::RIGHT_CIRCULAR;
    let left = r * stokes::StokesVector::LEFT_CIRCULAR;
    let closed = (PI * 0.02 * turns * pitch).tanh().powi(2);
    // slices: (2π/60)²/6 of the coupling; indices: Δn/n of the band's centre
    assert!(
        (right.s0() - closed).abs() < 5e-3,
        "{} {closed}",
        right.s0()
    );
    assert!(left.s0() < 1e-3);
    // an ordinary mirror would turn S3 round
    assert!(right.s3() / right.s0() > 0.99);
}
