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
use crate::beam::{Components, GeneralizedStokes};
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, MAX_ORDER, ShapeMatrix, Wavelength, hermite, mode_count, modes};
    use nalgebra::{Matrix2, Vector3};
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn light(components: Components) -> GeneralizedStokes {
        GeneralizedStokes::new(
            components,
            ShapeMatrix::from_root(&Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3)).unwrap(),
            Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
            Wavelength::from_metres(500e-9).unwrap(),
            2.0,
        )
        .unwrap()
    }

    fn unpolarized(modes: HermiteSeries) -> GeneralizedStokes {
        let stokes = StokesVector::UNPOLARIZED;
        light(Components::Shared { modes, stokes })
    }

    /// The series `c0 φ_00 + c2 φ_20`.
    fn single_axis(c0: f64, c2: f64) -> HermiteSeries {
        HermiteSeries::from_modes(&[(0, 0, c0.into()), (2, 0, c2.into())]).unwrap()
    }

    #[test]
    fn the_order_two_series_is_realizable_between_its_two_bounds() {
        let bound = -2f64.sqrt();
        for c2 in [bound * (1.0 - 1e-9), -1.0, -0.3, 0.0] {
            let report = unpolarized(single_axis(1.0, c2)).realizability();
            assert!(report.is_realizable(0.0), "{c2}: {report}");
            assert_eq!(report.to_string(), "realizable");
        }
        // below: negative at the centre, c0 + c2/√2; the peak of |y| e^(−y²/2) form lies at u = 2 + A/B
        let c2 = -2.0;
        let light = unpolarized(single_axis(1.0, c2));
        let report = light.realizability();
        let (a, b) = (1.0 + c2 / 2f64.sqrt(), 2f64.sqrt() * c2);
        let peak = -2.0 * b * (-0.5 * (2.0 + a / b)).exp();
        let found = report.negative_radiance.unwrap();
        assert!(
            (found.relative + a / peak).abs() < 1e-14,
            "{}",
            found.relative
        );
        assert!(
            (found.amount + a * light.radiance_unit() / PI.sqrt()).abs() < 1e-14 * found.amount
        );
        // a maximum is flat: its place is known to the root of the rounding
        let y = light.shape().fourier_dual().whiten(&found.position);
        assert!(y.norm() < 1e-7, "{y}");
        // above: negative beyond y² = 2 + A/B, by 2B e^(−(2 + A/B)/2)
        for c2 in [1.0, 0.3, 0.1] {
            let light = unpolarized(single_axis(1.0, c2));
            let report = light.realizability();
            let (a, b) = (1.0 + c2 / 2f64.sqrt(), 2f64.sqrt() * c2);
            let depth = 2.0 * b * (-0.5 * (2.0 + a / b)).exp();
            let found = report.negative_radiance.unwrap();
            assert!((found.relative / (depth / a) - 1.0).abs() < 1e-13, "{c2}");
            let y = light.shape().fourier_dual().whiten(&found.position);
            assert!(
                (y.x * y.x - 2.0 - a / b).abs() < 1e-5 && y.y.abs() < 1e-5,
                "{y}"
            );
            assert!(!report.is_realizable(0.99 * depth / a));
            assert!(report.is_realizable(1.01 * depth / a));
        }
    }

    /// `∫ h_n` over a box of half-width √3 standard deviations, by Simpson's rule (error below 1e-12).
    fn box_coefficients(order: usize) -> Vec<f64> {
        let (half, cells) = (3f64.sqrt(), 4000);
        let step = 2.0 * half / f64::from(cells);
        (0..=order)
            .map(|n| {
                (0..=cells)
                    .map(|i| {
                        let weight = match i {
                            0 => 1.0,
                            _ if i == cells => 1.0,
                            _ if i % 2 == 1 => 4.0,
                            _ => 2.0,
                        };
                        weight * hermite(n, -half + f64::from(i) * step)
                    })
                    .sum::<f64>()
                    * step
                    / 3.0
            })
            .collect()
    }

    #[test]
    fn a_box_rings_below_zero_at_every_order() {
        for order in [4, 8, 16, 32, 64] {
            let j = box_coefficients(order);
            // a box along the first axis, the matched Gaussian across
            let mut real = vec![0.0; mode_count(order)];
            for n in 0..=order {
                real[mode_index(n, 0)] = j[n];
            }
            let report =
                unpolarized(HermiteSeries::from_real_coefficients(&real).unwrap()).realizability();
            // slow and obvious: the sum at 40,001 points of the axis
            let profile: Vec<f64> = (-20_000..=20_000)
                .map(|i| {
                    let t = f64::from(i) * 1e-3;
                    (0..=order).map(|n| j[n] * hermite(n, t)).sum()
                })
                .collect();
            let lowest = profile.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = profile.iter().copied().fold(0.0, f64::max);
            let found = report.negative_radiance.unwrap();
            // the extremes of a function of curvature 2N+1, half a step of 1e-3 from a point
            let slack = (2 * order + 1) as f64 * 1e-6;
            assert!((found.relative + lowest / highest).abs() < slack, "{order}");
            // Gibbs: the reconstructed indicator reaches about −0.1
            assert!((-0.14..-0.06).contains(&lowest), "{order}: {lowest}");
            assert!(report.to_string().contains("the radiance is negative by"));
        }
    }

    #[test]
    fn a_component_of_a_wider_gaussian_leaves_the_cone_at_the_centre() {
        // C3 = 0.9 e^(−w²/(2·2θ)): in w its width is √2 that of C0, at the source 1/√2 and twice as high
        let wide =
            ShapeMatrix::from_root(&(Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3) / 2f64.sqrt()))
                .unwrap();
        let base = light(Components::Separate([None, None, None, None]));
        // equal values at 0 need c ∝ |det W|^(−1/2): twice the determinant ratio's root
        let (c3, lost) =
            HermiteSeries::fundamental(0.9 * 2f64.sqrt()).in_shape(&wide, base.shape(), 60);
        assert!(lost < 1e-13);
        let light = light(Components::Separate([
            Some(HermiteSeries::fundamental(1.0)),
            None,
            None,
            Some(c3),
        ]));
        assert!((light.stokes().stokes.degree_of_polarization() - 0.9).abs() < 1e-13);
        let report = light.realizability();
        let worst = report.cone_excess.unwrap();
        assert!((worst.radiance.degree_of_polarization() - 1.8).abs() < 1e-12);
        assert!((worst.relative - 0.8).abs() < 1e-12, "{report}");
        assert!(light.shape().fourier_dual().whiten(&worst.position).norm() < 1e-6);
        assert_eq!(report.negative_radiance, None);
        assert!(!report.is_realizable(0.7) && report.is_realizable(0.81));
        assert!(report.stokes_excess() < -0.09);
    }

    #[test]
    fn light_of_one_gaussian_is_judged_by_its_stokes_vector() {
        for (stokes, excess) in [
            ([1.0, 0.0, 0.0, -1.0], None),
            ([1.0, 0.0, 0.0, 0.0], None),
            ([1.0, 0.0, 1.5, 0.0], Some(0.5)),
            ([0.0, 0.0, 0.0, 0.0], None),
        ] {
            let modes = HermiteSeries::fundamental(2.0);
            let stokes = stokes.into();
            let report = light(Components::Shared { modes, stokes }).realizability();
            let found = report.cone_excess.map_or(0.0, |found| found.relative);
            assert!((found - excess.unwrap_or(0.0)).abs() < 4.0 * f64::EPSILON);
            assert_eq!(report.negative_radiance, None);
            assert_eq!(report.is_realizable(1e-15), excess.is_none());
        }
        // on the cone but for the rounding of its numbers
        let modes = HermiteSeries::fundamental(2.0);
        let stokes = StokesVector::new(1.0, 0.6, 0.0, 0.8);
        let report = light(Components::Shared { modes, stokes }).realizability();
        assert!(report.is_realizable(f64::EPSILON), "{report}");
        // a negative intensity, in two ways
        for (c00, s0) in [(1.0, -1.0), (-1.0, 1.0)] {
            let modes = HermiteSeries::fundamental(c00);
            let stokes = StokesVector::new(s0, 0.0, 0.0, 0.0);
            let report = light(Components::Shared { modes, stokes }).realizability();
            assert_eq!(report.peak, 0.0);
            assert_eq!(report.negative_radiance.unwrap().relative, f64::INFINITY);
            let text = report.to_string();
            assert!(
                text.starts_with("not realizable: the intensity is -"),
                "{text}"
            );
            assert!(text.contains("the radiance is negative by "), "{text}");
            assert!(
                text.contains("(inf of the peak) at the source point (0e0, 0e0) m"),
                "{text}"
            );
        }
    }

    #[test]
    fn the_worst_place_is_reported_where_its_radiance_is() {
        // lopsided on purpose: a lost sign of the position would find another radiance
        let s = [1.0, 0.9, -0.4, 0.3, 0.2, -0.1];
        let light = unpolarized(HermiteSeries::from_real_coefficients(&s).unwrap());
        let found = light.realizability().negative_radiance.unwrap();
        let there = light.generalized_radiance(&found.position);
        assert!((there.s0() + found.amount).abs() < 1e-14 * light.radiance_unit());
        assert!((there - found.radiance).to_vector().norm() < 1e-14 * light.radiance_unit());
        let opposite = light.generalized_radiance(&-found.position);
        assert!((opposite.s0() - there.s0()).abs() > 1e-2 * light.radiance_unit());
    }

    #[test]
    fn beyond_the_square_that_is_searched_nothing_is_left() {
        for order in (1..=MAX_ORDER).step_by(5) {
            let edge = ((2 * order + 1) as f64).sqrt() + 4.0;
            // no |h_b| exceeds 0.76, and beyond the turning point h_n falls
            for n in 0..=order {
                assert!(hermite(n, edge).abs() * 0.76 < 1e-6, "{order} {n}");
            }
        }
    }

    /// Four random series up to order 4.
    fn components() -> impl Strategy<Value = [Vec<f64>; 4]> {
        prop::array::uniform4(prop::collection::vec(-1.0..1.0f64, 15))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn no_random_place_is_worse_than_the_one_reported(
            s in components(),
            places in prop::collection::vec(prop::array::uniform2(-5.0..5.0f64), 200),
        ) {
            let series = s.map(|real| HermiteSeries::from_real_coefficients(&real).ok());
            let light = light(Components::Separate(series));
            let report = light.realizability();
            let slack = 1e-12 * light.radiance_unit();
            let amount = |found: Option<Violation>| found.map_or(0.0, |found| found.amount) + slack;
            for y in places {
                let m = light.shape().root().transpose() * Vector2::from(y);
                let there = light.generalized_radiance(&m);
                prop_assert!(-there.s0() <= amount(report.negative_radiance));
                prop_assert!(there.polarized_intensity() - there.s0() <= amount(report.cone_excess));
                prop_assert!(there.s0() <= report.peak + slack);
            }
        }

        #[test]
        fn a_sum_of_gaussian_sources_in_the_cone_is_realizable(
            parts in prop::collection::vec(
                (prop::array::uniform2(-0.8..0.8f64), 0.0..1.0f64, 0.0..PI, -1.5..1.5f64, 0.0..1.0f64), 1..4),
        ) {
            // each part: a Gaussian shifted by t, with a Stokes vector in the cone; s_ab ∝ t^(a+b)
            let order = 24;
            let mut sums: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; mode_count(order)]);
            for ([x, y], weight, psi, chi, degree) in parts {
                let stokes = [
                    weight,
                    weight * degree * chi.cos() * psi.cos(),
                    weight * degree * chi.cos() * psi.sin(),
                    weight * degree * chi.sin(),
                ];
                let along = |t: f64| {
                    (1..=order).fold(vec![1.0], |mut powers, n| {
                        powers.push(powers[n - 1] * t / (2.0 * n as f64).sqrt());
                        powers
                    })
                };
                let (p, q) = (along(x), along(y));
                for (place, (a, b)) in modes(order).enumerate() {
                    for j in 0..4 {
                        sums[j][place] += stokes[j] * p[a] * q[b];
                    }
                }
            }
            let series = sums.map(|real| HermiteSeries::from_real_coefficients(&real).ok());
            let report = light(Components::Separate(series)).realizability();
            // modes left out: (1.13/√2)^25/√25! < 1e-14 of the largest, a few hundred of them at most
            prop_assert!(report.is_realizable(1e-11), "{}", report);
        }
    }
}
