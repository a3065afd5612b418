//! Fresnel amplitudes of a smooth interface, written for the hot path of a renderer.
//!
//! ```text
//! w   = n₂ cos θ₂ = √(n₂² − n₁² sin² θ₁),   Im w ≤ 0 (decays into an absorbing or evanescent medium)
//! r_s = (n₁ c − w)/(n₁ c + w)               t_s = 2 n₁ c/(n₁ c + w)
//! r_p = (n₂² c − n₁ w)/(n₂² c + n₁ w)       t_p = 2 n₁ n₂ c/(n₂² c + n₁ w)         c = cos θ₁
//! ```
//!
//! Light comes from a transparent medium of index `n₁ > 0`; `n₂ = η − ik` with `η, k ≥ 0`. Frames: x is s, and
//! `r_p = −r_s` at normal incidence, `t_p = t_s`. Only one square root and no complex polar form is involved: `w`
//! stands in for the angle of refraction everywhere. `w²` is evaluated as `(n₂ − n₁)(n₂ + n₁) + n₁² c²`, which
//! keeps its digits at grazing incidence and for nearly equal media.
//!
//! `w²` errs by a few roundings of `max(n₁², |n₂|²)`, hence w by that over |w|, and amplitudes by
//! `|δr_s| = |δt_s| = 2 n₁ c |δw|/|n₁ c + w|²` and `|δr_p| = |n₂/n₁| |δt_p| = 2 n₁ c |n₂|² |δw|/|n₂² c + n₁ w|²`: below
//! 1e-14/|w| for the indices of glasses and metals, and more for `t_p` into a medium much thinner than the first (w is 0
//! at the critical angle; see [`amplitudes`] for full accuracy there). They are finite and passive for every `cos_i` in
//! `0.0..=1.0` and indices between 1e-70 and 1e70; η and k above 1e70 count as 1e70. Where an expression is 0/0 (grazing
//! light at equal media, `n₂ = 0`) the light is reflected, −1.
//!
//! Source: Born & Wolf, Principles of Optics, 7th ed., section 1.5.2, Eqs. (20), (21) with the p axis of Verdet;
//! section 14.2 for complex indices.

mod general;

use num_complex::Complex64;

pub use general::{InterfaceAmplitudes, amplitudes, power_weight};
pub(crate) use general::{normal_index_of, quotient};

/// Amplitudes along the two axes of an interface, dimensionless, in `exp(+iωt)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes {
    /// For the field perpendicular to the plane of incidence.
    pub s: Complex64,
    /// For the field in the plane of incidence.
    pub p: Complex64,
}

/// Light that passes an interface between transparent media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// Amplitude of the field perpendicular to the plane of incidence, `t_s`; real and positive.
    pub s: f64,
    /// Amplitude of the field in the plane of incidence, `t_p`; real and positive.
    pub p: f64,
    /// Cosine of the angle of refraction, in `0.0..=1.0`.
    pub cos_t: f64,
    /// `n₂ cos θ₂/(n₁ cos θ₁)`: power across the interface is this times the squared amplitude.
    pub power_weight: f64,
}

/// Squares of larger indices could overflow.
const LARGEST_INDEX: f64 = 1e70;

/// `(n₂ cos θ₂)²` for transparent media; negative beyond the critical angle.
#[inline]
#[must_use]
pub fn normal_index_squared(cos_i: f64, n1: f64, n2: f64) -> f64 {
    let grazing = n1 * cos_i;
    (n2 - n1) * (n2 + n1) + grazing * grazing
}

/// `w = n₂ cos θ₂`, the normal component of the transmitted wave vector over `k₀`, with `Im w ≤ 0` and `Re w ≥ 0`.
///
/// ```
/// use num_complex::Complex64;
/// // total reflection at 45° in glass: an evanescent wave, e^{−i w z k₀} decays
/// let w = csdm::fresnel::normal_index(0.5f64.sqrt(), 1.5, Complex64::new(1.0, 0.0));
/// assert!((w - Complex64::new(0.0, -0.125f64.sqrt())).norm() < 1e-15);
/// ```
#[inline]
#[must_use]
pub fn normal_index(cos_i: f64, n1: f64, n2: Complex64) -> Complex64 {
    let (eta, k) = components(n2);
    let re = normal_index_squared(cos_i, n1, eta) - k * k;
    sqrt_fourth_quadrant(re, 2.0 * eta * k)
}

/// `η` and `k` of `n = η − ik`.
#[inline]
fn components(n: Complex64) -> (f64, f64) {
    debug_assert!(
        n.re >= 0.0 && n.im <= 0.0,
        "an index is η − ik with η, k ≥ 0"
    );
    (n.re.min(LARGEST_INDEX), (-n.im).min(LARGEST_INDEX))
}

/// `√(re − i loss)` with `loss ≥ 0`, in the fourth quadrant.
///
/// The larger component is a sum of positive numbers; the smaller one follows from the product of the two.
#[inline]
#[must_use]
pub fn sqrt_fourth_quadrant(re: f64, loss: f64) -> Complex64 {
    let modulus = (re * re + loss * loss).sqrt();
    let squared = 0.5 * (modulus + re.abs());
    let larger = squared.sqrt();
    // 0/0 only where both are 0 (or their squares underflow): there the root is 0 as well. The quotient does not wait for
    // the root
    let smaller = if squared > 0.0 {
        0.5 * loss / squared * larger
    } else {
        0.0
    };
    if re >= 0.0 {
        Complex64::new(larger, -smaller)
    } else {
        Complex64::new(smaller, -larger)
    }
}

