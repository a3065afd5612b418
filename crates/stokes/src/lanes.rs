//! Hermite-Gauss functions and series at many points at once.
//!
//! Points are taken in blocks of eight, one a lane of `[T; 8]` arrays, whose loops the compiler turns into vector
//! code for whatever the build allows. Nothing is allocated. A block with a lane beyond [`Real::NEAR`] (or not a
//! number) takes the scalar road, so that every value is the scalar one, whatever its neighbours are.

use crate::basis::{apart, by_order, mode_count, mode_index};
use crate::hermite::{self, MAX_ORDER, Real};

/// Points of a block.
const LANES: usize = 8;

type Lanes<T> = [T; LANES];

fn check(order: usize, found: usize, expected: usize, what: &str) {
    assert!(order <= MAX_ORDER, "order {order}, expected at most {MAX_ORDER}");
    assert_eq!(found, expected, "{what} of order {order}");
}

/// The functions `h_0(t) … h_order(t)` at one argument, into `values`, dimensionless.
pub fn hermite_all<T: Real>(order: usize, t: T, values: &mut [T]) {
    check(order, values.len(), order + 1, "places for the functions");
    hermite::fill(&[t], values.as_chunks_mut().0);
}

/// The functions `h_0 … h_order` at many arguments: `h_n` of argument p into `values[n * arguments.len() + p]`.
pub fn hermite_all_at<T: Real>(order: usize, arguments: &[T], values: &mut [T]) {
    let count = arguments.len();
    check(order, values.len(), (order + 1) * count, "places for the functions");
    by_order!(order, hermite_all_sized(arguments, values));
}

#[inline(always)]
fn hermite_all_sized<T: Real, const SIZE: usize>(order: usize, arguments: &[T], values: &mut [T]) {
    let mut table = [[T::zero(); LANES]; SIZE];
    let table = &mut table[..=order];
    each_block(arguments, |start, count, block| {
        hermite::fill(block, table);
        for (row, lanes) in values.chunks_exact_mut(arguments.len()).zip(&*table) {
            put(lanes, &mut row[start..start + count]);
        }
    });
}

/// All products `h_a(y1) h_b(y2)`, a + b ≤ `order`, at many points: mode i of point p into
/// `modes[i * points.len() + p]`.
pub fn all_modes_at<T: Real>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let count = points.len();
    check(order, modes.len(), mode_count(order) * count, "places for the modes");
    by_order!(order, all_modes_sized(points, modes));
}

