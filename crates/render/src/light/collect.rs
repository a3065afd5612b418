//! What the sensor gets of the light at the end of a path.

use glam::{Vec3A, Vec4, vec4};

use super::frames::{double_angle, element_times, stokes, turn_vector};
use super::{Emission, MuellerResponse, MuellerThroughput, Polarized};

impl<const N: usize> MuellerThroughput<N> {
    /// Light of a source at the end of the path, as the sensor sees it; `k` is its propagation direction there.
    #[inline]
    pub(super) fn collect(&self, source: &Emission<Polarized<N>>, k: Vec3A) -> [Vec4; N] {
        let radiance = &source.radiance;
        let Some((from, states)) = source.state else {
            return match self {
                Self::Full { matrices, .. } => {
                    std::array::from_fn(|i| matrices[i].x_axis * radiance[i])
                }
                Self::RankOne { columns, rows, .. } => {
                    std::array::from_fn(|i| columns[i] * (rows[i].x * radiance[i]))
                }
                Self::Intensity { columns } => std::array::from_fn(|i| columns[i] * radiance[i]),
            };
        };
        match self {
            Self::Full { axis, matrices } => {
                let turn = double_angle(*axis, from, k);
                std::array::from_fn(|i| {
                    matrices[i] * turn_vector(stokes(radiance[i], states[i]), turn)
                })
            }
            Self::RankOne {
                axis,
                columns,
                rows,
            } => {
                let turn = double_angle(*axis, from, k);
                std::array::from_fn(|i| {
                    columns[i] * rows[i].dot(turn_vector(stokes(radiance[i], states[i]), turn))
                })
            }
            Self::Intensity { columns } => std::array::from_fn(|i| columns[i] * radiance[i]),
        }
    }

    /// The same with one more vertex between the path and the source.
    #[inline]
    pub(super) fn collect_through(
        &self,
        response: MuellerResponse<N>,
        k_out: Vec3A,
        source: &Emission<Polarized<N>>,
        k_in: Vec3A,
    ) -> [Vec4; N] {
        let radiance = &source.radiance;
        // what the vertex makes of the light; of unpolarized light its first column
        let (axis, light): (Vec3A, [Vec4; N]) = match (response, source.state) {
            (MuellerResponse::Depolarizing(m00), _) => {
                let dimmed = Emission::unpolarized(|i| m00[i] * radiance[i]);
                return self.collect(&dimmed, k_out);
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
        match self {
            Self::Full {
                axis: old,
                matrices,
            } => {
                let turn = double_angle(*old, axis, k_out);
                std::array::from_fn(|i| matrices[i] * turn_vector(light[i], turn))
            }
            Self::RankOne {
                axis: old,
                columns,
                rows,
            } => {
                let turn = double_angle(*old, axis, k_out);
                std::array::from_fn(|i| columns[i] * rows[i].dot(turn_vector(light[i], turn)))
            }
            Self::Intensity { columns } => std::array::from_fn(|i| columns[i] * light[i].x),
        }
    }
}
