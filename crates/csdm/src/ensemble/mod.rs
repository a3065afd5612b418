//! Elements that act on coherence: one mechanism for deterministic, varying and random ones.

mod mixture;
mod monte_carlo;
mod rough_retarder;
mod screen;
mod varying;

use nalgebra::Vector2;
use stokes::Mueller;

use crate::csdm::CrossSpectralDensity;
use crate::jones::JonesMatrix;
use crate::sixteen::{GeneralizedMueller, TransferTensor};

pub use mixture::{BadWeights, Mixture, Sequence, Turned};
pub use monte_carlo::{LightEstimate, MonteCarlo, RandomStream, SixteenEstimate, TooFewSamples};
pub use rough_retarder::RoughRetarder;
pub use screen::{CorrelationLengths, PhaseScreen, ScreenError};
pub use varying::{
    GaussianAperture, PatternError, Varying, VoltageResponse, liquid_crystal_modulator,
    polarization_grating,
};

/// Matter whose Jones matrix is known at every point, at least in the mean.
///
/// An element is known by the second moments of its Jones matrix at two points, a [`TransferTensor`]; what it makes of a
/// cross-spectral density and its sixteen numbers follow:
///
/// ```text
/// C'(r₁, r₂) = ⟨T(r₁) C(r₁, r₂) T(r₂)†⟩                                                           (S4.12)
/// ```
///
/// Points are transverse, in metres, in the axes of the frame of the light. Elements are thin: the light behind one is
/// that before it, point by point.
///
/// ```
/// use csdm::{CrossSpectralDensity, Element, PhaseScreen};
/// use nalgebra::Vector2;
/// use stokes::StokesVector;
/// // independent phases of 1 rad on the two axes: diagonal light keeps e^{−1} of its polarization
/// let screen = PhaseScreen::independent([1.0, 1.0], [1e-4, 1e-4])?;
/// let light = CrossSpectralDensity::from_stokes(StokesVector::DIAGONAL)?;
/// let here = Vector2::zeros();
/// let degree = screen.act_on(&light, &here, &here).degree_of_polarization()?;
/// assert!((degree - (-1f64).exp()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Element {
    /// The moments `⟨T_ap(r₁) T*_bq(r₂)⟩` at the points `first` and `second`, metres.
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor;

    /// The sixteen numbers `M_lj(r₁, r₂)`.
    fn generalized_mueller(
        &self,
        first: &Vector2<f64>,
        second: &Vector2<f64>,
    ) -> GeneralizedMueller {
        self.transfer(first, second).generalized_mueller()
    }

    /// The Mueller matrix at one point, where the sixteen are real.
    fn mueller_at(&self, point: &Vector2<f64>) -> Mueller {
        self.generalized_mueller(point, point).real_part()
    }

    /// What the element makes of `light`, the cross-spectral density of the points `first` and `second`.
    ///
    /// Source: Eq. (S4.12).
    fn act_on(
        &self,
        light: &CrossSpectralDensity,
        first: &Vector2<f64>,
        second: &Vector2<f64>,
    ) -> CrossSpectralDensity {
        self.transfer(first, second).apply(light)
    }
}

/// A uniform plate.
impl Element for JonesMatrix {
    fn transfer(&self, _first: &Vector2<f64>, _second: &Vector2<f64>) -> TransferTensor {
        TransferTensor::of_jones(self, self)
    }
}

impl<T: Element + ?Sized> Element for Box<T> {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        (**self).transfer(first, second)
    }
}

impl<T: Element + ?Sized> Element for &T {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        (**self).transfer(first, second)
    }
}
