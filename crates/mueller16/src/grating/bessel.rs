//! Bessel functions `J_0(z) … J_n(z)` of one argument at once: the orders of a sinusoidal phase.

/// Values above this are scaled down on the way, long before a square overflows.
const LARGE: f64 = 1e100;

/// `J_0(z), …, J_last(z)` for any finite z; one sweep of about `max(last, |z|)` steps.
///
/// Downward recurrence `J_(n−1) = (2n/z) J_n − J_(n+1)` from beyond the turning point `n = z`, scaled by
/// `J_0² + 2 Σ J_n² = 1`, a sum of one sign, and given its sign by `J_0 + 2 Σ J_2n = 1`.
/// Absolute error below 1e-13 for `|z| ≤ 5e3`.
///
/// Source: Gautschi, "Computational aspects of three-term recurrence relations", SIAM Rev. 9 (1967); Abramowitz &
/// Stegun, 9.1.46 and 9.1.76.
pub(super) fn bessel_j(z: f64, last: usize) -> Vec<f64> {
    let mut values = vec![0.0; last + 1];
    let x = z.abs();
    // J_1 of these is below the least number whose square counts
    if x < 1e-150 {
        values[0] = 1.0;
        return values;
    }
    let (mut above, mut here) = (0.0, 1.0);
    let (mut squares, mut evens) = (0.0, 0.0);
    for n in (0..=start(x, last)).rev() {
        if n <= last {
            values[n] = here;
        }
        let times = if n == 0 { 1.0 } else { 2.0 };
        squares += times * here * here;
        if n % 2 == 0 {
            evens += times * here;
        }
        (above, here) = (here, 2.0 * n as f64 / x * here - above);
        if here.abs() > LARGE {
            for value in [&mut above, &mut here, &mut evens] {
                *value /= LARGE;
            }
            squares /= LARGE * LARGE;
            for value in values.iter_mut().skip(n) {
                *value /= LARGE;
            }
        }
    }
    let scale = 1.0 / squares.sqrt().copysign(evens);
    for (n, value) in values.iter_mut().enumerate() {
        *value *= if z < 0.0 && n % 2 == 1 { -scale } else { scale };
    }
    values
}

/// Where `J_n` is below 1e-30 of its largest value, whatever the start: beyond `n = x + 18 x^(1/3)` it falls faster than
/// `e^(−(2√2/3) 18^(3/2))`, and for small x at least as `(x/2n)^n`.
fn start(x: f64, last: usize) -> usize {
    let beyond = |n: f64| (n + 18.0 * n.cbrt() + 20.0) as usize;
    beyond(x.max(last as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    /// `J_n(z) = (1/2π) ∫ cos(nτ − z sin τ) dτ`: the trapezoidal rule errs by `J_(m−n)(z)` for m points.
    fn integral(n: usize, z: f64) -> f64 {
        let m = 2 * (n + z.abs() as usize) + 100;
        let sum: f64 = (0..m)
            .map(|j| {
                let tau = 2.0 * PI * j as f64 / m as f64;
                (n as f64 * tau - z * tau.sin()).cos()
            })
            .sum();
        sum / m as f64
    }

    #[test]
    fn values_are_those_of_the_tables() {
        // Abramowitz & Stegun, table 9.1: J_0(1), J_1(1), J_2(1); J_0(10), J_2(10)
        let one = bessel_j(1.0, 2);
        for (found, expected) in one.into_iter().zip([
            0.765_197_686_557_966_6,
            0.440_050_585_744_933_5,
            0.114_903_484_931_900_5,
        ]) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        let ten = bessel_j(10.0, 2);
        assert!((ten[0] + 0.245_935_764_451_348_3).abs() < 1e-15);
        assert!((ten[2] - 0.254_630_313_685_120_6).abs() < 1e-15);
    }

    #[test]
    fn no_relief_has_no_order_but_the_first() {
        for z in [0.0, 1e-300, -1e-200, 5e-324] {
            assert_eq!(bessel_j(z, 3), [1.0, 0.0, 0.0, 0.0]);
        }
        // (z/2)^n/n!
        let small = bessel_j(-2e-60, 3);
        for (n, expected) in [1.0, -1e-60, 0.5e-120, -1e-180 / 6.0]
            .into_iter()
            .enumerate()
        {
            assert!((small[n] / expected - 1.0).abs() < 1e-14, "{n} {small:?}");
        }
    }

    #[test]
    fn orders_and_arguments_of_thousands_agree_with_another_library() {
        // libm says 1e-13 or so of its own for such arguments
        for z in [0.3, 7.7, 90.0, 1234.5, 5000.0] {
            let found = bessel_j(z, 10_000);
            for n in [0, 1, 2, 17, 90, 1000, 1234, 4990, 5000, 5040, 9999, 10_000] {
                let expected = libm::jn(n as i32, z);
                assert!(
                    (found[n] - expected).abs() < 1e-13,
                    "{n} {z}: {} {expected}",
                    found[n]
                );
            }
        }
    }

    proptest! {
        #[test]
        fn values_are_bessels_integral(n in 0usize..60, z in prop_oneof![-80.0..80.0f64, -1e-3..1e-3f64]) {
            let found = bessel_j(z, n)[n];
            // roundings of the phase (at most 200 rad) and of 400 terms
            prop_assert!((found - integral(n, z)).abs() < 1e-13, "{found}");
        }

        #[test]
        fn the_shares_of_all_orders_are_the_whole(z in 0.0..5e3f64) {
            let last = (z + 18.0 * z.cbrt()) as usize + 20;
            let values = bessel_j(z, last);
            let sum: f64 = values.iter().map(|j| j * j).sum();
            prop_assert!((2.0 * sum - values[0] * values[0] - 1.0).abs() < 1e-12);
        }
    }
}
