//! The statements of a Wavefront OBJ file that make triangles, checked and read in parallel.
//!
//! The file is cut at ends of lines. What precedes a part (lines, vertices) is counted first, so that indices and the
//! lines in errors are the same as if the file were read from its start to its end.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::error::{Position, SceneError, quoted, suggestion};

/// Statements that carry no triangles and are passed over: names, materials, smoothing groups, display hints.
const IGNORED: &str = "g o s mg usemtl mtllib usemap maplib bevel c_interp d_interp lod call";

/// Statements of points, lines and free-form surfaces; passed over too, with a notice.
const NO_TRIANGLES: &str = "p l vp cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con csh ctech \
                            stech shadow_obj trace_obj";

/// What a face names, in the order of its indices: statement, words, numbers that it needs.
const LISTS: [(&str, &str, usize); 3] = [
    ("v", "vertex", 3),
    ("vt", "texture coordinate", 1),
    ("vn", "normal", 3),
];

/// Bytes of a part, at least.
const PART: usize = 1 << 20;

/// Indices of a face's corner in the three lists, from zero.
pub(super) type Corner = [u32; 3];

/// An index that the file does not give.
pub(super) const MISSING: u32 = u32::MAX;

/// What a file or a part of it says.
#[derive(Default)]
pub(super) struct Statements {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Polygons cut into fans around their first corner.
    pub(super) triangles: Vec<[Corner; 3]>,
    /// Statements that might be missed.
    pub(super) ignored: usize,
}

/// How many lines there are, and entries in the three lists.
#[derive(Clone, Copy, Default)]
struct Count {
    lines: u32,
    lists: [usize; 3],
}

/// Reads a file part by part, in their order.
///
/// # Errors
///
/// The first one in the file.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Vec<Statements>, SceneError> {
    read_in_parts(bytes, PART, path)
}

fn read_in_parts(bytes: &[u8], size: usize, path: &Path) -> Result<Vec<Statements>, SceneError> {
    // comments and names need not be UTF-8
    let texts: Vec<Cow<'_, str>> = parts(bytes, size)
        .into_par_iter()
        .map(String::from_utf8_lossy)
        .collect();
    let counts: Vec<Count> = texts.par_iter().map(|text| count(text)).collect();
    let mut total = Count::default();
    let before: Vec<Count> = counts
        .iter()
        .map(|count| {
            let before = total;
            total.lines = total.lines.saturating_add(count.lines);
            for (sum, n) in total.lists.iter_mut().zip(count.lists) {
                *sum += n;
            }
            before
        })
        .collect();
    let file: Arc<Path> = path.into();
    let read: Vec<Result<Statements, SceneError>> = texts
        .par_iter()
        .zip(before)
        .map(|(text, before)| read_part(text, before, total.lists, &file))
        .collect();
    read.into_iter().collect()
}

/// Cuts a file into parts of at least `size` bytes, at ends of lines that do not go on in the next one.
fn parts(mut bytes: &[u8], size: usize) -> Vec<&[u8]> {
    bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut parts = Vec::new();
    while !bytes.is_empty() {
        let mut end = size.min(bytes.len());
        while end < bytes.len() && !(bytes[end - 1] == b'\n' && ends(&bytes[..end - 1])) {
            end += 1;
        }
        let (part, rest) = bytes.split_at(end);
        parts.push(part);
        bytes = rest;
    }
    parts
}

/// Whether the last line of a text ends with it, as far as its last characters tell.
fn ends(text: &[u8]) -> bool {
    let line = text.rsplit(|&byte| byte == b'\n').next();
    let last = line.and_then(|line| line.trim_ascii_end().last());
    // other characters than those of ASCII may be space too
    last.is_none_or(|&byte| byte.is_ascii() && byte != b'\\' && byte != 0x0b)
}

