//! K-correlation (fractal, Matérn, exponential) autocorrelations as mixtures of Gaussian widths.
//!
//! ```text
//! F{R}(q) = P₀ (1 + Q²)^(−c) = (P₀/Γ(c)) ∫ t^(c−1) e^(−t(1+Q²)) dt          Q = |Dq|
//! R(x)    = ∫ w(t) e^(−u²/4t) dt,   w ∝ t^(c−2) e^(−t)                      u = |D⁻ᵀx|
//! ```
//!
//! With an inner scale b the weight is `t^(c−2) e^(−t − b²/4t)`, that is `R(u) = R_K(√(u² + b²))/R_K(b)`: the power above
//! `1/b` is finite for every c, and the lobe is `∝ (1+Q²)^(−c/2) K_c(b √(1+Q²))`.
//!
//! The integral over `s = ln t` is summed by the trapezoidal rule of step h. Its errors:
//!
//! * discretisation. On the line `Im s = a` the modulus of the integrand is that of the same integrand with the exponents
//!   times `γ = cos a`; as `z^ν e^z K_c(z)` grows with z for `ν = max(c, ½)`, the integral of the modulus is at most
//!   `γ^(−ν) e^(z(1−γ))` of the lobe itself, `z = b √(1+Q²)`. The rule then errs by at most
//!   `2 γ^(−ν) e^(z(1−γ))/(e^(2πa/h) − 1)`, relative to the lobe at every Q; a is chosen, h follows.
//! * the wide end, where the sum beyond t is at most `Γ(c, t) ≤ t^c e^(−t)/(t − max(c − 1, 0))`.
//! * the narrow end, where the sum below t is at most `t^c e^(−b²/4t)/c`. It is not dropped but becomes one Gaussian of
//!   the same weight and the same lobe at 0, so that `R(0) = 1` stays and what is left is at most that sum times
//!   `min(1, t Q²)`.
//!
//! Source: Trefethen & Weideman, "The exponentially convergent trapezoidal rule", SIAM Review 56 (2014), Theorem 5.1.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Matrix2;

use super::error::check;
use super::{Autocorrelation, AutocorrelationError, GaussianFamily, GaussianTerm};
use crate::accuracy::{Approximation, Method, Tolerance};

/// `|Dq|` up to which the lobe's relative error is held where nothing else is asked for.
pub(super) const REACH: f64 = 100.0;

/// Where the inner scale has taken e⁻¹⁰ of the lobe: the relative error is held up to there.
const FARTHEST: f64 = 10.0;

/// Of the lobe's largest value: the relative error is held where the lobe is more.
const LEAST_LOBE: f64 = 1e-250;

/// `t` below which a spectrum without inner scale is one Gaussian, whatever is asked for.
const LEAST: f64 = 1e-28;

/// An autocorrelation with the lobe `P₀ (1 + |Dq|²)^(−c)`: the K-correlation or ABC model of polished and fractal surfaces.
///
/// `R(0) = 1`. The exponent c is in `0.01..=100.0`; 1.5 is the exponential `e^(−|x|/l)`, and in general
/// `R = 2^(2−c)/Γ(c−1) u^(c−1) K_(c−1)(u)` (Matérn). Up to c = 1 the power of the lobe diverges at large q and an inner
/// scale is needed.
///
/// Source: Church & Takacs, "The optimal estimation of finish parameters", Proc. SPIE 1530 (1991); with an inner scale
/// Shkarofsky, Can. J. Phys. 46, 2133 (1968).
///
/// ```
/// use mueller16::{KCorrelation, Tolerance};
/// use nalgebra::{Matrix2, Vector2};
/// let exponential = KCorrelation::new(&Matrix2::from_diagonal_element(2e-6), 1.5)?;
/// let (r, chosen) = exponential.autocorrelation(Tolerance::relative(1e-6)?)?;
/// // e^(−1) at one correlation length
/// assert!((r.value(&Vector2::new(2e-6, 0.0)).re - 0.367_879_441).abs() < 1e-6);
/// // 2π l² at the centre of the lobe
/// assert!((r.spectrum(&Vector2::zeros()) / (6.283_185_307 * 4e-12) - 1.0).abs() < 1e-6);
/// assert!(chosen.terms < 60);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KCorrelation {
    root: Matrix2<f64>,
    exponent: f64,
    inner: f64,
    reach: f64,
}

/// The nodes of a mixture, and a bound on its error.
#[derive(Clone, Debug)]
pub(super) struct Mixture {
    /// Positive weights whose sum is 1.
    pub(super) terms: Vec<GaussianTerm>,
    /// Error of the lobe over the lobe, as far as the reach, and over its largest value everywhere.
    pub(super) error: f64,
}

