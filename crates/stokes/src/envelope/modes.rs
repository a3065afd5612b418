//! Far-field modes of a profile.
//!
//! In the basis of root `W` the far field `f(w) = F{I}(Pw)` has the coefficients
//!
//! ```text
//! μ_ab = 2π (−i)^(a+b) |det W|^(−1/2) ∫ I(x) h_a(y₁) h_b(y₂) d²x,      y = W^(−T) Pᵀ x
//! ```
//!
//! For `W = D P` the argument is `y = D^(−T) x` in every direction, so that `μ |det W|^(1/2)` belongs to the profile
//! alone and a direction only changes W.

use nalgebra::{Matrix2, Vector2};

use crate::basis::{mode_count, mode_index};
use crate::beam::GeneralizedStokes;
use crate::components::Components;
use crate::frame::Frame;
use crate::plane;
use crate::series::{self, HermiteSeries};
use crate::shape::{self, ShapeError, ShapeMatrix};
use crate::units::Wavelength;
use crate::vector::StokesVector;

use super::{Envelope, EnvelopeError, Profile, checked, position};

/// How wide a profile's modes are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeWidth {
    /// `DᵀD` is the profile's covariance and D symmetric (Lemma 4.4): right for order 0 and low orders.
    VarianceMatched,
    /// The half-width of a rectangle, or the radius of a disk, is this many standard deviations of the Gaussian.
    /// √3 and 2 match the variance; up to `√(2N)` converges better at high order N.
    Sigmas(f64),
}

/// Far-field modes of a profile, for every direction at once.
///
/// ```
/// use nalgebra::Matrix2;
/// use stokes::{Envelope, ModeWidth};
/// let box_modes = Envelope::rectangle(1e-3, 1e-3)?.modes(ModeWidth::VarianceMatched, 0)?;
/// // a box in one dimension has 0.374, hence 0.510² = 1 − (1 − 0.374²)²
/// assert!((box_modes.relative_error() - 0.510).abs() < 1e-3);
/// // seen under 60°, the box is half as wide
/// let (shape, _) = box_modes.in_direction(&Matrix2::new(1.0, 0.0, 0.0, 0.5))?;
/// assert!((shape.covariance().m22 / shape.covariance().m11 - 0.25).abs() < 1e-15);
/// # Ok::<(), stokes::EnvelopeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnvelopeModes {
    root: Matrix2<f64>,
    series: HermiteSeries,
    area: f64,
    relative_error: f64,
}

impl Envelope {
    /// The far-field modes up to total order `order`, of the profile about its centroid.
    ///
    /// Error of a few `order·ε` of the largest coefficient.
    ///
    /// # Errors
    ///
    /// When `order` exceeds [`crate::MAX_ORDER`]; for [`ModeWidth::Sigmas`] when the number is not between 0.01 and
    /// 100 or the profile has no hard edge.
    pub fn modes(&self, width: ModeWidth, order: usize) -> Result<EnvelopeModes, EnvelopeError> {
        checked(order)?;
        let root = self.mode_root(width)?;
        let (series, relative_error) = if self.is_gaussian() {
            let mut real = vec![0.0; mode_count(order)];
            real[0] = self.area() * std::f64::consts::PI.sqrt();
            (HermiteSeries::from_real_coefficients(&real)?, 0.0)
        } else {
            let inverse = plane::inverse(&root);
            let series =
                far_field_signs(&self.moments(&inverse.transpose(), &self.centroid(), order)?)?;
            let error = self.relative_error(&root, &series)?;
            (series, error)
        };
        Ok(EnvelopeModes {
            root,
            series,
            area: self.area(),
            relative_error,
        })
    }