/// Calls `f` with each statement and the number of its last line, from one; a backslash at the end joins the next line.
///
/// Returns the number of lines, and whether the last statement is complete.
fn statements<E>(
    text: &str,
    mut f: impl FnMut(u32, &str) -> Result<(), E>,
) -> Result<(u32, bool), E> {
    let (mut number, mut joined) = (0, String::new());
    for line in text.lines() {
        number = u32::saturating_add(number, 1);
        let start = line
            .trim_end()
            .strip_suffix('\\')
            .filter(|start| !start.starts_with('#'));
        let line = if let Some(start) = start {
            joined.push_str(start);
            joined.push(' ');
            continue;
        } else if joined.is_empty() {
            line
        } else {
            joined.push_str(line);
            &joined
        };
        let comment = line.bytes().position(|byte| byte == b'#');
        f(number, &line[..comment.unwrap_or(line.len())])?;
        joined.clear();
    }
    Ok((number, joined.is_empty()))
}

/// Which list a statement makes longer.
fn list_of(keyword: &str) -> Option<usize> {
    LISTS.iter().position(|(name, ..)| *name == keyword)
}

fn count(text: &str) -> Count {
    let mut lists = [0; 3];
    let counted = statements(text, |_, statement| {
        if let Some(list) = statement.split_whitespace().next().and_then(list_of) {
            lists[list] += 1;
        }
        Ok::<(), std::convert::Infallible>(())
    });
    let Ok((lines, _)) = counted;
    Count { lines, lists }
}

fn read_part(
    text: &str,
    before: Count,
    totals: [usize; 3],
    file: &Arc<Path>,
) -> Result<Statements, SceneError> {
    let mut read = Statements::default();
    let mut lists = before.lists;
    let mut corners = Vec::new();
    let at = |number| Position::line(file.clone(), before.lines.saturating_add(number));
    let (number, complete) = statements(text, |number, statement| {
        let mut words = statement.split_whitespace();
        let keyword = words.next().unwrap_or_default();
        let outcome = if let Some(list) = list_of(keyword) {
            lists[list] += 1;
            numbers(LISTS[list], words).map(|[x, y, z]| match list {
                0 => read.positions.push([x, y, z]),
                1 => read.texcoords.push([x, y]),
                _ => read.normals.push([x, y, z]),
            })
        } else if keyword == "f" {
            face(words, lists, totals, &mut corners).map(|()| {
                let fan = corners[1..].windows(2);
                read.triangles
                    .extend(fan.map(|pair| [corners[0], pair[0], pair[1]]));
            })
        } else if NO_TRIANGLES.split_whitespace().any(|name| name == keyword) {
            read.ignored += 1;
            Ok(())
        } else if keyword.is_empty() || IGNORED.split_whitespace().any(|name| name == keyword) {
            Ok(())
        } else {
            Err(unknown(keyword))
        };
        outcome.map_err(|message| at(number).error(message))
    })?;
    if complete {
        Ok(read)
    } else {
        Err(at(number).error("the file ends after a backslash, expected another line"))
    }
}

fn unknown(keyword: &str) -> String {
    if keyword.contains(char::REPLACEMENT_CHARACTER) {
        return "the line is not text, expected an OBJ file".to_owned();
    }
    format!(
        "unknown statement {}{}",
        quoted(keyword),
        suggestion(keyword, &["v", "vn", "vt", "f"])
    )
}

