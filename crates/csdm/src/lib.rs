//! Fields: Jones matrices, Fresnel amplitudes, and the way from them to Mueller matrices.
//!
//! Fields are complex amplitudes in `exp(+iωt)`, indices are `n = η − ik`; frames and the sign of S3 are those of
//! the page of [`stokes`]. Jones matrices act on `(E_x, E_y)` in the frame of the ray, and `x` is s at an interface.
#![forbid(unsafe_code)]

mod abcd;
pub mod fresnel;
mod jones;
mod schell;

pub use abcd::{AstigmaticTransfer, RayTransfer, RayTransferError};
pub use jones::{JonesMatrix, stokes_vector};
pub use schell::{SchellBeam, SchellError, SchellSource};
