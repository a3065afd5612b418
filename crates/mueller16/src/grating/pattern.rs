//! Elements whose polarization repeats along a line: their orders, each of one Jones matrix.

use std::f64::consts::TAU;

use csdm::JonesMatrix;
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use rustfft::FftPlanner;
use stokes::Envelope;

use super::{GratingError, check_pitch, unit};
use crate::accuracy::{Approximation, Method, Tolerance};
use crate::autocorrelation::Autocorrelation;
use crate::channels::Channels;
use crate::population::Population;

/// Largest number of samples.
const MOST: usize = 1 << 16;

/// A thin element whose Jones matrix `T(x)` repeats along one direction of the surface.
///
/// ```text
/// T(x) = Σ_m T_m e^(imGx)  in exp(+iωt),     Σ^(j→l)(x₁, x₂) = conj M_lj(x₁, x₂) = Σ_q M_lj[T_(−q)] e^(iqG(x₁ − x₂))
/// ```
///
/// Order q, deflected by `qG`, has the Jones matrix of the harmonic `−q`: fields in `exp(+iωt)` travel as `e^(−ikr)`.
/// Without that conjugate patterned elements deflect to the wrong side. Place is not known (the mean over it), hence
/// orders are populations that do not interfere.
///
/// ```
/// use csdm::polarization_grating;
/// use mueller16::PolarizationPattern;
/// use nalgebra::Vector2;
/// use std::f64::consts::PI;
/// use stokes::StokesVector;
/// // half-wave plate whose axis turns: right circular light goes to order −1 and leaves left circular
/// let plate = polarization_grating(5e-6, PI)?;
/// let pattern = PolarizationPattern::new(5e-6, Vector2::x(), 16, |x| plate.at(x))?;
/// let out = pattern.order(-1).mueller() * StokesVector::RIGHT_CIRCULAR;
/// assert!((out - StokesVector::LEFT_CIRCULAR).to_vector().norm() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PolarizationPattern {
    wave_vector: Vector2<f64>,
    /// By increasing order.
    orders: Vec<(i32, JonesMatrix)>,
}

impl PolarizationPattern {
    /// The element with the Jones matrix `jones(x)` at the point x (metres, axes of the tangents), which repeats with
    /// the period `pitch` (metres) in the direction `along`; sampled at `samples` equal steps.
    ///
    /// Jones matrices lead from the axes of the incident ray to those of the outgoing one. With n samples there are n
    /// orders; harmonics beyond appear as others.
    ///
    /// # Errors
    ///
    /// When the pitch is not a number between 1e-12 and 1e3 m, `along` is not of unit length, there are no samples or
    /// more than 65,536, or an element of a Jones matrix is not of modulus at most 1e6.
    pub fn new(
        pitch: f64,
        along: Vector2<f64>,
        samples: usize,
        jones: impl Fn(&Vector2<f64>) -> JonesMatrix,
    ) -> Result<Self, GratingError> {
        check_pitch(pitch)?;
        let along = unit(along)?;
        if samples == 0 || samples > MOST {
            return Err(GratingError::Value {
                what: "number of samples",
                value: samples as f64,
                range: [1.0, MOST as f64],
            });
        }
        let at = |n: usize| jones(&(along * (pitch * n as f64 / samples as f64)));
        Self::of_samples(pitch, along, (0..samples).map(at))
    }

