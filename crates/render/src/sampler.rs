//! Random numbers as a function of (seed, pixel, sample, dimension), and the shapes that they are mapped to.
//!
//! Nothing is stepped: whoever asks for the same four numbers gets the same answer, so any split of the samples over
//! threads, passes or machines gives the same set, and the image does not depend on it.
//!
//! Samples of a pixel come in blocks. Within a block they are stratified together (`net.rs`), blocks are independent of
//! each other, and the variance of the image follows from the differences between blocks.

mod net;

use std::f32::consts::{FRAC_PI_4, TAU};
use std::num::Wrapping;

use crate::lanes::{Bits, Columns, Packed, Real, Rows};
pub use net::LARGEST_BLOCK;

/// A generator of sample points, by the name that `--sampler` takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Generator {
    /// Owen-scrambled Sobol' points, in at least eight independent blocks
    #[default]
    Sobol,
    /// Independent uniform numbers
    Independent,
}

/// Fewest blocks of a rendering: their differences tell its variance.
const FEWEST_BLOCKS: u64 = 8;

/// Size of blocks where nobody knows beforehand how many samples there will be.
const OPEN_ENDED: u64 = 16;

impl Generator {
    /// Most samples that are stratified together.
    pub fn largest_block(self) -> u64 {
        match self {
            Self::Independent => 1,
            Self::Sobol => LARGEST_BLOCK,
        }
    }

    /// Samples that are stratified together, of so many in every pixel: a power of two that divides their number.
    ///
    /// `open_ended`: the rendering may stop before all are taken.
    pub fn block(self, samples: u64, open_ended: bool) -> u64 {
        let open = if open_ended {
            OPEN_ENDED
        } else {
            LARGEST_BLOCK
        };
        let most = self
            .largest_block()
            .min(open)
            .min(samples / FEWEST_BLOCKS)
            .max(1);
        // the largest power of two in either
        let whole = 1 << samples.trailing_zeros().min(63);
        whole.min(1 << most.ilog2())
    }
}

/// The random numbers of one sample of one pixel.
pub type SampleStream = Stream<f32>;

/// The random numbers of samples side by side.
#[derive(Clone, Copy, Debug)]
pub struct Stream<R: Real> {
    /// Of each sample.
    key: [R::B; 2],
    /// Of its block.
    block: [R::B; 2],
    /// Its place in the block.
    place: R::B,
    /// Whether there are blocks: otherwise samples stand alone.
    pub stratified: bool,
}

/// Mixes 64 bits so that each of them depends on all.
///
/// Source: Stafford's variant 13 of the MurmurHash3 finaliser, as in Steele, Lea, Flood, Fast Splittable Pseudorandom
/// Number Generators, OOPSLA 2014.
#[inline]
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Odd integer closest to 2⁶⁴/φ: successive multiples fill the range evenly.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Three words of which each depends on all three that are given; the upper bits most.
///
/// Source: pcg3d of Jarzynski, Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020.
#[inline(always)]
fn scatter<B: Bits>(words: [B; 3]) -> [B; 3] {
    let (factor, more) = (B::splat(1_664_525), B::splat(1_013_904_223));
    let [x, y, z] = words;
    let (mut x, mut y, mut z) = (x * factor + more, y * factor + more, z * factor + more);
    x = x + y * z;
    y = y + z * x;
    z = z + x * y;
    [x, y, z] = [x ^ x.shr::<16>(), y ^ y.shr::<16>(), z ^ z.shr::<16>()];
    x = x + y * z;
    y = y + z * x;
    z = z + x * y;
    [x, y, z]
}

/// The key of a sample, or of a block.
#[inline(always)]
fn keys<B: Bits>([a, b]: [B; 2], [low, high]: [B; 2], kind: u32) -> [B; 2] {
    let [x, y, _] = scatter([low, a ^ high, b ^ B::splat(kind)]);
    [x, y]
}

