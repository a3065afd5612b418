//! Wavefront OBJ: vertices, normals, texture coordinates and faces of the whole file as one mesh.

use std::collections::HashMap;
use std::path::Path;

use glam::Vec3;

use super::error::{Position, SceneError};
use super::mesh::{Mesh, count_degenerate, vertex_normals};
use super::obj_text::{self, Corner, MISSING, Statements};
use super::source::read_bytes;

/// Largest file, bytes: fewer corners than 32 bits can count.
const LARGEST: usize = 1 << 33;

/// Reads an OBJ file.
///
/// All groups become one mesh; a polygon becomes a fan of triangles around its first corner. Vertex colours, the
/// fourth coordinate and materials are ignored. `flip_tex_coords` replaces v by 1 − v. Tolerated, with a notice: no
/// faces at all, statements that make no triangles, normals of no length (the vertices get smooth ones). Where some
/// corners lack a normal or texture coordinates, with a notice, all of them are without.
///
/// # Errors
///
/// Unreadable files, statements outside the format, numbers that are not finite in single precision, indices of
/// vertices that do not exist: with file and line.
pub fn load_obj(path: &Path, flip_tex_coords: bool) -> Result<Mesh, SceneError> {
    parse(&read_bytes(path)?, path, flip_tex_coords)
}

/// Reads the bytes of an OBJ file that is said to stand in `path`.
fn parse(bytes: &[u8], path: &Path, flip_tex_coords: bool) -> Result<Mesh, SceneError> {
    let whole = Position::whole(path);
    if bytes.len() > LARGEST {
        return Err(whole.error("a file of more than 8 GiB, expected a smaller one"));
    }
    let parts = obj_text::read(bytes, path)?;
    let ignored: usize = parts.iter().map(|part| part.ignored).sum();
    let mut mesh = assemble(parts, flip_tex_coords);
    if ignored > 0 {
        mesh.notices.push(format!(
            "{ignored} statements of points, lines or free-form surfaces are ignored"
        ));
    }
    for notice in &mut mesh.notices {
        *notice = whole.error(&*notice).to_string();
    }
    Ok(mesh)
}

/// Vertices in the order of their first use: equal corners are one vertex.
struct Vertices {
    corners: Vec<Corner>,
    /// The first vertex of each position, [`MISSING`] where there is none yet.
    first: Vec<u32>,
    /// The others: few but at seams.
    others: HashMap<Corner, u32>,
}

impl Vertices {
    /// The vertex of a corner.
    fn index(&mut self, corner: Corner) -> u32 {
        let new = self.corners.len() as u32;
        let first = &mut self.first[corner[0] as usize];
        let index = if *first == MISSING {
            *first = new;
            new
        } else if self.corners[*first as usize] == corner {
            *first
        } else {
            *self.others.entry(corner).or_insert(new)
        };
        if index == new {
            self.corners.push(corner);
        }
        index
    }

    /// What the vertices have of one of the lists that corners name; shorter where some have nothing.
    fn attribute<T: Copy>(&self, number: usize, list: &[T]) -> Vec<T> {
        self.corners
            .iter()
            .filter_map(|corner| list.get(corner[number] as usize).copied())
            .collect()
    }
}

