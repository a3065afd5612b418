//! Autocorrelations from measured spectra: a radial table fitted by Gaussians of positive weight.
//!
//! ```text
//! F{R}(q) ≈ Σ p_k e^(−t_k q²),   p_k ≥ 0        R(x) = Σ p_k/(4π t_k) e^(−|x|²/4t_k)
//! ```
//!
//! The widths lie on a logarithmic grid from the first row to the last; the weights are a least-squares fit without
//! negative coefficients, each row weighted by what the tolerance makes of it. Such a sum falls with q. Where a table
//! does not, rings join it: n Gaussians on a circle `|q| = q₀`, as positive as the others.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use thiserror::Error;

use super::least_squares::non_negative;
use super::{Autocorrelation, AutocorrelationError, GaussianTerm};
use crate::accuracy::{Approximation, Method, Tolerance};

/// `ln` of the ratio of neighbouring t.
const GRID: f64 = 0.35;

/// Radii of rings that are tried.
const RADII: usize = 24;

/// Most Gaussians of a ring; thinner rings are not tried.
const LARGEST_RING: usize = 64;

/// Why a table is no spectrum that a sum of Gaussians can hold.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TableError {
    /// Too few rows.
    #[error(
        "spectrum table: found {frequencies} frequencies and {values} values, expected as many of each and at least 2"
    )]
    Rows {
        /// Length of the first column.
        frequencies: usize,
        /// Length of the second.
        values: usize,
    },
    /// A frequency is not above the one before.
    #[error(
        "spectrum table: the frequency in row {row} is {value} rad/m after {before} rad/m, expected ascending finite numbers"
    )]
    Order {
        /// Place in the table, from 0.
        row: usize,
        /// What was found.
        value: f64,
        /// The row before; 0 for the first.
        before: f64,
    },
    /// A value is negative or no number, or all are 0.
    #[error(
        "spectrum table: the value in row {row} is {value}, expected a finite number of at least 0, and not 0 everywhere"
    )]
    Value {
        /// Place in the table, from 0.
        row: usize,
        /// What was found.
        value: f64,
    },
    /// The power asked for is no positive number.
    #[error("spectrum table: the power asked for is {0}, expected a positive finite number")]
    Power(f64),
    /// No sum of positive Gaussians comes near enough.
    #[error(
        "spectrum table: the best sum of positive Gaussians is off by {error} of the largest value, at {frequency} rad/m; expected \
         at most {tolerance}: smooth the table, give it more rows where it is steep, or accept that error"
    )]
    Misfit {
        /// Largest error of a row over the largest value.
        error: f64,
        /// What was asked for.
        tolerance: f64,
        /// Where it is.
        frequency: f64,
    },
    /// The Gaussians cannot be held.
    #[error(transparent)]
    Autocorrelation(#[from] AutocorrelationError),
}

/// A radial power spectrum given at some spatial frequencies: `F{R}(|q|)`, m² for a dimensionless R.
///
/// Between rows the sum is as smooth as its Gaussians; beyond the last row it falls as its widest lobe does, which is
/// flat over the table only if the table is.
///
/// ```
/// use mueller16::{TabulatedSpectrum, Tolerance};
/// // an exponential correlation of 1 µm: 2π l² (1 + l² q²)^(−3/2)
/// let q: Vec<f64> = (0..80).map(|i| 1e4 * 1.1f64.powi(i)).collect();
/// let psd: Vec<f64> = q.iter().map(|q| 6.283_185e-12 * (1.0 + q * q * 1e-12).powf(-1.5)).collect();
/// let (r, chosen) = TabulatedSpectrum::new(&q, &psd)?.autocorrelation(Tolerance::relative(1e-3)?)?;
/// assert!(chosen.error < 1e-3 && r.is_positive());
/// // the share of the power below q is 1 − (1 + l² q²)^(−1/2): 0.95 at the last row
/// assert!(r.at_zero() > 0.94 && r.at_zero() < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedSpectrum {
    frequencies: Vec<f64>,
    values: Vec<f64>,
    power: Option<f64>,
}

/// A column of the fit: `count` Gaussians `e^(−t|q − q₀|²)` about the circle, or one at the centre.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    t: f64,
    radius: f64,
    count: usize,
}

