//! Vector transport: the algebra of Stokes vectors, and the one place where their frames are turned into each other.

use glam::{Mat4, Vec3, Vec3A, Vec4, vec4};

use super::{Element, Emission, Light, Sight};

/// Vector transport: S0, S1, S2, S3.
#[derive(Clone, Copy, Debug)]
pub struct Polarized<const N: usize>;

/// A vertex's Mueller matrix, kept as small as it is.
#[derive(Clone, Copy, Debug)]
pub enum MuellerResponse<const N: usize> {
    /// Only M00.
    Depolarizing([f32; N]),
    /// Diagonal in the frame of `axis` on both sides.
    Diagonal {
        /// First axis of both frames.
        axis: Vec3A,
        /// One element a wavelength.
        elements: [Element; N],
    },
    /// Any matrix.
    General {
        /// First axis of the frame of the light that leaves.
        axis_out: Vec3A,
        /// First axis of the frame of the light that arrives.
        axis_in: Vec3A,
        /// One matrix a wavelength.
        matrices: [Mat4; N],
    },
}

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

/// cos 2θ and sin 2θ of the angle from `from` to `to`, counter-clockwise about `k`; all unit, `from` and `to` across `k`.
#[inline]
pub(super) fn double_angle(from: Vec3A, to: Vec3A, k: Vec3A) -> (f32, f32) {
    let c = from.dot(to);
    let s = k.cross(from).dot(to);
    // normalised: the axes are perpendicular to k only up to rounding
    let norm = (c * c + s * s).recip();
    ((c * c - s * s) * norm, 2.0 * c * s * norm)
}

/// `row · R`, where R takes Stokes vectors from frame `new` to frame `old`, (c, s) = double angle from `old` to `new`.
#[inline]
fn turn_row(row: Vec4, (c, s): (f32, f32)) -> Vec4 {
    vec4(row.x, c * row.y + s * row.z, c * row.z - s * row.y, row.w)
}

/// `M · R` for the same R.
#[inline]
fn turn_columns(m: &Mat4, (c, s): (f32, f32)) -> Mat4 {
    Mat4::from_cols(
        m.x_axis,
        c * m.y_axis + s * m.z_axis,
        c * m.z_axis - s * m.y_axis,
        m.w_axis,
    )
}

/// A Stokes vector taken from frame `new` to frame `old`, (c, s) = double angle from `old` to `new`.
#[inline]
fn turn_vector(v: Vec4, (c, s): (f32, f32)) -> Vec4 {
    vec4(v.x, c * v.y - s * v.z, s * v.y + c * v.z, v.w)
}

/// `M · E` for a diagonal element E.
#[inline]
fn times_element(m: &Mat4, e: &Element) -> Mat4 {
    Mat4::from_cols(
        e.mean * m.x_axis + e.difference * m.y_axis,
        e.difference * m.x_axis + e.mean * m.y_axis,
        e.cosine * m.z_axis - e.sine * m.w_axis,
        e.sine * m.z_axis + e.cosine * m.w_axis,
    )
}

/// `row · E`.
#[inline]
fn row_times_element(r: Vec4, e: &Element) -> Vec4 {
    vec4(
        e.mean * r.x + e.difference * r.y,
        e.difference * r.x + e.mean * r.y,
        e.cosine * r.z - e.sine * r.w,
        e.sine * r.z + e.cosine * r.w,
    )
}

/// `row · M`.
#[inline]
fn row_times_matrix(row: Vec4, m: &Mat4) -> Vec4 {
    vec4(
        row.dot(m.x_axis),
        row.dot(m.y_axis),
        row.dot(m.z_axis),
        row.dot(m.w_axis),
    )
}

/// `E · v`.
#[inline]
fn element_times(e: &Element, v: Vec4) -> Vec4 {
    vec4(
        e.mean * v.x + e.difference * v.y,
        e.difference * v.x + e.mean * v.y,
        e.cosine * v.z + e.sine * v.w,
        e.cosine * v.w - e.sine * v.z,
    )
}

/// The Stokes vector of light of a given state.
#[inline]
fn stokes(radiance: f32, state: Vec3) -> Vec4 {
    vec4(1.0, state.x, state.y, state.z) * radiance
}