/// The first three numbers of a statement, all of them finite; missing ones are zero.
fn numbers<'w>(
    (keyword, _, needed): (&str, &str, usize),
    words: impl Iterator<Item = &'w str>,
) -> Result<[f32; 3], String> {
    let (mut numbers, mut found) = ([0.0; 3], 0);
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
        if let Some(number) = numbers.get_mut(found) {
            *number = value;
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

/// The corners of a face. Positive indices count from the start of the file, negative ones back from this line.
fn face<'w>(
    words: impl Iterator<Item = &'w str>,
    before: [usize; 3],
    totals: [usize; 3],
    corners: &mut Vec<Corner>,
) -> Result<(), String> {
    corners.clear();
    for word in words {
        if word.starts_with('/') || word.bytes().filter(|&byte| byte == b'/').count() > 2 {
            return Err(format!(
                "face corner {}, expected v, v/vt, v//vn or v/vt/vn",
                quoted(word)
            ));
        }
        let mut corner = [MISSING; 3];
        for (list, part) in word.split('/').enumerate() {
            if !part.is_empty() {
                corner[list] = index(part, LISTS[list].1, before[list], totals[list])?;
            }
        }
        corners.push(corner);
    }
    if corners.len() < 3 {
        let found = corners.len();
        Err(format!("face with {found} corners, expected at least 3"))
    } else {
        Ok(())
    }
}

/// An index into a list, from zero.
fn index(part: &str, what: &str, before: usize, total: usize) -> Result<u32, String> {
    let index: i64 = part
        .parse()
        .map_err(|_| format!("index {} in a face, expected an integer", quoted(part)))?;
    let reach = index.unsigned_abs();
    if index == 0 {
        Err("index 0 in a face, expected 1 for the first vertex".to_owned())
    } else if index > 0 && reach > total as u64 {
        Err(format!(
            "face names {what} {index}, expected at most {total}, the number in the file"
        ))
    } else if index < 0 && reach > before as u64 {
        Err(format!(
            "index {index} in a face, there are {before} before this line"
        ))
    } else if index > 0 {
        Ok((reach - 1) as u32)
    } else {
        Ok((before as u64 - reach) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sixteen lines: backslashes that join and others that do not, indices that count back and reach ahead.
    const TEXT: &str = concat!(
        "# a comment \\\r\nv 0 0 0 \\ \n \nv 1 0 0\n\nvt \\\n.5 .25\ng caf\u{e9} \\\u{a0}\nv 9 9 9\nvn 0 0 1\n",
        "f 1 2 \\\n3/1 -1//-1\nl 1 2\nv 0 1 0\nvn 0 1 0\nf -2//-1 1 3//1\n",
    );

    /// All parts of a file that is cut into parts of so many bytes at least, one after the other.
    fn whole(text: &str, size: usize) -> Result<Statements, String> {
        let parts = read_in_parts(text.as_bytes(), size, Path::new("a.obj"));
        let mut whole = Statements::default();
        for part in parts.map_err(|error| error.to_string())? {
            whole.positions.extend(part.positions);
            whole.texcoords.extend(part.texcoords);
            whole.normals.extend(part.normals);
            whole.triangles.extend(part.triangles);
            whole.ignored += part.ignored;
        }
        Ok(whole)
    }

    #[test]
    fn parts_say_together_what_the_file_says() {
        const M: u32 = MISSING;
        for size in 1..=TEXT.len() {
            let read = whole(TEXT, size).unwrap();
            assert_eq!(read.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
            assert_eq!(read.texcoords, [[0.5, 0.25]]);
            assert_eq!(read.normals, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
            let triangles = [
                [[0, M, M], [1, M, M], [2, 0, M]],
                [[0, M, M], [2, 0, M], [1, M, 0]],
                [[1, M, 1], [0, M, M], [2, M, 0]],
            ];
            assert_eq!(read.triangles, triangles, "parts of {size} bytes");
            assert_eq!(read.ignored, 1);
        }
    }

    #[test]
    fn the_first_error_is_told_with_its_line_in_the_file() {
        for (end, message) in [
            (
                "v x 0 0\nf 1 2 4\n",
                "'x' in 'v' is no number, expected 3 or more",
            ),
            (
                "f 1 2 6\nv x 0 0\nv 0 0 0\n",
                "face names vertex 6, expected at most 5, the number in the file",
            ),
            (
                "f 1 2 \\",
                "the file ends after a backslash, expected another line",
            ),
        ] {
            let text = format!("{TEXT}{end}");
            for size in 1..=text.len() {
                let error = whole(&text, size).err().unwrap();
                assert_eq!(
                    error,
                    format!("a.obj:17: {message}"),
                    "parts of {size} bytes"
                );
            }
        }
    }

    #[test]
    fn a_large_file_is_cut_only_where_a_line_ends() {
        let text = TEXT.repeat(3);
        let whole: Vec<&[u8]> = parts(text.as_bytes(), 1);
        assert_eq!(whole.concat(), text.as_bytes());
        assert!(whole.len() > 30, "{}", whole.len());
        // lines 2, 6, 8 and 11 of the text go on in the next one
        assert!(whole.iter().all(|part| part.ends_with(b"\n")));
        assert!(
            whole
                .iter()
                .all(|part| !part.starts_with(b"3/1") && !part.starts_with(b".5"))
        );
    }
}
