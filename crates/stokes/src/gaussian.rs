//! The Gaussian `π^(-1/4) e^(-t²/2)` without branches and calls, so that loops over it become vector code.
//!
//! ```text
//! t²/2 = g²/2 − d,   g the leading half of the digits of t, g² exact,   d = (g − t)(g + t)/2
//! e^(−t²/2) = 2^m e^r,   m = ⌊−g²/2 log₂e⌉,   r = (−g²/2 − m ln 2) + d,   |r| < 0.39
//! ```
//!
//! The rounding of `t²` alone would cost `t²/2` units in the last place (680 at t = 37), hence the two halves. `ln 2`
//! stands in two parts, of which the first times m is exact. `e^r` is its Taylor polynomial.

use crate::hermite::PI_FOURTH_ROOT_INVERSE;

/// `1/(k + 2)!`, the coefficients of `(e^r − 1 − r)/r²`.
const TAYLOR: [f64; 12] = {
    let (mut coefficients, mut factorial, mut k) = ([0.0; 12], 2.0, 0);
    while k < 12 {
        coefficients[k] = 1.0 / factorial;
        factorial *= (k + 3) as f64;
        k += 1;
    }
    coefficients
};

/// `π^(-1/4) e^(-t²/2)` for `|t| ≤ 37`, relative error below 4 ε; the polynomial is of degree 13 and off by 5e-18.
#[inline(always)]
pub(crate) fn of_f64(t: f64) -> f64 {
    let head = f64::from_bits(t.to_bits() & !0x07ff_ffff);
    let d = 0.5 * (head - t) * (head + t);
    exp_f64(-0.5 * head * head, d, PI_FOURTH_ROOT_INVERSE)
}

/// `factor e^(x + d)` for `−700 ≤ x ≤ 0` and a small d.
#[inline(always)]
pub(crate) fn exp_f64(x: f64, d: f64, factor: f64) -> f64 {
    // a sum with this number is rounded to a whole number, which stands in its last bits
    const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 · 2^52
    const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    const C: [f64; 12] = TAYLOR;
    let shifted = x * std::f64::consts::LOG2_E + WHOLE;
    let m = shifted - WHOLE;
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let r = (x - m * LN2[0]) - m * LN2[1] + d;
    // Estrin's scheme, whose products do not wait for each other
    let (r2, r4) = (r * r, (r * r) * (r * r));
    let low = (C[0] + C[1] * r) + r2 * (C[2] + C[3] * r);
    let middle = (C[4] + C[5] * r) + r2 * (C[6] + C[7] * r);
    let high = (C[8] + C[9] * r) + r2 * (C[10] + C[11] * r);
    let q = low + r4 * (middle + r4 * high);
    (factor * power) * (1.0 + (r + r2 * q))
}

/// `π^(-1/4) e^(-t²/2)` for `|t| ≤ 12.5`, relative error below 4 ε; the polynomial is of degree 7 and off by 2e-8.
#[inline(always)]
pub(crate) fn of_f32(t: f32) -> f32 {
    let head = f32::from_bits(t.to_bits() & !0xfff);
    let d = 0.5 * (head - t) * (head + t);
    exp_f32(-0.5 * head * head, d, PI_FOURTH_ROOT_INVERSE as f32)
}

/// `factor e^(x + d)` for `−80 ≤ x ≤ 0` and a small d.
#[inline(always)]
pub(crate) fn exp_f32(x: f32, d: f32, factor: f32) -> f32 {
    const WHOLE: f32 = 12_582_912.0; // 1.5 · 2^23
    const LN2: [f32; 2] = [0.693_359_375, -2.121_944_4e-4];
    const C: [f32; 6] = {
        let (mut c, mut k) = ([0.0; 6], 0);
        while k < 6 {
            c[k] = TAYLOR[k] as f32;
            k += 1;
        }
        c
    };
    let shifted = x * std::f32::consts::LOG2_E + WHOLE;
    let m = shifted - WHOLE;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    let r = (x - m * LN2[0]) - m * LN2[1] + d;
    let r2 = r * r;
    let q = (C[0] + C[1] * r) + r2 * ((C[2] + C[3] * r) + r2 * (C[4] + C[5] * r));
    (factor * power) * (1.0 + (r + r2 * q))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `π^(-1/4) e^(-t²/2)` to 1e-22 or so: the square in two parts, the tail as a factor of first order.
    fn exact(t: f64) -> f64 {
        let square = t * t;
        let tail = t.mul_add(t, -square);
        let value = PI_FOURTH_ROOT_INVERSE * (-0.5 * square).exp();
        value - value * 0.5 * tail
    }

    #[test]
    fn a_decay_is_the_exponential() {
        for i in 0..=400_000 {
            let x = 680.0 * f64::from(i) / 400_000.0;
            let error = (exp_f64(-x, 0.0, 1.0) / (-x).exp() - 1.0).abs();
            // in half units: 0.4 for r, 1 for the sum, 1 for the product; the comparison adds 1 and 1
            assert!(error < 3.0 * f64::EPSILON, "{x}: {error:e}");
            let x = (0.1 * x) as f32;
            let error = (f64::from(exp_f32(-x, 0.0, 1.0)) / (-f64::from(x)).exp() - 1.0).abs();
            assert!(error < 2.0 * f64::from(f32::EPSILON), "{x}: {error:e}");
        }
    }

    #[test]
    fn every_magnitude_keeps_its_relative_accuracy() {
        let (mut worst, mut worst32) = (0.0f64, 0.0f64);
        for i in -400_000..=400_000 {
            let t = 37.0 * f64::from(i) / 400_000.0;
            worst = worst.max((of_f64(t) / exact(t) - 1.0).abs());
            let t = (t * 12.5 / 37.0) as f32;
            worst32 = worst32.max((f64::from(of_f32(t)) / exact(f64::from(t)) - 1.0).abs());
        }
        // in half units: 0.4 for r, 0.4 and 1 for the two sums, 1 for the product; in f64 the comparison itself
        // adds 1 for its exp, 1 for its product and 1 for its difference; in f32 π^(-1/4) adds 1
        assert!(worst < 3.0 * f64::EPSILON, "{worst:e}");
        assert!(worst32 < 2.0 * f64::from(f32::EPSILON), "{worst32:e}");
    }
}
