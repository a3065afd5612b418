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

/// Unit vector, in the plate's coordinates, along which a thin polarizer lets the field of a ray pass; `(sin, cos)` of
/// `theta`.
///
/// The absorbing axis `(sin θ, cos θ, 0)` is projected across `k`; the transmitted axis is perpendicular to both.
/// `k` of unit length. Light that travels along the absorbing axis gets the limit from nearby directions.
///
/// Source: Korger et al. 2013, The polarization properties of a tilted polarizer, Optics Express 21, 27032.
///
/// ```
/// let axis = mueller16::element::polarizer_transmitted_axis(0.0f64.sin_cos(), [0.0, 0.0, -1.0]);
/// assert_eq!(axis, [1.0, 0.0, 0.0]);
/// ```
#[must_use]
pub fn polarizer_transmitted_axis((sin, cos): (f64, f64), k: [f64; 3]) -> [f64; 3] {
    cross(k, projected([sin, cos, 0.0], k))
}

/// Unit vector, in the plate's coordinates, along which the field of a ray is fast in a thin retarder; `(sin, cos)` of
/// `theta`.
///
/// The plate's axis U is projected across `k`; the fast axis makes the angle `theta` with it on the wavefront, turning
/// from U toward V. `k` of unit length. Light that travels along U gets the limit from nearby directions.
///
/// An effective-axis model, the same as Mitsuba's where Mitsuba projects U rightly. A crystal's axis projected by
/// itself would lie up to `(1 − cos)/2` of the tilt, in radians, from this one.
///
/// ```
/// let axis = mueller16::element::retarder_fast_axis(0.0f64.sin_cos(), [0.0, 0.6, 0.8]);
/// assert_eq!(axis, [1.0, 0.0, 0.0]);
/// ```
#[must_use]
pub fn retarder_fast_axis((sin, cos): (f64, f64), k: [f64; 3]) -> [f64; 3] {
    let u = projected([1.0, 0.0, 0.0], k);
    // the second axis on the wavefront is the one on the side of V, whichever way the light goes
    let side = if k[2] < 0.0 { -1.0 } else { 1.0 };
    let v = cross(k, u).map(|c| side * c);
    [0, 1, 2].map(|i| cos * u[i] + sin * v[i])
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn same_axis(a: [f64; 3], b: [f64; 3]) -> bool {
        (dot(a, b).abs() - 1.0).abs() < 1e-14
    }

    #[test]
    fn polarizers_turn_clockwise_and_retarders_counter_clockwise_seen_from_the_front() {
        for k in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            for theta in [0.0f64, 0.3, FRAC_PI_4, 1.4, -0.8] {
                let (sin, cos) = theta.sin_cos();
                assert!(same_axis(
                    polarizer_transmitted_axis(theta.sin_cos(), k),
                    [cos, -sin, 0.0]
                ));
                assert!(same_axis(
                    retarder_fast_axis(theta.sin_cos(), k),
                    [cos, sin, 0.0]
                ));
            }
        }
    }

    #[test]
    fn a_polarizer_at_45_degrees_seen_from_the_front_passes_negative_s2() {
        // light that leaves through the front travels along +z; its receiver has U right and V up
        let axis = polarizer_transmitted_axis(FRAC_PI_4.sin_cos(), [0.0, 0.0, 1.0]);
        let to_axis = stokes::FrameRotation::from_axis(axis[0], axis[1]);
        let light = stokes::StokesVector::UNPOLARIZED.rotated(to_axis);
        let out = linear_polarizer().apply(light).rotated(to_axis.inverse());
        let expected = stokes::StokesVector::ANTIDIAGONAL * 0.5;
        assert!((out - expected).to_vector().norm() < 1e-15);
    }

    #[test]
    fn axes_of_oblique_rays_are_transverse_unit_vectors() {
        let k = [0.48, -0.6, 0.64];
        for theta in [0.0f64, 0.7, 2.0] {
            for axis in [
                polarizer_transmitted_axis(theta.sin_cos(), k),
                retarder_fast_axis(theta.sin_cos(), k),
            ] {
                assert!(dot(axis, k).abs() < 1e-15);
                assert!((dot(axis, axis) - 1.0).abs() < 1e-15);
            }
            // Korger et al.: what is absorbed is the projection of the absorbing axis
            let absorbing = [f64::sin(theta), f64::cos(theta), 0.0];
            assert!(dot(polarizer_transmitted_axis(theta.sin_cos(), k), absorbing).abs() < 1e-15);
        }
    }

    #[test]
    fn turning_theta_is_turning_the_plate() {
        // polarizer at θ, ray in the plane V = 0, equals polarizer at 0 in axes turned by −θ about the normal
        let (theta, k) = (0.6f64, [0.6, 0.0, 0.8]);
        let (sin, cos) = theta.sin_cos();
        let turn = |v: [f64; 3], sin: f64| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
        let by_theta = polarizer_transmitted_axis(theta.sin_cos(), k);
        let by_turning = turn(
            polarizer_transmitted_axis(0.0f64.sin_cos(), turn(k, sin)),
            -sin,
        );
        assert!(same_axis(by_theta, by_turning));
    }

    #[test]
    fn the_fast_axis_keeps_its_angle_to_the_projected_u_axis() {
        // tilted about V by 60°: U shortens to its projection, θ is counted on the wavefront
        let (theta, k) = (0.5f64, [0.75f64.sqrt(), 0.0, 0.5]);
        let u = retarder_fast_axis(0.0f64.sin_cos(), k);
        assert!(same_axis(u, [0.5, 0.0, -(0.75f64.sqrt())]));
        assert!((dot(retarder_fast_axis(theta.sin_cos(), k), u) - theta.cos()).abs() < 1e-15);
        // and turns toward V from both sides
        assert!(retarder_fast_axis(theta.sin_cos(), k)[1] > 0.0);
        assert!(retarder_fast_axis(theta.sin_cos(), k.map(|c| -c))[1] > 0.0);
    }

    #[test]
    fn the_fast_axis_has_no_seam_between_quadrants() {
        let tilted = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            retarder_fast_axis(
                0.4f64.sin_cos(),
                [0.17 * cos, 0.17 * sin, (1.0f64 - 0.17 * 0.17).sqrt()],
            )
        };
        for step in 0..3600 {
            let (a, b) = (
                tilted(f64::from(step).to_radians() / 10.0),
                tilted(f64::from(step + 1).to_radians() / 10.0),
            );
            assert!(dot(a, b) > 1.0 - 1e-6);
        }
    }

    #[test]
    fn light_along_an_axis_gets_the_limit_of_its_neighbours() {
        let near = 1e-6f64;
        let k = [near.cos(), 0.0, near.sin()];
        let along = [1.0, 0.0, 0.0];
        assert!(
            (dot(
                retarder_fast_axis(0.0f64.sin_cos(), k),
                retarder_fast_axis(0.0f64.sin_cos(), along)
            )
            .abs()
                - 1.0)
                .abs()
                < 1e-11
        );
        let limit = polarizer_transmitted_axis(FRAC_PI_2.sin_cos(), along);
        assert!(
            (dot(polarizer_transmitted_axis(FRAC_PI_2.sin_cos(), k), limit).abs() - 1.0).abs()
                < 1e-11
        );
    }

    #[test]
    fn a_tilted_plate_retards_less() {
        assert_eq!(oblique_retardance(2.0, [0.6, 0.0, -0.8]), 1.6);
    }
}
