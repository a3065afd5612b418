//! Whether light can exist: its Stokes vector and its radiance, point by point of the source, in the cone of Stokes
//! vectors.
//!
//! A coherence function of the separation alone belongs to some light exactly if its matrix Wigner function is
//! positive semidefinite, that is, if all generalized radiances satisfy `S0 ≥ √(S1² + S2² + S3²)` (Bochner). A truncated
//! series is a polynomial times a Gaussian there and may well leave the cone: a hard edge rings to −0.1 of the peak at
//! any order. Nothing is clamped; this file finds the worst places and says by how much.

use std::fmt;

use nalgebra::Vector2;

use crate::basis::mode_index;
use crate::beam::GeneralizedStokes;
use crate::components::Components;
use crate::hermite::fill;
use crate::plane;
use crate::series::HermiteSeries;
use crate::vector::StokesVector;

/// Step of the search in units of `1/√(2N+1)`, the fastest scale of a series of order N: 8 points per shortest period.
const STEP: f64 = 0.75;

/// How far the peaks are followed uphill in each round, in steps of the grid, and which part of the highest of them
/// a peak must reach to be followed there. Half a step from its nearest grid point a peak of the fastest scale is
/// `STEP²/4` = 14 per cent higher, an eighth of a step from it 1 per cent.
const ROUNDS: [[f64; 2]; 2] = [[0.125, 0.75], [1e-8, 0.98]];

/// A place where the radiance is not that of any light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The point of the source, metres along the axes of the light's frame, as
    /// [`GeneralizedStokes::generalized_radiance`] takes it.
    pub position: Vector2<f64>,
    /// The generalized radiance from there, in the light's frame.
    pub radiance: StokesVector,
    /// By how much it is wrong, in the unit of the radiance; positive.
    pub amount: f64,
    /// The amount over the peak of the radiance; infinite where the radiance is nowhere positive.
    pub relative: f64,
}

/// What [`GeneralizedStokes::realizability`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Realizability {
    /// The Stokes vector at zero separation: violated by `−S0` or by the negative of its unpolarized intensity.
    pub stokes: StokesVector,
    /// Largest total radiance `S0` over the source, or 0 where none is positive.
    pub peak: f64,
    /// The most negative total radiance, `amount = −S0`; `None` where it is nowhere negative.
    pub negative_radiance: Option<Violation>,
    /// The place where the polarized radiance exceeds the total one most, `amount = √(S1² + S2² + S3²) − S0`; `None`
    /// where it does not. At least as large as the negative radiance.
    pub cone_excess: Option<Violation>,
}

impl Realizability {
    /// Whether light like this exists, up to violations of `tolerance` relative to the peak radiance, and to the
    /// intensity at zero separation.
    ///
    /// Fully polarized light lies on the cone, where rounding decides: ask with 1e-12 rather than 0.
    #[must_use]
    pub fn is_realizable(&self, tolerance: f64) -> bool {
        let within = |violation: &Option<Violation>| {
            violation.is_none_or(|violation| violation.relative <= tolerance)
        };
        self.stokes_excess() <= tolerance
            && within(&self.negative_radiance)
            && within(&self.cone_excess)
    }

    /// By how much the Stokes vector at zero separation lies outside the cone, `√(S1² + S2² + S3²) − S0`, relative to
    /// the larger of the polarized and the total intensity; negative inside, 0 for dark light.
    #[must_use]
    pub fn stokes_excess(&self) -> f64 {
        let scale = self
            .stokes
            .s0()
            .abs()
            .max(self.stokes.polarized_intensity());
        if scale > 0.0 {
            -self.stokes.unpolarized_intensity() / scale
        } else {
            0.0
        }
    }
}

