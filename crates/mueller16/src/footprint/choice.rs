//! The order of modes that a set of lobes needs.
//!
//! With `ρ(x) = Σ |w| e^(−m xᵀS⁻¹x/2)` over the Gaussians of R, whatever their shifts,
//!
//! ```text
//! |F{R γ}(φ) − F{R γ_N}(φ)| ≤ ∫ ρ |γ − γ_N| d²x      at every φ
//! ```
//!
//! and the largest values of the Gaussians add up to `∫ ρ γ d²x` at least. Both integrals are sums over the same points,
//! polar ones of equal ratios, since the widths of the Gaussians may differ by orders of magnitude.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{Envelope, EnvelopeModes, ModeWidth, mode_count, mode_index, plane};

use super::FootprintError;
use crate::channels::Channels;

/// Orders up to this one are tried; beyond it Gaussians cost less and are nowhere negative.
const MOST: usize = 32;

/// A footprint of more standard deviations of a lobe than this is not tried with modes.
const WIDEST: f64 = 4.0;

/// Radii in units of the longest correlation, from 1e-4 to 8.5 where a Gaussian is below 1e-15, and angles.
const RADII: usize = 240;
const NEAREST: f64 = 1e-4;
const FARTHEST: f64 = 8.5;
const ANGLES: usize = 48;

/// The lobes of a set of channels, as a footprint's plane sees them.
pub(super) struct Lobes {
    /// Standard deviation along the thin axis of the narrowest lobe, m; infinite without lobes.
    pub(super) narrowest: f64,
    /// `|w|`, rate and inverse transposed root of every Gaussian.
    terms: Vec<(f64, f64, Matrix2<f64>)>,
    /// The root of the family of the narrowest, over the root of its rate: the longest correlation.
    longest: Matrix2<f64>,
}

impl Lobes {
    pub(super) fn of(channels: &Channels, map: &Matrix2<f64>) -> Result<Self, FootprintError> {
        let mut lobes = Self {
            narrowest: f64::INFINITY,
            terms: vec![],
            longest: Matrix2::identity(),
        };
        for group in channels.groups() {
            let strength = group.mueller.amax();
            for family in group.autocorrelation.families() {
                let inverse = plane::inverse(family.root()).transpose();
                let across = plane::product(map, &family.root().transpose());
                let [widest, _] = plane::singular_values(&across).values;
                for term in family.terms() {
                    let weight = strength * term.weight.abs();
                    if term.rate == 0.0 && weight > 0.0 {
                        return Err(FootprintError::Delta {
                            weight: term.weight,
                        });
                    }
                    if weight == 0.0 {
                        continue;
                    }
                    lobes.terms.push((weight, term.rate, inverse));
                    let sigma = term.rate.sqrt() / widest;
                    if sigma < lobes.narrowest {
                        lobes.narrowest = sigma;
                        lobes.longest = family.root() / term.rate.sqrt();
                    }
                }
            }
        }
        Ok(lobes)
    }

    /// `ρ(x)`.
    fn density(&self, x: &Vector2<f64>) -> f64 {
        let mut sum = 0.0;
        let (mut known, mut square) = (None, 0.0);
        for (weight, rate, inverse) in &self.terms {
            if known != Some(inverse) {
                square = plane::apply(inverse, x).norm_squared();
                known = Some(inverse);
            }
            sum += weight * (-0.5 * rate * square).exp();
        }
        sum
    }

    /// Modes of the lowest order whose error is below the tolerance, scaled to be exact at 0, and the bound on that
    /// error; `None` when no order up to [`MOST`] is enough.
    pub(super) fn order_for(
        &self,
        envelope: &Envelope,
        map: &Matrix2<f64>,
        tolerance: f64,
    ) -> Result<Option<(EnvelopeModes, f64)>, FootprintError> {
        let fundamental = envelope.modes(ModeWidth::VarianceMatched, 0)?;
        if fundamental.relative_error() == 0.0 || self.terms.is_empty() {
            return Ok(Some((fundamental.rescaled()?.0, 0.0)));
        }
        let [widest, _] = plane::singular_values(fundamental.root()).values;
        if widest > WIDEST * self.narrowest {
            return Ok(None);
        }
        let modes = envelope.modes(ModeWidth::VarianceMatched, MOST)?;
        let errors = self.errors(envelope, map, &modes);
        let order = errors.iter().position(|error| *error <= tolerance);
        order
            .map(|order| {
                let modes = envelope.modes(ModeWidth::VarianceMatched, order)?;
                Ok((modes.rescaled()?.0, errors[order]))
            })
            .transpose()
    }

    /// The bound for each order up to that of `modes`, whose sums are scaled to be exact at 0.
    fn errors(&self, envelope: &Envelope, map: &Matrix2<f64>, modes: &EnvelopeModes) -> Vec<f64> {
        let order = modes.series().order();
        let real = modes.series().real_coefficients();
        let scales: Vec<f64> = (0..=order)
            .map(|n| 1.0 / modes.series().truncated(n).0.sum_at_zero())
            .collect();
        let whiten = plane::product(modes.root(), map);
        let step = (FARTHEST / NEAREST).ln() / (RADII - 1) as f64;
        let (mut whole, mut lost) = (0.0, vec![0.0; order + 1]);
        let mut values = vec![0.0; mode_count(order)];
        for i in 0..RADII {
            let radius = NEAREST * (i as f64 * step).exp();
            for j in 0..ANGLES {
                // half a turn: both moduli are even
                let angle = std::f64::consts::PI * (j as f64 + 0.5) / ANGLES as f64;
                let u = Vector2::new(angle.cos(), angle.sin()) * radius;
                let x = plane::apply(&self.longest.transpose(), &u);
                let weight = self.density(&x) * radius * radius;
                let exact = envelope.far_field(map, &x) / envelope.area();
                whole += weight * exact.re;
                let y = plane::apply(&whiten, &x);
                stokes::all_modes(order, [y.x, y.y], &mut values);
                let mut sum = Complex64::ZERO;
                for n in 0..=order {
                    let places = mode_index(n, 0)..mode_count(n);
                    let more: f64 = places.map(|place| real[place] * values[place]).sum();
                    sum += Complex64::new(0.0, 1.0).powu(n as u32) * more;
                    lost[n] += weight * (exact - sum * scales[n]).norm();
                }
            }
        }
        let bound = |lost: f64| {
            if whole > 0.0 {
                lost / whole
            } else {
                f64::INFINITY
            }
        };
        lost.into_iter().map(bound).collect()
    }
}
