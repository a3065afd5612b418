//! The algebra of light for paths side by side: the same products as for one, a path a lane.
//!
//! Throughputs are whole matrices here. Behind a depolarizer all but the first column is zero: lanes of either kind then
//! go on together, and no lane waits for another.

use glam::{Mat4, Vec3A, Vec4, vec4};

use super::{Element, Intensity, Light, MuellerResponse, Polarized, Sight};
use crate::lanes::{Axes, Bits, Columns, MOST, Mask, Packed, Real, Rows, V3, each};

/// An [`Element`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Elements<R> {
    /// M00 = M11.
    pub mean: R,
    /// M01 = M10.
    pub difference: R,
    /// M22 = M33.
    pub cosine: R,
    /// M23 = −M32.
    pub sine: R,
}

impl<R: Real> Elements<R> {
    /// The same in all lanes.
    #[inline(always)]
    pub fn splat(element: Element) -> Self {
        Self {
            mean: R::splat(element.mean),
            difference: R::splat(element.difference),
            cosine: R::splat(element.cosine),
            sine: R::splat(element.sine),
        }
    }
    /// All four numbers times `weight`.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, weight: R) -> Self {
        Self {
            mean: self.mean * weight,
            difference: self.difference * weight,
            cosine: self.cosine * weight,
            sine: self.sine * weight,
        }
    }
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: Self, b: Self) -> Self {
        Self {
            mean: R::select(mask, a.mean, b.mean),
            difference: R::select(mask, a.difference, b.difference),
            cosine: R::select(mask, a.cosine, b.cosine),
            sine: R::select(mask, a.sine, b.sine),
        }
    }
}

/// A 4×4 matrix a lane, by columns.
pub type Matrices<R> = [[R; 4]; 4];

/// What light arrives with: radiance, and the state if it is polarized.
#[derive(Clone, Copy, Debug)]
pub struct Shine<V, R> {
    /// Radiance, or what the emitter has instead, a wavelength each.
    pub radiance: V,
    /// First axis of its Stokes frame, and S1, S2, S3 over S0, a wavelength each.
    pub state: Option<(V3<R>, [V; 3])>,
}

/// Which linearly polarized light a sensor sees rather than other light: [`Sight`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Sights<R> {
    /// First axis of its frame, across the ray.
    pub axis: V3<R>,
    /// S0 at the sensor that unit S1 and S2 make, over that of unit S0.
    pub linear: [R; 2],
}

impl<R: Real> Sights<R> {
    /// No polarization rather than another.
    #[inline(always)]
    pub fn blind(axis: V3<R>) -> Self {
        Self {
            axis,
            linear: [R::zero(); 2],
        }
    }
    /// One by one.
    #[inline(always)]
    pub fn lanes(&self) -> [Sight; MOST] {
        let axes = self.axis.lanes();
        let [a, b] = [self.linear[0].lanes(), self.linear[1].lanes()];
        let mut all = [Sight::BLIND; MOST];
        for (lane, sight) in all.iter_mut().enumerate().take(R::LANES) {
            *sight = Sight::new(axes[lane], [1.0, a[lane], b[lane]]);
        }
        all
    }
    /// How much rather it sees light polarized along `axis` than across it; `k` is the light's direction.
    #[inline(always)]
    pub fn along(&self, axis: V3<R>, k: V3<R>) -> R {
        let (cos, sin) = double_angles(self.axis, axis, k);
        self.linear[0] * cos + self.linear[1] * sin
    }
}

/// cos 2θ and sin 2θ of the angles from `from` to `to`, counter-clockwise about `k`; all unit, across `k`.
#[inline(always)]
fn double_angles<R: Real>(from: V3<R>, to: V3<R>, k: V3<R>) -> (R, R) {
    let c = from.dot(to);
    let s = k.cross(from).dot(to);
    // normalised: the axes are perpendicular to k only up to rounding, so that 2 − n is 1/n
    let norm = R::splat(2.0) - (c * c + s * s);
    ((c * c - s * s) * norm, (c + c) * s * norm)
}

