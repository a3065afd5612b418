//! What is printed in section S4 of the supplemental and does not hold of fields, next to what does. The cone below
//! (S4.6), (S4.4), (S4.9) and the count below (S4.12) have theirs where the quantities live: `positivity.rs`,
//! `coherence.rs` and `sixteen.rs`.

use csdm::film::Stack;
use csdm::{CrossSpectralDensity, Element, GeneralizedMueller, PhaseScreen};
use nalgebra::Vector2;
use num_complex::Complex64;
use stokes::Wavelength;

/// The complex amplitude A of a real oscillation `Re[A e^{i sense t}]`.
fn amplitude(real: impl Fn(f64) -> f64, sense: f64) -> Complex64 {
    let steps = 64;
    let at = |i: i32| f64::from(i) / f64::from(steps) * std::f64::consts::TAU;
    let terms = (0..steps).map(|i| Complex64::cis(-sense * at(i)) * real(at(i)));
    terms.sum::<Complex64>() * (2.0 / f64::from(steps))
}

#[test]
fn the_third_parameter_of_eqs_s4_5_and_s4_6_is_that_of_optics_only_in_exp_plus_i_omega_t() {
    // clockwise for a receiver with x to the right and y up: "right-handed", S3 > 0
    let (x, y) = (f64::cos, |t: f64| -t.sin());
    let c3 = |sense: f64| {
        let field = Vector2::new(amplitude(x, sense), amplitude(y, sense));
        CrossSpectralDensity::of_fields(field, field).generalized_stokes()[3]
    };
    assert!((c3(1.0) - 2.0).norm() < 1e-14);
    // the time factor of the supplemental, e^{−iωt} of its e^{+ikr}, gives the other hand
    assert!((c3(-1.0) + 2.0).norm() < 1e-14);
}

#[test]
fn the_sixteen_of_theorem_s4_1_are_mutual_intensities_and_not_squares_of_amplitudes() {
    // Σ^(j→l) = ⟨σ σ*⟩ of one scattering amplitude σ^(j→l) would be positive where the points are one
    let light = Wavelength::from_metres(550e-9).unwrap();
    let glass = Stack::new(1.0, vec![], 1.5.into()).unwrap();
    let mirror = glass.amplitudes(0.5f64.sqrt(), light).reflection();
    let sigma = GeneralizedMueller::of_jones(&mirror, &mirror).scattering();
    assert!((sigma[(2, 2)].re + 0.027_911_1).abs() < 1e-7 && sigma[(2, 2)].im == 0.0);
    // nor does |Σ| ≤ Σ between two points follow for any of the sixteen: |M01(r, r')| > M01(r, r) = 0
    let screen = PhaseScreen::independent([1.0, 1.0], [1e-4, 2e-4]).unwrap();
    let (a, b) = (Vector2::zeros(), Vector2::new(1e-4, 0.0));
    assert!(screen.mueller_at(&a).element(0, 1).abs() < 1e-16);
    let between = screen.generalized_mueller(&a, &b).scattering();
    assert!(between[(0, 1)].norm() > 0.1);
}
