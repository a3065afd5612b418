//! Heights of a surface, and the autocorrelation of the phase that they give to light.

use nalgebra::{Matrix2, Vector2};

use crate::accuracy::{Approximation, Method, Tolerance};
use crate::autocorrelation::{Autocorrelation, AutocorrelationError};
use crate::geometry::Geometry;
use crate::grating::GratingError;

/// A random or periodic relief of heights h(x), met by light with the vertical wave vector `φ_z`: it multiplies the field
/// by `e^(−iφ_z h)`, and `R(x) = ⟨e^(−iφ_z (h(x') − h(x' − x)))⟩`.
///
/// `R(0) = 1` for every relief. The part of R that does not decay (rate 0) is the mirror, or the sharp orders.
///
/// What is not periodic has only [`Relief::autocorrelation`] and [`Relief::slope_covariance`] to say.
pub trait Relief: Send + Sync {
    /// R for `phi_z`, rad/m, as a sum of Gaussians, and what was chosen for the tolerance.
    ///
    /// # Errors
    ///
    /// When a number of the relief or `phi_z` is outside what the sum can hold.
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError>;

    /// Covariance of the slopes `∂h/∂x`, 2×2, dimensionless; `None` where the relief is not differentiable.
    fn slope_covariance(&self) -> Option<Matrix2<f64>>;

    /// The sharp orders into which a periodic relief sends the light of the geometry's source, on its observer's side,
    /// reciprocal and with no more light together than comes. `None` where R itself says all, with the weights of its terms
    /// that do not decay: for whatever is not periodic.
    ///
    /// # Errors
    ///
    /// When orders are too many or too deep to be listed, or a direction is at grazing incidence.
    fn orders(
        &self,
        _geometry: &Geometry,
        _tolerance: Tolerance,
    ) -> Result<Option<Vec<SharpOrder>>, GratingError> {
        Ok(None)
    }

    /// The factor, the same from both ends and in `0.0..=1.0`, on lobes and haloes of a periodic relief, so that no more
    /// light leaves than comes; 1 for whatever is not periodic.
    ///
    /// # Errors
    ///
    /// As [`Relief::orders`].
    fn energy_cap(&self, _geometry: &Geometry) -> Result<f64, GratingError> {
        Ok(1.0)
    }
}

/// A sharp order of a relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpOrder {
    /// The encounter with the direction in which it leaves.
    pub geometry: Geometry,
    /// Its tangential wave vector, rad/m: qG.
    pub place: Vector2<f64>,
    /// Its share of the power, in `0.0..=1.0`.
    pub weight: f64,
}

/// No relief: a smooth surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flat;

impl Relief for Flat {
    fn autocorrelation(
        &self,
        _phi_z: f64,
        _tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let exact = Approximation {
            method: Method::Exact,
            terms: 1,
            error: 0.0,
        };
        Ok((Autocorrelation::constant(1.0), exact))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        Some(Matrix2::zeros())
    }
}

/// The sum of two independent reliefs, such as roughness on a grating: their autocorrelations are multiplied.
///
/// A grating keeps its sharing of the light among orders under roughness. Of two gratings the orders are those of R, whose
/// weights need not add up to 1: [`crate::Grating::crossed`] shares them.
///
/// Half of the tolerance goes to each. The lobe of the product is that of either relief averaged over the positive one of
/// the other, as under an incoherent source. So a bound that holds for sources of any shape holds for the product
/// beside its own largest value, and the two add up: `e₁ + e₂ + e₁e₂`. Where a bound is for light of at most ten times
/// the lobe's width ([`crate::KCorrelatedHeights`], [`crate::ExponentialHeights`]), so it is for the other relief's lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Superposed<A, B>(pub A, pub B);

impl<A: Relief, B: Relief> Relief for Superposed<A, B> {
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let half = tolerance.half();
        let (first, chosen) = self.0.autocorrelation(phi_z, half)?;
        let (second, also) = self.1.autocorrelation(phi_z, half)?;
        let product = first.times(&second)?;
        let approximation = Approximation {
            method: if chosen.error >= also.error {
                chosen.method
            } else {
                also.method
            },
            terms: product.term_count(),
            error: chosen.error + also.error + chosen.error * also.error,
        };
        Ok((product, approximation))
    }

    fn orders(
        &self,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<Option<Vec<SharpOrder>>, GratingError> {
        let first = self.0.orders(geometry, tolerance)?;
        let second = self.1.orders(geometry, tolerance)?;
        match (first, second) {
            (Some(orders), None) => under(orders, &self.1, tolerance).map(Some),
            (None, Some(orders)) => under(orders, &self.0, tolerance).map(Some),
            (None, None) | (Some(_), Some(_)) => Ok(None),
        }
    }

    fn energy_cap(&self, geometry: &Geometry) -> Result<f64, GratingError> {
        Ok(self.0.energy_cap(geometry)? * self.1.energy_cap(geometry)?)
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        Some(self.0.slope_covariance()? + self.1.slope_covariance()?)
    }
}

/// What roughness leaves sharp of each order: its own mirror part for the order's `φ_z`.
fn under(
    mut orders: Vec<SharpOrder>,
    roughness: &impl Relief,
    tolerance: Tolerance,
) -> Result<Vec<SharpOrder>, GratingError> {
    for order in &mut orders {
        let phi_z = order.geometry.normal_component();
        let (r, _) = roughness.autocorrelation(phi_z, tolerance)?;
        order.weight *= r.delta_weight();
    }
    orders.retain(|order| order.weight > 0.0);
    Ok(orders)
}
