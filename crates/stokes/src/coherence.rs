//! What one measures of the light's coherence: degrees at a separation, and the ellipse over which it lasts.
//!
//! Degrees of polarization, angles and the polarization ellipse belong to one point: they are those of
//! [`GeneralizedStokes::stokes`]. Nothing here is clamped. Light without intensity (`C0(0) ≤ 0`) has degree 0 by
//! definition, as in [`crate::StokesVector`].

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use thiserror::Error;

use crate::basis::modes;
use crate::beam::{Components, GeneralizedStokes};
use crate::hermite::{MAX_ORDER, PI_FOURTH_ROOT_INVERSE};
use crate::plane;
use crate::series::HermiteSeries;

/// Why light has no coherence ellipse.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CoherenceError {
    /// There is no light whose coherence could be asked for.
    #[error("coherence: the intensity is {intensity}, expected a positive number")]
    Dark {
        /// `C0(0)`.
        intensity: f64,
    },
    /// `|C0|` does not fall in every direction.
    #[error(
        "coherence: the curvature of −ln |C0| at zero separation is {larger} and {smaller} (1 for a Gaussian of the \
         light's shape), expected both positive (beyond their rounding error {rounding}): the series has no maximum there; \
         raise its order or choose a shape nearer to the light's"
    )]
    NoMaximum {
        /// The larger curvature, in whitened coordinates.
        larger: f64,
        /// The smaller curvature, in whitened coordinates.
        smaller: f64,
        /// Bound of the error of both.
        rounding: f64,
    },
}

/// The separations over which light is coherent: an ellipse across the ray.
///
/// On it the Gaussian that meets `|γ|` at zero separation has fallen to `e^(−1/2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoherenceEllipse {
    /// Semi-major axis, m.
    pub semi_major: f64,
    /// Semi-minor axis, m.
    pub semi_minor: f64,
    /// Angle of the major axis from the frame's `x`, radians in `[0, π)`; 0 for a circle.
    pub orientation: f64,
}

impl GeneralizedStokes {
    /// The series of `C0` and its factor.
    fn total(&self) -> Option<(f64, &HermiteSeries)> {
        match self.components() {
            Components::Shared { modes, stokes } => Some((stokes.s0(), modes)),
            Components::Separate(series) => series[0].as_ref().map(|series| (1.0, series)),
        }
    }

    /// Spectral intensity `C0(0)`, in the unit of the light.
    ///
    /// Source: Eq. (S4.7).
    #[must_use]
    pub fn intensity(&self) -> f64 {
        self.total().map_or(0.0, |(amplitude, series)| {
            amplitude * series.value_at_zero(self.shape()) / (self.distance() * self.distance())
        })
    }

    /// Degree of coherence `γ(ξ) = C0(ξ)/C0(0)` of two points `separation` metres apart across the ray; 0 for dark
    /// light.
    ///
    /// Its modulus is the visibility of the fringes of two pinholes there, 1 at zero separation and at most 1 for
    /// light that exists; its argument is their shift. In the far field both points have the same intensity.
    ///
    /// Source: Eq. (S4.8).
    #[must_use]
    pub fn degree_of_coherence(&self, separation: &Vector2<f64>) -> Complex64 {
        match self.total() {
            Some((_, series)) if self.intensity() > 0.0 => {
                let w = self.far_field_argument(separation);
                series.value(self.shape(), &w) / series.value_at_zero(self.shape())
            }
            _ => Complex64::ZERO,
        }
    }