impl<const N: usize> MuellerResponse<N> {
    /// As general matrices in the frames of `axis_out`, `axis_in`.
    fn in_frames(&self, axis_out: Vec3A, axis_in: Vec3A, k_out: Vec3A, k_in: Vec3A) -> [Mat4; N] {
        match self {
            Self::Depolarizing(m00) => m00
                .map(|a| Mat4::from_cols(vec4(a, 0., 0., 0.), Vec4::ZERO, Vec4::ZERO, Vec4::ZERO)),
            Self::Diagonal { axis, elements } => Self::General {
                axis_out: *axis,
                axis_in: *axis,
                matrices: elements.map(Element::matrix),
            }
            .in_frames(axis_out, axis_in, k_out, k_in),
            Self::General {
                axis_out: own_out,
                axis_in: own_in,
                matrices,
            } => {
                let out = double_angle(axis_out, *own_out, k_out);
                let inward = double_angle(*own_in, axis_in, k_in);
                matrices.map(|m| {
                    let m = turn_columns(&m, inward);
                    Mat4::from_cols(
                        turn_vector(m.x_axis, out),
                        turn_vector(m.y_axis, out),
                        turn_vector(m.z_axis, out),
                        turn_vector(m.w_axis, out),
                    )
                })
            }
        }
    }
}

impl<const N: usize> Light for Polarized<N> {
    const LANES: usize = N;
    const POLARIZED: bool = true;
    type Response = MuellerResponse<N>;
    type Throughput = MuellerThroughput<N>;
    type Lanes = [f32; N];
    type States = [Vec3; N];
    type Stokes = [Vec4; N];

