//! What tests of matter share: matter from the text of a scene, and its matrices in given frames.

use std::path::Path;
use std::rc::Rc;

use glam::Vec3A;
use nalgebra::Matrix4;

use super::{Matter, Part, Vertex};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Element, Light, MuellerThroughput, Polarized};
use crate::scene::{Object, SceneError, read_text};

/// The object of a bsdf, its parameters in the second line of a file.
pub fn object(plugin: &str, parameters: &str) -> Rc<Object> {
    let text =
        format!("<scene version='3.0.0'><bsdf type='{plugin}'>\n{parameters}</bsdf></scene>");
    let document = read_text(&text, Path::new("scene.xml"), &[]).unwrap();
    document.definitions()[0].clone()
}

/// Matter as a scene file describes it, or the error.
pub fn read<T>(
    plugin: &str,
    parameters: &str,
    of: impl Fn(&Object) -> Result<T, SceneError>,
) -> Result<T, String> {
    let object = object(plugin, parameters);
    let matter = of(&object).map_err(|e| e.to_string())?;
    object.finish().map_err(|e| e.to_string())?;
    Ok(matter)
}

/// A direction at so many degrees from the normal and an azimuth in radians; above 90 degrees on the back.
pub fn direction(degrees: f64, azimuth: f64) -> Vec3A {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3A::new(
        (sin * azimuth.cos()) as f32,
        (sin * azimuth.sin()) as f32,
        cos as f32,
    )
    .normalize()
}

/// A vertex seen from `o`, at the origin of the world.
pub fn vertex(o: Vec3A) -> Vertex {
    Vertex {
        o,
        position: Vec3A::ZERO,
        frame: Frame {
            s: Vec3A::X,
            t: Vec3A::Y,
            n: Vec3A::Z,
        },
        viewer_distance: 1.0,
    }
}

/// An axis across two directions: first axis of the frames of light along both.
pub fn common_axis(o: Vec3A, i: Vec3A) -> Vec3A {
    o.cross(i).try_normalize().unwrap_or(Frame::around(o).s)
}

/// The Mueller matrix from light along `−i` to light along `o`, in the frames of the given first axes.
pub fn matrix(
    matter: &impl Matter,
    (o, axis_out): (Vec3A, Vec3A),
    (i, axis_in): (Vec3A, Vec3A),
    part: Part,
    wavelength: f32,
) -> Matrix4<f64> {
    type L = Polarized<1>;
    let (response, _) =
        matter.respond::<L>(&vertex(o), i, part, &[wavelength], &Coherence::PLANE_WAVE);
    let nothing = Element {
        mean: 1.0,
        difference: 0.0,
        cosine: 1.0,
        sine: 0.0,
    };
    let seen = L::extend(&L::identity(axis_out), response, 1.0, o);
    let seen = L::extend(
        &seen,
        L::diattenuating_retarder(axis_in, |_| nothing),
        1.0,
        -i,
    );
    let MuellerThroughput::Full { matrices, .. } = seen else {
        panic!("a full matrix expected")
    };
    Matrix4::from_fn(|row, column| f64::from(matrices[0].col(column)[row]))
}

/// How far matter with discrete directions is from reciprocity; `ratio` is (n_i/n_o)².
///
/// `f(i → o)/n_o² = X f(o → i)ᵀ X/n_i²` with `f = m δ/cos_i`, and `n_i² cos_i dω_i = n_o² cos_o dω_o`.
pub fn broken_reciprocity(
    matter: &impl Matter,
    (o, i): (Vec3A, Vec3A),
    part: Part,
    wavelength: f32,
    ratio: f64,
) -> f64 {
    let axes = [
        Frame::with_tangent(o, Vec3A::new(0.3, 0.9, 0.1)).s,
        Frame::with_tangent(i, Vec3A::new(-0.5, 0.2, 0.7)).s,
    ];
    let there = matrix(matter, (o, axes[0]), (i, axes[1]), part, wavelength);
    let back = matrix(matter, (i, axes[1]), (o, axes[0]), part, wavelength);
    let x = Matrix4::from_diagonal(&nalgebra::Vector4::new(1.0, 1.0, -1.0, 1.0));
    (there * ratio - x * back.transpose() * x / ratio).amax()
}
