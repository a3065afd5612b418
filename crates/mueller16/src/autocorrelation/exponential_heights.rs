//! Rough surfaces whose heights are exponentially correlated: the measure of widths in closed form.
//!
//! ```text
//! R = e^(−g(1−e^(−u))) = e^(−g) Σ (gⁿ/n!) e^(−nu)
//! e^(−nu) = ∫ n √(τ/π) e^(−n²τ) e^(−u²/4τ) ds,   τ = e^s
//! ```
//!
//! All powers are summed at each τ, so that there are as many Gaussians as one exponential needs, not Poisson times as
//! many. The integral is summed by the trapezoidal rule with the bound of [`super::KCorrelation`]: for each power it is
//! relative to the power's own lobe, hence holds for the sum. The Poisson weights become those of few n by Gauss
//! quadrature in bins ([`super::rates`]).

use std::f64::consts::PI;

use nalgebra::Matrix2;

use super::error::{check_deviation, roughness};
use super::k_correlation::{REACH, step};
use super::phase::{self, Diffuse, Height};
use super::rates::{Point, gathered};
use super::{Autocorrelation, AutocorrelationError, GaussianFamily};
use crate::accuracy::{Approximation, Tolerance};
use crate::relief::Relief;

/// Normally distributed heights with the correlation `σ² e^(−u)`, `u = |D⁻ᵀx|`: a surface of random steps, without slope.
///
/// `R = e^(−g(1−e^(−u)))` with `g = (φ_z σ)²`, by one mixture of positive Gaussians for every g up to 1e8. The error is
/// measured at every call, over the lobe's largest value, for light of at most ten times its angular width; widths are kept that hold the tail up to `|Dq| = 100`.
///
/// ```
/// use mueller16::{ExponentialHeights, Relief, Tolerance};
/// use nalgebra::{Matrix2, Vector2};
/// let surface = ExponentialHeights::new(50e-9, &Matrix2::from_diagonal_element(4e-6))?;
/// // g = 1
/// let (r, chosen) = surface.autocorrelation(2e7, Tolerance::relative(1e-6)?)?;
/// assert!((r.delta_weight() - 0.367_879_441).abs() < 1e-9);
/// // e^(−(1−e^(−1))) at one correlation length
/// assert!((r.value(&Vector2::new(0.0, 4e-6)).re - 0.531_463_6).abs() < 1e-6);
/// assert!(chosen.error < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialHeights {
    deviation: f64,
    root: Matrix2<f64>,
}

impl ExponentialHeights {
    /// Heights of standard deviation σ, m, with the correlation root D, 2×2, m (`l` times 1 where it is isotropic).
    ///
    /// # Errors
    ///
    /// When σ is not between 0 and 1e24 m, or the root is singular or outside 1e-30 to 1e30 m.
    pub fn new(deviation: f64, root: &Matrix2<f64>) -> Result<Self, AutocorrelationError> {
        check_deviation(deviation)?;
        GaussianFamily::new(root, [])?;
        Ok(Self {
            deviation,
            root: *root,
        })
    }
}

impl Relief for ExponentialHeights {
    /// # Errors
    ///
    /// When g exceeds 1e8.
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let g = roughness(phi_z, self.deviation, phase::ROUGHEST)?;
        if g == 0.0 {
            return phase::with_mirror(&self.root, g, (vec![], 0.0));
        }
        let tolerance = tolerance.get();
        let nodes = nodes(tolerance / 4.0);
        let powers = gathered(&poisson(g), |_, _| nodes);
        let points = widths(&powers, tolerance / 2.0);
        let heights = phase::radii().map(|u2| Height {
            u2,
            rho: (-u2.sqrt()).exp(),
            structure: -(-u2.sqrt()).exp_m1(),
        });
        let error = Diffuse::new(g, heights).error(&points);
        phase::with_mirror(&self.root, g, (points, error))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        None
    }
}

