//! How a rendering tells of itself while it runs, and how it is interrupted.

use std::io::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Failure;
use crate::engine::Progress;

/// A bar on standard error, or none; without an end where nobody knows how many `samples` there will be.
pub(super) fn progress_bar(quiet: bool, samples: Option<u64>) -> ProgressBar {
    let target = if quiet {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let template = match samples {
        Some(_) => "{wide_bar} {pos}/{len} spp  {msg}  {eta} left",
        None => "{spinner} {pos} spp  {msg}  {elapsed}",
    };
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::with_draw_target(samples, target).with_style(style)
}

/// Brings the bar up to date after a pass.
pub(super) fn show(bar: &ProgressBar, progress: Progress<'_>) {
    if bar.is_hidden() {
        return;
    }
    let rate = progress.counters.paths as f64 / progress.elapsed.as_secs_f64().max(1e-9) / 1e6;
    bar.set_message(format!(
        "{rate:.2} Mpaths/s  error {:.2} %",
        100.0 * progress.error()
    ));
    bar.set_position(progress.samples);
}

/// A flag that an interrupt sets: the pass in flight is finished and what there is is written.
pub(super) fn stop_on_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            // asked twice: the user does not want to wait
            std::process::exit(1);
        }
        // best effort: nobody may be listening
        let _ = writeln!(
            std::io::stderr(),
            "\ninterrupted: finishing this pass; once more to quit at once"
        );
    })
    .map_err(|e| Failure::Work(format!("interrupts cannot be caught: {e}")))?;
    Ok(stop)
}
