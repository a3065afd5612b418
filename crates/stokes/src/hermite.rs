//! The one-dimensional Hermite-Gauss functions `h_n`, orthonormal on the line, by stable recurrence.
//!
//! ```text
//! h_0(t) = π^(-1/4) e^(-t²/2)                     h_1 = √2 t h_0
//! h_{n+1} = √(2/(n+1)) t h_n − √(n/(n+1)) h_{n−1}
//! ```
//!
//! These are `Ψ_n` of Eq. (S1.1). The recurrence is stable upwards for every argument: inside the turning points
//! `|t| < √(2n+1)` both its solutions oscillate, outside `h_n` is the growing one. What fails is its start, since
//! `e^(-t²/2)` underflows at |t| = 38.6 (f64) and 13.2 (f32), long before `h_64` is negligible. Beyond
//! [`Real::NEAR`] the start therefore carries an exponent of its own.

use num_traits::Float;

use crate::gaussian;

/// Highest order of any Hermite-Gauss function or series in this crate.
pub const MAX_ORDER: usize = 256;

/// π^(-1/4), the value of `h_0(0)`.
pub(crate) const PI_FOURTH_ROOT_INVERSE: f64 = 0.751_125_544_464_942_5;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The number types in which Hermite-Gauss functions can be evaluated: `f32` and `f64`.
pub trait Real:
    Float + std::ops::AddAssign + std::fmt::Debug + Default + Send + Sync + sealed::Sealed + 'static
{
    /// Largest argument at which `e^(-t²/2)` is a normal number with room to spare.
    const NEAR: Self;

    /// The nearest number of this type.
    fn from_f64(x: f64) -> Self;

    /// The same number.
    fn to_f64(self) -> f64;

    /// `π^(-1/4) e^(-t²/2)` for `|t| ≤ NEAR`, to a few units in the last place.
    fn gaussian(self) -> Self;

    /// `e^(-x)` for `0 ≤ x ≤ NEAR²/2`, to a few units in the last place.
    ///
    /// ```
    /// use stokes::Real;
    /// assert!((1f64.decay() - 0.367_879_441_171_442_3).abs() < 2e-16);
    /// ```
    fn decay(self) -> Self;

    /// The factors of the recurrence.
    fn steps() -> &'static [[Self; 2]; MAX_ORDER];
}

impl Real for f64 {
    const NEAR: Self = 37.0;

    #[inline]
    fn from_f64(x: f64) -> Self {
        x
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn gaussian(self) -> Self {
        gaussian::of_f64(self)
    }

    #[inline(always)]
    fn decay(self) -> Self {
        gaussian::exp_f64(-self, 0.0, 1.0)
    }

    #[inline]
    fn steps() -> &'static [[Self; 2]; MAX_ORDER] {
        const { &STEPS_F64 }
    }
}

impl Real for f32 {
    const NEAR: Self = 12.5;

    #[inline]
    fn from_f64(x: f64) -> Self {
        x as Self
    }

    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn gaussian(self) -> Self {
        gaussian::of_f32(self)
    }

    #[inline(always)]
    fn decay(self) -> Self {
        gaussian::exp_f32(-self, 0.0, 1.0)
    }

    #[inline]
    fn steps() -> &'static [[Self; 2]; MAX_ORDER] {
        const { &STEPS_F32 }
    }
}

/// A number `mantissa · 2^exponent` that neither overflows nor underflows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaled {
    pub(crate) mantissa: f64,
    pub(crate) exponent: i32,
}

impl Scaled {
    const ZERO: Self = Self {
        mantissa: 0.0,
        exponent: 0,
    };

    pub(crate) fn value(self) -> f64 {
        libm::scalbn(self.mantissa, self.exponent)
    }
}

/// `e^(−(x + tail))` for any `x`, `None` where it is below 2^(-2^30) or the argument is not a number.
pub(crate) fn scaled_exponential(x: f64, tail: f64) -> Option<Scaled> {
    // e^(-x) = 2^(-m) e^(-(x − m ln 2)), with ln 2 in two parts, the first exact in 33 bits
    const LN2_HEAD: f64 = 6.931_471_803_691_238e-1;
    const LN2_TAIL: f64 = 1.908_214_929_270_587_7e-10;
    if x.is_nan() || x > 7e8 {
        return None;
    }
    let m = (x * std::f64::consts::LOG2_E).round();
    let rest = (x - m * LN2_HEAD) - m * LN2_TAIL + tail;
    Some(Scaled {
        mantissa: (-rest).exp(),
        exponent: -(m as i32),
    })
}

