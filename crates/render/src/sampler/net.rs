//! Points of the first two Sobol' dimensions, Owen-scrambled and in a shuffled order: eight binary digits of each.
//!
//! A block has at most 256 points, so that only the first eight digits can be stratified; those that follow are random,
//! which is what Owen's scrambling would make of them. Every point by itself is uniform, any block of 2ᵐ points puts one
//! into each elementary interval of area 2⁻ᵐ, and different scrambles are independent as far as their hash is.
//!
//! Source: Owen, Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences, 1995; hash-based scrambling and shuffling: Burley,
//! Practical Hash-based Owen Scrambling, JCGT 9(4), 2020; the permutation: Laine and Karras, Stratified Sampling for
//! Stochastic Transparency, EGSR 2011, with Vegdahl's constants.

/// Most points that are stratified together.
pub const LARGEST_BLOCK: u64 = 256;

/// The second Sobol' dimension of a point's index, digits the other way round; the first is the index itself, so read.
const fn second(index: u8) -> u8 {
    // columns of Pascal's triangle modulo 2, from the binary digits of the index
    let (mut column, mut digits, mut sum) = (0x80u8, index, 0u8);
    while digits != 0 {
        if digits & 1 != 0 {
            sum ^= column;
        }
        column ^= column >> 1;
        digits >>= 1;
    }
    sum.reverse_bits()
}

/// A permutation of eight digits in which each digit depends on the lower ones alone: the part before its seed counts.
const fn before(x: u8) -> u8 {
    // modulo 256, so that of the permutation's constants the lowest byte is left
    x ^ x.wrapping_mul(0xea)
}

/// The part that two bytes choose; the only one that is not in the tables.
#[inline]
fn seeded(x: u8, [shift, factor]: [u8; 2]) -> usize {
    usize::from(x.wrapping_add(shift).wrapping_mul(factor | 1))
}

/// The part thereafter.
const fn after(mut x: u8) -> u8 {
    x ^= x.wrapping_mul(0x56);
    x ^ x.wrapping_mul(0x64)
}

/// The index of a point up to the seed of the shuffle.
const ENTERING: [u8; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = before((i as u8).reverse_bits());
        i += 1;
    }
    table
};

/// From there to the coordinates of the shuffled point, up to the seeds of their scrambles.
const SHUFFLED: [[u8; 2]; 256] = {
    let mut table = [[0; 2]; 256];
    let mut i = 0;
    while i < 256 {
        let index = after(i as u8).reverse_bits();
        table[i] = [before(index), before(second(index))];
        i += 1;
    }
    table
};

/// From there to a coordinate.
const SCRAMBLED: [u8; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = after(i as u8).reverse_bits();
        i += 1;
    }
    table
};

/// The first eight digits of both coordinates of point `index` of a block; of the bytes of `seeds` two choose the order
/// of the points, and two each the scrambling of a coordinate.
#[inline]
pub(super) fn point(index: u8, seeds: u64) -> [u8; 2] {
    let [a, c, b, d, e, _, f, _] = seeds.to_le_bytes();
    let [x, y] = SHUFFLED[seeded(ENTERING[usize::from(index)], [a, b])];
    [SCRAMBLED[seeded(x, [e, f])], SCRAMBLED[seeded(y, [c, d])]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some seeds that have nothing to do with each other.
    fn seeds(n: u32) -> u64 {
        u64::from(n + 1)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(29)
            .wrapping_mul(0xbf58_476d_1ce4_e5b9)
            .rotate_left(17)
    }

    #[test]
    fn blocks_of_every_size_put_one_point_into_each_elementary_interval() {
        for m in 0..=8u32 {
            for n in 0..50 {
                let points: Vec<_> = (0..1u32 << m).map(|i| point(i as u8, seeds(n))).collect();
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
                for (axis, digits) in point(index, seeds(k)).into_iter().enumerate() {
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
