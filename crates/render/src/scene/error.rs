//! What is wrong with a scene, and where: `scene.xml:12:7: unknown parameter 'ptich', did you mean 'pitch'?`

use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// A place in a file, written `FILE:LINE:COLUMN`.
///
/// Lines and columns count from 1, columns in characters. Zero stands for "no particular one" and is not printed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Position {
    /// The file, named as the user or the including file names it.
    pub file: Arc<Path>,
    /// Line, from 1; 0 means the file as a whole.
    pub line: u32,
    /// Column, from 1; 0 means the line as a whole.
    pub column: u32,
}

impl Position {
    /// The file as a whole.
    pub fn whole(file: &Path) -> Self {
        Self::line(file.into(), 0)
    }

    /// One line of the file, as a whole.
    pub fn line(file: Arc<Path>, line: u32) -> Self {
        Self {
            file,
            line,
            column: 0,
        }
    }

    /// An error at this place.
    pub fn error(&self, message: impl fmt::Display) -> SceneError {
        SceneError {
            position: self.clone(),
            message: message.to_string(),
        }
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        for number in [self.line, self.column] {
            if number == 0 {
                break;
            }
            write!(f, ":{number}")?;
        }
        Ok(())
    }
}

/// Something in a scene or in a file that it names that cannot be accepted, with its place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{position}: {message}")]
pub struct SceneError {
    /// Where.
    pub position: Position,
    /// What is wrong, what was expected.
    pub message: String,
}

/// Returns the candidate that `name` was probably meant to be, `None` if nothing is near.
///
/// Near is an edit distance (with swaps of neighbours) of at most a third of the length of `name`, three at most;
/// capitals and underscores are free, so that `toWorld` finds `to_world`.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().count();
    if length > 64 {
        return None;
    }
    let allowed = length.div_ceil(3).min(3);
    candidates
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|&(distance, _)| distance <= allowed && distance < length)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

fn distance(a: &str, b: &str) -> usize {
    let fold = |s: &str| s.to_lowercase().replace('_', "");
    strsim::damerau_levenshtein(a, b).min(strsim::damerau_levenshtein(&fold(a), &fold(b)))
}

/// The end of a message about an unknown name: the nearest name, or else the list of the known ones.
pub(super) fn suggestion(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(near) => format!(", did you mean '{near}'?"),
        None if known.is_empty() => String::new(),
        None => format!(", expected {}", alternatives(known)),
    }
}

/// `'a'`, `'a' or 'b'`, `'a', 'b' or 'c'`.
pub(super) fn alternatives(names: &[&str]) -> String {
    let quoted: Vec<_> = names.iter().map(|name| format!("'{name}'")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

/// Text of the user in quotes, on one line and cut to forty characters.
pub(super) fn quoted(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect::<String>();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("'{}'", short.replace(char::is_control, " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_file_line_and_column_as_far_as_they_are_known() {
        let mut position = Position::whole(Path::new("a/scene.xml"));
        assert_eq!(
            position.error("no such file").to_string(),
            "a/scene.xml: no such file"
        );
        position.line = 12;
        assert_eq!(position.to_string(), "a/scene.xml:12");
        position.column = 7;
        assert_eq!(position.to_string(), "a/scene.xml:12:7");
    }

    #[test]
    fn the_nearest_name_forgives_typing_and_the_old_camel_case() {
        let known = ["pitch", "alpha", "to_world", "k"];
        assert_eq!(nearest("ptich", known), Some("pitch"));
        assert_eq!(nearest("toWorld", known), Some("to_world"));
        assert_eq!(nearest("K", known), Some("k"));
        assert_eq!(nearest("n", known), None);
        assert_eq!(nearest("reflectance", known), None);
        assert_eq!(nearest("", known), None);
        assert_eq!(nearest(&"p".repeat(100_000), known), None);
    }

    #[test]
    fn an_unknown_name_gets_the_nearest_one_or_the_list() {
        assert_eq!(
            suggestion("alhpa", &["alpha", "eta"]),
            ", did you mean 'alpha'?"
        );
        assert_eq!(
            suggestion("zzz", &["alpha", "eta"]),
            ", expected 'alpha' or 'eta'"
        );
        assert_eq!(suggestion("zzz", &[]), "");
    }

    #[test]
    fn quoted_text_stays_on_one_short_line() {
        assert_eq!(quoted("a\nb"), "'a b'");
        assert_eq!(quoted(&"é".repeat(50)).chars().count(), 43);
    }
}
