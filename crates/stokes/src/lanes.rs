//! Hermite-Gauss functions and series at many points at once.
//!
//! Points are taken in blocks of eight, one a lane of `[T; 8]` arrays, whose loops the compiler turns into vector
//! code for whatever the build allows. Nothing is allocated. A block with a lane beyond [`Real::NEAR`] (or not a
//! number) takes the scalar road, so that every value is the scalar one, whatever its neighbours are.

use crate::basis::{by_order, mode_count, mode_index};
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
    hermite::fill(t, values.iter_mut());
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
        fill(block, table);
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
        fill(&block.map(|y| y[0]), &mut first[..=order]);
        fill(&block.map(|y| y[1]), &mut second[..=order]);
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
    let mut sum = T::zero();
    by_order!(order, sum_orders(coefficients, y, 1, |_, t| sum += t));
    sum
}

/// Calls `take(n, Σ_{a+b=n} s_ab h_a(y1) h_b(y2))` for n = 0, step, … up to `order`.
#[inline(always)]
pub(crate) fn sum_orders<T: Real, const SIZE: usize>(
    order: usize,
    coefficients: &[T],
    y: [T; 2],
    step: usize,
    mut take: impl FnMut(usize, T),
) {
    let (mut first, mut second) = ([T::zero(); SIZE], [T::zero(); SIZE]);
    hermite::fill(y[0], first[..=order].iter_mut().rev());
    hermite::fill(y[1], second[..=order].iter_mut());
    for n in (0..=order).step_by(step) {
        let s = &coefficients[mode_index(n, 0)..mode_count(n)];
        take(n, triple_sum(s, &first[order - n..=order], &second[..=n]));
    }
}

/// `Σ s_i x_i y_i` in four chains, which do not wait for each other.
#[inline(always)]
fn triple_sum<T: Real>(s: &[T], x: &[T], y: &[T]) -> T {
    let ((s, s_rest), (x, x_rest), (y, y_rest)) =
        (s.as_chunks::<4>(), x.as_chunks::<4>(), y.as_chunks::<4>());
    let mut chains = [T::zero(); 4];
    for ((s, x), y) in s.iter().zip(x).zip(y) {
        for l in 0..4 {
            chains[l] += s[l] * x[l] * y[l];
        }
    }
    for (l, ((s, x), y)) in s_rest.iter().zip(x_rest).zip(y_rest).enumerate() {
        chains[l] += *s * *x * *y;
    }
    (chains[0] + chains[2]) + (chains[1] + chains[3])
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
        fill(&block.map(|y| y[0]), &mut first[..=order]);
        fill(&block.map(|y| y[1]), &mut second[..=order]);
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

/// `h_0 …` of eight arguments.
#[inline(always)]
fn fill<T: Real>(t: &Lanes<T>, values: &mut [Lanes<T>]) {
    if !t.iter().fold(true, |near, t| near & (t.abs() <= T::NEAR)) {
        return fill_far(t, values);
    }
    let (mut before, mut now) = ([T::zero(); LANES], t.map(T::gaussian));
    let Some((start, rest)) = values.split_first_mut() else {
        return;
    };
    *start = now;
    for (value, [up, down]) in rest.iter_mut().zip(T::steps()) {
        let mut next = [T::zero(); LANES];
        for l in 0..LANES {
            next[l] = *up * t[l] * now[l] - *down * before[l];
        }
        *value = next;
        (before, now) = (now, next);
    }
}

/// The same, one lane after the other.
#[cold]
fn fill_far<T: Real>(t: &Lanes<T>, values: &mut [Lanes<T>]) {
    let mut column = [T::zero(); MAX_ORDER + 1];
    let column = &mut column[..values.len()];
    for (l, t) in t.iter().enumerate() {
        hermite::fill(*t, column.iter_mut());
        for (value, h) in values.iter_mut().zip(&*column) {
            value[l] = *h;
        }
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