/// What matter does to light, a path a lane; `N` wavelengths.
#[derive(Clone, Copy, Debug)]
pub enum Answers<R, const N: usize> {
    /// Only M00.
    Depolarizing([R; N]),
    /// Diagonal in the frame of an axis on both sides.
    Diagonal(V3<R>, [Elements<R>; N]),
    /// Any matrix, from the frame of the second axis to that of the first.
    General(V3<R>, V3<R>, [Matrices<R>; N]),
}

/// Mueller matrices of paths; they act on light in the frame of `axis`.
#[derive(Clone, Copy, Debug)]
pub struct Throughputs<R, const N: usize> {
    axis: V3<R>,
    matrices: [Matrices<R>; N],
}

/// Light along paths side by side.
pub trait Abreast: Light {
    /// One number a wavelength.
    type Values<R: Real>: Copy + std::fmt::Debug + AsRef<[R]> + AsMut<[R]>;
    /// One element a wavelength.
    type Diagonals<R: Real>: Copy + AsMut<[Elements<R>]>;
    /// What matter does to light.
    type Answers<R: Real>: Copy;
    /// Products of these from the sensor to here.
    type Throughputs<R: Real>: Copy;
    /// One Stokes vector a wavelength.
    type Seen<R: Real>: Copy;

    /// The same number for each wavelength, to be filled in.
    fn values<R: Real>(value: R) -> Self::Values<R>;
    /// The same element for each wavelength, to be filled in.
    fn diagonals<R: Real>(element: Elements<R>) -> Self::Diagonals<R>;
    /// Matter that forgets polarization.
    fn depolarizing_lanes<R: Real>(m00: Self::Values<R>) -> Self::Answers<R>;
    /// Matter that is diagonal in the frame of `axis`.
    fn diagonal_lanes<R: Real>(axis: V3<R>, elements: &Self::Diagonals<R>) -> Self::Answers<R>;
    /// Matter with the same matrix in all lanes, times a factor, in the frame of `axis` on both sides.
    fn general_lanes<R: Real>(
        axis: V3<R>,
        matrix: &Mat4,
        factors: &Self::Values<R>,
    ) -> Self::Answers<R>;
    /// Reflection by a surface, diagonal in the frame of an axis across `o` and `i`, and beside it a depolarizer between two
    /// passages with their axes: see [`Light::depolarizer_between`] and [`Light::sum`]. `o` is the direction toward the
    /// sensor, `i` that toward the light.
    fn coated_lanes<R: Real>(
        surface: (V3<R>, &Self::Diagonals<R>),
        last: (V3<R>, Elements<R>),
        weights: &Self::Values<R>,
        first: (V3<R>, Elements<R>),
        ways: [V3<R>; 2],
    ) -> Self::Answers<R>;
    /// The answers of lanes that were asked one by one; `o` is the direction toward the sensor, `i` that toward the light.
    fn gathered<R: Real>(
        lanes: u32,
        o: &[Vec3A; MOST],
        i: &[Vec3A; MOST],
        f: impl FnMut(usize) -> Self::Response,
    ) -> Self::Answers<R>;
    /// With its axes in the world.
    fn to_world<R: Real>(answer: &Self::Answers<R>, axes: &Axes<R>) -> Self::Answers<R>;
    /// The empty path in the frame of `axis`.
    fn beginning<R: Real>(axis: V3<R>) -> Self::Throughputs<R>;
    /// Longer by a vertex, weighted; `k_out` is the direction of light that leaves it, `i` that toward the light.
    fn extended<R: Real>(
        throughput: &Self::Throughputs<R>,
        answer: &Self::Answers<R>,
        weight: R,
        k_out: V3<R>,
        i: V3<R>,
    ) -> Self::Throughputs<R>;
    /// `a` where the mask holds, elsewhere `b`.
    fn select<R: Real>(
        mask: R::M,
        a: &Self::Throughputs<R>,
        b: &Self::Throughputs<R>,
    ) -> Self::Throughputs<R>;
    /// Light of a source, times `weight`, as the sensor sees it; `k` is its direction.
    fn seen<R: Real>(
        throughput: &Self::Throughputs<R>,
        light: &Shine<Self::Values<R>, R>,
        k: V3<R>,
        weight: R,
    ) -> Self::Seen<R>;
    /// The same with one more vertex in between.
    fn seen_through<R: Real>(
        throughput: &Self::Throughputs<R>,
        answer: &Self::Answers<R>,
        k_out: V3<R>,
        light: &Shine<Self::Values<R>, R>,
        k_in: V3<R>,
        weight: R,
    ) -> Self::Seen<R>;
    /// Adds what lanes see to the sums of their camera samples.
    fn add_to<R: Real>(sums: &mut [Self::Stokes], samples: R::B, seen: &Self::Seen<R>, lanes: R::M);
    /// Throughputs that wait in rows from `row` on.
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
    ) -> Self::Throughputs<R>;
    /// Lets throughputs wait in rows from `row` on.
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &Self::Throughputs<R>,
    );
    /// See [`Light::strength`].
    fn strengths<R: Real>(throughput: &Self::Throughputs<R>) -> R;
    /// See [`Light::reach`].
    fn reaches<R: Real>(throughput: &Self::Throughputs<R>) -> R;
    /// See [`Light::sight`].
    fn sights<R: Real>(throughput: &Self::Throughputs<R>) -> Sights<R>;
    /// Scales each path.
    fn scale_lanes<R: Real>(throughput: &mut Self::Throughputs<R>, weight: R);
}