/// Uniform in [0, 1): the upper 24 of 32 bits, exactly representable.
#[inline(always)]
fn unit<R: Real>(bits: R::B) -> R {
    R::of_int(bits.shr::<8>()) * R::splat(1.0 / 16_777_216.0)
}

/// The random numbers of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelStream([u32; 2]);

/// What tells the number of a block from that of a sample.
const BLOCKS: u32 = 0x5bd1_e995;

impl PixelStream {
    /// Of the pixel with running number `pixel`.
    #[inline]
    pub fn new(seed: u64, pixel: u64) -> Self {
        let key = mix(mix(seed.wrapping_add(GOLDEN)) ^ pixel);
        Self([key as u32, (key >> 32) as u32])
    }

    /// As two words.
    pub fn words(self) -> [u32; 2] {
        self.0
    }

    /// Of one of its samples, alone.
    #[inline(always)]
    pub fn alone(self, sample: u64) -> SampleStream {
        Stream::alone(self.0.map(Wrapping), split(sample).map(Wrapping))
    }

    /// Of one of its samples that is number `place` of its block; the samples of a block are stratified together.
    #[inline(always)]
    pub fn in_block(self, sample: u64, place: u32) -> SampleStream {
        let start = split(sample - u64::from(place)).map(Wrapping);
        let sample = split(sample).map(Wrapping);
        Stream::in_block(self.0.map(Wrapping), sample, start, Wrapping(place))
    }
}

/// Lower and upper word.
#[inline(always)]
pub fn split(x: u64) -> [u32; 2] {
    [x as u32, (x >> 32) as u32]
}

impl SampleStream {
    /// The stream of sample `sample` of the pixel with running number `pixel`, alone.
    #[inline]
    pub fn new(seed: u64, pixel: u64, sample: u64) -> Self {
        PixelStream::new(seed, pixel).alone(sample)
    }

    /// The same two numbers as an array.
    #[inline]
    pub fn pair(self, dimension: u32) -> [f32; 2] {
        self.pairs(Wrapping(dimension))
    }
}

/// Rows that a [`Stream`] takes.
pub const STREAM_ROWS: usize = 5;

impl<R: Real> Stream<R> {
    /// Of a sample of a pixel ([`PixelStream::words`], [`split`]), alone.
    #[inline(always)]
    pub fn alone(pixel: [R::B; 2], sample: [R::B; 2]) -> Self {
        let key = keys(pixel, sample, 0);
        Self {
            key,
            block: key,
            place: R::B::splat(0),
            stratified: false,
        }
    }

    /// Of number `place` of the block of samples that begins with sample `start`, which names it.
    #[inline(always)]
    pub fn in_block(pixel: [R::B; 2], sample: [R::B; 2], start: [R::B; 2], place: R::B) -> Self {
        Self {
            key: keys(pixel, sample, 0),
            block: keys(pixel, start, BLOCKS),
            place,
            stratified: true,
        }
    }

    /// Of no sample.
    #[inline(always)]
    pub fn nothing(stratified: bool) -> Self {
        let zero = R::B::splat(0);
        Self {
            key: [zero; 2],
            block: [zero; 2],
            place: zero,
            stratified,
        }
    }

    /// Lets it wait in rows from `row` on.
    #[inline(always)]
    pub fn put<const ROWS: usize>(&self, rows: &mut Rows<ROWS>, row: usize, columns: Packed<R>) {
        let [a, b] = self.key;
        let [c, d] = self.block;
        for (k, word) in [a, b, c, d, self.place].into_iter().enumerate() {
            rows.put(row + k, columns, R::of_bits(word));
        }
    }

