//! Hermite-Gauss functions and series at many points at once.
//!
//! Points are taken in blocks of eight, one a lane of `[T; 8]` arrays, whose loops the compiler turns into vector
//! code for whatever the build allows. Nothing is allocated. A block with a lane beyond [`Real::NEAR`] (or not a
//! number) takes the scalar road, so that every value is the scalar one, whatever its neighbours are.

use crate::basis::{LARGEST, apart, by_order, mode_count, mode_index};
use crate::hermite::{self, MAX_ORDER, Real};

/// Points of a block.
const LANES: usize = 8;

type Lanes<T> = [T; LANES];

fn check(order: usize, found: usize, expected: usize, what: &str) {
    assert!(
        order <= MAX_ORDER,
        "order {order}, expected at most {MAX_ORDER}"
    );
    assert_eq!(found, expected, "{what} of order {order}");
}

/// The functions `h_0(t) … h_order(t)` at one argument, into `values`, dimensionless.
///
/// Source: Eq. (S1.1). Each is [`crate::hermite`]'s number, bit by bit. No allocation.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `values` does not have `order + 1` places.
pub fn hermite_all<T: Real>(order: usize, t: T, values: &mut [T]) {
    check(order, values.len(), order + 1, "places for the functions");
    hermite::fill(t, values);
}

/// The functions `h_0 … h_order` at many arguments: `h_n` of argument p into `values[n * arguments.len() + p]`.
///
/// Dimensionless; each is [`crate::hermite`]'s number, bit by bit. No allocation.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `values` does not have `(order + 1) * arguments.len()` places.
pub fn hermite_all_at<T: Real>(order: usize, arguments: &[T], values: &mut [T]) {
    let count = arguments.len();
    check(
        order,
        values.len(),
        (order + 1) * count,
        "places for the functions",
    );
    by_order!(order, hermite_all_sized(arguments, values));
}

#[inline(always)]
fn hermite_all_sized<T: Real, const SIZE: usize>(order: usize, arguments: &[T], values: &mut [T]) {
    let mut table = [[T::zero(); LANES]; SIZE];
    let table = &mut table[..order + 1];
    each_block(arguments.as_chunks::<1>().0, |start, block| {
        fill(block, [table]);
        for (row, lanes) in values.chunks_exact_mut(arguments.len()).zip(&*table) {
            put(lanes, row, start);
        }
    });
}

/// All products `h_a(y1) h_b(y2)`, a + b ≤ `order`, at many points: mode i of point p into
/// `modes[i * points.len() + p]`.
///
/// Dimensionless; each is [`crate::all_modes`]' number, bit by bit. No allocation. Meant for batches whose modes stay
/// in the nearest cache, such as the wavelengths of a path.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `modes` does not have [`mode_count`]`(order) * points.len()` places.
///
/// ```
/// let mut modes = [0.0; 3 * 2];
/// stokes::all_modes_at(1, &[[0.0, 0.0], [1.0, 0.0]], &mut modes);
/// // mode (1, 0) is √(2/π) y1 e^(−|y|²/2): 0 at the first point, 0.4839 at the second
/// assert_eq!(modes[2], 0.0);
/// assert!((modes[3] - 0.483_941_449_038_286_7_f64).abs() < 1e-15);
/// ```
pub fn all_modes_at<T: Real>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let count = points.len();
    check(
        order,
        modes.len(),
        mode_count(order) * count,
        "places for the modes",
    );
    by_order!(order, all_modes_sized(points, modes));
}

#[inline(always)]
fn all_modes_sized<T: Real, const SIZE: usize>(order: usize, points: &[[T; 2]], modes: &mut [T]) {
    let mut first = [[T::zero(); LANES]; SIZE];
    let mut second = [[T::zero(); LANES]; SIZE];
    let count = points.len();
    each_block(points, |start, block| {
        fill(block, [&mut first[..order + 1], &mut second[..order + 1]]);
        if count < LANES {
            return put_few(&first[..order + 1], &second, count, modes);
        }
        let mut place = start;
        for n in 0..order + 1 {
            for b in 0..n + 1 {
                let (along, across) = (&first[n - b], &second[b]);
                let product: Lanes<T> = std::array::from_fn(|l| along[l] * across[l]);
                modes[place..place + LANES].copy_from_slice(&product);
                place += count;
            }
        }
    });
}

