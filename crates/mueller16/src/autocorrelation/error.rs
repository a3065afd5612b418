//! Why numbers are no autocorrelation.

use std::ops::RangeInclusive;

use thiserror::Error;

/// Why numbers are no autocorrelation.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AutocorrelationError {
    /// The covariance has no root.
    #[error(transparent)]
    Shape(#[from] stokes::ShapeError),
    /// A width is outside what the arithmetic can square.
    #[error("autocorrelation: a correlation length is {value:?} m, expected 1e-30 to 1e30 m")]
    Length {
        /// The singular value of the root.
        value: f64,
    },
    /// A weight, rate or shift is out of its domain.
    #[error("autocorrelation: the {what} of term {index} is {value:?}, expected {expected}")]
    Term {
        /// Place in the list, from 0.
        index: usize,
        /// `"weight"`, `"rate"` or `"shift"`.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
    /// A number that describes a spectrum, a relief or a phase is out of its domain.
    #[error("autocorrelation: the {what} is {value:?}, expected {expected}")]
    Number {
        /// Its name.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
    /// A grating is too deep for its orders to be counted.
    #[error(
        "autocorrelation: the phase depth of a grating is {:?} rad at φ_z = {phi_z:?} rad/m and a depth of {depth:?} m, \
         expected 0 to 1e5 rad",
        .phi_z.abs() * .depth
    )]
    Depth {
        /// Vertical wave vector.
        phi_z: f64,
        /// From the lowest to the highest point, m.
        depth: f64,
    },
    /// Heights are too many wavelengths high, or not a number of them.
    #[error(
        "autocorrelation: the roughness g = (φ_z σ_h)² is {g:?} at φ_z = {phi_z:?} rad/m and σ_h = {deviation:?} m, expected \
         0 to {most:?}"
    )]
    Roughness {
        /// Variance of the phase.
        g: f64,
        /// Vertical wave vector.
        phi_z: f64,
        /// Standard deviation of the heights, m.
        deviation: f64,
        /// Largest g that is taken.
        most: f64,
    },
}

pub(super) fn check(
    what: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), AutocorrelationError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(AutocorrelationError::Number {
            what,
            value,
            expected,
        })
    }
}

/// Whether `deviation` is a standard deviation of heights, m.
pub(super) fn check_deviation(deviation: f64) -> Result<(), AutocorrelationError> {
    let what = "standard deviation of the heights";
    check(what, deviation, 0.0..=1e24, "a number between 0 and 1e24 m")
}

/// `g = (φ_z σ_h)²`, at most `most`.
pub(super) fn roughness(
    phi_z: f64,
    deviation: f64,
    most: f64,
) -> Result<f64, AutocorrelationError> {
    let g = (phi_z * deviation).powi(2);
    if (0.0..=most).contains(&g) {
        Ok(g)
    } else {
        Err(AutocorrelationError::Roughness {
            g,
            phi_z,
            deviation,
            most,
        })
    }
}
