//! Least squares without negative coefficients.

use nalgebra::{DMatrix, DVector};

/// The x ≥ 0 for which `|A x − b|` is least.
///
/// The answer is sparse where columns are alike. Rounds are limited to three for each column; an answer that is cut off
/// there is still not negative, and the caller measures the misfit.
///
/// Source: Lawson & Hanson, Solving Least Squares Problems, chapter 23, algorithm NNLS.
pub(super) fn non_negative(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = a.ncols();
    let mut x = DVector::zeros(n);
    let mut passive: Vec<usize> = vec![];
    let norms: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    let floor = 1e-15 * b.norm();
    for _ in 0..3 * n {
        let gradient = a.tr_mul(&(b - a * &x));
        // a column that rounding makes useless is passed over
        let mut candidates: Vec<usize> = (0..n)
            .filter(|j| !passive.contains(j) && gradient[*j] > floor * norms[*j])
            .collect();
        candidates
            .sort_by(|i, j| (gradient[*j] / norms[*j]).total_cmp(&(gradient[*i] / norms[*i])));
        let entering = candidates.into_iter().find_map(|j| {
            let mut with = passive.clone();
            with.push(j);
            let s = solve(a, b, &with)?;
            (s[with.len() - 1] > 0.0).then_some((with, s))
        });
        let Some((with, mut s)) = entering else { break };
        passive = with;
        while let Some(worst) = blocking(&x, &s, &passive) {
            for (place, &j) in passive.iter().enumerate() {
                x[j] += worst * (s[place] - x[j]);
            }
            let kept: Vec<usize> = {
                let blocked = |place: usize| {
                    s[place] <= 0.0 && x[passive[place]] <= 1e-300_f64.max(1e-14 * x.amax())
                };
                (0..passive.len())
                    .filter(|p| !blocked(*p))
                    .map(|p| passive[p])
                    .collect()
            };
            if kept.len() == passive.len() {
                return x;
            }
            for j in 0..n {
                if !kept.contains(&j) {
                    x[j] = 0.0;
                }
            }
            passive = kept;
            match solve(a, b, &passive) {
                Some(again) => s = again,
                None => return x,
            }
        }
        x.fill(0.0);
        for (place, &j) in passive.iter().enumerate() {
            x[j] = s[place];
        }
    }
    x
}

/// How far from x to s one may go until the first coefficient is 0; `None` where none becomes so.
fn blocking(x: &DVector<f64>, s: &DVector<f64>, passive: &[usize]) -> Option<f64> {
    let steps = passive
        .iter()
        .enumerate()
        .filter(|(place, _)| s[*place] <= 0.0);
    steps
        .map(|(place, &j)| {
            if x[j] > 0.0 {
                x[j] / (x[j] - s[place])
            } else {
                0.0
            }
        })
        .reduce(f64::min)
}

/// Least squares in some of the columns; `None` where they are linearly dependent.
fn solve(a: &DMatrix<f64>, b: &DVector<f64>, columns: &[usize]) -> Option<DVector<f64>> {
    if columns.is_empty() {
        return Some(DVector::zeros(0));
    }
    if columns.len() > a.nrows() {
        return None;
    }
    let qr = a.select_columns(columns).qr();
    let mut right = b.clone();
    qr.q_tr_mul(&mut right);
    let upper = qr.r();
    let top = upper.diagonal().amax();
    if upper.diagonal().iter().any(|d| d.abs() < 1e-13 * top) {
        return None;
    }
    upper.solve_upper_triangular(&right.rows(0, columns.len()).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_negative_coefficient_is_held_at_zero() {
        // without the sign x = (1, −1); with it (0.5, 0) by hand: the first column alone fits (1, 0) as 1/2
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 1.0, 1.0]);
        let x = non_negative(&a, &DVector::from_vec(vec![1.0, 0.0]));
        assert!((x[0] - 0.5).abs() < 1e-15 && x[1] == 0.0, "{x}");
    }

    proptest! {
        #[test]
        fn the_conditions_of_kuhn_and_tucker_hold(
            entries in prop::collection::vec(-1.0..1.0f64, 40),
            b in prop::collection::vec(-1.0..1.0f64, 8),
        ) {
            let a = DMatrix::from_row_slice(8, 5, &entries);
            let b = DVector::from_vec(b);
            let x = non_negative(&a, &b);
            let gradient = a.tr_mul(&(&b - &a * &x));
            for j in 0..5 {
                prop_assert!(x[j] >= 0.0);
                // residuals are orthogonal to rounding of the QR times the condition of eight random rows
                prop_assert!(gradient[j] <= 1e-10);
                prop_assert!(x[j] == 0.0 || gradient[j].abs() <= 1e-10);
            }
        }

        #[test]
        fn planted_coefficients_are_found(
            entries in prop::collection::vec(-1.0..1.0f64, 60),
            planted in prop::collection::vec(prop_oneof![Just(0.0), 0.1..2.0f64], 5),
        ) {
            let a = DMatrix::from_row_slice(12, 5, &entries);
            let b = &a * DVector::from_vec(planted.clone());
            let misfit = (&a * non_negative(&a, &b) - &b).norm();
            prop_assert!(misfit <= 1e-12 * (1.0 + b.norm()), "{misfit}");
        }
    }
}
