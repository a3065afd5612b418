//! The Hessian of a logarithm and the shape that it is: finite differences, Gaussians off their centre, refusals.

#[path = "differences/mod.rs"]
mod differences;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use stokes::{ShapeMatrix, inverse_log_hessian, inverse_of_sum, log_hessian};

use differences::hessian_at_0;

/// The transform of a mixture of Gaussians with weights, centres and covariances, and its derivatives at `w`.
fn transform(
    terms: &[(f64, Vector2<f64>, Matrix2<f64>)],
    w: &Vector2<f64>,
) -> (Complex64, Vector2<Complex64>, Matrix2<Complex64>) {
    let mut sum = (
        Complex64::ZERO,
        Vector2::from_element(Complex64::ZERO),
        Matrix2::from_element(Complex64::ZERO),
    );
    for (weight, centre, s) in terms {
        let exponent = Complex64::new(-0.5 * w.dot(&(s * w)), -w.dot(centre));
        let value = weight * exponent.exp();
        let sw = s * w;
        let slope = Vector2::from_fn(|i, _| Complex64::new(-sw[i], -centre[i]));
        sum.0 += value;
        sum.1 += slope * value;
        sum.2 += (slope * slope.transpose() - s.map(Complex64::from)) * value;
    }
    sum
}

fn covariance() -> impl Strategy<Value = Matrix2<f64>> {
    (0.2..2.0f64, 0.2..2.0f64, -0.9..0.9f64).prop_map(|(a, b, r)| {
        let off = r * (a * b).sqrt();
        Matrix2::new(a, off, off, b)
    })
}

fn point() -> impl Strategy<Value = Vector2<f64>> {
    (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y)| Vector2::new(x, y))
}

/// Seeds once found wrong, from the package's root.
fn with_seeds() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(
            "proptest-regressions/log_hessian.txt",
        ))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(with_seeds())]

    #[test]
    fn the_log_hessian_is_that_of_finite_differences(
        m1 in point(), m2 in point(), s1 in covariance(), s2 in covariance(), w in point(), weight in 0.1..0.5f64,
    ) {
        // off-centre and complex; weights 1 and below 1/2 keep f away from 0 near the origin
        let terms = [(1.0, m1, s1), (weight, m2, s2)];
        let w = 0.3 * w;
        let (f, gradient, hessian) = transform(&terms, &w);
        let found = log_hessian(f, &gradient, &hessian).unwrap();
        let log = |d: &Vector2<f64>| transform(&terms, &(w + d)).0.norm().ln();
        let h = 5e-3;
        let (expected, coarse) = (hessian_at_0(log, h), hessian_at_0(log, 2.0 * h));
        // the truncation grows 16-fold with the step; ln |f| is right to 3 ε, its weights add up to 64/12
        let truncation = (coarse - expected).amax() / 4.0;
        prop_assert!((found - expected).amax() < truncation + 24.0 * f64::EPSILON / (h * h));
    }

    #[test]
    fn an_off_centre_gaussian_has_the_same_shape_everywhere(
        p in covariance(), x in point(), scale in -200i32..200, negative in any::<bool>(),
    ) {
        // f = ± 2^scale e^(−xᵀPx/2), up to three standard deviations off its centre
        let x = 2.0 * x;
        let size = if negative { -1.0 } else { 1.0 } * libm::scalbn(1.0, 4 * scale);
        let f = size * (-0.5 * x.dot(&(p * x))).exp();
        let slope = -p * x;
        let gradient = slope * f;
        let hessian = (slope * slope.transpose() - p) * f;
        let hessian = Matrix2::new(hessian.m11, hessian.m12, hessian.m12, hessian.m22);
        let found = log_hessian(f, &gradient, &hessian).unwrap();
        let size = p.amax() + slope.norm_squared();
        prop_assert!((found + p).amax() <= 16.0 * f64::EPSILON * size);
        let theta = -inverse_log_hessian(f, &gradient, &hessian).unwrap();
        let condition = p.norm() * theta.norm();
        prop_assert!((theta * p - Matrix2::identity()).amax() <= 32.0 * f64::EPSILON * size * theta.norm() * condition);
        let shape = ShapeMatrix::from_derivatives(f, &gradient, &hessian).unwrap();
        prop_assert!((shape.theta() - theta).amax() <= 32.0 * f64::EPSILON * condition * theta.amax());
    }

    #[test]
    fn two_updates_of_rank_one_are_the_inverse_of_the_sum(
        a in covariance(), u in point(), v in point(), p in point(), q in point(),
    ) {
        let sum = a + u * v.transpose() + p * q.transpose();
        prop_assume!(sum.determinant().abs() > 1e-2 && (a + u * v.transpose()).determinant().abs() > 1e-2);
        let first = inverse_of_sum(&a.try_inverse().unwrap(), &u, &v).unwrap();
        let second = inverse_of_sum(&first, &p, &q).unwrap();
        // each factor of the error is at most the largest matrix over the smallest determinant: 8/1e-2
        prop_assert!((second * sum - Matrix2::identity()).amax() < 64.0 * f64::EPSILON * 800.0f64.powi(2));
    }
}

#[test]
fn the_closed_form_holds_where_its_own_matrix_is_singular() {
    // at one standard deviation A = ggᵀ − P is singular, ln f is not
    let (g, p) = (Vector2::new(1.0, 0.0), Matrix2::identity());
    let a = g * g.transpose() - p;
    assert_eq!(a.determinant(), 0.0);
    let found = inverse_log_hessian(1.0, &g, &a).unwrap();
    assert_eq!(found, -p);
}

#[test]
fn a_sum_that_is_singular_has_no_inverse() {
    let u = Vector2::new(1.0, 0.0);
    assert_eq!(inverse_of_sum(&Matrix2::identity(), &u, &-u), None);
}

#[test]
fn what_has_no_shape_is_refused_with_its_numbers() {
    let (flat, zero) = (Vector2::zeros(), Matrix2::zeros());
    let text = |f: f64, gradient: Vector2<f64>, hessian: Matrix2<f64>| {
        ShapeMatrix::from_derivatives(f, &gradient, &hessian)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        text(0.0, flat, -Matrix2::identity()),
        "shape: the function is 0 where its logarithm is differentiated, expected a finite number other than 0"
    );
    assert_eq!(
        text(f64::NAN, flat, -Matrix2::identity()),
        "shape: the function is NaN where its logarithm is differentiated, expected a finite number other than 0"
    );
    assert_eq!(
        text(1.0, Vector2::new(0.0, f64::INFINITY), -Matrix2::identity()),
        "shape: entry (1, 0) of the gradient of f is inf, expected a finite number"
    );
    // a saddle
    assert_eq!(
        text(2.0, flat, Matrix2::new(-4.0, 0.0, 0.0, 2.0)),
        "shape: the negated Hessian of ln |f| has eigenvalues 2 and -1, expected both positive (beyond 4e-16 of \
         the larger)"
    );
    // a minimum of f < 0 is a maximum of |f|
    assert!(ShapeMatrix::from_derivatives(-1.0, &flat, &Matrix2::identity()).is_ok());
    assert_eq!(
        inverse_log_hessian(1.0, &flat, &zero)
            .unwrap_err()
            .to_string(),
        "shape: the Hessian of ln |f| has eigenvalues 0 and 0, expected both other than 0 (beyond 4e-16 of the \
         larger)"
    );
}
