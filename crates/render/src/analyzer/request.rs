//! What the user asks for with `--analyzer LIST`.

use std::path::Path;

use super::{Analyzer, matrix_file};
use crate::output::ImageError;

/// Words that stand for themselves.
const WORDS: [&str; 4] = ["rcp", "lcp", "camera", "mosaic"];
const EXPECTED: &str = "linear:ANGLE such as linear:30deg, rcp, lcp, camera, mosaic, or a Mueller matrix in a .json file";

/// One entry of the list.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// The Stokes image behind an analyzer.
    Analyzer(Box<Analyzer>),
    /// The four intensities behind the polarizers of a polarization camera.
    Camera,
    /// The raw frame of its sensor, each pixel behind the polarizer of its place.
    Mosaic,
}

impl Request {
    fn name(&self) -> &str {
        match self {
            Self::Analyzer(analyzer) => &analyzer.name,
            Self::Camera => "camera",
            Self::Mosaic => "mosaic",
        }
    }
}

/// The whole list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Requests {
    /// In the order of the command line.
    pub list: Vec<Request>,
    /// What the user should know about matrices that are doubtful.
    pub notices: Vec<String>,
}

/// Reads the entries of `--analyzer`; files are read too.
///
/// # Errors
/// An entry is unknown or there twice, an angle is no number, or a file holds no realizable Mueller matrix.
pub fn parse(entries: &[String]) -> Result<Requests, ImageError> {
    let mut requests = Requests::default();
    for entry in entries {
        let request = one(entry.trim(), &mut requests.notices)?;
        let name = request.name();
        let clash = |other: &Request| {
            other.name() == name || (*other == Request::Camera && name.starts_with("camera0"))
        };
        if requests.list.iter().any(clash) {
            return Err(wrong(format!(
                "'{entry}' would write the images '{name}' for the second time, expected names that differ"
            )));
        }
        requests.list.push(request);
    }
    Ok(requests)
}

fn wrong(problem: String) -> ImageError {
    ImageError::Request(format!("--analyzer: {problem}"))
}

fn one(entry: &str, notices: &mut Vec<String>) -> Result<Request, ImageError> {
    let analyzer = match entry {
        "camera" => return Ok(Request::Camera),
        "mosaic" => return Ok(Request::Mosaic),
        "rcp" => Analyzer::circular(false),
        "lcp" => Analyzer::circular(true),
        _ => {
            if let Some(angle) = entry.strip_prefix("linear:") {
                Analyzer::linear(degrees(angle).ok_or_else(|| {
                    wrong(format!(
                        "'{entry}' has no angle, expected degrees counter-clockwise from image right such as linear:30deg"
                    ))
                })?)
            } else if entry.to_lowercase().ends_with(".json") {
                let (analyzer, doubts) = matrix_file::read(Path::new(entry))?;
                notices.extend(doubts);
                analyzer
            } else {
                return Err(unknown(entry));
            }
        }
    };
    Ok(Request::Analyzer(Box::new(analyzer)))
}

/// An angle from `30deg`, `30°` or `30`.
fn degrees(text: &str) -> Option<f64> {
    let number = text
        .strip_suffix("deg")
        .or_else(|| text.strip_suffix('°'))
        .unwrap_or(text);
    let degrees: f64 = number.trim().parse().ok()?;
    degrees.is_finite().then_some(degrees)
}

fn unknown(entry: &str) -> ImageError {
    let likeness = |word: &str| strsim::jaro(word, entry);
    let nearest = WORDS
        .into_iter()
        .chain(["linear:30deg"])
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    let remedy = nearest
        .filter(|word| likeness(word) > 0.5)
        .map_or_else(String::new, |word| format!("; did you mean '{word}'?"));
    wrong(format!(
        "unknown analyzer '{entry}', expected {EXPECTED}{remedy}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Result<Requests, String> {
        let entries: Vec<String> = text.split(',').map(str::to_owned).collect();
        parse(&entries).map_err(|e| e.to_string())
    }

    #[test]
    fn angles_are_degrees_with_or_without_their_unit() {
        for text in [
            "linear:30deg",
            "linear:30",
            "linear: 30 deg",
            "linear:30°",
            "linear:-150",
        ] {
            let expected = Request::Analyzer(Box::new(Analyzer::linear(30.0)));
            assert_eq!(list(text).unwrap().list, [expected], "{text}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_what_was_expected() {
        for (text, expected) in [
            (
                "rpc",
                "unknown analyzer 'rpc', expected linear:ANGLE such as linear:30deg, rcp, lcp, camera, mosaic, or a Mueller matrix in a .json file; did you mean 'rcp'?",
            ),
            ("", "unknown analyzer ''"),
            ("rcp,,lcp", "unknown analyzer ''"),
            ("linear", "did you mean 'linear:30deg'?"),
            ("linear:", "'linear:' has no angle"),
            (
                "linear:x",
                "'linear:x' has no angle, expected degrees counter-clockwise from image right such as linear:30deg",
            ),
            ("linear:inf", "no angle"),
            ("linear:NaN", "no angle"),
            ("linear:0.5rad", "no angle"),
            (
                "linear:30,rcp,linear:-150deg",
                "'linear:-150deg' would write the images 'linear30' for the second time",
            ),
            ("camera,camera", "'camera' for the second time"),
            ("none.json", "none.json: cannot be read"),
        ] {
            let error = list(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
