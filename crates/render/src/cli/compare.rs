//! `brewster compare`.

use std::process::ExitCode;

use super::Outcome;

/// Command line of `brewster compare`.
#[derive(clap::Args, Debug)]
pub struct Args {}

/// Runs the command.
pub fn run(_args: &Args) -> Outcome {
    Ok(ExitCode::SUCCESS)
}
