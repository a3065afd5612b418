//! Arithmetic of the transverse plane without cancellation: 2×2 products, determinants, roots and singular values.
//!
//! A grazing direction or a long thin footprint makes shape matrices with condition numbers of 1e10 and more. The
//! sums `ab ± cd` that everything 2×2 consists of are therefore evaluated with their rounding errors (Kahan's
//! algorithm), so that each entry here is right to a few units in its last place whatever the condition number.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

/// `a·b + c·d`, right to two units in the last place even where the products cancel.
///
/// Source: Jeannerod, Louvet & Muller, "Further analysis of Kahan's algorithm for the accurate computation of 2×2
/// determinants", Math. Comp. 82 (2013).
#[inline]
#[must_use]
pub fn sum_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let product = c * d;
    let error = c.mul_add(d, -product);
    a.mul_add(b, product) + error
}

/// The angle of an undirected axis, from `(−π, π]` to `[0, π)`.
#[must_use]
pub fn axis_angle(angle: f64) -> f64 {
    let folded = if angle < 0.0 { angle + PI } else { angle };
    // a negative angle below the rounding of π wraps to 0
    if folded < PI { folded } else { 0.0 }
}

/// `m·v`, entrywise as [`sum_of_products`].
#[inline]
#[must_use]
pub fn apply(m: &Matrix2<f64>, v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(
        sum_of_products(m.m11, v.x, m.m12, v.y),
        sum_of_products(m.m21, v.x, m.m22, v.y),
    )
}

/// `a·b`, entrywise as [`sum_of_products`].
#[must_use]
pub fn product(a: &Matrix2<f64>, b: &Matrix2<f64>) -> Matrix2<f64> {
    Matrix2::from_fn(|row, column| {
        sum_of_products(a[(row, 0)], b[(0, column)], a[(row, 1)], b[(1, column)])
    })
}

/// The determinant, as [`sum_of_products`].
#[must_use]
pub fn determinant(m: &Matrix2<f64>) -> f64 {
    sum_of_products(m.m11, m.m22, -m.m12, m.m21)
}

/// The adjugate: `m · adjugate(m) = determinant(m) · 1`.
#[must_use]
pub fn adjugate(m: &Matrix2<f64>) -> Matrix2<f64> {
    Matrix2::new(m.m22, -m.m12, -m.m21, m.m11)
}

/// The inverse of a matrix whose determinant is not zero.
#[must_use]
pub fn inverse(m: &Matrix2<f64>) -> Matrix2<f64> {
    adjugate(m) / determinant(m)
}

/// Eigenvalues of a symmetric matrix, the larger first; the smaller one without cancellation.
#[must_use]
pub fn eigenvalues(m: &Matrix2<f64>) -> [f64; 2] {
    let trace = m.m11 + m.m22;
    let spread = (m.m11 - m.m22).hypot(2.0 * m.m12);
    let far = 0.5 * (trace.abs() + spread).copysign(trace);
    let near = if far == 0.0 {
        0.0
    } else {
        determinant(m) / far
    };
    if trace < 0.0 {
        [near, far]
    } else {
        [far, near]
    }
}

/// The symmetric positive root of a symmetric positive definite matrix: `(m + √|m| 1)/√(tr m + 2√|m|)`.
///
/// Entrywise as accurate as the determinant: no difference is taken on the diagonal.
#[must_use]
pub fn symmetric_root(m: &Matrix2<f64>) -> Matrix2<f64> {
    let s = determinant(m).sqrt();
    let t = (m.m11 + m.m22 + 2.0 * s).sqrt();
    Matrix2::new(m.m11 + s, m.m12, m.m21, m.m22 + s) / t
}

/// A singular value decomposition `m = left · diag(values) · rightᵀ` with orthogonal `left` and `right`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularValues {
    /// Orthogonal, 2×2.
    pub left: Matrix2<f64>,
    /// The larger first, neither negative.
    pub values: [f64; 2],
    /// Orthogonal, 2×2.
    pub right: Matrix2<f64>,
}

