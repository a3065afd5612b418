//! Tabulated spectra: known mixtures and power laws between the rows, rings, and tables that are refused.

use mueller16::{TableError, TabulatedSpectrum, Tolerance};
use nalgebra::Vector2;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn relative(tolerance: f64) -> Tolerance {
    Tolerance::relative(tolerance).unwrap()
}

/// n frequencies at equal ratios.
fn frequencies(first: f64, last: f64, n: usize) -> Vec<f64> {
    let step = (last / first).ln() / (n - 1) as f64;
    (0..n).map(|i| first * (step * i as f64).exp()).collect()
}

fn table(q: &[f64], f: impl Fn(f64) -> f64) -> TabulatedSpectrum {
    let values: Vec<f64> = q.iter().map(|q| f(*q)).collect();
    TabulatedSpectrum::new(q, &values).unwrap()
}

#[test]
fn a_power_law_is_met_between_its_rows_and_along_its_tail() {
    let l = 2e-6;
    for c in [1.2, 1.5, 2.5] {
        let exact = |q: f64| 1e-12 * (1.0 + l * l * q * q).powf(-c);
        let q = frequencies(1e-2 / l, 1e2 / l, 60);
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let (r, chosen) = table(&q, exact)
                .autocorrelation(relative(tolerance))
                .unwrap();
            assert!(chosen.error <= tolerance && r.is_positive(), "{chosen:?}");
            for pair in q.windows(2) {
                let at = (pair[0] * pair[1]).sqrt();
                let error = r.spectrum(&Vector2::new(0.0, at)) - exact(at);
                // rows are weighted by 1/(value + tolerance · peak), and the rows are three to a Gaussian's width
                let scale = exact(at) + tolerance * 1e-12;
                assert!(
                    error.abs() <= 3.0 * tolerance.max(chosen.error) * 1e-12,
                    "{c} {at} {error}"
                );
                assert!(error.abs() <= 0.3 * scale, "{c} {at} {error} {}", exact(at));
            }
        }
    }
}

#[test]
fn the_power_is_the_integral_of_the_table_or_what_is_given() {
    // e^(−q²/2) of 1 rad/m, to 8 rad/m: R(0) = (2π)⁻² 2π
    let q: Vec<f64> = (0..81).map(|i| 0.1 * f64::from(i)).collect();
    let spectrum = table(&q, |q| 3.0 * (-0.5 * q * q).exp());
    let (r, chosen) = spectrum.autocorrelation(relative(1e-3)).unwrap();
    assert!(
        (r.at_zero() / (3.0 / TAU) - 1.0).abs() < 1e-2,
        "{} {chosen:?}",
        r.at_zero()
    );
    // R = (3/2π) e^(−x²/2): a lobe's error of 1e-3 within its widths is one of about 1e-3 in R
    for x in [0.5, 1.0, 2.0] {
        let error = r.value(&Vector2::new(x, 0.0)).re - 3.0 / TAU * (-0.5 * x * x).exp();
        assert!(error.abs() < 5e-3 * 3.0 / TAU, "{x}: {error}");
    }
    let (unit, _) = spectrum
        .with_power(1.0)
        .unwrap()
        .autocorrelation(relative(1e-3))
        .unwrap();
    assert!((unit.at_zero() - 1.0).abs() < 1e-14);
}

#[test]
fn a_ring_is_made_of_gaussians_on_a_circle() {
    // speckle of an annular pupil: nothing at the centre, the most at 30 rad/mm
    let ring = |q: f64| 1e-9 * (-0.5 * ((q - 3e4) / 6e3_f64).powi(2)).exp();
    let q: Vec<f64> = (0..60).map(|i| 1e3 * f64::from(i)).collect();
    let (r, chosen) = table(&q, ring).autocorrelation(relative(0.03)).unwrap();
    assert!(
        chosen.error <= 0.03 && r.is_positive() && chosen.terms > 10,
        "{chosen:?}"
    );
    for at in [0.0, 1.55e4, 3.05e4, 4e4] {
        for angle in [0.0, 0.1, 1.0, 2.3] {
            let place = Vector2::new(f64::cos(angle), f64::sin(angle)) * at;
            let error = (r.spectrum(&place) - ring(at)) / 1e-9;
            assert!(error.abs() < 0.045, "{at} {angle}: {error} {chosen:?}");
        }
    }
    // R is real and even, and changes its sign as J₀ does
    let value = r.value(&Vector2::new(3.8 / 3e4, 0.0));
    assert!(value.re < 0.0 && value.im.abs() < 1e-12 * r.at_zero());
}

