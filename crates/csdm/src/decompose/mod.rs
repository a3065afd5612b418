//! What kind of element a Mueller matrix is: which Jones matrices make it up, and which diattenuator, retarder and
//! depolarizer.

mod cloude;
mod lu_chipman;
mod svd3;

pub use cloude::{CloudeSpectrum, NotRealizable, WeightedJones};
pub use lu_chipman::{NoPolarDecomposition, PolarDecomposition};
