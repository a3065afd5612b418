//! Section S1: norms, transforms and special values of the functions, and the factors of S2.6 and S2.8.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{Family, covariant_mode, covariant_mode_at_zero};

use crate::quadrature::{fourier, integral, shape};
use crate::{far_apart, turn};

/// Roundings in ε for the shapes used here, of condition number 5 and less.
const ROUNDINGS: f64 = 256.0;

fn psi(family: Family, n: usize, m: usize, theta: &Matrix2<f64>, x: &Vector2<f64>) -> f64 {
    covariant_mode(family, n, m, theta, x).expect("a shape matrix made from its axes")
}

/// The generating function (S1.2) without its constant, `e^(−xᵀΘ⁻¹x/2 + aᵀΘ⁻¹(2x − a))`.
fn generating(inverse: &Matrix2<f64>, a: &Vector2<f64>, x: &Vector2<f64>) -> f64 {
    (-0.5 * x.dot(&(inverse * x)) + a.dot(&(inverse * (2.0 * x - a)))).exp()
}

#[test]
fn s1_2_s1_3_and_s2_10_have_norm_1_only_with_the_constant_of_two_dimensions() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let inverse = theta.try_inverse().unwrap();
    let square = |constant: f64| {
        integral(&l, |x| {
            (generating(&inverse, &Vector2::zeros(), x) / constant)
                .powi(2)
                .into()
        })
    };
    let det = theta.determinant();
    let corrected = (PI.powi(2) * det).powf(0.25);
    let printed = (PI.powi(3) * det).powf(0.25);
    assert!(square(corrected).is(1.0.into(), ROUNDINGS));
    assert!(far_apart(1.0.into(), square(printed).value));
    let x = Vector2::new(0.3, -0.8);
    let found = psi(Family::Covariant, 0, 0, &theta, &x);
    let expected = generating(&inverse, &Vector2::zeros(), &x) / corrected;
    assert!((found / expected - 1.0).abs() < ROUNDINGS * f64::EPSILON);
}

#[test]
fn s1_5_the_second_line_takes_the_root_of_theta_not_that_of_its_determinant() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let inverse = theta.try_inverse().unwrap();
    let (a, zeta) = (Vector2::new(0.35, -0.2), Vector2::new(0.7, 0.45));
    let det = theta.determinant();
    let left = fourier(&l, &zeta, |x| {
        (generating(&inverse, &a, x) / (PI.powi(2) * det).powf(0.25)).into()
    });
    // the symmetric root of Θ = R D Rᵀ
    let stretch = turn(-0.4) * l;
    let root = turn(0.4) * Matrix2::from_diagonal(&stretch.diagonal()) * turn(-0.4);
    assert!((root * root - theta).amax() < ROUNDINGS * f64::EPSILON);
    let beta = root.try_inverse().unwrap() * a;
    let right = |z: &Vector2<f64>| {
        let inner = fourier(&Matrix2::identity(), z, |s| {
            (-0.5 * s.norm_squared() + 2.0 * beta.dot(s) - beta.norm_squared())
                .exp()
                .into()
        });
        (det / PI.powi(2)).powf(0.25) * inner.value
    };
    assert!(left.is(right(&(root * zeta)), ROUNDINGS));
    assert!(far_apart(left.value, right(&(det.sqrt() * zeta))));
}

#[test]
fn s1_5_the_third_line_subtracts_the_square_of_the_turned_argument() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let inverse = theta.try_inverse().unwrap();
    let (a, zeta) = (Vector2::new(0.35, -0.2), Vector2::new(0.7, 0.45));
    let det = theta.determinant();
    let left = fourier(&l, &zeta, |x| {
        (generating(&inverse, &a, x) / (PI.powi(2) * det).powf(0.25)).into()
    });
    // (−ia)ᵀΘ⁻¹(−ia) = −aᵀΘ⁻¹a
    let square = -a.dot(&(inverse * a));
    let third = |sign: f64| {
        let exponent = Complex64::new(
            -0.5 * zeta.dot(&(theta * zeta)) + sign * square,
            -2.0 * a.dot(&zeta),
        );
        2.0 * PI.sqrt() * det.powf(0.25) * exponent.exp()
    };
    assert!(left.is(third(-1.0), ROUNDINGS));
    assert!(far_apart(left.value, third(1.0)));
}

#[test]
fn covariant_functions_are_eigenfunctions_of_the_transform_only_for_round_shapes_of_unit_width() {
    let factor = 2.0 * PI * Complex64::new(0.0, -1.0).powu(3);
    let zeta = Vector2::new(0.7, 0.45);
    for (scale, condition) in [(1.0, 1.0), (1.3, 1.0), (1.3, 5.0)] {
        let (l, theta) = shape(0.4, scale, condition);
        let transform = fourier(&l, &zeta, |x| {
            psi(Family::Covariant, 2, 1, &theta, x).into()
        });
        // what the text after (S1.6) says, and what (S1.6) itself says
        let text = factor * psi(Family::Covariant, 2, 1, &theta, &zeta);
        let inverse = theta.try_inverse().unwrap();
        let inverse = Matrix2::new(inverse.m11, inverse.m12, inverse.m12, inverse.m22);
        let formula = factor * psi(Family::Dual, 2, 1, &inverse, &zeta);
        assert!(transform.is(formula, ROUNDINGS));
        if (scale, condition) == (1.0, 1.0) {
            assert!(transform.is(text, ROUNDINGS));
        } else {
            assert!(far_apart(transform.value, text), "{scale} {condition}");
        }
    }
}

