//! Many points at once give what one point gives, and that is what independent sums give.

use proptest::prelude::*;
use stokes::{
    HermiteSeries, Real, ShapeMatrix, all_modes, all_modes_at, contract, contract_at, hermite,
    hermite_all, hermite_all_at, mode_count, modes,
};

/// Mostly near, some in the tails, some beyond where the Gaussian underflows, some not numbers.
fn argument() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -6.0..6.0,
        2 => -14.0..14.0,
        1 => -45.0..45.0,
        1 => Just(f64::NAN),
        1 => Just(-0.0),
        1 => Just(f64::INFINITY),
    ]
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [argument(), argument()]
}

/// Equal bit by bit, where every NaN is as good as another.
fn same<T: Real>(x: T, y: T) -> bool {
    x == y && x.is_sign_negative() == y.is_sign_negative() || x.is_nan() && y.is_nan()
}

fn narrow(points: &[[f64; 2]]) -> Vec<[f32; 2]> {
    points.iter().map(|y| y.map(|t| t as f32)).collect()
}

fn batches_are_single_points<T: Real>(
    order: usize,
    points: &[[T; 2]],
    s: &[T],
) -> Result<(), TestCaseError> {
    let count = points.len();
    let mut batch = vec![T::one(); mode_count(order) * count];
    let mut single = vec![T::one(); mode_count(order)];
    let mut sums = vec![T::one(); count];
    all_modes_at(order, points, &mut batch);
    contract_at(order, s, points, &mut sums);
    for (p, y) in points.iter().enumerate() {
        all_modes(order, *y, &mut single);
        let mut functions = [vec![T::one(); order + 1], vec![T::one(); order + 1]];
        for (t, column) in y.iter().zip(&mut functions) {
            hermite_all(order, *t, column);
        }
        let mut size = T::zero();
        for (i, (a, b)) in modes(order).enumerate() {
            let (mode, expected) = (batch[i * count + p], functions[0][a] * functions[1][b]);
            prop_assert!(
                same(mode, single[i]),
                "{order} {y:?} ({a}, {b}): {mode:?} {:?}",
                single[i]
            );
            prop_assert!(
                same(mode, expected),
                "{order} {y:?} ({a}, {b}): {mode:?} {expected:?}"
            );
            size += (s[i] * mode).abs();
        }
        let sum = contract(order, s, *y);
        if size.is_nan() {
            prop_assert!(
                sum.is_nan() && sums[p].is_nan(),
                "{order} {y:?}: {sum:?} {:?}",
                sums[p]
            );
            continue;
        }
        let exact: f64 = single
            .iter()
            .zip(s)
            .map(|(h, s)| Real::to_f64(*h) * Real::to_f64(*s))
            .sum();
        // a term goes through order + 1 sums along the one axis and as many along the other, and three products
        let rounding = (2 * order + 5) as f64 * 0.5 * Real::to_f64(T::epsilon());
        // what underflows on the way is below the least normal number, once for every term
        let least = (single.len() * 2) as f64 * Real::to_f64(T::min_positive_value());
        let limit = rounding * Real::to_f64(size) + least;
        for found in [sum, sums[p]] {
            prop_assert!(
                (Real::to_f64(found) - exact).abs() <= limit,
                "{order} {y:?}: {found:?} instead of {exact:e}, size {size:?}"
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_point_has_the_same_modes_alone_and_among_others(
        order in 0usize..=64,
        points in prop::collection::vec(point(), 0..30),
        s in prop::collection::vec(-1.0..1.0f64, mode_count(64)),
    ) {
        let s = &s[..mode_count(order)];
        let s32: Vec<f32> = s.iter().map(|s| *s as f32).collect();
        batches_are_single_points(order, &points, s)?;
        batches_are_single_points(order, &narrow(&points), &s32)?;
    }

    #[test]
    fn a_table_in_f32_is_within_its_rounding_of_the_functions(
        order in 0usize..=64, t in argument(),
    ) {
        let t = t as f32;
        let mut column = vec![1.0; order + 1];
        hermite_all(order, t, &mut column);
        for (n, in_table) in column.iter().enumerate() {
            let exact = hermite(n, f64::from(t));
            let single = hermite(n, t);
            // one function is rounded once; a table carries n steps of three roundings, each at most ε/2 of |h| < 0.8,
            // damped by the oscillation to the growth of a random walk: four standard deviations of it
            prop_assert!(same(single, exact as f32), "{n} {t}");
            let walk = 4.0 * (3.0 * (n + 1) as f64).sqrt() * 0.5 * f64::from(f32::EPSILON) * 0.8;
            prop_assert!((f64::from(*in_table) - exact).abs() <= walk || exact.is_nan(), "{n} {t}");
        }
    }

    #[test]
    fn a_table_of_functions_is_the_single_functions(
        order in 0usize..=256,
        arguments in prop::collection::vec(argument(), 1..30),
    ) {
        let count = arguments.len();
        let mut table = vec![1.0; (order + 1) * count];
        let mut column = vec![1.0; order + 1];
        hermite_all_at(order, &arguments, &mut table);
        for (p, t) in arguments.iter().enumerate() {
            hermite_all(order, *t, &mut column);
            for n in 0..=order {
                prop_assert!(same(column[n], hermite(n, *t)), "{n} {t}");
                prop_assert!(same(column[n], table[n * count + p]), "{n} {t}");
            }
        }
    }

    #[test]
    fn the_value_of_a_series_is_the_sum_over_its_modes(
        order in 0usize..=40,
        y in [-7.0..7.0f64, -7.0..7.0f64],
        s in prop::collection::vec(-1.0..1.0f64, mode_count(40)),
        symmetric in any::<bool>(),
    ) {
        let mut s = s[..mode_count(order)].to_vec();
        for (s, (a, b)) in s.iter_mut().zip(modes(order)) {
            if symmetric && (a + b) % 2 == 1 {
                *s = 0.0;
            }
        }
        let series = HermiteSeries::from_real_coefficients(&s).unwrap();
        let shape = ShapeMatrix::isotropic(1.0).unwrap();
        let value = series.value(&shape, &y.into());
        let (mut re, mut im, mut sum, mut size) = (0.0, 0.0, 0.0, 0.0);
        for (a, b) in modes(order) {
            let mode = hermite(a, y[0]) * hermite(b, y[1]);
            let term = series.coefficient(a, b) * mode;
            re += term.re;
            im += term.im;
            sum += series.real_coefficient(a, b) * mode;
            size += term.norm();
        }
        // this sum one term after the other, the other one as in the test above
        let limit = (s.len() + 2 * order + 6) as f64 * 0.5 * f64::EPSILON * size + 1e-300;
        prop_assert!((value.re - re).abs() <= limit && (value.im - im).abs() <= limit, "{value} {re} {im}");
        prop_assert!((series.real_sum(&y.into()) - sum).abs() <= limit);
    }
}

/// The modes of high order are no product of a lower one: all sizes of scratch, up to the largest order.
#[test]
fn every_order_has_its_modes() {
    let points = [[0.3, -1.7], [4.0, 11.0], [0.0, 0.0], [38.0, -0.2]];
    let wide: Vec<[f64; 2]> = points.iter().cycle().take(11).copied().collect();
    for order in (0..=20).chain([31, 32, 33, 34, 63, 64, 65, 66, 128, 255, 256]) {
        let mut single = vec![f64::NAN; mode_count(order)];
        for points in [&points[..], &wide] {
            let mut batch = vec![f64::NAN; mode_count(order) * points.len()];
            all_modes_at(order, points, &mut batch);
            for (p, y) in points.iter().enumerate() {
                all_modes(order, *y, &mut single);
                for (i, (a, b)) in modes(order).enumerate() {
                    assert_eq!(
                        single[i],
                        hermite(a, y[0]) * hermite(b, y[1]),
                        "{order} {y:?} ({a}, {b})"
                    );
                    assert_eq!(
                        single[i],
                        batch[i * points.len() + p],
                        "{order} {y:?} ({a}, {b})"
                    );
                }
            }
        }
    }
}

/// One coefficient at a time, at a point where no mode of low order vanishes.
#[test]
fn each_coefficient_meets_its_own_mode() {
    let y = [0.81, -1.37];
    for order in [0, 1, 2, 3, 5, 8, 9, 12, 17] {
        for (i, (a, b)) in modes(order).enumerate() {
            let mut s = vec![0.0; mode_count(order)];
            s[i] = 1.0;
            let mode = hermite(a, y[0]) * hermite(b, y[1]);
            let mut sums = [0.0; 3];
            contract_at(order, &s, &[y; 3], &mut sums);
            assert_eq!(
                [contract(order, &s, y), sums[1]],
                [mode; 2],
                "order {order}, mode ({a}, {b})"
            );
        }
    }
}

#[test]
fn no_points_are_no_trouble() {
    all_modes_at::<f64>(4, &[], &mut []);
    contract_at::<f32>(1, &[1.0; 3], &[], &mut []);
    hermite_all_at::<f64>(4, &[], &mut []);
}
