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

use super::blur::CUT;
use super::grid::add_products;
use super::quadrature::{Rules, reach};
use super::staircase::Staircase;

/// Adds `∫_disk h_a(y₁) h_b(y₂) d²x`, `y = T (x − origin)`, to `moments`; they have to be turned by the matrix that is
/// returned.
pub(crate) fn moments(
    radius: f64,
    t: &Matrix2<f64>,
    origin: &Vector2<f64>,
    order: usize,
    moments: &mut [f64],
) -> Matrix2<f64> {
    let SingularValues {
        left,
        values: [t1, t2],
        right,
    } = plane::singular_values(t);
    let centred = *origin == Vector2::zeros();
    let o = plane::apply(&right.transpose(), origin);
    let far = reach(order);
    let angle = |x: f64| (x / radius).clamp(-1.0, 1.0).asin();
    let end = angle(o.x + far / t1);
    // one half of a centred disk is as the other
    let start = if centred { 0.0 } else { angle(o.x - far / t1) };
    let share = if centred { 2.0 } else { 1.0 };
    // the sine bends the phase; a few more nodes follow it
    let phase = 2.0 + 1.1 * far * 0.5 * (end - start) * radius * (t1 + t2);
    let mut rules = Rules::default();
    let nodes: Vec<_> = rules.on(start, end, phase).collect();
    let mut first = [0.0; MAX_ORDER + 1];
    let mut second = [0.0; MAX_ORDER + 1];
    for (theta, weight) in nodes {
        let (sin, cos) = theta.sin_cos();
        let half = radius * cos;
        hermite::fill(t1 * (radius * sin - o.x), &mut first[..=order]);
        Staircase {
            edges: &[-half - o.y, half - o.y],
            values: &[1.0],
        }
        .moments(t2, 0.0, &mut rules, &mut second[..=order]);
        if centred {
            // odd functions vanish over the whole disk, to the last bit
            for n in (1..=order).step_by(2) {
                first[n] = 0.0;
                second[n] = 0.0;
            }
        }
        add_products(share * weight * half, &first, &second, order, moments);
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

/// The mean of a disk's intensity over a normalised Gaussian with these standard deviations along two axes, about
/// `centre`: what a lobe sees of it. By chords, with `x = R sin θ`:
///
/// ```text
/// ∫ g(x − c₁) ½[erf((√(R²−x²) − c₂)/√2 σ₂) + erf((√(R²−x²) + c₂)/√2 σ₂)] dx
/// ```
pub(crate) fn under_gaussian(radius: f64, sigmas: [f64; 2], centre: [f64; 2]) -> f64 {
    let [along, across] = sigmas;
    let reach = (CUT + 0.5) * along;
    let [low, high] = [centre[0] - reach, centre[0] + reach].map(|x| (x / radius).clamp(-1.0, 1.0));
    if low >= high {
        return 0.0;
    }
    let mut rules = Rules::default();
    let mut sum = 0.0;
    // panels of one standard deviation; θ stays smooth up to the rim
    let panels = ((high - low) * radius / along).ceil().max(1.0) as usize;
    let theta = |i: usize| (low + (high - low) * (i as f64 / panels as f64)).asin();
    let scale = std::f64::consts::FRAC_1_SQRT_2 / across;
    for i in 0..panels {
        // error functions are flat eight standard deviations from where the chord ends
        let [first, last] = [theta(i), theta(i + 1)].map(|angle| radius * angle.cos() / across);
        let shift = centre[1].abs() / across;
        let phase = if first.min(last) < 8.0 + shift {
            8.0 + 3.0 * (first - last).abs()
        } else {
            8.0
        };
        for (angle, weight) in rules.on(theta(i), theta(i + 1), phase) {
            let (sin, cos) = angle.sin_cos();
            let d = (radius * sin - centre[0]) / along;
            let chord = libm::erf((radius * cos - centre[1]) * scale)
                + libm::erf((radius * cos + centre[1]) * scale);
            sum += weight * radius * cos * (-0.5 * d * d).exp() * 0.5 * chord;
        }
    }
    sum / (along * std::f64::consts::TAU.sqrt())
}