    /// Those that wait in rows from `row` on; all of them are `stratified`, or none is.
    #[inline(always)]
    pub fn taken<const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        stratified: bool,
    ) -> Self {
        let mut words = [R::B::splat(0); STREAM_ROWS];
        for (k, word) in words.iter_mut().enumerate() {
            *word = rows.get(row + k, columns).bits();
        }
        let [a, b, c, d, place] = words;
        Self {
            key: [a, b],
            block: [c, d],
            place,
            stratified,
        }
    }

    /// Two uniform numbers a lane, in [0, 1), at an even dimension and the next.
    #[inline(always)]
    pub fn pairs(self, dimension: R::B) -> [R; 2] {
        let [a, b] = self.key;
        let [x, y, _] = scatter([a, b, dimension]);
        if !self.stratified {
            return [unit::<R>(x), unit::<R>(y)];
        }
        let [a, b] = self.block;
        let [a, b, c] = scatter([a, b, dimension]);
        let seeds = [a.shr::<8>(), b.shr::<8>(), c.shr::<8>()];
        let [u, v] = net::point(self.place, seeds);
        [
            unit::<R>(u.shl::<24>() | x.shr::<8>()),
            unit::<R>(v.shl::<24>() | y.shr::<8>()),
        ]
    }
}

/// A point uniform over the unit disk: concentric map, which keeps strata compact.
///
/// Source: Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997.
#[inline]
pub fn unit_disk([u, v]: [f32; 2]) -> (f32, f32) {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if x == 0.0 && y == 0.0 {
        return (0.0, 0.0);
    }
    let (r, phi) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * (x / y))
    };
    let (sin, cos) = phi.sin_cos();
    (r * cos, r * sin)
}

/// A direction around +z with density cos/π.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> glam::Vec3A {
    let (x, y) = unit_disk(u);
    glam::Vec3A::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// A direction uniform over the sphere, density 1/4π.
