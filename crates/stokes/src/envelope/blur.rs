//! A profile and its patches, both seen through a Gaussian lobe.

use nalgebra::{Matrix2, Vector2};

use crate::plane;

use super::grid::Grid;
use super::{Envelope, GaussianPatch, Profile, disk, patches};

/// Standard deviations beyond which a Gaussian is left out: e^(−32) = 1e-14.
pub(crate) const CUT: f64 = 8.0;

/// Points along the longer axis of a search, at most.
const FINEST: f64 = 1000.0;

/// The largest modulus of the difference of the two, over the peak of the blurred profile.
pub(crate) fn largest_difference(
    envelope: &Envelope,
    patches: &[GaussianPatch],
    lobe_sigma: f64,
) -> f64 {
    let pair = Pair {
        envelope,
        grid: envelope.as_grid(),
        patches: BlurredPatches::new(patches, lobe_sigma),
        lobe_sigma,
    };
    let mut search = Search::default();
    match &envelope.0 {
        // the patches are the profile
        Profile::Gaussians(_) => return 0.0,
        Profile::Disk(radius) => pair.search_disk(*radius, &mut search),
        // the other quadrants look the same
        Profile::Rectangle(half) => {
            let high = Vector2::from(*half).add_scalar(pair.margin());
            pair.search_box(Vector2::zeros(), high, &mut search);
        }
        Profile::Grid(grid) => {
            let [low, high] = grid.corners();
            let margin = pair.margin();
            pair.search_box(
                low.add_scalar(-margin),
                high.add_scalar(margin),
                &mut search,
            );
        }
    }
    pair.climb(&mut search);
    search.largest / search.peak
}

/// The L² norm of the difference of the two, over that of the profile.
pub(crate) fn relative_norm(envelope: &Envelope, patches: &[GaussianPatch]) -> f64 {
    if matches!(&envelope.0, Profile::Gaussians(_)) {
        return 0.0;
    }
    let grid = envelope.as_grid();
    let whole = envelope.square_integral();
    let cross: f64 = patches
        .iter()
        .map(|patch| patch.weight * under_patch(envelope, grid.as_ref(), patch))
        .sum();
    let square = patches::square_integral(patches);
    ((whole - 2.0 * cross + square).max(0.0) / whole).sqrt()
}

/// The mean of the profile over a patch.
fn under_patch(envelope: &Envelope, grid: Option<&Grid>, patch: &GaussianPatch) -> f64 {
    match (&envelope.0, grid) {
        (Profile::Disk(radius), _) => {
            // the disk looks the same in the patch's own axes
            let axes = plane::singular_values(&patch.covariance);
            let centre = axes.left.tr_mul(&patch.centre);
            disk::under_gaussian(*radius, axes.values.map(f64::sqrt), centre.into())
        }
        (_, Some(grid)) => {
            // a Gaussian is π^(1/2) h_0 h_0 of whitened coordinates
            let root = plane::symmetric_root(&patch.covariance);
            let mut moment = [0.0];
            grid.moments(&plane::inverse(&root), &patch.centre, 0, &mut moment);
            moment[0] / (2.0 * std::f64::consts::PI.sqrt() * plane::determinant(&root))
        }
        (_, None) => 0.0,
    }
}

/// Where the difference was largest so far.
#[derive(Default)]
struct Search {
    largest: f64,
    place: Vector2<f64>,
    peak: f64,
    step: f64,
}

struct Pair<'a> {
    envelope: &'a Envelope,
    grid: Option<Grid>,
    patches: BlurredPatches,
    lobe_sigma: f64,
}

impl Pair<'_> {
    /// How far beyond the profile differences are looked for.
    fn margin(&self) -> f64 {
        4.0 * self.lobe_sigma
    }

    fn step(&self, extent: f64) -> f64 {
        (self.lobe_sigma / 3.0).max(extent / FINEST)
    }

    fn look(&self, place: Vector2<f64>, profile: f64, search: &mut Search) {
        search.peak = search.peak.max(profile);
        let difference = (profile - self.patches.value(&place)).abs();
        if difference > search.largest {
            search.largest = difference;
            search.place = place;
        }
    }

    /// All places of a box.
    fn search_box(&self, low: Vector2<f64>, high: Vector2<f64>, search: &mut Search) {
        let size = high - low;
        search.step = self.step(size.x.max(size.y));
        let places = |low: f64, high: f64| -> Vec<f64> {
            let count = ((high - low) / search.step).ceil().max(1.0) as usize;
            (0..=count)
                .map(|i| low + (high - low) * (i as f64 / count as f64))
                .collect()
        };
        let (columns, rows) = (places(low.x, high.x), places(low.y, high.y));
        for y in &rows {
            for x in &columns {
                let place = Vector2::new(*x, *y);
                self.look(place, self.profile(&place), search);
            }
        }
    }

    /// A twelfth of the disk, by rings on which the profile is constant.
    fn search_disk(&self, radius: f64, search: &mut Search) {
        let outer = radius + self.margin();
        search.step = self.step(outer);
        let count = (outer / search.step).ceil() as usize;
        for i in 0..=count {
            let r = outer * (i as f64 / count as f64);
            let profile = self.profile(&Vector2::new(r, 0.0));
            let angle = std::f64::consts::FRAC_PI_6;
            let places = (angle * r / search.step).ceil() as usize;
            for j in 0..=places {
                let (sin, cos) = (angle * (j as f64 / places.max(1) as f64)).sin_cos();
                self.look(Vector2::new(r * cos, r * sin), profile, search);
            }
        }
    }

    /// Steps towards larger differences until they are a hundredth of the first.
    fn climb(&self, search: &mut Search) {
        let mut step = 0.5 * search.step;
        for _ in 0..6 {
            for _ in 0..4 {
                let from = search.place;
                for (dx, dy) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                    let place = from + Vector2::new(dx, dy) * step;
                    self.look(place, self.profile(&place), search);
                }
                if search.place == from {
                    break;
                }
            }
            step *= 0.5;
        }
    }

    fn profile(&self, x: &Vector2<f64>) -> f64 {
        match (&self.envelope.0, &self.grid) {
            (Profile::Disk(radius), _) => {
                disk::under_gaussian(*radius, [self.lobe_sigma; 2], [x.norm(), 0.0])
            }
            (_, Some(grid)) => blurred_grid(grid, self.lobe_sigma, x),
            (_, None) => 0.0,
        }
    }
}