/// `π^(-1/4) e^(-t²/2)` for any argument, `None` where [`scaled_exponential`] is.
fn scaled_gaussian(t: f64) -> Option<Scaled> {
    let square = t * t;
    let mut gaussian = scaled_exponential(0.5 * square, 0.5 * t.mul_add(t, -square))?;
    gaussian.mantissa *= PI_FOURTH_ROOT_INVERSE;
    Some(gaussian)
}

/// Calls `take(n, h_n(t))` for n = 0..=order, with exponents, for any argument.
fn each_scaled(order: usize, t: f64, mut take: impl FnMut(usize, Scaled)) {
    const STEP: i32 = 400;
    let limit = libm::scalbn(1.0, STEP);
    let Some(mut now) = scaled_gaussian(t) else {
        // beyond |t| = 37,000 every order up to MAX_ORDER is below 1e-300,000,000
        let value = if t.is_nan() { t } else { 0.0 };
        for n in 0..=order {
            take(
                n,
                Scaled {
                    mantissa: value,
                    ..Scaled::ZERO
                },
            );
        }
        return;
    };
    let mut before = 0.0;
    take(0, now);
    for n in 0..order {
        let next = (n + 1) as f64;
        let value = (2.0 / next).sqrt() * t * now.mantissa - (n as f64 / next).sqrt() * before;
        before = now.mantissa;
        now.mantissa = value;
        if value.abs() > limit {
            before = libm::scalbn(before, -STEP);
            now.mantissa = libm::scalbn(value, -STEP);
            now.exponent += STEP;
        }
        take(n + 1, now);
    }
}

/// `h_n(t)` as a scaled number, for products whose factors underflow one by one.
pub(crate) fn hermite_scaled(n: usize, t: f64) -> Scaled {
    let mut last = Scaled::ZERO;
    each_scaled(n, t, |_, value| last = value);
    last
}

/// The orthonormal Hermite-Gauss function `h_n(t)`, dimensionless.
///
/// Source: Eq. (S1.1).
///
/// Accuracy in f64, for every finite argument and `n ≤ 256`, down to the smallest number of the type: the error is at most
/// `16 √(n+1) ε` of the envelope of `h_n` at `t`, which beyond the last zero is the function itself (the errors of the n
/// steps add up at random; `validation/stability.py` holds it to that and prints the share of it that is used).
///
/// In f32 one function costs the same in either precision, so that it is evaluated in f64 and rounded once; tables of many
/// orders and points ([`crate::hermite_all_at`], [`crate::all_modes_at`] …) run in f32. Not a number in, not a number out.
///
/// ```
/// // h_1(1) = √2 π^(-1/4) e^(-1/2)
/// assert!((stokes::hermite(1, 1.0_f64) - 0.644_288_365_113_475_6).abs() < 1e-15);
/// // the Gaussian alone is 5e-355 here, yet the function is an ordinary number
/// assert!(stokes::hermite(64, 40.4_f64) > 1e-300);
/// ```
#[must_use]
pub fn hermite<T: Real>(n: usize, t: T) -> T {
    let t = t.to_f64();
    if t.abs() > f64::NEAR || t.is_nan() {
        return T::from_f64(hermite_scaled(n, t).value());
    }
    let (mut before, mut now) = (0.0, t.gaussian());
    for i in 0..n {
        let [up, down] = step::<f64>(i);
        (before, now) = (now, up * t * now - down * before);
    }
    T::from_f64(now)
}

/// `√(2/(n+1))` and `√(n/(n+1))`, the recurrence's two factors, for n = 0..[`MAX_ORDER`].
type Steps<T> = [[T; 2]; MAX_ORDER];

const STEPS_F64: Steps<f64> = {
    let mut steps = [[0.0; 2]; MAX_ORDER];
    let mut n = 0;
    while n < MAX_ORDER {
        let next = n as u128 + 1;
        steps[n] = [root(128, next) / 8.0, root(n as u128, next)];
        n += 1;
    }
    steps
};

