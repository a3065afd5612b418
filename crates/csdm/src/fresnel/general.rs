//! Reflection and transmission of one interface for any two indices.

use num_complex::Complex64;

use super::Amplitudes;

/// What one interface makes of a field of amplitude 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceAmplitudes {
    /// Of the reflected light, `r_s` and `r_p`.
    pub reflected: Amplitudes,
    /// Of the transmitted light, `t_s` and `t_p`, without power weights.
    pub transmitted: Amplitudes,
}

/// Amplitudes of reflection and transmission from a medium of index `n1` into one of index `n2`.
///
/// Both indices are `η − ik`; `cos_i` in `0.0..=1.0`. The transmitted wave is the one with
/// `Im(n₂ cos θ₂) ≤ 0`, which decays away from the interface. In an absorbing first medium a real `cos_i` stands for
/// a wave that absorption has not made inhomogeneous.
///
/// For a transparent first medium the error is below 1e-14, next to the critical angle too: `(n₂ cos θ₂)²` is
/// evaluated in doubled precision. Where both the waves graze equal media (0/0) the light is reflected, −1.
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., section 1.5.2, Eqs. (20), (21) with the p axis of Verdet.
///
/// ```
/// use num_complex::Complex64;
/// let f = csdm::fresnel::amplitudes(Complex64::new(1.0, 0.0), Complex64::new(1.5, 0.0), 1.0);
/// assert!((f.reflected.s + 0.2).norm() < 1e-15 && (f.transmitted.p - 0.8).norm() < 1e-15);
/// ```
#[must_use]
pub fn amplitudes(n1: Complex64, n2: Complex64, cos_i: f64) -> InterfaceAmplitudes {
    let w = normal_index_of(n1, n2, cos_i);
    let a = n1 * cos_i;
    // p divided by n₂: n₂ c ± n₁ w/n₂, so that no square of an index occurs
    let (b, cos_t) = (n2 * cos_i, w / n2);
    let (sum_s, sum_p) = (a + w, b + n1 * cos_t);
    InterfaceAmplitudes {
        reflected: Amplitudes {
            s: quotient(a - w, sum_s, -1.0),
            p: quotient(b - n1 * cos_t, sum_p, -1.0),
        },
        transmitted: Amplitudes {
            s: quotient(2.0 * a, sum_s, 0.0),
            p: quotient(2.0 * a, sum_p, 0.0),
        },
    }
}

/// `a/b`, or the `limit` where b is 0.
fn quotient(a: Complex64, b: Complex64, limit: f64) -> Complex64 {
    if b == Complex64::ZERO {
        limit.into()
    } else {
        a / b
    }
}

/// `w = n₂ cos θ₂ = √(n₂² − n₁² sin² θ₁)` with `Im w ≤ 0`, to the last digits at every angle.
pub(crate) fn normal_index_of(n1: Complex64, n2: Complex64, cos_i: f64) -> Complex64 {
    let minus_sin_squared = Doubled::product(cos_i, cos_i) + Doubled(-1.0, 0.0);
    let [re1, im1] = square(n1);
    let [re2, im2] = square(n2);
    let re = re2 + re1 * minus_sin_squared;
    let im = im2 + im1 * minus_sin_squared;
    let root = Complex64::new(re.0, im.0).sqrt();
    if root.im > 0.0 { -root } else { root }
}

/// Real and imaginary part of z².
fn square(z: Complex64) -> [Doubled; 2] {
    let re = Doubled::product(z.re, z.re) + Doubled::product(-z.im, z.im);
    [re, Doubled::product(2.0 * z.re, z.im)]
}

/// An unevaluated sum of two numbers, the second below half a unit in the last place of the first.
///
/// Source: Dekker, Numerische Mathematik 18, 224 (1971).
#[derive(Clone, Copy)]
struct Doubled(f64, f64);

impl Doubled {
    /// `a·b`, exactly.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self(high, a.mul_add(b, -high))
    }

    /// `a + b`, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self(high, (a - (high - part)) + (b - part))
    }
}

impl std::ops::Add for Doubled {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.0, other.0), Self::sum(self.1, other.1));
        let first = Self::sum(high.0, high.1 + low.0);
        Self::sum(first.0, first.1 + low.1)
    }
}

