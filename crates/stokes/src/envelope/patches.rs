//! A profile as a sum of positive Gaussians.
//!
//! Each patch has the integral, centroid and covariance of its piece of the profile, so that the sum has those of the
//! whole. Unlike a truncated series it is positive everywhere; a lobe of width σ sees the difference only in fourth
//! order of patch width over σ.

use nalgebra::{Matrix2, Vector2};

use crate::plane;

use super::blur;
use super::grid::Grid;
use super::{Envelope, EnvelopeError, Gaussian, Profile, length, measure};

/// The most patches that a profile is split into.
pub const MAX_PATCHES: usize = 65_536;

/// A Gaussian piece of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianPatch {
    /// Its integral, in the unit of the intensity times m²; positive.
    pub weight: f64,
    /// Its centre, m.
    pub centre: Vector2<f64>,
    /// Its covariance, 2×2, m².
    pub covariance: Matrix2<f64>,
}

/// A profile split into positive Gaussians.
///
/// Their integrals, centroids and covariances add up to those of the profile, to rounding.
///
/// Source: recovering radiometry by Gaussians of matched variance, section S3 of the paper's supplement.
///
/// ```
/// use stokes::Envelope;
/// let slit = Envelope::rectangle(1.0, 1e-3)?;
/// // a lobe of 0.4 half-widths tells one Gaussian from the slit by 15 %, five by less than 0.1 %
/// assert!((slit.patches([1, 1])?.error(0.4)? - 0.15).abs() < 1e-3);
/// assert!(slit.patches([5, 1])?.error(0.4)? < 1e-3);
/// # Ok::<(), stokes::EnvelopeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    envelope: Envelope,
    patches: Vec<GaussianPatch>,
}

impl Envelope {
    /// The profile split into about `across[0]` patches along x and `across[1]` along y.
    ///
    /// Rectangles and grids are cut into equal cells (dark ones left out). A disk is cut into a round patch and k rings
    /// of 6, 12, … sectors of equal area, 2k + 1 across, where 2k + 1 is not below the larger of the two numbers.
    /// Gaussians are patches as they are. A number 0 is read as 1.
    ///
    /// # Errors
    ///
    /// When there would be more than [`MAX_PATCHES`].
    pub fn patches(&self, across: [usize; 2]) -> Result<Patches, EnvelopeError> {
        let across = across.map(|count| count.max(1));
        let needed = self.patch_count(across);
        if needed > MAX_PATCHES as f64 {
            return Err(EnvelopeError::TooManyPatches {
                needed,
                most: MAX_PATCHES,
            });
        }
        let patches = match &self.0 {
            Profile::Gaussians(gaussians) => gaussians.iter().map(Gaussian::patch).collect(),
            Profile::Disk(radius) => sectors(*radius, rings(across)),
            Profile::Rectangle(_) | Profile::Grid(_) => self
                .as_grid()
                .map_or_else(Vec::new, |grid| blocks(&grid, across)),
        };
        Ok(Patches {
            envelope: self.clone(),
            patches,
        })
    }

    /// As few patches as a lobe of standard deviation `lobe_sigma` metres (on the profile's plane) needs to see the
    /// profile with an error below `tolerance` of the peak ([`Patches::error`]).
    ///
    /// Starts from patches half as wide as the lobe, which have an error near 1e-3.
    ///
    /// # Errors
    ///
    /// When a number is not positive, or more than [`MAX_PATCHES`] would be needed.
    pub fn patches_for(&self, lobe_sigma: f64, tolerance: f64) -> Result<Patches, EnvelopeError> {
        length("the standard deviation of the lobe", lobe_sigma)?;
        measure("the tolerance", tolerance)?;
        let half_extent = match &self.0 {
            Profile::Gaussians(_) => return self.patches([1, 1]),
            Profile::Disk(radius) => [*radius; 2],
            Profile::Rectangle(half) => *half,
            Profile::Grid(grid) => grid.half_extent(),
        };
        // the error is of fourth order in the patches' width
        let mut half_width = 0.5 * lobe_sigma * (tolerance / 1e-3).sqrt().sqrt();
        loop {
            let across = half_extent.map(|half| (half / half_width).ceil().max(1.0));
            let needed = self.patch_count(across.map(|count| count.min(1e9) as usize));
            if needed > MAX_PATCHES as f64 {
                let most = MAX_PATCHES;
                return Err(EnvelopeError::LobeTooNarrow {
                    needed,
                    lobe_sigma,
                    tolerance,
                    most,
                });
            }
            let patches = self.patches(across.map(|count| count as usize))?;
            let error = patches.error(lobe_sigma)?;
            if error <= tolerance {
                return Ok(patches);
            }
            let excess = if error.is_finite() {
                error / tolerance
            } else {
                f64::MAX
            };
            let shrink = excess.sqrt().sqrt().clamp(1.1, 2.0);
            half_width = half_extent[0].max(half_extent[1]).min(half_width) / shrink;
        }
    }

