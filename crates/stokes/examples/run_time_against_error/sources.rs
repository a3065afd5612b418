//! What evaluation and projection cost at every order, and what error is left: a Gaussian, a rectangle, a disk.

use std::hint::black_box;

use nalgebra::Matrix2;
use stokes::{
    Envelope, EnvelopeError, HermiteSeries, ModeWidth, ShapeMatrix, all_modes, contract,
    contract_at, mode_count,
};

use crate::clock::{Contestant, Rounds, race};
use crate::yardsticks::{BATCH, lattice};

pub(crate) const ORDERS: [usize; 13] = [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
/// What is timed.
pub(crate) const TASKS: [&str; 4] = [
    "evaluate f64",
    "evaluate f32",
    "evaluate f32, 16 points",
    "project",
];
/// Standard deviations in the half-width, and variance of the shape over that of the Gaussian.
const SIGMAS: f64 = 4.0;
const VARIANCE_RATIO: f64 = 2.0;

/// A source and the Gaussian under its modes.
pub(crate) struct Source {
    pub(crate) name: &'static str,
    pub(crate) width: &'static str,
    envelope: Envelope,
    modes: Modes,
}

enum Modes {
    /// Over a shape that is not the source's own.
    Over(ShapeMatrix),
    Wide(ModeWidth),
}

/// Errors of a truncated series, relative.
pub(crate) struct Errors {
    /// L² norm of what is missing over that of the whole.
    pub(crate) norm: f64,
    /// Of the value at zero separation, which is the power; signed.
    pub(crate) at_zero: f64,
    /// Largest difference between evaluation in f32 and in f64, over the largest value.
    pub(crate) f32: f64,
}

pub(crate) fn all() -> Result<Vec<Source>, Box<dyn std::error::Error>> {
    let hard = |name, width, envelope: &Envelope, modes| Source {
        name,
        width,
        envelope: envelope.clone(),
        modes: Modes::Wide(modes),
    };
    let rectangle = Envelope::rectangle(1.0, 1.0)?;
    let disk = Envelope::disk(1.0)?;
    let (matched, narrow) = (ModeWidth::VarianceMatched, ModeWidth::Sigmas(SIGMAS));
    Ok(vec![
        Source {
            name: "gaussian",
            width: "variance × 2",
            envelope: Envelope::gaussian(&Matrix2::identity())?,
            modes: Modes::Over(ShapeMatrix::from_root(
                &(Matrix2::identity() * VARIANCE_RATIO.sqrt()),
            )?),
        },
        hard("rectangle", "variance matched", &rectangle, matched),
        hard("rectangle", "half-width 4 σ", &rectangle, narrow),
        hard("disk", "variance matched", &disk, matched),
        hard("disk", "half-width 4 σ", &disk, narrow),
    ])
}

impl Source {
    /// The series up to an order, and its errors.
    pub(crate) fn series(&self, order: usize) -> Result<(HermiteSeries, Errors), EnvelopeError> {
        match &self.modes {
            Modes::Wide(width) => {
                let modes = self.envelope.modes(*width, order)?;
                let errors = Errors {
                    norm: modes.relative_error(),
                    at_zero: modes.sum_at_zero() / modes.area() - 1.0,
                    f32: rounding(modes.series()),
                };
                Ok((modes.series().clone(), errors))
            }
            Modes::Over(shape) => {
                // Parseval; 64 orders more hold all but 1e-15 of what is missing
                let long = self
                    .envelope
                    .project(&Matrix2::identity(), shape, order + 64)?;
                let (series, lost) = long.truncated(order);
                let errors = Errors {
                    norm: lost / long.norm(),
                    at_zero: series.value_at_zero(shape) / self.envelope.area() - 1.0,
                    f32: rounding(&series),
                };
                Ok((series, errors))
            }
        }
    }

    /// Times all tasks at an order.
    pub(crate) fn measure(
        &self,
        order: usize,
        rounds: usize,
        slice: f64,
    ) -> Result<Rounds, EnvelopeError> {
        let (series, _) = self.series(order)?;
        let s = series.real_coefficients();
        let s32 = narrowed(s);
        let points = lattice();
        let points32 = points.map(|y| y.map(|t| t as f32));
        let order = black_box(order);
        let mut sums = [0.0; BATCH];
        Ok(race(
            vec![
                Contestant::new(TASKS[0], points.len(), || {
                    for y in &points {
                        black_box(contract(order, s, *black_box(y)));
                    }
                }),
                Contestant::new(TASKS[1], points.len(), || {
                    for y in &points32 {
                        black_box(contract(order, &s32, *black_box(y)));
                    }
                }),
                Contestant::new(TASKS[2], points.len(), || {
                    for batch in points32.chunks(BATCH) {
                        contract_at(order, &s32, black_box(batch), black_box(&mut sums));
                    }
                }),
                Contestant::new(TASKS[3], 1, || match &self.modes {
                    Modes::Wide(width) => {
                        let _ = black_box(black_box(&self.envelope).modes(*width, order));
                    }
                    Modes::Over(shape) => {
                        let plane = Matrix2::identity();
                        let _ = black_box(black_box(&self.envelope).project(&plane, shape, order));
                    }
                }),
            ],
            rounds,
            slice,
        ))
    }
}

fn narrowed(s: &[f64]) -> Vec<f32> {
    s.iter().map(|s| *s as f32).collect()
}

/// Coefficients, modes and sums in f32 against the plain sum in f64.
fn rounding(series: &HermiteSeries) -> f64 {
    let (order, s) = (series.order(), series.real_coefficients());
    let s32 = narrowed(s);
    let mut modes = vec![0.0; mode_count(order)];
    let (mut largest, mut worst) = (0.0f64, 0.0f64);
    for y in lattice() {
        let y32 = y.map(|t| t as f32);
        // at the point that f32 sees
        all_modes(order, y32.map(f64::from), &mut modes);
        let exact: f64 = modes.iter().zip(s).map(|(mode, s)| mode * s).sum();
        largest = largest.max(exact.abs());
        worst = worst.max((f64::from(contract(order, &s32, y32)) - exact).abs());
    }
    worst / largest
}
