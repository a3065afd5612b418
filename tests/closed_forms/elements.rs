//! Mueller calculus of ideal elements in f64, and the pieces that scenes are made of.

use glam::DVec3;

/// What single precision may cost in a few matrix products of numbers around one.
pub(crate) const ROUND_OFF: f64 = 3e-6;

/// A Stokes vector or a row of a Mueller matrix.
pub(crate) type Four = [f64; 4];

pub(crate) fn times(m: [Four; 4], s: Four) -> Four {
    m.map(|row| row.iter().zip(s).map(|(a, b)| a * b).sum())
}

/// Stokes vectors in a frame that is turned by `t` radians counter-clockwise, as the observer sees it.
pub(crate) fn turned(t: f64, s: Four) -> Four {
    let (sin, cos) = (2.0 * t).sin_cos();
    times(
        [
            [1., 0., 0., 0.],
            [0., cos, sin, 0.],
            [0., -sin, cos, 0.],
            [0., 0., 0., 1.],
        ],
        s,
    )
}

/// Behind an ideal polarizer that transmits along the angle `t` from the image's right, counter-clockwise.
pub(crate) fn polarizer(t: f64, s: Four) -> Four {
    let half = [[0.5, 0.5, 0., 0.], [0.5, 0.5, 0., 0.], [0.; 4], [0.; 4]];
    turned(-t, times(half, turned(t, s)))
}

/// Behind a retarder with its fast axis at the angle `t`; `delta` is the lead of the fast axis, radians.
pub(crate) fn retarder(t: f64, delta: f64, s: Four) -> Four {
    let (sin, cos) = delta.sin_cos();
    let lead = [
        [1., 0., 0., 0.],
        [0., 1., 0., 0.],
        [0., 0., cos, sin],
        [0., 0., -sin, cos],
    ];
    turned(-t, times(lead, turned(t, s)))
}

/// Behind a circular polarizer that passes S3 > 0 (`sign` 1) or S3 < 0 (`sign` -1).
pub(crate) fn circular(sign: f64, s: Four) -> Four {
    let i = 0.5 * (s[0] + sign * s[3]);
    [i, 0.0, 0.0, sign * i]
}

pub(crate) const LAMP: Four = [1.0, 0.0, 0.0, 0.0];

pub(crate) fn degrees(angle: f64) -> f64 {
    angle.to_radians()
}

/// A rectangle with matter, placed by the given transform elements.
pub(crate) fn plate(bsdf: &str, placement: &str) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'>{placement}</transform>{bsdf}</shape>"
    )
}

pub(crate) fn polarizer_xml(theta: f64) -> String {
    format!("<bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf>")
}

/// A lamp of radiance 1 behind everything, facing +z.
pub(crate) const LAMP_XML: &str = "<shape type='rectangle'><transform name='to_world'><scale value='200'/><translate z='-3'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";

pub(crate) const SURROUNDINGS: &str =
    "<emitter type='constant'><float name='radiance' value='1'/></emitter>";

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    DVec3::from(a).cross(b.into()).into()
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from(a).dot(b.into())
}

pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    DVec3::from(a).normalize().into()
}

/// Reflectances of s- and p-polarized light at a glass of index n.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.2, Eq. (21a): by sines and tangents of the angles.
pub(crate) fn reflectances(n: f64, angle: f64) -> (f64, f64) {
    if angle < 1e-6 {
        let normal = ((n - 1.0) / (n + 1.0)).powi(2);
        return (normal, normal);
    }
    let below = (angle.sin() / n).asin();
    let s = (angle - below).sin() / (angle + below).sin();
    let p = (angle - below).tan() / (angle + below).tan();
    (s * s, p * p)
}