    #[inline]
    fn lanes(value: impl Fn(usize) -> f32) -> [f32; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn states(value: impl Fn(usize) -> Vec3) -> [Vec3; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn dark() -> [Vec4; N] {
        [Vec4::ZERO; N]
    }
    #[inline]
    fn depolarizing(value: impl Fn(usize) -> f32) -> Self::Response {
        MuellerResponse::Depolarizing(std::array::from_fn(value))
    }
    #[inline]
    fn diattenuating_retarder(axis: Vec3A, element: impl Fn(usize) -> Element) -> Self::Response {
        MuellerResponse::Diagonal {
            axis,
            elements: std::array::from_fn(element),
        }
    }
    #[inline]
    fn depolarizer_between(
        (axis_out, last): (Vec3A, Element),
        weight: impl Fn(usize) -> f32,
        (axis_in, first): (Vec3A, Element),
    ) -> Self::Response {
        let column = vec4(last.mean, last.difference, 0., 0.);
        let outer = Mat4::from_cols(
            column * first.mean,
            column * first.difference,
            Vec4::ZERO,
            Vec4::ZERO,
        );
        MuellerResponse::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(|lane| outer * weight(lane)),
        }
    }
    #[inline]
    fn general(axis_out: Vec3A, axis_in: Vec3A, matrix: impl Fn(usize) -> Mat4) -> Self::Response {
        MuellerResponse::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(matrix),
        }
    }
    #[inline]
    fn sum(a: Self::Response, b: Self::Response, k_out: Vec3A, k_in: Vec3A) -> Self::Response {
        let (axis_out, axis_in) = match a {
            MuellerResponse::Depolarizing(_) => match b {
                MuellerResponse::Depolarizing(_) => {
                    let (MuellerResponse::Depolarizing(a), MuellerResponse::Depolarizing(b)) =
                        (a, b)
                    else {
                        return a;
                    };
                    return MuellerResponse::Depolarizing(std::array::from_fn(|lane| {
                        a[lane] + b[lane]
                    }));
                }
                MuellerResponse::Diagonal { axis, .. } => (axis, axis),
                MuellerResponse::General {
                    axis_out, axis_in, ..
                } => (axis_out, axis_in),
            },
            MuellerResponse::Diagonal { axis, .. } => (axis, axis),
            MuellerResponse::General {
                axis_out, axis_in, ..
            } => (axis_out, axis_in),
        };
        let a = a.in_frames(axis_out, axis_in, k_out, k_in);
        let b = b.in_frames(axis_out, axis_in, k_out, k_in);
        MuellerResponse::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(|lane| a[lane] + b[lane]),
        }
    }
    #[inline]
    fn map_axes(response: Self::Response, turn: impl Fn(Vec3A) -> Vec3A) -> Self::Response {
        match response {
            MuellerResponse::Depolarizing(_) => response,
            MuellerResponse::Diagonal { axis, elements } => MuellerResponse::Diagonal {
                axis: turn(axis),
                elements,
            },
            MuellerResponse::General {
                axis_out,
                axis_in,
                matrices,
            } => MuellerResponse::General {
                axis_out: turn(axis_out),
                axis_in: turn(axis_in),
                matrices,
            },
        }
    }

    #[inline]
    fn identity(axis: Vec3A) -> Self::Throughput {
        MuellerThroughput::Full {
            axis,
            matrices: [Mat4::IDENTITY; N],
        }
    }

    #[inline]
    fn extend(
        throughput: &Self::Throughput,
        response: Self::Response,
        weight: f32,
        k_out: Vec3A,
    ) -> Self::Throughput {
        use MuellerResponse as R;
        use MuellerThroughput as T;
        match (throughput, response) {
            (T::Full { matrices, .. }, R::Depolarizing(m00)) => T::Intensity {
                columns: std::array::from_fn(|i| matrices[i].x_axis * (m00[i] * weight)),
            },
            (
                T::Full {
                    axis: old,
                    matrices,
                },
                R::Diagonal { axis, elements },
            ) => {
                let turn = double_angle(*old, axis, k_out);
                T::Full {
                    axis,
                    matrices: std::array::from_fn(|i| {
                        times_element(
                            &turn_columns(&matrices[i], turn),
                            &elements[i].scaled(weight),
                        )
                    }),
                }
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
                T::Full {
                    axis: axis_in,
                    matrices: std::array::from_fn(|i| {
                        turn_columns(&matrices[i], turn) * (m[i] * weight)
                    }),
                }
            }
            (T::RankOne { columns, rows, .. }, R::Depolarizing(m00)) => T::Intensity {
                columns: std::array::from_fn(|i| columns[i] * (rows[i].x * m00[i] * weight)),
            },
            (
                T::RankOne {
                    axis: old,
                    columns,
                    rows,
                },
                R::Diagonal { axis, elements },
            ) => {
                let turn = double_angle(*old, axis, k_out);
                T::RankOne {
                    axis,
                    columns: *columns,
                    rows: std::array::from_fn(|i| {
                        row_times_element(turn_row(rows[i], turn), &elements[i].scaled(weight))
                    }),
                }
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
                T::RankOne {
                    axis: axis_in,
                    columns: *columns,
                    rows: std::array::from_fn(|i| {
                        row_times_matrix(turn_row(rows[i], turn), &matrices[i]) * weight
                    }),
                }
            }
            (T::Intensity { columns }, R::Depolarizing(m00)) => T::Intensity {
                columns: std::array::from_fn(|i| columns[i] * (m00[i] * weight)),
            },
            (T::Intensity { columns }, R::Diagonal { axis, elements }) => T::RankOne {
                axis,
                columns: *columns,
                rows: std::array::from_fn(|i| {
                    vec4(elements[i].mean, elements[i].difference, 0., 0.) * weight
                }),
            },
            (
                T::Intensity { columns },
                R::General {
                    axis_in, matrices, ..
                },
            ) => T::RankOne {
                axis: axis_in,
                columns: *columns,
                rows: std::array::from_fn(|i| row_times_matrix(Vec4::X, &matrices[i]) * weight),
            },
        }
    }

    fn as_response(throughput: &Self::Throughput, axis: Vec3A) -> Self::Response {
        match throughput {
            MuellerThroughput::Full {
                axis: inner,
                matrices,
            } => MuellerResponse::General {
                axis_out: axis,
                axis_in: *inner,
                matrices: *matrices,
            },
            MuellerThroughput::RankOne {
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
            MuellerThroughput::Intensity { columns } => MuellerResponse::General {
                axis_out: axis,
                // no frame: only S0 gets through
                axis_in: axis,
                matrices: columns.map(|c| Mat4::from_cols(c, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO)),
            },
        }
    }

    #[inline]
    fn collect(throughput: &Self::Throughput, source: &Emission<Self>, k: Vec3A) -> [Vec4; N] {
        let radiance = &source.radiance;
        let Some((from, states)) = source.state else {
            return match throughput {
                MuellerThroughput::Full { matrices, .. } => {
                    std::array::from_fn(|i| matrices[i].x_axis * radiance[i])
                }
                MuellerThroughput::RankOne { columns, rows, .. } => {
                    std::array::from_fn(|i| columns[i] * (rows[i].x * radiance[i]))
                }
                MuellerThroughput::Intensity { columns } => {
                    std::array::from_fn(|i| columns[i] * radiance[i])
                }
            };
        };
        match throughput {
            MuellerThroughput::Full { axis, matrices } => {
                let turn = double_angle(*axis, from, k);
                std::array::from_fn(|i| {
                    matrices[i] * turn_vector(stokes(radiance[i], states[i]), turn)
                })
            }
            MuellerThroughput::RankOne {
                axis,
                columns,
                rows,
            } => {
                let turn = double_angle(*axis, from, k);
                std::array::from_fn(|i| {
                    columns[i] * rows[i].dot(turn_vector(stokes(radiance[i], states[i]), turn))
                })
            }
            MuellerThroughput::Intensity { columns } => {
                std::array::from_fn(|i| columns[i] * radiance[i])
            }
        }
    }

    #[inline]
    fn collect_through(
        throughput: &Self::Throughput,
        response: Self::Response,
        k_out: Vec3A,
        source: &Emission<Self>,
        k_in: Vec3A,
    ) -> [Vec4; N] {
        use MuellerThroughput as T;
        let radiance = &source.radiance;
        // what the vertex makes of the light; of unpolarized light its first column
        let (axis, light): (Vec3A, [Vec4; N]) = match (response, source.state) {
            (MuellerResponse::Depolarizing(m00), _) => {
                let dimmed = Emission::unpolarized(|i| m00[i] * radiance[i]);
                return Self::collect(throughput, &dimmed, k_out);
            }
            (MuellerResponse::Diagonal { axis, elements }, None) => (
                axis,
                std::array::from_fn(|i| {
                    vec4(elements[i].mean, elements[i].difference, 0., 0.) * radiance[i]
                }),
            ),
            (MuellerResponse::Diagonal { axis, elements }, Some((from, states))) => {
                let turn = double_angle(axis, from, k_in);
                (
                    axis,
                    std::array::from_fn(|i| {
                        element_times(
                            &elements[i],
                            turn_vector(stokes(radiance[i], states[i]), turn),
                        )
                    }),
                )
            }
            (
                MuellerResponse::General {
                    axis_out, matrices, ..
                },
                None,
            ) => (
                axis_out,
                std::array::from_fn(|i| matrices[i].x_axis * radiance[i]),
            ),
            (
                MuellerResponse::General {
                    axis_out,
                    axis_in,
                    matrices,
                },
                Some((from, states)),
            ) => {
                let turn = double_angle(axis_in, from, k_in);
                (
                    axis_out,
                    std::array::from_fn(|i| {
                        matrices[i] * turn_vector(stokes(radiance[i], states[i]), turn)
                    }),
                )
            }
        };
        match throughput {
            T::Full {
                axis: old,
                matrices,
            } => {
                let turn = double_angle(*old, axis, k_out);
                std::array::from_fn(|i| matrices[i] * turn_vector(light[i], turn))
            }
            T::RankOne {
                axis: old,
                columns,
                rows,
            } => {
                let turn = double_angle(*old, axis, k_out);
                std::array::from_fn(|i| columns[i] * rows[i].dot(turn_vector(light[i], turn)))
            }
            T::Intensity { columns } => std::array::from_fn(|i| columns[i] * light[i].x),
        }
    }

    #[inline]
    fn accumulate(sum: &mut [Vec4; N], more: [Vec4; N], weight: f32) {
        for lane in 0..N {
            sum[lane] += more[lane] * weight;
        }
    }

    #[inline]
    fn strength(throughput: &Self::Throughput) -> f32 {
        let strongest = |values: [f32; N]| values.into_iter().fold(0.0, f32::max);
        strongest(match throughput {
            MuellerThroughput::Full { matrices, .. } => matrices.map(|m| m.x_axis.x),
            MuellerThroughput::RankOne { columns, rows, .. } => {
                std::array::from_fn(|i| columns[i].x * rows[i].x)
            }
            MuellerThroughput::Intensity { columns } => columns.map(|c| c.x),
        })
    }

    #[inline]
    fn sight(throughput: &Self::Throughput) -> Sight {
        let sum = |row: &dyn Fn(usize) -> [f32; 3]| {
            (0..N)
                .map(row)
                .fold([0.0; 3], |a, b| std::array::from_fn(|k| a[k] + b[k]))
        };
        match throughput {
            MuellerThroughput::Full { axis, matrices } => {
                let of = |m: &Mat4| [m.x_axis.x, m.y_axis.x, m.z_axis.x];
                Sight::new(*axis, sum(&|i| of(&matrices[i])))
            }
            MuellerThroughput::RankOne {
                axis,
                columns,
                rows,
            } => Sight::new(
                *axis,
                sum(&|i| [rows[i].x, rows[i].y, rows[i].z].map(|r| columns[i].x * r)),
            ),
            MuellerThroughput::Intensity { .. } => Sight::BLIND,
        }
    }

    #[inline]
    fn scale(throughput: &mut Self::Throughput, weight: f32) {
        match throughput {
            MuellerThroughput::Full { matrices, .. } => {
                matrices.iter_mut().for_each(|m| *m *= weight);
            }
            MuellerThroughput::RankOne { columns, .. }
            | MuellerThroughput::Intensity { columns } => {
                columns.iter_mut().for_each(|c| *c *= weight);
            }
        }
    }
}
