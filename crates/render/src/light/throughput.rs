//! The Mueller matrix of a path, from the sensor to where the path has come.

use glam::{Mat4, Vec3A, Vec4, vec4};

use super::frames::{
    double_angle, row_times_element, row_times_matrix, times_element, turn_columns, turn_row,
};
use super::{MuellerResponse, Sight};

/// The Mueller matrix of a path.
#[derive(Clone, Copy, Debug)]
pub enum MuellerThroughput<const N: usize> {
    /// Acts on light in the frame of `axis`.
    Full {
        /// First axis of the frame of the light that arrives.
        axis: Vec3A,
        /// One matrix a wavelength.
        matrices: [Mat4; N],
    },
    /// `column · rowᵀ`, after a depolarizer: `row` acts on light in the frame of `axis`.
    RankOne {
        /// First axis of the frame of the light that arrives.
        axis: Vec3A,
        /// What the sensor sees.
        columns: [Vec4; N],
        /// What it is sensitive to.
        rows: [Vec4; N],
    },
    /// `column · (1, 0, 0, 0)`: right behind a depolarizer; there is no frame.
    Intensity {
        /// What the sensor sees.
        columns: [Vec4; N],
    },
}

impl<const N: usize> MuellerThroughput<N> {
    /// Makes it a vertex longer, weighted; `k_out` is the propagation direction of the light that leaves it.
    #[inline]
    pub(super) fn lengthen(&mut self, response: MuellerResponse<N>, weight: f32, k_out: Vec3A) {
        use MuellerResponse as R;
        use MuellerThroughput as T;
        // each arm writes what it makes into place: a copy of the whole would wait for its parts
        match (&*self, response) {
            (T::Full { matrices, .. }, R::Depolarizing(m00)) => {
                *self = T::Intensity {
                    columns: std::array::from_fn(|i| matrices[i].x_axis * (m00[i] * weight)),
                };
            }
            (
                T::Full {
                    axis: old,
                    matrices,
                },
                R::Diagonal { axis, elements },
            ) => {
                let turn = double_angle(*old, axis, k_out);
                *self = T::Full {
                    axis,
                    matrices: std::array::from_fn(|i| {
                        times_element(
                            &turn_columns(&matrices[i], turn),
                            &elements[i].scaled(weight),
                        )
                    }),
                };
            }
            (
                T::Full {
                    axis: old,
                    matrices,
                },
                R::General {
                    axis_out,
                    axis_in,
                    matrices: m,
                },
            ) => {
                let turn = double_angle(*old, axis_out, k_out);
                *self = T::Full {
                    axis: axis_in,
                    matrices: std::array::from_fn(|i| {
                        turn_columns(&matrices[i], turn) * (m[i] * weight)
                    }),
                };
            }
            (T::RankOne { columns, rows, .. }, R::Depolarizing(m00)) => {
                *self = T::Intensity {
                    columns: std::array::from_fn(|i| columns[i] * (rows[i].x * m00[i] * weight)),
                };
            }
            (
                T::RankOne {
                    axis: old,
                    columns,
                    rows,
                },
                R::Diagonal { axis, elements },
            ) => {
                let turn = double_angle(*old, axis, k_out);
                *self = T::RankOne {
                    axis,
                    columns: *columns,
                    rows: std::array::from_fn(|i| {
                        row_times_element(turn_row(rows[i], turn), &elements[i].scaled(weight))
                    }),
                };
            }
            (
                T::RankOne {
                    axis: old,
                    columns,
                    rows,
                },
                R::General {
                    axis_out,
                    axis_in,
                    matrices,
                },
            ) => {
                let turn = double_angle(*old, axis_out, k_out);
                *self = T::RankOne {
                    axis: axis_in,
                    columns: *columns,
                    rows: std::array::from_fn(|i| {
                        row_times_matrix(turn_row(rows[i], turn), &matrices[i]) * weight
                    }),
                };
            }
            (T::Intensity { columns }, R::Depolarizing(m00)) => {
                *self = T::Intensity {
                    columns: std::array::from_fn(|i| columns[i] * (m00[i] * weight)),
                };
            }
            (T::Intensity { columns }, R::Diagonal { axis, elements }) => {
                *self = T::RankOne {
                    axis,
                    columns: *columns,
                    rows: std::array::from_fn(|i| {
                        vec4(elements[i].mean, elements[i].difference, 0., 0.) * weight
                    }),
                };
            }
            (
                T::Intensity { columns },
                R::General {
                    axis_in, matrices, ..
                },
            ) => {
                *self = T::RankOne {
                    axis: axis_in,
                    columns: *columns,
                    rows: std::array::from_fn(|i| row_times_matrix(Vec4::X, &matrices[i]) * weight),
                };
            }
        }
    }

