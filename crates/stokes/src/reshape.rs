//! Change of shape matrix: the same function by the modes of another root.
//!
//! `W₂W₁⁻¹ = U diag(d₁, d₂) Vᵀ` splits the change into a turn of the old root, a stretch of each axis by itself and
//! a turn of the new root. Turns act within a total order ([`crate::symmetric_power`]); a stretch couples orders of
//! equal parity by overlaps of one-dimensional functions, whose recurrence is a reflection and hence stable:
//!
//! ```text
//! O_an = ⟨√w₁ h_a(w₁ ·)|√w₂ h_n(w₂ ·)⟩,   C = (w₂² − w₁²)/(w₁² + w₂²),   S = 2 w₁w₂/(w₁² + w₂²),   O_00 = √S
//! √(a+1) O_{a+1,n} = −C √a O_{a−1,n} + S √n O_{a,n−1}          √(n+1) O_{a,n+1} = C √n O_{a,n−1} + S √a O_{a−1,n}
//! ```
//!
//! Each of the two alone multiplies by `√(n/(a+1))` and loses all digits where n ≫ a. Their mean with the weights `a` and
//! `n` is the reflection on the total order a + n, whose norm is 1: errors grow like `(a+n)·ε`.
//!
//! The turns and stretches together take O(N³) for all modes up to order N; the four-index recurrence for any two
//! roots would take O(N⁴).

use nalgebra::{DMatrix, Matrix2};

use crate::basis::{mode_count, mode_index, modes};
use crate::hermite::MAX_ORDER;
use crate::plane::{self, SingularValues};
use crate::series::HermiteSeries;
use crate::shape::ShapeMatrix;
use crate::symmetric_power::symmetric_power;

/// Overlaps `O_an` of the functions of widths 1/w₁ and 1/w₂ = 1/(ratio·w₁), a ≤ `first`, n ≤ `second`.
fn overlaps(ratio: f64, first: usize, second: usize) -> DMatrix<f64> {
    // in units of the larger of 1 and ratio, where no square overflows
    let most = ratio.max(1.0);
    let (w1, w2) = (1.0 / most, ratio / most);
    let total = w1 * w1 + w2 * w2;
    let (c, s) = ((w2 - w1) * (w2 + w1) / total, 2.0 * w1 * w2 / total);
    let root = |n: usize| (n as f64).sqrt();
    let mut o: DMatrix<f64> = DMatrix::zeros(first + 1, second + 1);
    o[(0, 0)] = s.sqrt();
    for n in 0..=second {
        for a in (n % 2..=first).step_by(2).filter(|a| a + n > 0) {
            let corner = if a > 0 && n > 0 {
                s * o[(a - 1, n - 1)]
            } else {
                0.0
            };
            let up = if a > 1 {
                -c * root(a - 1) * o[(a - 2, n)]
            } else {
                0.0
            };
            let left = if n > 1 {
                c * root(n - 1) * o[(a, n - 2)]
            } else {
                0.0
            };
            let raised_first = root(a) * (up + root(n) * corner);
            let raised_second = root(n) * (left + root(a) * corner);
            o[(a, n)] = (raised_first + raised_second) / (a + n) as f64;
        }
    }
    o
}

/// The change from one root to another, taken apart.
struct Change {
    turn_old: Matrix2<f64>,
    stretch: [f64; 2],
    turn_new: Matrix2<f64>,
}

impl Change {
    fn between(from: &ShapeMatrix, to: &ShapeMatrix) -> Self {
        let old = from.root();
        let map = plane::product(to.root(), &plane::adjugate(old)) / plane::determinant(old);
        let SingularValues {
            left,
            values,
            right,
        } = plane::singular_values(&map);
        // from the two determinants themselves: that of the rounded map is off by its condition number
        let smaller = to.root_determinant() / from.root_determinant() / values[0];
        Self {
            turn_old: right.transpose(),
            stretch: [values[0], smaller],
            turn_new: left,
        }
    }
}