    /// Degree of cross-polarization `√(|C1|² + |C2|² + |C3|²)/|C0|` of two points `separation` metres apart.
    ///
    /// Real, the same in every frame, and what correlations of intensity measure; the degree of polarization at zero
    /// separation. It may exceed 1 elsewhere, and is infinite where `C0` alone vanishes. Where all four vanish it
    /// is 0, unless they share their modes: then it is the same number everywhere.
    ///
    /// Source: Shirai & Wolf, Opt. Commun. 272 (2007); Eq. (S4.9) with moduli and the first power of `C0`.
    #[must_use]
    pub fn degree_of_cross_polarization(&self, separation: &Vector2<f64>) -> f64 {
        let [c0, rest @ ..] = self.ratios(separation);
        let [c1, c2, c3] = rest.map(Complex64::norm);
        let polarized = c1.hypot(c2).hypot(c3);
        if polarized == 0.0 {
            0.0
        } else {
            polarized / c0.norm()
        }
    }

    /// The complex degree of cross-polarization, `√(C1² + C2² + C3²)/C0` (no moduli); `None` where `C0` vanishes or is
    /// too small to divide by.
    ///
    /// Equals `√(1 − 4 det C/tr² C)`, which is Eq. (S4.4) at a separation; of the two roots the one with
    /// non-negative real part. The same in every frame. Its modulus is at most
    /// [`GeneralizedStokes::degree_of_cross_polarization`].
    ///
    /// Source: Eq. (S4.9) with the first power of `C0`.
    #[must_use]
    pub fn complex_degree_of_cross_polarization(
        &self,
        separation: &Vector2<f64>,
    ) -> Option<Complex64> {
        let [c0, rest @ ..] = self.ratios(separation);
        let (modulus, most) = (
            c0.norm(),
            rest.iter().fold(0.0, |most: f64, c| most.max(c.norm())),
        );
        if modulus == 0.0 {
            return None;
        }
        if most == 0.0 {
            return Some(Complex64::ZERO);
        }
        // numbers of modulus near 1, whose squares neither over- nor underflow
        let turn = (c0 / modulus).conj();
        let squares = rest.map(|c| (c / most * turn).powi(2));
        let factor = most / modulus;
        factor
            .is_finite()
            .then(|| squares.iter().sum::<Complex64>().sqrt() * factor)
    }

    /// Four numbers in the ratio of the `C_j`: where they share their modes, the four amplitudes.
    fn ratios(&self, separation: &Vector2<f64>) -> [Complex64; 4] {
        match self.components() {
            Components::Shared { stokes, .. } => stokes.to_array().map(Complex64::from),
            Components::Separate(_) => self.at_separation(separation),
        }
    }

    /// The ellipse of separations over which the light is coherent.
    ///
    /// From the exact curvature of `ln |C0|` at zero separation, `−∇∇ᵀ ln |C0| = k² Γ`, where `Γ` is the covariance of
    /// the directions that the light comes from: semi-axes `1/(k √eig Γ)`. For a series of order 0 they are
    /// `(r/k) √eig Θ`. Odd orders shift the mean direction, which does not count. Relative error of a few `ε` times
    /// `Σ|terms|/C0`, for any condition number of the shape.
    ///
    /// # Errors
    ///
    /// When the light is dark, or its truncated series has no maximum at zero separation.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector3};
    /// use stokes::*;
    /// // the sun, 9.3 mrad across, as a Gaussian of its variance: radius 4λ/(2π · 9.3 mrad)
    /// let (distance, spread) = (1.5e11, 1.5e11 * 9.3e-3 / 4.0);
    /// let light = GeneralizedStokes::new(
    ///     Components::Shared {
    ///         modes: HermiteSeries::fundamental(1.0),
    ///         stokes: StokesVector::UNPOLARIZED,
    ///     },
    ///     ShapeMatrix::from_root(&Matrix2::from_diagonal_element(spread))?,
    ///     Frame::with_x_along(Vector3::z(), Vector3::x())?,
    ///     Wavelength::from_metres(550e-9)?,
    ///     distance,
    /// )?;
    /// let ellipse = light.coherence_ellipse()?;
    /// assert!((ellipse.semi_major - 37.65e-6).abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn coherence_ellipse(&self) -> Result<CoherenceEllipse, CoherenceError> {
        let intensity = self.intensity();
        let (Some((_, series)), true) = (self.total(), intensity > 0.0) else {
            return Err(CoherenceError::Dark { intensity });
        };
        let fall = Jet::at_zero(series).log_fall()?;
        // (root of the fall)·W has the squares of its singular values for eigenvalues of the whole
        let root = plane::product(&plane::symmetric_root(&fall), self.shape().root());
        let plane::SingularValues {
            values: [large, small],
            right,
            ..
        } = plane::singular_values(&root);
        let to_metres = self.distance() / self.wavelength().wavenumber().radians_per_metre();
        let round = large - small <= 8.0 * f64::EPSILON * large;
        let orientation = if round {
            0.0
        } else {
            axis_angle(right.m12, right.m22)
        };
        Ok(CoherenceEllipse {
            semi_major: to_metres / small,
            semi_minor: to_metres / large,
            orientation,
        })
    }
}