impl TabulatedSpectrum {
    /// The spectrum with these values at these frequencies, rad/m, ascending.
    ///
    /// # Errors
    ///
    /// When there are less than two rows, the frequencies do not ascend from 0 or more, or a value is negative.
    pub fn new(frequencies: &[f64], values: &[f64]) -> Result<Self, TableError> {
        if frequencies.len() != values.len() || values.len() < 2 {
            return Err(TableError::Rows {
                frequencies: frequencies.len(),
                values: values.len(),
            });
        }
        let mut before = 0.0;
        for (row, &value) in frequencies.iter().enumerate() {
            let ascends = if row == 0 {
                value >= 0.0
            } else {
                value > before
            };
            if !(ascends && value <= 1e14) {
                return Err(TableError::Order { row, value, before });
            }
            before = value;
        }
        let good = |v: f64| v >= 0.0 && v.is_finite();
        if let Some((row, value)) = values.iter().enumerate().find(|(_, v)| !good(**v)) {
            return Err(TableError::Value { row, value: *value });
        }
        if values.iter().all(|v| *v == 0.0) {
            return Err(TableError::Value { row: 0, value: 0.0 });
        }
        Ok(Self {
            frequencies: frequencies.to_vec(),
            values: values.to_vec(),
            power: None,
        })
    }

    /// Scales the table so that `R(0)` is `power`, instead of `(2π)⁻² ∫ F{R} d²q`.
    ///
    /// # Errors
    ///
    /// When it is not a positive finite number.
    pub fn with_power(mut self, power: f64) -> Result<Self, TableError> {
        if !(power > 0.0 && power.is_finite()) {
            return Err(TableError::Power(power));
        }
        self.power = Some(power);
        Ok(self)
    }

    /// R as a sum of Gaussians of positive weight, and what was chosen for the tolerance.
    ///
    /// The error is the largest one in a row of the table, over the table's largest value.
    ///
    /// # Errors
    ///
    /// When no sum of positive Gaussians comes as near as the tolerance.
    pub fn autocorrelation(
        &self,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), TableError> {
        let tolerance = tolerance.get();
        let centred = self.centred();
        let mut best = self.fit(&centred, tolerance);
        if best.1 > tolerance {
            let mut all = centred;
            all.extend(self.rings(tolerance));
            let also = self.fit(&all, tolerance);
            if also.1 < best.1 {
                best = also;
            }
        }
        let (lobes, error, row) = best;
        if error > tolerance {
            return Err(TableError::Misfit {
                error,
                tolerance,
                frequency: self.frequencies[row],
            });
        }
        self.sum(&lobes, error)
    }

    /// The widths from a lobe that is flat over the table to one that is gone at its first step.
    fn centred(&self) -> Vec<Lobe> {
        let (first, last) = self.range();
        let widest = 0.05 / (last * last);
        let steps = ((8.0 / (first * first * widest)).ln() / GRID).ceil() as i32;
        let lobe = |k: i32| Lobe {
            t: widest * (GRID * f64::from(k)).exp(),
            radius: 0.0,
            count: 1,
        };
        (0..=steps).map(lobe).collect()
    }

    /// The first frequency that is not 0, or the first step where that is less; and the last frequency.
    fn range(&self) -> (f64, f64) {
        let q = &self.frequencies;
        let first = if q[0] > 0.0 {
            q[0].min(q[1] - q[0])
        } else {
            q[1]
        };
        (first, q[q.len() - 1])
    }

    /// Rings of all radii, as wide as the table's steps and wider.
    fn rings(&self, tolerance: f64) -> Vec<Lobe> {
        let q = &self.frequencies;
        let mut rings = vec![];
        let stride = q.len().div_ceil(RADII);
        for row in (0..q.len()).step_by(stride).filter(|row| q[*row] > 0.0) {
            let radius = q[row];
            let next = q[(row + 1).min(q.len() - 1)];
            let before = q[row.saturating_sub(1)];
            let spacing = 0.5 * (next - before);
            for width in [0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 7.5] {
                let t = 0.5 / (width * spacing).powi(2);
                // the first harmonic of n Gaussians is 2 I_n(z)/I₀(z) ≈ 2 e^(−n²/2z) of the mean
                let z = 2.0 * t * radius * radius;
                let count = (2.0 * z.max(1.0) * (8.0 / tolerance).ln()).sqrt().ceil() as usize;
                if count <= LARGEST_RING && z > 0.5 {
                    rings.push(Lobe { t, radius, count });
                }
            }
        }
        rings
    }

