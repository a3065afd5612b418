//! Claim: `brewster eval` says what is wrong with a file or a case, and computes the rest.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::io::Write as _;
use std::process::{Output, Stdio};

use brewster_tests::{brewster, repository, results_by_id};
use serde_json::{Value, json};

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
    let results = results_by_id(&answer);
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
    assert_eq!(results_by_id(&answer).keys().collect::<Vec<_>>(), ["b"]);
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
    let lobe = |r: Value| json!({"id": "bad", "op": "lobe", "inputs": {"R": r, "phi": [0, 0]}});
    let scatter = |family: &str, r: Value, map: Value| json!({"id": "bad", "op": "scatter", "inputs": {"R": r, "family": family, "n": 0, "m": 1, "shape": [[1, 0], [0, 1]], "B": map, "phi": [0, 0]}});
    for (case, expected) in [
        (
            lobe(json!({"kind": "fractal"})),
            "key 'R.kind': found 'fractal', expected 'constant', 'gaussian', 'gaussian_sum', 'grating', 'orders', 'rough', 'exponential', 'k_correlation' or 'relief'",
        ),
        (
            lobe(json!({"kind": "gaussian", "S": [[1, 0], [0, -1]]})),
            "key 'R.S': shape: ",
        ),
        (
            lobe(json!({"kind": "gaussian", "S": [[1, 0], [0, 1]], "amp": [1, 2, 3]})),
            "key 'R.amp': found 3 values, expected 2",
        ),
        (
            lobe(json!({"kind": "gaussian_sum", "weights": [1], "S_list": []})),
            "key 'R.S_list': found 0 matrices for 1 weights, expected one for each",
        ),
        (
            lobe(json!({"kind": "rough", "g": -1, "l": 1})),
            "key 'R.g': found -1, expected a number between 0 and 1e6",
        ),
        (
            lobe(json!({"kind": "rough", "g": 1, "l": 0})),
            "key 'R.l': shape: ",
        ),
        (
            scatter("dual", json!({"kind": "constant"}), one.clone()),
            "key 'family': found 'dual', expected 'white' or 'cov'",
        ),
        (
            scatter("cov", json!({"kind": "constant"}), json!([[1, 0], [0, 0]])),
            "key 'R': interaction: an autocorrelation that does not decay meets light without angular width (det V = 0)",
        ),
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
        assert_eq!(results_by_id(&answer).keys().collect::<Vec<_>>(), ["good"]);
        let op = case["op"].as_str().unwrap();
        let place = format!("brewster: standard input: case 'bad' ({op}): {expected}");
        assert!(said.starts_with(&place), "found {said}expected {place}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn what_is_no_surface_grating_or_screen_is_named() {
    let surface = |key: &str, value: Value| {
        let mut inputs = json!({"boundary": {"kind": "dielectric", "n_front": 1, "n_back": 1.5}, "relief": {"kind": "none"},
            "to_source": [0, 0, 1], "to_observer": [0, 0, 1], "lambda": 5e-7});
        inputs[key] = value;
        json!({"id": "case", "op": "surface", "inputs": inputs})
    };
    let grating = |key: &str, value: Value| {
        let mut inputs = json!({"profile": {"kind": "sinusoidal", "depth": 1e-7}, "pitch": 2e-6, "to_source": [0, 0, 1],
            "lambda": 5e-7});
        inputs[key] = value;
        json!({"id": "case", "op": "grating", "inputs": inputs})
    };
    let slits = |key: &str, value: Value| {
        let mut inputs = json!({"openings": [{"centre": [0, 0], "width": 1e-5, "height": 1e-5}], "screen_area": 1e-6,
            "to_source": [0, 0, -1], "to_observers": [[0, 0, 1]], "lambda": 5e-7});
        inputs[key] = value;
        json!({"id": "case", "op": "slits", "inputs": inputs})
    };
    for (case, expected) in [
        (
            surface("boundary", json!({"kind": "wood"})),
            "key 'boundary.kind': found 'wood', expected 'dielectric', 'conductor', 'film', 'mirror' or 'window'",
        ),
        (
            surface(
                "relief",
                json!({"kind": "gaussian", "sigma": -1e-8, "l": 1e-6}),
            ),
            "key 'relief': autocorrelation: the standard deviation of the heights is -1e-8, expected a number between 0 and 1e24 m",
        ),
        (
            surface("relief", json!({"kind": "gaussian", "sigma": 1e-8})),
            "key 'relief.l' is missing, expected a length in metres, or one along x and one along y (surface takes ",
        ),
        (
            surface("n_incident", json!(1.3)),
            "key 'inputs': surface: the geometry has the index 1.3 on the front side of the surface and the boundary 1,",
        ),
        (
            surface("tolerance", json!(0.9)),
            "key 'tolerance': tolerance: found 0.9, expected a relative error between 1e-15 and 0.5",
        ),
        (
            surface("light", json!({"kind": "disk", "angles": 0.1})),
            "key 'light.kind': found 'disk', expected 'plane_wave' or 'gaussian'",
        ),
        (surface("x_in", json!([0, 0, 1])), "key 'x_in': "),
        (
            grating("profile", json!({"kind": "lamellar", "depth": 1e-7})),
            "key 'profile.ridge_fraction' is missing, expected a finite number (grating takes ",
        ),
        (
            grating(
                "profile",
                json!([{"kind": "sinusoidal", "depth": 1e-7}, {"kind": "sinusoidal", "depth": 1e-7}]),
            ),
            "key 'pitch': found 2e-6, expected a list",
        ),
        (
            grating("pitch", json!(-1)),
            "key 'inputs': grating: the pitch is -1, expected a number from 0.000000000001 to 1000",
        ),
        (
            grating("side", json!("back")),
            "key 'side': found 'back', expected 'reflection' or 'transmission'",
        ),
        (
            slits("screen_area", json!(1e-11)),
            "key 'inputs': openings: the screen has an area of ",
        ),
        (
            slits("pair", json!([0, 1])),
            "key 'pair': found opening 1 of 1, expected one from 0",
        ),
        (
            slits("to_observers", json!([[0, 0, 1], [0, 0, 2]])),
            "key 'to_observers[1]': geometry: the vector to the observer has length 2, expected 1",
        ),
        (
            slits("to_observers", json!([])),
            "key 'inputs': found no direction under 'to_observers', expected at least one",
        ),
        (
            slits("light", json!({"kind": "disk"})),
            "key 'light.angles' is missing, expected an angle in radians or a matrix of angles (slits takes ",
        ),
    ] {
        let (status, _, said) = parts(&eval_text(&file_of(&json!([case])), &[]));
        let op = case["op"].as_str().unwrap();
        let expected = format!("brewster: standard input: case 'case' ({op}): {expected}");
        assert!(said.starts_with(&expected), "{said}\n{expected}");
        assert_eq!((status, said.lines().count()), (Some(1), 1), "{said}");
    }
}

/// The first golden case of the theorem, with changes.
fn interaction(change: impl Fn(&mut Value)) -> Value {
    let path = repository().join("tests/golden/interaction.json");
    let golden: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let mut inputs = golden["cases"][0]["inputs"].clone();
    change(&mut inputs);
    json!({"id": "case", "op": "interaction", "inputs": inputs})
}

#[test]
fn what_is_no_encounter_of_light_with_matter_is_named() {
    let with = |place: &str, value: Value| {
        interaction(|inputs| *inputs.pointer_mut(place).unwrap() = value.clone())
    };
    let nothing = vec![vec![Value::Null; 4]; 4];
    for (case, expected) in [
        (
            with("/incident/modes/2/1", json!([1, 0, 0.5])),
            "key 'incident.modes[2][1]': series: coefficient (1, 0) is 0.5+0i, expected a purely imaginary number",
        ),
        (
            with("/incident/modes/0/3", json!([2, 0, {"re": 0.5, "im": 0.1}])),
            "key 'incident.modes[0][3]': series: coefficient (2, 0) is 0.5+0.1i, expected a purely real number",
        ),
        (
            with("/incident/modes", json!([[], [], []])),
            "key 'incident.modes': found 3 values, expected 4",
        ),
        (
            with("/incident/W", json!([[1, 0], [1, 0]])),
            "key 'incident.W': shape: condition number inf of Θ",
        ),
        (
            with("/R/1/0", json!({"kind": "smooth"})),
            "key 'R[1][0].kind': found 'smooth', expected 'constant', 'gaussian'",
        ),
        (
            with("/R", json!(nothing)),
            "key 'R': found no channel, expected at least one that is not null",
        ),
        (
            with("/to_source", json!([0, 0, 2])),
            "key 'inputs': geometry: the vector to the source has length 2, expected 1",
        ),
        (with("/e_in/0", json!([0, 0, 1])), "key 'e_in': found axes "),
        (
            with("/e_out/1", json!([0, 0, 0])),
            "key 'e_out': found axes 1e0 away from perpendicular unit axes across the ray, expected at most 1e-6",
        ),
        (
            with("/s", json!(1e-9)),
            "key 's': light: distance 0.000000001 m",
        ),
        (
            with("/r", json!(1e-9)),
            "key 'r': light: distance 0.000000001 m",
        ),
        (
            with("/xi", json!([])),
            "key 'xi': found no separation, expected at least one",
        ),
    ] {
        let (status, _, said) = parts(&eval_text(&file_of(&json!([case])), &[]));
        let expected = format!("brewster: standard input: case 'case' (interaction): {expected}");
        assert!(said.starts_with(&expected), "{said}\n{expected}");
        assert_eq!((status, said.lines().count()), (Some(1), 1), "{said}");
    }
}

#[test]
fn mirrored_transverse_axes_only_rename_coordinates() {
    let plain = interaction(|_| ());
    let mirrored = interaction(|inputs| {
        for axes in ["e_in", "e_out"] {
            for component in inputs[axes][1].as_array_mut().unwrap() {
                let x: f64 = component.as_str().unwrap().parse().unwrap();
                *component = json!(-x);
            }
        }
        for row in inputs["incident"]["W"].as_array_mut().unwrap() {
            let x: f64 = row[1].as_str().unwrap().parse().unwrap();
            row[1] = json!(-x);
        }
        for xi in inputs["xi"].as_array_mut().unwrap() {
            let x: f64 = xi[1].as_str().unwrap().parse().unwrap();
            xi[1] = json!(-x);
        }
    });
    let result = |case: &Value| {
        let (status, answer, said) = parts(&eval_text(&file_of(&json!([case])), &[]));
        assert_eq!(status, Some(0), "{said}");
        results_by_id(&answer)["case"].clone()
    };
    let (plain, mirrored) = (result(&plain), result(&mirrored));
    for key in [
        "phi_t",
        "A",
        "S",
        "c_white",
        "C_samples",
        "intensity",
        "DoP",
    ] {
        assert_eq!(plain[key], mirrored[key], "{key}");
    }
    for (key, place) in [
        ("B", [1, 0]),
        ("P_out", [0, 1]),
        ("W_out", [0, 1]),
        ("Theta_out", [0, 1]),
    ] {
        let number = |result: &Value| -> f64 {
            let [row, column] = place;
            result[key][row][column].as_str().unwrap().parse().unwrap()
        };
        assert_eq!(number(&plain), -number(&mirrored), "{key}");
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