/// The sum of (S1.7) over the matrices whose columns the rule admits.
fn sum_at_zero(n: usize, m: usize, q: &Matrix2<f64>, admits: impl Fn(usize, usize) -> bool) -> f64 {
    let factorial = |k: usize| (1..=k).map(|i| i as f64).product::<f64>();
    let double = |k: usize| (1..k).step_by(2).map(|i| i as f64).product::<f64>();
    let mut sum = 0.0;
    for t11 in 0..=n {
        for t12 in 0..=m {
            let t = Matrix2::new(t11, t12, n - t11, m - t12);
            let rows = [t11 + t12, n + m - t11 - t12];
            if rows[0] % 2 == 1
                || rows[1] % 2 == 1
                || !admits(t.m11, t.m21)
                || !admits(t.m12, t.m22)
            {
                continue;
            }
            let entries: f64 = q
                .iter()
                .zip(t.iter())
                .map(|(q, t)| q.powi(*t as i32) / factorial(*t))
                .product();
            let signs = if (n + m).is_multiple_of(4) { 1.0 } else { -1.0 };
            sum += signs * entries * double(rows[0]) * double(rows[1]);
        }
    }
    (factorial(n) * factorial(m)).sqrt() * sum
}

#[test]
fn s1_7_sums_over_compositions_not_over_partitions() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let stretch = turn(-0.4) * l;
    let widths = stretch.diagonal().map(|width| 1.0 / width);
    let q = turn(0.4) * Matrix2::from_diagonal(&widths) * turn(-0.4);
    let norm = PI.sqrt() * theta.determinant().powf(0.25);
    for (n, m) in [(2, 0), (1, 1), (2, 2), (3, 1), (4, 2), (5, 3)] {
        // the value at 0 is the mean of the transform
        let back = l.try_inverse().unwrap().transpose();
        let mean = integral(&back, |z| {
            stokes::covariant_mode_fourier(Family::Covariant, n, m, &theta, z).unwrap()
        });
        let at_zero = mean.value / (4.0 * PI * PI);
        let rounding = ROUNDINGS * f64::EPSILON * mean.modulus;
        let compositions = sum_at_zero(n, m, &q, |_, _| true) / norm;
        assert!(
            (at_zero - compositions).norm() < rounding,
            "{n} {m}: {at_zero} {compositions}"
        );
        let found = covariant_mode_at_zero(Family::Covariant, n, m, &theta).unwrap();
        assert!((at_zero - found).norm() < rounding);
        // a partition is a composition in falling order
        let partitions = sum_at_zero(n, m, &q, |first, second| first >= second) / norm;
        assert!(far_apart(at_zero, partitions.into()), "{n} {m}");
    }
}

#[test]
fn s2_6_has_the_jacobian_of_two_dimensions() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let (r_over_k, q) = (1.7, turn(0.6));
    let grid = q.transpose() * l * r_over_k;
    for (n, m) in [(0, 0), (1, 0), (2, 1)] {
        let found = integral(&grid, |xi| {
            let w = q * xi / r_over_k;
            (psi(Family::Covariant, n, m, &theta, &w) * psi(Family::Dual, n, m, &theta, &w)).into()
        });
        assert!(found.is((r_over_k * r_over_k).into(), ROUNDINGS));
        assert!(far_apart(found.value, r_over_k.powi(3).into()));
    }
}

#[test]
fn s2_8_has_the_factor_of_two_dimensions() {
    let (l, theta) = shape(0.4, 1.3, 5.0);
    let inverse = theta.try_inverse().unwrap();
    let inverse = Matrix2::new(inverse.m11, inverse.m12, inverse.m12, inverse.m22);
    let (r_over_k, q, p) = (1.7, turn(0.6), Vector2::new(0.7, 0.45));
    let grid = q.transpose() * l * r_over_k;
    for (n, m) in [(0, 0), (1, 0), (2, 1)] {
        let found = fourier(&grid, &(p / r_over_k), |xi| {
            psi(Family::Dual, n, m, &theta, &(q * xi / r_over_k)).into()
        });
        let side = Complex64::new(0.0, -1.0).powu((n + m) as u32)
            * psi(Family::Covariant, n, m, &inverse, &(q * p));
        assert!(found.is(side * 2.0 * PI * r_over_k.powi(2), ROUNDINGS));
        assert!(far_apart(
            found.value,
            side * (2.0 * PI).powf(1.5) * r_over_k.powi(3)
        ));
        // also with the right Jacobian the printed power of 2π is not right
        assert!(far_apart(
            found.value,
            side * (2.0 * PI).powf(1.5) * r_over_k.powi(2)
        ));
    }
}
