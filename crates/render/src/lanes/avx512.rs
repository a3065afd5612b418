//! Sixteen lanes: AVX-512, which is looked for at run time.
//!
//! One of the files of the program with `unsafe`; twin of `avx2.rs`.
#![expect(
    unsafe_code,
    reason = "intrinsics are sound where the processor has them: numbers of these types are made in `run` alone, after they were found"
)]

use std::arch::x86_64 as arch;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};
use std::sync::OnceLock;

use super::{Bits, Double, MOST, Mask, Part, Real, Task};

const LANES: usize = 16;

/// Whether the processor has AVX-512 and the environment does not forbid it.
pub(super) fn is_there() -> bool {
    static THERE: OnceLock<bool> = OnceLock::new();
    *THERE.get_or_init(|| {
        !super::wished_for(&["portable", "avx2"])
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
    })
}

/// Does a task; only where [`is_there`].
pub(super) fn run<T: Task>(task: T) -> T::Output {
    assert!(is_there(), "asked for instructions that are not there");
    // SAFETY: they are there
    unsafe { run_here(task) }
}

#[target_feature(enable = "avx512f,avx2,bmi1,bmi2")]
fn run_here<T: Task>(task: T) -> T::Output {
    task.run::<F16>()
}

#[target_feature(enable = "avx512f,avx2,bmi1,bmi2")]
#[inline(never)]
fn apart_here<P: Part<F16>>(part: P) -> P::Output {
    part.run()
}

/// Sixteen numbers in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct F16(arch::__m512);

/// Sixteen numbers of 32 bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct U16(arch::__m512i);

/// Sixteen answers.
#[derive(Clone, Copy, Debug)]
pub(super) struct M16(u16);

/// Sixteen numbers in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct D16(arch::__m512d, arch::__m512d);

/// An operator of two operands.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where the instructions do
                unsafe { Self(arch::$intrinsic(self.0, other.0)) }
            }
        }
    };
}

operator!(F16, Add, add, _mm512_add_ps);
operator!(F16, Sub, sub, _mm512_sub_ps);
operator!(F16, Mul, mul, _mm512_mul_ps);
operator!(F16, Div, div, _mm512_div_ps);
operator!(U16, Add, add, _mm512_add_epi32);
operator!(U16, Sub, sub, _mm512_sub_epi32);
operator!(U16, Mul, mul, _mm512_mullo_epi32);
operator!(U16, BitAnd, bitand, _mm512_and_si512);
operator!(U16, BitOr, bitor, _mm512_or_si512);
operator!(U16, BitXor, bitxor, _mm512_xor_si512);

/// The same on both halves.
macro_rules! halves {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for D16 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where the instructions do
                unsafe {
                    Self(
                        arch::$intrinsic(self.0, other.0),
                        arch::$intrinsic(self.1, other.1),
                    )
                }
            }
        }
    };
}

halves!(Add, add, _mm512_add_pd);
halves!(Sub, sub, _mm512_sub_pd);
halves!(Mul, mul, _mm512_mul_pd);
halves!(Div, div, _mm512_div_pd);

impl Neg for F16 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::of_bits(Real::bits(self) ^ U16::splat(1 << 31))
    }
}

impl Neg for D16 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let sign = arch::_mm512_castpd_si512(arch::_mm512_set1_pd(-0.0));
            let (low, high) = (
                arch::_mm512_castpd_si512(self.0),
                arch::_mm512_castpd_si512(self.1),
            );
            Self(
                arch::_mm512_castsi512_pd(arch::_mm512_xor_si512(low, sign)),
                arch::_mm512_castsi512_pd(arch::_mm512_xor_si512(high, sign)),
            )
        }
    }
}

impl BitAnd for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for M16 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for M16 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

impl Bits for U16 {
    #[inline(always)]
    fn splat(x: u32) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm512_set1_epi32(x as i32)) }
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
        let mut all = [0u32; LANES];
        for (lane, x) in all.iter_mut().enumerate() {
            *x = f(lane);
        }
        // SAFETY: called by tasks that run here alone; as many numbers as are read
        unsafe { Self(arch::_mm512_loadu_si512(all.as_ptr().cast())) }
    }
    #[inline(always)]
    fn lanes(self) -> [u32; MOST] {
        let mut all = [0; MOST];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm512_storeu_si512(all.as_mut_ptr().cast(), self.0) };
        all
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_sll_epi32(self.0, arch::_mm_cvtsi32_si128(N))) }
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_srl_epi32(self.0, arch::_mm_cvtsi32_si128(N))) }
    }
}

