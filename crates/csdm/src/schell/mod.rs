//! Electromagnetic Gaussian Schell-model light: its source, its beam through any ABCD system, its far field.

mod beam;
mod source;

pub use beam::SchellBeam;
pub use source::SchellSource;

use stokes::{FrameError, LightError, ShapeError};
use thiserror::Error;

/// Why numbers are no Schell-model source, or why it cannot be asked for this light.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SchellError {
    /// A length or amplitude is not what it has to be.
    #[error("Schell-model source: {what} is {value}, expected {expected}")]
    Number {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// No field has these correlations.
    #[error(
        "Schell-model source: coherence width δxy = {width} m, expected {least} to {most} m: √((δxx² + δyy²)/2) to \
         √(δxx δyy/|Bxy|)"
    )]
    NotRealizable {
        /// δxy, m.
        width: f64,
        /// Its lower limit, m.
        least: f64,
        /// Its upper limit, m.
        most: f64,
    },
    /// The direction leads away from the source's front.
    #[error(
        "Schell-model source: direction at cosine {cosine} to the source's axis, expected more than 0"
    )]
    Behind {
        /// Cosine between the direction and the axis.
        cosine: f64,
    },
    /// The frame of the ray cannot be made.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The shape of the light cannot be made.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The light cannot be described.
    #[error(transparent)]
    Light(#[from] LightError),
}
