//! The algebra of light for paths side by side: the same products as for one, a path a lane.
//!
//! A throughput is kept as small as the path allows, see [`Throughputs`]. Paths whose throughputs are of one kind go on
//! together, so that all lanes do the same.

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

/// Kinds of throughputs, at most.
pub const KINDS: usize = 4;

/// Mueller matrices of paths, from the frame of `axis` to that of the sensor, all of one kind.
#[derive(Clone, Copy, Debug)]
pub enum Throughputs<R, const N: usize> {
    /// One: nothing has been met yet.
    Unit {
        /// First axis of the Stokes frame.
        axis: V3<R>,
    },
    /// Any.
    Whole {
        /// First axis of the Stokes frame.
        axis: V3<R>,
        /// By columns.
        matrices: [Matrices<R>; N],
    },
    /// A column times a row: the path has met a depolarizer.
    Product {
        /// First axis of the Stokes frame.
        axis: V3<R>,
        /// What of the path the sensor sees.
        columns: [[R; 4]; N],
        /// What of light goes that way.
        rows: [[R; 4]; N],
    },
    /// A column times (1, 0, 0, 0): only the radiance matters, since the path has just met a depolarizer.
    Column {
        /// What of the path the sensor sees.
        columns: [[R; 4]; N],
    },
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
    /// Longer by a vertex, weighted; `k_out` is the direction of light that leaves it.
    fn extended<R: Real>(
        throughput: &Self::Throughputs<R>,
        answer: &Self::Answers<R>,
        weight: R,
        k_out: V3<R>,
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
    /// Of which kind throughputs are: a number below [`KINDS`].
    fn kind<R: Real>(throughput: &Self::Throughputs<R>) -> usize;
    /// Throughputs of a kind that wait in rows from `row` on.
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Self::Throughputs<R>;
    /// Of such throughputs what acts on unpolarized light.
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
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
    /// Times a number a path.
    fn scaled_lanes<R: Real>(throughput: &Self::Throughputs<R>, weight: R) -> Self::Throughputs<R>;
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

/// A row with its linear part turned into the frame of the double angle (c, s).
#[inline(always)]
fn turned_row<R: Real>(r: [R; 4], (c, s): (R, R)) -> [R; 4] {
    [r[0], c * r[1] + s * r[2], c * r[2] - s * r[1], r[3]]
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

/// A row times an element.
#[inline(always)]
fn row_times_element<R: Real>(r: [R; 4], e: &Elements<R>) -> [R; 4] {
    [
        e.mean * r[0] + e.difference * r[1],
        e.difference * r[0] + e.mean * r[1],
        e.cosine * r[2] - e.sine * r[3],
        e.sine * r[2] + e.cosine * r[3],
    ]
}

#[inline(always)]
fn times_elements<R: Real>(m: &Matrices<R>, e: &Elements<R>) -> Matrices<R> {
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
fn turned_element<R: Real>(e: &Elements<R>, (c, s): (R, R)) -> Matrices<R> {
    let none = R::zero();
    [
        [e.mean, c * e.difference, s * e.difference, none],
        [e.difference, c * e.mean, s * e.mean, none],
        [none, -(s * e.cosine), c * e.cosine, -e.sine],
        [none, -(s * e.sine), c * e.sine, e.cosine],
    ]
}

#[inline(always)]
fn dot<R: Real>(a: [R; 4], b: [R; 4]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
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

/// A vector of numbers in as many rows.
#[inline(always)]
fn four<R: Real, const ROWS: usize>(rows: &Rows<ROWS>, row: usize, columns: Columns<R>) -> [R; 4] {
    [
        rows.get(row, columns),
        rows.get(row + 1, columns),
        rows.get(row + 2, columns),
        rows.get(row + 3, columns),
    ]
}

#[inline(always)]
fn put_four<R: Real, const ROWS: usize>(
    rows: &mut Rows<ROWS>,
    row: usize,
    columns: Packed<R>,
    v: &[R; 4],
) {
    for (k, value) in v.iter().enumerate() {
        rows.put(row + k, columns, *value);
    }
}

#[inline(always)]
fn select_four<R: Real>(mask: R::M, a: &[R; 4], b: &[R; 4]) -> [R; 4] {
    let mut chosen = *b;
    for (to, a) in chosen.iter_mut().zip(a) {
        *to = R::select(mask, *a, *to);
    }
    chosen
}

const UNIT: usize = 0;
const WHOLE: usize = 1;
const PRODUCT: usize = 2;
const COLUMN: usize = 3;

impl<R: Real, const N: usize> Throughputs<R, N> {
    /// The first column, of one wavelength.
    #[inline(always)]
    fn first_column(&self, w: usize) -> [R; 4] {
        match self {
            Self::Unit { .. } => [R::one(), R::zero(), R::zero(), R::zero()],
            Self::Whole { matrices, .. } => matrices[w][0],
            Self::Product { columns, rows, .. } => scaled_vector(columns[w], rows[w][0]),
            Self::Column { columns } => columns[w],
        }
    }

    /// The double angle from its frame to that of an axis; none that matters where no frame does.
    #[inline(always)]
    fn turn_to(&self, to: V3<R>, k: V3<R>) -> (R, R) {
        match self {
            Self::Unit { axis } | Self::Whole { axis, .. } | Self::Product { axis, .. } => {
                double_angles(*axis, to, k)
            }
            Self::Column { .. } => (R::one(), R::zero()),
        }
    }

    /// A Stokes vector in a frame that is turned by the double angle, as the sensor sees it, of one wavelength.
    #[inline(always)]
    fn times(&self, w: usize, v: [R; 4], turn: (R, R)) -> [R; 4] {
        match self {
            Self::Unit { .. } => turned_vector(v, turn),
            Self::Whole { matrices, .. } => times_vector(&matrices[w], turned_vector(v, turn)),
            Self::Product { columns, rows, .. } => {
                scaled_vector(columns[w], dot(rows[w], turned_vector(v, turn)))
            }
            Self::Column { columns } => scaled_vector(columns[w], v[0]),
        }
    }

    /// The same of light whose state is (a, b, 0, 0).
    #[inline(always)]
    fn times_linear(&self, w: usize, [a, b]: [R; 2], (c, s): (R, R)) -> [R; 4] {
        match self {
            Self::Unit { .. } => [a, c * b, s * b, R::zero()],
            Self::Whole { matrices, .. } => {
                let (m, b1, b2) = (&matrices[w], c * b, s * b);
                let mut sum = [R::zero(); 4];
                for (row, to) in sum.iter_mut().enumerate() {
                    *to = m[0][row] * a + m[1][row] * b1 + m[2][row] * b2;
                }
                sum
            }
            Self::Product { columns, rows, .. } => {
                let (row, b1, b2) = (rows[w], c * b, s * b);
                scaled_vector(columns[w], row[0] * a + row[1] * b1 + row[2] * b2)
            }
            Self::Column { columns } => scaled_vector(columns[w], a),
        }
    }

    /// As whole matrices.
    #[inline(always)]
    fn whole(&self) -> (V3<R>, [Matrices<R>; N]) {
        let (zero, one) = (R::zero(), R::one());
        let mut all = [[[zero; 4]; 4]; N];
        let mut axis = V3::splat(Vec3A::Z);
        match self {
            Self::Unit { axis: own } => {
                axis = *own;
                for matrix in &mut all {
                    for (k, column) in matrix.iter_mut().enumerate() {
                        column[k] = one;
                    }
                }
            }
            Self::Whole {
                axis: own,
                matrices,
            } => {
                axis = *own;
                all = *matrices;
            }
            Self::Product {
                axis: own,
                columns,
                rows,
            } => {
                axis = *own;
                for ((matrix, column), row) in all.iter_mut().zip(columns).zip(rows) {
                    for (to, factor) in matrix.iter_mut().zip(row) {
                        *to = scaled_vector(*column, *factor);
                    }
                }
            }
            Self::Column { columns } => {
                for (matrix, column) in all.iter_mut().zip(columns) {
                    matrix[0] = *column;
                }
            }
        }
        (axis, all)
    }
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
        Throughputs::Unit { axis }
    }
    #[inline(always)]
    fn extended<R: Real>(
        throughput: &Throughputs<R, N>,
        answer: &Answers<R, N>,
        weight: R,
        k_out: V3<R>,
    ) -> Throughputs<R, N> {
        let (no_matrix, no_vector) = ([[R::zero(); 4]; 4], [R::zero(); 4]);
        match answer {
            Answers::Depolarizing(m00) => Throughputs::Column {
                columns: each_wavelength!(
                    w,
                    no_vector,
                    scaled_vector(throughput.first_column(w), m00[w] * weight)
                ),
            },
            Answers::Diagonal(axis, elements) => {
                let (axis, turn) = (*axis, throughput.turn_to(*axis, k_out));
                match throughput {
                    Throughputs::Unit { .. } => Throughputs::Whole {
                        axis,
                        matrices: each_wavelength!(
                            w,
                            no_matrix,
                            turned_element(&elements[w].scaled(weight), turn)
                        ),
                    },
                    Throughputs::Whole { matrices, .. } => Throughputs::Whole {
                        axis,
                        matrices: each_wavelength!(
                            w,
                            no_matrix,
                            times_elements(
                                &turned_columns(&matrices[w], turn),
                                &elements[w].scaled(weight)
                            )
                        ),
                    },
                    Throughputs::Product { columns, rows, .. } => Throughputs::Product {
                        axis,
                        columns: *columns,
                        rows: each_wavelength!(
                            w,
                            no_vector,
                            row_times_element(
                                turned_row(rows[w], turn),
                                &elements[w].scaled(weight)
                            )
                        ),
                    },
                    Throughputs::Column { columns } => Throughputs::Product {
                        axis,
                        columns: *columns,
                        rows: each_wavelength!(w, no_vector, {
                            let e = elements[w].scaled(weight);
                            [e.mean, e.difference, R::zero(), R::zero()]
                        }),
                    },
                }
            }
            Answers::General(out, inward, answers) => {
                let (axis, turn) = (*inward, throughput.turn_to(*out, k_out));
                match throughput {
                    Throughputs::Unit { .. } => Throughputs::Whole {
                        axis,
                        matrices: each_wavelength!(w, no_matrix, {
                            let mut product = no_matrix;
                            for (to, column) in product.iter_mut().zip(answers[w]) {
                                *to = turned_vector(scaled_vector(column, weight), turn);
                            }
                            product
                        }),
                    },
                    Throughputs::Whole { matrices, .. } => Throughputs::Whole {
                        axis,
                        matrices: each_wavelength!(w, no_matrix, {
                            let turned = turned_columns(&matrices[w], turn);
                            let mut product = no_matrix;
                            for (to, column) in product.iter_mut().zip(answers[w]) {
                                *to = times_vector(&turned, scaled_vector(column, weight));
                            }
                            product
                        }),
                    },
                    Throughputs::Product { columns, rows, .. } => Throughputs::Product {
                        axis,
                        columns: *columns,
                        rows: each_wavelength!(w, no_vector, {
                            let turned = scaled_vector(turned_row(rows[w], turn), weight);
                            let mut product = no_vector;
                            for (to, column) in product.iter_mut().zip(answers[w]) {
                                *to = dot(turned, column);
                            }
                            product
                        }),
                    },
                    Throughputs::Column { columns } => Throughputs::Product {
                        axis,
                        columns: *columns,
                        rows: each_wavelength!(w, no_vector, {
                            let m = &answers[w];
                            scaled_vector([m[0][0], m[1][0], m[2][0], m[3][0]], weight)
                        }),
                    },
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
        let no_vector = [R::zero(); 4];
        if let (
            Throughputs::Product {
                axis,
                columns,
                rows,
            },
            Throughputs::Product {
                axis: other_axis,
                columns: other_columns,
                rows: other_rows,
            },
        ) = (a, b)
        {
            return Throughputs::Product {
                axis: V3::select(mask, *axis, *other_axis),
                columns: each_wavelength!(
                    w,
                    no_vector,
                    select_four(mask, &columns[w], &other_columns[w])
                ),
                rows: each_wavelength!(w, no_vector, select_four(mask, &rows[w], &other_rows[w])),
            };
        }
        let ((axis, a), (other_axis, b)) = (a.whole(), b.whole());
        Throughputs::Whole {
            axis: V3::select(mask, axis, other_axis),
            matrices: each_wavelength!(w, [no_vector; 4], {
                let mut chosen = b[w];
                for (to, a) in chosen.iter_mut().zip(&a[w]) {
                    *to = select_four(mask, a, to);
                }
                chosen
            }),
        }
    }
    #[inline(always)]
    fn seen<R: Real>(
        throughput: &Throughputs<R, N>,
        light: &Shine<[R; N], R>,
        k: V3<R>,
        weight: R,
    ) -> [[R; 4]; N] {
        let none = [R::zero(); 4];
        match &light.state {
            None => each_wavelength!(
                w,
                none,
                scaled_vector(throughput.first_column(w), light.radiance[w] * weight)
            ),
            Some((axis, states)) => {
                let turn = throughput.turn_to(*axis, k);
                each_wavelength!(w, none, {
                    let s0 = light.radiance[w] * weight;
                    let state = [s0, states[0][w] * s0, states[1][w] * s0, states[2][w] * s0];
                    throughput.times(w, state, turn)
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
        match answer {
            Answers::Depolarizing(m00) => each_wavelength!(
                w,
                none,
                scaled_vector(
                    throughput.first_column(w),
                    m00[w] * light.radiance[w] * weight
                )
            ),
            Answers::Diagonal(axis, elements) => {
                let turn = throughput.turn_to(*axis, k_out);
                if light.state.is_none() {
                    // of the element the first column is enough
                    return each_wavelength!(w, none, {
                        let (e, radiance) = (&elements[w], light.radiance[w] * weight);
                        let after = [e.mean * radiance, e.difference * radiance];
                        throughput.times_linear(w, after, turn)
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
                    throughput.times(w, after, turn)
                })
            }
            Answers::General(out, inward, matrices) => {
                let turn = throughput.turn_to(*out, k_out);
                if light.state.is_none() {
                    return each_wavelength!(w, none, {
                        let column = matrices[w][0];
                        let after = scaled_vector(column, light.radiance[w] * weight);
                        throughput.times(w, after, turn)
                    });
                }
                let light = arriving(*inward, light, k_in, weight);
                each_wavelength!(w, none, {
                    throughput.times(w, times_vector(&matrices[w], light[w]), turn)
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
    fn kind<R: Real>(throughput: &Throughputs<R, N>) -> usize {
        match throughput {
            Throughputs::Unit { .. } => UNIT,
            Throughputs::Whole { .. } => WHOLE,
            Throughputs::Product { .. } => PRODUCT,
            Throughputs::Column { .. } => COLUMN,
        }
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Throughputs<R, N> {
        let none = [R::zero(); 4];
        if kind == COLUMN {
            return Throughputs::Column {
                columns: each_wavelength!(w, none, four(rows, row + 4 * w, columns)),
            };
        }
        let (axis, row) = (rows.vector(row, columns), row + 3);
        match kind {
            UNIT => Throughputs::Unit { axis },
            PRODUCT => Throughputs::Product {
                axis,
                columns: each_wavelength!(w, none, four(rows, row + 8 * w, columns)),
                rows: each_wavelength!(w, none, four(rows, row + 8 * w + 4, columns)),
            },
            _ => Throughputs::Whole {
                axis,
                matrices: each_wavelength!(w, [none; 4], {
                    let mut matrix = [none; 4];
                    for (k, column) in matrix.iter_mut().enumerate() {
                        *column = four(rows, row + 16 * w + 4 * k, columns);
                    }
                    matrix
                }),
            },
        }
    }
    #[inline(always)]
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Throughputs<R, N> {
        let none = [R::zero(); 4];
        Throughputs::Column {
            columns: each_wavelength!(w, none, {
                match kind {
                    UNIT => [R::one(), R::zero(), R::zero(), R::zero()],
                    COLUMN => four(rows, row + 4 * w, columns),
                    PRODUCT => scaled_vector(
                        four(rows, row + 3 + 8 * w, columns),
                        rows.get(row + 3 + 8 * w + 4, columns),
                    ),
                    _ => four(rows, row + 3 + 16 * w, columns),
                }
            }),
        }
    }
    #[inline(always)]
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &Throughputs<R, N>,
    ) {
        match throughput {
            Throughputs::Unit { axis } => rows.put_vector(row, columns, *axis),
            Throughputs::Whole { axis, matrices } => {
                rows.put_vector(row, columns, *axis);
                for (k, column) in matrices.as_flattened().iter().enumerate() {
                    put_four(rows, row + 3 + 4 * k, columns, column);
                }
            }
            Throughputs::Product {
                axis,
                columns: own,
                rows: factors,
            } => {
                rows.put_vector(row, columns, *axis);
                for (w, (column, factor)) in own.iter().zip(factors).enumerate() {
                    put_four(rows, row + 3 + 8 * w, columns, column);
                    put_four(rows, row + 3 + 8 * w + 4, columns, factor);
                }
            }
            Throughputs::Column { columns: own } => {
                for (w, column) in own.iter().enumerate() {
                    put_four(rows, row + 4 * w, columns, column);
                }
            }
        }
    }
    #[inline(always)]
    fn strengths<R: Real>(throughput: &Throughputs<R, N>) -> R {
        let mut most = throughput.first_column(0)[0];
        for w in 1..N {
            most = most.max(throughput.first_column(w)[0]);
        }
        most
    }
    #[inline(always)]
    fn reaches<R: Real>(throughput: &Throughputs<R, N>) -> R {
        let mut most = R::zero();
        for w in 0..N {
            let [s0, a, b, c] = throughput.first_column(w);
            most = most.max(s0 + (a * a + b * b + c * c).sqrt());
        }
        most
    }
    #[inline(always)]
    fn sights<R: Real>(throughput: &Throughputs<R, N>) -> Sights<R> {
        let mut sums = [R::zero(); 3];
        let own = match throughput {
            Throughputs::Unit { axis } => return Sights::blind(*axis),
            // any axis will do
            Throughputs::Column { .. } => return Sights::blind(V3::splat(Vec3A::X)),
            Throughputs::Whole { axis, matrices } => {
                for m in matrices {
                    for (sum, column) in sums.iter_mut().zip(m) {
                        *sum = *sum + column[0];
                    }
                }
                *axis
            }
            Throughputs::Product {
                axis,
                columns,
                rows,
            } => {
                for (column, row) in columns.iter().zip(rows) {
                    for (sum, factor) in sums.iter_mut().zip(row) {
                        *sum = *sum + column[0] * *factor;
                    }
                }
                *axis
            }
        };
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
            axis: own,
            linear: [(a * shrink).only(known), (b * shrink).only(known)],
        }
    }
    #[inline(always)]
    fn scaled_lanes<R: Real>(throughput: &Throughputs<R, N>, weight: R) -> Throughputs<R, N> {
        let none = [R::zero(); 4];
        match throughput {
            Throughputs::Column { columns } => Throughputs::Column {
                columns: each_wavelength!(w, none, scaled_vector(columns[w], weight)),
            },
            Throughputs::Product {
                axis,
                columns,
                rows,
            } => Throughputs::Product {
                axis: *axis,
                columns: *columns,
                rows: each_wavelength!(w, none, scaled_vector(rows[w], weight)),
            },
            Throughputs::Unit { .. } | Throughputs::Whole { .. } => {
                let (axis, mut matrices) = throughput.whole();
                for column in matrices.as_flattened_mut() {
                    *column = scaled_vector(*column, weight);
                }
                Throughputs::Whole { axis, matrices }
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
    fn extended<R: Real>(throughput: &[R; N], answer: &[R; N], weight: R, _: V3<R>) -> [R; N] {
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
    fn kind<R: Real>(_: &[R; N]) -> usize {
        UNIT
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        _: usize,
    ) -> [R; N] {
        each_wavelength!(w, R::zero(), rows.get(row + w, columns))
    }
    #[inline(always)]
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> [R; N] {
        Self::taken(rows, row, columns, kind)
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
    fn scaled_lanes<R: Real>(throughput: &[R; N], weight: R) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * weight)
    }
}