/// What is violated and by how much, or that nothing is.
impl fmt::Display for Realizability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut found = Vec::new();
        let (s0, polarized) = (self.stokes.s0(), self.stokes.polarized_intensity());
        if s0 < 0.0 {
            found.push(format!("the intensity is {s0:e}"));
        }
        if self.stokes_excess() > 0.0 {
            found.push(format!(
                "the polarized intensity {polarized:e} exceeds the intensity {s0:e}"
            ));
        }
        for (violation, what) in [
            (&self.negative_radiance, "the radiance is negative"),
            (
                &self.cone_excess,
                "the polarized radiance exceeds the radiance",
            ),
        ] {
            if let Some(Violation {
                position,
                amount,
                relative,
                ..
            }) = violation
            {
                let (x, y) = (position.x, position.y);
                found.push(format!(
                    "{what} by {amount:e} ({relative:.3e} of the peak) at the source point ({x:e}, {y:e}) m"
                ));
            }
        }
        if found.is_empty() {
            f.write_str("realizable")
        } else {
            write!(f, "not realizable: {}", found.join("; "))
        }
    }
}

impl GeneralizedStokes {
    /// Whether this light can exist, and if not where it fails most.
    ///
    /// Order 0 is answered in closed form. Otherwise the radiance is evaluated over the square
    /// `|y|∞ ≤ √(2N+1) + 4` of whitened coordinates, 8 points per shortest period of order N, and the worst places are
    /// followed to their maximum: amounts are right to rounding, places to 1e-7 of the period. Violations beyond
    /// the square are missed; there the modes are below 1e-6. An audit, not for every ray: 1 ms at order 4, 0.1 s at 64,
    /// seconds at 256.
    ///
    /// Source: Bochner's theorem for matrices; Eq. (S4.6) and the Poincaré sphere condition below it, which holds for
    /// radiances and at zero separation but not between two points.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector3};
    /// use stokes::*;
    /// let light = |stokes| {
    ///     GeneralizedStokes::new(
    ///         Components::Shared { modes: HermiteSeries::fundamental(1.0), stokes },
    ///         ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3))?,
    ///         Frame::with_x_along(Vector3::z(), Vector3::x())?,
    ///         Wavelength::from_metres(500e-9)?,
    ///         1.0,
    ///     )
    ///     .map_err(Box::<dyn std::error::Error>::from)
    /// };
    /// assert!(light(StokesVector::RIGHT_CIRCULAR)?.realizability().is_realizable(0.0));
    /// let report = light(StokesVector::new(1.0, 0.0, 0.0, -1.5))?.realizability();
    /// assert!(!report.is_realizable(0.499) && report.is_realizable(0.5 + 1e-15));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn realizability(&self) -> Realizability {
        let search = Search::new(self.components());
        let [darkest, outermost, brightest] = search.worst();
        let unit = self.radiance_unit();
        let peak = brightest.map_or(0.0, |found| found.value * unit);
        let violation = |found: Found| {
            // y = −W^(−T) position
            let position =
                Vector2::zeros() - plane::apply(&self.shape().root().transpose(), &found.place);
            let amount = found.value * unit;
            Violation {
                position,
                radiance: search.sums(&found.place) * unit,
                amount,
                relative: amount / peak,
            }
        };
        Realizability {
            stokes: self.stokes().stokes,
            peak,
            negative_radiance: darkest.map(violation),
            cone_excess: outermost.map(violation),
        }
    }
}

/// A positive value of one of the three objectives, and where.
#[derive(Clone, Copy)]
struct Found {
    place: Vector2<f64>,
    value: f64,
}

/// The search for the extremes of four sums `Σ s_ab h_a(y1) h_b(y2)`.
struct Search<'a> {
    components: &'a Components,
    order: usize,
    step: f64,
    /// The grid has `2·half + 1` points along each axis.
    half: usize,
}

/// What is to be maximized: negative intensity, excess over the cone, intensity.
fn objectives(sums: &StokesVector) -> [f64; 3] {
    [-sums.s0(), -sums.unpolarized_intensity(), sums.s0()]
}

impl<'a> Search<'a> {
    fn new(components: &'a Components) -> Self {
        let order = components.order();
        let turning_point = ((2 * order + 1) as f64).sqrt();
        let step = STEP / turning_point;
        Self {
            components,
            order,
            step,
            half: ((turning_point + 4.0) / step).ceil() as usize,
        }
    }

    fn sums(&self, y: &Vector2<f64>) -> StokesVector {
        self.components.map(|series| series.real_sum(y)).into()
    }

