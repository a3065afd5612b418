//! The cases of `brewster eval`: a file, its cases, and the values in them.
//!
//! A number is a decimal string or a JSON number and means the binary64 nearest to it; a complex number is
//! `{"re": …, "im": …}`, a matrix a list of rows. What is wrong is named by its place in the case, such as
//! `Theta[0][1]`.

use std::fmt;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use serde::Deserialize;
use serde_json::Value;
use stokes::MAX_ORDER;

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

/// A value of a case together with its place, for messages.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    place: String,
    value: &'a Value,
}

impl<'a> Entry<'a> {
    /// The inputs of a case.
    #[must_use]
    pub fn of(case: &'a Case) -> Self {
        Self {
            place: String::new(),
            value: &case.inputs,
        }
    }

    /// The value under `key`, if there is one.
    ///
    /// # Errors
    ///
    /// When this value is no object.
    pub fn find(&self, key: &str) -> Result<Option<Self>, CaseError> {
        let Some(object) = self.value.as_object() else {
            return Err(self.unlike("an object"));
        };
        let place = if self.place.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.place)
        };
        Ok(object.get(key).map(|value| Self { place, value }))
    }

    /// The value under `key`; `expected` says in messages what it is.
    ///
    /// # Errors
    ///
    /// When this value is no object or has no such key.
    pub fn get(&self, key: &str, expected: &'static str) -> Result<Self, CaseError> {
        self.find(key)?.ok_or_else(|| CaseError::Missing {
            key: if self.place.is_empty() {
                key.to_owned()
            } else {
                format!("{}.{key}", self.place)
            },
            expected,
        })
    }

    /// The values of a list.
    ///
    /// # Errors
    ///
    /// When this value is no list.
    pub fn list(&self) -> Result<Vec<Self>, CaseError> {
        let Some(values) = self.value.as_array() else {
            return Err(self.unlike("a list"));
        };
        let place = |i| format!("{}[{i}]", self.place);
        Ok(values
            .iter()
            .enumerate()
            .map(|(i, value)| Self {
                place: place(i),
                value,
            })
            .collect())
    }

    /// The values of a list of a known length.
    ///
    /// # Errors
    ///
    /// When this value is no list or has another length.
    pub fn array<const N: usize>(&self) -> Result<[Self; N], CaseError> {
        let list = self.list()?;
        let found = list.len();
        list.try_into()
            .map_err(|_| self.refuse(format!("found {found} values, expected {N}")))
    }

    /// A word.
    ///
    /// # Errors
    ///
    /// When this value is no string.
    pub fn word(&self) -> Result<&'a str, CaseError> {
        self.value.as_str().ok_or_else(|| self.unlike("a word"))
    }

    /// A finite number.
    ///
    /// # Errors
    ///
    /// When this value is neither a JSON number nor a decimal string, or is too large.
    pub fn number(&self) -> Result<f64, CaseError> {
        let number = match self.value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => text.parse().ok(),
            _ => None,
        };
        number
            .filter(|x| x.is_finite())
            .ok_or_else(|| self.unlike("a finite number, plain or as a decimal string"))
    }

    /// A complex number: an object of `re` and `im`, or a real number.
    ///
    /// # Errors
    ///
    /// When this value is neither.
    pub fn complex(&self) -> Result<Complex64, CaseError> {
        if !self.is_complex() {
            return self.number().map(Complex64::from);
        }
        let [re, im] = ["re", "im"].map(|part| self.get(part, "a finite number"));
        Ok(Complex64::new(re?.number()?, im?.number()?))
    }

    /// Whether this value is written as a complex number.
    #[must_use]
    pub fn is_complex(&self) -> bool {
        self.value.is_object()
    }

    /// An order of modes, at most [`MAX_ORDER`].
    ///
    /// # Errors
    ///
    /// When this value is not a whole number or too large.
    pub fn order(&self) -> Result<usize, CaseError> {
        let number = self
            .number()
            .ok()
            .filter(|x| *x >= 0.0 && x.fract() == 0.0)
            .ok_or_else(|| self.unlike("an order: a whole number, 0 or more"))?;
        if number > MAX_ORDER as f64 {
            return Err(self.refuse(format!("order {number}, expected at most {MAX_ORDER}")));
        }
        Ok(number as usize)
    }

    /// A truth value: `true`, `false`, 1 or 0.
    ///
    /// # Errors
    ///
    /// When this value is something else.
    pub fn flag(&self) -> Result<bool, CaseError> {
        if let Value::Bool(flag) = self.value {
            return Ok(*flag);
        }
        match self.number() {
            Ok(0.0) => Ok(false),
            Ok(1.0) => Ok(true),
            _ => Err(self.unlike("0 or 1")),
        }
    }

    /// A vector of the transverse plane.
    ///
    /// # Errors
    ///
    /// When this value is not a list of two numbers.
    pub fn vector(&self) -> Result<Vector2<f64>, CaseError> {
        let [x, y] = self.array()?;
        Ok(Vector2::new(x.number()?, y.number()?))
    }

    /// A matrix of the transverse plane.
    ///
    /// # Errors
    ///
    /// When this value is not a list of two rows of two numbers.
    pub fn matrix(&self) -> Result<Matrix2<f64>, CaseError> {
        let [first, second] = self.array()?;
        let (first, second) = (first.vector()?, second.vector()?);
        Ok(Matrix2::new(first.x, first.y, second.x, second.y))
    }

    /// The error that this value is refused, and why.
    #[must_use]
    pub fn refuse(&self, problem: impl fmt::Display) -> CaseError {
        CaseError::Domain {
            key: self.place.clone(),
            problem: problem.to_string(),
        }
    }

    fn unlike(&self, expected: &str) -> CaseError {
        CaseError::Kind {
            key: if self.place.is_empty() {
                "inputs".to_owned()
            } else {
                self.place.clone()
            },
            found: shown(self.value),
            expected: expected.to_owned(),
        }
    }
}

