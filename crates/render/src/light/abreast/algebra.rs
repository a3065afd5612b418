//! Products of Mueller matrices, Stokes vectors and rows, a path a lane; of `S` Stokes components: all four, or three where
//! no light is circular.

use super::{Elements, Shine};
use crate::lanes::{Real, V3};

/// A matrix a lane, by columns.
pub(super) type Matrices<R, const S: usize> = [[R; S]; S];

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
pub(super) fn turned_vector<R: Real, const S: usize>(v: [R; S], (c, s): (R, R)) -> [R; S] {
    let mut turned = v;
    turned[1] = c * v[1] - s * v[2];
    turned[2] = s * v[1] + c * v[2];
    turned
}

/// A row with its linear part turned into the frame of the double angle (c, s).
#[inline(always)]
pub(super) fn turned_row<R: Real, const S: usize>(r: [R; S], (c, s): (R, R)) -> [R; S] {
    let mut turned = r;
    turned[1] = c * r[1] + s * r[2];
    turned[2] = c * r[2] - s * r[1];
    turned
}

#[inline(always)]
pub(super) fn turned_columns<R: Real, const S: usize>(
    m: &Matrices<R, S>,
    (c, s): (R, R),
) -> Matrices<R, S> {
    let mut turned = *m;
    for row in 0..S {
        turned[1][row] = c * m[1][row] + s * m[2][row];
        turned[2][row] = c * m[2][row] - s * m[1][row];
    }
    turned
}

/// A row times an element.
#[inline(always)]
pub(super) fn row_times_element<R: Real, const S: usize>(r: [R; S], e: &Elements<R>) -> [R; S] {
    let mut product = r;
    product[0] = e.mean * r[0] + e.difference * r[1];
    product[1] = e.difference * r[0] + e.mean * r[1];
    product[2] = e.cosine * r[2];
    if S > 3 {
        product[2] = product[2] - e.sine * r[3];
        product[3] = e.sine * r[2] + e.cosine * r[3];
    }
    product
}

/// An element times a column.
#[inline(always)]
pub(super) fn element_times_vector<R: Real, const S: usize>(e: &Elements<R>, v: [R; S]) -> [R; S] {
    let mut product = v;
    product[0] = e.mean * v[0] + e.difference * v[1];
    product[1] = e.difference * v[0] + e.mean * v[1];
    product[2] = e.cosine * v[2];
    if S > 3 {
        product[2] = product[2] + e.sine * v[3];
        product[3] = e.cosine * v[3] - e.sine * v[2];
    }
    product
}

#[inline(always)]
pub(super) fn times_elements<R: Real, const S: usize>(
    m: &Matrices<R, S>,
    e: &Elements<R>,
) -> Matrices<R, S> {
    let mut product = *m;
    for row in 0..S {
        let mut own = m[0];
        for column in 0..S {
            own[column] = m[column][row];
        }
        let own = row_times_element(own, e);
        for column in 0..S {
            product[column][row] = own[column];
        }
    }
    product
}

/// The matrix of an element.
#[inline(always)]
fn matrix_of<R: Real, const S: usize>(e: &Elements<R>) -> Matrices<R, S> {
    let mut matrix = [[R::zero(); S]; S];
    matrix[0][0] = e.mean;
    matrix[0][1] = e.difference;
    matrix[1][0] = e.difference;
    matrix[1][1] = e.mean;
    matrix[2][2] = e.cosine;
    if S > 3 {
        matrix[2][3] = -e.sine;
        matrix[3][2] = e.sine;
        matrix[3][3] = e.cosine;
    }
    matrix
}

/// An element, its columns turned out of the frame of the double angle (c, s).
#[inline(always)]
pub(super) fn turned_element<R: Real, const S: usize>(
    e: &Elements<R>,
    (c, s): (R, R),
) -> Matrices<R, S> {
    let mut matrix = matrix_of(e);
    matrix[0][1] = c * e.difference;
    matrix[0][2] = s * e.difference;
    matrix[1][1] = c * e.mean;
    matrix[1][2] = s * e.mean;
    matrix[2][1] = -(s * e.cosine);
    matrix[2][2] = c * e.cosine;
    if S > 3 {
        matrix[3][1] = -(s * e.sine);
        matrix[3][2] = c * e.sine;
    }
    matrix
}

#[inline(always)]
pub(super) fn dot<R: Real, const S: usize>(a: [R; S], b: [R; S]) -> R {
    let mut sum = a[0] * b[0];
    for k in 1..S {
        sum = sum + a[k] * b[k];
    }
    sum
}

#[inline(always)]
pub(super) fn times_vector<R: Real, const S: usize>(m: &Matrices<R, S>, v: [R; S]) -> [R; S] {
    let mut product = v;
    for (row, to) in product.iter_mut().enumerate() {
        let mut sum = m[0][row] * v[0];
        for column in 1..S {
            sum = sum + m[column][row] * v[column];
        }
        *to = sum;
    }
    product
}

#[inline(always)]
pub(super) fn scaled_vector<R: Real, const S: usize>(v: [R; S], weight: R) -> [R; S] {
    let mut scaled = v;
    for to in &mut scaled {
        *to = *to * weight;
    }
    scaled
}

/// (1, 0, 0, 0).
#[inline(always)]
pub(super) fn first<R: Real, const S: usize>() -> [R; S] {
    unpolarized(R::one())
}

/// (`s0`, 0, 0, 0).
#[inline(always)]
pub(super) fn unpolarized<R: Real, const S: usize>(s0: R) -> [R; S] {
    let mut column = [R::zero(); S];
    column[0] = s0;
    column
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

/// The matrix of an element, plus `weight` times the product of a column and a row.
#[inline(always)]
pub(super) fn element_beside<R: Real, const S: usize>(
    e: &Elements<R>,
    column: [R; 3],
    weight: R,
    row: [R; 3],
) -> Matrices<R, S> {
    let mut sum = matrix_of(e);
    for (to, a) in sum.iter_mut().zip(&row) {
        let a = *a * weight;
        for (to, b) in to.iter_mut().zip(&column) {
            *to = *to + *b * a;
        }
    }
    sum
}

/// Stokes vectors of light of `s0` whose S1, S2, S3 over S0 are these, of one wavelength.
#[inline(always)]
pub(super) fn state_of<R: Real, const S: usize>(s0: R, state: [R; 3]) -> [R; S] {
    let mut v = [s0; S];
    for k in 1..S {
        v[k] = state[k - 1] * s0;
    }
    v
}

/// Light of a source, times `weight`, in the frame of `axis`; `k` is its direction.
#[inline(always)]
pub(super) fn arriving<R: Real, const N: usize, const S: usize>(
    axis: V3<R>,
    light: &Shine<[R; N], R>,
    k: V3<R>,
    weight: R,
) -> [[R; S]; N] {
    let mut all = [[R::zero(); S]; N];
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
                let state = state_of(s0, [states[0][w], states[1][w], states[2][w]]);
                *to = turned_vector(state, turn);
            }
        }
    }
    all
}