    /// The modes of the far field `F{I}(Pw)` over any `shape`, up to total order `order`.
    ///
    /// Error of a few `order·ε` of the largest coefficient, for the given `projection` and root, whatever their
    /// condition numbers.
    ///
    /// # Errors
    ///
    /// When `order` exceeds [`crate::MAX_ORDER`] or `projection` is not finite.
    pub fn project(
        &self,
        projection: &Matrix2<f64>,
        shape: &ShapeMatrix,
        order: usize,
    ) -> Result<HermiteSeries, EnvelopeError> {
        checked(order)?;
        shape::finite(projection, "projection")?;
        if self.shape(projection).is_ok_and(|native| native == *shape) {
            // W = DP is rounded, D^(−T) is not: a thin P would cost the digits of its condition number
            let modes = self.modes(ModeWidth::VarianceMatched, order)?;
            return Ok(modes.in_direction(projection)?.1);
        }
        self.project_about(&self.centroid(), projection, shape, order)
    }

    /// As [`Envelope::project`] with another phase centre: the modes of `∫ I(x) e^(−i (Pw)·(x − origin)) d²x`, origin in
    /// metres. Profiles that share a shape share their phase centre too.
    ///
    /// # Errors
    ///
    /// As [`Envelope::project`]; when a coordinate of the origin is not finite.
    pub fn project_about(
        &self,
        origin: &Vector2<f64>,
        projection: &Matrix2<f64>,
        shape: &ShapeMatrix,
        order: usize,
    ) -> Result<HermiteSeries, EnvelopeError> {
        checked(order)?;
        shape::finite(projection, "projection")?;
        position("the x of the origin", origin.x)?;
        position("the y of the origin", origin.y)?;
        let root = shape.root();
        let t = plane::product(projection, &plane::adjugate(root)) / plane::determinant(root);
        let native = far_field_signs(&self.moments(&t.transpose(), origin, order)?)?;
        Ok(native.scaled(1.0 / shape.root_determinant().sqrt()))
    }

    fn is_gaussian(&self) -> bool {
        matches!(&self.0, Profile::Gaussians(gaussians) if gaussians.len() == 1)
    }

    fn mode_root(&self, width: ModeWidth) -> Result<Matrix2<f64>, EnvelopeError> {
        let ModeWidth::Sigmas(value) = width else {
            return Ok(plane::symmetric_root(&self.covariance()));
        };
        if !(0.01..=100.0).contains(&value) {
            return Err(EnvelopeError::Sigmas { value });
        }
        match self.0 {
            Profile::Rectangle([hx, hy]) => Ok(Matrix2::new(hx / value, 0.0, 0.0, hy / value)),
            Profile::Disk(radius) => Ok(Matrix2::from_diagonal_element(radius / value)),
            Profile::Gaussians(_) | Profile::Grid(_) => Err(EnvelopeError::NoEdge),
        }
    }

    /// The L² norm of what `series` leaves out, over that of the far field (Parseval).
    fn relative_error(
        &self,
        root: &Matrix2<f64>,
        series: &HermiteSeries,
    ) -> Result<f64, EnvelopeError> {
        const TAIL: usize = 32;
        let whole = std::f64::consts::TAU
            * (self.square_integral() * plane::determinant(root).abs()).sqrt();
        let kept = series.norm();
        let lost = (whole - kept) * (whole + kept);
        if lost > 1e-8 * whole * whole {
            return Ok(lost.sqrt() / whole);
        }
        let Profile::Gaussians(gaussians) = &self.0 else {
            // a step never converges that far: what is left is rounding
            return Ok(lost.max(0.0).sqrt() / whole);
        };
        // the difference has no digits left: add up the next orders instead
        let order = series.order() + TAIL;
        let mut moments = vec![0.0; mode_count(order)];
        let t = plane::inverse(root).transpose();
        for gaussian in gaussians {
            gaussian.add_moments(&t, &self.centroid(), order, &mut moments);
        }
        let rest = &moments[mode_index(series.order() + 1, 0)..];
        Ok(std::f64::consts::TAU * series::norm(rest) / whole)
    }
}

