//! Smooth interfaces: Fresnel's equations as Mueller matrices.
//!
//! The first axis of every frame is s, `normal × propagation` of the ray in question, so that the matrix of a ray
//! that meets the interface is a [`DiattenuatingRetarder`]. Where the plane of incidence is undefined (normal
//! incidence) any axis will do, the same one for both rays.
//!
//! Transmission matrices hold the power weight `n₂ cos θ₂/(n₁ cos θ₁)`: they act on power, and reflection plus
//! transmission is 1. The change of *radiance* by `(n₂/n₁)²`, which belongs to the solid angle, is not in them.

use csdm::fresnel;
use num_complex::Complex64;
use stokes::DiattenuatingRetarder;
use thiserror::Error;

/// A refractive index that no medium of this kind has.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum IndexError {
    /// The index of a transparent medium.
    #[error("refractive index: found {0}, expected a number between 1e-70 and 1e70")]
    Transparent(f64),
    /// The index of an absorbing medium.
    #[error(
        "refractive index: found eta {eta} and k {k}, expected two numbers between 0 and 1e70, not both below 1e-70"
    )]
    Absorbing {
        /// Real part.
        eta: f64,
        /// Extinction coefficient.
        k: f64,
    },
}

fn transparent(n: f64) -> Result<f64, IndexError> {
    if (1e-70..=1e70).contains(&n) {
        Ok(n)
    } else {
        Err(IndexError::Transparent(n))
    }
}

/// What passes an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmitted {
    /// The Mueller matrix, power weights included, without the factor `(n₂/n₁)²` of radiance.
    pub element: DiattenuatingRetarder,
    /// Cosine of the angle of refraction, in `0.0..=1.0`.
    pub cos_t: f64,
}

/// Smooth interface between two transparent media.
///
/// ```
/// let glass = mueller16::DielectricInterface::new(1.0, 1.5)?;
/// // Brewster's angle: s-light only, 14.8 % of it
/// let m = glass.reflection(1.5f64.atan().cos());
/// assert!((m.mean - 0.0739645).abs() < 1e-7 && (m.difference - m.mean).abs() < 1e-15);
/// # Ok::<(), mueller16::IndexError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricInterface {
    n1: f64,
    n2: f64,
}

impl DielectricInterface {
    /// The interface from a medium of index `n1`, where the light comes from, to one of index `n2`.
    ///
    /// # Errors
    ///
    /// When an index is not a number between 1e-70 and 1e70.
    pub fn new(n1: f64, n2: f64) -> Result<Self, IndexError> {
        Ok(Self {
            n1: transparent(n1)?,
            n2: transparent(n2)?,
        })
    }

    /// Index of the medium that the light comes from.
    #[must_use]
    pub fn n_incident(&self) -> f64 {
        self.n1
    }

    /// Index of the medium behind the interface.
    #[must_use]
    pub fn n_transmitted(&self) -> f64 {
        self.n2
    }

    /// The interface met from the other side.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            n1: self.n2,
            n2: self.n1,
        }
    }

    /// Mueller matrix of reflection, total reflection included.
    ///
    /// `cos_i` in `0.0..=1.0`. Error below 1e-14; see [`csdm::fresnel`].
    #[inline]
    #[must_use]
    pub fn reflection(&self, cos_i: f64) -> DiattenuatingRetarder {
        let Self { n1, n2 } = *self;
        let squared = fresnel::normal_index_squared(cos_i, n1, n2);
        let (a_s, a_p) = (n1 * cos_i, n2 * n2 * cos_i);
        if squared > 0.0 {
            let w = squared.sqrt();
            let b_p = n1 * w;
            let (r_s, r_p) = ((a_s - w) / (a_s + w), (a_p - b_p) / (a_p + b_p));
            DiattenuatingRetarder::from_real_amplitudes(r_s, r_p)
        } else {
            total_reflection(a_s, a_p, n1, (-squared).sqrt())
        }
    }

    /// Mueller matrix of transmission and the cosine of refraction; `None` at and beyond the critical angle.
    ///
    /// `cos_i` in `0.0..=1.0`. Power weights are included, the `(n₂/n₁)²` of radiance is not. Error below 1e-14.
    ///
    /// ```
    /// let glass = mueller16::DielectricInterface::new(1.0, 1.5)?;
    /// let t = glass.transmission(1.0).expect("no total reflection into glass");
    /// assert!((t.element.mean - 0.96).abs() < 1e-15);
    /// # Ok::<(), mueller16::IndexError>(())
    /// ```
    #[inline]
    #[must_use]
    pub fn transmission(&self, cos_i: f64) -> Option<Transmitted> {
        let Self { n1, n2 } = *self;
        let squared = fresnel::normal_index_squared(cos_i, n1, n2);
        if squared <= 0.0 {
            return None;
        }
        // T_s = t_s² w/a = 4 a w/(a + w)², finite at grazing incidence where the weight w/a is not
        let w = squared.sqrt();
        let a = n1 * cos_i;
        let (t_s, t_p) = (1.0 / (a + w), n2 / (n2 * n2 * cos_i + n1 * w));
        let half = 2.0 * a * w;
        let (power_s, power_p) = (half * t_s * t_s, half * t_p * t_p);
        Some(Transmitted {
            element: DiattenuatingRetarder {
                mean: power_s + power_p,
                difference: power_s - power_p,
                cosine: 2.0 * half * t_s * t_p,
                sine: 0.0,
            },
            cos_t: w / n2,
        })
    }
}

