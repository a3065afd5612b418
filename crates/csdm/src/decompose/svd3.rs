//! Singular values of a real 3×3 matrix by one-sided Jacobi rotations.
//!
//! Small singular values keep an absolute error of a few `f64::EPSILON` times the largest one (better where columns
//! differ in size); nalgebra's routine for this size squares the matrix and would lose half the digits.
//!
//! Source: Golub & Van Loan, Matrix Computations, 4th ed., section 8.6.

use nalgebra::{Matrix3, Vector3};

/// Sweeps after which rotation stops; three to six are enough for any matrix of this size.
const SWEEPS: usize = 30;

/// `matrix = U diag(values) Vᵀ`, values descending and not negative.
///
/// Columns of `u` that belong to a value of 0 are zero. `v` is orthogonal.
pub(super) struct Svd3 {
    pub(super) u: Matrix3<f64>,
    pub(super) values: Vector3<f64>,
    pub(super) v: Matrix3<f64>,
}

impl Svd3 {
    /// Of a matrix of finite elements.
    pub(super) fn of(matrix: &Matrix3<f64>) -> Self {
        let (mut a, mut v) = (*matrix, Matrix3::identity());
        for _ in 0..SWEEPS {
            let rotated = [(0, 1), (0, 2), (1, 2)]
                .map(|(p, q)| make_orthogonal(&mut a, &mut v, p, q))
                .into_iter()
                .any(|turned| turned);
            if !rotated {
                break;
            }
        }
        let norms = [0, 1, 2].map(|i| a.column(i).norm());
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| norms[j].total_cmp(&norms[i]));
        let unit = |i: usize| {
            let column = a.column(i).into_owned();
            if norms[i] > 0.0 {
                column / norms[i]
            } else {
                column
            }
        };
        Self {
            u: Matrix3::from_columns(&order.map(unit)),
            values: Vector3::from(order.map(|i| norms[i])),
            v: Matrix3::from_columns(&order.map(|i| v.column(i).into_owned())),
        }
    }
}

/// Turns columns `p` and `q` in their plane until they are orthogonal; whether there was anything to turn.
fn make_orthogonal(a: &mut Matrix3<f64>, v: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
    let gamma = a.column(p).dot(&a.column(q));
    if gamma.abs() <= f64::EPSILON * alpha.sqrt() * beta.sqrt() {
        return false;
    }
    let zeta = (beta - alpha) / (2.0 * gamma);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cos = 1.0 / tangent.hypot(1.0);
    let sin = cos * tangent;
    for matrix in [a, v] {
        let (first, second) = (matrix.column(p).into_owned(), matrix.column(q).into_owned());
        matrix.set_column(p, &(first * cos - second * sin));
        matrix.set_column(q, &(first * sin + second * cos));
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn planted_singular_values_are_found(
            first in prop::array::uniform3(-3.0..3.0f64), second in prop::array::uniform3(-3.0..3.0f64),
            sizes in prop::array::uniform3(prop_oneof![0.0..1.0f64, 0.0..1e-9f64, Just(0.0), Just(0.5)]),
        ) {
            let u = Rotation3::new(Vector3::from(first)).into_inner();
            let v = Rotation3::new(Vector3::from(second)).into_inner();
            let matrix = u * Matrix3::from_diagonal(&Vector3::from(sizes)) * v.transpose();
            let svd = Svd3::of(&matrix);
            let mut sorted = sizes;
            sorted.sort_by(|a, b| b.total_cmp(a));
            prop_assert!((svd.values - Vector3::from(sorted)).amax() < 4e-15);
            let back = svd.u * Matrix3::from_diagonal(&svd.values) * svd.v.transpose();
            prop_assert!((back - matrix).amax() < 4e-15);
            prop_assert!((svd.v.transpose() * svd.v - Matrix3::identity()).amax() < 4e-15);
        }
    }
}
