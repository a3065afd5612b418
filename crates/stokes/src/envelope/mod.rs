//! Intensity profiles of incoherent sources and of scatterers' footprints: their transforms, far-field modes and
//! patches.
//!
//! By the theorem of Van Cittert and Zernike a source of intensity `I(x)` shows the far field
//! `f(w) = ∫ I(x) e^{−i(Pw)·x} d²x`, with `P` as [`surface_projection`] makes it. Its expansion in Hermite-Gauss modes
//! is [`EnvelopeModes`]; its split into positive Gaussians, for lobes that a truncated series would see through, is
//! [`Patches`].

mod blur;
mod disk;
mod error;
mod gaussian;
mod grid;
mod modes;
mod patches;
mod quadrature;
mod staircase;

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;

use crate::frame::Frame;
use crate::hermite::MAX_ORDER;
use crate::plane;
use crate::series::HermiteSeries;
use crate::shape::{ShapeError, ShapeMatrix};

pub use error::EnvelopeError;
pub use gaussian::GaussianPeak;
pub use modes::{EnvelopeModes, ModeWidth};
pub use patches::{GaussianPatch, MAX_PATCHES, Patches};

use gaussian::Gaussian;
use grid::Grid;

/// Intensity profile over a plane, never negative: of an incoherent source, or the footprint `I` of locally
/// stationary matter.
///
/// Coordinates are metres in the plane's own axes. Modes, shapes and far fields are those of the profile *about its
/// centroid*: the phase centre of the light is [`Envelope::centroid`].
///
/// ```
/// use stokes::Envelope;
/// let lamp = Envelope::disk(2e-3)?;
/// // the variance of a uniform disk is R²/4 along each axis
/// assert!((lamp.covariance().m11 - 1e-6).abs() < 1e-21);
/// assert!((lamp.area() - 1.256_637_061_435_917e-5).abs() < 1e-20);
/// # Ok::<(), stokes::EnvelopeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope(Profile);

#[derive(Clone, Debug, PartialEq)]
enum Profile {
    Gaussians(Vec<Gaussian>),
    /// Half-widths.
    Rectangle([f64; 2]),
    /// Radius.
    Disk(f64),
    Grid(Grid),
}

impl Envelope {
    /// The Gaussian `e^(−xᵀ covariance⁻¹ x/2)`; covariance 2×2, m².
    ///
    /// # Errors
    ///
    /// When the covariance is not finite, not symmetric or not positive definite.
    pub fn gaussian(covariance: &Matrix2<f64>) -> Result<Self, EnvelopeError> {
        Self::mixture(&[GaussianPeak {
            peak: 1.0,
            centre: Vector2::zeros(),
            covariance: *covariance,
        }])
    }

    /// The sum of Gaussians, each with its peak, centre and covariance.
    ///
    /// # Errors
    ///
    /// When there is none, a peak is not positive, a centre not finite, or a covariance not positive definite.
    pub fn mixture(peaks: &[GaussianPeak]) -> Result<Self, EnvelopeError> {
        if peaks.is_empty() {
            return Err(EnvelopeError::Dark);
        }
        let gaussians: Result<Vec<_>, _> = peaks
            .iter()
            .enumerate()
            .map(|(index, peak)| Gaussian::new(index, peak))
            .collect();
        Ok(Self(Profile::Gaussians(gaussians?)))
    }

    /// The rectangle `|x| ≤ half_x, |y| ≤ half_y` of intensity 1, lengths in metres.
    ///
    /// # Errors
    ///
    /// When a half-width is not positive and finite.
    pub fn rectangle(half_x: f64, half_y: f64) -> Result<Self, EnvelopeError> {
        length("the half-width along x", half_x)?;
        length("the half-width along y", half_y)?;
        Ok(Self(Profile::Rectangle([half_x, half_y])))
    }

    /// The disk of this radius in metres, of intensity 1.
    ///
    /// # Errors
    ///
    /// When the radius is not positive and finite.
    pub fn disk(radius: f64) -> Result<Self, EnvelopeError> {
        length("the radius", radius)?;
        Ok(Self(Profile::Disk(radius)))
    }

