//! Coefficients over the covariant family and over the whitened basis describe one function.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{Family, HermiteSeries, SeriesError, ShapeMatrix, covariant_mode, mode_count, modes};

fn shape(entries: [f64; 4], size: f64) -> ShapeMatrix {
    let [a, b, c, d] = entries;
    let root = Matrix2::new(1.0 + 0.3 * a, 0.4 * b, 0.4 * c, 1.0 + 0.3 * d) * size;
    ShapeMatrix::from_root(&root).expect("a root near the identity")
}

/// Hermitian coefficients: even orders real, odd ones imaginary.
fn hermitian(real: &[f64], order: usize, size: f64) -> Vec<Complex64> {
    modes(order)
        .zip(real)
        .map(|((a, b), s)| {
            // in the unit that order n has for a footprint of that size
            s / size.powi((a + b) as i32) * Complex64::i().powu((a + b) as u32)
        })
        .collect()
}

proptest! {
    #[test]
    fn both_series_are_one_function(
        entries in prop::array::uniform4(-1.0..1.0f64), exponent in -8..8i32,
        real in prop::collection::vec(-1.0..1.0f64, mode_count(6)), y in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let size = 10f64.powi(exponent);
        let shape = shape(entries, size);
        let coefficients = hermitian(&real, 6, size);
        let series = HermiteSeries::from_covariant(&shape, &coefficients).unwrap();
        let w = shape.unwhiten(&Vector2::from(y));
        let (mut sum, mut modulus) = (Complex64::ZERO, 0.0);
        for ((n, m), c) in modes(6).zip(&coefficients) {
            let term = c * covariant_mode(Family::Covariant, n, m, &shape.theta(), &w).unwrap();
            sum += term;
            modulus += term.norm();
        }
        // the roundings of Θ (condition number below 30) for the left side, those of Sym(W) for the right one
        let difference = (series.value(&shape, &w) - sum).norm();
        let whitened = series.norm() * shape.root_determinant().sqrt();
        prop_assert!(difference <= 64.0 * 30.0 * f64::EPSILON * (modulus + whitened), "{difference} {modulus}");
    }

    #[test]
    fn there_and_back_leaves_the_coefficients(
        entries in prop::array::uniform4(-1.0..1.0f64), exponent in -60..60i32,
        real in prop::collection::vec(-1.0..1.0f64, mode_count(5)),
    ) {
        let size = 10f64.powi(exponent);
        let shape = shape(entries, size);
        let series = HermiteSeries::from_real_coefficients(&real).unwrap();
        let there = series.to_covariant(&shape);
        // 1e60⁵ is 1e300; 5 more orders of magnitude are for the factors of W⁻¹
        let back = HermiteSeries::from_covariant(&shape, &there).unwrap();
        for (n, m) in modes(5) {
            let error = (back.real_coefficient(n, m) - series.real_coefficient(n, m)).abs();
            // cond(W) is below 6
            prop_assert!(error <= 8.0 * 6.0 * f64::EPSILON * 6f64.powi((n + m) as i32), "{n} {m}: {error}");
        }
    }
}

#[test]
fn covariant_coefficients_are_projections_on_the_dual() {
    let shape = shape([0.4, -0.9, 0.2, 0.7], 1.3);
    let real = [1.0, 0.4, -0.2, 0.1, 0.05, -0.15, 0.02, 0.06, -0.03, 0.01];
    let series = HermiteSeries::from_real_coefficients(&real).unwrap();
    let found = series.to_covariant(&shape);
    // trapezoidal rule in whitened coordinates, exact to rounding
    let step = 0.25;
    let theta = shape.theta();
    for ((n, m), found) in modes(3).zip(found) {
        let (mut sum, mut modulus) = (Complex64::ZERO, 0.0);
        for i in -40..=40 {
            for j in -40..=40 {
                let w = shape.unwhiten(&(Vector2::new(f64::from(i), f64::from(j)) * step));
                let dual = covariant_mode(Family::Dual, n, m, &theta, &w).unwrap();
                let term = series.value(&shape, &w) * dual * step * step / shape.root_determinant();
                sum += term;
                modulus += term.norm();
            }
        }
        assert!(
            (sum - found).norm() < 256.0 * f64::EPSILON * modulus,
            "{n} {m}: {sum} {found}"
        );
    }
}

#[test]
fn what_is_no_series_is_refused() {
    let shape = ShapeMatrix::isotropic(1.0).unwrap();
    let one = Complex64::ONE;
    assert_eq!(
        HermiteSeries::from_covariant(&shape, &[one, one]),
        Err(SeriesError::Count { found: 2 })
    );
    assert!(matches!(
        HermiteSeries::from_covariant(&shape, &[one, one, one]),
        Err(SeriesError::NotHermitian { a: 1, b: 0, .. })
    ));
    // what overflows is named by its mode: Θ⁻¹ = 1e40, so that order 2 is multiplied by 1e40
    let wide = ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e20)).unwrap();
    let zero = Complex64::ZERO;
    let huge = [one, zero, zero, zero, (1e290).into(), zero];
    assert!(matches!(
        HermiteSeries::from_covariant(&wide, &huge),
        Err(SeriesError::NotFinite { a: 1, b: 1, .. })
    ));
    // and the other way round it is infinite, not nonsense
    let thin = ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-60)).unwrap();
    let mut real = vec![0.0; mode_count(6)];
    real[stokes::mode_index(6, 0)] = 1.0;
    let found = HermiteSeries::from_real_coefficients(&real)
        .unwrap()
        .to_covariant(&thin);
    assert_eq!(found[stokes::mode_index(6, 0)].re, f64::NEG_INFINITY);
    assert_eq!(found[stokes::mode_index(5, 1)].re, 0.0);
}