impl std::ops::Mul for Doubled {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = Self::product(self.0, other.0);
        Self::sum(high.0, high.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{reflection, reflection_dielectric, transmission_dielectric};
    use super::*;
    use proptest::prelude::*;

    fn close(a: Amplitudes, b: Amplitudes, tolerance: f64) -> bool {
        (a.s - b.s).norm() < tolerance && (a.p - b.p).norm() < tolerance
    }

    #[test]
    fn silver_in_absorbing_glass_has_the_amplitudes_of_a_50_digit_calculation() {
        let (n1, n2) = (Complex64::new(1.5, -0.02), Complex64::new(0.18, -3.4));
        let f = amplitudes(n1, n2, 0.25881904510252074);
        let (r, t) = (f.reflected, f.transmitted);
        for (found, re, im) in [
            (r.s, -0.96693807962417294, 0.20497354969339373),
            (r.p, -0.51455460507914917, -0.78435332722314311),
            (t.s, 0.033061920375827064, 0.20497354969339373),
            (t.p, 0.35898164662565769, 0.19054833218946912),
        ] {
            assert!((found - Complex64::new(re, im)).norm() < 1e-15);
        }
    }

    #[test]
    fn next_to_the_critical_angle_the_root_keeps_its_digits() {
        // n₁ = 1.25, n₂ = 1, sin θ = 0.8 at cos θ = 0.6; 50-digit value for the binary 0.6 + 2^−40
        let (n1, n2) = (Complex64::new(1.25, 0.0), Complex64::new(1.0, 0.0));
        let w = normal_index_of(n1, n2, 0.6 + 2f64.powi(-40));
        assert!((w.re / 1.3058563981013032542e-6 - 1.0).abs() < 1e-15 && w.im == 0.0);
    }

    fn cosine() -> impl Strategy<Value = f64> {
        prop_oneof![4 => 0.0..=1.0, 1 => 0.0..1e-9, 1 => 1.0 - 1e-9..=1.0, 1 => Just(1.0)]
    }

    fn index() -> impl Strategy<Value = Complex64> {
        let k = prop_oneof![2 => Just(0.0), 2 => 0.0..6.0f64, 1 => 0.0..1e-9f64];
        (0.05..4.0f64, k).prop_map(|(eta, k)| Complex64::new(eta, -k))
    }

    proptest! {
        #[test]
        fn a_transparent_first_medium_gives_the_amplitudes_of_the_hot_path(
            n1 in 0.5..2.0f64, n2 in index(), cos_i in cosine(),
        ) {
            let f = amplitudes(n1.into(), n2, cos_i);
            // the hot path rounds w² to 1e-15 of n₁²: what that is worth in w is counted
            let w = normal_index_of(n1.into(), n2, cos_i).norm();
            let tolerance = 1e-14 + 1e-14 / w.max(1e-7);
            prop_assert!(close(f.reflected, reflection(cos_i, n1, n2), tolerance));
            if n2.im == 0.0 {
                prop_assert!(close(f.reflected, reflection_dielectric(cos_i, n1, n2.re), tolerance));
                if let Some(t) = transmission_dielectric(cos_i, n1, n2.re) {
                    let t = Amplitudes { s: t.s.into(), p: t.p.into() };
                    prop_assert!(close(f.transmitted, t, tolerance));
                }
            }
        }

        #[test]
        fn fields_along_the_interface_are_continuous(n1 in index(), n2 in index(), cos_i in 1e-3..=1.0f64) {
            // E_s: 1 + r_s = t_s; H_s: n₁(1 + r_p) = n₂ t_p; E_p: (1 − r_p) cos θ₁ = t_p cos θ₂
            let f = amplitudes(n1, n2, cos_i);
            let cos_t = normal_index_of(n1, n2, cos_i) / n2;
            let (r, t) = (f.reflected, f.transmitted);
            let scale = 1.0 + r.s.norm() + r.p.norm() + t.p.norm() * cos_t.norm();
            prop_assert!((1.0 + r.s - t.s).norm() < 1e-14 * scale);
            prop_assert!((n1 * (1.0 + r.p) - n2 * t.p).norm() < 1e-14 * scale * (n1.norm() + n2.norm()));
            prop_assert!(((1.0 - r.p) * cos_i - t.p * cos_t).norm() < 1e-14 * scale);
        }
    }
}