/// One mesh with one index buffer, and what is to be said about it.
fn assemble(parts: Vec<Statements>, flip_tex_coords: bool) -> Mesh {
    let (mut positions, mut texcoords, mut normals) = (Vec::new(), Vec::new(), Vec::new());
    let mut faces = Vec::with_capacity(parts.len());
    for part in parts {
        positions.extend(part.positions);
        texcoords.extend(part.texcoords);
        normals.extend(part.normals);
        faces.push(part.triangles);
    }
    let mut vertices = Vertices {
        corners: Vec::new(),
        first: vec![MISSING; positions.len()],
        others: HashMap::new(),
    };
    let mut triangles = Vec::with_capacity(faces.iter().map(Vec::len).sum());
    for part in faces {
        triangles.extend(
            part.into_iter()
                .map(|face| face.map(|corner| vertices.index(corner))),
        );
    }
    let mut mesh = Mesh {
        positions: vertices.attribute(0, &positions),
        triangles,
        ..Mesh::default()
    };
    let count = mesh.positions.len();
    let mut texcoords = vertices.attribute(1, &texcoords);
    match texcoords.len() {
        0 => {}
        n if n == count => {
            if flip_tex_coords {
                texcoords.iter_mut().for_each(|[_, v]| *v = 1.0 - *v);
            }
            mesh.texcoords = Some(texcoords);
        }
        n => mesh.notices.push(format!(
            "{} vertices lack texture coordinates, all do without",
            count - n
        )),
    }
    let normals = vertices.attribute(2, &normals);
    match normals.len() {
        0 => {}
        n if n == count => set_normals(&mut mesh, &normals),
        n => mesh.notices.push(format!(
            "{} vertices lack a normal, all get smooth ones",
            count - n
        )),
    }
    mesh.degenerate = count_degenerate(&mesh);
    if mesh.triangles.is_empty() {
        mesh.notices.push("the file has no faces".to_owned());
    }
    if mesh.degenerate > 0 {
        mesh.notices
            .push(format!("{} triangles have no area", mesh.degenerate));
    }
    mesh
}

