//! Claim: single precision costs paths their rounding and nothing else: no drift, no number that is none.
//!
//! The same source follows the same samples with numbers in double precision. What waits between two links, tables, and
//! the program's own exponentials, logarithms and circular functions stay in single precision.

use std::marker::PhantomData;
use std::num::Wrapping;
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::Vec4;

use super::tests::{
    SAMPLES, Samples, built, of_plastic, of_plates, of_rough_matter, of_smooth_matter,
};
use crate::lanes::{Double, MOST, Part, Real, Task};
use crate::light::abreast::Stokes;

/// One number in double precision.
#[derive(Clone, Copy, Debug)]
struct Fine(f64);

/// Patterns of bits that are no numbers in single precision pass through unchanged: random words wait among numbers.
const PATTERN: u64 = 0x7ff8_dead_0000_0000;

impl Fine {
    fn coarse(self) -> f32 {
        let bits = self.0.to_bits();
        if bits & 0xffff_ffff_0000_0000 == PATTERN {
            f32::from_bits(bits as u32)
        } else {
            self.0 as f32
        }
    }
    fn of_coarse(x: f32) -> Self {
        if x.is_nan() {
            Self(f64::from_bits(PATTERN | u64::from(x.to_bits())))
        } else {
            Self(f64::from(x))
        }
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident)*) => {$(
        impl $trait for Fine {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}
operators!(Add add Sub sub Mul mul Div div);

impl Neg for Fine {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Double for Fine {
    type Single = Self;
    fn splat(x: f64) -> Self {
        Self(x)
    }
    fn wide(x: Self) -> Self {
        x
    }
    fn narrow(self) -> Self {
        self
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn max(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    fn min(self, other: Self) -> Self {
        if self.0 < other.0 { self } else { other }
    }
    fn is_negative(self) -> bool {
        self.0 < 0.0
    }
}

impl Real for Fine {
    const LANES: usize = 1;
    type M = bool;
    type B = Wrapping<u32>;
    type D = Self;

    fn splat(x: f32) -> Self {
        Self::of_coarse(x)
    }
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        Self::of_coarse(f(0))
    }
    fn apart<P: Part<Self>>(part: P) -> P::Output {
        part.run()
    }
    fn load(from: &[f32], first: usize) -> Self {
        Self::of_coarse(from[first])
    }
    fn store(self, to: &mut [f32], first: usize) {
        to[first] = self.coarse();
    }
    fn gather(from: &[f32], places: Wrapping<u32>) -> Self {
        Self::of_coarse(f32::gather(from, places))
    }
    fn order(_: bool) -> Wrapping<u32> {
        Wrapping(0)
    }
    fn ordered(self, _: Wrapping<u32>) -> Self {
        self
    }
    fn lane(self, _: usize) -> f32 {
        self.coarse()
    }
    fn lanes(self) -> [f32; MOST] {
        [self.coarse(); MOST]
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn min(self, other: Self) -> Self {
        if self.0 < other.0 { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    fn round(self) -> Self {
        Self(self.0.round_ties_even())
    }
    fn copysign(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }
    fn eq(self, other: Self) -> bool {
        self.0 == other.0
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    fn select_bits(mask: bool, a: Wrapping<u32>, b: Wrapping<u32>) -> Wrapping<u32> {
        if mask { a } else { b }
    }
    fn bits(self) -> Wrapping<u32> {
        Wrapping(self.coarse().to_bits())
    }
    fn of_bits(bits: Wrapping<u32>) -> Self {
        Self::of_coarse(f32::from_bits(bits.0))
    }
    fn of_int(bits: Wrapping<u32>) -> Self {
        Self(f64::from(bits.0))
    }
    fn to_int(self) -> Wrapping<u32> {
        Wrapping(self.0 as i32 as u32)
    }
    fn same(a: Wrapping<u32>, b: Wrapping<u32>) -> bool {
        a == b
    }
}

/// Unit of rounding in single precision.
const EPSILON: f64 = 0.5 * f32::EPSILON as f64;

/// Roundings that are the same in all samples (of constants and of what a scene is made of), so that they do not cancel:
/// at most six links of at most thirty factors.
const SHARED: f64 = 180.0;

#[test]
fn double_precision_finds_the_same_light() {
    let mut sizes: Vec<f64> = vec![];
    for content in [
        of_smooth_matter(),
        of_rough_matter(),
        of_plastic(),
        of_plates(),
    ]
    .concat()
    {
        let scene = built(&content);
        let samples = Samples(&scene, PhantomData::<Stokes<1, 4>>);
        let (single, double) = (samples.run::<f32>(), samples.run::<Fine>());
        assert!(
            single.iter().chain(&double).all(|s| s.is_finite()),
            "{content}"
        );
        let n = SAMPLES as f64;
        let mean = double.iter().map(|s| f64::from(s.x)).sum::<f64>() / n;
        let differences: Vec<_> = single
            .iter()
            .zip(&double)
            .map(|(a, b)| (*a - *b).as_dvec4())
            .collect();
        // rounding decides now and then which way a path goes
        let size = |s: &Vec4| f64::from(s.x).max(0.1 * mean);
        let far = differences
            .iter()
            .zip(&double)
            .filter(|(d, s)| d.abs().max_element() > 1e-3 * size(s));
        assert!((far.count() as f64) < 2e-3 * n, "{content}");
        for component in 0..4 {
            let drift = differences.iter().map(|d| d[component]).sum::<f64>() / n;
            let square = differences
                .iter()
                .map(|d| d[component].powi(2))
                .sum::<f64>()
                / n;
            // 4 σ: with four components of thirty scenes one run in a hundred would fail by chance
            let limit = 4.0 * (square / n).sqrt() + SHARED * EPSILON * mean;
            assert!(
                drift.abs() <= limit,
                "{content}: S{component} drifts by {drift}, limit {limit}"
            );
        }
        let seen = differences.iter().zip(&double).filter(|(_, s)| s.x > 0.0);
        sizes.extend(seen.map(|(d, s)| d.abs().max_element() / f64::from(s.x)));
    }
    sizes.sort_by(f64::total_cmp);
    for share in [0.5, 0.9, 0.99, 0.999] {
        let size = sizes[(share * sizes.len() as f64) as usize] / EPSILON;
        println!("{share} of the samples differ by at most {size:.1} units of rounding");
    }
}
