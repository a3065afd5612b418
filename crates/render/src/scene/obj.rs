//! Wavefront OBJ: vertices, normals, texture coordinates and faces of the whole file as one mesh.
//!
//! A reader of our own because every error names its line, and because groups and materials must not cut the
//! neighbourhood of a vertex, on which smooth normals depend.

use std::path::Path;
use std::sync::Arc;

use super::assemble::{NONE, Statements};
use super::error::{Position, SceneError, quoted, suggestion};
use super::mesh::Mesh;
use super::source::read_bytes;

/// Statements that carry no triangles and are passed over: names, materials, smoothing groups, display hints.
const IGNORED: [&str; 13] = [
    "g", "o", "s", "mg", "usemtl", "mtllib", "usemap", "maplib", "bevel", "c_interp", "d_interp",
    "lod", "call",
];

/// Statements of points, lines and free-form surfaces; passed over too, with a notice.
const NO_TRIANGLES: [&str; 22] = [
    "p",
    "l",
    "vp",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "csh",
    "ctech",
    "stech",
    "shadow_obj",
    "trace_obj",
];

/// Reads an OBJ file.
///
/// All groups become one mesh; a polygon becomes a fan of triangles around its first corner. Vertex colours, the
/// fourth coordinate and materials are ignored. `flip_tex_coords` replaces v by 1 − v. Tolerated, with a notice: no
/// faces at all, corners without a normal (they get the smooth one) or without texture coordinates (they get 0, 0)
/// where others have them, statements that make no triangles.
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
    let file: Arc<Path> = path.into();
    let mut statements = Statements::default();
    let mut number = 0;
    let mut joined = String::new();
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    for line in bytes.split(|&byte| byte == b'\n') {
        number += 1;
        let at = |message: String| Position::line(file.clone(), number).error(message);
        let line = line.trim_ascii();
        if joined.is_empty() && statements.skips(line) {
            continue;
        }
        let line = std::str::from_utf8(line)
            .map_err(|_| at("the line is not text, expected an OBJ file".to_owned()))?;
        // A backslash at the end joins the next line to this one.
        if let Some(start) = line.strip_suffix('\\') {
            joined.push_str(start);
            joined.push(' ');
        } else if joined.is_empty() {
            statements.take(line, number).map_err(at)?;
        } else {
            joined.push_str(line);
            statements.take(&joined, number).map_err(at)?;
            joined.clear();
        }
    }
    if !joined.is_empty() {
        return Err(Position::line(file, number)
            .error("the file ends after a backslash, expected another line"));
    }
    let mut mesh = statements
        .mesh(flip_tex_coords)
        .map_err(|(line, message)| Position::line(file, line).error(message))?;
    let whole = Position::whole(path);
    for notice in &mut mesh.notices {
        *notice = whole.error(&*notice).to_string();
    }
    Ok(mesh)
}

impl Statements {
    /// Comments, empty lines and names, which need not be UTF-8.
    fn skips(&self, line: &[u8]) -> bool {
        let end = line.iter().position(u8::is_ascii_whitespace);
        let keyword = &line[..end.unwrap_or(line.len())];
        line.is_empty() || line[0] == b'#' || IGNORED.iter().any(|name| name.as_bytes() == keyword)
    }

    fn take(&mut self, line: &str, number: u32) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            None => {}
            Some("v") => self.positions.push(floats("v", words, 3)?),
            Some("vn") => self.normals.push(floats("vn", words, 3)?),
            Some("vt") => self.texcoords.push(floats("vt", words, 1)?),
            Some("f") => self.face(words, number)?,
            Some(other) if NO_TRIANGLES.contains(&other) => self.ignored += 1,
            Some(other) => {
                return Err(format!(
                    "unknown statement {}{}",
                    quoted(other),
                    suggestion(other, &["v", "vn", "vt", "f"])
                ));
            }
        }
        Ok(())
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>, line: u32) -> Result<(), String> {
        let start = self.corners.len();
        let counts = [
            self.positions.len(),
            self.texcoords.len(),
            self.normals.len(),
        ];
        for word in words {
            let mut corner = [NONE; 3];
            let mut parts = word.split('/');
            for ((slot, count), part) in corner.iter_mut().zip(counts).zip(&mut parts) {
                if !part.is_empty() {
                    *slot = index(part, count)?;
                }
            }
            if corner[0] == NONE || parts.next().is_some() {
                return Err(format!(
                    "face corner {}, expected v, v/vt, v//vn or v/vt/vn",
                    quoted(word)
                ));
            }
            self.corners.push(corner);
        }
        match self.corners.len() - start {
            3.. => {
                self.faces.push((self.corners.len(), line));
                Ok(())
            }
            few => Err(format!("face with {few} corners, expected at least 3")),
        }
    }
}

/// The first `N` numbers of a statement, of which `needed` must be there; the others are zero. More may follow.
fn floats<'w, const N: usize>(
    keyword: &str,
    words: impl Iterator<Item = &'w str>,
    needed: usize,
) -> Result<[f32; N], String> {
    let mut numbers = [0.0; N];
    let mut found = 0;
    for word in words {
        let value: f32 = word.parse().map_err(|_| {
            format!(
                "{} in '{keyword}' is no number, expected {needed} or more",
                quoted(word)
            )
        })?;
        if !value.is_finite() {
            return Err(format!(
                "{} in '{keyword}' is not finite in single precision, expected a finite number",
                quoted(word)
            ));
        }
        if let Some(slot) = numbers.get_mut(found) {
            *slot = value;
        }
        found += 1;
    }
    if found < needed {
        return Err(format!(
            "'{keyword}' with {found} numbers, expected {needed}"
        ));
    }
    Ok(numbers)
}

/// An index counted from zero: positive ones count from the start of the file, negative ones back from this line.
fn index(text: &str, count: usize) -> Result<u32, String> {
    let number: i64 = text
        .parse()
        .map_err(|_| format!("index {} in a face, expected an integer", quoted(text)))?;
    let from_zero = match number {
        0 => return Err("index 0 in a face, expected 1 for the first vertex".to_owned()),
        1.. => number - 1,
        _ => i64::try_from(count)
            .unwrap_or(i64::MAX)
            .saturating_add(number),
    };
    u32::try_from(from_zero)
        .ok()
        .filter(|&index| index != NONE)
        .ok_or_else(|| format!("index {number} in a face, there are {count} before this line"))
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
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\np 1",
                "a.obj: 2 statements of points, lines or free-form surfaces are ignored",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3",
                "a.obj: 1 vertices lack a normal and get a smooth one",
            ),
            (
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3",
                "a.obj: 1 vertices lack texture coordinates and get (0, 0)",
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
                "index 4294967296 in a face, there are 3 before this line",
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