    /// As one response, of a path that began in the frame of `axis`.
    pub(super) fn as_response(&self, axis: Vec3A) -> MuellerResponse<N> {
        match self {
            Self::Full {
                axis: inner,
                matrices,
            } => MuellerResponse::General {
                axis_out: axis,
                axis_in: *inner,
                matrices: *matrices,
            },
            Self::RankOne {
                axis: inner,
                columns,
                rows,
            } => MuellerResponse::General {
                axis_out: axis,
                axis_in: *inner,
                matrices: std::array::from_fn(|i| {
                    Mat4::from_cols(
                        columns[i] * rows[i].x,
                        columns[i] * rows[i].y,
                        columns[i] * rows[i].z,
                        columns[i] * rows[i].w,
                    )
                }),
            },
            Self::Intensity { columns } => MuellerResponse::General {
                axis_out: axis,
                // no frame: only S0 gets through
                axis_in: axis,
                matrices: columns.map(|c| Mat4::from_cols(c, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO)),
            },
        }
    }

    /// The largest T00 over the wavelengths.
    #[inline]
    pub(super) fn strength(&self) -> f32 {
        let strongest = |values: [f32; N]| values.into_iter().fold(0.0, f32::max);
        strongest(match self {
            Self::Full { matrices, .. } => matrices.map(|m| m.x_axis.x),
            Self::RankOne { columns, rows, .. } => {
                std::array::from_fn(|i| columns[i].x * rows[i].x)
            }
            Self::Intensity { columns } => columns.map(|c| c.x),
        })
    }

    /// The largest S0 at the sensor of light of unit radiance: T00 + |(T01, T02, T03)|.
    #[inline]
    pub(super) fn reach(&self) -> f32 {
        let most = |row: Vec4| row.x + vec4(0.0, row.y, row.z, row.w).length();
        let largest = |values: [f32; N]| values.into_iter().fold(0.0, f32::max);
        largest(match self {
            Self::Full { matrices, .. } => matrices.map(|m| most(m.row(0))),
            Self::RankOne { columns, rows, .. } => {
                std::array::from_fn(|i| columns[i].x * most(rows[i]))
            }
            Self::Intensity { columns } => columns.map(|c| c.x),
        })
    }

    /// Which linearly polarized light makes more S0 at the sensor than other light, all wavelengths together.
    #[inline]
    pub(super) fn sight(&self) -> Sight {
        let sum = |row: &dyn Fn(usize) -> [f32; 3]| {
            (0..N)
                .map(row)
                .fold([0.0; 3], |a, b| std::array::from_fn(|k| a[k] + b[k]))
        };
        match self {
            Self::Full { axis, matrices } => {
                let of = |m: &Mat4| [m.x_axis.x, m.y_axis.x, m.z_axis.x];
                Sight::new(*axis, sum(&|i| of(&matrices[i])))
            }
            Self::RankOne {
                axis,
                columns,
                rows,
            } => Sight::new(
                *axis,
                sum(&|i| [rows[i].x, rows[i].y, rows[i].z].map(|r| columns[i].x * r)),
            ),
            Self::Intensity { .. } => Sight::BLIND,
        }
    }

    /// Scales the path.
    #[inline]
    pub(super) fn scale(&mut self, weight: f32) {
        match self {
            Self::Full { matrices, .. } => {
                matrices.iter_mut().for_each(|m| *m *= weight);
            }
            Self::RankOne { columns, .. } | Self::Intensity { columns } => {
                columns.iter_mut().for_each(|c| *c *= weight);
            }
        }
    }
}
