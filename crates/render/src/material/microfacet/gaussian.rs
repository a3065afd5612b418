//! Gaussian slopes, those of Beckmann facets: the slope that a viewer sees, and the error function that it takes.

use std::f32::consts::FRAC_1_PI;

/// Slope along the view of a Beckmann facet of unit roughness that is seen at (cos, sin) from the normal.
///
/// Solves `F(x) = u F(cot θ)`, `F(x) = cos (1 + erf x)/2 + sin e^{−x²}/(2√π)`, by Newton steps in `b = erf x`, kept
/// inside a shrinking bracket. First guess: Jakob, An Improved Visible Normal Sampling Routine for the Beckmann
/// Distribution, 2014.
#[inline]
pub(super) fn visible_slope(cos: f32, sin: f32, u: f32) -> f32 {
    if sin < 1e-4 {
        // seen from above: the slopes are Gaussian
        return inverse_erf(2.0 * u - 1.0);
    }
    let half_root_pi = 0.5 * FRAC_1_PI.sqrt();
    let cumulative = |b: f32, x: f32| 0.5 * cos * (1.0 + b) + sin * half_root_pi * (-x * x).exp();
    let cot = cos / sin;
    let b_max = 1.0 - (-cot * cot).exp() * scaled_erfc(cot);
    let whole = cumulative(b_max, cot);
    let (target, tolerance) = (u * whole, 1e-5 * whole);
    let theta = sin.atan2(cos);
    let fit = 1.0 + theta * (-0.876 + theta * (0.4265 - 0.0594 * theta));
    let (mut low, mut high) = (-1.0f32, b_max);
    let mut b = b_max - (1.0 + b_max) * (1.0 - u).powf(fit);
    let mut x = 0.0;
    for _ in 0..12 {
        if !(b >= low && b <= high) {
            b = 0.5 * (low + high);
        }
        x = inverse_erf(b);
        let excess = cumulative(b, x) - target;
        if excess.abs() < tolerance {
            break;
        }
        if excess > 0.0 {
            high = b;
        } else {
            low = b;
        }
        b -= 2.0 * excess / (cos - x * sin);
    }
    x
}

/// e^{x²} erfc x for x ≥ 0, absolute error below 1.5e-7 e^{x²}.
///
/// Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 7.1.26.
#[inline]
pub(super) fn scaled_erfc(x: f32) -> f32 {
    let t = (1.0 + 0.3275911 * x).recip();
    t * (0.254829592
        + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))))
}

/// Inverse error function, relative error below 5e-7 in single precision; finite at ±1.
///
/// Source: Giles, Approximating the erfinv function, GPU Computing Gems Jade, 2011.
#[inline]
pub(super) fn inverse_erf(x: f32) -> f32 {
    let x = x.clamp(-0.999_999_9, 0.999_999_9);
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let horner = |coefficients: &[f32], w: f32| coefficients.iter().fold(0.0, |p, c| p * w + c);
    let p = if w < 5.0 {
        horner(
            &[
                2.81022636e-08,
                3.43273939e-07,
                -3.5233877e-06,
                -4.39150654e-06,
                0.00021858087,
                -0.00125372503,
                -0.00417768164,
                0.246640727,
                1.50140941,
            ],
            w - 2.5,
        )
    } else {
        horner(
            &[
                -0.000200214257,
                0.000100950558,
                0.00134934322,
                -0.00367342844,
                0.00573950773,
                -0.0076224613,
                0.00943887047,
                1.00167406,
                2.83297682,
            ],
            w.sqrt() - 3.0,
        )
    };
    p * x
}