    /// The largest positive value of each objective, `None` where there is none.
    fn worst(&self) -> [Option<Found>; 3] {
        if self.order == 0 {
            // one Gaussian times a fixed vector: all extremes are at its centre
            let place = Vector2::zeros();
            return objectives(&self.sums(&place))
                .map(|value| (value > 0.0).then_some(Found { place, value }));
        }
        let grid = self.grid();
        [0, 1, 2].map(|which| {
            let mut tops = self.candidates(&grid, which);
            for [finest, worthy] in ROUNDS {
                let highest = tops.iter().fold(0.0, |most: f64, top| most.max(top.value));
                tops.retain(|top| top.value >= worthy * highest);
                for top in &mut tops {
                    *top = self.climb(*top, which, finest * self.step);
                }
            }
            tops.into_iter().max_by(|a, b| a.value.total_cmp(&b.value))
        })
    }

    fn at(&self, place: usize) -> f64 {
        (place as f64 - self.half as f64) * self.step
    }

    /// The objectives at every point of the grid, row by row.
    fn grid(&self) -> Vec<[f64; 3]> {
        let count = 2 * self.half + 1;
        let functions: Vec<Vec<f64>> = (0..count)
            .map(|place| {
                let mut values = vec![0.0; self.order + 1];
                fill(self.at(place), &mut values);
                values
            })
            .collect();
        let mut grid = Vec::with_capacity(count * count);
        for along in &functions {
            let rows: Vec<[f64; 4]> = match self.components {
                Components::Shared { modes, stokes } => row(modes, along, &functions)
                    .into_iter()
                    .map(|sum| (*stokes * sum).to_array())
                    .collect(),
                Components::Separate(series) => {
                    let mut rows = vec![[0.0; 4]; count];
                    for (j, series) in series.iter().enumerate() {
                        let Some(series) = series else { continue };
                        for (sums, sum) in rows.iter_mut().zip(row(series, along, &functions)) {
                            sums[j] = sum;
                        }
                    }
                    rows
                }
            };
            grid.extend(rows.into_iter().map(|sums| objectives(&sums.into())));
        }
        grid
    }

    /// The local maxima of the grid at which the objective is positive.
    fn candidates(&self, grid: &[[f64; 3]], which: usize) -> Vec<Found> {
        let count = 2 * self.half + 1;
        let mut tops = Vec::new();
        for i in 0..count {
            for j in 0..count {
                let here = grid[i * count + j][which];
                let rows = i.saturating_sub(1)..(i + 2).min(count);
                let top = here > 0.0
                    && rows.into_iter().all(|row| {
                        let columns = j.saturating_sub(1)..(j + 2).min(count);
                        grid[row * count..][columns]
                            .iter()
                            .all(|values| values[which] <= here)
                    });
                if top {
                    tops.push(Found {
                        place: Vector2::new(self.at(i), self.at(j)),
                        value: here,
                    });
                }
            }
        }
        tops
    }

    /// Uphill to the maximum nearby: the best of eight neighbours, nearer ones when none is better.
    fn climb(&self, from: Found, which: usize, finest: f64) -> Found {
        const AROUND: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        let Found {
            mut place,
            mut value,
        } = from;
        let mut step = 0.5 * self.step;
        while step >= finest {
            let best = AROUND
                .map(|[x, y]| {
                    let there = place + Vector2::new(x, y) * step;
                    (objectives(&self.sums(&there))[which], there)
                })
                .into_iter()
                .max_by(|a, b| a.0.total_cmp(&b.0));
            match best {
                Some((higher, there)) if higher > value => (value, place) = (higher, there),
                _ => step *= 0.5,
            }
        }
        Found { place, value }
    }
}

/// `Σ s_ab h_a h_b` for fixed `h_a` and each row of `functions` for `h_b`.
fn row(series: &HermiteSeries, along: &[f64], functions: &[Vec<f64>]) -> Vec<f64> {
    let (order, real) = (series.order(), series.real_coefficients());
    let partial: Vec<f64> = (0..=order)
        .map(|b| {
            (0..=order - b)
                .map(|a| real[mode_index(a, b)] * along[a])
                .sum()
        })
        .collect();
    functions
        .iter()
        .map(|across| partial.iter().zip(across).map(|(s, h)| s * h).sum())
        .collect()
}
