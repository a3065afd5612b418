//! Gaussian slopes, those of Beckmann facets: how much of them a viewer sees, the slope that is drawn of these, and the
//! error functions that it takes.
//!
//! For a viewer at height `z` over the plane and `r` along it, in slopes of unit roughness, facets of slope x along the
//! view count by `(z − x r) e^{−x²}/√π` up to `x = z/r`, where they are seen edge on:
//!
//! ```text
//! F(x) = z (1 + erf x)/2 + r e^{−x²}/(2√π)        F(z/r) = r W(z/r): all that is seen
//! ```

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::LazyLock;

use crate::lanes::{Bits, Mask, Real, exp, ln, polynomial};

/// All that is seen of Gaussian slopes of unit roughness from height `z` and distance `r`: `z (1 + Λ)`, relative error
/// below 6e-7.
///
/// `W(a) = a (1 + erf a)/2 + e^{−a²}/(2√π)` by a rational fit of least relative error for `a < 3.2`; from there on it is a.
#[inline(always)]
pub(in crate::material) fn seen_area<R: Real>(z: R, r: R) -> R {
    let a = z / r;
    let p = [
        0.0137517133,
        0.0259941666,
        0.0791214371,
        0.259710139,
        0.440836057,
        0.282094768,
    ];
    let q = [
        -0.000457370414,
        0.0215044117,
        -0.0293605903,
        0.292562183,
        -0.209739913,
        1.0,
    ];
    let fit = r * polynomial(a, &p) / polynomial(a, &q);
    R::select(a.lt(R::splat(3.2)), fit, z)
}

/// Slope along the view of a facet that is seen from height `z` and distance `r`, of unit roughness: solves `F(x) = u area`
/// within 1e-6 of `area`, which is F(z/r).
///
/// One step of Halley's method from an interpolated guess.
#[inline(always)]
pub(in crate::material) fn visible_slope<R: Real>(z: R, r: R, area: R, u: R) -> R {
    let half = R::splat(0.5);
    let gap = GUESSES.gap(z, r, u);
    let inverse = r.recip();
    let x = (z - gap) * inverse;
    let bell = exp(-(x * x));
    let half_tail = half * z * scaled_erfc(x.abs());
    let edges = R::splat(0.5 * FRAC_1_PI.sqrt()) * r;
    let below = R::select(
        x.gt(R::zero()),
        z + bell * (edges - half_tail),
        bell * (edges + half_tail),
    );
    let excess = R::splat(PI.sqrt()) * (below - u * area);
    let slope = (bell + bell) * gap * gap + excess * ((gap + gap) * x + r);
    let step = (gap + gap) * excess / slope;
    // where facets are all but edge on `excess` is little more than rounding
    let room = half * gap * inverse;
    let x = x - step.max(-room).min(room);
    // seen from above: Gaussian slopes, less the first order in r/z
    let above = r.lt(R::splat(1e-4) * z);
    if !above.any() {
        return x;
    }
    let gaussian = inverse_erf(u + u - R::one()) - half * r / z;
    R::select(above, gaussian, x)
}

/// Where visible slopes are, roughly.
///
/// Holds `(z − x r)/(z + r)`, which stays smooth and positive up to edge-on facets, at even steps of `r/(z + r)`; and for u
/// below and above a half at half and whole powers of two of the distance from 0, or from 1.
struct Guesses([[[f32; COLUMNS]; 2]; ROWS + 1]);

/// Steps of `r/(z + r)`.
const ROWS: usize = 16;

/// From 2⁻²⁴ to 2⁻¹, in steps that double every second time.
const COLUMNS: usize = 2 * 23 + 1;

/// Bits of a number in single precision below those that name its column.
const WITHIN: u32 = 22;

const LEAST: f32 = 1.0 / 16_777_216.0;

static GUESSES: LazyLock<Guesses> = LazyLock::new(Guesses::new);

impl Guesses {
    fn new() -> Self {
        let mut guesses = [[[1.0; COLUMNS]; 2]; ROWS + 1];
        for (row, halves) in guesses.iter_mut().enumerate().skip(1) {
            let r = row as f64 / ROWS as f64;
            for column in 0..COLUMNS {
                let bits = LEAST.to_bits() + ((column as u32) << WITHIN);
                let u = f64::from(f32::from_bits(bits));
                for (half, u) in halves.iter_mut().zip([u, 1.0 - u]) {
                    half[column] = ((1.0 - r) - slope_by_bisection(1.0 - r, r, u) * r) as f32;
                }
            }
        }
        Self(guesses)
    }

    /// `z − x r` of a slope.
    #[inline(always)]
    fn gap<R: Real>(&self, z: R, r: R, u: R) -> R {
        let (one, half) = (R::one(), R::splat(0.5));
        let whole = z + r;
        let across = r / whole;
        let rows = across * R::splat(ROWS as f32);
        let row = rows.min(R::splat(ROWS as f32 - 0.5)).to_int();
        let down = rows - R::of_int(row);
        let low = u.lt(half);
        let distance = R::select(low, u, one - u);
        // a column begins where the exponent changes, or halfway to there
        let bits = distance.clamp(LEAST, 0.499_999_97).bits() - R::B::splat(LEAST.to_bits());
        let column = bits.shr::<{ WITHIN as i32 }>();
        let within = R::of_int(bits & R::B::splat((1 << WITHIN) - 1));
        let along = within * R::splat(1.0 / (1 << WITHIN) as f32);
        let (zero, columns) = (R::B::splat(0), R::B::splat(COLUMNS as u32));
        let place = row * (columns + columns) + R::select_bits(low, zero, columns) + column;
        let values = self.0.as_flattened().as_flattened();
        let upper = between(values, place, along);
        let lower = between(values, place + columns + columns, along);
        // beside the first row x falls by half of r/z
        let first = half * (R::splat(1.0 / ROWS as f32) - across).max(R::zero());
        whole * (upper + down * (lower - upper)) - r * first
    }
}

