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

/// Number of modes with a + b ≤ `order`, `(order + 1)(order + 2)/2`.
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
///
/// ```
/// let pairs: Vec<_> = stokes::modes(2).collect();
/// assert_eq!(pairs, [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]);
/// ```
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

/// Scratch for any order, and for the rest of the last group of four.
pub(crate) const LARGEST: usize = MAX_ORDER + 4;

/// Calls a function with the order and a constant that exceeds it, the size of its scratch: filling 257 places costs
/// more than a low order itself. Up to order 8 the compiler knows the order, too; beyond, the size exceeds it by 4.
macro_rules! by_order {
    ($order:expr, $function:ident ($($argument:expr),*)) => {
        match $order {
            0 => $function::<_, 1>(0, $($argument),*),
            1 => $function::<_, 2>(1, $($argument),*),
            2 => $function::<_, 3>(2, $($argument),*),
            3 => $function::<_, 4>(3, $($argument),*),
            4 => $function::<_, 5>(4, $($argument),*),
            5 => $function::<_, 6>(5, $($argument),*),
            6 => $function::<_, 7>(6, $($argument),*),
            7 => $function::<_, 8>(7, $($argument),*),
            8 => $function::<_, 9>(8, $($argument),*),
            order @ 9..17 => apart(|| $function::<_, 20>(order, $($argument),*)),
            order @ 17..33 => apart(|| $function::<_, 36>(order, $($argument),*)),
            order @ 33..65 => apart(|| $function::<_, 68>(order, $($argument),*)),
            order => apart(|| $function::<_, LARGEST>(order, $($argument),*)),
        }
    };
}
pub(crate) use by_order;

/// Calls a function whose stack shall not burden its neighbours.
#[inline(never)]
pub(crate) fn apart<R>(function: impl FnOnce() -> R) -> R {
    function()
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
    if hermite::near(&y) {
        let start = hermite::gaussians(&y);
        let fill = |h: &mut [_]| hermite::fill_near(&y, &start, h);
        by_order!(order, all_modes_sized(fill, modes));
    } else {
        let fill = |h: &mut [_]| hermite::fill_lanes(&y, h);
        apart(|| all_modes_sized::<T, LARGEST>(order, fill, modes));
    }
}

#[inline(always)]
fn all_modes_sized<T: Real, const SIZE: usize>(
    order: usize,
    fill: impl Fn(&mut [[T; 2]]),
    modes: &mut [T],
) {
    let mut h = [[T::zero(); 2]; SIZE];
    fill(&mut h[..=order]);
    let modes = &mut modes[..mode_count(order)];
    if order <= 8 {
        // half-open ranges: the compiler unrolls them
        for n in 0..order + 1 {
            for b in 0..n + 1 {
                modes[mode_index(n - b, b)] = h[n - b][0] * h[b][1];
            }
        }
        return;
    }
    // the first axis backwards, so that a total order is the product of two slices
    let (mut first, mut second) = ([T::zero(); SIZE], [T::zero(); SIZE]);
    for n in 0..order + 1 {
        first[order - n] = h[n][0];
        second[n] = h[n][1];
    }
    // in groups of four; what a group writes too many is overwritten by the next total order
    let mut place = 0;
    for n in 0..order {
        let along = first[order - n..].as_chunks::<4>().0;
        let across = second.as_chunks::<4>().0;
        let groups = modes[place..].as_chunks_mut::<4>().0.iter_mut();
        for ((group, along), across) in groups.zip(along).zip(&across[..n / 4 + 1]) {
            *group = std::array::from_fn(|l| along[l] * across[l]);
        }
        place += n + 1;
    }
    for ((mode, along), across) in modes[place..].iter_mut().zip(&first).zip(&second) {
        *mode = *along * *across;
    }
}
