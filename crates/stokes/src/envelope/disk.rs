//! The uniform disk.
//!
//! With `T = U diag(t₁, t₂) Vᵀ` the turn V leaves the disk as it is. Chords across the first axis have closed moments
//! ([`super::staircase`]), and with `x = R sin θ` what remains is smooth up to the rim:
//!
//! ```text
//! J_ab = 4 ∫_0^{π/2} R cos θ h_a(t₁ R sin θ) (∫_0^{R cos θ} h_b(t₂ x₂) dx₂) dθ,        a, b even
//! ```
//!
//! Axis 1 is the one along which the disk is wide beside the functions: θ ends where they do.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

use crate::hermite::{self, MAX_ORDER};
use crate::plane::{self, SingularValues};

use super::grid::add_products;
use super::quadrature::{Rules, reach};
use super::staircase::Staircase;

/// Adds `∫_disk h_a(y₁) h_b(y₂) d²x`, `y = T x`, to `moments`; they have to be turned by the matrix that is returned.
pub(crate) fn moments(
    radius: f64,
    t: &Matrix2<f64>,
    order: usize,
    moments: &mut [f64],
) -> Matrix2<f64> {
    let SingularValues {
        left,
        values: [t1, t2],
        ..
    } = plane::singular_values(t);
    let far = reach(order);
    let end = (far / (t1 * radius)).min(1.0).asin();
    // the sine bends the phase; a few more nodes follow it
    let phase = 2.0 + 1.1 * far * 0.5 * end * radius * (t1 + t2);
    let mut rules = Rules::default();
    let nodes: Vec<_> = rules.on(0.0, end, phase).collect();
    let mut first = [0.0; MAX_ORDER + 1];
    let mut second = [0.0; MAX_ORDER + 1];
    for (theta, weight) in nodes {
        let (sin, cos) = theta.sin_cos();
        let half = radius * cos;
        hermite::fill(t1 * radius * sin, &mut first[..=order]);
        Staircase {
            edges: &[-half, half],
            values: &[1.0],
        }
        .moments(t2, 0.0, &mut rules, &mut second[..=order]);
        // odd functions vanish over the whole disk, to the last bit
        for n in (1..=order).step_by(2) {
            first[n] = 0.0;
            second[n] = 0.0;
        }
        add_products(2.0 * weight * half, &first, &second, order, moments);
    }
    left
}

/// `F{disk}(u) = 2πR² J₁(q)/q`, `q = |u| R`.
pub(crate) fn fourier(radius: f64, u: &Vector2<f64>) -> Complex64 {
    let q = u.norm() * radius;
    let area = std::f64::consts::PI * radius * radius;
    let falloff = if q == 0.0 { 1.0 } else { 2.0 * libm::j1(q) / q };
    Complex64::new(area * falloff, 0.0)
}
