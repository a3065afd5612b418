//! `brewster eval`: formulas of the theory on numbers from a file, to check them against other implementations.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::json;

use super::{Failure, Outcome};
use crate::eval::schema::{CaseError, CaseFile};
use crate::eval::{self, Precision};
use crate::output;

/// Command line of `brewster eval`.
///
/// Exit status: 0 all cases computed; 1 some were not, or the results could not be written; 2 unusable file.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Cases to compute (JSON), or - for standard input
    cases: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "RESULTS")]
    output: Option<PathBuf>,
    /// Evaluate the Hermite-Gauss functions in single precision
    #[arg(long)]
    f32: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (name, bytes) = read(&args.cases)?;
    let file = CaseFile::parse(&name, &bytes).map_err(Failure::Usage)?;
    let precision = if args.f32 {
        Precision::Single
    } else {
        Precision::Double
    };
    let mut done = Vec::new();
    let mut unknown = BTreeMap::<&str, usize>::new();
    for case in &file.cases {
        let Some(op) = eval::find(&case.op) else {
            *unknown.entry(&case.op).or_default() += 1;
            continue;
        };
        match op.evaluate(case, precision) {
            Ok(result) => done.push(json!({"id": case.id, "result": result})),
            Err(error) => {
                let takes = match error {
                    CaseError::Missing { .. } => format!(" ({} takes {})", op.name, op.inputs),
                    _ => String::new(),
                };
                eprintln!(
                    "brewster: {name}: case '{}' ({}): {error}{takes}",
                    case.id, op.name
                );
            }
        }
    }
    for (op, count) in unknown {
        let cases = if count == 1 { "case" } else { "cases" };
        eprintln!("brewster: {name}: unknown op '{op}': {count} {cases} left out");
    }
    let complete = done.len() == file.cases.len();
    write(args.output.as_deref(), &json!({"cases": done}))?;
    Ok(if complete {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The bytes of the file, and what messages call it.
fn read(path: &Path) -> Result<(String, Vec<u8>), Failure> {
    let mut bytes = Vec::new();
    let (name, outcome) = if path == Path::new("-") {
        let outcome = std::io::stdin().lock().read_to_end(&mut bytes).map(drop);
        ("standard input".to_owned(), outcome)
    } else {
        let outcome = std::fs::read(path).map(|read| bytes = read);
        (path.display().to_string(), outcome)
    };
    outcome.map_err(|e| Failure::Usage(format!("{name}: cannot be read: {e}")))?;
    Ok((name, bytes))
}

fn write(path: Option<&Path>, results: &serde_json::Value) -> Result<(), Failure> {
    let text = format!("{results:#}\n");
    match path {
        Some(path) => output::write_atomically(path, text.as_bytes())
            .map_err(|e| Failure::Work(e.to_string())),
        None => std::io::stdout()
            .lock()
            .write_all(text.as_bytes())
            .map_err(|e| Failure::Work(format!("standard output: cannot be written: {e}"))),
    }
}