/// A grid's cells against a Gaussian, each a product of two error functions.
fn blurred_grid(grid: &Grid, sigma: f64, x: &Vector2<f64>) -> f64 {
    let along = |edges: &[f64], t: f64| -> (usize, Vec<f64>) {
        let reach = (CUT + 0.5) * sigma;
        let first = edges
            .partition_point(|edge| *edge < t - reach)
            .saturating_sub(1);
        let shares = edges[first..]
            .windows(2)
            .take_while(|edge| edge[0] <= t + reach)
            .map(|edge| {
                let [a, b] = [edge[0], edge[1]]
                    .map(|edge| libm::erf((edge - t) / sigma * std::f64::consts::FRAC_1_SQRT_2));
                0.5 * (b - a)
            })
            .collect();
        (first, shares)
    };
    let (column, first) = along(&grid.columns, x.x);
    let (row, second) = along(&grid.rows, x.y);
    let mut sum = 0.0;
    for (j, share) in second.iter().enumerate() {
        let line: f64 = first
            .iter()
            .enumerate()
            .map(|(i, s)| s * grid.sample(column + i, row + j))
            .sum();
        sum += share * line;
    }
    sum
}

/// One blurred patch.
struct Blurred {
    centre: Vector2<f64>,
    inverse: Matrix2<f64>,
    peak: f64,
}

/// Blurred patches in square bins, so that only those near a place are summed.
struct BlurredPatches {
    bins: Vec<Vec<Blurred>>,
    columns: usize,
    rows: usize,
    low: Vector2<f64>,
    size: f64,
}

impl BlurredPatches {
    fn new(patches: &[GaussianPatch], sigma: f64) -> Self {
        let widest = patches.iter().fold(0.0, |most: f64, patch| {
            most.max(plane::eigenvalues(&patch.covariance)[0])
        });
        let far = Vector2::repeat(f64::INFINITY);
        let low = patches
            .iter()
            .fold(far, |low, patch| low.inf(&patch.centre));
        let high = patches
            .iter()
            .fold(-far, |high, patch| high.sup(&patch.centre));
        let extent = high - low;
        // a bin holds what lies beyond the cut of the next but one; no more bins than 64 × 64
        let size = (CUT * (sigma * sigma + widest).sqrt()).max(extent.x.max(extent.y) / 64.0);
        let place = |t: f64| (t / size) as usize;
        let (columns, rows) = (place(extent.x) + 1, place(extent.y) + 1);
        let mut bins: Vec<Vec<Blurred>> = Vec::new();
        bins.resize_with(columns * rows, Vec::new);
        for patch in patches {
            let sum = patch.covariance + Matrix2::from_diagonal_element(sigma * sigma);
            let offset = patch.centre - low;
            bins[place(offset.y) * columns + place(offset.x)].push(Blurred {
                centre: patch.centre,
                inverse: plane::inverse(&sum),
                peak: patch.weight / (std::f64::consts::TAU * plane::determinant(&sum).sqrt()),
            });
        }
        Self {
            bins,
            columns,
            rows,
            low,
            size,
        }
    }

    fn value(&self, x: &Vector2<f64>) -> f64 {
        let around = |t: f64, count: usize| {
            let bin = (t / self.size).floor();
            let first = (bin - 1.0).clamp(0.0, count as f64) as usize;
            let last = (bin + 2.0).clamp(0.0, count as f64) as usize;
            first..last
        };
        let offset = x - self.low;
        let columns = around(offset.x, self.columns);
        let mut sum = 0.0;
        for row in around(offset.y, self.rows) {
            for column in columns.clone() {
                for patch in &self.bins[row * self.columns + column] {
                    let d = x - patch.centre;
                    let q = d.x * d.x * patch.inverse.m11
                        + 2.0 * d.x * d.y * patch.inverse.m12
                        + d.y * d.y * patch.inverse.m22;
                    if q < CUT * CUT {
                        sum += patch.peak * (-0.5 * q).exp();
                    }
                }
            }
        }
        sum
    }
}
