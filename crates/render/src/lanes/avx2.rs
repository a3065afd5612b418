//! Eight lanes: AVX2, which is looked for at run time.
//!
//! One of the files of the program with `unsafe`, beside `avx512.rs` and `geometry/simd.rs`, which traces single rays.
#![expect(
    unsafe_code,
    reason = "intrinsics are sound where the processor has them: numbers of these types are made in `run` alone, after they were found"
)]

use std::arch::x86_64 as arch;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};
use std::sync::OnceLock;

use super::{Bits, Double, MOST, Mask, Part, Real, Task};

const LANES: usize = 8;

/// Whether the processor has AVX2 and the environment does not forbid it.
pub(super) fn is_there() -> bool {
    static THERE: OnceLock<bool> = OnceLock::new();
    *THERE.get_or_init(|| {
        !super::wished_for(&["portable"])
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

#[target_feature(enable = "avx2,bmi1,bmi2")]
fn run_here<T: Task>(task: T) -> T::Output {
    task.run::<F8>()
}

#[target_feature(enable = "avx2,bmi1,bmi2")]
#[inline(never)]
fn apart_here<P: Part<F8>>(part: P) -> P::Output {
    part.run()
}

/// Eight numbers in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct F8(arch::__m256);

/// Eight numbers of 32 bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct U8(arch::__m256i);

/// Eight answers: all bits of a lane set, or none.
#[derive(Clone, Copy, Debug)]
pub(super) struct M8(arch::__m256);

/// Eight numbers in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct D8(arch::__m256d, arch::__m256d);

/// For each set of lanes the order in which they come first.
static ORDERS: [[u32; LANES]; 1 << LANES] = orders();

const fn orders() -> [[u32; LANES]; 1 << LANES] {
    let mut all = [[0; LANES]; 1 << LANES];
    let mut set = 0;
    while set < all.len() {
        let (mut lane, mut place) = (0, 0);
        while lane < LANES {
            if set >> lane & 1 == 1 {
                all[set][place] = lane as u32;
                place += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    all
}

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

operator!(F8, Add, add, _mm256_add_ps);
operator!(F8, Sub, sub, _mm256_sub_ps);
operator!(F8, Mul, mul, _mm256_mul_ps);
operator!(F8, Div, div, _mm256_div_ps);
operator!(U8, Add, add, _mm256_add_epi32);
operator!(U8, Sub, sub, _mm256_sub_epi32);
operator!(U8, Mul, mul, _mm256_mullo_epi32);
operator!(U8, BitAnd, bitand, _mm256_and_si256);
operator!(U8, BitOr, bitor, _mm256_or_si256);
operator!(U8, BitXor, bitxor, _mm256_xor_si256);
operator!(M8, BitAnd, bitand, _mm256_and_ps);
operator!(M8, BitOr, bitor, _mm256_or_ps);

/// The same on both halves.
macro_rules! halves {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for D8 {
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

halves!(Add, add, _mm256_add_pd);
halves!(Sub, sub, _mm256_sub_pd);
halves!(Mul, mul, _mm256_mul_pd);
halves!(Div, div, _mm256_div_pd);

impl Neg for F8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_xor_ps(self.0, arch::_mm256_set1_ps(-0.0))) }
    }
}

impl Neg for D8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let sign = arch::_mm256_set1_pd(-0.0);
            Self(
                arch::_mm256_xor_pd(self.0, sign),
                arch::_mm256_xor_pd(self.1, sign),
            )
        }
    }
}

impl Not for M8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let all = arch::_mm256_castsi256_ps(arch::_mm256_set1_epi32(-1));
            Self(arch::_mm256_xor_ps(self.0, all))
        }
    }
}

impl Mask for M8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { arch::_mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe {
            let lane = arch::_mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = arch::_mm256_and_si256(arch::_mm256_set1_epi32(bits as i32), lane);
            Self(arch::_mm256_castsi256_ps(arch::_mm256_cmpeq_epi32(
                set, lane,
            )))
        }
    }
}

impl Bits for U8 {
    #[inline(always)]
    fn splat(x: u32) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm256_set1_epi32(x as i32)) }
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
        let mut all = [0u32; LANES];
        for (lane, x) in all.iter_mut().enumerate() {
            *x = f(lane);
        }
        // SAFETY: called by tasks that run here alone; as many numbers as are read
        unsafe { Self(arch::_mm256_loadu_si256(all.as_ptr().cast())) }
    }
    #[inline(always)]
    fn lanes(self) -> [u32; MOST] {
        let mut all = [0; MOST];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm256_storeu_si256(all.as_mut_ptr().cast(), self.0) };
        all
    }
    #[inline(always)]
    fn shl<const N: i32>(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_slli_epi32::<N>(self.0)) }
    }
    #[inline(always)]
    fn shr<const N: i32>(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_srli_epi32::<N>(self.0)) }
    }
}

