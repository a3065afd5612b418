//! `Sym^N(A)`: how a linear map of the plane acts on the Hermite-Gauss modes of total order N.
//!
//! ```text
//! Sym(A)_{nm,ab} = √(n! m!/(a! b!)) [XⁿYᵐ] (A11 X + A21 Y)^a (A12 X + A22 Y)^b,     n+m = a+b = N
//! Sym(A) Sym(B) = Sym(AB)      Sym(Aᵀ) = Sym(A)ᵀ
//! ```
//!
//! Explicit sums alternate and lose all digits by N ≈ 40 for a rotation. Here each order follows from the one
//! below it, averaged over the two ways of taking a factor out; that step has norm `|A|`, so the error grows like
//! `N·ε·|A|^N`: an orthogonal matrix stays orthogonal to `N·ε`.

use nalgebra::{DMatrix, Matrix2};

/// From `Sym^N(a)` to `Sym^(N+1)(a)`.
pub(crate) fn raise(a: &Matrix2<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let order = below.nrows();
    // entries outside the lower matrix come with the factor √0
    let at = |row: Option<usize>, column: Option<usize>| match (row, column) {
        (Some(row), Some(column)) if row < order && column < order => below[(row, column)],
        _ => 0.0,
    };
    DMatrix::from_fn(order + 1, order + 1, |i, j| {
        let [n, m, from_first, from_second] =
            [order - i, i, order - j, j].map(|count| (count as f64).sqrt());
        let (keep_y, drop_y) = (Some(i), i.checked_sub(1));
        let (keep_b, drop_b) = (Some(j), j.checked_sub(1));
        let first = a.m11 * n * at(keep_y, keep_b) + a.m21 * m * at(drop_y, keep_b);
        let second = a.m12 * n * at(keep_y, drop_b) + a.m22 * m * at(drop_y, drop_b);
        (from_first * first + from_second * second) / order as f64
    })
}

/// The `N`-th symmetric power of `a`, (N+1)×(N+1); rows and columns in the order (N,0), (N−1,1) … (0,N).
///
/// It turns covariant coefficients into whitened ones, `c_white = Sym^N(W) c_cov` order by order, and coefficients
/// of one root into those of another.
///
/// Source: from the generating function (S1.2); error `N·ε·|a|^N`.
///
/// ```
/// use nalgebra::Matrix2;
/// let a = Matrix2::new(1.0, 2.0, 3.0, 4.0);
/// assert_eq!(stokes::symmetric_power(&a, 1), a);
/// // [X²] (X + 3Y)², to rounding
/// assert!((stokes::symmetric_power(&a, 2)[(0, 0)] - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn symmetric_power(a: &Matrix2<f64>, n: usize) -> DMatrix<f64> {
    (0..n).fold(DMatrix::from_element(1, 1, 1.0), |below, _| {
        raise(a, &below)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix() -> impl Strategy<Value = Matrix2<f64>> {
        prop::array::uniform4(-1.0..1.0f64).prop_map(|[a, b, c, d]| Matrix2::new(a, b, c, d))
    }

    #[test]
    fn the_second_power_is_the_one_in_the_books() {
        let (p, q, r, s) = (0.3, -1.7, 2.1, 0.9);
        let root2 = 2f64.sqrt();
        let expected = DMatrix::from_row_slice(
            3,
            3,
            &[
                p * p,
                root2 * p * q,
                q * q,
                root2 * p * r,
                p * s + q * r,
                root2 * q * s,
                r * r,
                root2 * r * s,
                s * s,
            ],
        );
        let found = symmetric_power(&Matrix2::new(p, q, r, s), 2);
        assert!((found - expected).amax() < 8.0 * f64::EPSILON * 4.0);
    }

    /// `Sym^N` of a matrix of integers over `divisor`, its sums in exact arithmetic.
    fn explicit(a: [[i128; 2]; 2], divisor: f64, n: usize) -> DMatrix<f64> {
        let ln_factorial = |k: usize| (1..=k).map(|i| (i as f64).ln()).sum::<f64>();
        DMatrix::from_fn(n + 1, n + 1, |i, j| {
            // (A11 X + A21)^(n−j) (A12 X + A22)^j, its coefficients from X⁰ on
            let mut polynomial = vec![1i128];
            for factor in 0..n {
                let column = usize::from(factor >= n - j);
                let mut next = vec![0; polynomial.len() + 1];
                for (power, coefficient) in polynomial.iter().enumerate() {
                    next[power + 1] += coefficient * a[0][column];
                    next[power] += coefficient * a[1][column];
                }
                polynomial = next;
            }
            let root = 0.5
                * (ln_factorial(n - i) + ln_factorial(i) - ln_factorial(n - j) - ln_factorial(j));
            root.exp() * polynomial[n - i] as f64 / divisor.powi(n as i32)
        })
    }

    #[test]
    fn powers_are_the_explicit_sums_in_exact_arithmetic() {
        // a turn by the angle of a 3-4-5 triangle, whose sums in f64 lose all digits; a mirror; a singular matrix
        for (a, divisor) in [
            ([[3, -4], [4, 3]], 5.0),
            ([[3, 4], [4, -3]], 5.0),
            ([[2, -1], [4, -2]], 5.0),
            ([[1, -3], [0, 2]], 4.0),
        ] {
            let m = Matrix2::from_fn(|i, j| a[i][j] as f64 / divisor);
            // these have norm 1 or less; ln n! up to 110 costs 110 ε in the expected numbers
            for n in [1, 2, 3, 7, 16, 40] {
                let error = (symmetric_power(&m, n) - explicit(a, divisor, n)).amax();
                assert!(
                    error < (2 * n + 110) as f64 * f64::EPSILON,
                    "{a:?} {n}: {error}"
                );
            }
        }
    }

    #[test]
    fn what_is_below_f64_is_zero_and_the_rest_is_kept() {
        let power = symmetric_power(&Matrix2::new(1e-10, 0.0, 0.0, 1.0), 40);
        assert_eq!(power[(0, 0)], 0.0);
        for j in 12..=40 {
            let expected = 1e-10f64.powi(40 - j);
            assert!(
                (power[(j as usize, j as usize)] / expected - 1.0).abs() < 160.0 * f64::EPSILON
            );
        }
    }

    proptest! {
        #[test]
        fn powers_multiply(a in matrix(), b in matrix(), n in 0usize..24) {
            let product = symmetric_power(&a, n) * symmetric_power(&b, n);
            let together = symmetric_power(&(a * b), n);
            let norm = (a.norm() * b.norm()).powi(n as i32);
            prop_assert!((product - together).amax() <= 8.0 * (n + 1) as f64 * f64::EPSILON * norm);
        }

        #[test]
        fn the_power_of_the_transpose_is_the_transpose(a in matrix(), n in 0usize..24) {
            let difference = symmetric_power(&a.transpose(), n) - symmetric_power(&a, n).transpose();
            prop_assert!(difference.amax() <= 8.0 * (n + 1) as f64 * f64::EPSILON * a.norm().powi(n as i32));
        }

        #[test]
        fn rotations_stay_orthogonal(angle in -7.0..7.0f64, n in 0usize..=128) {
            let (sin, cos) = angle.sin_cos();
            let u = symmetric_power(&Matrix2::new(cos, -sin, sin, cos), n);
            let defect = (u.transpose() * &u - DMatrix::identity(n + 1, n + 1)).amax();
            prop_assert!(defect <= 8.0 * (n + 1) as f64 * f64::EPSILON, "{defect}");
        }
    }
}
