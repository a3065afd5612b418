//! The covariant family, its dual and the whitened basis are what the paper says of them, by quadrature.
//!
//! Points and Θ are rounded to f64: in whitened coordinates that is an error of `√cond Θ · ε` for points, and
//! `cond Θ · ε` for Θ. Tolerances are multiples of it, relative to the integral of the modulus.

mod quadrature;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use proptest::prelude::*;
use quadrature::{fourier, integral, points, shape};
use stokes::{
    Family, ShapeMatrix, covariant_mode, covariant_mode_fourier, hermite, modes, whitened_mode,
};

fn mode(family: Family, n: usize, m: usize, theta: &Matrix2<f64>, x: &Vector2<f64>) -> f64 {
    covariant_mode(family, n, m, theta, x).expect("a shape matrix made from its axes")
}

/// Roundings of Θ and of a point for a product of functions up to total order 12, in ε.
fn roundings(condition: f64) -> f64 {
    64.0 * condition
}

/// Inner products of all modes up to an order, `first` with `second`, and whether they are δ.
fn assert_biorthonormal(
    l: &Matrix2<f64>,
    order: usize,
    factor: f64,
    first: impl Fn(usize, usize, &Vector2<f64>) -> f64,
    second: impl Fn(usize, usize, &Vector2<f64>) -> f64,
) {
    let (points, area) = points(l);
    let values = |of: &dyn Fn(usize, usize, &Vector2<f64>) -> f64| -> Vec<Vec<f64>> {
        modes(order)
            .map(|(n, m)| points.iter().map(|x| of(n, m, x)).collect())
            .collect()
    };
    let (first, second) = (values(&first), values(&second));
    for (i, f) in first.iter().enumerate() {
        for (j, g) in second.iter().enumerate() {
            let terms = || f.iter().zip(g).map(|(f, g)| f * g * area);
            let modulus: f64 = terms().map(f64::abs).sum();
            let found: f64 = terms().sum();
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!(
                (found - expected).abs() <= factor * f64::EPSILON * modulus,
                "{i} {j}: {found} {modulus}"
            );
        }
    }
}

#[test]
fn each_family_is_the_others_inverse_basis() {
    for (angle, scale, condition) in [(0.4, 1.0, 1.0), (0.4, 0.7, 12.0), (-1.1, 3e4, 300.0)] {
        let (l, theta) = shape(angle, scale, condition);
        assert_biorthonormal(
            &l,
            5,
            roundings(condition),
            |n, m, x| mode(Family::Covariant, n, m, &theta, x),
            |n, m, x| mode(Family::Dual, n, m, &theta, x),
        );
    }
}

#[test]
fn neither_family_is_orthogonal_by_itself() {
    let (l, theta) = shape(0.4, 1.0, 12.0);
    for family in [Family::Covariant, Family::Dual] {
        let found = integral(&l, |x| {
            (mode(family, 1, 0, &theta, x) * mode(family, 0, 1, &theta, x)).into()
        });
        // ⟨Ψ_10|Ψ_01⟩ = (Θ⁻¹)₁₂, of the dual Θ₁₂
        let sign = if family == Family::Dual { 1.0 } else { -1.0 };
        assert!(
            found.is((sign * theta.m12).into(), roundings(12.0)),
            "{found:?}"
        );
        assert!(found.value.norm() > 0.5);
    }
}

#[test]
fn the_families_are_a_fourier_pair_up_to_the_thinnest_shapes() {
    for condition in [1.0, 30.0, 1e4, 1e6] {
        let (l, theta) = shape(0.9, 1.7, condition);
        let back = l.try_inverse().expect("axes are not zero").transpose();
        for (n, m) in [(0, 0), (1, 0), (0, 1), (2, 1), (3, 3), (0, 6), (5, 2)] {
            for family in [Family::Covariant, Family::Dual] {
                let zeta = back * Vector2::new(0.8, -1.3);
                let found = fourier(&l, &zeta, |x| mode(family, n, m, &theta, x).into());
                let expected =
                    covariant_mode_fourier(family, n, m, &theta, &zeta).expect("as above");
                assert!(
                    found.is(expected, roundings(condition)),
                    "{condition} {family:?} {n} {m}: {found:?} {expected}"
                );
            }
        }
    }
}

#[test]
fn the_whitened_basis_is_orthonormal() {
    for condition in [1.0, 1e3, 1e6] {
        // a root that is neither symmetric nor of positive determinant
        let (l, _) = shape(0.9, 1.7, condition);
        let l = l * Matrix2::new(0.6, 0.8, 0.8, -0.6);
        let root =
            ShapeMatrix::from_root(&l.try_inverse().expect("axes are not zero")).expect("a root");
        // only the points are rounded here; the root is the inverse of l to ε √cond
        let modes = |a, b, x: &Vector2<f64>| whitened_mode(a, b, &root, x);
        assert_biorthonormal(&l, 8, roundings(condition.sqrt()), modes, modes);
    }
}