/// Between the value at a place and the next one.
#[inline(always)]
fn between<R: Real>(values: &[f32], place: R::B, along: R) -> R {
    let here = R::gather(values, place);
    let next = R::gather(values, place + R::B::splat(1));
    here + along * (next - here)
}

/// Solves `F(x) = u F(z/r)` within 1e-8.
fn slope_by_bisection(z: f64, r: f64, u: f64) -> f64 {
    let half_root_pi = 0.5 * std::f64::consts::FRAC_1_PI.sqrt();
    let seen = |x: f64| 0.5 * z * libm::erfc(-x) + r * half_root_pi * (-x * x).exp();
    let (mut low, mut high) = (-6.0, (z / r).min(6.0));
    let target = u * seen(z / r);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if seen(middle) > target {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// e^{x²} erfc x for x from 0 to 4.5, relative error below 5e-7.
///
/// A polynomial in `1/(1 + 0.36 x)` of least relative error there.
#[inline(always)]
fn scaled_erfc<R: Real>(x: R) -> R {
    let t = (R::one() + R::splat(0.36) * x).recip();
    let p = [
        -0.17173287,
        0.59846739,
        -0.41475279,
        0.48163856,
        0.08169038,
        0.22314428,
        0.20154495,
    ];
    t * polynomial(t, &p)
}

/// Inverse error function, relative error below 5e-7 in single precision; finite at ±1.
///
/// Source: Giles, Approximating the erfinv function, GPU Computing Gems Jade, 2011.
#[inline(always)]
pub(in crate::material) fn inverse_erf<R: Real>(x: R) -> R {
    let x = Real::clamp(x, -0.999_999_9, 0.999_999_9);
    let w = -ln((R::one() - x) * (R::one() + x));
    let near = [
        2.81022636e-08,
        3.43273939e-07,
        -3.5233877e-06,
        -4.39150654e-06,
        0.00021858087,
        -0.00125372503,
        -0.00417768164,
        0.246640727,
        1.50140941,
    ];
    let mut p = polynomial(w - R::splat(2.5), &near);
    let far = w.ge(R::splat(5.0));
    if far.any() {
        let tail = [
            -0.000200214257,
            0.000100950558,
            0.00134934322,
            -0.00367342844,
            0.00573950773,
            -0.0076224613,
            0.00943887047,
            1.00167406,
            2.83297682,
        ];
        let v = w.max(R::zero()).sqrt() - R::splat(3.0);
        p = R::select(far, polynomial(v, &tail), p);
    }
    p * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F(x) in double precision.
    fn below(z: f64, r: f64, x: f64) -> f64 {
        0.5 * z * libm::erfc(-x) + 0.5 * r * (-x * x).exp() / std::f64::consts::PI.sqrt()
    }

    /// Views from the normal to grazing, and numbers down to the last one next to 0 and 1.
    fn views() -> impl Iterator<Item = (f32, f32)> {
        let steps = (1..2000).map(|k| std::f64::consts::FRAC_PI_2 * f64::from(k) / 2000.0);
        let ends = (1..60).flat_map(|k| {
            let small = 10f64.powf(-0.1 * f64::from(k));
            [small, std::f64::consts::FRAC_PI_2 - small]
        });
        steps
            .chain(ends)
            .map(|theta| (theta.cos() as f32, theta.sin() as f32))
    }

    #[test]
    fn what_is_seen_of_all_slopes_is_the_integral_over_them() {
        // the fit errs by 1e-7, 3.2 instead of W(3.2) by 1.4e-7, the rounding of two polynomials by 3e-7
        for (z, r) in views() {
            let (z64, r64) = (f64::from(z), f64::from(r));
            let expected = below(z64, r64, z64 / r64);
            let ratio = f64::from(seen_area(z, r)) / expected;
            assert!((ratio - 1.0).abs() < 6e-7, "{z} {r}: {ratio}");
        }
    }

    #[test]
    fn a_slope_has_its_share_of_what_is_seen_below_it() {
        let numbers = (0..500).map(|k| (k as f32 + 0.37) / 500.0);
        let ends = (0..24).flat_map(|k| {
            let small = LEAST * (1u32 << k) as f32;
            [small, 1.0 - small, 1.37 * small]
        });
        let numbers: Vec<f32> = numbers.chain(ends).chain([0.0]).collect();
        let mut worst = 0.0f64;
        for (z, r) in views() {
            let (z64, r64) = (f64::from(z), f64::from(r));
            let area = seen_area(z, r);
            for &u in &numbers {
                let x = f64::from(visible_slope(z, r, area, u));
                assert!(x * r64 < z64 * (1.0 + 1e-6), "{z} {r} {u}: {x}");
                let share = below(z64, r64, x) / below(z64, r64, z64 / r64);
                let error = (share - f64::from(u)).abs();
                worst = worst.max(error);
                // the guess, after its step, errs by 4e-7, and the area by 6e-7 at most
                assert!(error < 1e-6, "{z} {r} {u}: {x}, {share}");
            }
        }
        println!("largest error {worst:.2e}");
    }

    #[test]
    fn the_scaled_error_function_is_as_accurate_as_stated() {
        for k in 0..4500 {
            let x = k as f32 * 1e-3;
            let exact = libm::erfc(f64::from(x)) * f64::from(x).powi(2).exp();
            let ratio = f64::from(scaled_erfc(x)) / exact;
            assert!((ratio - 1.0).abs() < 5e-7, "{x}: {ratio}");
        }
    }
}