/// Complex cosine of the angle of refraction, `cos θ₂ = w/n₂`, with `Im(n₂ cos θ₂) ≤ 0`.
///
/// `cos_i` in `0.0..=1.0`, `n1` real and positive, `n2 = η − ik` not zero.
///
/// ```
/// use num_complex::Complex64;
/// let cos_t = csdm::fresnel::refract(45f64.to_radians().cos(), 1.0, Complex64::new(1.5, 0.0));
/// assert!((cos_t.re.acos().to_degrees() - 28.1255057020557).abs() < 1e-12);
/// ```
#[inline]
#[must_use]
pub fn refract(cos_i: f64, n1: f64, n2: Complex64) -> Complex64 {
    let (eta, k) = components(n2);
    let w = normal_index(cos_i, n1, n2);
    // w/(η − ik), both scaled to the size of n₂ so that no square overflows
    let scale = 1.0 / eta.max(k);
    let (a, b) = (eta * scale, k * scale);
    let (re, im) = (w.re * scale, w.im * scale);
    let inverse = 1.0 / (a * a + b * b);
    Complex64::new((re * a - im * b) * inverse, (im * a + re * b) * inverse)
}

/// Amplitudes of reflection at a medium of complex index.
///
/// `cos_i` in `0.0..=1.0`, `n1` real and positive, `n2 = η − ik`. See the module page for accuracy.
///
/// Silver at 635.8 nm, 45°:
/// ```
/// use num_complex::Complex64;
/// let r = csdm::fresnel::reflection(0.5f64.sqrt(), 1.0, Complex64::new(0.136125, -4.010625));
/// assert!((0.5 * (r.s.norm_sqr() + r.p.norm_sqr()) - 0.9673489).abs() < 1e-6);
/// ```
#[inline]
#[must_use]
pub fn reflection(cos_i: f64, n1: f64, n2: Complex64) -> Amplitudes {
    let (eta, k) = components(n2);
    let w = normal_index(cos_i, n1, n2);
    let square_re = ((eta - k) * (eta + k)) * cos_i;
    let square_im = -2.0 * eta * k * cos_i;
    Amplitudes {
        s: contrast(n1 * cos_i, 0.0, w.re, w.im),
        p: contrast(square_re, square_im, n1 * w.re, n1 * w.im),
    }
}

/// `(a − b)/(a + b)` of two complex numbers, −1 where the sum is zero or its square underflows.
#[inline]
fn contrast(a_re: f64, a_im: f64, b_re: f64, b_im: f64) -> Complex64 {
    let (sum_re, sum_im) = (a_re + b_re, a_im + b_im);
    let (dif_re, dif_im) = (a_re - b_re, a_im - b_im);
    let norm = sum_re * sum_re + sum_im * sum_im;
    if norm < 1e-300 {
        return Complex64::new(-1.0, 0.0);
    }
    let inverse = 1.0 / norm;
    Complex64::new(
        (dif_re * sum_re + dif_im * sum_im) * inverse,
        (dif_im * sum_re - dif_re * sum_im) * inverse,
    )
}

/// Amplitudes of reflection between transparent media, total reflection included.
///
/// `cos_i` in `0.0..=1.0`, indices real and positive. The amplitudes are real below the critical angle and have
/// modulus 1 beyond it.
///
/// At Brewster's angle, 56.31° at n = 1.5, only s-light is reflected:
/// ```
/// let r = csdm::fresnel::reflection_dielectric(1.5f64.atan().cos(), 1.0, 1.5);
/// assert!((r.s.norm_sqr() - 0.1479).abs() < 1e-4 && r.p.norm() < 1e-16);
/// ```
#[inline]
#[must_use]
pub fn reflection_dielectric(cos_i: f64, n1: f64, n2: f64) -> Amplitudes {
    let squared = normal_index_squared(cos_i, n1, n2);
    let (a_s, a_p) = (n1 * cos_i, n2 * n2 * cos_i);
    if squared > 0.0 {
        let w = squared.sqrt();
        let b_p = n1 * w;
        Amplitudes {
            s: ((a_s - w) / (a_s + w)).into(),
            p: ((a_p - b_p) / (a_p + b_p)).into(),
        }
    } else {
        let q = (-squared).sqrt();
        Amplitudes {
            s: contrast(a_s, 0.0, 0.0, -q),
            p: contrast(a_p, 0.0, 0.0, -n1 * q),
        }
    }
}

/// Amplitudes of transmission between transparent media; `None` at and beyond the critical angle.
///
/// `cos_i` in `0.0..=1.0` and above 0, indices real and positive.
///
/// ```
/// let t = csdm::fresnel::transmission_dielectric(1.0, 1.0, 1.5).expect("no total reflection");
/// assert_eq!((t.s, t.p, t.cos_t, t.power_weight), (0.8, 0.8, 1.0, 1.5));
/// assert!(csdm::fresnel::transmission_dielectric(0.5, 1.5, 1.0).is_none());
/// ```
#[inline]
#[must_use]
pub fn transmission_dielectric(cos_i: f64, n1: f64, n2: f64) -> Option<Transmission> {
    let squared = normal_index_squared(cos_i, n1, n2);
    if squared <= 0.0 || cos_i <= 0.0 {
        return None;
    }
    let w = squared.sqrt();
    let a = n1 * cos_i;
    Some(Transmission {
        s: 2.0 * a / (a + w),
        p: 2.0 * a * n2 / (n2 * n2 * cos_i + n1 * w),
        cos_t: w / n2,
        power_weight: w / a,
    })
}

#[cfg(test)]
mod tests;
