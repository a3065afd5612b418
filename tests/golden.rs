//! Claim: `brewster eval` finds the numbers of an independent implementation, and no damage to its file makes it panic.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use brewster_tests::{brewster, repository, results_by_id};
use render::eval::schema::CaseFile;
use render::eval::{self, Precision};
use serde_json::{Value, json};

const FILES: [&str; 20] = [
    "hermite1d",
    "phi_whitened",
    "sym_power",
    "cov_to_white",
    "overlap",
    "wvd",
    "projection",
    "shape",
    "psi_covariant",
    "psi_zero",
    "ft_pair",
    "observables",
    "jones",
    "phase_screen",
    "fresnel",
    "egsm",
    "coherency",
    "scatter",
    "rough_lobe",
    "interaction",
];

/// A case of every operation that no other implementation of the schema has; `validation/fields.py` and
/// `validation/surfaces.py` check their numbers.
const OWN: &str = r#"[
    {"id": "film", "op": "multilayer", "inputs": {"n_incident": 1.5, "n_exit": "1.0", "cos_i": 0.6, "lambda": 5e-7,
        "layers": [[1.38, 1e-7], {"n": {"re": 0.2, "im": -3.4}, "thickness": 2e-8}]}},
    {"id": "plate", "op": "plate", "inputs": {"n_incident": 1, "n_exit": 1.5, "cos_i": 0.8, "lambda": 5e-7, "azimuth": 0.3,
        "side": "back", "method": "coherent", "coherent_below": 0, "layers": [
            {"n": 1.5, "gyration": 1e-4, "thickness": 1e-6},
            {"n": [1.5, 1.7], "axis": [1, 0, 1], "thickness": 2e-6, "turned": 0.2},
            {"n": [1.5, 1.6, 1.7], "axes": [[1, 0, 0], [0, 1, 1]], "thickness": 1e-6,
             "gyration": [[0, 1e-4, 0], [1e-4, 0, 0], [0, 0, 1e-4]]}]}},
    {"id": "parts", "op": "decompose", "inputs": {"tolerance": 1e-9,
        "M": [[0.9, 0.1, 0, 0.1], [0.2, 0.5, 0.1, 0], [0, -0.1, 0.6, 0.2], [0.1, 0, 0.1, 0.4]]}},
    {"id": "element", "op": "jones_element", "inputs": {"element": "elliptical_retarder", "azimuth": 0.3,
        "ellipticity": 0.1, "retardance": 1.2, "rotated": -0.4}},
    {"id": "relief", "op": "surface", "inputs": {"boundary": {"kind": "film", "n_front": 1, "layers": [[1.4, 1e-7]], "n_back": 1.5},
        "relief": {"kind": "gaussian", "sigma": 5e-8, "l": [3e-6, 2e-6]}, "to_source": [0.6, 0, 0.8],
        "to_observer": [0, 0.6, -0.8], "lambda": 5e-7, "light": {"kind": "gaussian", "angles": 0.1}, "tolerance": 1e-2,
        "obliquity": 1, "shadowing": 1, "x_in": [0, 1, 0], "x_out": [1, 0, 0]}},
    {"id": "orders", "op": "grating", "inputs": {"profile": [{"kind": "blazed", "sense": "rising", "depth": 2e-7},
        {"kind": "lamellar", "depth": 1e-7, "ridge_fraction": 0.5}], "pitch": [1e-6, 6e-7], "across": [0.6, 0.8],
        "to_source": [0, 0.6, 0.8], "lambda": 5e-7, "side": "transmission", "n_incident": 1.5, "n_outgoing": 1}},
    {"id": "young", "op": "slits", "inputs": {"openings": [{"centre": [-5e-5, 0], "width": 1e-5, "height": 1e-3},
        {"centre": [5e-5, 0], "width": 1e-5, "height": 1e-3, "T": [[1, 0], [0, 0.5]]}], "screen_area": 1e-6,
        "to_source": [0, 0, -1], "to_observers": [[0, 0.6, 0.8]], "lambda": 5e-7, "light": {"kind": "disk",
        "angles": [[1e-3, 0], [0, 1e-4]]}, "tolerance": 1e-3, "pair": [0, 1], "stokes": [1, 0, 0, 0.5]}}
]"#;

/// Operations that `--f32` computes in single precision.
const SINGLE: [&str; 2] = ["hermite1d", "phi"];

fn golden(file: &str) -> PathBuf {
    repository().join(format!("tests/golden/{file}.json"))
}

/// The numbers under a key by place; a complex number is two.
fn numbers(value: &Value, place: &str, into: &mut BTreeMap<String, f64>) {
    match value {
        Value::Object(object) => {
            // the only word among the results
            for (key, value) in object.iter().filter(|(key, _)| *key != "method") {
                numbers(value, &format!("{place}/{key}"), into);
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                numbers(value, &format!("{place}/{i}"), into);
            }
        }
        Value::String(text) => {
            into.insert(place.to_owned(), text.parse().unwrap());
        }
        other => panic!("{place}: {other} is no decimal string"),
    }
}

fn flat(value: &Value) -> BTreeMap<String, f64> {
    let mut map = BTreeMap::new();
    numbers(value, "", &mut map);
    map
}