/// `⟨φ_ab(·; W₁)|φ_nm(·; W₂)⟩`, dimensionless, in `-1.0..=1.0`; `first` is (a, b), `second` is (n, m).
///
/// Error of a few `f64::EPSILON` at low orders, growing no faster than the sum of the orders, for orders up to 256 and
/// any condition numbers of the two shapes (`validation/stability.py` measures it).
///
/// Source: from the generating function (S1.2) in whitened coordinates.
///
/// ```
/// use stokes::{ShapeMatrix, overlap};
/// let (narrow, wide) = (ShapeMatrix::isotropic(1.0)?, ShapeMatrix::isotropic(4.0)?);
/// // two round Gaussians of widths 1 and 2: 2·1·2/(1² + 2²)
/// assert!((overlap((0, 0), &narrow, (0, 0), &wide) - 0.8).abs() < 1e-15);
/// # Ok::<(), stokes::ShapeError>(())
/// ```
#[must_use]
pub fn overlap(
    first: (usize, usize),
    shape1: &ShapeMatrix,
    second: (usize, usize),
    shape2: &ShapeMatrix,
) -> f64 {
    let (old, new) = (first.0 + first.1, second.0 + second.1);
    if (old + new) % 2 == 1 {
        return 0.0;
    }
    let change = Change::between(shape1, shape2);
    let from = symmetric_power(&change.turn_old, old);
    let to = symmetric_power(&change.turn_new, new);
    let along = change.stretch.map(|ratio| overlaps(ratio, old, new));
    let mut sum = 0.0;
    for d in 0..=old {
        for q in 0..=new {
            sum += from[(d, first.1)]
                * along[0][(old - d, new - q)]
                * along[1][(d, q)]
                * to[(second.1, q)];
        }
    }
    sum
}

impl HermiteSeries {
    /// The same function by the modes of shape `to` up to `order` (at most [`MAX_ORDER`]), and the L² norm of what
    /// they leave out.
    ///
    /// `self` is a series over the shape `from`. Rounding error `order·ε` of the norm; the norm of the lost part is
    /// found to some per cent.
    ///
    /// Source: from the generating function (S1.2); the head of this file says how.
    ///
    /// ```
    /// use stokes::{HermiteSeries, ShapeMatrix};
    /// // a round Gaussian by one of twice the width: overlap 2·1·2/(1² + 2²), and 0.8² + 0.6² = 1
    /// let (narrow, wide) = (ShapeMatrix::isotropic(1.0)?, ShapeMatrix::isotropic(4.0)?);
    /// let (kept, lost) = HermiteSeries::fundamental(1.0).in_shape(&narrow, &wide, 0);
    /// assert!((kept.real_coefficient(0, 0) - 0.8).abs() < 1e-15);
    /// assert!((lost - 0.6).abs() < 1e-15);
    /// # Ok::<(), stokes::ShapeError>(())
    /// ```
    #[must_use]
    pub fn in_shape(&self, from: &ShapeMatrix, to: &ShapeMatrix, order: usize) -> (Self, f64) {
        const TAIL: usize = 32;
        let order = order.min(MAX_ORDER);
        let change = Change::between(from, to);
        let straight = self.with_root_turned_by(&change.turn_old);
        let stretched = stretched(&straight, change.stretch, order);
        let kept = Self::from_real_parts(order, &stretched);
        let (whole, rest) = (self.norm(), kept.norm());
        let difference = (whole - rest) * (whole + rest);
        let lost = if difference > 1e-8 * whole * whole {
            difference.sqrt()
        } else {
            // the difference has no digits left: add up the next orders instead
            let more = self::stretched(&straight, change.stretch, order + TAIL);
            crate::series::norm(&more[mode_count(order)..])
        };
        (kept.with_root_turned_by(&change.turn_new), lost)
    }
}