const STEPS_F32: Steps<f32> = {
    let mut steps = [[0.0; 2]; MAX_ORDER];
    let mut n = 0;
    while n < MAX_ORDER {
        steps[n] = [STEPS_F64[n][0] as f32, STEPS_F64[n][1] as f32];
        n += 1;
    }
    steps
};

/// The factors after `h_n`, for any n.
fn step<T: Real>(n: usize) -> [T; 2] {
    T::steps().get(n).copied().unwrap_or_else(|| {
        let next = (n + 1) as f64;
        [(2.0 / next).sqrt(), (n as f64 / next).sqrt()].map(T::from_f64)
    })
}

/// `√(p/q)` for p < 256, to 2^-59 and the rounding to f64.
const fn root(p: u128, q: u128) -> f64 {
    ((p << 118) / q).isqrt() as f64 / (1_u64 << 59) as f64
}

/// `h_0(t), h_1(t) …` into `values`, at most [`MAX_ORDER`] + 1 of them.
#[inline]
pub(crate) fn fill<T: Real>(t: T, values: &mut [T]) {
    fill_lanes(&[t], values.as_chunks_mut().0);
}

/// `h_0, h_1 …` of L arguments side by side into `values`, at most [`MAX_ORDER`] + 1 of them.
///
/// The loops over the lanes become vector code. Where a lane is beyond [`Real::NEAR`], or not a number, all take the
/// scalar road, so that each value is the same whatever its neighbours are.
#[inline(always)]
pub(crate) fn fill_lanes<T: Real, const L: usize>(t: &[T; L], values: &mut [[T; L]]) {
    if near(t) {
        fill_near(t, &gaussians(t), values);
    } else {
        fill_far(t, values);
    }
}

/// Whether no argument needs an exponent of its own.
#[inline(always)]
pub(crate) fn near<T: Real, const L: usize>(t: &[T; L]) -> bool {
    t.iter().fold(true, |near, t| near & (t.abs() <= T::NEAR))
}

/// `h_0` of arguments that are [`near`].
#[inline(always)]
pub(crate) fn gaussians<T: Real, const L: usize>(t: &[T; L]) -> [T; L] {
    let mut gaussians = [T::zero(); L];
    for l in 0..L {
        gaussians[l] = t[l].gaussian();
    }
    gaussians
}

/// As [`fill_lanes`], for arguments that are [`near`] and have the given `h_0`.
#[inline(always)]
pub(crate) fn fill_near<T: Real, const L: usize>(
    t: &[T; L],
    start: &[T; L],
    values: &mut [[T; L]],
) {
    let Some((first, rest)) = values.split_first_mut() else {
        return;
    };
    let (mut before, mut now) = ([T::zero(); L], *start);
    *first = now;
    for (value, [up, down]) in rest.iter_mut().zip(T::steps()) {
        let next = std::array::from_fn(|l| *up * t[l] * now[l] - *down * before[l]);
        *value = next;
        (before, now) = (now, next);
    }
}

