//! Throughputs of paths side by side, kept as small as the path allows.
//!
//! Lanes that work together have throughputs of one kind, so that all do the same.

use glam::Vec3A;

use super::algebra::{
    Matrices, dot, double_angles, first, row_times_element, scaled_vector, times_elements,
    times_vector, turned_columns, turned_element, turned_row, turned_vector, unpolarized,
};
use super::polarized::Answers;
use super::{Sights, each_wavelength};
use crate::lanes::{Columns, Mask, Packed, Real, Rows, V3};

/// Mueller matrices of paths, from the frame of `axis` to that of the sensor, all of one kind.
#[derive(Clone, Copy, Debug)]
pub enum Throughputs<R, const N: usize, const S: usize> {
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
        matrices: [Matrices<R, S>; N],
    },
    /// A column times a row: the path has met a depolarizer.
    Product {
        /// First axis of the Stokes frame.
        axis: V3<R>,
        /// What of the path the sensor sees.
        columns: [[R; S]; N],
        /// What of light goes that way.
        rows: [[R; S]; N],
    },
    /// A column times (1, 0, 0, 0): only the radiance matters, since the path has just met a depolarizer.
    Column {
        /// What of the path the sensor sees.
        columns: [[R; S]; N],
    },
    /// (1, 0, 0, 0) times a row: a depolarizer was the first that the path has met, so that the sensor sees S0 alone.
    Row {
        /// First axis of the Stokes frame.
        axis: V3<R>,
        /// What of light goes that way.
        rows: [[R; S]; N],
    },
    /// Both: S0 at the sensor over S0 here.
    Scalar {
        /// One number a wavelength.
        factors: [R; N],
    },
}

const UNIT: usize = 0;
const WHOLE: usize = 1;
const PRODUCT: usize = 2;
const COLUMN: usize = 3;
const ROW: usize = 4;
const SCALAR: usize = 5;

/// Vectors of numbers in as many rows.
#[inline(always)]
fn vectors<R: Real, const S: usize, const ROWS: usize>(
    rows: &Rows<ROWS>,
    row: usize,
    columns: Columns<R>,
) -> [R; S] {
    let mut all = [R::zero(); S];
    for (k, to) in all.iter_mut().enumerate() {
        *to = rows.get(row + k, columns);
    }
    all
}

#[inline(always)]
fn put_vectors<R: Real, const S: usize, const ROWS: usize>(
    rows: &mut Rows<ROWS>,
    row: usize,
    columns: Packed<R>,
    v: &[R; S],
) {
    for (k, value) in v.iter().enumerate() {
        rows.put(row + k, columns, *value);
    }
}

#[inline(always)]
fn select_vectors<R: Real, const S: usize>(mask: R::M, a: &[R; S], b: &[R; S]) -> [R; S] {
    let mut chosen = *b;
    for (to, a) in chosen.iter_mut().zip(a) {
        *to = R::select(mask, *a, *to);
    }
    chosen
}

impl<R: Real, const N: usize, const S: usize> Throughputs<R, N, S> {
    /// Whether the sensor sees nothing of it but S0.
    #[inline(always)]
    pub(super) fn shows_intensity_alone(&self) -> bool {
        matches!(self, Self::Row { .. } | Self::Scalar { .. })
    }

    /// The first column, of one wavelength.
    #[inline(always)]
    pub(super) fn first_column(&self, w: usize) -> [R; S] {
        match self {
            Self::Unit { .. } => first(),
            Self::Whole { matrices, .. } => matrices[w][0],
            Self::Product { columns, rows, .. } => scaled_vector(columns[w], rows[w][0]),
            Self::Column { columns } => columns[w],
            Self::Row { rows, .. } => unpolarized(rows[w][0]),
            Self::Scalar { factors } => unpolarized(factors[w]),
        }
    }

    /// The double angle from its frame to that of an axis; none that matters where no frame does.
    #[inline(always)]
    pub(super) fn turn_to(&self, to: V3<R>, k: V3<R>) -> (R, R) {
        match self {
            Self::Unit { axis }
            | Self::Whole { axis, .. }
            | Self::Product { axis, .. }
            | Self::Row { axis, .. } => double_angles(*axis, to, k),
            Self::Column { .. } | Self::Scalar { .. } => (R::one(), R::zero()),
        }
    }

