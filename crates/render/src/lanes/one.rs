//! One lane: plain numbers, for every processor.

use std::num::Wrapping;

use super::{Bits, Double, MOST, Mask, Part, Real};

impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits & 1 != 0
    }
}

impl Bits for Wrapping<u32> {
    #[inline(always)]
    fn splat(x: u32) -> Self {
        Self(x)
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
        Self(f(0))
    }
    #[inline(always)]
    fn lanes(self) -> [u32; MOST] {
        [self.0; MOST]
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        Self(self.0 << N)
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        Self(self.0 >> N)
    }
}

impl Double for f64 {
    type Single = f32;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn wide(x: f32) -> Self {
        Self::from(x)
    }
    #[inline(always)]
    fn narrow(self) -> f32 {
        self as f32
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn is_negative(self) -> bool {
        self < 0.0
    }
}

impl Real for f32 {
    const LANES: usize = 1;
    type M = bool;
    type B = Wrapping<u32>;
    type D = f64;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        f(0)
    }
    #[inline(never)]
    fn apart<P: Part<Self>>(part: P) -> P::Output {
        part.run()
    }
    #[inline(always)]
    fn load(from: &[f32], first: usize) -> Self {
        from[first]
    }
    #[inline(always)]
    fn store(self, to: &mut [f32], first: usize) {
        to[first] = self;
    }
    #[inline(always)]
    fn gather(from: &[f32], places: Wrapping<u32>) -> Self {
        from[(places.0 as usize).min(from.len() - 1)]
    }
    #[inline(always)]
    fn order(_: bool) -> Wrapping<u32> {
        Wrapping(0)
    }
    #[inline(always)]
    fn ordered(self, _: Wrapping<u32>) -> Self {
        self
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self
    }
    #[inline(always)]
    fn lanes(self) -> [f32; MOST] {
        [self; MOST]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn round(self) -> Self {
        // the library's would be a call: from 2²³ on there are only integers, and sums are rounded to them
        let (size, whole) = (Self::abs(self), 8_388_608.0);
        let near = (size + whole) - whole;
        Self::copysign(if size < whole { near } else { size }, self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self::copysign(self, sign)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn bits(self) -> Wrapping<u32> {
        Wrapping(self.to_bits())
    }
    #[inline(always)]
    fn of_bits(bits: Wrapping<u32>) -> Self {
        Self::from_bits(bits.0)
    }
    #[inline(always)]
    fn of_int(bits: Wrapping<u32>) -> Self {
        bits.0 as Self
    }
    #[inline(always)]
    fn to_int(self) -> Wrapping<u32> {
        Wrapping(self as i32 as u32)
    }
    #[inline(always)]
    fn same(a: Wrapping<u32>, b: Wrapping<u32>) -> bool {
        a == b
    }
}