#[test]
fn a_whitened_mode_transforms_to_one_of_the_inverse_transposed_root() {
    for condition in [1.0, 1e3, 1e6] {
        let (l, _) = shape(-0.3, 0.2, condition);
        let l = l * Matrix2::new(0.6, 0.8, 0.8, -0.6);
        let w = l.try_inverse().expect("axes are not zero");
        let root = ShapeMatrix::from_root(&w).expect("a root");
        let zeta = w.transpose() * Vector2::new(-1.1, 0.6);
        for (a, b) in [(0, 0), (1, 0), (0, 1), (4, 1), (3, 8)] {
            let found = fourier(&l, &zeta, |x| whitened_mode(a, b, &root, x).into());
            let factor =
                2.0 * std::f64::consts::PI * Complex64::new(0.0, -1.0).powu((a + b) as u32);
            let expected = factor * whitened_mode(a, b, &root.fourier_dual(), &zeta);
            assert!(
                found.is(expected, roundings(condition.sqrt())),
                "{condition} {a} {b}: {found:?} {expected}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn parity_is_exact(
        n in 0usize..12, m in 0usize..12, angle in 0.0..3.2f64, condition in 1.0..1e8f64,
        x in -3.0..3.0f64, y in -3.0..3.0f64,
    ) {
        let (l, theta) = shape(angle, 1.0, condition);
        let x = l * Vector2::new(x, y);
        let sign = if (n + m) % 2 == 0 { 1.0 } else { -1.0 };
        for family in [Family::Covariant, Family::Dual] {
            prop_assert_eq!(mode(family, n, m, &theta, &-x), sign * mode(family, n, m, &theta, &x));
        }
    }

    #[test]
    fn parity_of_the_orthonormal_functions_is_exact(
        n in 0usize..=64, m in 0usize..=64, angle in 0.0..3.2f64, stretch in 0.0..12.0f64,
        y in prop::array::uniform2(prop_oneof![-12.0..12.0f64, -1e3..1e3f64, Just(0.0)]),
    ) {
        let sign = |order: usize| if order.is_multiple_of(2) { 1.0 } else { -1.0 };
        prop_assert_eq!(hermite(n, -y[0]), sign(n) * hermite(n, y[0]));
        let t = y[0] as f32;
        prop_assert_eq!(hermite(n, -t), sign(n) as f32 * hermite(n, t));
        // condition numbers of Θ to 1e12
        let (l, _) = shape(angle, 1.0, 10f64.powf(stretch));
        let root = ShapeMatrix::from_root(&l).expect("a root");
        let w = root.unwhiten(&y.into());
        let value = whitened_mode(n, m, &root, &w);
        prop_assert!(value.is_finite());
        prop_assert_eq!(whitened_mode(n, m, &root, &-w), sign(n + m) * value);
    }

    #[test]
    fn the_generating_functions_are_the_sums_of_their_series(
        angle in 0.0..3.2f64, condition in 1.0..100.0f64, scale in 0.1..10.0f64,
        a in prop::array::uniform2(-0.5..0.5f64), y in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let (l, theta) = shape(angle, scale, condition);
        let inverse = theta.try_inverse().expect("positive definite");
        let x = l * Vector2::from(y);
        let w = l.try_inverse().expect("axes are not zero");
        for family in [Family::Covariant, Family::Dual] {
            // |Wa| ≤ 0.71, resp. |Lᵀa|: order N contributes below 2^(N/2) 0.71^N N!^(−1/2), 1e-24 at N = 40
            let (a, exponent) = match family {
                Family::Covariant => {
                    let a = l * Vector2::from(a);
                    (a, a.dot(&(inverse * (2.0 * x - a))))
                }
                Family::Dual => {
                    let a = w.transpose() * Vector2::from(a);
                    (a, a.dot(&(2.0 * x - theta * a)))
                }
            };
            let (mut sum, mut modulus) = (0.0, 0.0);
            for (n, m) in modes(40) {
                let factorials: f64 = (1..=n).chain(1..=m).map(|i| (2.0 / i as f64).sqrt()).product();
                let term = factorials * a.x.powi(n as i32) * a.y.powi(m as i32) * mode(family, n, m, &theta, &x);
                sum += term;
                modulus += term.abs();
            }
            let norm = std::f64::consts::PI.sqrt() * theta.determinant().sqrt().sqrt();
            let expected = (exponent - 0.5 * x.dot(&(inverse * x))).exp() / norm;
            prop_assert!((sum - expected).abs() <= roundings(condition) * f64::EPSILON * modulus,
                "{:?}: {} {} of {}", family, sum, expected, modulus);
        }
    }
}
