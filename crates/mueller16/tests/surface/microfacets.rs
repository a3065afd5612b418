//! Very rough surfaces against the microfacet model of Walter et al. 2007, written here from the paper.

use std::f64::consts::PI;

use crate::relief::{PlainHeights, direction, green, heights};
use mueller16::{Boundary, RayFrames, Surface, smith_beckmann};
use mueller16::{DielectricInterface, Geometry, IncidentCoherence, Relief, Tolerance};
use nalgebra::{Vector2, Vector3};

/// Unpolarized Fresnel reflectance, Eq. (22) of the paper.
fn fresnel(c: f64, n_i: f64, n_t: f64) -> f64 {
    let g = ((n_t / n_i).powi(2) - 1.0 + c * c).sqrt();
    let ratio = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    0.5 * ((g - c) / (g + c)).powi(2) * (1.0 + ratio * ratio)
}

/// Eq. (25).
fn beckmann(cos: f64, alpha: f64) -> f64 {
    let tan2 = 1.0 / (cos * cos) - 1.0;
    (-tan2 / (alpha * alpha)).exp() / (PI * alpha * alpha * cos.powi(4))
}

/// Eqs. (20) and (21) without G.
fn microfacets(i: Vector3<f64>, o: Vector3<f64>, [n_i, n_o]: [f64; 2], alpha: f64) -> f64 {
    if o.z > 0.0 {
        let h = (i + o).normalize();
        return fresnel(i.dot(&h), n_i, 1.5 / n_i) * beckmann(h.z, alpha) / (4.0 * i.z * o.z);
    }
    let mut h = -(i * n_i + o * n_o).normalize();
    if h.z < 0.0 {
        h = -h;
    }
    let (on_i, on_o) = (i.dot(&h), o.dot(&h));
    let jacobian = n_o * n_o / (n_i * on_i + n_o * on_o).powi(2);
    let passed = 1.0 - fresnel(on_i.abs(), n_i, n_o);
    (on_i * on_o / (i.z * o.z)).abs() * jacobian * passed * beckmann(h.z, alpha)
}

/// Largest deviation of wave optics over microfacets from `1 + (x² − 4x + 2)/2g`, times g².
fn deviation(
    relief: PlainHeights,
    [n_front, n_back]: [f64; 2],
    below: bool,
    sides: [f64; 2],
) -> f64 {
    let glass = Boundary::Dielectric(DielectricInterface::new(n_front, n_back).unwrap());
    let surface = Surface::of_heights(glass, relief);
    let alpha = 2.0 * relief.sigma / relief.length;
    let [n_i, n_o] = sides;
    let mut worst: f64 = 0.0;
    for polar in [0.0, 0.35, 0.6] {
        let i = direction(polar, 0.4);
        for step in 0..60 {
            // about the mirror or Snell direction, up to four deviations of the slopes
            let (r, psi) = (0.07 * f64::from(step), 2.4 * f64::from(step));
            let tilt = Vector3::new(r * psi.cos(), r * psi.sin(), 0.0) * alpha / 2f64.sqrt();
            let h = (Vector3::z() - tilt).normalize();
            let c = i.dot(&h);
            let o = if below {
                let eta = n_i / n_o;
                let inside = 1.0 + eta * eta * (c * c - 1.0);
                if inside < 0.0 {
                    continue;
                }
                h * (eta * c - inside.sqrt()) - i * eta
            } else {
                h * (2.0 * c) - i
            };
            let geometry = Geometry::on_plane(i, o, green())
                .unwrap()
                .between(n_i, n_o)
                .unwrap();
            let frames = RayFrames::of_surface(&geometry).unwrap();
            let f = surface
                .scattering_function(
                    &geometry,
                    &frames,
                    &IncidentCoherence::plane_wave(),
                    Tolerance::relative(1e-12).unwrap(),
                )
                .unwrap()
                .element(0, 0);
            let g = (geometry.normal_component() * relief.sigma).powi(2);
            let x = geometry.tangential().norm_squared() * relief.length.powi(2) / (4.0 * g);
            let ratio = f / microfacets(i, o, sides, alpha);
            worst = worst.max((ratio - 1.0 - (x * x - 4.0 * x + 2.0) / (2.0 * g)).abs() * g * g);
        }
    }
    worst
}

// The lobe is ⟨e^(−q/m)/m⟩ over the Poisson numbers m of mean g. Its series about m = g, with the central moments g, g,
// 3g² + g, is Beckmann's times 1 + P₂/2g + (P₃/6 + P₄/8)/g² + …, x = q/g = |φ_t|² l²/4g:
//     P₂ = x² − 4x + 2    P₃ = x³ − 9x² + 18x − 6    P₄ = x⁴ − 16x³ + 72x² − 96x + 24
// 1/g at the peak, 17/g four deviations out (x = 8). |P₃/6 + P₄/8| is at most 23 for x ≤ 9; g is 500 and more, and the
// next term, of the order of P₆/48g, x⁶/48g at most, is below 23 too.
const SECOND: f64 = 46.0;

#[test]
fn rough_reflection_is_that_of_microfacets() {
    let d = deviation(heights(3.0, 40.0), [1.0, 1.5], false, [1.0, 1.0]);
    assert!(d < SECOND, "{d}");
}

#[test]
fn rough_refraction_is_that_of_microfacets_both_ways() {
    let into = deviation(heights(8.0, 120.0), [1.0, 1.5], true, [1.0, 1.5]);
    assert!(into < SECOND, "{into}");
    let out = deviation(heights(8.0, 120.0), [1.5, 1.0], true, [1.5, 1.0]);
    assert!(out < SECOND, "{out}");
}

#[test]
fn smith_is_the_integral_over_the_slopes() {
    // Λ = (1/μ) ∫_μ^∞ (s − μ) p(s) ds, μ the cotangent, p the slopes along the azimuth (Smith 1967)
    let relief = heights(1.0, 5.0);
    let slopes = relief.slope_covariance().unwrap();
    let deviation = slopes.m11.sqrt();
    for degrees in [40.0, 70.0, 85.0, 89.0f64] {
        let cos = degrees.to_radians().cos();
        let mu = 1.0 / degrees.to_radians().tan();
        let steps = 200_000;
        let d = 10.0 * deviation / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|k| {
                let s = mu + (f64::from(k) + 0.5) * d;
                (s - mu) * (-0.5 * (s / deviation).powi(2)).exp() * d
            })
            .sum();
        let lambda = sum / (mu * deviation * (2.0 * PI).sqrt());
        let found = smith_beckmann(&slopes, cos, &Vector2::y());
        assert!(
            (found - 1.0 / (1.0 + lambda)).abs() < 1e-9,
            "{degrees}: {found}"
        );
    }
}