/// The modes of fewer than eight points.
#[inline(never)]
fn put_few<T: Real>(first: &[Lanes<T>], second: &[Lanes<T>], count: usize, modes: &mut [T]) {
    let mut rows = modes.chunks_exact_mut(count);
    for n in 0..first.len() {
        for ((along, across), row) in first[..=n].iter().rev().zip(second).zip(&mut rows) {
            for ((mode, along), across) in row.iter_mut().zip(along).zip(across) {
                *mode = *along * *across;
            }
        }
    }
}

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at one point `y`.
///
/// In the unit of the coefficients, which stand in the order of [`crate::modes`]; the Wigner function of a
/// [`crate::HermiteSeries`]. Error at most `(order + 2.5) ε Σ|s_ab h_a h_b|`, `ε` that of `T`, beside that of the
/// functions themselves ([`crate::hermite`]). No allocation.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `coefficients` are not [`mode_count`]`(order)` numbers.
///
/// ```
/// // 1/√π at 0, where odd modes vanish
/// assert!((stokes::contract(1, &[1.0, 5.0, 7.0], [0.0, 0.0]) - 0.564_189_583_547_756_3_f64).abs() < 1e-15);
/// ```
#[must_use]
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
        let fill = |h: &mut [_]| hermite::fill_lanes(&y, h);
        apart(|| parity_sums_sized::<T, LARGEST>(order, fill, coefficients, odd, turned))
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

/// The sum `Σ s_ab h_a(y1) h_b(y2)` over a + b ≤ `order` at many points `y`, into `sums`.
///
/// As [`contract`], with the same bound on the error; the last digits may differ from it. No allocation.
///
/// # Panics
///
/// When `order` exceeds [`MAX_ORDER`] or `coefficients` are not [`mode_count`]`(order)` numbers or `sums` not as many as `points`.
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
    let coefficients = &coefficients[..mode_count(order)];
    each_block(points, |start, block| {
        fill(block, [&mut first[..order + 1], &mut second[..order + 1]]);
        let mut sum = [T::zero(); LANES];
        for b in 0..order + 1 {
            let mut along = [T::zero(); LANES];
            for a in 0..order - b + 1 {
                let s = coefficients[mode_index(a, b)];
                for l in 0..LANES {
                    along[l] += s * first[a][l];
                }
            }
            for l in 0..LANES {
                sum[l] += along[l] * second[b][l];
            }
        }
        put(&sum, sums, start);
    });
}

/// Calls `take(start, block)` for blocks of eight. The last one begins earlier where the number is no multiple of
/// eight, so that some points are done twice; fewer than eight are filled up with zeros.
#[inline(always)]
fn each_block<P: Copy + Default>(points: &[P], mut take: impl FnMut(usize, &[P; LANES])) {
    let count = points.len();
    let mut filled_up = [P::default(); LANES];
    let points = if count < LANES {
        filled_up[..count].copy_from_slice(points);
        &filled_up
    } else {
        points
    };
    let last = points.len() - LANES;
    for start in (0..count).step_by(LANES) {
        let start = start.min(last);
        if let Some(block) = points[start..].first_chunk() {
            take(start, block);
        }
    }
}

/// `h_0 …` of the coordinates of eight points, `D` numbers a point, into tables of one row an order.
#[inline(always)]
fn fill<T: Real, const D: usize>(points: &[[T; D]; LANES], tables: [&mut [Lanes<T>]; D]) {
    let mut start = [[[T::zero(); LANES]; 2]; D];
    let near = starts(points, &mut start);
    for (table, [t, start]) in tables.into_iter().zip(&start) {
        if near {
            hermite::fill_near(t, start, table);
        } else {
            hermite::fill_lanes(t, table);
        }
    }
}

/// Coordinates by axis with their `h_0`, and whether all are near enough for it. A loop of its own, since the
/// compiler then turns the points into vectors by shuffles and not by way of memory.
#[inline(never)]
fn starts<T: Real, const D: usize>(
    points: &[[T; D]; LANES],
    start: &mut [[Lanes<T>; 2]; D],
) -> bool {
    for l in 0..LANES {
        for axis in 0..D {
            let t = points[l][axis];
            start[axis][0][l] = t;
            start[axis][1][l] = t.gaussian();
        }
    }
    start.iter().all(|[t, _]| hermite::near(t))
}

/// The lanes into the places from `start`, or as many as there are.
#[inline(always)]
fn put<T: Real>(lanes: &Lanes<T>, row: &mut [T], start: usize) {
    if let Some(places) = row[start..].first_chunk_mut() {
        *places = *lanes;
    } else {
        put_some(lanes, row);
    }
}

#[cold]
#[inline(never)]
fn put_some<T: Real>(lanes: &Lanes<T>, row: &mut [T]) {
    row.copy_from_slice(&lanes[..row.len()]);
}
