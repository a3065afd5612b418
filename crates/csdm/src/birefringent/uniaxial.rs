//! The ordinary and the extraordinary wave of a lossless uniaxial crystal in closed form.
//!
//! In the frame of incidence, optic axis c, principal permittivities ε_o and ε_e, wave vectors κ = (0, ξ, q) over k₀:
//!
//! ```text
//! ordinary:       κ² = ε_o                D ∥ κ × c
//! extraordinary:  κᵀεκ = ε_o ε_e          D ∥ κ × (κ × c)
//! ```
//!
//! Both D are across κ to the last bit even where κ lies almost along c and their directions are lost in rounding; the
//! two waves are then so nearly equal that any pair of directions serves.
//!
//! Source: Born & Wolf, Principles of Optics, 7th ed., sections 15.2.2, 15.3.1.

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;

use super::crystal::Crystal;
use super::half_space::{Directions, HalfSpace};

/// Waves that graze the faces inside more than this (q² over the permittivity) are left to the general solution.
const GRAZING: f64 = 1e-3;

/// A lossless uniaxial medium, optically inactive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uniaxial {
    pub(super) ordinary: f64,
    pub(super) extraordinary: f64,
    /// Unit vector, in plate axes.
    pub(super) axis: Vector3<f64>,
}

/// One plane wave: q, and its `(a, b)` as of [`Generator`](super::generator::Generator).
struct Wave {
    q: f64,
    a: Vector2<f64>,
    b: Vector2<f64>,
}

impl Directions {
    /// What [`Directions::new`] computes, where the crystal is uniaxial, lossless and inactive, and all waves propagate.
    ///
    /// Agrees with it to 1e-13 (tests).
    pub(super) fn of_uniaxial(crystal: &Crystal, xi: f64, azimuth: f64) -> Option<Self> {
        let Uniaxial {
            ordinary,
            extraordinary,
            axis,
        } = *crystal.uniaxial_part()?;
        let (sin, cos) = azimuth.sin_cos();
        let c = Vector3::new(
            axis.x * cos + axis.y * sin,
            axis.y * cos - axis.x * sin,
            axis.z,
        );
        let q_o2 = ordinary - xi * xi;
        // ε_zz q² + 2 ε_yz ξ q + ε_yy ξ² − ε_o ε_e = 0
        let excess = extraordinary - ordinary;
        let [yy, yz, zz] = [
            ordinary + excess * c.y * c.y,
            excess * c.y * c.z,
            ordinary + excess * c.z * c.z,
        ];
        let shift = -yz * xi / zz;
        let half2 = shift * shift + (ordinary * extraordinary - yy * xi * xi) / zz;
        let least = GRAZING * ordinary.max(extraordinary);
        if !(q_o2 > least && half2 > least) {
            return None;
        }
        let (q_o, half) = (q_o2.sqrt(), half2.sqrt());
        let pair = |sign: f64| {
            let kappa = Vector3::new(0.0, xi, sign * q_o);
            // any direction across, where the axis lies along the wave
            let across = across(&kappa, &c);
            let o = Wave::of(&across, kappa);
            let kappa = Vector3::new(0.0, xi, shift + sign * half);
            let d = kappa.cross(&self::across(&kappa, &c));
            // E = ε⁻¹ D up to a factor
            let e = d + c * (c.dot(&d) * (ordinary / extraordinary - 1.0));
            [o, Wave::of(&e, kappa)]
        };
        let [forward, backward] = [pair(1.0), pair(-1.0)];
        let (b_forward, grow_forward) = graph(forward.each_ref().map(|w| (w.q, w.a, w.b)))?;
        let (a_backward, grow_backward) = graph(backward.each_ref().map(|w| (w.q, w.b, w.a)))?;
        let one = Matrix2::identity();
        let complex = |m: Matrix2<f64>| m.map(Complex64::from);
        Some(Self {
            waves: HalfSpace {
                a_forward: one,
                b_forward: complex(b_forward),
                a_backward: complex(a_backward),
                b_backward: one,
            },
            forward: complex(grow_forward),
            backward: complex(grow_backward),
        })
    }
}

impl Wave {
    /// The wave of electric field along `e` and wave vector κ.
    fn of(e: &Vector3<f64>, kappa: Vector3<f64>) -> Self {
        let h = kappa.cross(e);
        let (u, v) = (e.xy(), Vector2::new(h.y, -h.x));
        Self {
            q: kappa.z,
            a: u + v,
            b: u - v,
        }
    }
}

/// A vector along κ × c, across κ to the last bit; x where κ lies along c.
fn across(kappa: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
    let w = kappa.cross(c);
    let square = kappa.norm_squared();
    if w.norm_squared() < 1e-28 * square {
        // κ has no component along x
        return Vector3::x();
    }
    let w = w.normalize();
    w - kappa * (kappa.dot(&w) / square)
}

/// `R` in `second = R first` for both waves, and A in `first' = −i k₀ A first`.
fn graph(waves: [(f64, Vector2<f64>, Vector2<f64>); 2]) -> Option<(Matrix2<f64>, Matrix2<f64>)> {
    let [(q_0, first_0, second_0), (q_1, first_1, second_1)] = waves;
    let inverse = Matrix2::from_columns(&[first_0, first_1]).try_inverse()?;
    Some((
        Matrix2::from_columns(&[second_0, second_1]) * inverse,
        Matrix2::from_columns(&[first_0 * q_0, first_1 * q_1]) * inverse,
    ))
}