#[inline]
pub fn uniform_sphere(u: [f32; 2]) -> glam::Vec3A {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    glam::Vec3A::new(r * cos, r * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ² over 16 bins with 160,000 numbers: fixed seed; the 1e-6 quantile of χ²(15) is 56.5.
    fn chi_squared(values: impl Iterator<Item = f32>) -> f64 {
        let mut bins = [0u32; 16];
        let mut n = 0.0;
        for v in values {
            assert!((0.0..1.0).contains(&v));
            bins[(v * 16.0) as usize] += 1;
            n += 1.0;
        }
        bins.iter()
            .map(|&b| (f64::from(b) - n / 16.0).powi(2) / (n / 16.0))
            .sum()
    }

    #[test]
    fn every_coordinate_of_the_key_gives_uniform_numbers() {
        let n = 160_000u64;
        let first = |s: SampleStream| s.pair(0)[0];
        assert!(chi_squared((0..n).map(|i| first(SampleStream::new(i, 3, 5)))) < 56.5);
        assert!(chi_squared((0..n).map(|i| first(SampleStream::new(1, i, 5)))) < 56.5);
        assert!(chi_squared((0..n).map(|i| first(SampleStream::new(1, 3, i)))) < 56.5);
        let one = SampleStream::new(1, 3, 5);
        assert!(chi_squared((0..n as u32).map(|i| one.pair(2 * i)[0])) < 56.5);
        assert!(chi_squared((0..n as u32).map(|i| one.pair(2 * i)[1])) < 56.5);
    }

    #[test]
    fn neighbouring_pixels_samples_and_dimensions_are_uncorrelated() {
        let n = 100_000u64;
        let correlation = |f: &dyn Fn(u64) -> (f32, f32)| {
            (0..n)
                .map(|i| {
                    let (a, b) = f(i);
                    (f64::from(a) - 0.5) * (f64::from(b) - 0.5)
                })
                .sum::<f64>()
                / n as f64
                * 12.0
        };
        // standard deviation of the estimate is 1/√n = 0.0032; bound at 5 of them
        let at = |p, s, d| SampleStream::new(9, p, s).pair(d);
        for c in [
            correlation(&|i| (at(i, 0, 0)[0], at(i + 1, 0, 0)[0])),
            correlation(&|i| (at(7, i, 0)[0], at(7, i + 1, 0)[0])),
            correlation(&|i| (at(i, 1, 0)[0], at(i, 1, 0)[1])),
            correlation(&|i| (at(i, 1, 0)[1], at(i, 1, 2)[0])),
        ] {
            assert!(c.abs() < 5.0 / (n as f64).sqrt(), "{c}");
        }
    }

    #[test]
    fn numbers_of_a_block_are_uniform_and_its_dimensions_uncorrelated() {
        let n = 160_000u64;
        let at = |i: u64, d: u32| {
            let stream: SampleStream =
                PixelStream::new(4, i / 64).in_block(i % 64, (i % 64) as u32);
            stream.pair(d)
        };
        for d in [0, 2, 4] {
            for axis in 0..2 {
                // stratified within a block: χ² cannot be larger than of independent numbers
                assert!(chi_squared((0..n).map(|i| at(i, d)[axis])) < 56.5);
            }
        }
        // whatever the first pair does, the next is shuffled: 16 × 16 cells of a number of each, over many blocks
        for (d, axes) in [(2, [0, 0]), (2, [1, 1]), (4, [0, 1])] {
            let cell = |i: u64| {
                let (a, b) = (at(i, 0)[axes[0]], at(i, d)[axes[1]]);
                ((a * 4.0).floor() * 4.0 + (b * 4.0).floor()) / 16.0
            };
            // of 64 points 16 are in each row and each column, which makes the cells even rather than uneven
            assert!(chi_squared((0..n).map(cell)) < 56.5, "{d} {axes:?}");
        }
    }

    #[test]
    fn blocks_are_powers_of_two_that_divide_the_samples() {
        let sobol = |samples| Generator::Sobol.block(samples, false);
        assert_eq!([1, 4, 8, 16, 100, 101].map(sobol), [1, 1, 1, 2, 4, 1]);
        assert_eq!([64, 1000, 1 << 20].map(sobol), [8, 8, 256]);
        assert_eq!(Generator::Sobol.block(1 << 20, true), 16);
        assert_eq!(Generator::Independent.block(1 << 20, false), 1);
    }

    #[test]
    fn stratified_samples_integrate_a_smooth_function_better() {
        // variance of the mean of 64 values of x y over many blocks: (1/9 − 1/16)/64 if they were independent
        let blocks = 2000u64;
        let variance = |size: u64| {
            let means: Vec<f64> = (0..blocks)
                .map(|pixel| {
                    let value = |i| {
                        let stream = PixelStream::new(5, pixel);
                        let stream: SampleStream = if size == 1 {
                            stream.alone(i)
                        } else {
                            stream.in_block(i, (i % size) as u32)
                        };
                        let [x, y] = stream.pair(8);
                        f64::from(x) * f64::from(y)
                    };
                    (0..64).map(value).sum::<f64>() / 64.0
                })
                .collect();
            let mean = means.iter().sum::<f64>() / blocks as f64;
            // standard error of the mean over all blocks of independent samples: 5 of them
            assert!((mean - 0.25).abs() < 5.0 * (0.0486f64 / 64.0 / blocks as f64).sqrt());
            means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (blocks - 1) as f64
        };
        let (alone, together) = (variance(1), variance(64));
        // the variance of a variance of normal numbers: 2/(n − 1), √ of it 3.2 %
        assert!((alone / (0.0486 / 64.0) - 1.0).abs() < 0.16, "{alone}");
        // for smooth functions the variance of 2ᵐ points falls with 2⁻³ᵐ; within a hundredth it is stratified in both
        assert!(together < 0.01 * alone, "{together} {alone}");
    }

    #[test]
    fn disk_points_are_uniform_by_radius_and_angle() {
        let n = 160_000u64;
        let points = || (0..n).map(|i| unit_disk(SampleStream::new(2, 0, i).pair(0)));
        assert!(chi_squared(points().map(|(x, y)| (x * x + y * y).min(0.999_999))) < 56.5);
        assert!(
            chi_squared(points().map(|(x, y)| (y.atan2(x) / TAU + 0.5).clamp(0.0, 0.999_999)))
                < 56.5
        );
    }
}
