//! Sections S2.3 and S2.4 and Theorem S4.1 (ii): the shape matrix from a Hessian.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{ShapeMatrix, inverse_log_hessian, inverse_of_sum, log_hessian};

use crate::differences::hessian_at_0;
use crate::turn;

/// Step of the finite differences of a quadratic form of size 1: rounding `ε/h²` and no truncation.
const STEP: f64 = 0.05;
const ROUNDING: f64 = 64.0 * f64::EPSILON / (STEP * STEP);

#[test]
fn s2_12_and_s2_13_turn_the_hessian_the_other_way_round() {
    let q = turn(0.6);
    let theta = Matrix2::new(0.9, 0.4, 0.4, 0.7);
    let inverse = theta.try_inverse().unwrap();
    // (S2.11): the logarithm of the Gaussian of w
    let h = hessian_at_0(
        |w| {
            let y = q * w;
            -0.5 * y.dot(&(inverse * y))
        },
        STEP,
    );
    assert!((q.transpose() * inverse * q + h).amax() < ROUNDING);
    assert!((q * inverse * q.transpose() + h).amax() > 0.1);
    let inverse_hessian = h.try_inverse().unwrap();
    let corrected = -q * inverse_hessian * q.transpose();
    let printed = -q.transpose() * inverse_hessian * q;
    assert!((corrected - theta).amax() < ROUNDING);
    assert!((printed - theta).amax() > 0.1);
    let shape = ShapeMatrix::from_log_hessian(&(q * h * q.transpose())).unwrap();
    assert!((shape.theta() - theta).amax() < ROUNDING);
}

#[test]
fn s4_1_lacks_the_minus_sign() {
    let h = hessian_at_0(|w| -w.x * w.x - 0.3 * w.x * w.y - w.y * w.y, STEP);
    assert!(ShapeMatrix::from_log_hessian(&h).is_ok());
    // as printed Θ would be the inverse of the Hessian itself, which is negative
    let printed = h.try_inverse().unwrap();
    assert!(printed.m11 < 0.0 && printed.determinant() > 0.0);
    assert!(ShapeMatrix::from_theta(&printed).is_err());
    assert!(ShapeMatrix::from_log_hessian(&-h).is_err());
}

#[test]
fn s2_13_inverts_what_is_restricted_to_the_transverse_plane_and_not_the_other_way_round() {
    // a source of three-dimensional extent: |f| = e^(−wᵀ Cov w/2) for any w
    let root = Matrix3::new(1.0, 0.3, -0.5, 0.2, 0.8, 0.6, -0.4, 0.1, 1.2);
    let covariance = root.transpose() * root;
    let away = Vector3::new(0.4, -0.5, 0.7).normalize();
    let e1 = away.cross(&Vector3::x()).normalize();
    let e2 = away.cross(&e1);
    let across = Matrix2x3::from_rows(&[e1.transpose(), e2.transpose()]);
    // the function of a transverse w is all that there is
    let h = hessian_at_0(
        |w| {
            let w = across.transpose() * w;
            -0.5 * w.dot(&(covariance * w))
        },
        STEP,
    );
    let theta = ShapeMatrix::from_log_hessian(&h).unwrap().theta();
    let restricted_first = (across * covariance * across.transpose())
        .try_inverse()
        .unwrap();
    let inverted_first = across * covariance.try_inverse().unwrap() * across.transpose();
    assert!((theta - restricted_first).amax() < 4.0 * ROUNDING * theta.amax());
    assert!((theta - inverted_first).amax() > 0.1 * theta.amax());
}

/// The transform of two Gaussians off the centre, real by symmetry of sign, with its derivatives.
fn mixture(w: &Vector2<f64>) -> (f64, Vector2<f64>, Matrix2<f64>) {
    let terms = [
        (
            1.0,
            Vector2::new(0.3, -0.2),
            Matrix2::new(1.1, 0.3, 0.3, 0.6),
        ),
        (
            0.6,
            Vector2::new(-0.5, 0.4),
            Matrix2::new(0.4, -0.1, -0.1, 0.9),
        ),
    ];
    let (mut f, mut gradient, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
    for (weight, centre, s) in terms {
        let x = w - centre;
        let value = weight * (-0.5 * x.dot(&(s * x))).exp();
        let slope = -s * x;
        f += value;
        gradient += slope * value;
        second += (slope * slope.transpose() - s) * value;
    }
    (
        f,
        gradient,
        Matrix2::new(second.m11, second.m12, second.m12, second.m22),
    )
}

#[test]
fn s2_17_takes_the_inverse_of_the_hessian() {
    let w = Vector2::new(0.9, -0.6);
    let (f, gradient, second) = mixture(&w);
    // the truncation grows 16-fold with the step; ln f is right to 3 ε, its weights add up to 64/12
    let h = 5e-3;
    let by_differences = |h: f64| hessian_at_0(|d| mixture(&(w + d)).0.ln(), h);
    let log = by_differences(h);
    let truncation = (by_differences(2.0 * h) - log).amax() / 4.0;
    let error = truncation + 24.0 * f64::EPSILON / (h * h);
    assert!((log_hessian(f, &gradient, &second).unwrap() - log).amax() < error);
    let expected = log.try_inverse().unwrap();
    let inverse = (second / f).try_inverse().unwrap();
    let update = inverse * (gradient * gradient.transpose() / (f * f)) * inverse;
    let outer = gradient * gradient.transpose();
    let with = |t1: f64| inverse + t1 * update;
    let corrected = with(1.0 / (1.0 - (outer * second.try_inverse().unwrap()).trace() / f));
    let printed = with(1.0 / (1.0 - (outer * second).trace() / f));
    let error = error * expected.norm_squared();
    assert!((corrected - expected).amax() < error);
    assert!((printed - expected).amax() > 1e-2 * expected.amax());
    let found = inverse_log_hessian(f, &gradient, &second).unwrap();
    assert!((found - corrected).amax() < 64.0 * f64::EPSILON * expected.norm());
    let lemma = inverse_of_sum(&inverse, &(-gradient / f), &(gradient / f)).unwrap();
    assert!((lemma - corrected).amax() < 64.0 * f64::EPSILON * expected.norm());
    let shape = ShapeMatrix::from_derivatives(f, &gradient, &second).unwrap();
    assert!((shape.theta() + found).amax() < 64.0 * f64::EPSILON * expected.norm());
}

#[test]
fn the_shape_of_an_off_centre_envelope_is_that_of_the_modulus() {
    // f = e^(−im·w − wᵀSw/2): the logarithm of the real part has another curvature
    let (m, s) = (Vector2::new(1.2, -0.4), Matrix2::new(1.1, 0.3, 0.3, 0.6));
    let slope = m.map(|m| Complex64::new(0.0, -m));
    let second = slope * slope.transpose() - s.map(Complex64::from);
    let modulus = log_hessian(Complex64::ONE, &slope, &second).unwrap();
    assert!((modulus + s).amax() < 8.0 * f64::EPSILON);
    let real = log_hessian(1.0, &slope.map(|z| z.re), &second.map(|z| z.re)).unwrap();
    assert!((real + s).amax() > 0.1);
}
