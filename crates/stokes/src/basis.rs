//! The whitened orthonormal basis of the plane: all modes at a point, or at many points at once.
//!
//! ```text
//! φ_ab(w; W) = |det W|^(1/2) h_a(y1) h_b(y2),   y = W w,      ⟨φ_ab|φ_cd⟩ = δ_ac δ_bd
//! F{φ_ab(·; W)}(z) = 2π (−i)^(a+b) φ_ab(z; W^(−T))
//! ```
//!
//! Modes are numbered by total order n = a + b and then by b: (0,0), (1,0), (0,1), (2,0), (1,1), (0,2), … so that a
//! series of lower order is a prefix of one of higher order.

use nalgebra::Vector2;

use crate::hermite::{self, MAX_ORDER, Real};
use crate::shape::ShapeMatrix;

/// Number of modes with a + b ≤ `order`.
#[inline]
#[must_use]
pub const fn mode_count(order: usize) -> usize {
    (order + 1) * (order + 2) / 2
}

/// Place of mode (a, b) among the modes in order.
///
/// ```
/// assert_eq!(stokes::mode_index(0, 0), 0);
/// assert_eq!(stokes::mode_index(1, 1), 4);
/// ```
#[inline]
#[must_use]
pub const fn mode_index(a: usize, b: usize) -> usize {
    let n = a + b;
    n * (n + 1) / 2 + b
}

/// The pairs (a, b) with a + b ≤ `order`, in order.
pub fn modes(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=order).flat_map(|n| (0..=n).map(move |b| (n - b, b)))
}

/// One function of the whitened basis, `φ_ab(w; W)`, in the unit of `|det W|^(1/2)`.
///
/// `a` and `b` are the orders along the two whitened axes. Error as [`crate::hermite`], for any condition number of
/// the shape.
///
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// use stokes::{ShapeMatrix, whitened_mode};
/// let round = ShapeMatrix::from_root(&Matrix2::identity())?;
/// // φ_00(0) = π^(-1/2)
/// assert!((whitened_mode(0, 0, &round, &Vector2::zeros()) - 0.564_189_583_547_756_3).abs() < 1e-15);
/// # Ok::<(), stokes::ShapeError>(())
/// ```
#[must_use]
pub fn whitened_mode(a: usize, b: usize, shape: &ShapeMatrix, w: &Vector2<f64>) -> f64 {
    let y = shape.whiten(w);
    // the product of two functions may be a normal number although one of them is not
    let (first, second) = (
        hermite::hermite_scaled(a, y.x),
        hermite::hermite_scaled(b, y.y),
    );
    let mantissa = shape.root_determinant().sqrt() * first.mantissa * second.mantissa;
    libm::scalbn(mantissa, first.exponent + second.exponent)
}

/// All products `h_a(y1) h_b(y2)`, a + b ≤ `order`, at one point `y`, into `modes` in order.
///
/// `T` is `f32` or `f64`. Multiply by `|det W|^(1/2)` for `φ_ab`. No allocation.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `modes` does not have [`mode_count`]`(order)` places.
pub fn all_modes<T: Real>(order: usize, y: [T; 2], modes: &mut [T]) {
    assert!(
        order <= MAX_ORDER,
        "order {order}, expected at most {MAX_ORDER}"
    );
    assert_eq!(
        modes.len(),
        mode_count(order),
        "places for the modes of order {order}"
    );
    // h_b(y2) waits in the last total order, whose place (a, order − a) is overwritten when a is done
    let last = mode_index(order, 0);
    hermite::fill(y[1], &mut modes[last..]);
    let mut first = [T::zero(); MAX_ORDER + 1];
    hermite::fill(y[0], &mut first[..=order]);
    for (a, along) in first[..=order].iter().enumerate() {
        let mut place = mode_index(a, 0);
        for b in 0..=order - a {
            modes[place] = *along * modes[last + b];
            place += a + b + 2;
        }
    }
}
