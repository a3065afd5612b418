//! Time against error of Theorem S4.1, and what every part that is absent saves.
//!
//! ```text
//! cargo run --release -p mueller16 --example interaction_run_time -- OUT.csv
//! ```
//!
//! Times are medians over rounds in which the contestants of a race take turns, and the least of them; ratios are medians
//! of the rounds' ratios to the last contestant of the race. Errors are the largest over a fan of directions, relative
//! to the largest value of the lobe: `truncation` is what the sum leaves out, against a longer one in f64; `rounding` what
//! f32 makes of the same sum. `validation/run_time_against_error.py` draws the picture.

#[path = "../../../stokes/examples/run_time_against_error/clock.rs"]
mod clock;
mod matter;
mod races;

use std::error::Error;
use std::fmt::Write;

use clock::{Contestant, race};

const ROUNDS: usize = 31;
/// Seconds of one contestant in one round.
const SLICE: f64 = 2e-4;

/// What a row says beside times.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) order: usize,
    pub(crate) terms: usize,
    pub(crate) channels: usize,
    /// `f64` or `f32`.
    pub(crate) number: &'static str,
    pub(crate) truncation: Option<f64>,
    pub(crate) rounding: Option<f64>,
}

/// The table as it grows.
pub(crate) struct Table(String);

impl Table {
    /// Times the contestants against each other, and writes a row for each.
    pub(crate) fn race(&mut self, part: &str, entrants: Vec<(Row, Box<dyn FnMut() + '_>)>) {
        let (rows, works): (Vec<_>, Vec<_>) = entrants.into_iter().unzip();
        let contestants = rows
            .iter()
            .zip(works)
            .map(|(row, work)| Contestant::new(row.name, 1, work))
            .collect();
        let rounds = race(contestants, ROUNDS, SLICE);
        let Some(last) = rows.last().map(|row| row.name) else {
            return;
        };
        for row in rows {
            let [ns, least] = rounds.ns(row.name);
            let [ratio, _] = rounds.ratio(row.name, last);
            let Row {
                name,
                order,
                terms,
                channels,
                number,
                truncation,
                rounding,
            } = row;
            let [truncation, rounding] = [truncation, rounding]
                .map(|error| error.map_or(String::new(), |error| format!("{error:.3e}")));
            println!(
                "{part:9} {name:44} {order:3} {terms:5} {channels:3} {number} {ns:10.1} {least:10.1} {ratio:7.3} {truncation:9} {rounding}"
            );
            let line = format!(
                "{part},{name},{order},{terms},{channels},{number},{ns:.2},{least:.2},{ratio:.4},{truncation},{rounding}"
            );
            self.0.push_str(&line);
            self.0.push('\n');
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = std::env::args_os().nth(1) else {
        eprintln!("interaction_run_time: no file named, expected OUT.csv");
        std::process::exit(2);
    };
    let mut table = Table(String::new());
    writeln!(
        table.0,
        "# made by: cargo run --release -p mueller16 --example interaction_run_time -- OUT.csv; times in ns a transfer\n\
         part,name,order,terms,channels,number,ns,least_ns,ratio,truncation,rounding"
    )?;
    println!(
        "part      name                                           N terms  ch num         ns      least   ratio truncation rounding"
    );
    races::yardsticks(&mut table)?;
    races::channels(&mut table)?;
    races::skips(&mut table)?;
    races::orders(&mut table)?;
    races::roughness(&mut table)?;
    races::heights(&mut table)?;
    races::grating(&mut table)?;
    races::layers(&mut table)?;
    std::fs::write(path, table.0)?;
    Ok(())
}
