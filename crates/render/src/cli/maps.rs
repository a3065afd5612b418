//! `brewster maps`.

use std::process::ExitCode;

use super::Outcome;

/// Command line of `brewster maps`.
#[derive(clap::Args, Debug)]
pub struct Args {}

/// Runs the command.
pub fn run(_args: &Args) -> Outcome {
    Ok(ExitCode::SUCCESS)
}

/// Placeholder.
pub fn write_beside(_: &crate::image::StokesImage, _: &str, _: &std::path::Path, _: bool) -> Result<(), super::Failure> {
    Ok(())
}
