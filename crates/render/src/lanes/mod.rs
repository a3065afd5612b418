//! Numbers side by side: one camera path a lane, all doing the same at the same time.
//!
//! What is written for any [`Real`] runs with one path at a time (`f32`, every processor), with eight (AVX2) or sixteen
//! (AVX-512, both in `intrinsics.rs`), chosen at run time by [`run`]. Every operation rounds each lane as IEEE 754 has it and
//! nothing is fused, so that all give the same bits. Lanes that do not take part go through the same arithmetic; masks keep
//! their results out.
//!
//! Everything here is inlined into the task that [`run`] is given: only there are the instructions known.

mod functions;
mod one;
mod rows;
#[cfg(test)]
mod tests;
mod vector;

use std::ffi::OsStr;
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

#[cfg(target_arch = "x86_64")]
use crate::intrinsics::found;
#[cfg(all(target_arch = "x86_64", test))]
use crate::intrinsics::present;

pub use functions::{atan2, exp, ln, polynomial, sin_cos_turns};
pub use rows::{COLUMNS, Columns, Packed, Rows};
pub use vector::{Axes, V3};

/// Most lanes that any [`Real`] has.
pub const MOST: usize = 16;

/// Where something holds.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// In any lane.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Lane 0 in the lowest bit.
    fn bits(self) -> u32;
    /// From such bits.
    fn from_bits(bits: u32) -> Self;
}

/// Unsigned numbers of 32 bits; arithmetic wraps.
pub trait Bits:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
{
    /// The same in all lanes.
    fn splat(x: u32) -> Self;
    /// Lane by lane.
    fn from_fn(f: impl FnMut(usize) -> u32) -> Self;
    /// All lanes; of [`MOST`] only as many count as there are.
    fn lanes(self) -> [u32; MOST];
    /// Times 2ⁿ.
    fn shl<const N: i32>(self) -> Self;
    /// Over 2ⁿ.
    fn shr<const N: i32>(self) -> Self;
}

/// Numbers in double precision, where single precision cancels.
pub trait Double:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What they are rounded to.
    type Single: Real<D = Self>;
    /// The same in all lanes.
    fn splat(x: f64) -> Self;
    /// Without loss.
    fn wide(x: Self::Single) -> Self;
    /// Rounded.
    fn narrow(self) -> Self::Single;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The larger.
    fn max(self, other: Self) -> Self;
    /// The smaller.
    fn min(self, other: Self) -> Self;
    /// Where it is below zero.
    fn is_negative(self) -> <Self::Single as Real>::M;
}

/// Numbers in single precision, one or several.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// How many.
    const LANES: usize;
    /// Where something holds.
    type M: Mask;
    /// Their bits.
    type B: Bits;
    /// In double precision.
    type D: Double<Single = Self>;

    /// The same in all lanes.
    fn splat(x: f32) -> Self;
    /// Lane by lane.
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self;
    /// As many numbers as there are lanes, from place `first` on.
    fn load(from: &[f32], first: usize) -> Self;
    /// Writes as many numbers as there are lanes, from place `first` on.
    fn store(self, to: &mut [f32], first: usize);
    /// The number at its own place for each lane; places beyond the end mean the last.
    fn gather(from: &[f32], places: Self::B) -> Self;
    /// The order in which lanes where the mask holds come first, for [`Real::ordered`].
    fn order(mask: Self::M) -> Self::B;
    /// With its lanes in another order.
    fn ordered(self, order: Self::B) -> Self;
    /// One lane.
    fn lane(self, lane: usize) -> f32;
    /// All lanes; of [`MOST`] only as many count as there are.
    fn lanes(self) -> [f32; MOST];
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller; `other` where either is not a number.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` where either is not a number.
    fn max(self, other: Self) -> Self;
    /// The nearest integer, the even one of two.
    fn round(self) -> Self;
    /// Its value with the sign of another.
    fn copysign(self, sign: Self) -> Self;
    /// Where it is smaller.
    fn lt(self, other: Self) -> Self::M;
    /// Where it is not larger.
    fn le(self, other: Self) -> Self::M;
    /// Where it is equal.
    fn eq(self, other: Self) -> Self::M;
    /// `a` where the mask holds, elsewhere `b`.
    fn select(mask: Self::M, a: Self, b: Self) -> Self;
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    fn select_bits(mask: Self::M, a: Self::B, b: Self::B) -> Self::B {
        Self::select(mask, Self::of_bits(a), Self::of_bits(b)).bits()
    }
    /// Its bits.
    fn bits(self) -> Self::B;
    /// From bits.
    fn of_bits(bits: Self::B) -> Self;
    /// Of integers below 2³¹.
    fn of_int(bits: Self::B) -> Self;
    /// Toward zero, as integers.
    fn to_int(self) -> Self::B;
    /// Where two integers are equal.
    fn same(a: Self::B, b: Self::B) -> Self::M;

    /// Does a part in a function of its own, compiled for these lanes.
    fn apart<P: Part<Self>>(part: P) -> P::Output;

    /// Where it is larger.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::M {
        other.lt(self)
    }
    /// Where it is not smaller.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::M {
        other.le(self)
    }
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
    /// One over it.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// It where a mask holds, elsewhere zero.
    #[inline(always)]
    fn only(self, mask: Self::M) -> Self {
        Self::select(mask, self, Self::zero())
    }
    /// From the first to the second.
    #[inline(always)]
    fn clamp(self, low: f32, high: f32) -> Self {
        self.max(Self::splat(low)).min(Self::splat(high))
    }
    /// Everywhere.
    #[inline(always)]
    fn everywhere() -> Self::M {
        Self::M::from_bits((1 << Self::LANES) - 1)
    }
    /// Nowhere.
    #[inline(always)]
    fn nowhere() -> Self::M {
        Self::M::from_bits(0)
    }
    /// In the first `count` lanes, or in all if that is more.
    #[inline(always)]
    fn first(count: usize) -> Self::M {
        Self::M::from_bits((1u32 << count.min(Self::LANES)) - 1)
    }
}

/// The lanes in which bits are set, one after the other.
#[inline(always)]
pub fn each(mut bits: u32, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// Part of a task that is not inlined into the rest: a single function of everything would take minutes to build.
pub trait Part<R: Real> {
    /// What comes of it.
    type Output;
    /// Does it. Must be `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// Defines a [`Part`] by its name, the lifetimes and types of which it speaks, the arguments of the function that does it,