/// `r = (a + iq)/(a − iq)` for s, and the same with `a_p`, `n₁ q` for p: modulus 1, so only the phase is computed.
#[inline]
fn total_reflection(a_s: f64, a_p: f64, n1: f64, q: f64) -> DiattenuatingRetarder {
    // r_s r_p* = u²/|u|² with u = (a_s + iq)(a_p − i n₁q)
    let b_p = n1 * q;
    let (re, im) = (a_s * a_p + q * b_p, q * a_p - a_s * b_p);
    let norm = re * re + im * im;
    let (cosine, sine) = if norm < 1e-300 {
        (1.0, 0.0)
    } else {
        ((re * re - im * im) / norm, 2.0 * re * im / norm)
    };
    DiattenuatingRetarder {
        mean: 1.0,
        difference: 0.0,
        cosine,
        sine,
    }
}

/// `part/whole`, and 1 where both vanish.
#[inline]
fn fraction(part: f64, whole: f64) -> f64 {
    if whole < 1e-300 { 1.0 } else { part / whole }
}

/// Smooth interface from a transparent medium to an absorbing one, `n₂ = η − ik`.
///
/// ```
/// // silver at 635.8 nm, 45°
/// let silver = mueller16::ConductorInterface::new(1.0, 0.136125, 4.010625)?;
/// let m = silver.reflection(0.5f64.sqrt());
/// assert!((m.mean - 0.9673489).abs() < 1e-6);
/// # Ok::<(), mueller16::IndexError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConductorInterface {
    n1: f64,
    n2: Complex64,
    /// η² − n₁², k² and 2ηk: n₂² − n₁², in parts that keep their digits where they cancel.
    contrast: [f64; 3],
}

impl ConductorInterface {
    /// The interface from a medium of index `n1`, where the light comes from, to one of index `eta − i k`.
    ///
    /// # Errors
    ///
    /// When `n1` is not a number between 1e-70 and 1e70, `eta` or `k` is not a number between 0 and 1e70,
    /// or both are below 1e-70.
    pub fn new(n1: f64, eta: f64, k: f64) -> Result<Self, IndexError> {
        let valid = |x: f64| (0.0..=1e70).contains(&x);
        if !valid(eta) || !valid(k) || eta.max(k) < 1e-70 {
            return Err(IndexError::Absorbing { eta, k });
        }
        let n1 = transparent(n1)?;
        Ok(Self {
            n1,
            n2: Complex64::new(eta, -k),
            contrast: [(eta - n1) * (eta + n1), k * k, 2.0 * eta * k],
        })
    }

    /// Index of the medium that the light comes from.
    #[must_use]
    pub fn n_incident(&self) -> f64 {
        self.n1
    }

    /// Index `η − ik` of the medium behind the interface.
    #[must_use]
    pub fn n_transmitted(&self) -> Complex64 {
        self.n2
    }

    /// Mueller matrix of reflection.
    ///
    /// `cos_i` in `0.0..=1.0`. Error below 1e-14. Grazing light at equal media is reflected whole.
    ///
    /// With `a = n₁ cos θ₁`, `t = n₁² sin² θ₁`, `w = n₂ cos θ₂` as in [`csdm::fresnel`]:
    ///
    /// ```text
    /// r_s = (a − w)/(a + w)      r_p = −r_s q      q = (a w − t)/(a w + t)      r_s r_p* = −|r_s|² q*
    /// ```
    ///
    /// so that every element but the phase is a sum of positive numbers, and `n₂²` is not needed.
    ///
    /// Source: Born & Wolf, Principles of Optics, 7th ed., section 1.5.2: `r_p/r_s = −cos(θ₁ + θ₂)/cos(θ₁ − θ₂)`
    /// in the axes used here, and `n₁ n₂ cos(θ₁ ± θ₂) = a w ∓ t`.
    #[inline]
    #[must_use]
    pub fn reflection(&self, cos_i: f64) -> DiattenuatingRetarder {
        let a = self.n1 * cos_i;
        let [contrast, square, twice] = self.contrast;
        let w = fresnel::sqrt_fourth_quadrant(contrast + a * a - square, twice);
        let t = self.n1 * self.n1 * (1.0 - cos_i) * (1.0 + cos_i);
        let loss = w.im * w.im;
        let (sum, difference) = (a + w.re, a - w.re);
        let power_s = fraction(difference * difference + loss, sum * sum + loss);
        let aw = a * a * (w.re * w.re + loss);
        let twice_at = 2.0 * a * t;
        let scale = power_s * fraction(1.0, aw + t * t + twice_at * w.re);
        DiattenuatingRetarder {
            mean: scale * (aw + t * t),
            difference: scale * twice_at * w.re,
            cosine: scale * (t * t - aw),
            sine: scale * twice_at * w.im,
        }
    }
}
