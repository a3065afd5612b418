//! The files of `brewster eval`: cases by id, and what is said of a case that has no result.

use serde::Deserialize;
use serde_json::Value;

/// The name that a file of cases bears under `schema`.
const SCHEMA: &str = "hg-oracle-1";

/// Why a case has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CaseError {
    /// A key is not there.
    #[error("key '{key}' is missing, expected {expected}")]
    Missing {
        /// Its place.
        key: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A value is of another kind.
    #[error("key '{key}': found {found}, expected {expected}")]
    Kind {
        /// Its place.
        key: String,
        /// The value, or how it begins.
        found: String,
        /// What should be there.
        expected: String,
    },
    /// A value is of the right kind and still refused.
    #[error("key '{key}': {problem}")]
    Domain {
        /// Its place.
        key: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// A result is too large for a binary64.
    #[error(
        "result '{key}' is {value}, expected a finite number: it is beyond double precision for these inputs"
    )]
    NotFinite {
        /// Its place.
        key: String,
        /// What came out.
        value: f64,
    },
}

/// A file of cases.
#[derive(Debug, Deserialize)]
#[serde(expecting = "an object with 'schema' and 'cases'")]
pub struct CaseFile {
    #[serde(rename = "schema")]
    _schema: Schema,
    /// The cases, in the order of the file.
    pub cases: Vec<Case>,
}

/// One operation and what it is to be done on.
#[derive(Debug, Deserialize)]
#[serde(expecting = "a case: an object with 'id', 'op' and 'inputs'")]
pub struct Case {
    /// Name of the case, once in a file.
    pub id: String,
    /// Name of the operation.
    pub op: String,
    /// Its inputs, an object; null where there are none.
    #[serde(default)]
    pub inputs: Value,
}

#[derive(Debug, Deserialize)]
#[serde(try_from = "String")]
struct Schema;

impl TryFrom<String> for Schema {
    type Error = String;
    fn try_from(name: String) -> Result<Self, String> {
        if name == SCHEMA {
            Ok(Self)
        } else {
            Err(format!(
                "'schema' is {}, expected \"{SCHEMA}\"",
                shown(&name.into())
            ))
        }
    }
}

impl CaseFile {
    /// Reads a file of cases; `name` is what messages call it.
    ///
    /// # Errors
    ///
    /// `name:line:column: …` when the text is not JSON or not of the schema; `name: …` when two cases have one id.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let file: Self = serde_json::from_slice(bytes).map_err(|error| {
            let (line, column) = (error.line(), error.column());
            let text = error.to_string();
            let problem = text
                .strip_suffix(&format!(" at line {line} column {column}"))
                .unwrap_or(&text);
            format!("{name}:{line}:{column}: {problem}")
        })?;
        let mut places = std::collections::BTreeMap::new();
        for (place, case) in file.cases.iter().enumerate() {
            if let Some(first) = places.insert(&case.id, place) {
                return Err(format!(
                    "{name}: cases {} and {} have the same id '{}', expected each id once",
                    first + 1,
                    place + 1,
                    case.id
                ));
            }
        }
        Ok(file)
    }
}

/// A value as it stands in the file, shortened.
pub(super) fn shown(value: &Value) -> String {
    const MOST: usize = 40;
    let text = value.to_string();
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
