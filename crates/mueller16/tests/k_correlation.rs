//! K-correlation autocorrelations against their closed forms: lobes to the far tail, Bessel functions by quadrature.

use mueller16::{Autocorrelation, AutocorrelationError, KCorrelation, Tolerance};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

const TOLERANCES: [f64; 4] = [1e-2, 1e-4, 1e-8, 1e-12];

fn relative(tolerance: f64) -> Tolerance {
    Tolerance::relative(tolerance).unwrap()
}

/// `K_ν(z) = ∫₀^∞ e^(−z cosh θ) cosh νθ dθ` by the trapezoidal rule, whose error at step 1/32 is `e^(−2π·1.5·32)`.
fn bessel_k(nu: f64, z: f64) -> f64 {
    let h = 1.0 / 32.0;
    let term = |k: i32| {
        let theta = h * f64::from(k);
        (-z * theta.cosh()).exp() * (nu * theta).cosh()
    };
    h * (0.5 * term(0) + (1..2000).map(term).take_while(|t| *t > 0.0).sum::<f64>())
}

/// `R_K(u)/R_K(0)` times a constant: `u^(c−1) K_(c−1)(u)`.
fn matern(c: f64, u: f64) -> f64 {
    u.powf(c - 1.0) * bessel_k(c - 1.0, u)
}

fn along(r: &Autocorrelation, root: &Matrix2<f64>, u: f64) -> f64 {
    // |D⁻ᵀx| = u
    let x = root.transpose() * Vector2::new(0.6, 0.8) * u;
    r.value(&x).re
}

fn roots() -> [Matrix2<f64>; 3] {
    [
        Matrix2::from_diagonal_element(3e-6),
        Matrix2::new(2e-6, 1e-6, -4e-7, 9e-6),
        Matrix2::new(0.0, 1e-3, 1e-8, 0.0),
    ]
}

#[test]
fn the_bessel_function_of_these_tests_is_that_of_the_books() {
    // K_{1/2}(z) = √(π/2z) e^(−z); Abramowitz & Stegun, table 9.8: K₀(1) = 0.42102 44382, K₁(1) = 0.60190 72302
    assert!((bessel_k(0.5, 2.0) - (PI / 4.0).sqrt() * (-2f64).exp()).abs() < 1e-15);
    assert!((bessel_k(0.0, 1.0) - 0.421_024_438_2).abs() < 1e-10);
    assert!((bessel_k(1.0, 1.0) - 0.601_907_230_2).abs() < 1e-10);
}

#[test]
fn the_lobe_is_the_power_law_to_a_hundred_inverse_lengths() {
    for root in roots() {
        let area = root.determinant().abs();
        let inverse = root.try_inverse().unwrap();
        for c in [1.01, 1.1, 1.5, 2.0, 2.5, 4.0, 20.0, 100.0] {
            let spectrum = KCorrelation::new(&root, c).unwrap();
            for tolerance in TOLERANCES {
                let (r, chosen) = spectrum.autocorrelation(relative(tolerance)).unwrap();
                assert!(chosen.error <= tolerance, "{chosen:?}");
                for q in [0.0, 0.01, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0] {
                    let at = inverse * Vector2::new(0.6, 0.8) * q;
                    let power = (1.0 + q * q).powf(-c);
                    if power < 1e-250 {
                        continue;
                    }
                    let expected = 4.0 * PI * area * (c - 1.0) * power;
                    let error = r.spectrum(&at) / expected - 1.0;
                    // and the roundings of the exponents of a hundred terms of one sign
                    let rounding = 1e-13 * c;
                    assert!(
                        error.abs() <= chosen.error + rounding,
                        "c {c} tolerance {tolerance} q {q}: {error} {chosen:?}"
                    );
                }
                assert!((r.at_zero() - 1.0).abs() < 1e-14 && r.is_positive());
            }
        }
    }
}

#[test]
fn the_value_is_materns() {
    let root = roots()[1];
    for c in [1.25, 1.5, 2.0, 2.5, 7.0] {
        let spectrum = KCorrelation::new(&root, c).unwrap();
        let (r, _) = spectrum.autocorrelation(relative(1e-12)).unwrap();
        // Γ(c−1) 2^(c−2), by the limit at 0 of the same quadrature: 1 − O(u^min(2, 2c−2))
        let at_zero = libm::tgamma(c - 1.0) * (c - 2.0).exp2();
        for u in [0.05, 0.3, 1.0, 3.0, 10.0] {
            let expected = matern(c, u) / at_zero;
            let error = along(&r, &root, u) - expected;
            // what is narrower than the last node is far below u = 0.05
            assert!(error.abs() < 1e-11, "{c} {u}: {error}");
        }
    }
}

#[test]
fn an_exponent_of_three_halves_is_the_exponential() {
    let root = roots()[0];
    let (r, _) = KCorrelation::exponential(&root)
        .unwrap()
        .autocorrelation(relative(1e-12))
        .unwrap();
    for u in [0.01, 0.1, 1.0, 5.0, 20.0] {
        assert!((along(&r, &root, u) - (-u).exp()).abs() < 1e-12, "{u}");
    }
}