    fn patch_count(&self, across: [usize; 2]) -> f64 {
        match &self.0 {
            Profile::Gaussians(gaussians) => gaussians.len() as f64,
            Profile::Disk(_) => {
                let k = rings(across) as f64;
                1.0 + 3.0 * k * (k + 1.0)
            }
            Profile::Rectangle(_) | Profile::Grid(_) => across[0] as f64 * across[1] as f64,
        }
    }
}

impl Patches {
    /// The patches.
    #[must_use]
    pub fn patches(&self) -> &[GaussianPatch] {
        &self.patches
    }

    /// The profile that was split.
    #[must_use]
    pub fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    /// The largest difference, over all places, between the profile and the patches when both are blurred by a round
    /// Gaussian lobe of standard deviation `lobe_sigma` metres; relative to the peak of the blurred profile.
    ///
    /// This is the error of a transfer: the average of a lobe over the profile. The maximum is searched on a grid as fine
    /// as a third of the lobe (a thousandth of the profile at least) and then climbed: found to about 1 %.
    ///
    /// # Errors
    ///
    /// When `lobe_sigma` is not finite and positive.
    pub fn error(&self, lobe_sigma: f64) -> Result<f64, EnvelopeError> {
        length("the standard deviation of the lobe", lobe_sigma)?;
        Ok(blur::largest_difference(
            &self.envelope,
            &self.patches,
            lobe_sigma,
        ))
    }

    /// The L² norm of the difference between the far fields of the patches and of the profile, over that of the
    /// profile's; the same in every direction (Parseval).
    ///
    /// It does not vanish as the patches are refined: cells of matched variance leave ripples of `2 e^(−π²/6)`, 39 %, at
    /// their own period, which only a lobe as wide as a patch smooths out ([`Patches::error`]). Takes a time of the
    /// square of the number of patches; right to 1e-8.
    #[must_use]
    pub fn far_field_error(&self) -> f64 {
        blur::relative_norm(&self.envelope, &self.patches)
    }
}

/// `∫ (Σ patches)² d²x`
pub(crate) fn square_integral(patches: &[GaussianPatch]) -> f64 {
    let product = |a: &GaussianPatch, b: &GaussianPatch| {
        let sum = a.covariance + b.covariance;
        let apart = a.centre - b.centre;
        let determinant = plane::determinant(&sum);
        let exponent = apart.dot(&plane::apply(&plane::adjugate(&sum), &apart)) / determinant;
        a.weight * b.weight * (-0.5 * exponent).exp() / (std::f64::consts::TAU * determinant.sqrt())
    };
    patches
        .iter()
        .flat_map(|a| patches.iter().map(move |b| product(a, b)))
        .sum()
}

/// Number of rings about the middle patch.
fn rings(across: [usize; 2]) -> usize {
    across[0].max(across[1]) / 2
}

/// A piece of an interval: where it is, how long, and which cell it belongs to.
struct Piece {
    cell: usize,
    centre: f64,
    size: f64,
}

