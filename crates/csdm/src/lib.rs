//! Fields: Jones matrices, Fresnel amplitudes, and the way from them to Mueller matrices.
//!
//! Fields are complex amplitudes in `exp(+iωt)`, indices are `n = η − ik`; frames and the sign of S3 are those of
//! the page of [`stokes`]. Jones matrices act on `(E_x, E_y)` in the frame of the ray, and `x` is s at an interface.
#![forbid(unsafe_code)]

mod abcd;
pub mod birefringent;
mod coherence;
mod csdm;
mod decompose;
mod elements;
mod ensemble;
pub mod film;
pub mod fresnel;
mod jones;
mod jones_polar;
mod layered;
mod positivity;
mod scale;
mod schell;
mod sixteen;

pub use abcd::{AstigmaticTransfer, RayTransfer, RayTransferError};
pub use csdm::CrossSpectralDensity;
pub use decompose::{
    CloudeSpectrum, NoPolarDecomposition, NotRealizable, PolarDecomposition, WeightedJones,
    coherency_matrix,
};
pub use elements::ElementError;
pub use ensemble::{
    BadWeights, CorrelationLengths, Element, GaussianAperture, LightEstimate, Mixture, MonteCarlo,
    PatternError, PhaseScreen, RandomStream, RoughRetarder, ScreenError, Sequence, SixteenEstimate,
    TooFewSamples, Turned, Varying, VoltageResponse, liquid_crystal_modulator,
    polarization_grating,
};
pub use jones::{JonesMatrix, stokes_vector};
pub use jones_polar::JonesPolar;
pub use positivity::CoherenceError;
pub use schell::{SchellBeam, SchellError, SchellSource};
pub use sixteen::{GeneralizedMueller, NotReal, TransferTensor};
