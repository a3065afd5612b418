//! The `brewster` command: parse, run, print the error.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use render::cli;

/// A polarization-aware renderer: Mitsuba 3 scenes in, Stokes images and polarization maps out.
#[derive(Parser)]
#[command(name = "brewster", version, arg_required_else_help = true)]
struct Command {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Render a scene to a Stokes image
    Render(Box<cli::render::Args>),
    /// Make pictures from a Stokes image (ours or Mitsuba's)
    Maps(cli::maps::Args),
    /// Say what a scene holds, needs and skips
    Inspect(cli::inspect::Args),
    /// Compare two Stokes images, component by component
    Compare(cli::compare::Args),
    /// Compute formulas of the theory on numbers from a file
    Eval(cli::eval::Args),
}

fn main() -> ExitCode {
    let task = Command::parse().task;
    let outcome = cli::check_environment().and_then(|()| match task {
        Task::Render(args) => cli::render::run(&args),
        Task::Maps(args) => cli::maps::run(&args),
        Task::Inspect(args) => cli::inspect::run(&args),
        Task::Compare(args) => cli::compare::run(&args),
        Task::Eval(args) => cli::eval::run(&args),
    });
    outcome.unwrap_or_else(|failure| {
        eprintln!("brewster: {failure}");
        failure.exit_code()
    })
}
