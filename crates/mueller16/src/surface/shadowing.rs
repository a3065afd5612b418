//! Shadowing and masking of rough surfaces.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

/// Smith's `G1 = 1/(1 + Λ)` of a surface with Gaussian slopes, for a direction at `cosine` from the normal whose
/// tangential part is along `tangential`; in `0.0..=1.0`.
///
/// ```text
/// Λ = e^(−a²)/(2a√π) − erfc(a)/2,     a = cos/(α sin),     α² = 2 uᵀCu        C covariance of the slopes, u azimuth
/// ```
///
/// Source: Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces, section 5.3, the exact form.
///
/// α = 0.5 at 80°, a = 0.352654:
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// let slopes = Matrix2::from_diagonal_element(0.125);
/// let g1 = mueller16::smith_beckmann(&slopes, 80f64.to_radians().cos(), &Vector2::x());
/// assert!((g1 - 0.715620).abs() < 1e-6);
/// ```
#[must_use]
pub fn smith_beckmann(
    slope_covariance: &Matrix2<f64>,
    cosine: f64,
    tangential: &Vector2<f64>,
) -> f64 {
    let cos = cosine.abs().min(1.0);
    let sine = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let length = tangential.norm();
    if sine == 0.0 || length == 0.0 {
        return 1.0;
    }
    let u = tangential / length;
    let alpha = (2.0 * u.dot(&(slope_covariance * u))).max(0.0).sqrt();
    let a = cos / (alpha * sine);
    // at a = 26 Λ is below the smallest number that 1 notices
    if a > 26.0 || alpha == 0.0 {
        return 1.0;
    }
    if a == 0.0 {
        return 0.0;
    }
    let lambda = 0.5 * ((-a * a).exp() / (a * PI.sqrt()) - libm::erfc(a));
    1.0 / (1.0 + lambda)
}