impl Double for D16 {
    type Single = F16;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm512_set1_pd(x), arch::_mm512_set1_pd(x)) }
    }
    #[inline(always)]
    fn wide(x: F16) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let upper = arch::_mm512_extractf64x4_pd::<1>(arch::_mm512_castps_pd(x.0));
            Self(
                arch::_mm512_cvtps_pd(arch::_mm512_castps512_ps256(x.0)),
                arch::_mm512_cvtps_pd(arch::_mm256_castpd_ps(upper)),
            )
        }
    }
    #[inline(always)]
    fn narrow(self) -> F16 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let (low, high) = (arch::_mm512_cvtpd_ps(self.0), arch::_mm512_cvtpd_ps(self.1));
            let low = arch::_mm512_castpd256_pd512(arch::_mm256_castps_pd(low));
            let both = arch::_mm512_insertf64x4::<1>(low, arch::_mm256_castps_pd(high));
            F16(arch::_mm512_castpd_ps(both))
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_sqrt_pd(self.0), arch::_mm512_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(
                arch::_mm512_max_pd(self.0, other.0),
                arch::_mm512_max_pd(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(
                arch::_mm512_min_pd(self.0, other.0),
                arch::_mm512_min_pd(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn is_negative(self) -> M16 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let zero = arch::_mm512_setzero_pd();
            let low = arch::_mm512_cmp_pd_mask::<{ arch::_CMP_LT_OQ }>(self.0, zero);
            let high = arch::_mm512_cmp_pd_mask::<{ arch::_CMP_LT_OQ }>(self.1, zero);
            M16(u16::from(low) | u16::from(high) << 8)
        }
    }
}

/// A question to two numbers.
macro_rules! compare {
    ($method:ident, $predicate:ident) => {
        #[inline(always)]
        fn $method(self, other: Self) -> M16 {
            // SAFETY: values of this type exist only where the instructions do
            unsafe {
                M16(arch::_mm512_cmp_ps_mask::<{ arch::$predicate }>(
                    self.0, other.0,
                ))
            }
        }
    };
}

impl Real for F16 {
    const LANES: usize = LANES;
    type M = M16;
    type B = U16;
    type D = D16;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm512_set1_ps(x)) }
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        let mut all = [0.0; LANES];
        for (lane, x) in all.iter_mut().enumerate() {
            *x = f(lane);
        }
        // SAFETY: called by tasks that run here alone; as many numbers as are read
        unsafe { Self(arch::_mm512_loadu_ps(all.as_ptr())) }
    }
    #[inline(always)]
    fn apart<P: Part<Self>>(part: P) -> P::Output {
        // SAFETY: called by tasks that run here alone
        unsafe { apart_here(part) }
    }
    #[inline(always)]
    fn load(from: &[f32], first: usize) -> Self {
        let from = &from[first..first + LANES];
        // SAFETY: called by tasks that run here alone; as many numbers as are read
        unsafe { Self(arch::_mm512_loadu_ps(from.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f32], first: usize) {
        let to = &mut to[first..first + LANES];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm512_storeu_ps(to.as_mut_ptr(), self.0) };
    }
    #[inline(always)]
    fn gather(from: &[f32], places: U16) -> Self {
        let last = from.len().wrapping_sub(1);
        assert!(last < 1 << 31, "none, or too many to gather from");
        // SAFETY: called by tasks that run here alone; no place beyond the last number
        unsafe {
            let places = arch::_mm512_min_epu32(places.0, arch::_mm512_set1_epi32(last as i32));
            Self(arch::_mm512_i32gather_ps::<4>(places, from.as_ptr()))
        }
    }
    #[inline(always)]
    fn order(mask: M16) -> U16 {
        // SAFETY: called by tasks that run here alone
        unsafe {
            let all = arch::_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            U16(arch::_mm512_maskz_compress_epi32(mask.0, all))
        }
    }
    #[inline(always)]
    fn ordered(self, order: U16) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_permutexvar_ps(order.0, self.0)) }
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.lanes()[lane]
    }
    #[inline(always)]
    fn lanes(self) -> [f32; MOST] {
        let mut all = [0.0; MOST];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm512_storeu_ps(all.as_mut_ptr(), self.0) };
        all
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::of_bits(Real::bits(self) & U16::splat(!(1 << 31)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_min_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_max_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn round(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(arch::_mm512_roundscale_ps::<
                { arch::_MM_FROUND_TO_NEAREST_INT | arch::_MM_FROUND_NO_EXC },
            >(self.0))
        }
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let bit = U16::splat(1 << 31);
        Self::of_bits(Real::bits(self.abs()) | (Real::bits(sign) & bit))
    }
    compare!(lt, _CMP_LT_OQ);
    compare!(le, _CMP_LE_OQ);
    compare!(eq, _CMP_EQ_OQ);
    #[inline(always)]
    fn select(mask: M16, a: Self, b: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_mask_blend_ps(mask.0, b.0, a.0)) }
    }
    #[inline(always)]
    fn bits(self) -> U16 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { U16(arch::_mm512_castps_si512(self.0)) }
    }
    #[inline(always)]
    fn of_bits(bits: U16) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_castsi512_ps(bits.0)) }
    }
    #[inline(always)]
    fn of_int(bits: U16) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm512_cvtepi32_ps(bits.0)) }
    }
    #[inline(always)]
    fn to_int(self) -> U16 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { U16(arch::_mm512_cvttps_epi32(self.0)) }
    }
    #[inline(always)]
    fn same(a: U16, b: U16) -> M16 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { M16(arch::_mm512_cmpeq_epi32_mask(a.0, b.0)) }
    }
}
