//! Why openings, the light in them, or the place from which they are seen have no answer.

use thiserror::Error;

use crate::geometry::GeometryError;
use crate::incident::IncidentError;

/// Why openings have no answer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OpeningError {
    /// There is none.
    #[error("openings: none, expected at least one")]
    Nothing,
    /// A number of an opening is out of its domain.
    #[error("openings: the {what} of opening {index} is {value}, expected {expected}")]
    Number {
        /// Place in the list, from 0.
        index: usize,
        /// `"width"`, `"height"`, `"centre"` or `"Jones matrix"`.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
    /// Two openings share a piece of the screen.
    #[error(
        "openings: openings {first} and {second} overlap by {width} m × {height} m, expected openings apart or touching"
    )]
    Overlap {
        /// Place of one in the list, from 0.
        first: usize,
        /// Place of the other.
        second: usize,
        /// Of the common piece, m.
        width: f64,
        /// Of the common piece, m.
        height: f64,
    },
    /// The screen is smaller than its openings.
    #[error(
        "openings: the screen has an area of {screen} m², expected at least the {open} m² that are open"
    )]
    Screen {
        /// Of the screen, m².
        screen: f64,
        /// Of all openings, m².
        open: f64,
    },
    /// Source or receiver is too near for one phase over the whole screen.
    #[error(
        "openings: the outermost is {extent} m from the centre, seen over distances of {source_distance} m and {observer} m; \
         spherical waves leave plane ones by {phase} rad there, expected at most {limit}: give each opening its own path"
    )]
    GlobalPhase {
        /// Largest distance of a corner from the centre, m.
        extent: f64,
        /// Distance of the source, m.
        source_distance: f64,
        /// Distance of the receiver, m.
        observer: f64,
        /// `k extent² (n_i/s + n_o/r)/2`.
        phase: f64,
        /// The tolerance.
        limit: f64,
    },
    /// Source or receiver is in the near field of a single opening.
    #[error(
        "openings: opening {index} of {width} m × {height} m is seen over distances of {source_distance} m and {observer} m; \
         spherical waves leave plane ones by {phase} rad at its corner, expected at most {limit}: divide the opening"
    )]
    NearField {
        /// Place in the list, from 0.
        index: usize,
        /// m.
        width: f64,
        /// m.
        height: f64,
        /// Distance of the source, m.
        source_distance: f64,
        /// Distance of the receiver, m.
        observer: f64,
        /// `k (a² + b²) (n_i/s + n_o/r)/8`.
        phase: f64,
        /// The tolerance.
        limit: f64,
    },
    /// A number of the light or of a view is out of its domain.
    #[error("openings: {what} is {value}, expected {expected}")]
    Value {
        /// Which one.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
    /// The light is too incoherent over the openings for a list of plane waves.
    #[error(
        "openings: {needed} plane waves for light that is incoherent over 1/{phase} of the openings, expected at most \
         {limit}: split the source, or ask for less accuracy"
    )]
    Waves {
        /// How many the tolerance needs.
        needed: f64,
        /// Largest phase between two points of the openings over the width of the light, rad.
        phase: f64,
        /// How many there may be.
        limit: usize,
    },
    /// The directions.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The light.
    #[error(transparent)]
    Incident(#[from] IncidentError),
}