#[test]
fn an_inner_scale_is_a_hyperbola_of_the_separation() {
    let root = roots()[1];
    for (c, b) in [
        (0.3, 0.1),
        (0.75, 0.01),
        (1.0, 1e-4),
        (1.5, 1.0),
        (2.5, 0.05),
        (0.05, 0.5),
    ] {
        let spectrum = KCorrelation::with_inner_scale(&root, c, b).unwrap();
        for tolerance in TOLERANCES {
            let (r, chosen) = spectrum.autocorrelation(relative(tolerance)).unwrap();
            assert!(chosen.error <= tolerance, "{chosen:?}");
            assert!((r.at_zero() - 1.0).abs() < 1e-14 && r.is_positive());
            for q in [0.0, 0.1, 1.0, 10.0, 100.0] {
                let z = b * f64::hypot(1.0, q);
                if z > 10.0 {
                    continue;
                }
                // ∫ t^(c−1) e^(−t(1+Q²)−b²/4t) dt = 2 (b/2√(1+Q²))^c K_c(z), and the same of c − 1 at Q = 0
                let lobe = (b / 2.0 / f64::hypot(1.0, q)).powf(c) * bessel_k(c, z);
                let whole = (b / 2.0).powf(c - 1.0) * bessel_k(c - 1.0, b);
                let expected = 4.0 * PI * root.determinant().abs() * lobe / whole;
                let at = root.try_inverse().unwrap() * Vector2::new(-0.8, 0.6) * q;
                let error = r.spectrum(&at) / expected - 1.0;
                assert!(
                    error.abs() <= chosen.error + 1e-12,
                    "c {c} b {b} q {q}: {error} {chosen:?}"
                );
            }
        }
        // with a reach beyond 1/b what is narrower than the last node has less than e^(−b²/4t) ≤ 1e-12 of the weight
        let spectrum = spectrum.with_reach(1e6).unwrap();
        let (r, _) = spectrum.autocorrelation(relative(1e-12)).unwrap();
        for u in [0.0, 0.3 * b, b, 1.0, 4.0] {
            let expected = matern(c, f64::hypot(u, b)) / matern(c, b);
            let error = along(&r, &root, u) - expected;
            assert!(error.abs() < 1e-11, "c {c} b {b} u {u}: {error}");
        }
    }
}

#[test]
fn a_shorter_reach_and_a_larger_tolerance_take_fewer_gaussians() {
    let spectrum = KCorrelation::exponential(&roots()[0]).unwrap();
    let count = |reach: f64, tolerance: f64| {
        let spectrum = spectrum.with_reach(reach).unwrap();
        let (_, chosen) = spectrum.autocorrelation(relative(tolerance)).unwrap();
        chosen.terms
    };
    assert!(count(10.0, 1e-4) < count(100.0, 1e-4));
    assert!(count(100.0, 1e-4) < count(1e6, 1e-4));
    assert!(count(100.0, 1e-3) < count(100.0, 1e-6));
    assert!(count(100.0, 1e-3) <= 24, "{}", count(100.0, 1e-3));
}

#[test]
fn the_tail_of_a_long_reach_is_held_too() {
    let root = roots()[0];
    let spectrum = KCorrelation::new(&root, 1.75)
        .unwrap()
        .with_reach(1e6)
        .unwrap();
    let (r, chosen) = spectrum.autocorrelation(relative(1e-6)).unwrap();
    for q in [1e3_f64, 1e5, 1e6] {
        let expected = 2.0 * TAU * 9e-12 * 0.75 * (1.0 + q * q).powf(-1.75);
        let error = r.spectrum(&Vector2::new(q / 3e-6, 0.0)) / expected - 1.0;
        assert!(error.abs() <= chosen.error, "{q}: {error}");
    }
}

#[test]
fn numbers_out_of_their_range_are_named() {
    let root = roots()[0];
    let text = KCorrelation::new(&root, 0.9).unwrap_err().to_string();
    assert!(
        text.contains("exponent is 0.9") && text.contains("inner scale"),
        "{text}"
    );
    for c in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        assert!(KCorrelation::new(&root, c).is_err());
        assert!(KCorrelation::with_inner_scale(&root, c, 0.1).is_err());
        assert!(KCorrelation::with_inner_scale(&root, 0.5, c).is_err());
        assert!(
            c == 0.0
                || KCorrelation::exponential(&root)
                    .unwrap()
                    .with_reach(c)
                    .is_err()
        );
    }
    assert!(matches!(
        KCorrelation::exponential(&Matrix2::zeros()),
        Err(AutocorrelationError::Shape(_))
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn every_spectrum_keeps_its_bound(
        c in prop_oneof![1.01..1.1f64, 1.1..3.0f64, 3.0..100.0f64],
        exponent in -14.0..-0.4f64,
        q in prop_oneof![Just(0.0), 0.0..1.0f64, 1.0..100.0f64],
    ) {
        let root = Matrix2::from_diagonal_element(1.0);
        let tolerance = 10f64.powf(exponent);
        let (r, chosen) = KCorrelation::new(&root, c).unwrap().autocorrelation(relative(tolerance)).unwrap();
        let expected = 4.0 * PI * (c - 1.0) * (1.0 + q * q).powf(-c);
        let error = r.spectrum(&Vector2::new(q, 0.0)) / expected - 1.0;
        prop_assert!(chosen.error <= tolerance);
        prop_assume!((1.0 + q * q).powf(-c) > 1e-250);
        prop_assert!(error.abs() <= chosen.error + 1e-13 * c, "{} {:?}", error, chosen);
        prop_assert!((r.at_zero() - 1.0).abs() < 1e-14);
    }
}