/// `2π (−1)^(a+b)` times the moments: the real coefficients `(−i)^(a+b) μ_ab |det W|^(1/2)`.
fn far_field_signs(moments: &HermiteSeries) -> Result<HermiteSeries, EnvelopeError> {
    let mut real = moments.real_coefficients().to_vec();
    for n in 0..=moments.order() {
        let factor = if n % 2 == 0 {
            std::f64::consts::TAU
        } else {
            -std::f64::consts::TAU
        };
        for s in &mut real[mode_index(n, 0)..mode_count(n)] {
            *s *= factor;
        }
    }
    Ok(HermiteSeries::from_real_coefficients(&real)?)
}

impl EnvelopeModes {
    /// The root D over the profile's plane, 2×2, m: the shape's root is `W = D P`.
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        &self.root
    }

    /// The real numbers `(−i)^(a+b) μ_ab |det W|^(1/2)`, the same in every direction; unit of the profile times m².
    #[must_use]
    pub fn series(&self) -> &HermiteSeries {
        &self.series
    }

    /// The integral of the profile, which the far field has at zero separation.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The L² norm of what the truncated series leaves out of the far field, over that of the whole, in `0.0..=1.0`.
    ///
    /// Independent of the direction. Errors below 1e-4 of Gaussian mixtures are the sum of the next 32 orders; those
    /// of [`EnvelopeModes::rescaled`] modes are the error before rescaling.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.relative_error
    }

    /// The sum of the truncated series at zero separation, which converges to [`EnvelopeModes::area`].
    #[must_use]
    pub fn sum_at_zero(&self) -> f64 {
        self.series.sum_at_zero()
    }

    /// The shape matrix and the coefficients `μ_ab` for a direction with this projection `P`.
    ///
    /// # Errors
    ///
    /// When `projection` is not finite or singular: the plane is seen edge-on.
    pub fn in_direction(
        &self,
        projection: &Matrix2<f64>,
    ) -> Result<(ShapeMatrix, HermiteSeries), ShapeError> {
        let shape = ShapeMatrix::from_root(&self.root)?.in_coordinates(projection)?;
        let modes = self.series.scaled(1.0 / shape.root_determinant().sqrt());
        Ok((shape, modes))
    }

    /// The modes times the factor that makes the truncated series exact at zero separation, and that factor.
    ///
    /// Energy is then right at every order, at the price of an error elsewhere.
    ///
    /// # Errors
    ///
    /// When the truncated series is not positive there, which was never seen: the partial sums over total orders of a
    /// profile that is not negative stay above 0.
    pub fn rescaled(&self) -> Result<(Self, f64), EnvelopeError> {
        let (sum, area) = (self.sum_at_zero(), self.area);
        if sum.is_nan() || sum <= 0.0 {
            let order = self.series.order();
            return Err(EnvelopeError::NotPositive { order, sum, area });
        }
        let factor = area / sum;
        let series = self.series.scaled(factor);
        Ok((
            Self {
                series,
                ..self.clone()
            },
            factor,
        ))
    }

    /// The light of a source with this profile, unpolarized or not, at `distance` metres in the direction of `frame`.
    ///
    /// `stokes` is the radiant intensity per area of the source, W/(m² sr), written in `frame`; with `P` from
    /// [`super::surface_projection`] the light's parameters at zero separation are `area · S_j/r²`, times
    /// [`EnvelopeModes::sum_at_zero`]` / area` for the truncation. No cosine is applied.
    ///
    /// # Errors
    ///
    /// When the plane is seen edge-on, an amplitude is not finite, or the distance is not in the far field.
    pub fn light(
        &self,
        stokes: StokesVector,
        projection: &Matrix2<f64>,
        frame: Frame,
        wavelength: Wavelength,
        distance: f64,
    ) -> Result<GeneralizedStokes, EnvelopeError> {
        let (shape, modes) = self.in_direction(projection)?;
        let components = Components::Shared { modes, stokes };
        Ok(GeneralizedStokes::new(
            components, shape, frame, wavelength, distance,
        )?)
    }
}
