//! Integrals over the plane by the trapezoidal rule.
//!
//! For a polynomial times a Gaussian of width 1 in whitened coordinates `y` the rule with step ¼ out to |y| = 12 is
//! exact to rounding: what it neglects is below `e^(−72)` in space and `e^(−200)` in frequency, for the orders up
//! to 12 and frequencies up to 4 that occur here.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

/// An integral, and that of the modulus, to which its rounding error is proportional.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integral {
    pub(crate) value: Complex64,
    pub(crate) modulus: f64,
}

impl Integral {
    /// Whether the value is `expected`, up to `factor · ε · ∫|f|`.
    pub(crate) fn is(&self, expected: Complex64, factor: f64) -> bool {
        (self.value - expected).norm() <= factor * f64::EPSILON * self.modulus
    }
}

/// The points `x = l y` of the rule, and the area that each stands for.
pub(crate) fn points(l: &Matrix2<f64>) -> (Vec<Vector2<f64>>, f64) {
    const STEP: f64 = 0.25;
    const HALF: i32 = 48;
    let points = (-HALF..=HALF).flat_map(|i| {
        (-HALF..=HALF).map(move |j| l * Vector2::new(f64::from(i), f64::from(j)) * STEP)
    });
    (points.collect(), l.determinant().abs() * STEP * STEP)
}

/// `∫ f(x) d²x` on the points `x = l y`.
pub(crate) fn integral(l: &Matrix2<f64>, f: impl Fn(&Vector2<f64>) -> Complex64) -> Integral {
    let (points, area) = points(l);
    let mut sum = Integral {
        value: Complex64::ZERO,
        modulus: 0.0,
    };
    for x in &points {
        let value = f(x) * area;
        sum.value += value;
        sum.modulus += value.norm();
    }
    sum
}

/// `∫ f(x) e^(−iζ·x) d²x` on the points `x = l y`.
pub(crate) fn fourier(
    l: &Matrix2<f64>,
    zeta: &Vector2<f64>,
    f: impl Fn(&Vector2<f64>) -> Complex64,
) -> Integral {
    integral(l, |x| f(x) * Complex64::new(0.0, -zeta.dot(x)).exp())
}

/// A matrix `l` and `Θ = l lᵀ`, whose axes have variances `scale·√cond` and `scale/√cond` and are turned by `angle`.
pub(crate) fn shape(angle: f64, scale: f64, condition: f64) -> (Matrix2<f64>, Matrix2<f64>) {
    let (sin, cos) = angle.sin_cos();
    let stretch = condition.sqrt().sqrt();
    let l = Matrix2::new(cos, -sin, sin, cos)
        * Matrix2::new(stretch, 0.0, 0.0, 1.0 / stretch)
        * scale.sqrt();
    let theta = l * l.transpose();
    (l, Matrix2::new(theta.m11, theta.m12, theta.m12, theta.m22))
}
