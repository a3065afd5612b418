//! Fresnel's equations a lane, in double precision as the theorem crates have them.

use crate::lanes::{Double, Mask, Real};
use crate::light::abreast::Elements;

/// What a smooth interface between transparent media does.
pub(super) struct Interface<R: Real> {
    /// Reflection, total reflection included.
    pub(super) reflection: Elements<R>,
    /// Transmission with its power weight, black beyond the critical angle.
    pub(super) transmission: Elements<R>,
    /// Cosine of refraction times the index on its side; 0 beyond the critical angle.
    pub(super) grazing: R::D,
    /// Where light passes.
    pub(super) passes: R::M,
}

/// See [`mueller16::DielectricInterface`]: light comes from index `n1`.
#[inline(always)]
pub(super) fn dielectric<R: Real>(cos_i: R, n1: R::D, n2: R::D) -> Interface<R> {
    let (zero, one, two) = (R::D::splat(0.0), R::D::splat(1.0), R::D::splat(2.0));
    let cos = R::D::wide(cos_i);
    let grazing = n1 * cos;
    let squared = (n2 - n1) * (n2 + n1) + grazing * grazing;
    let passes = (-squared).is_negative();
    let (a_s, a_p) = (grazing, n2 * n2 * cos);
    let w = squared.max(zero).sqrt();
    let b_p = n1 * w;
    // one division for both
    let (sum_s, sum_p) = (a_s + w, a_p + b_p);
    let over = one / (sum_s * sum_p);
    let (over_s, over_p) = (sum_p * over, sum_s * over);
    let (r_s, r_p) = ((a_s - w) * over_s, (a_p - b_p) * over_p);
    let half = R::D::splat(0.5);
    let (power_s, power_p) = (r_s * r_s, r_p * r_p);
    let real = Elements {
        mean: (half * (power_s + power_p)).narrow(),
        difference: (half * (power_s - power_p)).narrow(),
        cosine: (r_s * r_p).narrow(),
        sine: R::zero(),
    };
    let (t_s, t_p) = (over_s, n2 * over_p);
    let weight = two * a_s * w;
    let (power_s, power_p) = (weight * t_s * t_s, weight * t_p * t_p);
    let transmission = Elements {
        mean: (power_s + power_p).narrow(),
        difference: (power_s - power_p).narrow(),
        cosine: (two * weight * t_s * t_p).narrow(),
        sine: R::zero(),
    };
    let none = Elements::splat(crate::light::Element::BLACK);
    if (!passes & R::everywhere()).bits() == 0 {
        return Interface {
            reflection: real,
            transmission,
            grazing: w,
            passes,
        };
    }
    // modulus 1, so only the phase is worked out
    let q = (-squared).max(zero).sqrt();
    let b_p = n1 * q;
    let (re, im) = (a_s * a_p + q * b_p, q * a_p - a_s * b_p);
    let over = one / (re * re + im * im).max(R::D::splat(1e-300));
    let total = Elements {
        mean: R::one(),
        difference: R::zero(),
        cosine: ((re * re - im * im) * over).narrow(),
        sine: (two * re * im * over).narrow(),
    };
    Interface {
        reflection: Elements::select(passes, real, total),
        transmission: Elements::select(passes, transmission, none),
        grazing: w,
        passes,
    }
}

/// See [`mueller16::ConductorInterface::reflection`]: light comes from index 1; black where the index is 0.
#[inline(always)]
pub(super) fn conductor<R: Real>(cos_i: R, eta: R, k: R) -> Elements<R> {
    let (one, half) = (R::D::splat(1.0), R::D::splat(0.5));
    let tiny = R::D::splat(1e-300);
    let (cos, eta, k) = (R::D::wide(cos_i), R::D::wide(eta), R::D::wide(k));
    // w = √(re − i loss) in the fourth quadrant: the larger component first
    let re = (eta - one) * (eta + one) + cos * cos - k * k;
    let lost = (eta + eta) * k;
    let size = re.max(-re);
    let larger = (half * ((re * re + lost * lost).sqrt() + size)).sqrt();
    let smaller = half * lost / larger.max(tiny);
    let (larger, smaller) = (larger.narrow(), smaller.narrow());
    let negative = re.is_negative();
    let w_re = R::D::wide(R::select(negative, smaller, larger));
    let w_im = R::D::wide(-R::select(negative, larger, smaller));
    let t = (one - cos) * (one + cos);
    let loss = w_im * w_im;
    let (sum, difference) = (cos + w_re, cos - w_re);
    let aw = cos * cos * (w_re * w_re + loss);
    let twice = (cos + cos) * t;
    let whole = (sum * sum + loss) * (aw + t * t + twice * w_re);
    let scale = (difference * difference + loss) / whole.max(tiny);
    let black = (eta + k).narrow().le(R::zero());
    let scale = R::D::wide(scale.narrow().only(!black));
    Elements {
        mean: (scale * (aw + t * t)).narrow(),
        difference: (scale * twice * w_re).narrow(),
        cosine: (scale * (t * t - aw)).narrow(),
        sine: (scale * twice * w_im).narrow(),
    }
}