/// Arrays of wavelengths, written out: closures that are not inlined would lose the instructions.
macro_rules! each_wavelength {
    ($i:ident, $initial:expr, $value:expr) => {{
        let mut all = [$initial; N];
        for ($i, place) in all.iter_mut().enumerate() {
            *place = $value;
        }
        all
    }};
}

/// A column with its linear part turned out of the frame of the double angle (c, s).
#[inline(always)]
fn turned_vector<R: Real>(v: [R; 4], (c, s): (R, R)) -> [R; 4] {
    [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2], v[3]]
}

#[inline(always)]
fn turned_columns<R: Real>(m: &Matrices<R>, (c, s): (R, R)) -> Matrices<R> {
    let mut turned = *m;
    for row in 0..4 {
        turned[1][row] = c * m[1][row] + s * m[2][row];
        turned[2][row] = c * m[2][row] - s * m[1][row];
    }
    turned
}

#[inline(always)]
fn times_elements<R: Real>(m: &Matrices<R>, e: &Elements<R>) -> Matrices<R> {
    let mut product = *m;
    for row in 0..4 {
        product[0][row] = e.mean * m[0][row] + e.difference * m[1][row];
        product[1][row] = e.difference * m[0][row] + e.mean * m[1][row];
        product[2][row] = e.cosine * m[2][row] - e.sine * m[3][row];
        product[3][row] = e.sine * m[2][row] + e.cosine * m[3][row];
    }
    product
}

#[inline(always)]
fn times_vector<R: Real>(m: &Matrices<R>, v: [R; 4]) -> [R; 4] {
    let mut product = [R::zero(); 4];
    for (row, sum) in product.iter_mut().enumerate() {
        *sum = m[0][row] * v[0] + m[1][row] * v[1] + m[2][row] * v[2] + m[3][row] * v[3];
    }
    product
}

#[inline(always)]
fn scaled_vector<R: Real>(v: [R; 4], weight: R) -> [R; 4] {
    [v[0] * weight, v[1] * weight, v[2] * weight, v[3] * weight]
}

/// Column of an element, S0 to S2 of the light that it makes of unpolarized light, in the frame of `axis`; its own axis is
/// `own`. Its row in that frame is the same.
#[inline(always)]
fn polarized_along<R: Real>(axis: V3<R>, (own, e): (V3<R>, Elements<R>), k: V3<R>) -> [R; 3] {
    let (c, s) = double_angles(axis, own, k);
    [e.mean, c * e.difference, s * e.difference]
}