#[inline(always)]
fn all_modes_sized<T: Real, const SIZE: usize>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let mut first = [[T::zero(); LANES]; SIZE];
    let mut second = [[T::zero(); LANES]; SIZE];
    each_block(points, |start, count, block| {
        hermite::fill(&block.map(|y| y[0]), &mut first[..=order]);
        hermite::fill(&block.map(|y| y[1]), &mut second[..=order]);
        let mut rows = modes.chunks_exact_mut(points.len());
        for n in 0..=order {
            for ((along, across), row) in first[..=n].iter().rev().zip(&second).zip(&mut rows) {
                let product = std::array::from_fn(|l| along[l] * across[l]);
                put(&product, &mut row[start..start + count]);
            }
        }
    });
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at one point `y`.
pub fn contract<T: Real>(order: usize, coefficients: &[T], y: [T; 2]) -> T {
    check(order, coefficients.len(), mode_count(order), "coefficients");
    let [even, odd] = parity_sums(order, coefficients, y, true, false);
    even + odd
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over even and over odd total orders n = a + b; the latter is 0 without `odd`.
///
/// With `turned` every order has the factor `(−1)^⌊n/2⌋`, so that the sums are real and imaginary part of the sum
/// with the factors `i^n`.
#[inline(always)]
pub(crate) fn parity_sums<T: Real>(
    order: usize,
    coefficients: &[T],
    y: [T; 2],
    odd: bool,
    turned: bool,
) -> [T; 2] {
    if hermite::near(&y) {
        let start = hermite::gaussians(&y);
        let fill = |h: &mut [_]| hermite::fill_near(&y, &start, h);
        by_order!(order, parity_sums_sized(fill, coefficients, odd, turned))
    } else {
        const SIZE: usize = MAX_ORDER + 1;
        let fill = |h: &mut [_]| hermite::fill(&y, h);
        apart(|| parity_sums_sized::<T, SIZE>(order, fill, coefficients, odd, turned))
    }
}

#[inline(always)]
fn parity_sums_sized<T: Real, const SIZE: usize>(
    order: usize,
    fill: impl Fn(&mut [[T; 2]]),
    coefficients: &[T],
    odd: bool,
    turned: bool,
) -> [T; 2] {
    let mut h = [[T::zero(); 2]; SIZE];
    fill(&mut h[..=order]);
    // h_a backwards, so that the modes of a total order are products of two slices
    let mut first = [T::zero(); SIZE];
    for n in 0..order + 1 {
        first[order - n] = h[n][0];
    }
    let coefficients = &coefficients[..mode_count(order)];
    let mut sums = [T::zero(); 2];
    for (parity, sum) in sums.iter_mut().enumerate().take(1 + usize::from(odd)) {
        // for every b the sum over a
        let mut along = [T::zero(); SIZE];
        for n in (parity..order + 1).step_by(2) {
            let s = &coefficients[mode_index(n, 0)..mode_count(n)];
            let terms = along[..=n].iter_mut().zip(s).zip(&first[order - n..=order]);
            if turned && n % 4 >= 2 {
                terms.for_each(|((along, s), h)| *along = *along - *s * *h);
            } else {
                terms.for_each(|((along, s), h)| *along += *s * *h);
            }
        }
        for (along, h) in along[..=order].iter().zip(&h) {
            *sum += *along * h[1];
        }
    }
    sums
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at many points `y`.
pub fn contract_at<T: Real>(order: usize, coefficients: &[T], points: &[[T; 2]], sums: &mut [T]) {
    check(order, coefficients.len(), mode_count(order), "coefficients");
    check(order, sums.len(), points.len(), "places for the sums");
    by_order!(order, contract_at_sized(coefficients, points, sums));
}

#[inline(always)]
fn contract_at_sized<T: Real, const SIZE: usize>(
    order: usize,
    coefficients: &[T],
    points: &[[T; 2]],
    sums: &mut [T],
) {
    let mut first = [[T::zero(); LANES]; SIZE];
    let mut second = [[T::zero(); LANES]; SIZE];
    each_block(points, |start, count, block| {
        hermite::fill(&block.map(|y| y[0]), &mut first[..=order]);
        hermite::fill(&block.map(|y| y[1]), &mut second[..=order]);
        let mut sum = [T::zero(); LANES];
        for (b, across) in second[..=order].iter().enumerate() {
            let mut place = mode_index(0, b);
            let mut along_axis = [T::zero(); LANES];
            for (a, along) in first[..=order - b].iter().enumerate() {
                let s = coefficients[place];
                for l in 0..LANES {
                    along_axis[l] += s * along[l];
                }
                place += a + b + 1;
            }
            for l in 0..LANES {
                sum[l] += along_axis[l] * across[l];
            }
        }
        put(&sum, &mut sums[start..start + count]);
    });
}

/// Calls `take(start, count, block)` for every block of eight, the last one filled up with zeros.
#[inline(always)]
fn each_block<P: Copy + Default>(points: &[P], mut take: impl FnMut(usize, usize, &[P; LANES])) {
    let (blocks, rest) = points.as_chunks();
    for (block, start) in blocks.iter().zip((0..).step_by(LANES)) {
        take(start, LANES, block);
    }
    if !rest.is_empty() {
        let mut block = [P::default(); LANES];
        block[..rest.len()].copy_from_slice(rest);
        take(points.len() - rest.len(), rest.len(), &block);
    }
}

/// The lanes into a block's places.
#[inline(always)]
fn put<T: Real>(lanes: &Lanes<T>, places: &mut [T]) {
    if let Ok(whole) = <&mut Lanes<T>>::try_from(&mut *places) {
        *whole = *lanes;
    } else {
        places.copy_from_slice(&lanes[..places.len()]);
    }
}
