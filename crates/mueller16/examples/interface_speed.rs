//! Prints the time of one interface in nanoseconds: complex and real indices, reflection and transmission.
//!
//! `cargo run --release -p mueller16 --example interface_speed`

use std::hint::black_box;
use std::time::Instant;

use mueller16::{ConductorInterface, DielectricInterface};

const CALLS: u32 = 4_000_000;

/// Nanoseconds per call of `work` on cosines spread over the quadrant; the best of seven rounds.
fn time(work: impl Fn(f64) -> f64) -> f64 {
    let round = || {
        let start = Instant::now();
        let sum: f64 = (0..CALLS)
            .map(|i| work(f64::from(i) / f64::from(CALLS)))
            .sum();
        black_box(sum);
        start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    (0..7).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), mueller16::IndexError> {
    let gold = black_box(ConductorInterface::new(1.0, 0.183, 3.43)?);
    let enter = black_box(DielectricInterface::new(1.0, 1.5)?);
    let leave = black_box(DielectricInterface::new(1.5, 1.0)?);
    let sum =
        |m: stokes::DiattenuatingRetarder| m.mean + 2.0 * m.difference + 3.0 * m.cosine + m.sine;
    let gold_ns = time(|c| sum(gold.reflection(c)));
    let enter_ns = time(|c| sum(enter.reflection(c)));
    let leave_ns = time(|c| sum(leave.reflection(c)));
    let through_ns = time(|c| {
        enter
            .transmission(c)
            .map_or(0.0, |t| sum(t.element) + t.cos_t)
    });
    println!("reflection, complex index        {gold_ns:6.1} ns");
    println!("reflection, real, into glass     {enter_ns:6.1} ns");
    println!("reflection, real, out of glass   {leave_ns:6.1} ns (three quarters of it total)");
    println!("transmission, real, into glass   {through_ns:6.1} ns");
    Ok(())
}
