//! Reflection and transmission of one interface for any two indices.

use num_complex::Complex64;

use super::Amplitudes;
use crate::doubled::Doubled;
use crate::scale::power_of_two;

/// What one interface makes of a field of amplitude 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceAmplitudes {
    /// Of the reflected light, `r_s` and `r_p`.
    pub reflected: Amplitudes,
    /// Of the transmitted light, `t_s` and `t_p`, without the weights of [`power_weight`].
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

/// What turns squared amplitudes of transmission into shares of the power, `[s, p]`: `Re(n₂ cos θ₂)/(n₁ cos θ₁)` and
/// `Re(n₂* cos θ₂)/(n₁ cos θ₁)`.
///
/// From a transparent medium of index `n1` into any other of index `n2 = η − ik`; `cos_i` in `0.0..=1.0`. The two
/// differ in an absorbing second medium only. 0 beyond the critical angle, infinite at grazing incidence (where the
/// amplitudes are 0).
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., section 1.5.3; for complex indices the normal components of the
/// energy flow behind the interface.
///
/// ```
/// use num_complex::Complex64;
/// use csdm::fresnel;
/// // gold at 633 nm, 75°: what is not reflected goes in
/// let (gold, cos_i) = (Complex64::new(0.183, -3.43), 75f64.to_radians().cos());
/// let f = fresnel::amplitudes(1.0.into(), gold, cos_i);
/// let [_, weight] = fresnel::power_weight(1.0, gold, cos_i);
/// let balance = f.reflected.p.norm_sqr() + weight * f.transmitted.p.norm_sqr();
/// assert!((balance - 1.0).abs() < 1e-14);
/// ```
#[must_use]
pub fn power_weight(n1: f64, n2: Complex64, cos_i: f64) -> [f64; 2] {
    let w = normal_index_of(n1.into(), n2, cos_i);
    let grazing = n1 * cos_i;
    // a wave that carries no power has the weight 0 at grazing incidence too
    [w.re, (n2.conj() * (w / n2)).re].map(|flux| if flux == 0.0 { 0.0 } else { flux / grazing })
}

/// `a/b`, or the `limit` where b is 0; without underflow of the square of a small b.
pub(crate) fn quotient(a: Complex64, b: Complex64, limit: f64) -> Complex64 {
    if b == Complex64::ZERO {
        return limit.into();
    }
    let scale = power_of_two(b.norm());
    (a / scale) / (b / scale)
}

/// `w = n₂ cos θ₂ = √(n₂² − n₁² sin² θ₁)` with `Im w ≤ 0`, to the last digits at every angle.
pub(crate) fn normal_index_of(n1: Complex64, n2: Complex64, cos_i: f64) -> Complex64 {
    let minus_sin_squared = Doubled::product(cos_i, cos_i) + Doubled(-1.0, 0.0);
    let [re1, im1] = square(n1);
    let [re2, im2] = square(n2);
    let re = re2 + re1 * minus_sin_squared;
    let im = im2 + im1 * minus_sin_squared;
    let root = Complex64::new(re.0, im.0).sqrt();
    // 0 − root: an evanescent wave has the real part +0, not −0
    if root.im > 0.0 {
        Complex64::ZERO - root
    } else {
        root
    }
}

/// Real and imaginary part of z².
fn square(z: Complex64) -> [Doubled; 2] {
    let re = Doubled::product(z.re, z.re) + Doubled::product(-z.im, z.im);
    [re, Doubled::product(2.0 * z.re, z.im)]
}

#[cfg(test)]
mod tests {
    use super::super::{reflection, reflection_dielectric, transmission_dielectric};
    use super::*;
    use proptest::prelude::*;

    fn close(a: Amplitudes, b: Amplitudes, [s, p]: [f64; 2]) -> bool {
        (a.s - b.s).norm() <= s && (a.p - b.p).norm() <= p
    }

    /// How far the amplitudes of reflection in the hot path may be off, `[s, p]`.
    ///
    /// Its w² has four terms of at most five roundings; those of w' = w + δw are off by
    /// `2 n₁ c δw/((n₁ c + w)(n₁ c + w'))` and `2 n₁ c n₂² δw/((n₂² c + n₁ w)(n₂² c + n₁ w'))`. The rest is some sixteen
    /// roundings: neither sum cancels.
    fn rounding(n1: f64, n2: Complex64, cos_i: f64) -> [f64; 2] {
        let w = normal_index_of(n1.into(), n2, cos_i);
        let squared = 10.0 * f64::EPSILON * n2.norm_sqr().max(n1 * n1);
        let off = (squared / w.norm()).min(squared.sqrt());
        let sum_s = (n1 * cos_i + w).norm();
        let sum_p = (n2 * n2 * cos_i + n1 * w).norm();
        let by_w = 2.0 * n1 * cos_i * off;
        [
            by_w / (sum_s * (sum_s - off).max(n1 * cos_i)),
            by_w * n2.norm_sqr() / (sum_p * (sum_p - n1 * off).max(0.0)),
        ]
        .map(|error| error + 16.0 * f64::EPSILON)
    }

    fn agrees_with_the_hot_path(n1: f64, n2: Complex64, cos_i: f64) -> bool {
        let f = amplitudes(n1.into(), n2, cos_i);
        let reflected = rounding(n1, n2, cos_i);
        let mut agrees = close(f.reflected, reflection(cos_i, n1, n2), reflected);
        if n2.im == 0.0 {
            let real = reflection_dielectric(cos_i, n1, n2.re);
            agrees &= close(f.reflected, real, reflected);
            if let Some(t) = transmission_dielectric(cos_i, n1, n2.re) {
                let t = Amplitudes {
                    s: t.s.into(),
                    p: t.p.into(),
                };
                // t_s = 1 + r_s, n₂ t_p = n₁ (1 + r_p)
                let [s, p] = reflected;
                agrees &= close(f.transmitted, t, [s, p * n1.max(n2.re) / n2.re]);
            }
        }
        agrees
    }

    #[test]
    fn into_a_much_thinner_medium_the_hot_path_loses_what_is_counted() {
        for (n1, n2, cos_i) in [
            (1.7396657101012856, 0.17267729016095926, 0.9954475679608317),
            (1.9646286483144049, 0.05, 0.9999999999272782),
        ] {
            for n2 in [Complex64::new(n2, 0.0), Complex64::new(n2, -0.0)] {
                assert!(agrees_with_the_hot_path(n1, n2, cos_i), "{n1} {n2} {cos_i}");
            }
        }
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
    fn light_that_only_just_grazes_stays_finite_and_passive() {
        for cos_i in [0.0, f64::MIN_POSITIVE, 1e-300, 1e-160, 1e-150] {
            for (n1, n2) in [(1.0, 1.0), (3.0, 3.0), (1.0, 1.5), (1.5, 1.0)] {
                let f = amplitudes(n1.into(), n2.into(), cos_i);
                let (r, t) = (f.reflected, f.transmitted);
                assert!(r.s.norm() <= 1.0 + 1e-15 && r.p.norm() <= 1.0 + 1e-15);
                assert!(t.s.norm() <= 2.0 && t.p.norm() <= 2.0 * n1.max(n2));
                if n1 > n2 {
                    assert_eq!(power_weight(n1, n2.into(), cos_i), [0.0, 0.0]);
                }
            }
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
            prop_assert!(agrees_with_the_hot_path(n1, n2, cos_i));
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
