//! What tests of matter share: matter from the text of a scene, its matrices in given frames, and whether drawn directions
//! follow their density.

use std::path::Path;
use std::rc::Rc;

use glam::{Mat4, Vec3A, Vec4};
use nalgebra::Matrix4;

use super::{Material, Matter, Part, Vertex, axis_s};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Element, Light, MuellerThroughput, Polarized, Sight};
use crate::sampler::SampleStream;
use crate::scene::{Object, Overrides, SceneError, build, read_text};

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

/// Matter `plugin` with the index 1.5 in vacuum, or others.
pub fn of_indices(plugin: &str, [inside, outside]: [f64; 2], more: &str) -> Material {
    material_of(&format!(
        "<bsdf type='{plugin}'><float name='int_ior' value='{inside}'/><float name='ext_ior' value='{outside}'/>{more}</bsdf>"
    ))
    .unwrap()
}

/// Reflectances of s and p by sines and tangents, at a face behind which the index is η times that before it.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.2, Eq. (21a).
pub fn reflectances(eta: f64, cos: f64) -> [f64; 2] {
    let a = cos.acos();
    if a < 1e-6 {
        return [((eta - 1.0) / (eta + 1.0)).powi(2); 2];
    }
    let b = (a.sin() / eta).asin();
    let s = (a - b).sin() / (a + b).sin();
    let p = (a - b).tan() / (a + b).tan();
    [s * s, p * p]
}

