//! What thin films and crystal plates share: checks of their numbers, and the light that leaves them.

use num_complex::Complex64;
use stokes::{Mueller, Wavelength};
use thiserror::Error;

use crate::JonesMatrix;
use crate::fresnel::normal_index_of;

/// Moduli of refractive indices lie between this and its inverse.
const SMALLEST_INDEX: f64 = 1e-8;
/// Thickest layer, in metres: beyond it a phase has no digits left.
const THICKEST: f64 = 1e6;

/// Why numbers make no stack of layers, or no Mueller matrix.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum FilmError {
    /// The refractive index of a medium is out of range, or its medium gains.
    #[error(
        "{medium}: refractive index eta - ik with eta = {eta} and k = {k}, expected eta >= 0, k >= 0 and a modulus \
         between 1e-8 and 1e8"
    )]
    Index {
        /// Which medium.
        medium: Medium,
        /// Real part.
        eta: f64,
        /// Extinction coefficient.
        k: f64,
    },
    /// The medium that the light comes from absorbs.
    #[error("{medium}: extinction coefficient k = {k}, expected 0 where light comes from")]
    Absorbing {
        /// Which medium.
        medium: Medium,
        /// Extinction coefficient.
        k: f64,
    },
    /// The thickness of a layer.
    #[error("{medium}: thickness {thickness} m, expected a number between 0 and 1e6")]
    Thickness {
        /// Which medium.
        medium: Medium,
        /// What was found, in metres.
        thickness: f64,
    },
    /// Light in an absorbing exit medium has no Stokes vector of its own: s and p carry power differently.
    #[error(
        "transmission: no mueller matrix into an exit medium with k = {k}, expected k = 0; use the amplitudes"
    )]
    AbsorbingExit {
        /// Extinction coefficient of the exit medium.
        k: f64,
    },
}

/// A medium of a stack, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Medium {
    /// Where the light comes from.
    Incident,
    /// A layer, counted from 0 at the incident medium.
    Layer(usize),
    /// Behind the last layer.
    Exit,
}

impl std::fmt::Display for Medium {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Incident => write!(f, "incident medium"),
            Self::Layer(number) => write!(f, "layer {number}"),
            Self::Exit => write!(f, "exit medium"),
        }
    }
}

/// Whether `η − ik` is an index of passive matter that the methods of this crate can take.
pub(crate) fn is_index(n: Complex64) -> bool {
    let range = SMALLEST_INDEX..=1.0 / SMALLEST_INDEX;
    n.re >= 0.0 && n.im <= 0.0 && range.contains(&n.norm())
}

pub(crate) fn checked_index(n: Complex64, medium: Medium) -> Result<Complex64, FilmError> {
    if is_index(n) {
        return Ok(n);
    }
    Err(FilmError::Index {
        medium,
        eta: n.re,
        k: -n.im,
    })
}

pub(crate) fn transparent_index(n: Complex64, medium: Medium) -> Result<f64, FilmError> {
    let n = checked_index(n, medium)?;
    if n.im == 0.0 {
        return Ok(n.re);
    }
    Err(FilmError::Absorbing { medium, k: -n.im })
}

pub(crate) fn checked_thickness(thickness: f64, medium: Medium) -> Result<f64, FilmError> {
    if (0.0..=THICKEST).contains(&thickness) {
        return Ok(thickness);
    }
    Err(FilmError::Thickness { medium, thickness })
}

/// `k₀ d`, the thickness in radians of vacuum.
pub(crate) fn optical_depth(thickness: f64, wavelength: Wavelength) -> f64 {
    std::f64::consts::TAU * (thickness / wavelength.metres())
}

/// `[s, p]` power weights from a transparent medium of index `n1` into one of index `n2`: theory of absorbing exit
/// media wants `Re(n₂ cos θ₂)/(n₁ cos θ₁)` for s and `Re(n₂* cos θ₂)/(n₁ cos θ₁)` for p.
pub(crate) fn power_weight(n1: f64, n2: Complex64, cos_i: f64) -> [f64; 2] {
    let w = normal_index_of(n1.into(), n2, cos_i);
    let grazing = n1 * cos_i;
    [w.re / grazing, (n2.conj() * (w / n2)).re / grazing]
}

/// The Mueller matrix of transmission, power weight included.
pub(crate) fn transmission_mueller(
    jones: &JonesMatrix,
    weight: f64,
    exit: Complex64,
) -> Result<Mueller, FilmError> {
    if exit.im != 0.0 {
        return Err(FilmError::AbsorbingExit { k: -exit.im });
    }
    // at grazing incidence the weight is infinite, and no light enters
    let weight = if weight.is_finite() { weight } else { 0.0 };
    Ok(jones.mueller() * weight)
}