/// The singular values of `m` and their axes.
///
/// One-sided Jacobi rotation. The smaller value is `|det m|` over the larger, hence as accurate as the entries of
/// `m` permit (relative error of a few `f64::EPSILON` for any condition number).
#[must_use]
pub fn singular_values(m: &Matrix2<f64>) -> SingularValues {
    let scale = m.amax();
    if scale == 0.0 {
        return SingularValues {
            left: Matrix2::identity(),
            values: [0.0; 2],
            right: Matrix2::identity(),
        };
    }
    let unit = m / scale;
    // the right rotation that makes the columns perpendicular
    let across = 2.0 * sum_of_products(unit.m11, unit.m12, unit.m21, unit.m22);
    let excess = sum_of_products(
        unit.m11 - unit.m12,
        unit.m11 + unit.m12,
        unit.m21 - unit.m22,
        unit.m21 + unit.m22,
    );
    let (sin, cos) = (0.5 * across.atan2(excess)).sin_cos();
    let right = Matrix2::new(cos, -sin, sin, cos);
    let long = apply(&unit, &Vector2::new(cos, sin));
    let larger = long.norm();
    let axis = long / larger;
    let det = determinant(&unit);
    let sign = if det < 0.0 { -1.0 } else { 1.0 };
    SingularValues {
        left: Matrix2::new(axis.x, -sign * axis.y, axis.y, sign * axis.x),
        values: [larger * scale, det.abs() / larger * scale],
        right,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn entries() -> impl Strategy<Value = Matrix2<f64>> {
        prop::array::uniform4(prop_oneof![
            -1.0..1.0f64,
            -1e-6..1e-6f64,
            Just(0.0),
            Just(1.0)
        ])
        .prop_map(|[a, b, c, d]| Matrix2::new(a, b, c, d))
    }

    #[test]
    fn a_cancelling_determinant_keeps_its_digits() {
        // (1 + ε)(1 − ε) − 1 = −ε²: a plain evaluation gives 0
        let e = f64::EPSILON;
        let m = Matrix2::new(1.0 + e, 1.0, 1.0, 1.0 - e);
        assert_eq!(determinant(&m), -e * e);
    }

    #[test]
    fn sums_of_products_are_right_where_they_cancel() {
        // (2^27 + 1)(2^27 − 1) = 2^54 − 1 is no f64
        let big = 2f64.powi(27);
        assert_eq!(sum_of_products(big + 1.0, big - 1.0, -big, big), -1.0);
        assert_eq!(sum_of_products(-big, big, big + 1.0, big - 1.0), -1.0);
    }

    #[test]
    fn the_smaller_eigenvalue_keeps_its_digits_and_its_sign() {
        // eigenvalues of [1 1−d; 1−d 1] are 2 − d and d
        for d in [1e-3, 1e-9, 1e-15] {
            let off = 1.0 - d;
            let d = 1.0 - off;
            for sign in [1.0, -1.0] {
                let [large, small] = eigenvalues(&(sign * Matrix2::new(1.0, off, off, 1.0)));
                let (far, near) = if sign > 0.0 {
                    (large, small)
                } else {
                    (small, large)
                };
                assert!(
                    (near / (sign * d) - 1.0).abs() < 4.0 * f64::EPSILON,
                    "{d} {near}"
                );
                assert!((far / (sign * (2.0 - d)) - 1.0).abs() < 4.0 * f64::EPSILON);
            }
        }
        // trace 0: a saddle
        assert_eq!(eigenvalues(&Matrix2::new(3.0, 4.0, 4.0, -3.0)), [5.0, -5.0]);
        assert_eq!(eigenvalues(&Matrix2::zeros()), [0.0, 0.0]);
    }

    #[test]
    fn singular_values_of_near_singular_matrices_keep_their_digits() {
        // |m| = e² − … exactly as in the determinant above; the larger value is near 2
        let e = 2f64.powi(-26);
        for m in [
            Matrix2::new(1.0 + e, 1.0, 1.0, 1.0 - e),
            Matrix2::new(1.0, 1.0 - e, 1.0 + e, 1.0),
        ] {
            let SingularValues { values, .. } = singular_values(&m);
            let expected = e * e / values[0];
            assert!((values[0] - 2.0).abs() < e);
            assert!(
                (values[1] / expected - 1.0).abs() < 4.0 * f64::EPSILON,
                "{values:?}"
            );
        }
    }

    #[test]
    fn singular_values_follow_the_size_of_a_matrix_from_subnormal_to_huge() {
        let m = Matrix2::new(3.0, -1.0, 0.5, 2.0);
        let SingularValues { values, .. } = singular_values(&m);
        for exponent in [-1000, -500, 500, 1000] {
            let scaled = m.map(|entry| libm::scalbn(entry, exponent));
            let found = singular_values(&scaled).values;
            for (found, value) in found.into_iter().zip(values) {
                let value = libm::scalbn(value, exponent);
                assert!(
                    (found / value - 1.0).abs() < 8.0 * f64::EPSILON,
                    "{exponent}"
                );
            }
        }
        // the smallest numbers of all: no digits, but no nonsense either
        let tiny = singular_values(&Matrix2::from_diagonal_element(5e-324));
        assert_eq!(tiny.values, [5e-324; 2]);
    }

    #[test]
    fn the_root_of_a_thin_matrix_squares_to_it() {
        for thin in [1e-2, 1e-6, 1e-12] {
            let (sin, cos) = 0.7f64.sin_cos();
            let turn = Matrix2::new(cos, -sin, sin, cos);
            let m = turn * Matrix2::new(1.0, 0.0, 0.0, thin) * turn.transpose();
            let symmetric = Matrix2::new(m.m11, m.m12, m.m12, m.m22);
            let root = symmetric_root(&symmetric);
            assert!((product(&root, &root) - symmetric).amax() < 4.0 * f64::EPSILON);
            // each entry of the root is right to a few roundings, of which its determinant √thin keeps the difference
            let expected = determinant(&symmetric).sqrt();
            let error = (determinant(&root) - expected).abs();
            assert!(error < 8.0 * f64::EPSILON, "{thin}: {error}");
        }
    }

    proptest! {
        #[test]
        fn singular_values_recompose(m in entries()) {
            let SingularValues { left, values, right } = singular_values(&m);
            let again = left * Matrix2::new(values[0], 0.0, 0.0, values[1]) * right.transpose();
            let eps = 16.0 * f64::EPSILON;
            prop_assert!((again - m).amax() <= eps * m.amax());
            prop_assert!((left.transpose() * left - Matrix2::identity()).amax() <= eps);
            prop_assert!((right.transpose() * right - Matrix2::identity()).amax() <= eps);
            prop_assert!(values[0] >= values[1] && values[1] >= 0.0);
        }

        #[test]
        fn eigenvalues_have_the_trace_and_the_determinant(m in entries()) {
            let m = Matrix2::new(m.m11, m.m12, m.m12, m.m22);
            let [large, small] = eigenvalues(&m);
            prop_assert!(large >= small);
            prop_assert!((large + small - m.m11 - m.m22).abs() <= 8.0 * f64::EPSILON * m.amax());
            prop_assert!((large * small - determinant(&m)).abs() <= 8.0 * f64::EPSILON * determinant(&m).abs());
        }
    }
}
