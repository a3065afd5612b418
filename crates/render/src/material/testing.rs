//! What the tests of all matter ask: matrices in known frames, and whether drawn directions follow their density.

use glam::{Mat4, Vec3A, Vec4};

use super::{Material, Matter, Part, Vertex, axis_s};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Element, Light, MuellerThroughput, Polarized};
use crate::sampler::SampleStream;
use crate::scene::{Overrides, SceneError, build, read_text};

/// Light that does not know in which of its laws it was written.
type One = Polarized<1>;

/// Green, nm.
pub(crate) const GREEN: [f32; 1] = [550.0];

/// The material of a `<bsdf>` in a scene file.
pub(crate) fn read(bsdf: &str) -> Result<Material, SceneError> {
    let text = format!("<scene version='3.0.0'><sensor type='perspective'/>\n{bsdf}</scene>");
    let document = read_text(&text, "test.xml".as_ref(), &[])?;
    let mut built = build(&document, Overrides::default())?;
    Ok(built.scene.materials.swap_remove(0))
}

/// Sum of `density⁻¹ × matrix` over drawn directions, `weight(i, η)` each, and the standard error of its corner.
pub(crate) fn mean_over_draws(
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

/// A vertex at the origin of a surface in the plane z = 0, seen from `o`.
pub(crate) fn vertex(o: Vec3A) -> Vertex {
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

/// A unit direction by its angle from the normal and its azimuth, degrees.
pub(crate) fn direction(theta: f32, azimuth: f32) -> Vec3A {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = azimuth.to_radians().sin_cos();
    Vec3A::new(sin * x, sin * y, cos)
}

/// The matrix from `i` to `o` in frames whose first axes are across normal and ray, and the density.
pub(crate) fn respond(matter: &impl Matter, o: Vec3A, i: Vec3A, part: Part) -> (Mat4, f32) {
    let (response, density) =
        matter.respond::<One>(&vertex(o), i, part, &GREEN, &Coherence::PLANE_WAVE);
    let nothing = Element {
        mean: 1.0,
        difference: 0.0,
        cosine: 1.0,
        sine: 0.0,
    };
    let [out, into] = [o, i].map(|v| axis_s(Vec3A::Z, v));
    let whole = One::extend(&One::identity(out), response, 1.0, o);
    let turn = One::diattenuating_retarder(into, |_| nothing);
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
pub(crate) fn reversed(m: &Mat4) -> Mat4 {
    let x = Mat4::from_diagonal(Vec4::new(1.0, 1.0, -1.0, 1.0));
    x * m.transpose() * x
}

/// Largest difference of two matrices.
pub(crate) fn difference(a: &Mat4, b: &Mat4) -> f32 {
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
pub(crate) fn assert_drawn_as_dense(
    what: &str,
    matter: &impl Matter,
    o: Vec3A,
    fine: usize,
) -> f64 {
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
