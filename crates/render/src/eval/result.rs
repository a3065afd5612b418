//! The results of `brewster eval`: numbers by name, written with 17 significant digits or refused, and words.

use nalgebra::{DMatrix, SMatrix};
use num_complex::Complex64;
use serde_json::{Map, Value, json};

use super::schema::CaseError;

/// A result: numbers and words in lists and groups.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A real number.
    Real(f64),
    /// A complex number.
    Complex(Complex64),
    /// What was chosen, by name.
    Word(&'static str),
    /// Numbers in a row, or rows of them.
    List(Vec<Item>),
    /// Results by name.
    Group(Vec<(&'static str, Item)>),
}

impl Item {
    /// The one result `value`.
    pub fn value(value: impl Into<Self>) -> Self {
        Self::Group(vec![("value", value.into())])
    }

    /// The result in the schema's form.
    ///
    /// # Errors
    ///
    /// When a number is infinite or not a number.
    pub fn to_json(&self) -> Result<Value, CaseError> {
        self.at("")
    }

    fn at(&self, place: &str) -> Result<Value, CaseError> {
        let real = |x: f64| {
            if x.is_finite() {
                Ok(decimal(x))
            } else {
                let key = place.to_owned();
                Err(CaseError::NotFinite { key, value: x })
            }
        };
        Ok(match self {
            Self::Real(x) => real(*x)?.into(),
            Self::Complex(z) => json!({"re": real(z.re)?, "im": real(z.im)?}),
            Self::Word(word) => (*word).into(),
            Self::List(items) => items
                .iter()
                .enumerate()
                .map(|(i, item)| item.at(&format!("{place}[{i}]")))
                .collect::<Result<Value, _>>()?,
            Self::Group(items) => {
                let mut object = Map::new();
                for (name, item) in items {
                    let dot = if place.is_empty() { "" } else { "." };
                    let value = item.at(&format!("{place}{dot}{name}"))?;
                    object.insert((*name).to_owned(), value);
                }
                object.into()
            }
        })
    }
}

/// A number with 17 significant digits, as C's `%.16e` prints it.
fn decimal(x: f64) -> String {
    let text = format!("{x:.16e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let (sign, digits) = match exponent.strip_prefix('-') {
        Some(digits) => ('-', digits),
        None => ('+', exponent),
    };
    format!("{mantissa}e{sign}{digits:0>2}")
}

impl From<f64> for Item {
    fn from(x: f64) -> Self {
        Self::Real(x)
    }
}

impl From<Complex64> for Item {
    fn from(z: Complex64) -> Self {
        Self::Complex(z)
    }
}

impl<T: Into<Item>> From<Vec<T>> for Item {
    fn from(values: Vec<T>) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<Item> + Copy, const R: usize, const C: usize> From<SMatrix<T, R, C>> for Item {
    fn from(m: SMatrix<T, R, C>) -> Self {
        let row = |r| (0..C).map(|c| m[(r, c)]).collect::<Vec<_>>();
        (0..R).map(row).collect::<Vec<_>>().into()
    }
}

impl From<DMatrix<f64>> for Item {
    fn from(m: DMatrix<f64>) -> Self {
        m.row_iter()
            .map(|row| row.iter().copied().collect::<Vec<_>>())
            .collect::<Vec<_>>()
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_c_writes_them_and_read_back_the_same() {
        for (x, text) in [
            (0.0, "0.0000000000000000e+00"),
            (-0.0, "-0.0000000000000000e+00"),
            (1.0, "1.0000000000000000e+00"),
            (0.1, "1.0000000000000001e-01"),
            (-2.5e17, "-2.5000000000000000e+17"),
            (5e-324, "4.9406564584124654e-324"),
            (f64::MAX, "1.7976931348623157e+308"),
        ] {
            assert_eq!(decimal(x), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
    }

    #[test]
    fn a_number_that_is_none_is_refused_with_its_place() {
        let nested =
            |x: f64| Item::Group(vec![("rows", vec![vec![0.0, 1.0], vec![2.0, x]].into())]);
        let rows = json!({"rows": [[decimal(0.0), decimal(1.0)], [decimal(2.0), decimal(3.0)]]});
        assert_eq!(nested(3.0).to_json(), Ok(rows));
        for x in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            let said = nested(x).to_json().unwrap_err().to_string();
            let expected = format!("result 'rows[1][1]' is {x}, expected a finite number");
            assert!(said.starts_with(&expected), "{said}");
        }
        let complex = Item::value(Complex64::new(1.0, f64::NAN));
        assert!(complex.to_json().is_err());
    }

    #[test]
    fn matrices_are_written_by_rows() {
        use nalgebra::Matrix2;
        let [a, b, c, d] = [1.0, 2.0, 3.0, 4.0].map(decimal);
        let expected = json!([[a, b], [c, d]]);
        assert_eq!(
            Item::from(Matrix2::new(1.0, 2.0, 3.0, 4.0)).to_json(),
            Ok(expected.clone())
        );
        let large = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(Item::from(large).to_json(), Ok(expected));
    }
}