/// How far `found` is from `expected`, and the scale of the latter: largest moduli over the places of a key.
fn distance(found: &Value, expected: &Value) -> (f64, f64) {
    let (found, mut expected) = (flat(found), flat(expected));
    for place in found.keys() {
        // a complex number that is real may be written so
        if let Some(whole) = place.strip_suffix("/re")
            && let Some(re) = expected.remove(whole)
        {
            expected.insert(place.clone(), re);
            expected.insert(format!("{whole}/im"), 0.0);
        }
    }
    assert!(
        found.keys().eq(expected.keys()),
        "found {found:?}, expected {expected:?}"
    );
    let most = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
    let difference = most(&mut expected.iter().map(|(place, e)| {
        let difference = (found[place] - e).abs();
        assert!(difference.is_finite(), "{place}: {}", found[place]);
        difference
    }));
    (difference, most(&mut expected.values().map(|e| e.abs())))
}

/// Runs the program on a golden file and checks every number in its answer.
fn check(file: &str, single: bool) {
    let text = fs::read_to_string(golden(file)).unwrap();
    let cases: Value = serde_json::from_str(&text).unwrap();
    let mut command = brewster();
    command.arg("eval").arg(golden(file));
    if single {
        command.arg("--f32");
    }
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{file}: {said}");
    assert!(said.is_empty(), "{file}: {said}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let results = results_by_id(&answer);
    let cases = cases["cases"].as_array().unwrap();
    assert_eq!(
        results.len(),
        cases.len(),
        "{file}: one result for each case"
    );
    for case in cases {
        let id = case["id"].as_str().unwrap();
        for (key, expected) in case["expected"].as_object().unwrap() {
            let found = results[id]
                .get(key)
                .unwrap_or_else(|| panic!("{id}: no {key}"));
            if ["cov", "c_cov"].contains(&key.as_str()) {
                continue;
            }
            let (difference, scale) = distance(found, expected);
            let limit = if single && SINGLE.contains(&case["op"].as_str().unwrap()) {
                if scale >= 1e-30 { 2e-5 * scale } else { 1e-6 }
            } else {
                let sensitivity = &case["err"]["one_ulp_input_sensitivity"][key];
                let sensitivity: f64 = sensitivity.as_str().map_or(0.0, |s| s.parse().unwrap());
                (1e-12 + 64.0 * sensitivity) * scale.max(1e-290)
            };
            assert!(
                difference <= limit,
                "{id} {key}: off by {difference:e}, limit {limit:e}"
            );
        }
    }
}

#[test]
fn every_golden_number_is_found() {
    for file in FILES {
        check(file, false);
    }
}

#[test]
fn every_golden_number_is_found_in_single_precision() {
    for file in FILES {
        check(file, true);
    }
}

/// The shortest case of every operation in the golden files.
fn one_case_each() -> String {
    let mut cases: BTreeMap<String, Value> = BTreeMap::new();
    for file in FILES {
        let text = fs::read_to_string(golden(file)).unwrap();
        let golden: Value = serde_json::from_str(&text).unwrap();
        for case in golden["cases"].as_array().unwrap() {
            let case = json!({"id": case["id"], "op": case["op"], "inputs": case["inputs"]});
            let op = case["op"].as_str().unwrap().to_owned();
            let known = cases.entry(op).or_insert_with(|| case.clone());
            if case.to_string().len() < known.to_string().len() {
                *known = case;
            }
        }
    }
    let own: Vec<Value> = serde_json::from_str(OWN).unwrap();
    for case in own {
        let op = case["op"].as_str().unwrap().to_owned();
        assert!(
            cases.insert(op, case).is_none(),
            "one case of each operation"
        );
    }
    assert_eq!(
        cases.keys().cloned().collect::<Vec<_>>(),
        {
            let mut names: Vec<_> = eval::OPS.iter().map(|op| op.name.to_owned()).collect();
            names.sort();
            names
        },
        "every operation has a golden file or a case here"
    );
    let cases: Value = cases.into_values().collect();
    json!({"schema": "hg-oracle-1", "cases": cases}).to_string()
}

#[test]
fn no_damage_to_a_file_makes_a_panic_or_a_number_that_is_none() {
    let text = one_case_each();
    let try_out = |bytes: &[u8]| {
        let Ok(file) = CaseFile::parse("damaged", bytes) else {
            return;
        };
        for case in &file.cases {
            let Some(op) = eval::find(&case.op) else {
                continue;
            };
            for precision in [Precision::Double, Precision::Single] {
                if let Ok(result) = op.evaluate(case, precision) {
                    assert!(flat(&result).values().all(|x| x.is_finite()), "{case:?}");
                }
            }
        }
    };
    try_out(text.as_bytes());
    for end in 0..text.len() {
        assert!(CaseFile::parse("cut", &text.as_bytes()[..end]).is_err());
    }
    let mut bytes = text.into_bytes();
    for place in 0..bytes.len() {
        let whole = bytes[place];
        // each place gets one of these, each of these gets every kind of place
        let damage = b"0-9\"e{[,nx}]:\xff 1."[place % 17];
        bytes[place] = damage;
        try_out(&bytes);
        bytes[place] = whole;
    }
}
