//! Hermite-Gauss functions and series at many points at once.
//!
//! Points are taken in blocks of eight, one a lane of `[T; 8]` arrays, whose loops the compiler turns into vector
//! code for whatever the build allows. Nothing is allocated. A block with a lane beyond [`Real::NEAR`] (or not a
//! number) takes the scalar road, so that every value is the scalar one, whatever its neighbours are.

use crate::basis::{mode_count, mode_index};
use crate::hermite::{self, MAX_ORDER, Real};

/// Points of a block.
const LANES: usize = 8;

type Lanes<T> = [T; LANES];

/// Calls a function with a scratch size near what the order needs: filling 257 places costs more than a low order.
macro_rules! by_order {
    ($order:expr, $function:ident $arguments:tt) => {
        match $order {
            0..5 => $function::<_, 5> $arguments,
            5..9 => $function::<_, 9> $arguments,
            9..17 => $function::<_, 17> $arguments,
            17..33 => $function::<_, 33> $arguments,
            33..65 => $function::<_, 65> $arguments,
            _ => $function::<_, { MAX_ORDER + 1 }> $arguments,
        }
    };
}

fn check(order: usize, found: usize, expected: usize, what: &str) {
    assert!(order <= MAX_ORDER, "order {order}, expected at most {MAX_ORDER}");
    assert_eq!(found, expected, "{what} of order {order}");
}

/// The functions `h_0(t) … h_order(t)` at one argument, into `values`, dimensionless.
pub fn hermite_all<T: Real>(order: usize, t: T, values: &mut [T]) {
    check(order, values.len(), order + 1, "places for the functions");
    hermite::fill(t, values);
}

/// The functions `h_0 … h_order` at many arguments: `h_n` of argument p into `values[n * arguments.len() + p]`.
pub fn hermite_all_at<T: Real>(order: usize, arguments: &[T], values: &mut [T]) {
    let count = arguments.len();
    check(order, values.len(), (order + 1) * count, "places for the functions");
    by_order!(order, hermite_all_sized(order, arguments, values));
}

fn hermite_all_sized<T: Real, const SIZE: usize>(order: usize, arguments: &[T], values: &mut [T]) {
    let mut table = [[T::zero(); LANES]; SIZE];
    for (block, start) in arguments.chunks(LANES).zip((0..).step_by(LANES)) {
        let table = &mut table[..=order];
        fill(&padded(block), table);
        for (row, lanes) in values.chunks_exact_mut(arguments.len()).zip(&*table) {
            put(lanes, &mut row[start..start + block.len()]);
        }
    }
}

/// All products `h_a(y1) h_b(y2)`, a + b ≤ `order`, at many points: mode i of point p into
/// `modes[i * points.len() + p]`.
pub fn all_modes_at<T: Real>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let count = points.len();
    check(order, modes.len(), mode_count(order) * count, "places for the modes");
    by_order!(order, all_modes_sized(order, points, modes));
}

fn all_modes_sized<T: Real, const SIZE: usize>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let mut first = [[T::zero(); LANES]; SIZE];
    let mut second = [[T::zero(); LANES]; SIZE];
    for (block, start) in points.chunks(LANES).zip((0..).step_by(LANES)) {
        let [y1, y2] = axes(block);
        fill(&y1, &mut first[..=order]);
        fill(&y2, &mut second[..=order]);
        let mut rows = modes.chunks_exact_mut(points.len());
        for n in 0..=order {
            for ((along, across), row) in first[..=n].iter().rev().zip(&second).zip(&mut rows) {
                put(&product(along, across), &mut row[start..start + block.len()]);
            }
        }
    }
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at one point `y`.
pub fn contract<T: Real>(order: usize, coefficients: &[T], y: [T; 2]) -> T {
    check(order, coefficients.len(), mode_count(order), "coefficients");
    by_order!(order, contract_sized(order, coefficients, y))
}

fn contract_sized<T: Real, const SIZE: usize>(order: usize, coefficients: &[T], y: [T; 2]) -> T {
    let (mut first, mut second) = ([T::zero(); SIZE], [T::zero(); SIZE]);
    hermite::fill(y[0], &mut first[..=order]);
    hermite::fill(y[1], &mut second[..=order]);
    let mut sum = T::zero();
    for (b, across) in second[..=order].iter().enumerate() {
        let mut place = mode_index(0, b);
        let mut along_axis = T::zero();
        for (a, along) in first[..=order - b].iter().enumerate() {
            along_axis += coefficients[place] * *along;
            place += a + b + 1;
        }
        sum += along_axis * *across;
    }
    sum
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at many points `y`.
pub fn contract_at<T: Real>(order: usize, coefficients: &[T], points: &[[T; 2]], sums: &mut [T]) {
    check(order, coefficients.len(), mode_count(order), "coefficients");
    check(order, sums.len(), points.len(), "places for the sums");
    by_order!(order, contract_at_sized(order, coefficients, points, sums));
}

fn contract_at_sized<T: Real, const SIZE: usize>(
    order: usize,
    coefficients: &[T],
    points: &[[T; 2]],
    sums: &mut [T],
) {
    let mut first = [[T::zero(); LANES]; SIZE];
    let mut second = [[T::zero(); LANES]; SIZE];
    for (block, sums) in points.chunks(LANES).zip(sums.chunks_mut(LANES)) {
        let [y1, y2] = axes(block);
        fill(&y1, &mut first[..=order]);
        fill(&y2, &mut second[..=order]);
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
        put(&sum, sums);
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
        hermite::fill(*t, column);
        for (value, h) in values.iter_mut().zip(&*column) {
            value[l] = *h;
        }
    }
}

#[inline(always)]
fn product<T: Real>(x: &Lanes<T>, y: &Lanes<T>) -> Lanes<T> {
    std::array::from_fn(|l| x[l] * y[l])
}

/// A block's arguments, with zeros in the lanes that it does not fill.
#[inline(always)]
fn padded<T: Real>(block: &[T]) -> Lanes<T> {
    let mut lanes = [T::zero(); LANES];
    lanes[..block.len()].copy_from_slice(block);
    lanes
}

/// The two coordinates of a block's points, with zeros in the lanes that it does not fill.
#[inline(always)]
fn axes<T: Real>(block: &[[T; 2]]) -> [Lanes<T>; 2] {
    let mut axes = [[T::zero(); LANES]; 2];
    for (l, y) in block.iter().enumerate() {
        axes[0][l] = y[0];
        axes[1][l] = y[1];
    }
    axes
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