impl Double for D8 {
    type Single = F8;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm256_set1_pd(x), arch::_mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn wide(x: F8) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(
                arch::_mm256_cvtps_pd(arch::_mm256_castps256_ps128(x.0)),
                arch::_mm256_cvtps_pd(arch::_mm256_extractf128_ps::<1>(x.0)),
            )
        }
    }
    #[inline(always)]
    fn narrow(self) -> F8 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let (low, high) = (arch::_mm256_cvtpd_ps(self.0), arch::_mm256_cvtpd_ps(self.1));
            F8(arch::_mm256_set_m128(high, low))
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_sqrt_pd(self.0), arch::_mm256_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(
                arch::_mm256_max_pd(self.0, other.0),
                arch::_mm256_max_pd(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(
                arch::_mm256_min_pd(self.0, other.0),
                arch::_mm256_min_pd(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn is_negative(self) -> M8 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let zero = arch::_mm256_setzero_pd();
            let low = arch::_mm256_cmp_pd::<{ arch::_CMP_LT_OQ }>(self.0, zero);
            let high = arch::_mm256_cmp_pd::<{ arch::_CMP_LT_OQ }>(self.1, zero);
            let (low, high) = (
                arch::_mm256_movemask_pd(low),
                arch::_mm256_movemask_pd(high),
            );
            M8::from_bits((low | high << 4) as u32)
        }
    }
}

/// A question to two numbers.
macro_rules! compare {
    ($method:ident, $predicate:ident) => {
        #[inline(always)]
        fn $method(self, other: Self) -> M8 {
            // SAFETY: values of this type exist only where the instructions do
            unsafe { M8(arch::_mm256_cmp_ps::<{ arch::$predicate }>(self.0, other.0)) }
        }
    };
}

impl Real for F8 {
    const LANES: usize = LANES;
    type M = M8;
    type B = U8;
    type D = D8;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: called by tasks that run here alone
        unsafe { Self(arch::_mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        let mut all = [0.0; LANES];
        for (lane, x) in all.iter_mut().enumerate() {
            *x = f(lane);
        }
        // SAFETY: called by tasks that run here alone; as many numbers as are read
        unsafe { Self(arch::_mm256_loadu_ps(all.as_ptr())) }
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
        unsafe { Self(arch::_mm256_loadu_ps(from.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f32], first: usize) {
        let to = &mut to[first..first + LANES];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm256_storeu_ps(to.as_mut_ptr(), self.0) };
    }
    #[inline(always)]
    fn gather(from: &[f32], places: U8) -> Self {
        let last = from.len().wrapping_sub(1);
        assert!(last < 1 << 31, "none, or too many to gather from");
        // SAFETY: called by tasks that run here alone; no place beyond the last number
        unsafe {
            let places = arch::_mm256_min_epu32(places.0, arch::_mm256_set1_epi32(last as i32));
            Self(arch::_mm256_i32gather_ps::<4>(from.as_ptr(), places))
        }
    }
    #[inline(always)]
    fn order(mask: M8) -> U8 {
        let order = &ORDERS[mask.bits() as usize % ORDERS.len()];
        // SAFETY: values of this type exist only where the instructions do; as many numbers as are read
        unsafe { U8(arch::_mm256_loadu_si256(order.as_ptr().cast())) }
    }
    #[inline(always)]
    fn ordered(self, order: U8) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_permutevar8x32_ps(self.0, order.0)) }
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.lanes()[lane]
    }
    #[inline(always)]
    fn lanes(self) -> [f32; MOST] {
        let mut all = [0.0; MOST];
        // SAFETY: values of this type exist only where the instructions do; room for as many numbers as are written
        unsafe { arch::_mm256_storeu_ps(all.as_mut_ptr(), self.0) };
        all
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_andnot_ps(arch::_mm256_set1_ps(-0.0), self.0)) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_min_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_max_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn round(self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            Self(arch::_mm256_round_ps::<
                { arch::_MM_FROUND_TO_NEAREST_INT | arch::_MM_FROUND_NO_EXC },
            >(self.0))
        }
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            let bit = arch::_mm256_set1_ps(-0.0);
            Self(arch::_mm256_or_ps(
                arch::_mm256_andnot_ps(bit, self.0),
                arch::_mm256_and_ps(bit, sign.0),
            ))
        }
    }
    compare!(lt, _CMP_LT_OQ);
    compare!(le, _CMP_LE_OQ);
    compare!(eq, _CMP_EQ_OQ);
    #[inline(always)]
    fn select(mask: M8, a: Self, b: Self) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_blendv_ps(b.0, a.0, mask.0)) }
    }
    #[inline(always)]
    fn bits(self) -> U8 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { U8(arch::_mm256_castps_si256(self.0)) }
    }
    #[inline(always)]
    fn of_bits(bits: U8) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_castsi256_ps(bits.0)) }
    }
    #[inline(always)]
    fn of_int(bits: U8) -> Self {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { Self(arch::_mm256_cvtepi32_ps(bits.0)) }
    }
    #[inline(always)]
    fn to_int(self) -> U8 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe { U8(arch::_mm256_cvttps_epi32(self.0)) }
    }
    #[inline(always)]
    fn same(a: U8, b: U8) -> M8 {
        // SAFETY: values of this type exist only where the instructions do
        unsafe {
            M8(arch::_mm256_castsi256_ps(arch::_mm256_cmpeq_epi32(
                a.0, b.0,
            )))
        }
    }
}
