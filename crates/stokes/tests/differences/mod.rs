//! Derivatives by differences.

use nalgebra::{Matrix2, Vector2};

/// Hessian at 0 by differences of fourth order with steps of `h`.
pub(crate) fn hessian_at_0(f: impl Fn(&Vector2<f64>) -> f64, h: f64) -> Matrix2<f64> {
    let along = |x: f64, y: f64| {
        let at = |s: f64| f(&(Vector2::new(x, y) * s * h));
        (16.0 * (at(1.0) + at(-1.0)) - at(2.0) - at(-2.0) - 30.0 * at(0.0)) / (12.0 * h * h)
    };
    let xy = (along(1.0, 1.0) - along(1.0, -1.0)) / 4.0;
    Matrix2::new(along(1.0, 0.0), xy, xy, along(0.0, 1.0))
}
