//! Random numbers as a function of (seed, pixel, sample, dimension), and the shapes that they are mapped to.
//!
//! Nothing is stepped: whoever asks for the same four numbers gets the same answer, so any split of the samples over
//! threads, passes or machines gives the same set, and the image does not depend on it.

use std::f32::consts::{FRAC_PI_4, TAU};

/// A generator of sample points, by the name that `--sampler` takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Generator {
    /// Independent uniform numbers
    #[default]
    Independent,
}

/// The random numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct SampleStream {
    key: u64,
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

/// Uniform in [0, 1): the upper 24 of 32 bits, exactly representable.
#[inline]
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

impl SampleStream {
    /// The stream of sample `sample` of the pixel with running number `pixel`.
    #[inline]
    pub fn new(seed: u64, pixel: u64, sample: u64) -> Self {
        Self {
            key: mix(mix(mix(seed.wrapping_add(GOLDEN)) ^ pixel).wrapping_add(GOLDEN) ^ sample),
        }
    }

    /// Two uniform numbers in [0, 1) at an even dimension and the next.
    #[inline]
    pub fn pair(self, dimension: u32) -> [f32; 2] {
        let bits = mix(self
            .key
            .wrapping_add(u64::from(dimension / 2 + 1).wrapping_mul(GOLDEN)));
        [unit(bits as u32), unit((bits >> 32) as u32)]
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