/// Panics where light does not retrace its path: `f(i → o)/n_o² = X f(o → i)ᵀ X/n_i²`, relative to M00.
pub fn assert_retraced(
    matter: &impl Matter,
    (o, i): (Vec3A, Vec3A),
    index: impl Fn(Vec3A) -> f32,
    tolerance: f32,
) {
    let f = |o: Vec3A, i: Vec3A| {
        let scale = index(o).powi(-2) / i.z.abs();
        respond(matter, o, i, Part::Continuous).0 * scale
    };
    let (there, back) = (f(o, i), f(i, o));
    assert!(there.x_axis.x > 1e-3, "{o} {i}: {there}");
    let error = difference(&there, &reversed(&back));
    assert!(error < tolerance * there.x_axis.x, "{o} {i}: {error}");
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
        sight: Sight::BLIND,
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
    let seen = L::extend(&L::identity(axis_out), response, 1.0, o);
    let seen = L::extend(
        &seen,
        L::diattenuating_retarder(axis_in, |_| NOTHING),
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

/// What leaves light as it is.
const NOTHING: Element = Element {
    mean: 1.0,
    difference: 0.0,
    cosine: 1.0,
    sine: 0.0,
};

/// Light that does not know in which of its laws it was written.
type One = Polarized<1>;

/// Green, nm.
pub const GREEN: [f32; 1] = [550.0];

/// The material of a `<bsdf>` in a scene file.
pub fn material_of(bsdf: &str) -> Result<Material, SceneError> {
    let text = format!("<scene version='3.0.0'><sensor type='perspective'/>\n{bsdf}</scene>");
    let document = read_text(&text, "test.xml".as_ref(), &[])?;
    let mut built = build(&document, Overrides::default())?;
    Ok(built.scene.materials.swap_remove(0))
}

/// Sum of `density⁻¹ × matrix` over drawn directions, `weight(i, η)` each, and the standard error of its corner.
pub fn mean_over_draws(
    matter: &impl Matter,
    o: Vec3A,
    draws: u64,
    weight: impl Fn(Vec3A, f32) -> f32,
) -> (Mat4, f64) {
    let (mut sum, mut square) = (Mat4::ZERO, 0.0);
    for draw in 0..draws {
        let stream = SampleStream::new(3, 1, draw);
        let ([a, b], [c, _]) = (stream.pair(0), stream.pair(2));
        if let Some(d) = matter.sample(&vertex(o), &GREEN, [c, a, b]) {
            let (matrix, _) = respond(matter, o, d.direction, d.part);
            let matrix = matrix * (weight(d.direction, d.eta) / d.density);
            sum += matrix;
            square += f64::from(matrix.x_axis.x).powi(2);
        }
    }
    let n = draws as f64;
    let mean = sum * (draws as f32).recip();
    let variance = square / n - f64::from(mean.x_axis.x).powi(2);
    (mean, (variance.max(0.0) / n).sqrt())
}

/// A unit direction by its angle from the normal and its azimuth, degrees.
pub fn toward(theta: f32, azimuth: f32) -> Vec3A {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = azimuth.to_radians().sin_cos();
    Vec3A::new(sin * x, sin * y, cos)
}

/// The matrix from `i` to `o` in frames whose first axes are across normal and ray, and the density.
pub fn respond(matter: &impl Matter, o: Vec3A, i: Vec3A, part: Part) -> (Mat4, f32) {
    let (response, density) =
        matter.respond::<One>(&vertex(o), i, part, &GREEN, &Coherence::PLANE_WAVE);
    let [out, into] = [o, i].map(|v| axis_s(Vec3A::Z, v));
    let whole = One::extend(&One::identity(out), response, 1.0, o);
    let turn = One::diattenuating_retarder(into, |_| NOTHING);
    let matrix = match One::extend(&whole, turn, 1.0, -i) {
        MuellerThroughput::Full { matrices, .. } => matrices[0],
        MuellerThroughput::RankOne { columns, rows, .. } => {
            Mat4::from_cols_array_2d(&rows[0].to_array().map(|r| (columns[0] * r).to_array()))
        }
        MuellerThroughput::Intensity { columns } => {
            Mat4::from_cols(columns[0], Vec4::ZERO, Vec4::ZERO, Vec4::ZERO)
        }
    };
    (matrix, density)
}

/// `X Mᵀ X`, X = diag(1, 1, −1, 1): the matrix of the reversed path through reciprocal matter.
pub fn reversed(m: &Mat4) -> Mat4 {
    let x = Mat4::from_diagonal(Vec4::new(1.0, 1.0, -1.0, 1.0));
    x * m.transpose() * x
}

/// Largest difference of two matrices.
pub fn difference(a: &Mat4, b: &Mat4) -> f32 {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

/// χ² of 400 000 drawn directions against their density, in cells of cosine and azimuth on both sides; fails beyond the
/// 1e-6 quantile of the normal approximation. `fine` points a cell and axis.
///
/// Returns the share of draws that had a direction.
pub fn assert_drawn_as_dense(what: &str, matter: &impl Matter, o: Vec3A, fine: usize) -> f64 {
    const RINGS: usize = 24;
    const SECTORS: usize = 12;
    const DRAWS: u64 = 400_000;
    const CELLS: usize = RINGS * SECTORS;
    let cell = |i: Vec3A| {
        let ring = ((0.5 * (i.z + 1.0) * RINGS as f32) as usize).min(RINGS - 1);
        let turn = i.y.atan2(i.x) / std::f32::consts::TAU + 0.5;
        ring * SECTORS + ((turn * SECTORS as f32) as usize).min(SECTORS - 1)
    };
    let mut counts = vec![0.0; CELLS];
    let (mut kept, mut discrete) = (0.0, 0.0);
    for draw in 0..DRAWS {
        let stream = SampleStream::new(5, 0, draw);
        let ([a, b], [c, _]) = (stream.pair(0), stream.pair(2));
        if let Some(departure) = matter.sample(&vertex(o), &GREEN, [c, a, b]) {
            kept += 1.0;
            if departure.part != Part::Continuous {
                discrete += 1.0;
                continue;
            }
            let (_, density) = respond(matter, o, departure.direction, Part::Continuous);
            assert!(
                (density / departure.density - 1.0).abs() < 2e-2,
                "{what}: the density is {} when drawn and {density} when asked",
                departure.density
            );
            counts[cell(departure.direction)] += 1.0;
        }
    }
    let (mut chi2, mut freedom, mut all) = (0.0, 0.0, discrete);
    for (place, count) in counts.iter().enumerate() {
        let (ring, sector) = (place / SECTORS, place % SECTORS);
        let mut expected = 0.0;
        for point in 0..fine * fine {
            let at = |base: usize, n: usize, cells: usize| {
                (base as f32 + (n as f32 + 0.5) / fine as f32) / cells as f32
            };
            let z = 2.0 * at(ring, point / fine, RINGS) - 1.0;
            let turn = (at(sector, point % fine, SECTORS) - 0.5) * std::f32::consts::TAU;
            let r = (1.0 - z * z).sqrt();
            let i = Vec3A::new(r * turn.cos(), r * turn.sin(), z);
            expected += f64::from(respond(matter, o, i, Part::Continuous).1);
        }
        let area = 4.0 * std::f64::consts::PI / (CELLS * fine * fine) as f64;
        expected *= area * DRAWS as f64;
        all += expected;
        if expected > 25.0 {
            chi2 += (count - expected) * (count - expected) / expected;
            freedom += 1.0;
        } else {
            assert!(
                *count < expected + 40.0,
                "{what}: {count} drawn, {expected} expected"
            );
        }
    }
    // Wilson and Hilferty
    let spread = 2.0 / (9.0 * freedom);
    let normal = (f64::powf(chi2 / freedom, 1.0 / 3.0) - (1.0 - spread)) / f64::sqrt(spread);
    assert!(
        normal < 4.75,
        "{what}: χ² = {chi2} of {freedom}, {normal} deviations"
    );
    let error = (all - kept).abs() / DRAWS as f64;
    assert!(
        error < 5e-3,
        "{what}: the density integrates to {} of what is drawn",
        all / kept
    );
    kept / DRAWS as f64
}
