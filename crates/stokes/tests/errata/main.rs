//! What is wrong in print: each printed formula of the supplemental fails here, and its correction holds.
//!
//! Both sides are compared with quadrature, finite differences or a field that is followed in time. "Fails" means by
//! more than 1 % of the right value, that is, by 13 orders of magnitude more than rounding.

#[path = "../differences/mod.rs"]
mod differences;
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
