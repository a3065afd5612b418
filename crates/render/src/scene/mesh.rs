//! Triangle meshes with one index buffer, and smooth normals for those that come without.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

pub use super::obj::load_obj;

/// A triangle mesh; all attributes of a vertex share its index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertices, finite, in the space of the file.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one a vertex, if the file has any.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates (u, v), one pair a vertex, if the file has any.
    pub texcoords: Option<Vec<[f32; 2]>>,
    /// Indices of vertices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// How many triangles have no area; they are kept.
    pub degenerate: usize,
    /// Remarks for the user that are no errors, each with the file.
    pub notices: Vec<String>,
}

/// Triangles whose angles are kept at once.
const BATCH: usize = 1 << 16;

/// Smooth unit normals, one a vertex: the mean of the normals around it, weighted by the angle at the vertex.
///
/// Triangles without area do not count. A vertex with no other triangles, or whose triangles cancel each other, gets
/// the normal of one of them, or +z where there is none. Vertices with several texture coordinates or normals in the
/// file are several vertices here, as in Mitsuba, so that a seam stays a seam.
///
/// Source: Thürmer and Wüthrich, Computing Vertex Normals from Polygonal Facets, J. Graphics Tools 3 (1998).
///
/// # Panics
///
/// If a triangle names a vertex that does not exist.
pub fn vertex_normals(mesh: &Mesh) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    let mut fallback = vec![DVec3::Z; mesh.positions.len()];
    // angles in parallel, sums in the order of the file
    for batch in mesh.triangles.chunks(BATCH) {
        let shares: Vec<_> = batch.par_iter().map(|&t| share(mesh, t)).collect();
        for (triangle, (normal, angles)) in
            batch.iter().zip(shares).filter_map(|(t, s)| Some((t, s?)))
        {
            for (&index, angle) in triangle.iter().zip(angles) {
                sums[index as usize] += angle * normal;
                fallback[index as usize] = normal;
            }
        }
    }
    // A sum that is only rounding of terms near one has no direction.
    let direction = |(sum, fallback): (DVec3, DVec3)| {
        let sum = Some(sum).filter(|sum| sum.length() > 1e-9);
        sum.map_or(fallback, DVec3::normalize).as_vec3().to_array()
    };
    sums.into_par_iter().zip(fallback).map(direction).collect()
}

/// Unit normal of a triangle and the angles at its corners; `None` without area.
fn share(mesh: &Mesh, triangle: [u32; 3]) -> Option<(DVec3, [f64; 3])> {
    let corners = triangle.map(|index| corner(mesh, index));
    let normal = face_normal(corners)?;
    let angle = |k: usize| {
        let a = corners[(k + 1) % 3] - corners[k];
        let b = corners[(k + 2) % 3] - corners[k];
        a.cross(b).length().atan2(a.dot(b))
    };
    Some((normal, [0, 1, 2].map(angle)))
}

/// The number of triangles without area.
pub(super) fn count_degenerate(mesh: &Mesh) -> usize {
    let flat = |&&triangle: &&[u32; 3]| face_normal(triangle.map(|i| corner(mesh, i))).is_none();
    mesh.triangles.par_iter().filter(flat).count()
}

fn corner(mesh: &Mesh, index: u32) -> DVec3 {
    Vec3::from(mesh.positions[index as usize]).as_dvec3()
}

/// Unit normal, `None` for corners on a line to within the rounding of their coordinates' differences.
fn face_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (e, f) = (b - a, c - a);
    let cross = e.cross(f);
    let area = cross.length();
    (area > 1e-12 * e.length() * f.length()).then(|| cross / area)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_corner_of_a_cube_has_the_diagonal_normal_however_it_is_cut() {
        // Three faces meet at the origin; the first one is cut into two triangles there, which must not count twice.
        let positions = [
            [0.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
            [-1.0, -1.0, 0.0],
        ];
        let triangles = [[0, 1, 4], [0, 4, 2], [0, 2, 3], [0, 3, 1]];
        let normals = vertex_normals(&mesh(&positions, &triangles));
        let expected = Vec3::splat(1.0 / 3f32.sqrt());
        assert!((Vec3::from(normals[0]) - expected).length() < 1e-6);
    }

    #[test]
    fn degenerate_triangles_have_no_say() {
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [2.0, 0.0, 0.0],
        ];
        let mesh = mesh(&positions, &[[0, 1, 2], [0, 1, 3], [3, 3, 3], [0, 0, 1]]);
        assert_eq!(count_degenerate(&mesh), 3);
        assert_eq!(vertex_normals(&mesh), [[0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn triangles_that_cancel_leave_a_unit_normal() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        for normal in vertex_normals(&mesh(&positions, &[[0, 1, 2], [0, 2, 1]])) {
            assert!((Vec3::from(normal).length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn huge_and_tiny_triangles_have_normals_too() {
        for scale in [f32::MAX / 4.0, 1e-38] {
            let positions = [[0.0, 0.0, 0.0], [scale, 0.0, 0.0], [0.0, scale, 0.0]];
            let mesh = mesh(&positions, &[[0, 1, 2]]);
            assert_eq!(count_degenerate(&mesh), 0, "{scale}");
            assert_eq!(vertex_normals(&mesh), [[0.0, 0.0, 1.0]; 3]);
        }
    }
}