    /// As [`PolarizationPattern::new`], from Jones matrices at equal steps over one period.
    ///
    /// # Errors
    ///
    /// As [`PolarizationPattern::new`].
    pub fn of_samples(
        pitch: f64,
        along: Vector2<f64>,
        samples: impl IntoIterator<Item = JonesMatrix>,
    ) -> Result<Self, GratingError> {
        check_pitch(pitch)?;
        let along = unit(along)?;
        let samples: Vec<Matrix2<Complex64>> =
            samples.into_iter().map(JonesMatrix::to_matrix).collect();
        let n = samples.len();
        if n == 0 || n > MOST {
            return Err(GratingError::Value {
                what: "number of samples",
                value: n as f64,
                range: [1.0, MOST as f64],
            });
        }
        for value in samples.iter().flat_map(|t| t.iter()) {
            super::check("modulus of an element", value.norm(), [0.0, 1e6])?;
        }
        let forward = FftPlanner::new().plan_fft_forward(n);
        let elements: [Vec<Complex64>; 4] = std::array::from_fn(|i| {
            let mut line: Vec<_> = samples.iter().map(|t| t[i] / n as f64).collect();
            forward.process(&mut line);
            line
        });
        let orders = (-((n as i32 - 1) / 2)..=n as i32 / 2).map(|q| {
            let harmonic = (-q).rem_euclid(n as i32) as usize;
            let t = Matrix2::from_fn(|row, column| elements[row + 2 * column][harmonic]);
            (q, JonesMatrix::from(t))
        });
        Ok(Self {
            wave_vector: along * (TAU / pitch),
            orders: orders.collect(),
        })
    }

    /// `G`, rad/m, in the axes of the tangents: order q is at `φ_t = qG`.
    #[must_use]
    pub fn wave_vector(&self) -> Vector2<f64> {
        self.wave_vector
    }

    /// All orders with their Jones matrices.
    #[must_use]
    pub fn orders(&self) -> &[(i32, JonesMatrix)] {
        &self.orders
    }

    /// The Jones matrix of an order; zero for one that the samples do not hold.
    #[must_use]
    pub fn order(&self, q: i32) -> JonesMatrix {
        let found = self.orders.iter().find(|(order, _)| *order == q);
        found.map_or_else(|| Matrix2::zeros().into(), |(_, jones)| *jones)
    }

    /// The channels of the orders with the most light, as few as leave out less than the tolerance.
    ///
    /// `common` is what all have: [`Autocorrelation::constant`] of 1 for an endless element, an aperture's or a rough
    /// surface's otherwise. The bound is the power of unpolarized light in what is left out over that in the largest
    /// order.
    #[must_use]
    pub fn channels(
        &self,
        common: &Autocorrelation,
        tolerance: Tolerance,
    ) -> (Channels, Approximation) {
        let (kept, approximation) = self.chosen(common, tolerance);
        let channels = kept
            .into_iter()
            .fold(Channels::default(), |sum, (jones, r)| {
                sum.with(&jones.mueller(), r, 0)
            });
        (channels, approximation)
    }

    /// As [`PolarizationPattern::channels`], as populations in an envelope.
    #[must_use]
    pub fn populations(
        &self,
        common: &Autocorrelation,
        envelope: &Envelope,
        tolerance: Tolerance,
    ) -> (Vec<Population>, Approximation) {
        let (kept, approximation) = self.chosen(common, tolerance);
        let populations = kept
            .into_iter()
            .map(|(jones, r)| Population::of_jones(&jones, r, envelope.clone()));
        (populations.collect(), approximation)
    }

    fn chosen(
        &self,
        common: &Autocorrelation,
        tolerance: Tolerance,
    ) -> (Vec<(JonesMatrix, Autocorrelation)>, Approximation) {
        let powers = self.orders.iter().map(|(q, jones)| {
            let power = 0.5 * jones.to_matrix().norm_squared();
            (*q, power)
        });
        let chosen = super::choice::pruned(powers.collect(), 0.0, tolerance.get(), MOST);
        let kept: Vec<_> = chosen
            .orders
            .iter()
            .map(|(q, _)| {
                let shift = self.wave_vector * f64::from(*q);
                (self.order(*q), common.clone().shifted(&shift))
            })
            .collect();
        let approximation = Approximation {
            method: Method::Orders,
            terms: kept.len() * common.term_count(),
            error: chosen.error,
        };
        (kept, approximation)
    }
}