impl KCorrelation {
    /// The lobe `(1 + |Dq|²)^(−exponent)` of an exponent above 1; `root` D, 2×2, m (`l` times 1 where it is isotropic).
    ///
    /// # Errors
    ///
    /// When the exponent is not between 1.01 and 100, or the root is singular or outside 1e-30 to 1e30 m.
    pub fn new(root: &Matrix2<f64>, exponent: f64) -> Result<Self, AutocorrelationError> {
        let expected = "a number between 1.01 and 100 (below that the power of the lobe diverges: give an inner scale)";
        check("exponent", exponent, 1.01..=100.0, expected)?;
        Self::checked(root, exponent, 0.0)
    }

    /// The exponential `e^(−|x|/l)`, the exponent 1.5.
    ///
    /// # Errors
    ///
    /// As [`KCorrelation::new`].
    pub fn exponential(root: &Matrix2<f64>) -> Result<Self, AutocorrelationError> {
        Self::new(root, 1.5)
    }

    /// The same without detail below `inner` times the correlation length: `R(u) → R(√(u² + inner²))/R(inner)`.
    ///
    /// `inner` is in `1e-10..=1.0`, the exponent in `0.01..=100.0`. The lobe follows the power law up to
    /// `|Dq| ≈ 1/inner` and falls exponentially beyond.
    ///
    /// # Errors
    ///
    /// When a number is outside these, or the root is singular or outside 1e-30 to 1e30 m.
    pub fn with_inner_scale(
        root: &Matrix2<f64>,
        exponent: f64,
        inner: f64,
    ) -> Result<Self, AutocorrelationError> {
        let expected = "a number between 0.01 and 100";
        check("exponent", exponent, 0.01..=100.0, expected)?;
        let expected = "a number between 1e-10 and 1 (in correlation lengths)";
        check("inner scale", inner, 1e-10..=1.0, expected)?;
        Self::checked(root, exponent, inner)
    }

    fn checked(
        root: &Matrix2<f64>,
        exponent: f64,
        inner: f64,
    ) -> Result<Self, AutocorrelationError> {
        GaussianFamily::new(root, [])?;
        Ok(Self {
            root: *root,
            exponent,
            inner,
            reach: REACH,
        })
    }

    /// Holds the lobe's relative error as far as `|Dq| = reach`, in `0.0..=1e6`, instead of 100.
    ///
    /// Light of wavenumber k never sees more than `2 k l`. A shorter reach needs fewer Gaussians.
    ///
    /// # Errors
    ///
    /// When the reach is outside its range.
    pub fn with_reach(mut self, reach: f64) -> Result<Self, AutocorrelationError> {
        check("reach", reach, 0.0..=1e6, "a number between 0 and 1e6")?;
        self.reach = reach;
        Ok(self)
    }