    /// Samples on a regular grid of `columns` cells along x, each cell of constant intensity.
    ///
    /// `samples` runs along x first, then along y, both ascending; `pixel` is the size of a cell in metres, `centre`
    /// the place of the grid's middle.
    ///
    /// # Errors
    ///
    /// When the samples do not fill whole rows, one is negative or not finite, or all are 0; when a size is not
    /// positive or the centre not finite.
    pub fn sampled(
        samples: Vec<f64>,
        columns: usize,
        pixel: [f64; 2],
        centre: Vector2<f64>,
    ) -> Result<Self, EnvelopeError> {
        let rows = samples.len().checked_div(columns).unwrap_or(0);
        if samples.is_empty() || rows * columns != samples.len() {
            let found = samples.len();
            return Err(EnvelopeError::SampleCount {
                found,
                columns,
                rows,
            });
        }
        for (place, value) in samples.iter().copied().enumerate() {
            if !(0.0..=1e100).contains(&value) {
                let (column, row) = (place % columns, place / columns);
                return Err(EnvelopeError::Sample { column, row, value });
            }
        }
        if samples.iter().all(|sample| *sample == 0.0) {
            return Err(EnvelopeError::Dark);
        }
        length("the size of a cell along x", pixel[0])?;
        length("the size of a cell along y", pixel[1])?;
        position("the x of the grid's centre", centre.x)?;
        position("the y of the grid's centre", centre.y)?;
        let edges = |count: usize, size: f64, middle: f64| -> Vec<f64> {
            (0..=count)
                .map(|i| middle + (i as f64 - 0.5 * count as f64) * size)
                .collect()
        };
        Ok(Self(Profile::Grid(Grid {
            columns: edges(columns, pixel[0], centre.x),
            rows: edges(rows, pixel[1], centre.y),
            samples,
        })))
    }

    /// The integral of the intensity, `f(0)`, in the intensity's unit times m².
    #[must_use]
    pub fn area(&self) -> f64 {
        match &self.0 {
            Profile::Gaussians(gaussians) => gaussians.iter().map(Gaussian::mass).sum(),
            Profile::Rectangle([hx, hy]) => 4.0 * hx * hy,
            Profile::Disk(radius) => std::f64::consts::PI * radius * radius,
            Profile::Grid(grid) => grid.mass(),
        }
    }

    /// The mean position, m.
    #[must_use]
    pub fn centroid(&self) -> Vector2<f64> {
        match &self.0 {
            Profile::Gaussians(gaussians) => {
                let sum: Vector2<f64> = gaussians.iter().map(|g| g.centre * g.mass()).sum();
                sum / self.area()
            }
            Profile::Rectangle(_) | Profile::Disk(_) => Vector2::zeros(),
            Profile::Grid(grid) => grid.centroid(),
        }
    }

    /// The covariance of the position about the centroid, 2×2, m².
    #[must_use]
    pub fn covariance(&self) -> Matrix2<f64> {
        match &self.0 {
            Profile::Gaussians(gaussians) => {
                let origin = self.centroid();
                let sum: Matrix2<f64> = gaussians
                    .iter()
                    .map(|g| {
                        let d = g.centre - origin;
                        (g.covariance + d * d.transpose()) * g.mass()
                    })
                    .sum();
                sum / self.area()
            }
            Profile::Rectangle([hx, hy]) => Matrix2::new(hx * hx / 3.0, 0.0, 0.0, hy * hy / 3.0),
            Profile::Disk(radius) => Matrix2::from_diagonal_element(0.25 * radius * radius),
            Profile::Grid(grid) => grid.covariance(),
        }
    }

    /// The intensity at a place in metres.
    #[must_use]
    pub fn value(&self, x: &Vector2<f64>) -> f64 {
        let inside = |is: bool| if is { 1.0 } else { 0.0 };
        match &self.0 {
            Profile::Gaussians(gaussians) => gaussians.iter().map(|g| g.value(x)).sum(),
            Profile::Rectangle([hx, hy]) => inside(x.x.abs() <= *hx && x.y.abs() <= *hy),
            Profile::Disk(radius) => inside(x.norm() <= *radius),
            Profile::Grid(grid) => grid.value(x),
        }
    }

    /// The Fourier transform `∫ I(x) e^(−i u·x) d²x` about the origin of the coordinates; `u` in rad/m.
    ///
    /// In closed form for every profile; error of a few `ε` times the area (and `ε |u·x|` of the phases).
    #[must_use]
    pub fn fourier(&self, u: &Vector2<f64>) -> Complex64 {
        match &self.0 {
            Profile::Gaussians(gaussians) => gaussians.iter().map(|g| g.fourier(u)).sum(),
            Profile::Rectangle(_) => self
                .as_grid()
                .map_or(Complex64::ZERO, |grid| grid.fourier(u)),
            Profile::Disk(radius) => disk::fourier(*radius, u),
            Profile::Grid(grid) => grid.fourier(u),
        }
    }