    /// A Stokes vector in a frame that is turned by the double angle, as the sensor sees it, of one wavelength.
    #[inline(always)]
    pub(super) fn times(&self, w: usize, v: [R; S], turn: (R, R)) -> [R; S] {
        match self {
            Self::Unit { .. } => turned_vector(v, turn),
            Self::Whole { matrices, .. } => times_vector(&matrices[w], turned_vector(v, turn)),
            Self::Product { columns, rows, .. } => {
                scaled_vector(columns[w], dot(rows[w], turned_vector(v, turn)))
            }
            Self::Column { columns } => scaled_vector(columns[w], v[0]),
            Self::Row { rows, .. } => unpolarized(dot(rows[w], turned_vector(v, turn))),
            Self::Scalar { factors } => unpolarized(factors[w] * v[0]),
        }
    }

    /// The same of unpolarized light, with the same bits.
    #[inline(always)]
    pub(super) fn times_unpolarized(&self, w: usize, s0: R) -> [R; S] {
        match self {
            Self::Product { columns, rows, .. } => scaled_vector(columns[w], rows[w][0] * s0),
            _ => scaled_vector(self.first_column(w), s0),
        }
    }

    /// The same of light whose state is (a, b, 0, 0).
    #[inline(always)]
    pub(super) fn times_linear(&self, w: usize, [a, b]: [R; 2], (c, s): (R, R)) -> [R; S] {
        match self {
            Self::Unit { .. } => {
                let mut v = [R::zero(); S];
                v[0] = a;
                v[1] = c * b;
                v[2] = s * b;
                v
            }
            Self::Whole { matrices, .. } => {
                let (m, b1, b2) = (&matrices[w], c * b, s * b);
                let mut sum = [R::zero(); S];
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
            Self::Row { rows, .. } => {
                let (row, b1, b2) = (rows[w], c * b, s * b);
                unpolarized(row[0] * a + row[1] * b1 + row[2] * b2)
            }
            Self::Scalar { factors } => unpolarized(factors[w] * a),
        }
    }

    /// As whole matrices.
    #[inline(always)]
    pub(super) fn whole(&self) -> (V3<R>, [Matrices<R, S>; N]) {
        let (zero, one) = (R::zero(), R::one());
        let mut all = [[[zero; S]; S]; N];
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
            Self::Row { axis: own, rows } => {
                axis = *own;
                for (matrix, row) in all.iter_mut().zip(rows) {
                    for (to, factor) in matrix.iter_mut().zip(row) {
                        to[0] = *factor;
                    }
                }
            }
            Self::Scalar { factors } => {
                for (matrix, factor) in all.iter_mut().zip(factors) {
                    matrix[0][0] = *factor;
                }
            }
        }
        (axis, all)
    }

