//! What can be wrong with a profile, its modes or its patches.

use thiserror::Error;

use crate::beam::LightError;
use crate::series::SeriesError;
use crate::shape::ShapeError;

/// Why numbers are no intensity profile, or a profile has no such modes or patches.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EnvelopeError {
    /// A length is not positive, or outside what the arithmetic can square.
    #[error("envelope: {what} is {value}, expected a length from 1e-70 to 1e70")]
    Length {
        /// Which length.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// A coordinate is infinite or not a number.
    #[error("envelope: {what} is {value}, expected a finite number up to 1e70 in modulus")]
    Position {
        /// Which coordinate.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// The peak of one Gaussian of a mixture is not positive.
    #[error(
        "envelope: Gaussian {index} of the mixture has peak {value}, expected a positive number up to 1e100"
    )]
    Peak {
        /// Its place in the mixture, from 0.
        index: usize,
        /// What was found.
        value: f64,
    },
    /// A sample is negative or not finite.
    #[error(
        "envelope: sample ({column}, {row}) is {value}, expected 0 to 1e100: an intensity is not negative"
    )]
    Sample {
        /// Its place along x, from 0.
        column: usize,
        /// Its place along y, from 0.
        row: usize,
        /// What was found.
        value: f64,
    },
    /// The samples do not fill the grid.
    #[error("envelope: found {found} samples, expected {columns} × {rows}, at least one")]
    SampleCount {
        /// How many there are.
        found: usize,
        /// Places along x.
        columns: usize,
        /// Places along y.
        rows: usize,
    },
    /// There is no light: no Gaussian, or no sample above 0.
    #[error("envelope: the profile is dark everywhere, expected a positive intensity somewhere")]
    Dark,
    /// An order beyond what the functions are made for.
    #[error("envelope: order {order}, expected at most 256")]
    Order {
        /// The order.
        order: usize,
    },
    /// A width in standard deviations that is not positive.
    #[error(
        "envelope: half-width of {value} standard deviations, expected 0.01 to 100 (√3 matches a rectangle's variance)"
    )]
    Sigmas {
        /// What was found.
        value: f64,
    },
    /// A profile without a hard edge has no half-width.
    #[error(
        "envelope: the profile has no half-width to count in standard deviations; match its variance instead"
    )]
    NoEdge,
    /// A truncated series that cannot be rescaled.
    #[error(
        "envelope: the modes up to order {order} add up to {sum} at zero separation where the profile has {area}; \
         choose another order"
    )]
    NotPositive {
        /// The order.
        order: usize,
        /// The sum.
        sum: f64,
        /// What it should be.
        area: f64,
    },
    /// A lobe width or a tolerance that is not positive.
    #[error("envelope: {what} is {value}, expected a finite positive number")]
    NotAMeasure {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// The patches would be too many.
    #[error("envelope: {needed} patches, expected at most {most}")]
    TooManyPatches {
        /// How many there would be.
        needed: f64,
        /// The most that are made.
        most: usize,
    },
    /// The lobe is so narrow that the patches would be too many.
    #[error(
        "envelope: {needed} patches for a lobe of standard deviation {lobe_sigma} m and a tolerance of {tolerance}, \
         expected at most {most}; a lobe this narrow resolves the source: sample its points instead"
    )]
    LobeTooNarrow {
        /// How many there would be.
        needed: f64,
        /// The standard deviation of the lobe, m.
        lobe_sigma: f64,
        /// The tolerance, relative to the peak.
        tolerance: f64,
        /// The most that are made.
        most: usize,
    },
    /// The shape matrix is none.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The coefficients are no series.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// The light is none.
    #[error(transparent)]
    Light(#[from] LightError),
}