    /// The far field `f(w) = ∫ I(x) e^(−i (Pw)·(x − centroid)) d²x`; `w` in rad/m.
    ///
    /// Source: Eq. (S2.9) for locally stationary matter, Lemma 4.3.
    #[must_use]
    pub fn far_field(&self, projection: &Matrix2<f64>, w: &Vector2<f64>) -> Complex64 {
        let u = plane::apply(projection, w);
        self.fourier(&u) * Complex64::cis(u.dot(&self.centroid()))
    }

    /// The shape matrix of the far field, `Θ⁻¹ = Pᵀ Cov P` with root `W = Cov^(1/2) P`, the symmetric root.
    ///
    /// Source: Lemma 4.4.
    ///
    /// # Errors
    ///
    /// When `projection` is not finite or singular: the plane is seen edge-on.
    pub fn shape(&self, projection: &Matrix2<f64>) -> Result<ShapeMatrix, ShapeError> {
        let root = plane::symmetric_root(&self.covariance());
        ShapeMatrix::from_root(&root)?.in_coordinates(projection)
    }

    /// `∫ I² d²x`
    pub(crate) fn square_integral(&self) -> f64 {
        match &self.0 {
            Profile::Gaussians(gaussians) => {
                let patches: Vec<_> = gaussians.iter().map(Gaussian::patch).collect();
                patches::square_integral(&patches)
            }
            Profile::Rectangle(_) | Profile::Disk(_) => self.area(),
            Profile::Grid(grid) => grid.square_integral(),
        }
    }

    /// A piecewise constant profile as a grid.
    fn as_grid(&self) -> Option<Grid> {
        match &self.0 {
            Profile::Rectangle([hx, hy]) => Some(Grid {
                columns: vec![-hx, *hx],
                rows: vec![-hy, *hy],
                samples: vec![1.0],
            }),
            Profile::Grid(grid) => Some(grid.clone()),
            Profile::Gaussians(_) | Profile::Disk(_) => None,
        }
    }

    /// `∫ I(x) h_a(y₁) h_b(y₂) d²x` for a + b ≤ `order`, with `y = T (x − origin)`.
    fn moments(
        &self,
        t: &Matrix2<f64>,
        origin: &Vector2<f64>,
        order: usize,
    ) -> Result<HermiteSeries, EnvelopeError> {
        let mut moments = vec![0.0; crate::basis::mode_count(order)];
        let turn = match &self.0 {
            Profile::Gaussians(gaussians) => {
                for gaussian in gaussians {
                    gaussian.add_moments(t, origin, order, &mut moments);
                }
                Matrix2::identity()
            }
            Profile::Disk(radius) => disk::moments(*radius, t, origin, order, &mut moments),
            Profile::Grid(grid) => grid.moments(t, origin, order, &mut moments),
            Profile::Rectangle(_) => self.as_grid().map_or_else(Matrix2::identity, |grid| {
                grid.moments(t, origin, order, &mut moments)
            }),
        };
        let straight = HermiteSeries::from_real_coefficients(&moments)?;
        if turn == Matrix2::identity() {
            Ok(straight)
        } else {
            Ok(straight.with_root_turned_by(&turn))
        }
    }
}

/// How the plane of a profile is seen along a ray: `P = Tᵀ E`, with the plane's unit axes `tangents` as columns of T
/// and the frame's transverse axes as columns of E; 2×2, dimensionless.
///
/// `P` leads from the far-field argument `w = (k/r) ξ` to the wave vector in the plane. A plane that faces the ray and
/// has the frame's axes has `P = 1`.
///
/// Source: `Q` of Theorem S4.1, restricted to the two planes.
#[must_use]
pub fn surface_projection(tangents: &[Vector3<f64>; 2], frame: &Frame) -> Matrix2<f64> {
    let [t1, t2] = tangents;
    let (e1, e2) = (frame.x(), frame.y());
    Matrix2::new(t1.dot(&e1), t1.dot(&e2), t2.dot(&e1), t2.dot(&e2))
}

fn length(what: &'static str, value: f64) -> Result<(), EnvelopeError> {
    if (1e-70..=1e70).contains(&value) {
        Ok(())
    } else {
        Err(EnvelopeError::Length { what, value })
    }
}

fn position(what: &'static str, value: f64) -> Result<(), EnvelopeError> {
    if value.abs() <= 1e70 {
        Ok(())
    } else {
        Err(EnvelopeError::Position { what, value })
    }
}

fn measure(what: &'static str, value: f64) -> Result<(), EnvelopeError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(EnvelopeError::NotAMeasure { what, value })
    }
}

fn checked(order: usize) -> Result<usize, EnvelopeError> {
    if order <= MAX_ORDER {
        Ok(order)
    } else {
        Err(EnvelopeError::Order { order })
    }
}
