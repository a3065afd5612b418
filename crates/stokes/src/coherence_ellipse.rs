//! The coherence ellipse: over which separations light is coherent, from the curvature of `|C0|` at zero separation.

use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

use crate::basis::modes;
use crate::beam::GeneralizedStokes;
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
            plane::axis_angle(right.m22.atan2(right.m12))
        };
        Ok(CoherenceEllipse {
            semi_major: to_metres / small,
            semi_minor: to_metres / large,
            orientation,
        })
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
