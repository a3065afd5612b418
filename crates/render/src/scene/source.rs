//! The text of one file: reading it, and turning byte offsets into lines and columns.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use super::error::{Position, SceneError};

/// Bytes between two places whose line and column are remembered, so that a file in one long line stays fast.
const STRIDE: usize = 128;

/// A text file with the places of its lines.
pub(super) struct Source {
    pub(super) file: Arc<Path>,
    /// Without a byte order mark.
    pub(super) text: String,
    /// (byte offset, line, column), ascending.
    marks: Vec<(usize, u32, u32)>,
}

impl Source {
    /// Reads a UTF-8 file.
    pub(super) fn read(path: &Path) -> Result<Self, SceneError> {
        let text = String::from_utf8(read_bytes(path)?).map_err(|failure| {
            let end = failure.utf8_error().valid_up_to();
            let valid = String::from_utf8_lossy(&failure.as_bytes()[..end]).into_owned();
            Self::new(path, &valid)
                .position(valid.len())
                .error("the text is not UTF-8, save the file in that encoding")
        })?;
        Ok(Self::new(path, &text))
    }

    /// A text that is said to stand in `path`.
    pub(super) fn new(path: &Path, text: &str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).to_owned();
        let marks = marks(&text);
        Self {
            file: path.into(),
            text,
            marks,
        }
    }

    /// The place of a byte of the text; offsets past the end mean the end.
    pub(super) fn position(&self, offset: usize) -> Position {
        let after = self.marks.partition_point(|&(at, _, _)| at <= offset);
        let (start, line, column) = self.marks[after.saturating_sub(1)];
        let passed = self.text[start..]
            .char_indices()
            .take_while(|&(at, c)| start + at + c.len_utf8() <= offset)
            .count();
        Position {
            file: self.file.clone(),
            line,
            column: column + u32::try_from(passed).unwrap_or(0),
        }
    }
}

fn marks(text: &str) -> Vec<(usize, u32, u32)> {
    let (mut line, mut column) = (1, 1);
    let mut marks = vec![(0, line, column)];
    let mut last = 0;
    for (offset, c) in text.char_indices() {
        if offset >= last + STRIDE {
            marks.push((offset, line, column));
            last = offset;
        }
        column += 1;
        if c == '\n' {
            (line, column) = (line + 1, 1);
            marks.push((offset + 1, line, column));
            last = offset + 1;
        }
    }
    marks
}

/// Reads a regular file as a whole.
///
/// Devices and pipes are refused: a scene that names `/dev/zero` would be read for ever.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    let fail = |message: String| Position::whole(path).error(message);
    let unreadable = |failure: std::io::Error| {
        fail(match failure.kind() {
            ErrorKind::NotFound => "no such file".to_owned(),
            ErrorKind::PermissionDenied => "no permission to read the file".to_owned(),
            _ => format!("cannot read the file: {failure}"),
        })
    };
    let kind = fs::metadata(path).map_err(unreadable)?.file_type();
    if kind.is_dir() {
        return Err(fail("is a directory, expected a file".to_owned()));
    }
    if !kind.is_file() {
        return Err(fail("is a device or a pipe, expected a file".to_owned()));
    }
    fs::read(path).map_err(unreadable)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(source: &Source, offset: usize) -> (u32, u32) {
        let position = source.position(offset);
        (position.line, position.column)
    }

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source::new(Path::new("a"), "\u{feff}ab\né€x\r\n\ny");
        assert_eq!(place(&source, 0), (1, 1));
        assert_eq!(place(&source, 2), (1, 3));
        assert_eq!(place(&source, 3), (2, 1));
        assert_eq!(place(&source, 8), (2, 3));
        assert_eq!(place(&source, source.text.len()), (4, 2));
        assert_eq!(place(&source, 1000), (4, 2));
    }

    #[test]
    fn places_agree_with_counting_from_the_start() {
        let text = format!("{}\n{}", "é".repeat(2000), "ab ".repeat(700));
        let source = Source::new(Path::new("a"), &text);
        for (offset, _) in text.char_indices().step_by(37) {
            let line = text[..offset].matches('\n').count() as u32 + 1;
            let column = text[..offset]
                .chars()
                .rev()
                .take_while(|&c| c != '\n')
                .count() as u32
                + 1;
            assert_eq!(place(&source, offset), (line, column), "offset {offset}");
        }
    }

    #[test]
    fn only_readable_text_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| Source::read(path).err().unwrap().to_string();
        let missing = folder.path().join("none.xml");
        assert!(message(&missing).ends_with("none.xml: no such file"));
        assert!(message(folder.path()).ends_with(": is a directory, expected a file"));
        let latin = folder.path().join("latin.xml");
        fs::write(&latin, b"<scene>\n<!-- caf\xe9 -->").unwrap();
        assert!(
            message(&latin)
                .ends_with("latin.xml:2:9: the text is not UTF-8, save the file in that encoding")
        );
    }
}
