//! The phase that random heights give to light: `R = e^(−g(1−ρ))`, its mirror, its diffuse part and the error of a mixture.
//!
//! The error is measured, not estimated: for any two functions of the radius
//!
//! ```text
//! |F{R − R̃}(q)| ≤ 2π |det D| ∫ |R − R̃| u du
//! ```
//!
//! at every q; the lobe's largest value, at `q = 0`, is the same integral of `R − e^(−g)`. For light whose coherence γ is
//! positive and falls with u, both integrals are averages of those over disks, so that their ratio is at most the largest
//! ratio over a disk. It is taken over all disks down to a tenth of the lobe's own, `√τ/5` with `2τ = ∫ (R − e^(−g)) u du`:
//! the error is that for light of at most ten times the lobe's angular width, the plane wave included.

use nalgebra::Matrix2;

use super::rates::Point;
use super::{Autocorrelation, AutocorrelationError, GaussianTerm};
use crate::accuracy::{Approximation, Method};

/// Largest roughness `(φ_z σ)²`.
pub(super) const ROUGHEST: f64 = 1e8;

/// Area of the smallest disk over that of the lobe: light of ten times the lobe's angular width.
const LEAST_DISK: f64 = 0.02;

/// Step of `ln u`.
const STEP: f64 = 0.125;

/// A correlation of heights at one radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Height {
    /// `u²`
    pub(super) u2: f64,
    /// `ρ(u)`
    pub(super) rho: f64,
    /// `1 − ρ(u)`
    pub(super) structure: f64,
}

/// `u²` on a logarithmic grid, from far outside (190 correlation lengths) in.
pub(super) fn radii() -> impl Iterator<Item = f64> {
    (-300..43).rev().map(|k| (2.0 * STEP * f64::from(k)).exp())
}

/// The part of R that decays, on the grid of radii.
pub(super) struct Diffuse {
    /// `u²`, the exact value, and the weight `u du` of the rule.
    samples: Vec<[f64; 3]>,
    /// `∫ (R − e^(−g)) u du`
    pub(super) area: f64,
    /// `[u², ∫₀ᵘ (R − e^(−g)) u du]`, from the smallest disk of the measurement outwards.
    disks: Vec<[f64; 2]>,
}

impl Diffuse {
    /// For heights of this correlation at the [`radii`].
    pub(super) fn new(g: f64, heights: impl Iterator<Item = Height>) -> Self {
        let (mut samples, mut area) = (vec![], 0.0);
        for Height { u2, rho, structure } in heights {
            // e^(−g)(e^(gρ) − 1), of which neither factor may overflow
            let value = if g * rho < 1.0 {
                (-g).exp() * (g * rho).exp_m1()
            } else {
                (-g * structure).exp() - (-g).exp()
            };
            let weight = u2 * STEP;
            area += value * weight;
            samples.push([u2, value, weight]);
            // the disk that is left holds 1e-16 of the whole
            if area > 0.0 && u2 * -(-g).exp_m1() < 1e-16 * area {
                break;
            }
        }
        let least = area * LEAST_DISK / -(-g).exp_m1();
        let mut within = 0.0;
        let rings = samples.iter().rev().map(|[u2, value, weight]| {
            within += value * weight;
            [*u2, within]
        });
        let disks = rings.filter(|[u2, _]| *u2 >= least).collect();
        Self {
            samples,
            area,
            disks,
        }
    }

    /// Bound on the lobe of a Gaussian of the rate m and the weight 1 over that of R, in the light that is meant above.
    ///
    /// Over a disk the Gaussian's integral is at most `min(u²/2, 1/m)`, and that of R grows slower than the disk: the
    /// ratio is largest at `u² = 2/m`, or over the smallest disk.
    pub(super) fn share(&self, m: f64) -> f64 {
        let place = self.disks.partition_point(|[u2, _]| *u2 * m < 2.0);
        let held = self.disks.get(place.saturating_sub(1));
        held.map_or(1.0, |[_, within]| 1.0 / (m * within))
    }

    /// `u²` beyond which this share of the lobe at 0 lies.
    pub(super) fn end(&self, share: f64) -> f64 {
        let mut beyond = 0.0;
        let place = self.samples.iter().position(|[_, value, weight]| {
            beyond += value * weight;
            beyond > share * self.area
        });
        place.map_or(f64::INFINITY, |place| self.samples[place][0])
    }

    /// Bound on the lobe's error over its largest value for this measure of rates, in the light that is meant above.
    pub(super) fn error(&self, points: &[Point]) -> f64 {
        let least = self.disks.first().map_or(0.0, |[u2, _]| *u2);
        let (mut off, mut whole, mut worst) = (0.0, 0.0, 0.0_f64);
        for &[u2, value, weight] in self.samples.iter().rev() {
            let sum: f64 = points.iter().map(|[m, w]| w * (-0.5 * m * u2).exp()).sum();
            off += (sum - value).abs() * weight;
            whole += value * weight;
            if u2 >= least {
                worst = worst.max(off / whole);
            }
        }
        worst
    }
}

/// The mirror `e^(−g)` and the measure of the rest.
pub(super) fn with_mirror(
    root: &Matrix2<f64>,
    g: f64,
    (points, error): (Vec<Point>, f64),
) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
    let mirror = GaussianTerm::centred((-g).exp(), 0.0);
    let rest = points.into_iter().map(|[m, w]| GaussianTerm::centred(w, m));
    let all = std::iter::once(mirror).chain(rest);
    let terms: Vec<GaussianTerm> = all.filter(|term| term.weight > 0.0).collect();
    let approximation = Approximation {
        method: if g == 0.0 {
            Method::Exact
        } else {
            Method::WidthQuadrature
        },
        terms: terms.len(),
        error,
    };
    Ok((Autocorrelation::of_family(root, terms)?, approximation))
}
