//! This crate's evaluation beside the plain loops, in one run.

use std::hint::black_box;

use stokes::{all_modes, all_modes_at, contract, contract_at, mode_count};

use crate::clock::{Contestant, Rounds, race};
use crate::plain;

/// Points of one turn.
const POINTS: usize = 64;
/// Points of a batch, such as the wavelengths of a path. Both sides write their modes to places for so many.
pub(crate) const BATCH: usize = 16;

/// Ours and the yardstick that it is measured by.
pub(crate) const PAIRS: [[&str; 2]; 8] = [
    ["all_modes f32", "plain all modes f32"],
    ["all_modes f64", "plain all modes f64"],
    ["contract f32", "plain sum f32"],
    ["contract f64", "plain sum f64"],
    ["all_modes_at f32", "plain all modes [f32; 8]"],
    ["contract_at f32", "plain sum [f32; 8]"],
    ["all_modes_at f64", "plain all modes [f32; 8]"],
    ["contract_at f64", "plain sum [f32; 8]"],
];

/// A lattice over the square |y| < 3 without symmetry.
pub(crate) fn lattice() -> [[f64; 2]; POINTS] {
    std::array::from_fn(|i| {
        let fraction = |step: f64| 6.0 * (step * (i as f64 + 0.5)).fract() - 3.0;
        [fraction(0.618_033_988_75), fraction(0.754_877_666_25)]
    })
}

/// Races everything at the order SIZE − 1.
pub(crate) fn measure<const SIZE: usize>(rounds: usize, slice: f64) -> Rounds {
    let order = SIZE - 1;
    let count = mode_count(order);
    let points = lattice();
    let points32 = points.map(|y| y.map(|t| t as f32));
    let lanes: Vec<[[f32; 8]; 2]> = points32
        .as_chunks::<8>()
        .0
        .iter()
        .map(|block| [0, 1].map(|axis| block.map(|y| y[axis])))
        .collect();
    let s: Vec<f64> = (0..count).map(|i| ((i * i) as f64 * 0.7).sin()).collect();
    let s32: Vec<f32> = s.iter().map(|s| *s as f32).collect();
    let c: Vec<[f64; 2]> = s.iter().map(|s| [*s, 1.0 - *s]).collect();
    let c32: Vec<[f32; 2]> = c.iter().map(|c| c.map(|part| part as f32)).collect();
    let factors: [[f64; 2]; SIZE] = plain::factors(|x| x);
    let factors32: [[f32; 2]; SIZE] = plain::factors(|x| x as f32);
    // what the optimizer cannot know
    let order = black_box(order);
    let (mut a, mut b) = (vec![0.0f32; count], vec![0.0f32; count]);
    let (mut c64, mut d64) = (vec![0.0; count], vec![0.0; count]);
    let (mut e, mut f) = (vec![0.0f32; count * BATCH], vec![0.0; count * BATCH]);
    let mut g = vec![[0.0f32; 8]; count * BATCH / 8];
    let (mut h, mut k) = ([0.0f32; POINTS], [0.0; POINTS]);
    race(
        vec![
            Contestant::new("plain all modes f32", POINTS, || {
                for y in &points32 {
                    plain::all_modes_f32(*black_box(y), &factors32, black_box(&mut a));
                }
            }),
            Contestant::new("all_modes f32", POINTS, || {
                for y in &points32 {
                    all_modes(order, *black_box(y), black_box(&mut b));
                }
            }),
            Contestant::new("plain all modes f64", POINTS, || {
                for y in &points {
                    plain::all_modes_f64(*black_box(y), &factors, black_box(&mut c64));
                }
            }),
            Contestant::new("all_modes f64", POINTS, || {
                for y in &points {
                    all_modes(order, *black_box(y), black_box(&mut d64));
                }
            }),
            Contestant::new("plain sum f32", POINTS, || {
                for y in &points32 {
                    black_box(plain::sum_f32(*black_box(y), &factors32, &c32));
                }
            }),
            Contestant::new("contract f32", POINTS, || {
                for y in &points32 {
                    black_box(contract(order, &s32, *black_box(y)));
                }
            }),
            Contestant::new("plain sum f64", POINTS, || {
                for y in &points {
                    black_box(plain::sum_f64(*black_box(y), &factors, &c));
                }
            }),
            Contestant::new("contract f64", POINTS, || {
                for y in &points {
                    black_box(contract(order, &s, *black_box(y)));
                }
            }),
            Contestant::new("plain all modes [f32; 8]", POINTS, || {
                for batch in lanes.chunks(BATCH / 8) {
                    for (y, modes) in batch.iter().zip(g.chunks_exact_mut(count)) {
                        plain::all_modes_of_eight(*black_box(y), &factors32, black_box(modes));
                    }
                }
            }),
            Contestant::new("all_modes_at f32", POINTS, || {
                for batch in points32.chunks(BATCH) {
                    all_modes_at(order, black_box(batch), black_box(&mut e));
                }
            }),
            Contestant::new("all_modes_at f64", POINTS, || {
                for batch in points.chunks(BATCH) {
                    all_modes_at(order, black_box(batch), black_box(&mut f));
                }
            }),
            Contestant::new("plain sum [f32; 8]", POINTS, || {
                for y in &lanes {
                    black_box(plain::sum_of_eight(*black_box(y), &factors32, &c32));
                }
            }),
            Contestant::new("contract_at f32", POINTS, || {
                for (batch, sums) in points32.chunks(BATCH).zip(h.chunks_mut(BATCH)) {
                    contract_at(order, &s32, black_box(batch), black_box(sums));
                }
            }),
            Contestant::new("contract_at f64", POINTS, || {
                for (batch, sums) in points.chunks(BATCH).zip(k.chunks_mut(BATCH)) {
                    contract_at(order, &s, black_box(batch), black_box(sums));
                }
            }),
        ],
        rounds,
        slice,
    )
}
