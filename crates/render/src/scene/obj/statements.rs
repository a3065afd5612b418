//! The statements of an OBJ file, one by one: those that make triangles are checked and kept, the others passed over.
//!
//! tobj passes over statements that it does not know, takes polylines for faces, cuts the mesh at groups and names no
//! line in its errors: what it is given must be free of all that.

use std::path::Path;
use std::sync::Arc;

use crate::scene::error::{Position, SceneError, quoted, suggestion};

/// Statements that carry no triangles and are passed over: names, materials, smoothing groups, display hints.
const IGNORED: &str = "g o s mg usemtl mtllib usemap maplib bevel c_interp d_interp lod call";

/// Statements of points, lines and free-form surfaces; passed over too, with a notice.
const NO_TRIANGLES: &str = "p l vp cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con csh ctech \
                            stech shadow_obj trace_obj";

/// What a face names, in the order of its indices: statement, words, numbers that it needs, numbers that are read.
const LISTS: [(&str, &str, usize, usize); 3] = [
    ("v", "vertex", 3, 3),
    ("vt", "texture coordinate", 1, 2),
    ("vn", "normal", 3, 3),
];

/// The statements that make triangles, all of them good, and how many others there are that might be missed.
pub(super) fn select(text: &str, path: &Path) -> Result<(String, usize), SceneError> {
    let file: Arc<Path> = path.into();
    let named = |keyword| {
        text.lines()
            .filter(|line| line.split_whitespace().next() == Some(keyword))
            .count()
    };
    let totals = LISTS.map(|(keyword, ..)| named(keyword));
    let mut before = [0; 3];
    let (mut kept, mut ignored) = (String::with_capacity(text.len() + 1), 0);
    let mut joined = String::new();
    let mut number = 0;
    for line in text.lines() {
        number += 1;
        let at = |message: String| Position::line(file.clone(), number).error(message);
        // a backslash at the end joins the next line to this one
        if let Some(start) = line
            .trim_end()
            .strip_suffix('\\')
            .filter(|start| !start.starts_with('#'))
        {
            joined.push_str(start);
            joined.push(' ');
            continue;
        }
        joined.push_str(line);
        let statement = joined.split('#').next().unwrap_or_default();
        let mut words = statement.split_whitespace();
        let keyword = words.next().unwrap_or_default();
        if let Some(list) = LISTS.iter().position(|(name, ..)| *name == keyword) {
            numbers(LISTS[list], words, &mut kept).map_err(at)?;
            before[list] += 1;
        } else if keyword == "f" {
            check_face(words, before, totals).map_err(at)?;
            kept.push_str(statement);
            kept.push('\n');
        } else if NO_TRIANGLES.split_whitespace().any(|name| name == keyword) {
            ignored += 1;
        } else if !keyword.is_empty() && !IGNORED.split_whitespace().any(|name| name == keyword) {
            return Err(at(unknown(keyword)));
        }
        joined.clear();
    }
    if joined.is_empty() {
        Ok((kept, ignored))
    } else {
        Err(Position::line(file, number)
            .error("the file ends after a backslash, expected another line"))
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

/// Copies a statement of numbers, all of them finite, without those that are not read; missing ones are zero.
fn numbers<'w>(
    (keyword, _, needed, read): (&str, &str, usize, usize),
    words: impl Iterator<Item = &'w str>,
    kept: &mut String,
) -> Result<(), String> {
    kept.push_str(keyword);
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
        if found < read {
            kept.push(' ');
            kept.push_str(word);
        }
        found += 1;
    }
    if found < needed {
        return Err(format!(
            "'{keyword}' with {found} numbers, expected {needed}"
        ));
    }
    kept.push_str(&" 0".repeat(read.saturating_sub(found)));
    kept.push('\n');
    Ok(())
}

/// Positive indices count from the start of the file, negative ones back from this line.
fn check_face<'w>(
    words: impl Iterator<Item = &'w str>,
    before: [usize; 3],
    totals: [usize; 3],
) -> Result<(), String> {
    let mut corners = 0;
    for word in words {
        corners += 1;
        if word.starts_with('/') || word.split('/').count() > 3 {
            return Err(format!(
                "face corner {}, expected v, v/vt, v//vn or v/vt/vn",
                quoted(word)
            ));
        }
        for (list, part) in word
            .split('/')
            .enumerate()
            .filter(|(_, part)| !part.is_empty())
        {
            let index: i64 = part
                .parse()
                .map_err(|_| format!("index {} in a face, expected an integer", quoted(part)))?;
            let (what, total, before) = (LISTS[list].1, totals[list], before[list]);
            let reach = index.unsigned_abs();
            if index == 0 {
                return Err("index 0 in a face, expected 1 for the first vertex".to_owned());
            } else if index > 0 && reach > total as u64 {
                return Err(format!(
                    "face names {what} {index}, expected at most {total}, the number in the file"
                ));
            } else if index < 0 && reach > before as u64 {
                return Err(format!(
                    "index {index} in a face, there are {before} before this line"
                ));
            }
        }
    }
    if corners < 3 {
        Err(format!("face with {corners} corners, expected at least 3"))
    } else {
        Ok(())
    }
}
