//! The waves of a crystal that neither absorbs nor turns light, where all of them propagate, in real numbers.
//!
//! With ε real, κ = (0, ξ, q) over k₀ and the tangential fields u = (E_x, E_y), v = (h_y, −h_x), E_z and h_z eliminated,
//!
//! ```text
//! q u = P u + Q v,   q v = S u + Pᵀ v
//! P = −ξ/ε_zz (0, 0; ε_xz, ε_yz)     Q = diag(1, 1 − ξ²/ε_zz)     S_ij = ε_ij − ε_iz ε_jz/ε_zz − ξ² δ_ix δ_jx
//! ```
//!
//! of which the waves `(a, b)` of [`Generator`](super::generator::Generator) are sums and differences: M is real, and so
//! are the subspaces of forward and backward waves.
//!
//! Source: Berreman, J. Opt. Soc. Am. 62, 502 (1972).

use nalgebra::{Matrix2, Matrix3, Rotation3, Vector3};
use num_complex::Complex64;

use super::crystal::Crystal;
use super::half_space::{Directions, HalfSpace, graph_near};

impl Directions {
    /// What [`Directions::new`] computes, where the crystal is lossless and inactive and all waves propagate.
    ///
    /// Agrees with the general solution to 1e-13 (tests).
    pub(super) fn of_clear(crystal: &Crystal, xi: f64, azimuth: f64) -> Option<Self> {
        let epsilon = crystal.clear_permittivity()?;
        let square = epsilon.trace() / 3.0;
        if square <= xi * xi {
            return None;
        }
        let near = HalfSpace::<Complex64>::isotropic(
            square.sqrt().into(),
            (square - xi * xi).sqrt().into(),
        );
        let near = near.as_real()?.as_graphs()?;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth).into_inner();
        let [aa, ab, ba, bb] = blocks(&(turn.transpose() * epsilon * turn), xi)?;
        let forward = graph_near(near.b_forward, &aa, &ab, &ba, &bb)?;
        let backward = graph_near(near.a_backward, &bb, &ba, &ab, &aa)?;
        let one = Matrix2::identity();
        let complex = |m: Matrix2<f64>| m.map(Complex64::from);
        Some(Self {
            waves: HalfSpace {
                a_forward: one,
                b_forward: complex(forward),
                a_backward: complex(backward),
                b_backward: one,
            },
            forward: complex(aa + ab * forward),
            backward: complex(bb + ba * backward),
        })
    }
}

/// M of the waves (a, b): `aa, ab, ba, bb`.
fn blocks(epsilon: &Matrix3<f64>, xi: f64) -> Option<[Matrix2<f64>; 4]> {
    let inverse = epsilon.m33.recip();
    let (x, y) = (epsilon.m13, epsilon.m23);
    let p = Matrix2::new(0.0, 0.0, x, y) * (-xi * inverse);
    let q = Matrix2::new(1.0, 0.0, 0.0, 1.0 - xi * xi * inverse);
    let across = epsilon.m12 - x * y * inverse;
    let s = Matrix2::new(
        epsilon.m11 - x * x * inverse - xi * xi,
        across,
        across,
        epsilon.m22 - y * y * inverse,
    );
    let (p, t) = (p * 0.5, p.transpose() * 0.5);
    let (q, s) = (q * 0.5, s * 0.5);
    inverse
        .is_finite()
        .then(|| [p + q + s + t, p - q + s - t, p + q - s - t, p - q - s + t])
}