    /// Longer by a vertex, weighted; `k_out` is the direction of light that leaves it.
    #[inline(always)]
    pub(super) fn extended(&self, answer: &Answers<R, N, S>, weight: R, k_out: V3<R>) -> Self {
        let (no_matrix, no_vector) = ([[R::zero(); S]; S], [R::zero(); S]);
        match answer {
            Answers::Depolarizing(m00) => match self {
                Throughputs::Unit { .. } => Throughputs::Scalar {
                    factors: each_wavelength!(w, R::zero(), m00[w] * weight),
                },
                Throughputs::Row { .. } | Throughputs::Scalar { .. } => Throughputs::Scalar {
                    factors: each_wavelength!(
                        w,
                        R::zero(),
                        self.first_column(w)[0] * (m00[w] * weight)
                    ),
                },
                _ => Throughputs::Column {
                    columns: each_wavelength!(
                        w,
                        no_vector,
                        scaled_vector(self.first_column(w), m00[w] * weight)
                    ),
                },
            },
            Answers::Diagonal(axis, elements) => {
                let (axis, turn) = (*axis, self.turn_to(*axis, k_out));
                match self {
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
                            let mut row = no_vector;
                            row[0] = e.mean;
                            row[1] = e.difference;
                            row
                        }),
                    },
                    Throughputs::Row { rows, .. } => Throughputs::Row {
                        axis,
                        rows: each_wavelength!(
                            w,
                            no_vector,
                            row_times_element(
                                turned_row(rows[w], turn),
                                &elements[w].scaled(weight)
                            )
                        ),
                    },
                    Throughputs::Scalar { factors } => Throughputs::Row {
                        axis,
                        rows: each_wavelength!(w, no_vector, {
                            let e = elements[w].scaled(factors[w] * weight);
                            let mut row = no_vector;
                            row[0] = e.mean;
                            row[1] = e.difference;
                            row
                        }),
                    },
                }
            }
            Answers::General(out, inward, answers) => {
                let (axis, turn) = (*inward, self.turn_to(*out, k_out));
                match self {
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
                            let mut row = no_vector;
                            for (to, column) in row.iter_mut().zip(answers[w]) {
                                *to = column[0] * weight;
                            }
                            row
                        }),
                    },
                    Throughputs::Row { rows, .. } => Throughputs::Row {
                        axis,
                        rows: each_wavelength!(w, no_vector, {
                            let turned = scaled_vector(turned_row(rows[w], turn), weight);
                            let mut product = no_vector;
                            for (to, column) in product.iter_mut().zip(answers[w]) {
                                *to = dot(turned, column);
                            }
                            product
                        }),
                    },
                    Throughputs::Scalar { factors } => Throughputs::Row {
                        axis,
                        rows: each_wavelength!(w, no_vector, {
                            let factor = factors[w] * weight;
                            let mut row = no_vector;
                            for (to, column) in row.iter_mut().zip(answers[w]) {
                                *to = column[0] * factor;
                            }
                            row
                        }),
                    },
                }
            }
        }
    }

    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub(super) fn select(mask: R::M, a: &Self, b: &Self) -> Self {
        let no_vector = [R::zero(); S];
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
                    select_vectors(mask, &columns[w], &other_columns[w])
                ),
                rows: each_wavelength!(
                    w,
                    no_vector,
                    select_vectors(mask, &rows[w], &other_rows[w])
                ),
            };
        }
        if let (
            Throughputs::Row { axis, rows },
            Throughputs::Row {
                axis: other_axis,
                rows: other_rows,
            },
        ) = (a, b)
        {
            return Throughputs::Row {
                axis: V3::select(mask, *axis, *other_axis),
                rows: each_wavelength!(
                    w,
                    no_vector,
                    select_vectors(mask, &rows[w], &other_rows[w])
                ),
            };
        }
        let ((axis, a), (other_axis, b)) = (a.whole(), b.whole());
        Throughputs::Whole {
            axis: V3::select(mask, axis, other_axis),
            matrices: each_wavelength!(w, [no_vector; S], {
                let mut chosen = b[w];
                for (to, a) in chosen.iter_mut().zip(&a[w]) {
                    *to = select_vectors(mask, a, to);
                }
                chosen
            }),
        }
    }

    /// See [`Abreast::kind`](super::Abreast::kind).
    #[inline(always)]
    pub(super) fn kind(&self) -> usize {
        match self {
            Throughputs::Unit { .. } => UNIT,
            Throughputs::Whole { .. } => WHOLE,
            Throughputs::Product { .. } => PRODUCT,
            Throughputs::Column { .. } => COLUMN,
            Throughputs::Row { .. } => ROW,
            Throughputs::Scalar { .. } => SCALAR,
        }
    }

    /// See [`Abreast::taken`](super::Abreast::taken).
    #[inline(always)]
    pub(super) fn taken<const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Self {
        let none = [R::zero(); S];
        match kind {
            COLUMN => {
                return Throughputs::Column {
                    columns: each_wavelength!(w, none, vectors(rows, row + S * w, columns)),
                };
            }
            SCALAR => {
                return Throughputs::Scalar {
                    factors: each_wavelength!(w, R::zero(), rows.get(row + w, columns)),
                };
            }
            _ => {}
        }
        let (axis, row) = (rows.vector(row, columns), row + 3);
        match kind {
            UNIT => Throughputs::Unit { axis },
            ROW => Throughputs::Row {
                axis,
                rows: each_wavelength!(w, none, vectors(rows, row + S * w, columns)),
            },
            PRODUCT => Throughputs::Product {
                axis,
                columns: each_wavelength!(w, none, vectors(rows, row + 2 * S * w, columns)),
                rows: each_wavelength!(w, none, vectors(rows, row + 2 * S * w + S, columns)),
            },
            _ => Throughputs::Whole {
                axis,
                matrices: each_wavelength!(w, [none; S], {
                    let mut matrix = [none; S];
                    for (k, column) in matrix.iter_mut().enumerate() {
                        *column = vectors(rows, row + S * (S * w + k), columns);
                    }
                    matrix
                }),
            },
        }
    }

    /// See [`Abreast::taken_for_unpolarized`](super::Abreast::taken_for_unpolarized).
    #[inline(always)]
    pub(super) fn taken_for_unpolarized<const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Self {
        let (zero, none) = (R::zero(), [R::zero(); S]);
        match kind {
            UNIT => Throughputs::Scalar {
                factors: [R::one(); N],
            },
            SCALAR => Throughputs::Scalar {
                factors: each_wavelength!(w, zero, rows.get(row + w, columns)),
            },
            ROW => Throughputs::Scalar {
                factors: each_wavelength!(w, zero, rows.get(row + 3 + S * w, columns)),
            },
            COLUMN => Throughputs::Column {
                columns: each_wavelength!(w, none, vectors(rows, row + S * w, columns)),
            },
            PRODUCT => Throughputs::Column {
                columns: each_wavelength!(
                    w,
                    none,
                    scaled_vector(
                        vectors(rows, row + 3 + 2 * S * w, columns),
                        rows.get(row + 3 + 2 * S * w + S, columns),
                    )
                ),
            },
            _ => Throughputs::Column {
                columns: each_wavelength!(w, none, vectors(rows, row + 3 + S * S * w, columns)),
            },
        }
    }

    /// See [`Abreast::put`](super::Abreast::put).
    #[inline(always)]
    pub(super) fn put<const ROWS: usize>(
        &self,
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
    ) {
        match self {
            Throughputs::Unit { axis } => rows.put_vector(row, columns, *axis),
            Throughputs::Whole { axis, matrices } => {
                rows.put_vector(row, columns, *axis);
                for (k, column) in matrices.as_flattened().iter().enumerate() {
                    put_vectors(rows, row + 3 + S * k, columns, column);
                }
            }
            Throughputs::Product {
                axis,
                columns: own,
                rows: factors,
            } => {
                rows.put_vector(row, columns, *axis);
                for (w, (column, factor)) in own.iter().zip(factors).enumerate() {
                    put_vectors(rows, row + 3 + 2 * S * w, columns, column);
                    put_vectors(rows, row + 3 + 2 * S * w + S, columns, factor);
                }
            }
            Throughputs::Column { columns: own } => {
                for (w, column) in own.iter().enumerate() {
                    put_vectors(rows, row + S * w, columns, column);
                }
            }
            Throughputs::Row { axis, rows: own } => {
                rows.put_vector(row, columns, *axis);
                for (w, factor) in own.iter().enumerate() {
                    put_vectors(rows, row + 3 + S * w, columns, factor);
                }
            }
            Throughputs::Scalar { factors } => {
                for (w, factor) in factors.iter().enumerate() {
                    rows.put(row + w, columns, *factor);
                }
            }
        }
    }

    /// See [`Light::sight`](crate::light::Light::sight).
    #[inline(always)]
    pub(super) fn sights(&self) -> Sights<R> {
        let mut sums = [R::zero(); 3];
        let own = match self {
            Throughputs::Unit { axis } => return Sights::blind(*axis),
            // any axis will do
            Throughputs::Column { .. } | Throughputs::Scalar { .. } => {
                return Sights::blind(V3::splat(Vec3A::X));
            }
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
            Throughputs::Row { axis, rows } => {
                for row in rows {
                    for (sum, factor) in sums.iter_mut().zip(row) {
                        *sum = *sum + *factor;
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

    /// Times a number a path.
    #[inline(always)]
    pub(super) fn scaled(&self, weight: R) -> Self {
        let none = [R::zero(); S];
        match self {
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
            Throughputs::Row { axis, rows } => Throughputs::Row {
                axis: *axis,
                rows: each_wavelength!(w, none, scaled_vector(rows[w], weight)),
            },
            Throughputs::Scalar { factors } => Throughputs::Scalar {
                factors: each_wavelength!(w, R::zero(), factors[w] * weight),
            },
            Throughputs::Unit { .. } | Throughputs::Whole { .. } => {
                let (axis, mut matrices) = self.whole();
                for column in matrices.as_flattened_mut() {
                    *column = scaled_vector(*column, weight);
                }
                Throughputs::Whole { axis, matrices }
            }
        }
    }
}