/// The whole matrix of an element, plus `weight` times the product of a column and a row.
#[inline(always)]
fn element_beside<R: Real>(e: &Elements<R>, column: [R; 3], weight: R, row: [R; 3]) -> Matrices<R> {
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
fn arriving<R: Real, const N: usize>(
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

impl<const N: usize> Abreast for Polarized<N> {
    type Values<R: Real> = [R; N];
    type Diagonals<R: Real> = [Elements<R>; N];
    type Answers<R: Real> = Answers<R, N>;
    type Throughputs<R: Real> = Throughputs<R, N>;
    type Seen<R: Real> = [[R; 4]; N];

    #[inline(always)]
    fn values<R: Real>(value: R) -> [R; N] {
        [value; N]
    }
    #[inline(always)]
    fn diagonals<R: Real>(element: Elements<R>) -> [Elements<R>; N] {
        [element; N]
    }
    #[inline(always)]
    fn depolarizing_lanes<R: Real>(m00: [R; N]) -> Answers<R, N> {
        Answers::Depolarizing(m00)
    }
    #[inline(always)]
    fn diagonal_lanes<R: Real>(axis: V3<R>, elements: &[Elements<R>; N]) -> Answers<R, N> {
        Answers::Diagonal(axis, *elements)
    }
    #[inline(always)]
    fn general_lanes<R: Real>(axis: V3<R>, matrix: &Mat4, factors: &[R; N]) -> Answers<R, N> {
        let columns = matrix.to_cols_array_2d();
        let none = [[R::zero(); 4]; 4];
        let matrices = each_wavelength!(w, none, {
            let mut m = none;
            for (to, from) in m.iter_mut().zip(&columns) {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = R::splat(*from) * factors[w];
                }
            }
            m
        });
        Answers::General(axis, axis, matrices)
    }
    #[inline(always)]
    fn coated_lanes<R: Real>(
        (axis, surface): (V3<R>, &[Elements<R>; N]),
        last: (V3<R>, Elements<R>),
        weights: &[R; N],
        first: (V3<R>, Elements<R>),
        [o, i]: [V3<R>; 2],
    ) -> Answers<R, N> {
        let column = polarized_along(axis, last, o);
        let row = polarized_along(axis, first, -i);
        let none = [[R::zero(); 4]; 4];
        let matrices = each_wavelength!(
            w,
            none,
            element_beside(&surface[w], column, weights[w], row)
        );
        Answers::General(axis, axis, matrices)
    }
    #[inline(always)]
    fn gathered<R: Real>(
        lanes: u32,
        o: &[Vec3A; MOST],
        i: &[Vec3A; MOST],
        mut f: impl FnMut(usize) -> MuellerResponse<N>,
    ) -> Answers<R, N> {
        let mut axes = [[Vec3A::X; MOST]; 2];
        let mut matrices = [[[[0.0; MOST]; 4]; 4]; N];
        each(lanes, |lane| {
            let ([out, inward], matrix) = f(lane).whole(o[lane], i[lane]);
            axes[0][lane] = out;
            axes[1][lane] = inward;
            for (to, from) in matrices.iter_mut().zip(matrix) {
                for (column, values) in to.iter_mut().enumerate() {
                    for (row, value) in values.iter_mut().enumerate() {
                        value[lane] = from.col(column)[row];
                    }
                }
            }
        });
        let mut all = [[[R::zero(); 4]; 4]; N];
        for (to, from) in all.iter_mut().zip(&matrices) {
            for column in 0..4 {
                for row in 0..4 {
                    to[column][row] = R::from_fn(|lane| from[column][row][lane]);
                }
            }
        }
        Answers::General(V3::from_lanes(&axes[0]), V3::from_lanes(&axes[1]), all)
    }
    #[inline(always)]
    fn to_world<R: Real>(answer: &Answers<R, N>, axes: &Axes<R>) -> Answers<R, N> {
        match answer {
            Answers::Depolarizing(_) => *answer,
            Answers::Diagonal(axis, elements) => Answers::Diagonal(axes.to_world(*axis), *elements),
            Answers::General(out, inward, m) => {
                Answers::General(axes.to_world(*out), axes.to_world(*inward), *m)
            }
        }
    }
    #[inline(always)]
    fn beginning<R: Real>(axis: V3<R>) -> Throughputs<R, N> {
        let mut matrix = [[R::zero(); 4]; 4];
        for (k, column) in matrix.iter_mut().enumerate() {
            column[k] = R::one();
        }
        Throughputs {
            axis,
            matrices: [matrix; N],
        }
    }
    #[inline(always)]
    fn extended<R: Real>(
        throughput: &Throughputs<R, N>,
        answer: &Answers<R, N>,
        weight: R,
        k_out: V3<R>,
        i: V3<R>,
    ) -> Throughputs<R, N> {
        let none = [[R::zero(); 4]; 4];
        let m = &throughput.matrices;
        match answer {
            Answers::Depolarizing(m00) => Throughputs {
                axis: Axes::around(i).s,
                matrices: each_wavelength!(w, none, {
                    let mut matrix = none;
                    matrix[0] = scaled_vector(m[w][0], m00[w] * weight);
                    matrix
                }),
            },
            Answers::Diagonal(axis, elements) => {
                let turn = double_angles(throughput.axis, *axis, k_out);
                Throughputs {
                    axis: *axis,
                    matrices: each_wavelength!(
                        w,
                        none,
                        times_elements(&turned_columns(&m[w], turn), &elements[w].scaled(weight))
                    ),
                }
            }
            Answers::General(out, inward, matrices) => {
                let turn = double_angles(throughput.axis, *out, k_out);
                Throughputs {
                    axis: *inward,
                    matrices: each_wavelength!(w, none, {
                        let turned = turned_columns(&m[w], turn);
                        let mut product = none;
                        for (column, to) in product.iter_mut().enumerate() {
                            *to = times_vector(&turned, scaled_vector(matrices[w][column], weight));
                        }
                        product
                    }),
                }
            }
        }
    }
    #[inline(always)]
    fn select<R: Real>(
        mask: R::M,
        a: &Throughputs<R, N>,
        b: &Throughputs<R, N>,
    ) -> Throughputs<R, N> {
        let mut chosen = *b;
        chosen.axis = V3::select(mask, a.axis, b.axis);
        for w in 0..N {
            for column in 0..4 {
                for row in 0..4 {
                    chosen.matrices[w][column][row] =
                        R::select(mask, a.matrices[w][column][row], b.matrices[w][column][row]);
                }
            }
        }
        chosen
    }
    #[inline(always)]
    fn seen<R: Real>(
        throughput: &Throughputs<R, N>,
        light: &Shine<[R; N], R>,
        k: V3<R>,
        weight: R,
    ) -> [[R; 4]; N] {
        let none = [R::zero(); 4];
        let m = &throughput.matrices;
        match &light.state {
            None => each_wavelength!(w, none, scaled_vector(m[w][0], light.radiance[w] * weight)),
            Some((axis, states)) => {
                let turn = double_angles(throughput.axis, *axis, k);
                each_wavelength!(w, none, {
                    let s0 = light.radiance[w] * weight;
                    let state = [s0, states[0][w] * s0, states[1][w] * s0, states[2][w] * s0];
                    times_vector(&m[w], turned_vector(state, turn))
                })
            }
        }
    }
    #[inline(always)]
    fn seen_through<R: Real>(
        throughput: &Throughputs<R, N>,
        answer: &Answers<R, N>,
        k_out: V3<R>,
        light: &Shine<[R; N], R>,
        k_in: V3<R>,
        weight: R,
    ) -> [[R; 4]; N] {
        let none = [R::zero(); 4];
        let m = &throughput.matrices;
        match answer {
            Answers::Depolarizing(m00) => each_wavelength!(
                w,
                none,
                scaled_vector(m[w][0], m00[w] * light.radiance[w] * weight)
            ),
            Answers::Diagonal(axis, elements) => {
                let turn = double_angles(throughput.axis, *axis, k_out);
                if light.state.is_none() {
                    // of the element the first column is enough
                    return each_wavelength!(w, none, {
                        let (e, radiance) = (&elements[w], light.radiance[w] * weight);
                        let (a, b) = (e.mean * radiance, e.difference * radiance);
                        let (b1, b2) = (turn.0 * b, turn.1 * b);
                        let mut sum = none;
                        for (row, to) in sum.iter_mut().enumerate() {
                            *to = m[w][0][row] * a + m[w][1][row] * b1 + m[w][2][row] * b2;
                        }
                        sum
                    });
                }
                let light = arriving(*axis, light, k_in, weight);
                each_wavelength!(w, none, {
                    let (e, v) = (&elements[w], light[w]);
                    let after = [
                        e.mean * v[0] + e.difference * v[1],
                        e.difference * v[0] + e.mean * v[1],
                        e.cosine * v[2] + e.sine * v[3],
                        e.cosine * v[3] - e.sine * v[2],
                    ];
                    times_vector(&m[w], turned_vector(after, turn))
                })
            }
            Answers::General(out, inward, matrices) => {
                let turn = double_angles(throughput.axis, *out, k_out);
                let light = arriving(*inward, light, k_in, weight);
                each_wavelength!(w, none, {
                    let after = times_vector(&matrices[w], light[w]);
                    times_vector(&m[w], turned_vector(after, turn))
                })
            }
        }
    }
    #[inline(always)]
    fn add_to<R: Real>(sums: &mut [[Vec4; N]], samples: R::B, seen: &[[R; 4]; N], lanes: R::M) {
        let samples = samples.lanes();
        for w in 0..N {
            let [a, b, c, d] = seen[w];
            let (a, b, c, d) = (a.lanes(), b.lanes(), c.lanes(), d.lanes());
            each(lanes.bits(), |lane| {
                let more = vec4(a[lane], b[lane], c[lane], d[lane]);
                sums[samples[lane] as usize][w] += more;
            });
        }
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
    ) -> Throughputs<R, N> {
        let mut matrices = [[[R::zero(); 4]; 4]; N];
        for (w, matrix) in matrices.iter_mut().enumerate() {
            for (k, column) in matrix.iter_mut().enumerate() {
                for (j, value) in column.iter_mut().enumerate() {
                    *value = rows.get(row + 3 + 16 * w + 4 * k + j, columns);
                }
            }
        }
        Throughputs {
            axis: rows.vector(row, columns),
            matrices,
        }
    }
    #[inline(always)]
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &Throughputs<R, N>,
    ) {
        rows.put_vector(row, columns, throughput.axis);
        for (w, matrix) in throughput.matrices.iter().enumerate() {
            for (k, column) in matrix.iter().enumerate() {
                for (j, value) in column.iter().enumerate() {
                    rows.put(row + 3 + 16 * w + 4 * k + j, columns, *value);
                }
            }
        }
    }
    #[inline(always)]
    fn strengths<R: Real>(throughput: &Throughputs<R, N>) -> R {
        let mut most = throughput.matrices[0][0][0];
        for matrix in &throughput.matrices[1..] {
            most = most.max(matrix[0][0]);
        }
        most
    }
    #[inline(always)]
    fn reaches<R: Real>(throughput: &Throughputs<R, N>) -> R {
        let mut most = R::zero();
        for m in &throughput.matrices {
            let across = m[1][0] * m[1][0] + m[2][0] * m[2][0] + m[3][0] * m[3][0];
            most = most.max(m[0][0] + across.sqrt());
        }
        most
    }
    #[inline(always)]
    fn sights<R: Real>(throughput: &Throughputs<R, N>) -> Sights<R> {
        let mut sums = [R::zero(); 3];
        for m in &throughput.matrices {
            for (sum, column) in sums.iter_mut().zip(m) {
                *sum = *sum + column[0];
            }
        }
        let [all, a, b] = sums;
        let inverse = all.recip();
        let (a, b) = (a * inverse, b * inverse);
        // at most 1 long; blind where nothing is seen
        let squared = a * a + b * b;
        let mut shrink = R::one();
        if squared.gt(R::one()).any() {
            shrink = squared.sqrt().max(R::one()).recip();
        }
        let known = all.gt(R::zero());
        Sights {
            axis: throughput.axis,
            linear: [(a * shrink).only(known), (b * shrink).only(known)],
        }
    }
    #[inline(always)]
    fn scale_lanes<R: Real>(throughput: &mut Throughputs<R, N>, weight: R) {
        for matrix in &mut throughput.matrices {
            for column in matrix {
                *column = scaled_vector(*column, weight);
            }
        }
    }
}

