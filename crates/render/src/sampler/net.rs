//! Points of the first two Sobol' dimensions, Owen-scrambled and in a shuffled order: eight binary digits of each.
//!
//! A block has at most 256 points, so that only the first eight digits can be stratified; those that follow are random,
//! which is what Owen's scrambling would make of them. Every point by itself is uniform, any block of 2ᵐ points puts one
//! into each elementary interval of area 2⁻ᵐ, and different scrambles are independent as far as their hash is.
//!
//! Source: Owen, Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences, 1995; hash-based scrambling and shuffling: Burley,
//! Practical Hash-based Owen Scrambling, JCGT 9(4), 2020; the permutation: Laine and Karras, Stratified Sampling for
//! Stochastic Transparency, EGSR 2011, with Vegdahl's constants.

use crate::lanes::Bits;

/// Most points that are stratified together.
pub const LARGEST_BLOCK: u64 = 256;

/// Eight digits, the other way round.
#[inline(always)]
fn reversed<B: Bits>(x: B) -> B {
    let (four, two, one) = (B::splat(0x0f), B::splat(0x33), B::splat(0x55));
    let x = (x & four).shl::<4>() | (x.shr::<4>() & four);
    let x = (x & two).shl::<2>() | (x.shr::<2>() & two);
    (x & one).shl::<1>() | (x.shr::<1>() & one)
}

/// The second Sobol' dimension, digits the other way round; the first is the index itself, so read.
///
/// Digit j is the sum of those digits k of the index for which Pascal's triangle has an odd number in row k, column j: those
/// whose binary number contains that of j.
#[inline(always)]
fn second<B: Bits>(index: B) -> B {
    let x = index ^ (index.shr::<1>() & B::splat(0x55));
    let x = x ^ (x.shr::<2>() & B::splat(0x33));
    x ^ (x.shr::<4>() & B::splat(0x0f))
}

/// A permutation of eight digits in which each digit depends on the lower ones alone; `seed` chooses it.
#[inline(always)]
fn permuted<B: Bits>(x: B, seed: B) -> B {
    let x = x ^ (x * B::splat(0x3d20_adea));
    let x = x + seed;
    let x = x * (seed.shr::<16>() | B::splat(1));
    let x = x ^ (x * B::splat(0x0552_6c56));
    let x = x ^ (x * B::splat(0x53a2_2864));
    x & B::splat(0xff)
}

/// The first eight digits of both coordinates of point `index` of a block; `seeds` choose order and scrambling: of each
/// the first and the third byte count.
#[inline(always)]
pub(super) fn point<B: Bits>(index: B, seeds: [B; 3]) -> [B; 2] {
    let shuffled = reversed(permuted(reversed(index), seeds[0]));
    [
        reversed(permuted(shuffled, seeds[1])),
        reversed(permuted(second(shuffled), seeds[2])),
    ]
}

#[cfg(test)]
mod tests {
    use std::num::Wrapping;

    use super::*;

    /// Some seeds that have nothing to do with each other.
    fn seeds(n: u32) -> [u32; 3] {
        [1, 2, 3].map(|k| (n * 3 + k).wrapping_mul(0x9e37_79b9).rotate_left(7))
    }

    fn digits(index: u32, seeds: [u32; 3]) -> [u8; 2] {
        point(Wrapping(index), seeds.map(Wrapping)).map(|x| x.0 as u8)
    }

    #[test]
    fn blocks_of_every_size_put_one_point_into_each_elementary_interval() {
        for m in 0..=8u32 {
            for n in 0..50 {
                let points: Vec<_> = (0..1u32 << m).map(|i| digits(i, seeds(n))).collect();
                for across in 0..=m {
                    let mut cells: Vec<u32> = points
                        .iter()
                        .map(|&[x, y]| {
                            let column = u32::from(x) >> (8 - across);
                            let row = u32::from(y) >> (8 - (m - across));
                            column << (m - across) | row
                        })
                        .collect();
                    cells.sort_unstable();
                    assert!(
                        cells.into_iter().eq(0..1 << m),
                        "2^{m} points, {across} columns"
                    );
                }
            }
        }
    }

    #[test]
    fn a_point_is_uniform_over_the_seeds() {
        for index in [0, 1, 77, 255] {
            let mut counts = [[0u32; 16]; 2];
            let n = 160_000;
            for k in 0..n {
                for (axis, digits) in digits(index, seeds(k)).into_iter().enumerate() {
                    counts[axis][usize::from(digits >> 4)] += 1;
                }
            }
            for bins in counts {
                let expected = f64::from(n) / 16.0;
                let chi: f64 = bins
                    .iter()
                    .map(|&b| (f64::from(b) - expected).powi(2) / expected)
                    .sum();
                // the 1e-6 quantile of χ²(15)
                assert!(chi < 56.5, "{index}: {chi}");
            }
        }
    }
}
