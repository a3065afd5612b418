//! A Mueller matrix from a JSON file.
//!
//! ```json
//! { "description": "quarter-wave plate, fast axis at 0", "mueller": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]] }
//! ```
//!
//! Or the four rows alone. Rows and columns are S0 to S3 in the frame of a pixel: x image right, y image up.

use std::fs;
use std::path::Path;

use csdm::CloudeSpectrum;
use serde_json::Value;
use stokes::Mueller;

use super::Analyzer;
use crate::output::ImageError;

/// Eigenvalues of the coherency matrix below minus this times M00 are no rounding of what was written.
const ROUNDING: f64 = 1e-6;
/// Below minus this times M00 they are no noise of a measurement either.
const NOISE: f64 = 1e-3;

/// Reads a matrix, and what is doubtful about it.
///
/// # Errors
/// The file cannot be read, holds no 4×4 matrix, or no ensemble of Jones matrices has it.
pub(super) fn read(path: &Path) -> Result<(Analyzer, Vec<String>), ImageError> {
    let text = fs::read_to_string(path).map_err(|source| ImageError::Read {
        path: path.to_owned(),
        source,
    })?;
    let problem = |problem: String| ImageError::content(path, problem);
    let value: Value =
        serde_json::from_str(&text).map_err(|e| problem(format!("not JSON: {e}")))?;
    let (rows, description) = parts(&value).map_err(problem)?;
    let mueller = matrix(rows).map_err(problem)?;
    let doubts = doubts(&mueller).map_err(problem)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let analyzer = Analyzer {
        description: description.unwrap_or_else(|| format!("Mueller matrix of {}", path.display())),
        name: stem.into_owned(),
        matrix: mueller,
    };
    let place = |doubt: String| format!("{}: {doubt}", path.display());
    Ok((analyzer, doubts.into_iter().map(place).collect()))
}

/// The rows, and a description where there is one.
fn parts(value: &Value) -> Result<(&Value, Option<String>), String> {
    let Value::Object(object) = value else {
        return Ok((value, None));
    };
    if let Some(key) = object
        .keys()
        .find(|key| !["mueller", "description"].contains(&key.as_str()))
    {
        return Err(format!(
            "unknown key '{key}', expected 'mueller' and perhaps 'description'"
        ));
    }
    let rows = object
        .get("mueller")
        .ok_or("no key 'mueller', expected four rows of four numbers there")?;
    match object.get("description") {
        None => Ok((rows, None)),
        Some(Value::String(text)) => Ok((rows, Some(text.clone()))),
        Some(other) => Err(format!("'description' is {other}, expected a text")),
    }
}

fn matrix(value: &Value) -> Result<Mueller, String> {
    let rows = value.as_array().ok_or_else(|| {
        "no Mueller matrix, expected four rows of four numbers: [[1, 0, 0, 0], …]".to_owned()
    })?;
    let mut out = [[0.0; 4]; 4];
    if rows.len() != 4 {
        return Err(format!("{} rows, expected 4 of 4 numbers each", rows.len()));
    }
    for (i, row) in rows.iter().enumerate() {
        let numbers = row
            .as_array()
            .ok_or_else(|| format!("row {i} is {row}, expected 4 numbers"))?;
        if numbers.len() != 4 {
            return Err(format!("row {i} has {} numbers, expected 4", numbers.len()));
        }
        for (j, number) in numbers.iter().enumerate() {
            out[i][j] = number
                .as_f64()
                .ok_or_else(|| format!("element ({i}, {j}) is {number}, expected a number"))?;
        }
    }
    Ok(Mueller::from_rows(out))
}

