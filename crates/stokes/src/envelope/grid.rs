//! Piecewise constant profiles on a regular grid; a rectangle is a grid of one cell.
//!
//! `T = U R` with a rotation U and a triangular R leaves one direction in which the integral over a row of cells is
//! closed ([`super::staircase`]), and one for quadrature:
//!
//! ```text
//! ∫ I h_a(y₁) h_b(y₂) d²x = ∫ dx₂ h_b(r₂₂ x₂) ∫ dx₁ I h_a(r₁₁ x₁ + r₁₂ x₂),       y = R x
//! ```
//!
//! For axes along the grid r₁₂ = 0 and both are closed. Otherwise the range of x₂ is cut to where the functions
//! live, and split where an edge of the grid enters or leaves that range: the number of nodes is bounded for every T.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

use crate::basis::mode_index;
use crate::hermite::{self, MAX_ORDER};
use crate::plane;

use super::quadrature::{Rules, reach};
use super::staircase::Staircase;

/// Cells between consecutive edges.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Edges along x, ascending.
    pub(crate) columns: Vec<f64>,
    /// Edges along y, ascending.
    pub(crate) rows: Vec<f64>,
    /// Row by row, x first.
    pub(crate) samples: Vec<f64>,
}

/// `T = turn · [[r11, r12], [0, r22]]`
struct Triangular {
    turn: Matrix2<f64>,
    r11: f64,
    r12: f64,
    r22: f64,
}

impl Triangular {
    fn of(t: &Matrix2<f64>) -> Self {
        let (first, second) = (t.column(0), t.column(1));
        let length = first.norm();
        let axis = if length > 0.0 {
            first / length
        } else {
            // a singular T: any direction across the other column will do
            let across = second.norm();
            if across > 0.0 {
                Vector2::new(second.y, -second.x) / across
            } else {
                Vector2::x()
            }
        };
        Self {
            turn: Matrix2::new(axis.x, -axis.y, axis.y, axis.x),
            r11: length,
            r12: plane::sum_of_products(axis.x, second.x, axis.y, second.y),
            r22: if length > 0.0 {
                plane::determinant(t) / length
            } else {
                second.norm()
            },
        }
    }
}

impl Grid {
    /// The samples with their cells' areas and centres.
    fn cells(&self) -> impl Iterator<Item = (f64, f64, Vector2<f64>)> {
        self.rows
            .windows(2)
            .zip(self.samples.chunks_exact(self.columns.len() - 1))
            .flat_map(|(row, samples)| {
                self.columns
                    .windows(2)
                    .zip(samples)
                    .map(move |(column, sample)| {
                        let area = (column[1] - column[0]) * (row[1] - row[0]);
                        let centre =
                            Vector2::new(0.5 * (column[0] + column[1]), 0.5 * (row[0] + row[1]));
                        (*sample, area, centre)
                    })
            })
    }

    pub(crate) fn mass(&self) -> f64 {
        self.cells().map(|(sample, area, _)| sample * area).sum()
    }

    pub(crate) fn square_integral(&self) -> f64 {
        self.cells()
            .map(|(sample, area, _)| sample * sample * area)
            .sum()
    }

    pub(crate) fn centroid(&self) -> Vector2<f64> {
        let sum: Vector2<f64> = self
            .cells()
            .map(|(sample, area, centre)| centre * (sample * area))
            .sum();
        sum / self.mass()
    }

    /// The size of a cell.
    fn pixel(&self) -> [f64; 2] {
        [&self.columns, &self.rows]
            .map(|edges| (edges[edges.len() - 1] - edges[0]) / (edges.len() - 1) as f64)
    }

    pub(crate) fn covariance(&self) -> Matrix2<f64> {
        let origin = self.centroid();
        let sum: Matrix2<f64> = self
            .cells()
            .map(|(sample, area, centre)| {
                let d = centre - origin;
                d * d.transpose() * (sample * area)
            })
            .sum();
        let within = self.pixel().map(|size| size * size / 12.0);
        sum / self.mass() + Matrix2::new(within[0], 0.0, 0.0, within[1])
    }

    /// The sample of column `i` and row `j`.
    pub(crate) fn sample(&self, i: usize, j: usize) -> f64 {
        self.samples[j * (self.columns.len() - 1) + i]
    }

    /// The lower left and the upper right corner.
    pub(crate) fn corners(&self) -> [Vector2<f64>; 2] {
        let last = |edges: &[f64]| edges[edges.len() - 1];
        [
            Vector2::new(self.columns[0], self.rows[0]),
            Vector2::new(last(&self.columns), last(&self.rows)),
        ]
    }

    /// Half the size of the whole along each axis.
    pub(crate) fn half_extent(&self) -> [f64; 2] {
        let [low, high] = self.corners();
        (0.5 * (high - low)).into()
    }