    /// The lobes with their weights, the largest error of a row, and that row.
    fn fit(&self, lobes: &[Lobe], tolerance: f64) -> (Vec<(Lobe, f64)>, f64, usize) {
        let peak = self.values.iter().copied().fold(0.0, f64::max);
        let weight: Vec<f64> = self
            .values
            .iter()
            .map(|v| 1.0 / (v / peak + tolerance))
            .collect();
        let a = DMatrix::from_fn(weight.len(), lobes.len(), |i, k| {
            weight[i] * lobes[k].mean(self.frequencies[i])
        });
        let b = DVector::from_fn(weight.len(), |i, _| weight[i] * self.values[i] / peak);
        let x = non_negative(&a, &b);
        let found: Vec<(Lobe, f64)> = lobes
            .iter()
            .zip(x.iter())
            .filter(|(_, x)| **x > 0.0)
            .map(|(lobe, x)| (*lobe, x * peak))
            .collect();
        let (mut error, mut at) = (0.0, 0);
        for (row, (q, value)) in self.frequencies.iter().zip(&self.values).enumerate() {
            let sum: f64 = found.iter().map(|(lobe, p)| p * lobe.mean(*q)).sum();
            // rings swell and shrink about their mean: the swellings may meet
            let ripple: f64 = found.iter().map(|(lobe, p)| p * lobe.ripple(*q)).sum();
            let off = ((sum - value).abs() + ripple) / peak;
            if off > error {
                (error, at) = (off, row);
            }
        }
        (found, error, at)
    }

    fn sum(
        &self,
        lobes: &[(Lobe, f64)],
        error: f64,
    ) -> Result<(Autocorrelation, Approximation), TableError> {
        // rates beside the geometric mean of the table's range
        let (first, last) = self.range();
        let unit = 1.0 / (first * last).sqrt();
        let terms = lobes.iter().flat_map(|(lobe, p)| {
            let weight = p / (4.0 * std::f64::consts::PI * lobe.t);
            let rate = unit * unit / (2.0 * lobe.t);
            lobe.places().map(move |shift| GaussianTerm {
                weight: weight / lobe.count as f64,
                rate,
                shift,
            })
        });
        let mut r = Autocorrelation::of_family(&Matrix2::from_diagonal_element(unit), terms)?;
        if let Some(power) = self.power {
            let total = r.at_zero();
            r = r.scaled(power / total);
        }
        let approximation = Approximation {
            method: Method::WidthFit,
            terms: r.term_count(),
            error,
        };
        Ok((r, approximation))
    }
}

impl Lobe {
    /// The centres of its Gaussians.
    fn places(self) -> impl Iterator<Item = Vector2<f64>> {
        (0..self.count).map(move |j| {
            let angle = std::f64::consts::TAU * j as f64 / self.count as f64;
            Vector2::new(angle.cos(), angle.sin()) * self.radius
        })
    }

    /// Its value at distance q and an angle from the first Gaussian.
    fn value(self, q: f64, angle: f64) -> f64 {
        let at = Vector2::new(angle.cos(), angle.sin()) * q;
        let sum: f64 = self
            .places()
            .map(|place| (-self.t * (at - place).norm_squared()).exp())
            .sum();
        sum / self.count as f64
    }

    /// The middle between its largest and smallest value at distance q.
    fn mean(self, q: f64) -> f64 {
        let between = std::f64::consts::PI / self.count as f64;
        0.5 * (self.value(q, 0.0) + self.value(q, between))
    }

    /// Half the difference of these.
    fn ripple(self, q: f64) -> f64 {
        if self.count == 1 {
            return 0.0;
        }
        let between = std::f64::consts::PI / self.count as f64;
        0.5 * (self.value(q, 0.0) - self.value(q, between)).abs()
    }
}