#[cold]
#[inline(never)]
fn fill_far<T: Real, const L: usize>(t: &[T; L], values: &mut [[T; L]]) {
    for (l, t) in t.iter().enumerate() {
        if t.abs() <= T::NEAR {
            let (mut before, mut now) = (T::zero(), t.gaussian());
            for (n, value) in values.iter_mut().enumerate() {
                value[l] = now;
                let [up, down] = step::<T>(n);
                (before, now) = (now, up * *t * now - down * before);
            }
        } else if let Some(order) = values.len().checked_sub(1) {
            each_scaled(order, Real::to_f64(*t), |n, h| {
                values[n][l] = T::from_f64(h.value());
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_functions_are_the_textbook_polynomials() {
        for t in [-3.1, -0.4, 0.0, 1e-9, 0.7, 2.0, 5.5f64] {
            let h0 = PI_FOURTH_ROOT_INVERSE * (-0.5 * t * t).exp();
            let polynomials = [
                1.0,
                2.0 * t / 2f64.sqrt(),
                (4.0 * t * t - 2.0) / 8f64.sqrt(),
                (8.0 * t * t * t - 12.0 * t) / 48f64.sqrt(),
                (16.0 * t.powi(4) - 48.0 * t * t + 12.0) / 384f64.sqrt(),
            ];
            for (n, polynomial) in polynomials.into_iter().enumerate() {
                assert!((hermite(n, t) - h0 * polynomial).abs() < 2e-15, "{n} {t}");
            }
        }
    }

    #[test]
    fn functions_are_orthonormal_and_satisfy_their_equation() {
        // trapezoidal rule with step 1/16 out to 30: exact to rounding up to order 128
        let points: Vec<f64> = (-480..=480).map(|i| f64::from(i) / 16.0).collect();
        let mut table = vec![[0.0; 129]; points.len()];
        for (t, values) in points.iter().zip(&mut table) {
            fill(*t, values);
        }
        for (n, m) in [
            (0, 0),
            (0, 2),
            (17, 17),
            (40, 42),
            (64, 64),
            (63, 127),
            (128, 128),
            (128, 126),
        ] {
            let sum: f64 = table
                .iter()
                .map(|values| values[n] * values[m] / 16.0)
                .sum();
            let expected = if n == m { 1.0 } else { 0.0 };
            assert!((sum - expected).abs() < 1e-14, "{n} {m}: {sum}");
        }
        // a lowering step from both sides: √(2n) h_{n−1} = t h_n + h_n′, the derivative by the raising step
        for t in [0.3, 5.0, 11.0, 15.9] {
            let mut h = [0.0; 130];
            fill(t, &mut h);
            for n in 1..128 {
                let slope =
                    (n as f64 / 2.0).sqrt() * h[n - 1] - ((n + 1) as f64 / 2.0).sqrt() * h[n + 1];
                let scale = h[n - 1].abs().max(h[n + 1].abs()).max(h[n].abs()) * (n as f64).sqrt();
                assert!(
                    ((2.0 * n as f64).sqrt() * h[n - 1] - t * h[n] - slope).abs()
                        < 32.0 * f64::EPSILON * scale
                );
            }
        }
    }

    #[test]
    fn tiny_and_subnormal_arguments_are_as_good_as_zero() {
        for t in [f64::MIN_POSITIVE, 5e-324, -1e-310, 1e-160] {
            // h_1 = √2 t h_0 to first order, h_2 its value at 0
            let first = 2f64.sqrt() * t * PI_FOURTH_ROOT_INVERSE;
            assert!((hermite(1, t) - first).abs() <= 4.0 * f64::EPSILON * first.abs() + 5e-324);
            assert_eq!(hermite(2, t), hermite(2, 0.0));
            assert_eq!(hermite(3, -t), -hermite(3, t));
        }
    }

    #[test]
    fn both_roads_to_a_value_agree_where_they_meet() {
        for n in [0, 1, 30, 64, 255, 256] {
            for t in [-36.9, -20.0, -1.5, 0.0, 0.3, 12.0, 36.999] {
                let near = hermite(n, t);
                let far = hermite_scaled(n, t).value();
                // both carry the rounding of n steps
                assert!(
                    (near - far).abs() <= 1e-14 * near.abs().max(1e-3 * hermite(0, t)),
                    "{n} {t}: {near} {far}"
                );
            }
        }
    }

    #[test]
    fn far_arguments_end_in_zero_and_not_in_nonsense() {
        for t in [1e2, 1e4, 4e4, 1e9, 1e154, 1e300, f64::MAX, f64::INFINITY] {
            for n in [0, 1, 64, 256] {
                assert_eq!(hermite(n, t), 0.0, "{n} {t}");
                assert_eq!(hermite(n, -t as f32), 0.0, "{n} {t}");
            }
        }
        assert!(hermite(3, f64::NAN).is_nan() && hermite(0, f32::NAN).is_nan());
    }

    #[test]
    fn a_filled_table_is_the_single_functions() {
        let mut values = [[0.0; 2]; 101];
        for t in [
            [0.0, -2.5],
            [14.0, 0.1],
            [38.9, 1.0],
            [2.0, f64::NAN],
            [-45.0, 39.0],
        ] {
            fill_lanes(&t, &mut values);
            for (n, value) in values.iter().enumerate() {
                for l in 0..2 {
                    assert_eq!(value[l].to_bits(), hermite(n, t[l]).to_bits(), "{n} {t:?}");
                }
            }
        }
    }
}
