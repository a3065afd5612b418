//! Heights of a surface, and the autocorrelation of the phase that they give to light.

use nalgebra::Matrix2;

use crate::accuracy::{Approximation, Method, Tolerance};
use crate::autocorrelation::{Autocorrelation, AutocorrelationError};

/// A random or periodic relief of heights h(x), met by light with the vertical wave vector `φ_z`: it multiplies the field
/// by `e^(−iφ_z h)`, and `R(x) = ⟨e^(−iφ_z (h(x') − h(x' − x)))⟩`.
///
/// `R(0) = 1` for every relief. The part of R that does not decay (rate 0) is the mirror, or the sharp orders.
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

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        Some(self.0.slope_covariance()? + self.1.slope_covariance()?)
    }
}