/// The pieces into which the edges of cells cut `[low, high]`.
fn pieces(edges: &[f64], low: f64, high: f64) -> Vec<Piece> {
    let first = edges.partition_point(|edge| *edge <= low).saturating_sub(1);
    edges
        .windows(2)
        .enumerate()
        .skip(first)
        .take_while(|(_, edge)| edge[0] < high)
        .filter_map(|(cell, edge)| {
            let (a, b) = (edge[0].max(low), edge[1].min(high));
            (b > a).then_some(Piece {
                cell,
                centre: 0.5 * (a + b),
                size: b - a,
            })
        })
        .collect()
}

fn blocks(grid: &Grid, across: [usize; 2]) -> Vec<GaussianPatch> {
    let cuts = |edges: &[f64], count: usize| -> Vec<Vec<Piece>> {
        let (low, high) = (edges[0], edges[edges.len() - 1]);
        let at = |i: usize| {
            // the last cut is the last edge, to the last bit
            if i == count {
                high
            } else {
                low + (high - low) * (i as f64 / count as f64)
            }
        };
        (0..count)
            .map(|i| pieces(edges, at(i), at(i + 1)))
            .collect()
    };
    let (columns, rows) = (cuts(&grid.columns, across[0]), cuts(&grid.rows, across[1]));
    rows.iter()
        .flat_map(|row| columns.iter().filter_map(|column| block(grid, column, row)))
        .collect()
}

/// The patch of one block of a grid, `None` where it is dark.
fn block(grid: &Grid, columns: &[Piece], rows: &[Piece]) -> Option<GaussianPatch> {
    let cells = || {
        rows.iter().flat_map(|y| {
            columns.iter().map(move |x| {
                let weight = grid.sample(x.cell, y.cell) * x.size * y.size;
                (
                    weight,
                    Vector2::new(x.centre, y.centre),
                    Vector2::new(x.size, y.size),
                )
            })
        })
    };
    let weight: f64 = cells().map(|(weight, ..)| weight).sum();
    if weight <= 0.0 {
        return None;
    }
    let centre = cells()
        .map(|(weight, place, _)| place * weight)
        .sum::<Vector2<f64>>()
        / weight;
    let covariance = cells()
        .map(|(weight, place, size)| {
            let d = place - centre;
            let within = Matrix2::new(size.x * size.x / 12.0, 0.0, 0.0, size.y * size.y / 12.0);
            (d * d.transpose() + within) * weight
        })
        .sum::<Matrix2<f64>>()
        / weight;
    Some(GaussianPatch {
        weight,
        centre,
        covariance,
    })
}

/// A round patch and rings of sectors, all of the same area.
fn sectors(radius: f64, rings: usize) -> Vec<GaussianPatch> {
    let within = |ring: usize| (1 + 3 * ring * (ring + 1)) as f64;
    let total = within(rings);
    let outer = |ring: usize| radius * (within(ring) / total).sqrt();
    let area = std::f64::consts::PI * radius * radius / total;
    let mut patches = vec![GaussianPatch {
        weight: area,
        centre: Vector2::zeros(),
        covariance: Matrix2::from_diagonal_element(0.25 * outer(0) * outer(0)),
    }];
    for ring in 1..=rings {
        let count = 6 * ring;
        let (r1, r2) = (outer(ring - 1), outer(ring));
        // half the sector's angle; moments of an annular sector about the disk's centre
        let alpha = std::f64::consts::PI / count as f64;
        let mean = 2.0 / 3.0 * (r1 * r1 + r1 * r2 + r2 * r2) / (r1 + r2) * alpha.sin() / alpha;
        let square = 0.25 * (r1 * r1 + r2 * r2);
        let skew = (2.0 * alpha).sin() / (2.0 * alpha);
        let (radial, tangential) = (square * (1.0 + skew) - mean * mean, square * (1.0 - skew));
        for i in 0..count {
            let (sin, cos) = ((2 * i + 1) as f64 * alpha).sin_cos();
            let off = (radial - tangential) * sin * cos;
            patches.push(GaussianPatch {
                weight: area,
                centre: Vector2::new(mean * cos, mean * sin),
                covariance: Matrix2::new(
                    radial * cos * cos + tangential * sin * sin,
                    off,
                    off,
                    radial * sin * sin + tangential * cos * cos,
                ),
            });
        }
    }
    patches
}
