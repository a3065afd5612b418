//! Ideal polarizers and retarders, and where their axes lie for an oblique ray.
//!
//! Matrices are written in the element's own frame: `x` along the transmitted, respectively fast, axis. Thin plates
//! stand in the plane of their local `U = (1, 0, 0)` and `V = (0, 1, 0)`, normal `(0, 0, 1)`; `k` is the direction
//! of the light in these coordinates. Angles `theta` are in radians, and follow the plates of Mitsuba 3: a
//! polarizer transmits along `(cos θ, −sin θ)` (clockwise seen from the front), a retarder is fast along
//! `(cos θ, sin θ)` (counter-clockwise).

use stokes::{DiattenuatingRetarder, Mueller};

/// Ideal polarizer that passes light along its first axis.
#[must_use]
pub fn linear_polarizer() -> DiattenuatingRetarder {
    DiattenuatingRetarder::from_real_amplitudes(1.0, 0.0)
}

/// Linear retarder whose first axis is the fast one; `retardance` δ in radians.
///
/// Source: Goldstein, Polarized Light, 3rd ed., Eq. (6.43), with the sign of the crate page.
///
/// A quarter-wave plate turns +45° light into left circular light:
/// ```
/// let plate = mueller16::element::linear_retarder(std::f64::consts::FRAC_PI_2);
/// let out = plate.apply(stokes::StokesVector::DIAGONAL);
/// assert!((out - stokes::StokesVector::LEFT_CIRCULAR).to_vector().norm() < 1e-15);
/// ```
#[must_use]
pub fn linear_retarder(retardance: f64) -> DiattenuatingRetarder {
    let (sine, cosine) = retardance.sin_cos();
    DiattenuatingRetarder {
        mean: 1.0,
        difference: 0.0,
        cosine,
        sine,
    }
}

/// Ideal circular polarizer: passes `S3 > 0`, or `S3 < 0` when `left_handed`. The same in every frame and from
/// both sides.
#[must_use]
pub fn circular_polarizer(left_handed: bool) -> Mueller {
    let hand = if left_handed { -0.5 } else { 0.5 };
    let dark = [0.0; 4];
    Mueller::from_rows([[0.5, 0.0, 0.0, hand], dark, dark, [hand, 0.0, 0.0, 0.5]])
}

/// Unit vector, in the plate's coordinates, along which a thin polarizer lets the field of a ray pass.
///
/// The absorbing axis `(sin θ, cos θ, 0)` is projected across `k`; the transmitted axis is perpendicular to both.
/// `k` of unit length. Light that travels along the absorbing axis gets the limit from nearby directions.
///
/// Source: Korger et al. 2013, The polarization properties of a tilted polarizer, Optics Express 21, 27032.
///
/// ```
/// let axis = mueller16::element::polarizer_transmitted_axis(0.0, [0.0, 0.0, -1.0]);
/// assert_eq!(axis, [1.0, 0.0, 0.0]);
/// ```
#[must_use]
pub fn polarizer_transmitted_axis(theta: f64, k: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    cross(k, projected([sin, cos, 0.0], k))
}

/// Unit vector, in the plate's coordinates, along which the field of a ray is fast in a thin retarder.
///
/// The axis `(cos θ, sin θ, 0)` projected across `k`, of unit length. Light that travels along the axis gets the
/// limit from nearby directions; its retardance is 0 there.
#[must_use]
pub fn retarder_fast_axis(theta: f64, k: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    projected([cos, sin, 0.0], k)
}

/// Retardance of a thin retarder for a ray along `k` (unit length): `retardance · |cos|` of the angle of incidence.
///
/// Mitsuba's rule, kept for agreement of images; a real plate's retardance depends on the direction to its axis too.
#[must_use]
pub fn oblique_retardance(retardance: f64, k: [f64; 3]) -> f64 {
    retardance * k[2].abs()
}

/// `axis` projected across `k`, of unit length; the plate's normal where the two are parallel.
fn projected(axis: [f64; 3], k: [f64; 3]) -> [f64; 3] {
    let along = axis[0] * k[0] + axis[1] * k[1] + axis[2] * k[2];
    let across = [0, 1, 2].map(|i| axis[i] - along * k[i]);
    let norm = across.iter().map(|c| c * c).sum::<f64>().sqrt();
    if norm < 1e-12 {
        return [0.0, 0.0, 1.0];
    }
    across.map(|c| c / norm)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