    /// The root D, 2×2, m.
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        &self.root
    }

    /// The exponent c.
    #[must_use]
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// The inner scale in correlation lengths; 0 for none.
    #[must_use]
    pub fn inner_scale(&self) -> f64 {
        self.inner
    }

    /// R as a sum of Gaussians of positive weight, and what was chosen for the tolerance.
    ///
    /// The error holds over the lobe's largest value everywhere, and over the lobe itself for `|Dq|` up to the reach (up
    /// to `10/inner` where that is less, and where the lobe is more than 1e-250 of its largest value); hence for light of any
    /// angular width within the reach. `R(0) = 1` to rounding.
    ///
    /// # Errors
    ///
    /// None that a checked spectrum can cause; those of [`GaussianFamily::new`].
    pub fn autocorrelation(
        &self,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let Mixture { terms, error } = self.mixture(tolerance.get());
        let approximation = Approximation {
            method: Method::WidthQuadrature,
            terms: terms.len(),
            error,
        };
        Ok((
            Autocorrelation::of_family(&self.root, terms)?,
            approximation,
        ))
    }

    /// Mean rate of the mixture, `−∂²R/∂u²` at 0; `None` where it diverges.
    pub(super) fn mean_rate(&self) -> Option<f64> {
        if self.inner == 0.0 {
            return (self.exponent > 2.0).then(|| 0.5 / (self.exponent - 2.0));
        }
        let Mixture { terms, .. } = self.mixture_until(1e-14, |_| 1.0);
        Some(terms.iter().map(|term| term.weight * term.rate).sum())
    }

    /// The mixture for a relative error of the lobe.
    fn mixture(&self, tolerance: f64) -> Mixture {
        let mut farthest = LEAST_LOBE.powf(-1.0 / self.exponent);
        if self.inner > 0.0 {
            farthest = farthest.min((FARTHEST / self.inner).powi(2));
        }
        let q2 = self.reach.powi(2).min(farthest - 1.0);
        let [mut peak, mut tail] = [0.0; 2];
        self.mixture_until(tolerance, |Node { t, lobe, rest, .. }| {
            peak += lobe;
            tail += lobe * (-t * q2).exp();
            // a tail of 0 has not begun yet
            let far = if q2 == 0.0 {
                0.0
            } else {
                rest * (t * q2).min(1.0) / tail
            };
            (rest / peak).max(far)
        })
    }

    /// The mixture whose narrow end is where `left`, asked from the widest node down, is at most a quarter of the
    /// tolerance, or at t = 1e-28.
    pub(super) fn mixture_until(
        &self,
        tolerance: f64,
        mut left: impl FnMut(Node) -> f64,
    ) -> Mixture {
        let (c, tc) = (self.exponent, self.inner * self.inner / 4.0);
        // both the lobe and R(0), by which it is divided, err by the rule
        let z = if self.inner > 0.0 { FARTHEST } else { 0.0 };
        let h = step(c.max(1.0), z, tolerance / 8.0);
        let lobe = |t: f64| h * (c * t.ln() - t - tc / t).exp();
        let (top, wide) = self.widest(tolerance / 8.0);
        let mut nodes: Vec<[f64; 2]> = vec![];
        let mut cut = 0.0;
        for k in 0_i32.. {
            let t = top * (-f64::from(k) * h).exp();
            let node = Node {
                t,
                lobe: lobe(t),
                mass: lobe(t) / t,
                rest: t.powf(c) * (-tc / t).exp() / c,
            };
            nodes.push([t, node.mass]);
            cut = left(node);
            if cut <= tolerance / 4.0 || t < LEAST {
                break;
            }
        }
        let t = nodes.last().map_or(top, |node| node[0]);
        if let Some(narrow) = narrow_end(t, h, c, tc) {
            nodes.push(narrow);
        }
        let total: f64 = nodes.iter().map(|[_, mass]| mass).sum();
        let terms = nodes
            .into_iter()
            .map(|[t, mass]| GaussianTerm::centred(mass / total, 0.5 / t));
        Mixture {
            terms: terms.filter(|term| term.weight > 0.0).collect(),
            error: tolerance / 4.0 + 2.0 * wide + cut,
        }
    }

    /// The widest t, and a bound on the sum beyond it over the lobe at 0.
    fn widest(&self, tolerance: f64) -> (f64, f64) {
        let (c, tc) = (self.exponent, self.inner * self.inner / 4.0);
        // to a part in 1e6, by the same rule at a step of 1/8
        let whole: f64 = (-600..80)
            .map(|k| f64::from(k) / 8.0)
            .map(|s| (c * s - s.exp() - tc * (-s).exp()).exp() / 8.0)
            .sum();
        let beyond = |t: f64| (c * t.ln() - t).exp() / (t - (c - 1.0).max(0.0)) / whole;
        let mut t = c + 1.0;
        while beyond(t) > tolerance {
            t += 0.25;
        }
        (t, beyond(t))
    }
}

/// One node of the rule.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// `u²/4t` is the exponent.
    pub(super) t: f64,
    /// `h t^c e^(−t − b²/4t)`: its share of the lobe at 0.
    lobe: f64,
    /// Its share of R(0).
    pub(super) mass: f64,
    /// Bound on the lobes at 0 of all narrower nodes.
    rest: f64,
}

impl Node {
    /// Bound on the weights of all narrower nodes, in the unit of [`Node::mass`].
    pub(super) fn rest_of_weight(&self, correlation: &KCorrelation) -> f64 {
        let (c, tc) = (
            correlation.exponent,
            correlation.inner * correlation.inner / 4.0,
        );
        if tc == 0.0 {
            return self.t.powf(c - 1.0) / (c - 1.0);
        }
        // τ^(c−2) ≤ t^c τ^(−2), whose integral with e^(−b²/4τ) is elementary
        self.t.powf(c) * (-tc / self.t).exp() / tc
    }
}

/// The nodes below t as one of their weight and their lobe at 0: its t and its weight.
fn narrow_end(t: f64, h: f64, c: f64, tc: f64) -> Option<[f64; 2]> {
    let (mut mass, mut lobe) = (0.0, 0.0);
    for j in 1_i32.. {
        let t = t * (-f64::from(j) * h).exp();
        let density = h * (c * t.ln() - t - tc / t).exp();
        mass += density / t;
        lobe += density;
        if tc > 0.0 && density == 0.0 {
            break;
        }
        if tc == 0.0 && t < 1e-18 {
            // e^(−t) is 1: two geometric series
            mass += density / t / ((c - 1.0) * h).exp_m1();
            lobe += density / (c * h).exp_m1();
            break;
        }
    }
    (mass > 0.0 && lobe > 0.0).then(|| [lobe / mass, mass])
}

/// The largest step for which the rule's bound is at most `error`.
pub(super) fn step(nu: f64, z: f64, error: f64) -> f64 {
    (1..64)
        .map(|j| {
            let a = FRAC_PI_2 * f64::from(j) / 64.0;
            let gamma = a.cos();
            let log = (2.0 / error).ln() - nu * gamma.ln() + z * (1.0 - gamma);
            TAU * a / (log + (-log).exp().ln_1p())
        })
        .fold(0.0, f64::max)
}
