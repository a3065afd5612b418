//! Autocorrelations of gratings: which orders they hold, what they leave out, and their lobes.

use std::f64::consts::{PI, TAU};

use mueller16::{Blaze, Grating, Profile, Relief, Tolerance};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

const DEPTH: f64 = 2e-7;

#[test]
fn fewer_orders_are_kept_for_less_accuracy_and_within_a_reach() {
    let terms = |grating: &Grating, tolerance: f64| {
        let tolerance = Tolerance::relative(tolerance).unwrap();
        let (_, chosen) = grating.autocorrelation(2e7, tolerance).unwrap();
        (chosen.terms, chosen.error)
    };
    let smooth = Grating::lines(2e-6, Vector2::x(), Profile::sinusoidal(DEPTH).unwrap()).unwrap();
    let mut before = 1;
    for tolerance in [0.1, 1e-3, 1e-6, 1e-9, 1e-12] {
        let (now, error) = terms(&smooth, tolerance);
        assert!(
            now > before && error <= tolerance,
            "{tolerance} {now} {error}"
        );
        before = now;
    }
    assert!(before < 25);
    // steps: shares fall as 1/q², and what 10,000 orders do not hold is said, 8 sin²(ψ/2)/(π² Q) less the even orders
    let steep = Grating::lines(2e-6, Vector2::x(), Profile::lamellar(DEPTH, 0.5).unwrap()).unwrap();
    let (_, error) = terms(&steep, 1e-9);
    let largest = 4.0 / (PI * PI) * (0.5 * 2e7 * DEPTH).sin().powi(2);
    let expected = 4.0 * (0.5 * 2e7 * DEPTH).sin().powi(2) / (PI * PI * 1e4) / largest;
    assert!((error / expected - 1.0).abs() < 1e-3, "{error} {expected}");
    // no two directions in air are further apart than 2k: orders to ±7 in green light
    let near = steep.within_reach(2.0 * TAU / 550e-9).unwrap();
    let (now, error) = terms(&near, 1e-9);
    assert!(now <= 15 && error <= 1e-9);
}

#[test]
fn crossed_lines_are_products_and_the_same_as_a_sampled_cell() {
    let n = 32;
    let sine = |i: usize, depth: f64| 0.5 * depth * (TAU * i as f64 / n as f64).cos();
    let heights = (0..n * n)
        .map(|at| sine(at % n, 1e-7) + sine(at / n, 6e-8))
        .collect();
    let first = Vector2::new(0.6, 0.8);
    let pitches = [2e-6, 3e-6];
    let sampled = Grating::sampled_cells(pitches, first, heights, n).unwrap();
    let profiles = [1e-7, 6e-8].map(|d| Profile::sinusoidal(d).unwrap());
    let crossed = Grating::crossed(pitches, first, profiles).unwrap();
    let phi_z = 2.3e7;
    for order in [[0, 0], [1, 0], [0, 1], [-1, 2], [3, -2], [2, 2]] {
        let expected = crossed.amplitude(phi_z, order);
        let product =
            libm::jn(order[0], 0.5 * phi_z * 1e-7) * libm::jn(order[1], 0.5 * phi_z * 6e-8);
        assert!((expected.norm() - product.abs()).abs() < 1e-15);
        // aliases J_29(1.2) are below 1e-37
        let found = sampled.amplitude(phi_z, order);
        assert!((found - expected).norm() < 1e-15, "{order:?}");
        let along = first * (TAU / 2e-6) * f64::from(order[0]);
        let across = Vector2::new(-0.8, 0.6) * (TAU / 3e-6) * f64::from(order[1]);
        assert!((crossed.shift(order) - along - across).norm() < 1e-8);
    }
    let tolerance = Tolerance::relative(1e-9).unwrap();
    let (a, chosen) = crossed.autocorrelation(phi_z, tolerance).unwrap();
    let (b, _) = sampled.autocorrelation(phi_z, tolerance).unwrap();
    assert!(chosen.error <= 1e-9 && (a.at_zero() - 1.0).abs() < 1e-9);
    for x in [Vector2::new(3e-7, -8e-7), Vector2::new(-1e-6, 2e-7)] {
        assert!((a.value(&x) - b.value(&x)).norm() < 2e-9);
    }
}

#[test]
fn the_autocorrelation_of_a_blaze_is_complex_and_that_of_its_definition() {
    // ⟨e^(−iφ_z (h(x') − h(x' − x)))⟩: over the pitch the step is met once, shares 1 − u and u of the period
    let (pitch, phi_z) = (2e-6, 3.1e7);
    let psi = phi_z * DEPTH;
    let profile = Profile::blazed(DEPTH, Blaze::Rising).unwrap();
    let grating = Grating::lines(pitch, Vector2::x(), profile).unwrap();
    let tolerance = Tolerance::relative(1e-3).unwrap();
    let (r, chosen) = grating.autocorrelation(phi_z, tolerance).unwrap();
    for u in [0.1, 0.25, 0.6, 0.8] {
        let expected = Complex64::cis(-psi * u) * (1.0 - u) + Complex64::cis(psi * (1.0 - u)) * u;
        let found = r.value(&Vector2::new(u * pitch, 0.0));
        assert!(
            (found - expected).norm() <= chosen.error,
            "{u}: {found} {expected}"
        );
        assert!(expected.im.abs() > 0.05, "{expected}");
    }
}

#[test]
fn a_finite_gratings_lobes_have_the_orders_areas() {
    let (pitch, phi_z, size) = (2e-6, 2e7, 20e-6);
    let profile = Profile::triangular(DEPTH, 0.8).unwrap();
    let across = Vector2::new(0.8, -0.6);
    let covariance = Matrix2::new(size * size, 0.0, 0.0, 4.0 * size * size);
    let grating = Grating::lines(pitch, across, profile.clone())
        .unwrap()
        .through_aperture(&covariance)
        .unwrap();
    let (r, _) = grating
        .autocorrelation(phi_z, Tolerance::relative(1e-6).unwrap())
        .unwrap();
    assert_eq!(r.delta_weight(), 0.0);
    for q in -3..=3 {
        // trapezoidal sum over ±8 deviations 1/size, 1/(2 size): exact to e^(−2π²·16/… ) and the lobe's tail e^(−32)
        let (n, half) = (64, 8.0);
        let step = 2.0 * half / f64::from(n);
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let at = Vector2::new(
                    f64::from(i) * step - half,
                    (f64::from(j) * step - half) / 2.0,
                );
                sum += r.spectrum(&(grating.shift([q, 0]) + at / size));
            }
        }
        let area = sum * step * step / (2.0 * size * size) / (TAU * TAU);
        let expected = profile.amplitude(phi_z, q).norm_sqr();
        assert!((area - expected).abs() < 1e-12, "{q}: {area} {expected}");
    }
}
