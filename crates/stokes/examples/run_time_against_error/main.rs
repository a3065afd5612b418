//! Time against error of the Hermite-Gauss evaluation, and its time beside plain loops.
//!
//! ```text
//! cargo run --release -p stokes --example run_time_against_error -- OUT.csv
//! ```
//!
//! Rows with a yardstick: all modes at a point, or their sum, against loops that anybody would write first, in the
//! same build. The other rows: what it costs to evaluate a series of a source at a point (f64; f32; f32 in batches of
//! 16 points) and to find its coefficients, with the errors that the truncated series leaves. Times are medians over
//! rounds in which the contestants take turns, and the least of them; ratios are medians of the rounds' ratios.
//! `validation/run_time_against_error.py` draws the picture.

mod clock;
mod plain;
mod sources;
mod yardsticks;

use std::error::Error;
use std::fmt::Write;

const ROUNDS: usize = 31;
/// Seconds of one contestant in one round.
const SLICE: f64 = 2e-4;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = std::env::args_os().nth(1) else {
        eprintln!("run_time_against_error: no file named, expected OUT.csv");
        std::process::exit(2);
    };
    let mut csv = String::from(
        "# made by: cargo run --release -p stokes --example run_time_against_error -- OUT.csv; times in ns a point, \
         of `project` in ns a series\n\
         task,source,width,order,ns,least_ns,yardstick,yardstick_ns,ratio,least_ratio,l2_error,error_at_zero,f32_error\n",
    );
    println!(
        "task                      order        ns   yardstick                      ns  ratio  least"
    );
    yardstick_rows::<1>(&mut csv)?;
    yardstick_rows::<3>(&mut csv)?;
    yardstick_rows::<5>(&mut csv)?;
    yardstick_rows::<9>(&mut csv)?;
    yardstick_rows::<17>(&mut csv)?;
    yardstick_rows::<33>(&mut csv)?;
    yardstick_rows::<65>(&mut csv)?;
    println!(
        "\nsource     width             order  L2 error   at zero   f32  | ns: {}",
        sources::TASKS.join(" | ")
    );
    for source in sources::all()? {
        for order in sources::ORDERS {
            source_rows(&source, order, &mut csv)?;
        }
    }
    std::fs::write(path, csv)?;
    Ok(())
}

fn yardstick_rows<const SIZE: usize>(csv: &mut String) -> Result<(), Box<dyn Error>> {
    let rounds = yardsticks::measure::<SIZE>(ROUNDS, SLICE);
    let order = SIZE - 1;
    for [ours, plain] in yardsticks::PAIRS {
        let [ns, least] = rounds.ns(ours);
        let [plain_ns, _] = rounds.ns(plain);
        let [ratio, least_ratio] = rounds.ratio(ours, plain);
        println!(
            "{ours:25} {order:5} {ns:9.1}   {plain:25} {plain_ns:7.1} {ratio:6.2} {least_ratio:6.2}"
        );
        // commas part the columns
        let plain = plain.replace(',', "");
        writeln!(
            csv,
            "{ours},,,{order},{ns:.2},{least:.2},{plain},{plain_ns:.2},{ratio:.3},{least_ratio:.3},,,"
        )?;
    }
    Ok(())
}

fn source_rows(
    source: &sources::Source,
    order: usize,
    csv: &mut String,
) -> Result<(), Box<dyn Error>> {
    let (_, errors) = source.series(order)?;
    let rounds = source.measure(order, ROUNDS, SLICE)?;
    let (name, width) = (source.name, source.width);
    let errors_text = format!(
        "{:.9e},{:.9e},{:.2e}",
        errors.norm, errors.at_zero, errors.f32
    );
    let mut times = String::new();
    for task in sources::TASKS {
        let [ns, least] = rounds.ns(task);
        write!(times, " {ns:10.1}")?;
        let task = task.replace(',', "");
        writeln!(
            csv,
            "{task},{name},{width},{order},{ns:.2},{least:.2},,,,,{errors_text}"
        )?;
    }
    println!(
        "{name:10} {width:17} {order:5} {:9.2e} {:9.1e} {:8.1e} {times}",
        errors.norm, errors.at_zero, errors.f32
    );
    Ok(())
}
