use glam::{Vec4, vec4};

use super::*;
use crate::film::SampleSums;

fn tile(products: bool) -> TileSums {
    TileSums::new([32, 16], [5, 5], (2, products, false))
}

/// Adds a sample in the second of two colours, as a pass of its own, to the run of blocks of `block` after `first` samples.
fn add(tile: &mut TileSums, (first, block): (u64, u64), sample: Vec4) {
    let (x, y) = (36, 20);
    let mut sums = SampleSums::new(2);
    tile.go_on(x, y, first, block);
    tile.open(x, y, &mut sums);
    assert!(sums.add(&[Vec4::ONE, sample]));
    let taken = tile.taken(x, y) + 1;
    if (taken - first).is_multiple_of(block) {
        tile.close(x, y, &mut sums);
    }
    tile.keep(x, y, &sums, taken);
}

const SAMPLES: [Vec4; 7] = [
    vec4(1.0, 0.5, -0.25, 0.125),
    vec4(3.0, -1.0, 0.5, 2.0),
    vec4(0.5, 0.5, 0.0, 0.0),
    vec4(2.5, 0.0, 1.0, -1.0),
    vec4(4.0, -2.0, 0.5, 0.25),
    vec4(0.125, 0.0, 0.0, 0.0),
    vec4(7.0, 1.0, 1.0, 1.0),
];

/// Variance of a sample of `weights · S` from the means of blocks, as textbooks have it.
fn variance_of_a_sample(samples: &[Vec4], block: usize, weights: [f64; 4]) -> f64 {
    let value = |s: &Vec4| (0..4).map(|k| weights[k] * f64::from(s[k])).sum::<f64>();
    let means: Vec<f64> = samples
        .chunks_exact(block)
        .map(|b| b.iter().map(value).sum::<f64>() / block as f64)
        .collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) * block as f64
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12 * b.abs()
}

#[test]
fn the_variance_of_a_sum_of_components_is_that_of_the_summed_blocks() {
    let mut tile = tile(true);
    // three blocks of two samples, and one that is not complete
    SAMPLES.iter().for_each(|s| add(&mut tile, (0, 2), *s));
    let pixel = tile.pixel(36, 20);
    assert_eq!((pixel.samples(), pixel.blocks()), (7, 3));
    let variance = |weights| variance_of_a_sample(&SAMPLES, 2, weights) / 7.0;
    let weights = [0.5, -0.25, 2.0, 1.0];
    let (found, expected) = (pixel.variance_of(&weights, 1), variance(weights));
    assert!(
        found.is_some_and(|f| close(f, expected)),
        "{found:?} {expected}"
    );
    assert_eq!(pixel.variance_of(&weights, 0), Some(0.0));
    // one component alone: the mean and the variance that the image has
    let (mean, alone) = pixel.estimate(1, 1);
    let expected = SAMPLES.iter().map(|s| f64::from(s.y)).sum::<f64>() / 7.0;
    assert!((mean - expected).abs() < 1e-15);
    assert!(close(alone, variance([0.0, 1.0, 0.0, 0.0])));
    // both colours together, the other has none
    assert!(close(pixel.variance_in_run(1), 7.0 * alone));
}

#[test]
fn runs_of_blocks_of_different_sizes_add_up() {
    let mut tile = tile(true);
    SAMPLES[..3].iter().for_each(|s| add(&mut tile, (0, 1), *s));
    SAMPLES[3..].iter().for_each(|s| add(&mut tile, (3, 2), *s));
    let pixel = tile.pixel(36, 20);
    assert_eq!((pixel.samples(), pixel.blocks()), (7, 5));
    for weights in [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.5, -0.25, 2.0, 1.0],
    ] {
        let early = 3.0 * variance_of_a_sample(&SAMPLES[..3], 1, weights);
        let late = 4.0 * variance_of_a_sample(&SAMPLES[3..], 2, weights);
        let expected = (early + late) / 49.0;
        let found = pixel.variance_of(&weights, 1);
        assert!(
            found.is_some_and(|f| close(f, expected)),
            "{found:?} {expected}"
        );
        if let Some(k) = weights.iter().position(|w| *w == 1.0)
            && weights[0] + weights[3] == 1.0
        {
            let (mean, variance) = pixel.estimate(k, 1);
            let sum: f64 = SAMPLES.iter().map(|s| f64::from(s[k])).sum();
            assert!(close(mean, sum / 7.0) && close(variance, expected));
            // what the run in progress shows is its own
            assert!(close(pixel.variance_in_run(k), late / 4.0));
        }
    }
    assert_eq!(pixel.estimate(0, 0), (1.0, 0.0));
}

#[test]
fn a_run_too_short_to_tell_counts_as_noisy_as_those_before() {
    let mut tile = tile(true);
    SAMPLES[..4].iter().for_each(|s| add(&mut tile, (0, 1), *s));
    let four = tile.pixel(36, 20).estimate(0, 1).1;
    SAMPLES[4..].iter().for_each(|s| add(&mut tile, (4, 2), *s));
    let seven = tile.pixel(36, 20).estimate(0, 1).1;
    assert!(close(seven, four * 4.0 / 7.0), "{seven} {four}");
}

#[test]
fn one_block_tells_no_variance_and_neither_does_a_film_without_products() {
    let mut one = tile(true);
    SAMPLES[..3].iter().for_each(|s| add(&mut one, (0, 2), *s));
    let pixel = one.pixel(36, 20);
    assert_eq!(pixel.estimate(0, 1), (1.5, f64::INFINITY));
    assert_eq!(pixel.variance_of(&[1.0; 4], 1), None);
    assert_eq!(pixel.variance_in_run(0), f64::INFINITY);

    let mut plain = tile(false);
    SAMPLES[..3]
        .iter()
        .for_each(|s| add(&mut plain, (0, 1), *s));
    assert_eq!(plain.pixel(36, 20).estimate(0, 0), (1.0, 0.0));
    assert_eq!(plain.pixel(36, 20).variance_of(&[1.0; 4], 1), None);
}
