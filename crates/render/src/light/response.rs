//! What a vertex does to Stokes vectors: a Mueller matrix, kept as small as it is.

use glam::{Mat4, Vec3A, Vec4, vec4};

use super::Element;
use super::frames::{double_angle, turn_columns, turn_vector};
use crate::geometry::frame::Frame;

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

    /// `last · diag(weight, 0, 0, 0) · first`, with the axes of each element.
    #[inline]
    pub(super) fn depolarizer_between(
        (axis_out, last): (Vec3A, Element),
        weight: impl Fn(usize) -> f32,
        (axis_in, first): (Vec3A, Element),
    ) -> Self {
        let column = vec4(last.mean, last.difference, 0., 0.);
        let outer = Mat4::from_cols(
            column * first.mean,
            column * first.difference,
            Vec4::ZERO,
            Vec4::ZERO,
        );
        Self::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(|lane| outer * weight(lane)),
        }
    }

    /// Both together; `k_out` and `k_in` are the propagation directions of the light that leaves and arrives.
    #[inline]
    pub(super) fn sum(a: Self, b: Self, k_out: Vec3A, k_in: Vec3A) -> Self {
        let (axis_out, axis_in) = match (&a, &b) {
            (Self::Depolarizing(a), Self::Depolarizing(b)) => {
                return Self::Depolarizing(std::array::from_fn(|lane| a[lane] + b[lane]));
            }
            (Self::Diagonal { axis, .. }, _)
            | (Self::Depolarizing(_), Self::Diagonal { axis, .. }) => (*axis, *axis),
            (
                Self::General {
                    axis_out, axis_in, ..
                },
                _,
            )
            | (
                Self::Depolarizing(_),
                Self::General {
                    axis_out, axis_in, ..
                },
            ) => (*axis_out, *axis_in),
        };
        let a = a.in_frames(axis_out, axis_in, k_out, k_in);
        let b = b.in_frames(axis_out, axis_in, k_out, k_in);
        Self::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(|lane| a[lane] + b[lane]),
        }
    }

    /// Axes on either side and the whole matrices; `o` and `i` are the directions toward the sensor and the light.
    #[inline]
    pub(super) fn whole(&self, o: Vec3A, i: Vec3A) -> ([Vec3A; 2], [Mat4; N]) {
        match self {
            Self::Depolarizing(m00) => (
                [o, i].map(|k| Frame::around(k).s),
                m00.map(|a| {
                    Mat4::from_cols(vec4(a, 0., 0., 0.), Vec4::ZERO, Vec4::ZERO, Vec4::ZERO)
                }),
            ),
            Self::Diagonal { axis, elements } => ([*axis; 2], elements.map(Element::matrix)),
            Self::General {
                axis_out,
                axis_in,
                matrices,
            } => ([*axis_out, *axis_in], *matrices),
        }
    }

    /// With its axes turned.
    #[inline]
    pub(super) fn map_axes(self, turn: impl Fn(Vec3A) -> Vec3A) -> Self {
        match self {
            Self::Depolarizing(_) => self,
            Self::Diagonal { axis, elements } => Self::Diagonal {
                axis: turn(axis),
                elements,
            },
            Self::General {
                axis_out,
                axis_in,
                matrices,
            } => Self::General {
                axis_out: turn(axis_out),
                axis_in: turn(axis_in),
                matrices,
            },
        }
    }
}
