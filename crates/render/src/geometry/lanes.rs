//! What tracing a ray asks of a processor: numbers side by side; and the portable answer to it. That of AVX2 is in
//! `intrinsics.rs`.
//!
//! Every operation rounds each lane as IEEE 754 has it and nothing is fused, so all implementations give the same
//! bits: traversal, distances and barycentric weights do not depend on the instructions that were chosen.

#[cfg(target_arch = "x86_64")]
use crate::intrinsics::{Avx2, found};

/// `N` numbers in single precision that are worked on together.
///
/// A value of the implementing type is the permission to use its instructions.
pub(crate) trait Lanes<const N: usize>: Copy {
    /// The numbers.
    type F: Copy;

    fn load(self, from: &[f32; N]) -> Self::F;

    /// Numbers of which only the sign bits matter.
    fn load_signs(self, from: &[u32; N]) -> Self::F;

    fn splat(self, x: f32) -> Self::F;

    fn store(self, a: Self::F) -> [f32; N];

    fn add(self, a: Self::F, b: Self::F) -> Self::F;

    fn sub(self, a: Self::F, b: Self::F) -> Self::F;

    fn mul(self, a: Self::F, b: Self::F) -> Self::F;

    fn div(self, a: Self::F, b: Self::F) -> Self::F;

    /// `a` where it is less, otherwise `b`: `b` survives a NaN in `a`.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;

    /// `a` where it is greater, otherwise `b`: `b` survives a NaN in `a`.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;

    /// `a` where the sign bit is set, otherwise `b`.
    fn select(self, signs: Self::F, a: Self::F, b: Self::F) -> Self::F;

    /// Sign bits, lane 0 lowest.
    fn signs(self, a: Self::F) -> u32;

    /// Where `a ≤ b`, lane 0 in the lowest bit.
    fn le(self, a: Self::F, b: Self::F) -> u32;

    /// Where `a < b`, lane 0 in the lowest bit.
    fn lt(self, a: Self::F, b: Self::F) -> u32;
}

/// What the traversal needs: eight boxes at once, four flat primitives at once.
pub(crate) trait Simd: Lanes<8> + Lanes<4> {
    /// Says that something will be read soon.
    fn prefetch<T>(self, _at: &T) {}
}

/// Something to be done with rays: one source for all instructions.
pub(crate) trait Traversal {
    /// What comes of it.
    type Output;

    /// Does it. Must be `#[inline(always)]`, as everything in it that takes a [`Simd`].
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Which instructions trace rays.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Instructions {
    /// Those that every processor has.
    #[default]
    Portable,
    /// Eight lanes at once.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Instructions {
    /// The best that this processor has, or the portable ones where the environment allows no others.
    pub(super) fn choose() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let (Some(avx2), _) = found() {
            return Self::Avx2(avx2);
        }
        Self::Portable
    }

    /// Does it in a function that is compiled for these instructions.
    #[inline]
    pub(super) fn trace<T: Traversal>(self, traversal: T) -> T::Output {
        match self {
            Self::Portable => Portable.trace(traversal),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.trace(traversal),
        }
    }
}

/// Plain arrays, for every processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

impl Simd for Portable {}

impl Portable {
    /// Out of the way of scenes of one shape.
    #[inline(never)]
    fn trace<T: Traversal>(self, traversal: T) -> T::Output {
        traversal.run(self)
    }
}

#[inline(always)]
fn map<const N: usize>(a: [f32; N], b: [f32; N], f: impl Fn(f32, f32) -> f32) -> [f32; N] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn bits<const N: usize>(f: impl Fn(usize) -> bool) -> u32 {
    (0..N).fold(0, |bits, i| bits | u32::from(f(i)) << i)
}

impl<const N: usize> Lanes<N> for Portable {
    type F = [f32; N];

    #[inline(always)]
    fn load(self, from: &[f32; N]) -> [f32; N] {
        *from
    }

    #[inline(always)]
    fn load_signs(self, from: &[u32; N]) -> [f32; N] {
        from.map(f32::from_bits)
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; N] {
        [x; N]
    }

    #[inline(always)]
    fn store(self, a: [f32; N]) -> [f32; N] {
        a
    }

    #[inline(always)]
    fn add(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn min(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        map(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn select(self, signs: [f32; N], a: [f32; N], b: [f32; N]) -> [f32; N] {
        std::array::from_fn(|i| {
            if signs[i].is_sign_negative() {
                a[i]
            } else {
                b[i]
            }
        })
    }

    #[inline(always)]
    fn signs(self, a: [f32; N]) -> u32 {
        bits::<N>(|i| a[i].is_sign_negative())
    }

    #[inline(always)]
    fn le(self, a: [f32; N], b: [f32; N]) -> u32 {
        bits::<N>(|i| a[i] <= b[i])
    }

    #[inline(always)]
    fn lt(self, a: [f32; N], b: [f32; N]) -> u32 {
        bits::<N>(|i| a[i] < b[i])
    }
}