/// Real coefficients up to `order` after each axis is stretched by itself.
fn stretched(series: &HermiteSeries, stretch: [f64; 2], order: usize) -> Vec<f64> {
    // i^(a − n) of the complex coefficients is a sign, for a and n of equal parity
    let [first, second] = stretch.map(|ratio| {
        let plain = overlaps(ratio, series.order(), order);
        DMatrix::from_fn(plain.nrows(), plain.ncols(), |a, n| {
            let quarter_turns = a.abs_diff(n) / 2;
            if quarter_turns % 2 == 0 {
                plain[(a, n)]
            } else {
                -plain[(a, n)]
            }
        })
    });
    let old = series.order();
    let half = DMatrix::from_fn(order + 1, old + 1, |n, b| {
        (n % 2..=old - b)
            .step_by(2)
            .map(|a| first[(a, n)] * series.real_coefficient(a, b))
            .sum::<f64>()
    });
    let mut real = vec![0.0; mode_count(order)];
    for (n, m) in modes(order) {
        real[mode_index(n, m)] = (m % 2..=old)
            .step_by(2)
            .map(|b| second[(b, m)] * half[(n, b)])
            .sum();
    }
    real
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hermite::hermite;
    use nalgebra::Vector2;
    use proptest::prelude::*;

    /// The trapezoidal rule on the line: exact to rounding for functions that decay like these.
    fn quadrature(f: impl Fn(f64) -> f64) -> f64 {
        let step = 1.0 / 64.0;
        (-64 * 24..=64 * 24)
            .map(|i| f(f64::from(i) * step))
            .sum::<f64>()
            * step
    }

    #[test]
    fn one_dimensional_overlaps_are_the_integrals() {
        for ratio in [0.4, 1.0, 1.7, 3.0] {
            let found = overlaps(ratio, 20, 20);
            for (a, n) in [
                (0, 0),
                (2, 0),
                (0, 2),
                (1, 1),
                (3, 7),
                (12, 4),
                (20, 20),
                (19, 5),
                (5, 4),
            ] {
                let expected = quadrature(|t| hermite(a, t) * ratio.sqrt() * hermite(n, ratio * t));
                assert!((found[(a, n)] - expected).abs() < 2e-14, "{ratio} {a} {n}");
            }
        }
    }

    #[test]
    fn overlaps_of_high_orders_keep_the_norm() {
        // a narrower function lies within the orders of a wider one up to a + many: Σ_n O_an² = 1
        for (ratio, order, reach) in [(2.0, 64, 700), (0.5, 64, 700), (1.3, 160, 700)] {
            let found = overlaps(ratio, order, reach);
            for a in [0, 1, order / 2, order - 1, order] {
                let norm: f64 = found.row(a).iter().map(|o| o * o).sum();
                assert!((norm - 1.0).abs() < 1e-13, "{ratio} {a}: {norm}");
            }
        }
    }

    #[test]
    fn two_thin_shapes_overlap_by_their_determinants() {
        // O_00² = 4 |W₁||W₂|/|W₁ᵀW₁ + W₂ᵀW₂|, the sum here exact in integers
        let w1 = Matrix2::new(7545.0, -15005.0, 3988.0, -7931.0);
        let w2 = Matrix2::new(17046.0, 2979.0, 7722.0, 1349.0);
        let integers = |m: &Matrix2<f64>| m.map(|x| x as i128);
        let determinant = |m: &Matrix2<i128>| m.m11 * m.m22 - m.m12 * m.m21;
        let (i1, i2) = (integers(&w1), integers(&w2));
        let sum = i1.transpose() * i1 + i2.transpose() * i2;
        let ratio =
            (determinant(&i1).abs() * determinant(&i2).abs()) as f64 / determinant(&sum) as f64;
        let [first, second] = [w1, w2].map(|w| ShapeMatrix::from_root(&w).unwrap());
        let found = overlap((0, 0), &first, (0, 0), &second);
        // a few roundings in each of two determinants, the larger stretch and two roots
        assert!(
            (found / (2.0 * ratio.sqrt()) - 1.0).abs() < 32.0 * f64::EPSILON,
            "{found} {ratio}"
        );
    }

    fn shape(root: [f64; 4]) -> ShapeMatrix {
        let [a, b, c, d] = root;
        ShapeMatrix::from_root(&Matrix2::new(
            1.0 + 0.2 * a,
            0.3 * b,
            0.3 * c,
            1.0 + 0.2 * d,
        ))
        .unwrap()
    }

    #[test]
    fn overlaps_of_the_most_unlike_shapes_are_small_numbers_and_not_nonsense() {
        // round Gaussians: 2 w1 w2/(w1² + w2²), and ⟨h_2|h_0⟩ = √S · (−C)/√2 on one axis with S, C = ±1 on the other
        for [w1, w2] in [[1e-70, 1e70], [1e70, 1e-70], [1e-12, 1.0]] {
            let [first, second] = [w1, w2]
                .map(|w: f64| ShapeMatrix::from_root(&Matrix2::from_diagonal_element(w)).unwrap());
            let ratio = w1.min(w2) / w1.max(w2);
            let s = 2.0 * ratio / (1.0 + ratio * ratio);
            let plain = overlap((0, 0), &first, (0, 0), &second);
            assert!((plain / s - 1.0).abs() < 16.0 * f64::EPSILON, "{plain} {s}");
            let c = (w2 - w1).signum();
            let with_second = overlap((2, 0), &first, (0, 0), &second);
            assert!((with_second / (-c * s / 2f64.sqrt()) - 1.0).abs() < 16.0 * f64::EPSILON);
            let series = HermiteSeries::fundamental(1.0);
            let (kept, lost) = series.in_shape(&first, &second, 8);
            assert!((kept.norm().hypot(lost) - 1.0).abs() < 16.0 * f64::EPSILON);
        }
    }

    #[test]
    fn thin_shapes_of_one_direction_are_nearly_the_same() {
        // axes of 1 and 1e-12: a turn by 1e-13 is a tenth of the angle of the thin axis
        let thin = Matrix2::new(1.0, 0.0, 0.0, 1e12);
        let turn = |angle: f64| Matrix2::new(1.0, -angle, angle, 1.0);
        let [first, second] =
            [0.0, 1e-13].map(|angle| ShapeMatrix::from_root(&(thin * turn(angle))).unwrap());
        // W₂W₁⁻¹ = [1 −a/t; a t 1] with a t = 0.1: overlap of two Gaussians 2/√|1 + MᵀM| · √|M|
        let m: Matrix2<f64> = Matrix2::new(1.0, -1e-25, 0.1, 1.0);
        let expected = 2.0
            / (Matrix2::identity() + m.transpose() * m)
                .determinant()
                .sqrt();
        let found = overlap((0, 0), &first, (0, 0), &second);
        assert!(
            (found - expected).abs() < 16.0 * f64::EPSILON,
            "{found} {expected}"
        );
    }

    #[test]
    fn an_order_beyond_the_highest_is_cut_to_it() {
        let [from, to] = [1.0, 1.5].map(|v| ShapeMatrix::isotropic(v).unwrap());
        let (series, lost) = HermiteSeries::fundamental(1.0).in_shape(&from, &to, 300);
        assert_eq!(series.order(), MAX_ORDER);
        assert!(lost < 1e-16);
        let w = Vector2::new(0.3, -0.4);
        let expected = HermiteSeries::fundamental(1.0).value(&from, &w);
        assert!((series.value(&to, &w) - expected).norm() < 1e-14);
    }

    proptest! {
        #[test]
        fn a_series_in_another_shape_is_the_same_function(
            r1 in prop::array::uniform4(-1.0..1.0f64),
            r2 in prop::array::uniform4(-1.0..1.0f64),
            s in prop::collection::vec(-1.0..1.0f64, 15),
            x in -2.0..2.0f64, y in -2.0..2.0f64,
        ) {
            let (from, to) = (shape(r1), shape(r2));
            let series = HermiteSeries::from_real_coefficients(&s).unwrap();
            let (again, lost) = series.in_shape(&from, &to, 60);
            let w = Vector2::new(x, y);
            // |f − g| at a point is not bounded by its L² norm; by that of a truncated series of these widths, times 10
            let difference = (again.value(&to, &w) - series.value(&from, &w)).norm();
            prop_assert!(difference <= 10.0 * lost + 1e-12, "{difference} {lost}");
        }

        #[test]
        fn what_is_lost_and_what_is_kept_make_the_whole(
            r1 in prop::array::uniform4(-1.0..1.0f64),
            r2 in prop::array::uniform4(-1.0..1.0f64),
            s in prop::collection::vec(-1.0..1.0f64, 15),
            order in 0usize..40,
        ) {
            let series = HermiteSeries::from_real_coefficients(&s).unwrap();
            let (kept, lost) = series.in_shape(&shape(r1), &shape(r2), order);
            let whole = kept.norm().hypot(lost);
            prop_assert!((whole / series.norm() - 1.0).abs() < 1e-13);
        }

        #[test]
        fn overlaps_are_the_coefficients_of_a_changed_mode(
            r1 in prop::array::uniform4(-1.0..1.0f64),
            r2 in prop::array::uniform4(-1.0..1.0f64),
            a in 0usize..6, b in 0usize..6,
        ) {
            let (from, to) = (shape(r1), shape(r2));
            let mut s = vec![0.0; mode_count(a + b)];
            s[mode_index(a, b)] = 1.0;
            let series = HermiteSeries::from_real_coefficients(&s).unwrap();
            let (again, _) = series.in_shape(&from, &to, 12);
            for (n, m) in modes(12) {
                let expected = overlap((a, b), &from, (n, m), &to);
                let sign = if (a + b).abs_diff(n + m) % 4 == 0 { 1.0 } else { -1.0 };
                prop_assert!((sign * again.real_coefficient(n, m) - expected).abs() < 1e-14);
            }
        }
    }
}