/// A value as it stands in the file, shortened.
fn shown(value: &Value) -> String {
    const MOST: usize = 40;
    let text = value.to_string();
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(inputs: &str) -> Case {
        let text = format!(
            "{{\"schema\": \"hg-oracle-1\", \"group\": \"g\", \"cases\": [{{\"id\": \"a\", \"op\": \"b\", \"err\": {{}}, \"inputs\": {inputs}}}]}}"
        );
        CaseFile::parse("test", text.as_bytes())
            .unwrap()
            .cases
            .remove(0)
    }

    #[test]
    fn every_spelling_means_the_nearest_number() {
        // a plain reader of JSON misses these by a unit in the last place
        for text in [
            "2.2250738585072012e-308",
            "9007199254740993",
            "0.1",
            "5.1241629831779156e-02",
            "1.00000000000000011102230246251565404236316680908203125",
            "123456789012345678901234567890",
            "8.41E+21",
        ] {
            let expected: f64 = text.parse().unwrap();
            for spelling in [text.to_owned(), format!("\"{text}\"")] {
                let case = case(&format!("{{\"x\": {spelling}}}"));
                let found = Entry::of(&case).get("x", "").unwrap().number();
                assert_eq!(found, Ok(expected), "{spelling}");
            }
        }
    }

    #[test]
    fn places_lead_to_the_value() {
        let case = case(
            r#"{"I": {"S_list": [[["1", "2"], ["3", {"re": 1}]]]}, "c": {"re": "1", "im": 2}, "r": "3"}"#,
        );
        let inputs = Entry::of(&case);
        let matrix = &inputs
            .get("I", "")
            .unwrap()
            .get("S_list", "")
            .unwrap()
            .list()
            .unwrap()[0];
        let said = matrix.matrix().unwrap_err().to_string();
        assert!(
            said.starts_with(
                r#"key 'I.S_list[0][1][1]': found {"re":1}, expected a finite number"#
            ),
            "{said}"
        );
        let imaginary = matrix.list().unwrap()[1].list().unwrap()[1].complex();
        assert_eq!(
            imaginary.unwrap_err().to_string(),
            "key 'I.S_list[0][1][1].im' is missing, expected a finite number"
        );
        let complex = |key| inputs.get(key, "").unwrap().complex();
        assert_eq!(complex("c"), Ok(Complex64::new(1.0, 2.0)));
        assert_eq!(complex("r"), Ok(Complex64::new(3.0, 0.0)));
    }

    #[test]
    fn flags_are_truth_values_or_0_and_1() {
        for (text, expected) in [
            ("true", Some(true)),
            ("0", Some(false)),
            ("1", Some(true)),
            ("\"1\"", Some(true)),
            ("2", None),
            ("\"yes\"", None),
            ("null", None),
        ] {
            let case = case(&format!("{{\"dual\": {text}}}"));
            let found = Entry::of(&case).get("dual", "").unwrap().flag();
            assert_eq!(found.ok(), expected, "{text}");
        }
    }

    #[test]
    fn long_values_are_shortened_in_messages() {
        let case = case(&format!("{{\"x\": \"{}\"}}", "ξ".repeat(100)));
        let said = Entry::of(&case)
            .get("x", "")
            .unwrap()
            .number()
            .unwrap_err()
            .to_string();
        assert!(
            said.contains("ξ…, expected") && said.chars().count() < 120,
            "{said}"
        );
    }
}