/// Angle of an undirected axis, in `[0, π)`.
fn axis_angle(x: f64, y: f64) -> f64 {
    let angle = y.atan2(x);
    let folded = if angle < 0.0 {
        angle + std::f64::consts::PI
    } else {
        angle
    };
    if folded < std::f64::consts::PI {
        folded
    } else {
        0.0
    }
}

/// Value and derivatives at 0 of `Σ c_ab h_a(y1) h_b(y2)`; the gradient of a Hermitian function is imaginary there.
struct Jet {
    value: f64,
    /// Imaginary part of the gradient.
    gradient: Vector2<f64>,
    hessian: Matrix2<f64>,
    /// Sum of the moduli of what was summed.
    magnitude: f64,
}

impl Jet {
    /// From `h_n = −√((n−1)/n) h_{n−2}`, `h_n' = √(2n) h_{n−1}` and `h_n'' = −(2n+1) h_n` at 0.
    fn at_zero(series: &HermiteSeries) -> Self {
        // h_n(0) for even n, h_n'(0) for odd n: the other one vanishes
        let mut h = [PI_FOURTH_ROOT_INVERSE; MAX_ORDER + 1];
        for n in 1..=series.order() {
            let order = n as f64;
            h[n] = if n % 2 == 1 {
                (2.0 * order).sqrt() * h[n - 1]
            } else {
                -((order - 1.0) / order).sqrt() * h[n - 2]
            };
        }
        let mut jet = Self {
            value: 0.0,
            gradient: Vector2::zeros(),
            hessian: Matrix2::zeros(),
            magnitude: 0.0,
        };
        for ((a, b), s) in modes(series.order()).zip(series.real_coefficients()) {
            // c_ab = i^(a+b) s_ab
            let sign = if (a + b) % 4 < 2 { 1.0 } else { -1.0 };
            let term = sign * s * h[a] * h[b];
            jet.magnitude += (2 * (a + b) + 1) as f64 * term.abs();
            match (a % 2, b % 2) {
                (0, 0) => {
                    jet.value += term;
                    jet.hessian.m11 -= (2 * a + 1) as f64 * term;
                    jet.hessian.m22 -= (2 * b + 1) as f64 * term;
                }
                (1, 0) => jet.gradient.x += term,
                (0, 1) => jet.gradient.y += term,
                _ => jet.hessian.m12 += term,
            }
        }
        jet.hessian.m21 = jet.hessian.m12;
        jet
    }

    /// `−∇∇ᵀ ln |f| = −f''/f + Re(f' f'ᵀ/f²)`, where `f'` is imaginary.
    fn log_fall(&self) -> Result<Matrix2<f64>, CoherenceError> {
        let slope = self.gradient / self.value;
        let fall = -self.hessian / self.value - slope * slope.transpose();
        let [larger, smaller] = plane::eigenvalues(&fall);
        let rounding =
            16.0 * f64::EPSILON * (self.magnitude / self.value).abs() * (1.0 + slope.norm());
        if smaller > rounding {
            Ok(fall)
        } else {
            Err(CoherenceError::NoMaximum {
                larger,
                smaller,
                rounding,
            })
        }
    }
}
