//! Integrals over planes, and light and matter to try.

use mueller16::{Autocorrelation, Channels, GaussianTerm, Geometry};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, Mueller, ShapeMatrix, Wavelength,
    mode_count,
};

pub(crate) const MICRON: f64 = 1e-6;

/// An integral, and that of the modulus, to which its rounding is proportional.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Integral {
    pub(crate) value: Complex64,
    pub(crate) modulus: f64,
}

impl Integral {
    pub(crate) fn add(&mut self, value: Complex64) {
        self.value += value;
        self.modulus += value.norm();
    }

    /// Whether it is `expected`, up to `roundings · ε · ∫|f|`.
    pub(crate) fn is(&self, expected: f64, roundings: f64) -> bool {
        (self.value - expected).norm() <= roundings * f64::EPSILON * self.modulus
    }
}

/// `∫ f(x) d²x` by the trapezoidal rule with `2·half + 1` points along each column of `step`.
pub(crate) fn over_plane(
    half: i32,
    step: &Matrix2<f64>,
    f: impl Fn(&Vector2<f64>) -> Complex64,
) -> Integral {
    let area = step.determinant().abs();
    let mut sum = Integral::default();
    for i in -half..=half {
        // rows by themselves: a term is rounded 2(2·half + 1) times and not for each point
        let mut row = Integral::default();
        for j in -half..=half {
            row.add(f(&(step * Vector2::new(f64::from(i), f64::from(j)))) * area);
        }
        sum.value += row.value;
        sum.modulus += row.modulus;
    }
    sum
}

/// Nodes and weights of Gauss and Legendre on [-1, 1], by Newton's method.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..50 {
                let (mut p, mut last) = (x, 1.0);
                for k in 1..count {
                    let k = k as f64;
                    (p, last) = (((2.0 * k + 1.0) * x * p - k * last) / (k + 1.0), p);
                }
                slope = n * (x * p - last) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// `∫ f` over the rectangle of these half-widths, by 64 × 64 nodes.
pub(crate) fn over_rectangle(half: [f64; 2], f: impl Fn(&Vector2<f64>) -> f64) -> f64 {
    let nodes = gauss_legendre(64);
    let mut sum = 0.0;
    for (x, v) in &nodes {
        for (y, w) in &nodes {
            sum += v * w * f(&Vector2::new(x * half[0], y * half[1]));
        }
    }
    sum * half[0] * half[1]
}

/// `∫ f` over the disk, by 64 radii and 128 angles.
pub(crate) fn over_disk(radius: f64, f: impl Fn(&Vector2<f64>) -> f64) -> f64 {
    let nodes = gauss_legendre(64);
    let mut sum = 0.0;
    for (x, weight) in &nodes {
        let r = 0.5 * radius * (x + 1.0);
        for j in 0..128 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / 128.0).sin_cos();
            sum += weight * r * f(&Vector2::new(r * cos, r * sin));
        }
    }
    sum * 0.5 * radius * std::f64::consts::TAU / 128.0
}

pub(crate) fn green() -> Wavelength {
    Wavelength::from_metres(550e-9).unwrap()
}

/// The direction at the polar angle from the normal, both angles in degrees.
pub(crate) fn direction(polar: f64, azimuth: f64) -> Vector3<f64> {
    let ((sin, cos), (s, c)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    Vector3::new(sin * c, sin * s, cos)
}

/// Light from 33°, seen near the mirror direction, off it by this tangential wave vector in rad/m.
pub(crate) fn oblique(phi: [f64; 2]) -> Geometry {
    let to_source = direction(33.0, 20.0);
    Geometry::on_plane(to_source, direction(33.0, 200.0), green())
        .unwrap()
        .observed_at(&phi.into())
        .unwrap()
}

/// The frame of light that comes from the geometry's source, turned out of the plane of incidence.
pub(crate) fn incident_frame(geometry: &Geometry) -> Frame {
    Frame::with_x_across(-geometry.to_source(), geometry.normal())
        .unwrap()
        .turned(0.4)
}

pub(crate) fn outgoing_frame(geometry: &Geometry) -> Frame {
    Frame::with_x_across(geometry.to_observer(), geometry.normal())
        .unwrap()
        .turned(-0.7)
}

/// A series of all modes, odd ones too, with a positive value at 0.
pub(crate) fn series(order: usize, seed: f64) -> HermiteSeries {
    let real: Vec<f64> = (0..mode_count(order))
        .map(|i| {
            if i == 0 {
                2.0
            } else {
                (seed + 1.7 * i as f64).sin() / (1.0 + i as f64)
            }
        })
        .collect();
    HermiteSeries::from_real_coefficients(&real).unwrap()
}

/// A root over the transverse plane at a distance of 1 m: coherence over some ten microns in green light.
pub(crate) fn skew_root() -> Matrix2<f64> {
    Matrix2::new(6e-3, 2e-3, -3e-3, 5e-3)
}

pub(crate) fn light(geometry: &Geometry, components: Components) -> GeneralizedStokes {
    GeneralizedStokes::new(
        components,
        ShapeMatrix::from_root(&skew_root()).unwrap(),
        incident_frame(geometry),
        geometry.wavelength(),
        1.0,
    )
    .unwrap()
}

/// Four different series with odd orders in each.
pub(crate) fn lopsided() -> Components {
    Components::Separate([
        Some(series(5, 1.0)),
        Some(series(1, 0.2)),
        Some(series(4, -0.9)),
        Some(series(3, 2.2)),
    ])
}

/// A root of covariance in m, of about this size in microns, without symmetry.
pub(crate) fn root_of_size(microns: f64) -> Matrix2<f64> {
    Matrix2::new(1.1, -0.3, 0.4, 0.8) * (microns * MICRON)
}

/// A complex autocorrelation of two shapes: an order on each of two sides with a lobe about each, not alike.
pub(crate) fn blazed() -> Autocorrelation {
    let term = |weight, rate, x: f64, y: f64| GaussianTerm {
        weight,
        rate,
        shift: Vector2::new(x, y),
    };
    let narrow = [term(0.5, 1.0, 0.0, 0.0), term(0.3, 1.7, 9e4, -4e4)];
    let wide = [term(0.2, 1.0, -6e4, 3e4)];
    Autocorrelation::of_family(&root_of_size(9.0), narrow)
        .unwrap()
        .plus(&Autocorrelation::of_family(&root_of_size(4.0).transpose(), wide).unwrap())
}

/// Sixteen different numbers.
pub(crate) fn dense() -> Mueller {
    Mueller::from_rows([
        [1.0, 0.11, -0.12, 0.13],
        [0.21, 0.7, 0.22, -0.23],
        [-0.31, 0.32, -0.5, 0.33],
        [0.14, -0.24, 0.34, 0.4],
    ])
}

pub(crate) fn dense_channels() -> Channels {
    Channels::new(&dense(), blazed())
}
