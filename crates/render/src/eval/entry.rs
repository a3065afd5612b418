//! The values in a case, each with its place for messages, such as `I.S_list[0]`.
//!
//! A number is a decimal string or a JSON number and means the binary64 nearest to it; a complex number is
//! `{"re": …, "im": …}`, a matrix a list of rows.

use std::fmt;

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use serde_json::Value;
use stokes::MAX_ORDER;

use super::schema::{Case, CaseError, shown};

/// What messages call a vector of the transverse plane.
pub const VECTOR: &str = "a list of two numbers";

/// What messages call a vector of space.
pub const DIRECTION: &str = "a list of three numbers";

/// What messages call a matrix of the transverse plane.
pub const MATRIX: &str = "a matrix: a list of two rows of two numbers";

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

    /// A whole file.
    #[must_use]
    pub fn whole(value: &'a Value) -> Self {
        Self {
            place: String::new(),
            value,
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

    /// The values of a list of a known length, each as `read` takes it.
    ///
    /// # Errors
    ///
    /// When this value is no list, has another length, or an entry is refused.
    pub fn array_of<T: Copy + Default, const N: usize>(
        &self,
        read: impl Fn(&Self) -> Result<T, CaseError>,
    ) -> Result<[T; N], CaseError> {
        let mut values = [T::default(); N];
        for (value, entry) in values.iter_mut().zip(self.array::<N>()?) {
            *value = read(&entry)?;
        }
        Ok(values)
    }

    /// Whether this value is written as a list.
    #[must_use]
    pub fn is_list(&self) -> bool {
        self.value.is_array()
    }

    /// Whether this value stands for nothing.
    #[must_use]
    pub fn is_null(&self) -> bool {
        self.value.is_null()
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

    /// A complex number, also as the list of its two parts.
    ///
    /// # Errors
    ///
    /// When this value is neither a number, an object of `re` and `im`, nor a list of two numbers.
    pub fn complex_or_parts(&self) -> Result<Complex64, CaseError> {
        if self.value.is_array() {
            let [re, im] = self.array_of(Self::number)?;
            return Ok(Complex64::new(re, im));
        }
        self.complex()
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

    /// A vector of space.
    ///
    /// # Errors
    ///
    /// When this value is not a list of three numbers.
    pub fn direction(&self) -> Result<Vector3<f64>, CaseError> {
        self.array_of(Self::number).map(Vector3::from)
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
            key: self.name(),
            problem: problem.to_string(),
        }
    }

    fn unlike(&self, expected: &str) -> CaseError {
        CaseError::Kind {
            key: self.name(),
            found: shown(self.value),
            expected: expected.to_owned(),
        }
    }

    /// What messages call this value.
    fn name(&self) -> String {
        if self.place.is_empty() {
            "inputs".to_owned()
        } else {
            self.place.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::schema::CaseFile;

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
