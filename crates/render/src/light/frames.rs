//! The one place where Stokes frames are turned into each other, and the products of matrices, rows and elements.

use glam::{Mat4, Vec3, Vec3A, Vec4, vec4};

use super::Element;

/// cos 2θ and sin 2θ of the angle from `from` to `to`, counter-clockwise about `k`; all unit, `from` and `to` across `k`.
#[inline]
pub(super) fn double_angle(from: Vec3A, to: Vec3A, k: Vec3A) -> (f32, f32) {
    let c = from.dot(to);
    let s = k.cross(from).dot(to);
    // normalised: the axes are perpendicular to k only up to rounding. Of the reciprocal two terms are enough
    let norm = 2.0 - (c * c + s * s);
    ((c * c - s * s) * norm, 2.0 * c * s * norm)
}

/// `row · R`, where R takes Stokes vectors from frame `new` to frame `old`, (c, s) = double angle from `old` to `new`.
#[inline]
pub(super) fn turn_row(row: Vec4, (c, s): (f32, f32)) -> Vec4 {
    vec4(row.x, c * row.y + s * row.z, c * row.z - s * row.y, row.w)
}

/// `M · R` for the same R.
#[inline]
pub(super) fn turn_columns(m: &Mat4, (c, s): (f32, f32)) -> Mat4 {
    Mat4::from_cols(
        m.x_axis,
        c * m.y_axis + s * m.z_axis,
        c * m.z_axis - s * m.y_axis,
        m.w_axis,
    )
}

/// A Stokes vector taken from frame `new` to frame `old`, (c, s) = double angle from `old` to `new`.
#[inline]
pub(super) fn turn_vector(v: Vec4, (c, s): (f32, f32)) -> Vec4 {
    vec4(v.x, c * v.y - s * v.z, s * v.y + c * v.z, v.w)
}

/// `M · E` for a diagonal element E.
#[inline]
pub(super) fn times_element(m: &Mat4, e: &Element) -> Mat4 {
    Mat4::from_cols(
        e.mean * m.x_axis + e.difference * m.y_axis,
        e.difference * m.x_axis + e.mean * m.y_axis,
        e.cosine * m.z_axis - e.sine * m.w_axis,
        e.sine * m.z_axis + e.cosine * m.w_axis,
    )
}

/// `row · E`.
#[inline]
pub(super) fn row_times_element(r: Vec4, e: &Element) -> Vec4 {
    vec4(
        e.mean * r.x + e.difference * r.y,
        e.difference * r.x + e.mean * r.y,
        e.cosine * r.z - e.sine * r.w,
        e.sine * r.z + e.cosine * r.w,
    )
}

/// `row · M`.
#[inline]
pub(super) fn row_times_matrix(row: Vec4, m: &Mat4) -> Vec4 {
    vec4(
        row.dot(m.x_axis),
        row.dot(m.y_axis),
        row.dot(m.z_axis),
        row.dot(m.w_axis),
    )
}

/// `E · v`.
#[inline]
pub(super) fn element_times(e: &Element, v: Vec4) -> Vec4 {
    vec4(
        e.mean * v.x + e.difference * v.y,
        e.difference * v.x + e.mean * v.y,
        e.cosine * v.z + e.sine * v.w,
        e.cosine * v.w - e.sine * v.z,
    )
}

/// The Stokes vector of light of a given state.
#[inline]
pub(super) fn stokes(radiance: f32, state: Vec3) -> Vec4 {
    vec4(1.0, state.x, state.y, state.z) * radiance
}