/// Refuses what no matter does; tells what ideal passive matter does not do.
fn doubts(mueller: &Mueller) -> Result<Vec<String>, String> {
    let m00 = mueller.element(0, 0);
    if m00 <= 0.0 {
        return Err(format!(
            "element (0, 0) is {m00}, expected a positive transmittance"
        ));
    }
    let spectrum = CloudeSpectrum::of(mueller).map_err(|e| e.to_string())?;
    let mut doubts = Vec::new();
    let least = spectrum.eigenvalues()[3] / m00;
    if least < -NOISE {
        return Err(format!(
            "not realizable: its coherency matrix has the eigenvalue {least:.3e} in units of M00, expected none below {:.0e}; no matter has this Mueller matrix",
            -NOISE
        ));
    }
    if least < -ROUNDING {
        doubts.push(format!(
            "not quite realizable: its coherency matrix has the eigenvalue {least:.1e} in units of M00, expected none below 0; used as it is"
        ));
    }
    if !mueller.is_passive(ROUNDING) {
        doubts.push("amplifies some light, expected M00 + |(M01, M02, M03)| and M00 + |(M10, M20, M30)| of at most 1; used as it is".to_owned());
    }
    Ok(doubts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<(Analyzer, Vec<String>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plate.json");
        fs::write(&path, text).unwrap();
        read(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn rows_are_read_with_and_without_a_description() {
        let rows = "[[0.5, 0.5, 0, 0], [0.5, 0.5, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]";
        let (bare, doubts) = read_text(rows).unwrap();
        assert_eq!((bare.name.as_str(), doubts.len()), ("plate", 0));
        let text = format!(r#"{{"description": "a sheet", "mueller": {rows}}}"#);
        let (described, _) = read_text(&text).unwrap();
        assert_eq!(described.description, "a sheet");
        assert_eq!(described.matrix, bare.matrix);
        assert!(Analyzer::linear(0.0).matrix == bare.matrix);
    }

    #[test]
    fn what_is_no_matter_is_refused() {
        let rows = |a: &str, last: &str| {
            format!("[[{a}, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0], {last}]")
        };
        for (text, expected) in [
            (
                "[[1, 0,".to_owned(),
                "plate.json: not JSON: EOF while parsing a value at line 1",
            ),
            ("3".to_owned(), "no Mueller matrix, expected four rows"),
            ("[[1]]".to_owned(), "1 rows, expected 4"),
            (rows("1", "[0, 0, 1]"), "row 3 has 3 numbers, expected 4"),
            (rows("1", "7"), "row 3 is 7, expected 4 numbers"),
            (
                rows("1", "[0, 0, 0, \"x\"]"),
                "element (3, 3) is \"x\", expected a number",
            ),
            (
                rows("0", "[0, 0, 0, 0]"),
                "element (0, 0) is 0, expected a positive transmittance",
            ),
            // diag(1, ½, ½, −0.9): least eigenvalue (1 − ½ − ½ − 0.9)/4
            (
                rows("1", "[0, 0, 0, -0.9]"),
                "not realizable: its coherency matrix has the eigenvalue",
            ),
            (
                "{\"muller\": []}".to_owned(),
                "unknown key 'muller', expected 'mueller'",
            ),
            ("{}".to_owned(), "no key 'mueller'"),
            (
                format!(
                    "{{\"mueller\": {}, \"description\": 1}}",
                    rows("1", "[0, 0, 0, 0]")
                ),
                "'description' is 1, expected a text",
            ),
        ] {
            let error = read_text(&text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn noise_and_gain_are_told() {
        // diag(1, a, a, −b): least eigenvalue (1 − 2a − b)/4
        let diagonal = |d: [f64; 4]| {
            let row = |i: usize| {
                format!(
                    "{:?}",
                    std::array::from_fn::<_, 4, _>(|j| if i == j { d[i] } else { 0.0 })
                )
            };
            format!("[{}, {}, {}, {}]", row(0), row(1), row(2), row(3))
        };
        let (_, doubts) = read_text(&diagonal([1.0, 0.5, 0.5, -0.001])).unwrap();
        assert!(
            doubts[0].contains("not quite realizable") && doubts[0].contains("-2.5e-4"),
            "{doubts:?}"
        );
        let (_, doubts) = read_text(&diagonal([1.5, 0.5, 0.5, 0.5])).unwrap();
        assert!(doubts[0].contains("amplifies"), "{doubts:?}");
    }
}
