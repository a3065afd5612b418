//! What is wrong in print: each printed formula of the supplemental fails here, and its correction holds.
//!
//! Both sides are compared with quadrature, finite differences or a field that is followed in time. "Fails" means by
//! more than 1 % of the right value, that is, by 13 orders of magnitude more than rounding.

mod functions;
mod polarization;
#[path = "../quadrature/mod.rs"]
mod quadrature;
mod shapes;
mod wigner;

/// Whether two numbers differ by more than 1 % of the first.
fn far_apart(right: num_complex::Complex64, printed: num_complex::Complex64) -> bool {
    (right - printed).norm() > 0.01 * right.norm()
}

/// The turn of the plane by an angle.
fn turn(angle: f64) -> nalgebra::Matrix2<f64> {
    let (sin, cos) = angle.sin_cos();
    nalgebra::Matrix2::new(cos, -sin, sin, cos)
}

/// Hessian at 0 by differences of fourth order.
fn hessian(f: impl Fn(&nalgebra::Vector2<f64>) -> f64, h: f64) -> nalgebra::Matrix2<f64> {
    let along = |x: f64, y: f64| {
        let at = |s: f64| f(&(nalgebra::Vector2::new(x, y) * s * h));
        (16.0 * (at(1.0) + at(-1.0)) - at(2.0) - at(-2.0) - 30.0 * at(0.0)) / (12.0 * h * h)
    };
    let xy = (along(1.0, 1.0) - along(1.0, -1.0)) / 4.0;
    nalgebra::Matrix2::new(along(1.0, 0.0), xy, xy, along(0.0, 1.0))
}