/// Unit normals; those without a direction are smooth ones.
fn set_normals(mesh: &mut Mesh, given: &[[f32; 3]]) {
    let unit = |&n: &[f32; 3]| {
        Some(
            Vec3::from(n)
                .as_dvec3()
                .try_normalize()?
                .as_vec3()
                .to_array(),
        )
    };
    let mut normals: Vec<Option<[f32; 3]>> = given.iter().map(unit).collect();
    let missing = normals.iter().filter(|normal| normal.is_none()).count();
    if missing > 0 {
        for (normal, smooth) in normals.iter_mut().zip(vertex_normals(mesh)) {
            normal.get_or_insert(smooth);
        }
        mesh.notices.push(format!(
            "{missing} vertices have a normal of no length and get a smooth one"
        ));
    }
    mesh.normals = Some(normals.into_iter().flatten().collect());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Mesh, String> {
        parse(text.as_bytes(), Path::new("a.obj"), true).map_err(|error| error.to_string())
    }

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    #[test]
    fn a_polygon_becomes_a_fan_around_its_first_corner() {
        let mesh = read(&format!("{TRIANGLE}v 1 1 0\nv 2 2 0\nf 3 1 2 4 5\n")).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(mesh.positions[0], [0.0, 1.0, 0.0]);
        assert_eq!((mesh.normals, mesh.texcoords), (None, None));
    }

    #[test]
    fn groups_and_materials_do_not_split_vertices() {
        let text = format!(
            "\u{feff}mtllib none.mtl\no a\n{TRIANGLE}v 1 1 0\ng b\nusemtl c\nf 1 2 3\ng d\ns 1\nf 3 2 4 # end\r\n"
        );
        let mesh = read(&text).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.notices, [""; 0]);
    }

    #[test]
    fn equal_positions_with_different_attributes_are_different_vertices() {
        let text = format!(
            "{TRIANGLE}vt 0 .25\nvt 1\nvn 0 0 2\nf 1/1/1 2/1/1 3/1/1\nf 1/2/1 3/1/1 2/1/1\n"
        );
        let mesh = read(&text).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 2, 1]]);
        assert_eq!(mesh.normals.unwrap(), [[0.0, 0.0, 1.0]; 4]);
        let uv = mesh.texcoords.unwrap();
        assert_eq!((uv[0], uv[3]), ([0.0, 0.75], [1.0, 1.0]));
        let unflipped = parse(text.as_bytes(), Path::new("a.obj"), false).unwrap();
        assert_eq!(unflipped.texcoords.unwrap()[0], [0.0, 0.25]);
    }

    #[test]
    fn indices_count_back_from_the_line_or_reach_ahead() {
        let mesh = read(&format!("{TRIANGLE}f -3 -2 -1\nf 4 1 2\nv 5 5 5 1\n")).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 0, 1]]);
        assert_eq!(mesh.positions[3], [5.0; 3]);
    }

    #[test]
    fn a_backslash_continues_a_line() {
        let mesh = read(&format!("{TRIANGLE}f 1 \\\n 2 3\n")).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert!(
            read("f 1 \\")
                .unwrap_err()
                .starts_with("a.obj:1: the file ends")
        );
    }

    #[test]
    fn what_is_tolerated_is_noticed() {
        for (text, notice) in [
            ("", "a.obj: the file has no faces"),
            (
                "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3",
                "a.obj: 1 triangles have no area",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2 3\np 1",
                "a.obj: 2 statements of points, lines or free-form surfaces are ignored",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3",
                "a.obj: 1 vertices lack a normal, all get smooth ones",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1",
                "a.obj: 3 vertices have a normal of no length and get a smooth one",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3",
                "a.obj: 1 vertices lack texture coordinates, all do without",
            ),
        ] {
            assert_eq!(read(text).unwrap().notices, [notice], "{text}");
        }
    }

    #[test]
    fn comments_need_not_be_utf_8() {
        let text = [b"# caf\xe9\ng caf\xe9\n", TRIANGLE.as_bytes(), b"f 1 2 3"].concat();
        let mesh = parse(&text, Path::new("a.obj"), true).unwrap();
        assert_eq!(mesh.triangles.len(), 1);
    }

    #[test]
    fn malformed_lines_are_named() {
        for (line, message) in [
            ("v 1 2", "'v' with 2 numbers, expected 3"),
            ("v 1 2 x", "'x' in 'v' is no number, expected 3 or more"),
            (
                "v 1 2 nan",
                "'nan' in 'v' is not finite in single precision, expected a finite number",
            ),
            (
                "vn 0 1e39 0",
                "'1e39' in 'vn' is not finite in single precision, expected a finite number",
            ),
            ("vt", "'vt' with 0 numbers, expected 1"),
            ("f 1 2", "face with 2 corners, expected at least 3"),
            (
                "f 1 2 0",
                "index 0 in a face, expected 1 for the first vertex",
            ),
            (
                "f 1 2 -4",
                "index -4 in a face, there are 3 before this line",
            ),
            (
                "f 1 2 4",
                "face names vertex 4, expected at most 3, the number in the file",
            ),
            (
                "f 1 2 3/1",
                "face names texture coordinate 1, expected at most 0, the number in the file",
            ),
            (
                "f 1 2 3//1",
                "face names normal 1, expected at most 0, the number in the file",
            ),
            (
                "f 1 2 3/1/1/1",
                "face corner '3/1/1/1', expected v, v/vt, v//vn or v/vt/vn",
            ),
            (
                "f 1 2 /1",
                "face corner '/1', expected v, v/vt, v//vn or v/vt/vn",
            ),
            ("f 1 2 1.5", "index '1.5' in a face, expected an integer"),
            (
                "f 1 2 99999999999999999999",
                "index '99999999999999999999' in a face, expected an integer",
            ),
            (
                "f 1 2 4294967296",
                "face names vertex 4294967296, expected at most 3, the number in the file",
            ),
            (
                "f 1 2 -9223372036854775808",
                "index -9223372036854775808 in a face, there are 3 before this line",
            ),
            ("vnn 1 2 3", "unknown statement 'vnn', did you mean 'vn'?"),
            (
                "hello",
                "unknown statement 'hello', expected 'v', 'vn', 'vt' or 'f'",
            ),
        ] {
            let error = read(&format!("{TRIANGLE}{line}\n")).unwrap_err();
            assert_eq!(error, format!("a.obj:4: {message}"));
        }
    }
}
