//! The command line: one file a subcommand, each with its `Args` and `run`.

use std::io::Write as _;
use std::process::ExitCode;

use crate::lanes::Allowed;

pub mod compare;
pub mod eval;
pub mod inspect;
pub mod maps;
mod progress;
pub mod render;
pub mod values;
mod wavelengths;

/// Why a command could not do its work, in the words that the user reads.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line or the scene is wrong: exit status 2.
    #[error("{0}")]
    Usage(String),
    /// The work itself failed (a file could not be written, …): exit status 1.
    #[error("{0}")]
    Work(String),
}

impl Failure {
    /// 2 for a wrong command line or scene, 1 for work that failed.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Work(_) => ExitCode::from(1),
        }
    }
}

/// Refuses an environment that asks for what there is not.
///
/// # Errors
///
/// A wrong value of `BREWSTER_SIMD`.
pub fn check_environment() -> Result<(), Failure> {
    Allowed::by_environment().map(drop).map_err(Failure::Usage)
}

/// Says something on standard output; who has closed it, as `head` does, does not want to know.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// What a subcommand returns.
pub type Outcome = Result<ExitCode, Failure>;
