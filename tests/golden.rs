//! Claim: `brewster eval` finds the numbers of an independent implementation, and survives any file.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Output, Stdio};

use brewster_tests::{brewster, repository};
use render::eval::schema::CaseFile;
use render::eval::{self, Precision};
use serde_json::{Value, json};

const FILES: [&str; 12] = [
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
];

/// Operations that `--f32` computes in single precision.
const SINGLE: [&str; 2] = ["hermite1d", "phi"];

fn golden(file: &str) -> PathBuf {
    repository().join(format!("tests/golden/{file}.json"))
}

/// The numbers under a key by place; a complex number is two.
fn numbers(value: &Value, place: &str, into: &mut BTreeMap<String, f64>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
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
    let (found, expected) = (flat(found), flat(expected));
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
    let results = by_id(&answer);
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
            if key == "cov" {
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

/// The results of an answer; the same id twice fails.
fn by_id(answer: &Value) -> BTreeMap<String, &Value> {
    let mut results = BTreeMap::new();
    for case in answer["cases"].as_array().unwrap() {
        let id = case["id"].as_str().unwrap().to_owned();
        assert!(results.insert(id, &case["result"]).is_none(), "{case}");
    }
    results
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

/// Runs `brewster eval -` with further arguments on a text.
fn eval_text(text: &str, arguments: &[&str]) -> Output {
    let mut child = brewster()
        .args(["eval", "-"])
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(text.as_bytes()).unwrap();
    drop(stdin);
    child.wait_with_output().unwrap()
}

fn file_of(cases: &Value) -> String {
    json!({"schema": "hg-oracle-1", "cases": cases}).to_string()
}

fn hermite(id: &str, n: Value, t: Value) -> Value {
    json!({"id": id, "op": "hermite1d", "inputs": {"n": n, "t": t}})
}

/// Exit status, what was written to standard output and what was said.
fn parts(output: &Output) -> (Option<i32>, Value, String) {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!said.contains("panicked"), "{said}");
    let value = serde_json::from_slice(&output.stdout).unwrap_or(Value::Null);
    (output.status.code(), value, said)
}

#[test]
fn numbers_are_strings_or_plain_and_come_back_with_17_digits() {
    let cases = json!([
        hermite("text", json!("0"), json!("1.0000000000000000e+00")),
        hermite("plain", json!(0), json!(1.0)),
        hermite("tiny", json!(0), json!("40")),
    ]);
    let (status, answer, said) = parts(&eval_text(&file_of(&cases), &[]));
    assert_eq!((status, said.as_str()), (Some(0), ""));
    let results = by_id(&answer);
    assert_eq!(results["text"], results["plain"]);
    // π^(-1/4) e^(-1/2) = 0.4555806720113325, to the digit that binary64 holds
    let text = results["text"]["value"].as_str().unwrap();
    assert!(text.starts_with("4.555806720113325") && text.ends_with("e-01") && text.len() == 22);
    // below the smallest number
    assert_eq!(results["tiny"]["value"], "0.0000000000000000e+00");
}

#[test]
fn unknown_operations_are_named_once_and_the_rest_is_computed() {
    let cases = json!([
        {"id": "a", "op": "frobnicate", "inputs": {}},
        hermite("b", json!(2), json!("0.5")),
        {"id": "c", "op": "frobnicate", "inputs": {}},
        {"id": "d", "op": "zap"},
    ]);
    let (status, answer, said) = parts(&eval_text(&file_of(&cases), &[]));
    assert_eq!(status, Some(1));
    assert_eq!(by_id(&answer).keys().collect::<Vec<_>>(), ["b"]);
    assert_eq!(
        said.lines().collect::<Vec<_>>(),
        [
            "brewster: standard input: unknown op 'frobnicate': 2 cases left out",
            "brewster: standard input: unknown op 'zap': 1 case left out"
        ]
    );
}

#[test]
fn a_wrong_case_is_named_and_the_rest_is_computed() {
    let phi = |root: Value, x: Value| json!({"id": "bad", "op": "phi", "inputs": {"a": 0, "b": 1, "W": root, "x": x}});
    let one = json!([["1", "0"], ["0", "1"]]);
    let psi = |theta: Value, dual: Value| json!({"id": "bad", "op": "psi", "inputs": {"n": 0, "m": 1, "Theta": theta, "x": [0, 0], "dual": dual}});
    let shape = |profile: Value| json!({"id": "bad", "op": "shape", "inputs": {"I": profile, "P": [[1, 0], [0, 1]]}});
    let csd = |lambda: f64, r: f64, mode: Value| json!({"id": "bad", "op": "csd", "inputs": {"lambda": lambda, "r": r, "Theta": [[1, 0], [0, 1]], "Q": [[1, 0], [0, 1]], "modes": [mode], "xi": [0, 0]}});
    for (case, expected) in [
        (
            json!({"id": "bad", "op": "hermite1d", "inputs": {"n": 1}}),
            "key 't' is missing, expected a finite number (hermite1d takes n, t)",
        ),
        (
            json!({"id": "bad", "op": "hermite1d"}),
            "key 'inputs': found null, expected an object",
        ),
        (
            json!({"id": "bad", "op": "hermite1d", "inputs": [1, 2]}),
            "key 'inputs': found [1,2], expected an object",
        ),
        (
            hermite("bad", json!(257), json!(0)),
            "key 'n': order 257, expected at most 256",
        ),
        (
            hermite("bad", json!(-1), json!(0)),
            "key 'n': found -1, expected an order: a whole number, 0 or more",
        ),
        (
            hermite("bad", json!(1.5), json!(0)),
            "key 'n': found 1.5, expected an order",
        ),
        (
            hermite("bad", json!(1), json!("NaN")),
            "key 't': found \"NaN\", expected a finite number, plain or as a decimal string",
        ),
        (
            hermite("bad", json!(1), json!("1e400")),
            "key 't': found \"1e400\", expected a finite number",
        ),
        (
            hermite("bad", json!(1), json!({"re": 0, "im": 0})),
            "key 't': found {\"im\":0,\"re\":0}, expected a finite number",
        ),
        (
            phi(json!([["1", "0"], ["0", "x"]]), json!(["0", "0"])),
            "key 'W[1][1]': found \"x\", expected a finite number",
        ),
        (
            phi(json!([["1", "0"]]), json!(["0", "0"])),
            "key 'W': found 1 values, expected 2",
        ),
        (
            phi(json!([["1", "1"], ["1", "1"]]), json!(["0", "0"])),
            "key 'W': shape: condition number inf of Θ, expected at most 1e24",
        ),
        (
            phi(one, json!(["0", "0", "0"])),
            "key 'x': found 3 values, expected 2",
        ),
        (
            json!({"id": "bad", "op": "sym_power", "inputs": {"A": [["1e200", 0], [0, 0]], "N": 2}}),
            "result 'matrix[0][0]' is inf, expected a finite number",
        ),
        (
            psi(json!([[1, 2], [2, 1]]), json!(0)),
            "key 'Theta': shape: the shape matrix Θ has eigenvalues 3 and -1, expected both positive",
        ),
        (
            psi(json!([[1, 0], [0, 1]]), json!("maybe")),
            "key 'dual': found \"maybe\", expected 0 or 1",
        ),
        (
            shape(json!({"kind": "square", "hx": 1})),
            "key 'I.kind': found 'square', expected 'gaussian', 'rect', 'disk' or 'gaussian_mixture'",
        ),
        (
            shape(json!({"kind": "rect", "hx": 1})),
            "key 'I.hy' is missing, expected a length in metres (shape takes I, P)",
        ),
        (
            shape(json!({"kind": "disk", "radius": "-1"})),
            "key 'I': envelope: the radius is -1, expected a length",
        ),
        (
            shape(
                json!({"kind": "gaussian_mixture", "weights": [1, 2], "S_list": [[[1, 0], [0, 1]]]}),
            ),
            "key 'I.S_list': found 1 matrices for 2 weights, expected one for each",
        ),
        (
            json!({"id": "bad", "op": "projection", "inputs": {"I": {"kind": "disk", "radius": 1}, "P": [[1, 0], [0, 0]], "N": 2}}),
            "key 'P': shape: condition number inf",
        ),
        (
            csd(5e-7, 2.0, json!([200, 100, 1])),
            "key 'modes[0]': order 300, expected at most 256",
        ),
        (csd(-5e-7, 2.0, json!([0, 0, 1])), "key 'lambda': "),
        (
            csd(5e-7, 1e-9, json!([0, 0, 1])),
            "key 'r': light: distance 0.000000001 m at wavelength 0.0000005 m has k r = 0.0125",
        ),
        (
            json!({"id": "bad", "op": "observables", "inputs": {"stokes": [1, 0, 0]}}),
            "key 'stokes': found 3 values, expected 4",
        ),
        (
            json!({"id": "bad", "op": "cov_to_white", "inputs": {"W": [[1, 0], [0, 1]], "coeffs": [[1], [1, 2, 3]]}}),
            "key 'coeffs[1]': found 3 coefficients of order 1, expected 2",
        ),
    ] {
        let text = file_of(&json!([case, hermite("good", json!(0), json!(0))]));
        let (status, answer, said) = parts(&eval_text(&text, &[]));
        assert_eq!(status, Some(1), "{said}");
        assert_eq!(by_id(&answer).keys().collect::<Vec<_>>(), ["good"]);
        let op = case["op"].as_str().unwrap();
        let place = format!("brewster: standard input: case 'bad' ({op}): {expected}");
        assert!(said.starts_with(&place), "found {said}expected {place}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn a_file_that_is_no_case_file_is_refused_with_its_place() {
    for (text, expected) in [
        ("", "standard input:1:0: "),
        (
            "{\"schema\": \"hg-oracle-1\",\n  oops}",
            "standard input:2:3: ",
        ),
        (
            "{\"schema\": \"hg-oracle-2\", \"cases\": []}",
            "standard input:1:24: 'schema' is \"hg-oracle-2\", expected \"hg-oracle-1\"",
        ),
        (
            "{\"cases\": []}",
            "standard input:1:13: missing field `schema`",
        ),
        (
            "{\"schema\": \"hg-oracle-1\", \"cases\": {}}",
            "standard input:1:35: invalid type: map, expected a sequence",
        ),
        (
            "{\"schema\": \"hg-oracle-1\", \"cases\": [{\"op\": \"phi\"}]}",
            "standard input:1:49: missing field `id`",
        ),
        (
            "{\"schema\": \"hg-oracle-1\", \"cases\": [{\"id\": \"a\", \"op\": \"x\"}, {\"id\": \"a\", \"op\": \"x\"}]}",
            "standard input: cases 1 and 2 have the same id 'a'",
        ),
    ] {
        let (status, answer, said) = parts(&eval_text(text, &[]));
        assert_eq!((status, answer), (Some(2), Value::Null), "{text}");
        assert!(
            said.starts_with(&format!("brewster: {expected}")),
            "{text}: {said}"
        );
    }
    let output = brewster().args(["eval", "no/such.json"]).output().unwrap();
    let (status, _, said) = parts(&output);
    assert_eq!(status, Some(2));
    assert!(said.starts_with("brewster: no/such.json: cannot be read"));
}

#[test]
fn results_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.json");
    let text = file_of(&json!([hermite("a", json!(0), json!(0))]));
    let output = eval_text(&text, &["-o", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty());
    let written: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    // h_0(0) = π^(-1/4)
    assert_eq!(
        written,
        json!({"cases": [{"id": "a", "result": {"value": "7.5112554446494251e-01"}}]})
    );
    let elsewhere = folder.path().join("no/such/results.json");
    let (status, _, said) = parts(&eval_text(&text, &["-o", elsewhere.to_str().unwrap()]));
    assert_eq!(status, Some(1));
    assert!(said.contains("cannot be written"), "{said}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// One small case of every operation, taken from the golden files.
fn one_case_each() -> String {
    let mut cases = BTreeMap::new();
    for file in FILES {
        let text = fs::read_to_string(golden(file)).unwrap();
        let golden: Value = serde_json::from_str(&text).unwrap();
        for case in golden["cases"].as_array().unwrap() {
            let case = json!({"id": case["id"], "op": case["op"], "inputs": case["inputs"]});
            let op = case["op"].as_str().unwrap().to_owned();
            cases.entry(op).or_insert(case);
        }
    }
    assert_eq!(
        cases.keys().cloned().collect::<Vec<_>>(),
        {
            let mut names: Vec<_> = eval::OPS.iter().map(|op| op.name.to_owned()).collect();
            names.sort();
            names
        },
        "every operation has a golden file"
    );
    file_of(&cases.into_values().collect())
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