    pub(crate) fn value(&self, x: &Vector2<f64>) -> f64 {
        let place = |edges: &[f64], t: f64| match edges.partition_point(|edge| *edge <= t) {
            0 => None,
            // the last edge belongs to the last cell
            i if i == edges.len() => (t == edges[i - 1]).then(|| i - 2),
            i => Some(i - 1),
        };
        match (place(&self.columns, x.x), place(&self.rows, x.y)) {
            (Some(i), Some(j)) => self.sample(i, j),
            _ => 0.0,
        }
    }

    pub(crate) fn fourier(&self, u: &Vector2<f64>) -> Complex64 {
        let along = |edges: &[f64], u: f64| -> Vec<Complex64> {
            edges
                .windows(2)
                .map(|edge| {
                    let (half, centre) = (0.5 * (edge[1] - edge[0]), 0.5 * (edge[0] + edge[1]));
                    Complex64::from_polar(2.0 * half, -u * centre) * sinc(u * half)
                })
                .collect()
        };
        let (first, second) = (along(&self.columns, u.x), along(&self.rows, u.y));
        self.samples
            .chunks_exact(first.len())
            .zip(second)
            .map(|(row, factor)| {
                factor
                    * row
                        .iter()
                        .zip(&first)
                        .map(|(sample, f)| f * *sample)
                        .sum::<Complex64>()
            })
            .sum()
    }

    /// `∫ I(x) h_a(y₁) h_b(y₂) d²x`, `y = T (x − origin)`, into `moments` over the modes up to `order`; they have to
    /// be turned by the orthogonal matrix that is returned.
    pub(crate) fn moments(
        &self,
        t: &Matrix2<f64>,
        origin: &Vector2<f64>,
        order: usize,
        moments: &mut [f64],
    ) -> Matrix2<f64> {
        let triangular = Triangular::of(t);
        let columns: Vec<f64> = self.columns.iter().map(|x| x - origin.x).collect();
        let mut rules = Rules::default();
        let mut first = [0.0; MAX_ORDER + 1];
        let mut second = [0.0; MAX_ORDER + 1];
        for (edges, values) in self
            .rows
            .windows(2)
            .zip(self.samples.chunks_exact(columns.len() - 1))
        {
            let row = Staircase {
                edges: &columns,
                values,
            };
            let range = [edges[0] - origin.y, edges[1] - origin.y];
            if triangular.r12 == 0.0 {
                row.moments(triangular.r11, 0.0, &mut rules, &mut first[..=order]);
                Staircase {
                    edges: &range,
                    values: &[1.0],
                }
                .moments(triangular.r22, 0.0, &mut rules, &mut second[..=order]);
                add_products(1.0, &first, &second, order, moments);
            } else {
                for [low, high, phase] in intervals(&triangular, &columns, range, order) {
                    let nodes: Vec<_> = rules.on(low, high, phase).collect();
                    for (x2, weight) in nodes {
                        row.moments(
                            triangular.r11,
                            triangular.r12 * x2,
                            &mut rules,
                            &mut first[..=order],
                        );
                        hermite::fill(triangular.r22 * x2, &mut second[..=order]);
                        add_products(weight, &first, &second, order, moments);
                    }
                }
            }
        }
        triangular.turn
    }
}

/// Pieces `[low, high, phase]` of a row on which the integrand is smooth.
fn intervals(t: &Triangular, columns: &[f64], range: [f64; 2], order: usize) -> Vec<[f64; 3]> {
    let far = reach(order);
    let live = if t.r22 == 0.0 {
        f64::INFINITY
    } else {
        far / t.r22.abs()
    };
    let (low, high) = (range[0].max(-live), range[1].min(live));
    if low >= high {
        return Vec::new();
    }
    let mut cuts = vec![low, high];
    for x in columns {
        for end in [-far, far] {
            let cut = (end - t.r11 * x) / t.r12;
            if cut > low && cut < high {
                cuts.push(cut);
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2)
        .map(|cut| {
            let middle = 0.5 * (cut[0] + cut[1]);
            let active = columns
                .iter()
                .any(|x| (t.r11 * x + t.r12 * middle).abs() < far);
            let frequency = t.r22.abs() + if active { t.r12.abs() } else { 0.0 };
            [cut[0], cut[1], 0.5 * (cut[1] - cut[0]) * far * frequency]
        })
        .collect()
}

/// Adds `weight · first_a · second_b` to every mode up to `order`.
pub(crate) fn add_products(
    weight: f64,
    first: &[f64],
    second: &[f64],
    order: usize,
    moments: &mut [f64],
) {
    for n in 0..=order {
        let place = mode_index(n, 0);
        for b in 0..=n {
            moments[place + b] += weight * first[n - b] * second[b];
        }
    }
}

/// `sin z / z`
fn sinc(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { z.sin() / z }
}
