//! Accuracy as an argument: what a caller may ask for, and what was chosen for it.

use thiserror::Error;

/// A tolerance that no method here can keep, or that asks for nothing.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("tolerance: found {0}, expected a relative error between 1e-15 and 0.5")]
pub struct BadTolerance(pub f64);

/// Relative error that a caller accepts, in `1e-15..=0.5`.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Tolerance(f64);

impl Tolerance {
    /// What rounding leaves: nothing that can be seen in f64 is dropped.
    pub const ROUNDING: Self = Self(1e-15);

    /// Errors up to `relative` are accepted.
    ///
    /// # Errors
    ///
    /// When `relative` is not between 1e-15 and 0.5.
    pub fn relative(relative: f64) -> Result<Self, BadTolerance> {
        if (1e-15..=0.5).contains(&relative) {
            Ok(Self(relative))
        } else {
            Err(BadTolerance(relative))
        }
    }

    /// Half of it, down to [`Tolerance::ROUNDING`].
    pub(crate) fn half(self) -> Self {
        Self((0.5 * self.0).max(Self::ROUNDING.0))
    }

    /// The relative error.
    #[must_use]
    pub fn get(self) -> f64 {
        self.0
    }
}

/// How a function of position was made a sum of Gaussians.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// It is one.
    Exact,
    /// The Poisson sum of a rough surface's powers of the height correlation, cut where it is below the tolerance.
    PoissonSum,
    /// Gauss quadrature for the Poisson weights.
    GaussCharlier,
    /// The leading Gaussian of a very rough surface.
    GeometricOptics,
    /// Quadrature over the widths of a scale mixture.
    WidthQuadrature,
    /// Positive weights fitted on a grid of widths.
    WidthFit,
    /// Orders of a grating, cut where they are below the tolerance.
    Orders,
}

/// What was chosen, and how far from the exact function it can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approximation {
    /// The method.
    pub method: Method,
    /// Gaussian terms (delta orders included).
    pub terms: usize,
    /// Bound on the error of the lobe `F{R γ}`, over its largest value.
    pub error: f64,
}