/// The Poisson weights `[n, e^(−g) gⁿ/n!]` of `n ≥ 1`, as far as they are 1e-18 of the largest, with the sum `1 − e^(−g)`.
fn poisson(g: f64) -> Vec<Point> {
    // from the largest weight outwards: no power and no factorial
    let top = g.floor().max(1.0);
    let mut points = vec![[top, 1.0]];
    let (mut n, mut w) = (top, 1.0);
    while w > 1e-18 && n > 1.0 {
        w *= n / g;
        n -= 1.0;
        points.push([n, w]);
    }
    (n, w) = (top, 1.0);
    while w > 1e-18 {
        n += 1.0;
        w *= g / n;
        points.push([n, w]);
    }
    let sum: f64 = points.iter().map(|[_, w]| w).sum();
    let scale = -(-g).exp_m1() / sum;
    points.iter().map(|[n, w]| [*n, w * scale]).collect()
}

/// Nodes for the powers n of a bin that bring the error of `e^(−n²τ)` to the tolerance.
///
/// Between n and 2n the k-point rule errs by `4 (n/4)^(2k) f^(2k)/(2k)!`, and by Cramér's inequality for Hermite functions
/// `f^(2k) ≤ 1.09 √((2k)!) (2τ)^k e^(−n²τ/2)`: together at most `4.36 · 8^(−k)`, where `n²τ = 2k`.
fn nodes(tolerance: f64) -> usize {
    let (mut k, mut bound) = (1, 4.36 / 8.0);
    while bound > tolerance {
        k += 1;
        bound /= 8.0;
    }
    k
}

/// The measure of rates `1/(2τ)` of `Σ w e^(−nu)`.
fn widths(powers: &[Point], tolerance: f64) -> Vec<Point> {
    let h = step(1.5, 0.0, tolerance / 8.0);
    let weight: f64 = powers.iter().map(|[_, w]| w).sum();
    let slope: f64 = powers.iter().map(|[n, w]| n * w).sum();
    // share of R(0) in one step at τ
    let mass = |tau: f64| -> f64 {
        let sum: f64 = powers
            .iter()
            .map(|[n, w]| w * n * (-n * n * tau).exp())
            .sum();
        h * (tau / PI).sqrt() * sum
    };
    let least = powers.iter().map(|[n, _]| *n).fold(f64::INFINITY, f64::min);
    // Γ(1.5, t) ≤ t^1.5 e^(−t)/(t − 0.5)
    let mut t = 2.5_f64;
    while t.powf(1.5) * (-t).exp() / (t - 0.5) > 0.1 * tolerance {
        t += 0.25;
    }
    let (mut points, mut lobe, mut tail): (Vec<Point>, f64, f64) = (vec![], 0.0, 0.0);
    let mut tau = t / (least * least);
    loop {
        let m = mass(tau);
        lobe += m * tau;
        tail += m * tau * (-tau * REACH * REACH).exp();
        points.push([0.5 / tau, m]);
        // what is narrower has at most this lobe at 0, and as one Gaussian errs by this share of it
        let rest = slope * tau.powf(1.5) / (1.5 * PI.sqrt());
        let far = rest * (tau * REACH * REACH).min(1.0);
        // a hundredth for light that is wider than the lobe
        if (rest < 0.0025 * tolerance * lobe && far < 0.25 * tolerance * tail) || tau < 1e-28 {
            break;
        }
        tau *= (-h).exp();
    }
    // it becomes one Gaussian of the same weight and the same lobe at 0
    let (mut m, mut l) = (0.0, 0.0);
    loop {
        tau *= (-h).exp();
        let more = mass(tau);
        m += more;
        l += more * tau;
        if more < 1e-18 * m {
            break;
        }
    }
    points.push([0.5 * m / l, m]);
    let sum: f64 = points.iter().map(|[_, w]| w).sum();
    points
        .iter()
        .map(|[rate, w]| [*rate, w * weight / sum])
        .collect()
}