#[test]
fn a_spike_between_rows_is_refused_with_its_place() {
    let mut values = vec![1.0; 40];
    values[25] = 40.0;
    let q: Vec<f64> = (0..40).map(|i| 10.0 + f64::from(i)).collect();
    let spectrum = TabulatedSpectrum::new(&q, &values).unwrap();
    match spectrum.autocorrelation(relative(1e-3)) {
        Err(
            error @ TableError::Misfit {
                error: misfit,
                tolerance,
                ..
            },
        ) => {
            assert!(misfit > 0.01 && tolerance == 1e-3);
            let text = error.to_string();
            assert!(
                text.contains("rad/m") && text.contains("expected at most 0.001"),
                "{text}"
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_tables_are_named_by_their_rows() {
    let new = TabulatedSpectrum::new;
    let text = |error: Result<TabulatedSpectrum, TableError>| error.unwrap_err().to_string();
    assert!(text(new(&[1.0], &[1.0])).contains("1 frequencies and 1 values"));
    assert!(text(new(&[1.0, 2.0], &[1.0])).contains("2 frequencies and 1 values"));
    assert!(text(new(&[1.0, 3.0, 2.0], &[1.0; 3])).contains("row 2 is 2 rad/m after 3"));
    assert!(text(new(&[1.0, 1.0], &[1.0; 2])).contains("row 1"));
    assert!(text(new(&[-1.0, 1.0], &[1.0; 2])).contains("row 0 is -1"));
    assert!(text(new(&[1.0, f64::NAN], &[1.0; 2])).contains("row 1 is NaN"));
    assert!(text(new(&[1.0, f64::INFINITY], &[1.0; 2])).contains("row 1 is inf"));
    assert!(text(new(&[1.0, 2.0], &[1.0, -0.5])).contains("row 1 is -0.5"));
    assert!(text(new(&[1.0, 2.0], &[f64::NAN, 0.5])).contains("row 0 is NaN"));
    assert!(text(new(&[1.0, 2.0], &[0.0, 0.0])).contains("not 0 everywhere"));
    let good = new(&[1.0, 2.0], &[1.0, 0.5]).unwrap();
    assert!(text(good.with_power(0.0)).contains("power asked for is 0"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn planted_gaussians_are_found(
        weights in prop::collection::vec(0.01..1.0f64, 4),
        exponents in prop::collection::vec(-3.0..3.0f64, 4),
        scale in -6.0..6.0f64,
    ) {
        let scale = 10f64.powf(scale);
        let ts: Vec<f64> = exponents.iter().map(|e| e.exp() / (scale * scale)).collect();
        let exact = |q: f64| -> f64 { ts.iter().zip(&weights).map(|(t, w)| w * (-t * q * q).exp()).sum() };
        let q = frequencies(0.01 * scale, 30.0 * scale, 80);
        let (r, chosen) = table(&q, exact).autocorrelation(relative(3e-3)).unwrap();
        prop_assert!(chosen.error <= 3e-3 && r.is_positive());
        // R = Σ w/(4πt) e^(−x²/4t) where the widest part is
        let total: f64 = ts.iter().zip(&weights).map(|(t, w)| w / (4.0 * PI * t)).sum();
        // errors e of the rows, times the area (30 scale)²/4π, and beyond it the widest lobe, t = 0.05/(30 scale)²: 1.05 e/0.05
        let heights: f64 = weights.iter().sum();
        let allowed = 22.0 * chosen.error * heights * 900.0 / (4.0 * PI);
        let error = (r.at_zero() - total) / (scale * scale);
        prop_assert!(error.abs() <= allowed, "{} {}", error, allowed);
    }
}
