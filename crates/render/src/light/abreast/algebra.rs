//! Products of Mueller matrices, Stokes vectors and rows, a path a lane.

use super::{Elements, Shine};
use crate::lanes::{Real, V3};

/// A 4×4 matrix a lane, by columns.
pub(super) type Matrices<R> = [[R; 4]; 4];

/// cos 2θ and sin 2θ of the angles from `from` to `to`, counter-clockwise about `k`; all unit, across `k`.
#[inline(always)]
pub(super) fn double_angles<R: Real>(from: V3<R>, to: V3<R>, k: V3<R>) -> (R, R) {
    let c = from.dot(to);
    let s = k.cross(from).dot(to);
    // normalised: the axes are perpendicular to k only up to rounding, so that 2 − n is 1/n
    let norm = R::splat(2.0) - (c * c + s * s);
    ((c * c - s * s) * norm, (c + c) * s * norm)
}

/// A column with its linear part turned out of the frame of the double angle (c, s).
#[inline(always)]
pub(super) fn turned_vector<R: Real>(v: [R; 4], (c, s): (R, R)) -> [R; 4] {
    [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2], v[3]]
}

/// A row with its linear part turned into the frame of the double angle (c, s).
#[inline(always)]
pub(super) fn turned_row<R: Real>(r: [R; 4], (c, s): (R, R)) -> [R; 4] {
    [r[0], c * r[1] + s * r[2], c * r[2] - s * r[1], r[3]]
}

#[inline(always)]
pub(super) fn turned_columns<R: Real>(m: &Matrices<R>, (c, s): (R, R)) -> Matrices<R> {
    let mut turned = *m;
    for row in 0..4 {
        turned[1][row] = c * m[1][row] + s * m[2][row];
        turned[2][row] = c * m[2][row] - s * m[1][row];
    }
    turned
}

/// A row times an element.
#[inline(always)]
pub(super) fn row_times_element<R: Real>(r: [R; 4], e: &Elements<R>) -> [R; 4] {
    [
        e.mean * r[0] + e.difference * r[1],
        e.difference * r[0] + e.mean * r[1],
        e.cosine * r[2] - e.sine * r[3],
        e.sine * r[2] + e.cosine * r[3],
    ]
}

#[inline(always)]
pub(super) fn times_elements<R: Real>(m: &Matrices<R>, e: &Elements<R>) -> Matrices<R> {
    let mut product = *m;
    for row in 0..4 {
        let [a, b, c, d] = row_times_element([m[0][row], m[1][row], m[2][row], m[3][row]], e);
        product[0][row] = a;
        product[1][row] = b;
        product[2][row] = c;
        product[3][row] = d;
    }
    product
}

/// An element, its columns turned out of the frame of the double angle (c, s).
#[inline(always)]
pub(super) fn turned_element<R: Real>(e: &Elements<R>, (c, s): (R, R)) -> Matrices<R> {
    let none = R::zero();
    [
        [e.mean, c * e.difference, s * e.difference, none],
        [e.difference, c * e.mean, s * e.mean, none],
        [none, -(s * e.cosine), c * e.cosine, -e.sine],
        [none, -(s * e.sine), c * e.sine, e.cosine],
    ]
}

#[inline(always)]
pub(super) fn dot<R: Real>(a: [R; 4], b: [R; 4]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

#[inline(always)]
pub(super) fn times_vector<R: Real>(m: &Matrices<R>, v: [R; 4]) -> [R; 4] {
    let mut product = [R::zero(); 4];
    for (row, sum) in product.iter_mut().enumerate() {
        *sum = m[0][row] * v[0] + m[1][row] * v[1] + m[2][row] * v[2] + m[3][row] * v[3];
    }
    product
}

#[inline(always)]
pub(super) fn scaled_vector<R: Real>(v: [R; 4], weight: R) -> [R; 4] {
    [v[0] * weight, v[1] * weight, v[2] * weight, v[3] * weight]
}

/// Column of an element, S0 to S2 of the light that it makes of unpolarized light, in the frame of `axis`; its own axis is
/// `own`. Its row in that frame is the same.
#[inline(always)]
pub(super) fn polarized_along<R: Real>(
    axis: V3<R>,
    (own, e): (V3<R>, Elements<R>),
    k: V3<R>,
) -> [R; 3] {
    let (c, s) = double_angles(axis, own, k);
    [e.mean, c * e.difference, s * e.difference]
}

/// The whole matrix of an element, plus `weight` times the product of a column and a row.
#[inline(always)]
pub(super) fn element_beside<R: Real>(
    e: &Elements<R>,
    column: [R; 3],
    weight: R,
    row: [R; 3],
) -> Matrices<R> {
    let o = R::zero();
    let mut sum = [
        [e.mean, e.difference, o, o],
        [e.difference, e.mean, o, o],
        [o, o, e.cosine, -e.sine],
        [o, o, e.sine, e.cosine],
    ];
    for (to, a) in sum.iter_mut().zip(&row) {
        let a = *a * weight;
        for (to, b) in to.iter_mut().zip(&column) {
            *to = *to + *b * a;
        }
    }
    sum
}

/// Light of a source, times `weight`, in the frame of `axis`; `k` is its direction.
#[inline(always)]
pub(super) fn arriving<R: Real, const N: usize>(
    axis: V3<R>,
    light: &Shine<[R; N], R>,
    k: V3<R>,
    weight: R,
) -> [[R; 4]; N] {
    let mut all = [[R::zero(); 4]; N];
    match &light.state {
        None => {
            for (w, to) in all.iter_mut().enumerate() {
                to[0] = light.radiance[w] * weight;
            }
        }
        Some((from, states)) => {
            let turn = double_angles(axis, *from, k);
            for (w, to) in all.iter_mut().enumerate() {
                let s0 = light.radiance[w] * weight;
                let state = [s0, states[0][w] * s0, states[1][w] * s0, states[2][w] * s0];
                *to = turned_vector(state, turn);
            }
        }
    }
    all
}