/// what that returns, and the function.
macro_rules! part {
    ($name:ident<$($life:lifetime),*; $R:ident $(, $L:ident: $bound:ident)?>
        ($($field:ident: $type:ty),* $(,)?) -> $out:ty: $f:expr) => {
        struct $name<$($life,)* $R: $crate::lanes::Real $(, $L: $bound)?> {
            $($field: $type,)*
        }
        impl<$($life,)* $R: $crate::lanes::Real $(, $L: $bound)?> $crate::lanes::Part<$R>
            for $name<$($life,)* $R $(, $L)?>
        {
            type Output = $out;
            #[inline(always)]
            fn run(self) -> $out {
                let Self { $($field,)* } = self;
                $f($($field,)*)
            }
        }
    };
}
pub(crate) use part;

/// Something to be done with numbers side by side.
pub trait Task {
    /// What comes of it.
    type Output;
    /// Does it. Must be `#[inline(always)]`, as everything in it that takes a [`Real`].
    fn run<R: Real>(self) -> Self::Output;
}

/// Which of the processor's instructions may be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Allowed {
    /// Those that every processor has.
    Portable,
    /// AVX2 too.
    Avx2,
    /// All.
    #[default]
    All,
}

impl Allowed {
    /// What the environment says: `BREWSTER_SIMD` is `portable`, `avx2`, or nothing for all.
    ///
    /// # Errors
    ///
    /// Where it is anything else.
    pub fn by_environment() -> Result<Self, String> {
        Self::of(&std::env::var_os("BREWSTER_SIMD").unwrap_or_default())
    }

    fn of(wish: &OsStr) -> Result<Self, String> {
        match wish.to_str() {
            Some("") => Ok(Self::All),
            Some("avx2") => Ok(Self::Avx2),
            Some("portable") => Ok(Self::Portable),
            _ => Err(format!(
                "BREWSTER_SIMD: unknown instructions '{}', expected 'avx2' or 'portable', or nothing for all",
                wish.to_string_lossy()
            )),
        }
    }
}

/// Does a task with as many lanes as the processor has, or with fewer where the environment asks for that: [`Allowed`].
pub fn run<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    {
        let (avx2, avx512) = found();
        if let Some(avx512) = avx512 {
            return avx512.run(task);
        }
        if let Some(avx2) = avx2 {
            return avx2.run(task);
        }
    }
    task.run::<f32>()
}

/// Does a task with one lane, and with as many of every kind of instructions that the processor has, whatever the
/// environment says.
#[cfg(test)]
pub fn run_with_each<T: Task + Copy>(task: T) -> Vec<T::Output> {
    #[cfg_attr(
        not(target_arch = "x86_64"),
        expect(unused_mut, reason = "there is only one kind")
    )]
    let mut all = vec![task.run::<f32>()];
    #[cfg(target_arch = "x86_64")]
    {
        let (avx2, avx512) = present();
        all.extend(avx2.map(|avx2| avx2.run(task)));
        all.extend(avx512.map(|avx512| avx512.run(task)));
    }
    if all.len() == 1 {
        eprintln!("skipped: lanes are compared with one another and need AVX2, which is not here");
    }
    all
}