impl<const N: usize> Abreast for Intensity<N> {
    type Values<R: Real> = [R; N];
    type Diagonals<R: Real> = [Elements<R>; N];
    type Answers<R: Real> = [R; N];
    type Throughputs<R: Real> = [R; N];
    type Seen<R: Real> = [R; N];

    #[inline(always)]
    fn values<R: Real>(value: R) -> [R; N] {
        [value; N]
    }
    #[inline(always)]
    fn diagonals<R: Real>(element: Elements<R>) -> [Elements<R>; N] {
        [element; N]
    }
    #[inline(always)]
    fn depolarizing_lanes<R: Real>(m00: [R; N]) -> [R; N] {
        m00
    }
    #[inline(always)]
    fn diagonal_lanes<R: Real>(_: V3<R>, elements: &[Elements<R>; N]) -> [R; N] {
        each_wavelength!(i, R::zero(), elements[i].mean)
    }
    #[inline(always)]
    fn general_lanes<R: Real>(_: V3<R>, matrix: &Mat4, factors: &[R; N]) -> [R; N] {
        each_wavelength!(i, R::zero(), R::splat(matrix.x_axis.x) * factors[i])
    }
    #[inline(always)]
    fn coated_lanes<R: Real>(
        (_, surface): (V3<R>, &[Elements<R>; N]),
        (_, last): (V3<R>, Elements<R>),
        weights: &[R; N],
        (_, first): (V3<R>, Elements<R>),
        _: [V3<R>; 2],
    ) -> [R; N] {
        let both = last.mean * first.mean;
        each_wavelength!(w, R::zero(), surface[w].mean + both * weights[w])
    }
    #[inline(always)]
    fn gathered<R: Real>(
        lanes: u32,
        _: &[Vec3A; MOST],
        _: &[Vec3A; MOST],
        mut f: impl FnMut(usize) -> [f32; N],
    ) -> [R; N] {
        let mut all = [[0.0; MOST]; N];
        each(lanes, |lane| {
            for (to, value) in all.iter_mut().zip(f(lane)) {
                to[lane] = value;
            }
        });
        each_wavelength!(w, R::zero(), R::from_fn(|lane| all[w][lane]))
    }
    #[inline(always)]
    fn to_world<R: Real>(answer: &[R; N], _: &Axes<R>) -> [R; N] {
        *answer
    }
    #[inline(always)]
    fn beginning<R: Real>(_: V3<R>) -> [R; N] {
        [R::one(); N]
    }
    #[inline(always)]
    fn extended<R: Real>(
        throughput: &[R; N],
        answer: &[R; N],
        weight: R,
        _: V3<R>,
        _: V3<R>,
    ) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * answer[w] * weight)
    }
    #[inline(always)]
    fn select<R: Real>(mask: R::M, a: &[R; N], b: &[R; N]) -> [R; N] {
        each_wavelength!(w, R::zero(), R::select(mask, a[w], b[w]))
    }
    #[inline(always)]
    fn seen<R: Real>(throughput: &[R; N], light: &Shine<[R; N], R>, _: V3<R>, weight: R) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * (light.radiance[w] * weight))
    }
    #[inline(always)]
    fn seen_through<R: Real>(
        throughput: &[R; N],
        answer: &[R; N],
        _: V3<R>,
        light: &Shine<[R; N], R>,
        _: V3<R>,
        weight: R,
    ) -> [R; N] {
        each_wavelength!(
            w,
            R::zero(),
            throughput[w] * (answer[w] * light.radiance[w] * weight)
        )
    }
    #[inline(always)]
    fn add_to<R: Real>(sums: &mut [[Vec4; N]], samples: R::B, seen: &[R; N], lanes: R::M) {
        let samples = samples.lanes();
        for w in 0..N {
            let s0 = seen[w].lanes();
            each(lanes.bits(), |lane| {
                sums[samples[lane] as usize][w].x += s0[lane];
            });
        }
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
    ) -> [R; N] {
        each_wavelength!(w, R::zero(), rows.get(row + w, columns))
    }
    #[inline(always)]
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &[R; N],
    ) {
        for (w, value) in throughput.iter().enumerate() {
            rows.put(row + w, columns, *value);
        }
    }
    #[inline(always)]
    fn strengths<R: Real>(throughput: &[R; N]) -> R {
        let mut most = throughput[0];
        for value in &throughput[1..] {
            most = most.max(*value);
        }
        most
    }
    #[inline(always)]
    fn reaches<R: Real>(throughput: &[R; N]) -> R {
        Self::strengths(throughput)
    }
    #[inline(always)]
    fn sights<R: Real>(_: &[R; N]) -> Sights<R> {
        Sights::blind(V3::splat(Vec3A::X))
    }
    #[inline(always)]
    fn scale_lanes<R: Real>(throughput: &mut [R; N], weight: R) {
        for value in throughput {
            *value = *value * weight;
        }
    }
}
