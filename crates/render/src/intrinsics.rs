//! Everything in the program with `unsafe`: instructions that not every processor has, and memory in large pages.
//!
//! # Why it is sound
//!
//! *Instructions are used only where the processor has them.* [`present`] alone asks for them, and it alone makes the
//! permissions [`Avx2`] and `Avx512`. Whatever uses instructions either takes a permission, or is a function of the types
//! `F`, `U`, `M` and `D`, which have no name outside their module: other code meets them as the types of a [`Task`], which
//! `run` does where there is a permission. Comments call this *the rule*.
//!
//! *Memory is touched in few places.* What stands in tables (`operators!`, `inlined!`) takes registers and gives them back,
//! and no pointers; of all this only `order` reads memory, a row of the table `ORDERS`. Every pointer elsewhere comes from
//! an array or a slice, and the comment says why it is long enough.
//!
//! None of it changes a result. The twins in plain Rust are `lanes/one.rs` and, for single rays, `Portable` in
//! `geometry/lanes.rs`; operation by operation they give the same bits.
//!
//! [`present`]: x86::present
//! [`Avx2`]: x86::Avx2
//! [`Task`]: crate::lanes::Task
#![expect(unsafe_code, reason = "sound by what this page says")]

#[cfg(all(target_arch = "x86_64", test))]
pub(crate) use x86::present;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, found};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};
    use std::sync::OnceLock;

    use crate::geometry::lanes::{Lanes, Simd, Traversal};
    use crate::lanes::{Allowed, Bits, Double, MOST, Mask, Part, Real, Task};

    // ---- what the processor has ----

    /// The permission to use AVX2 and the bit manipulations that came with it.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct Avx2(());

    /// The permission to use AVX-512 as well.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct Avx512(());

    /// What the processor has.
    pub(crate) fn present() -> (Option<Avx2>, Option<Avx512>) {
        let avx2 = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        let avx512 = avx2 && is_x86_feature_detected!("avx512f");
        (avx2.then_some(Avx2(())), avx512.then_some(Avx512(())))
    }

    /// Of it what the environment allows. Asked once.
    pub(crate) fn found() -> (Option<Avx2>, Option<Avx512>) {
        static FOUND: OnceLock<(Option<Avx2>, Option<Avx512>)> = OnceLock::new();
        *FOUND.get_or_init(|| {
            let (avx2, avx512) = present();
            match Allowed::by_environment().unwrap_or_default() {
                Allowed::All => (avx2, avx512),
                Allowed::Avx2 => (avx2, None),
                Allowed::Portable => (None, None),
            }
        })
    }

    // ---- functions that are compiled for these instructions, with all that is inlined into them ----

    impl Avx2 {
        /// Does a task with eight lanes.
        pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
            // SAFETY: the rule; `self` is the permission
            unsafe { eight::run(task) }
        }

        /// Traces rays.
        #[inline]
        pub(crate) fn trace<T: Traversal>(self, traversal: T) -> T::Output {
            #[target_feature(enable = "avx2,bmi1,bmi2")]
            fn here<T: Traversal>(avx2: Avx2, traversal: T) -> T::Output {
                traversal.run(avx2)
            }
            // SAFETY: the rule; `self` is the permission
            unsafe { here(self, traversal) }
        }
    }

    impl Avx512 {
        /// Does a task with sixteen lanes.
        pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
            // SAFETY: the rule; `self` is the permission
            unsafe { sixteen::run(task) }
        }
    }

    // ---- tables of operations on registers ----

    /// Methods that are instructions on registers.
    macro_rules! inlined {
        ($(fn $name:ident $(<const $n:ident: i32>)? ($($arguments:tt)*) -> $out:ty = $body:expr;)*) => {$(
            #[inline(always)]
            fn $name $(<const $n: i32>)? ($($arguments)*) -> $out {
                // SAFETY: the rule; no pointer is taken
                unsafe { $body }
            }
        )*};
    }

    /// Operators that are instructions on registers.
    macro_rules! operators {
        ($($trait:ident for $type:ident: $method:ident($self:ident $(, $other:ident)?) = $body:expr;)*) => {$(
            impl $trait for $type {
                type Output = Self;
                inlined! { fn $method($self $(, $other: Self)?) -> Self = $body; }
            }
        )*};
    }

    // ---- paths side by side ----

    /// The types of so many lanes, out of what the module around calls its registers and instructions.
    macro_rules! lanes {
        ($lanes:literal, $features:literal) => {
            const LANES: usize = $lanes;

            #[target_feature(enable = $features)]
            pub(super) fn run<T: Task>(task: T) -> T::Output {
                task.run::<F>()
            }

            #[target_feature(enable = $features)]
            #[inline(never)]
            fn apart<P: Part<F>>(part: P) -> P::Output {
                part.run()
            }

            /// Numbers in single precision.
            #[derive(Clone, Copy, Debug)]
            struct F(Singles);

            /// Numbers of 32 bits.
            #[derive(Clone, Copy, Debug)]
            struct U(Words);

            /// Answers.
            #[derive(Clone, Copy, Debug)]
            struct M(Answers);

            /// Numbers in double precision.
            #[derive(Clone, Copy, Debug)]
            struct D(Doubles, Doubles);

            operators! {
                Add for F: add(self, other) = Self(add_ps(self.0, other.0));
                Sub for F: sub(self, other) = Self(sub_ps(self.0, other.0));
                Mul for F: mul(self, other) = Self(mul_ps(self.0, other.0));
                Div for F: div(self, other) = Self(div_ps(self.0, other.0));
                Add for U: add(self, other) = Self(add_epi32(self.0, other.0));
                Sub for U: sub(self, other) = Self(sub_epi32(self.0, other.0));
                Mul for U: mul(self, other) = Self(mullo_epi32(self.0, other.0));
                BitAnd for U: bitand(self, other) = Self(and_si(self.0, other.0));
                BitOr for U: bitor(self, other) = Self(or_si(self.0, other.0));
                BitXor for U: bitxor(self, other) = Self(xor_si(self.0, other.0));
                BitAnd for M: bitand(self, other) = Self(and_answers(self.0, other.0));
                BitOr for M: bitor(self, other) = Self(or_answers(self.0, other.0));
                Not for M: not(self) = Self(not_answers(self.0));
                Add for D: add(self, other) = Self(add_pd(self.0, other.0), add_pd(self.1, other.1));
                Sub for D: sub(self, other) = Self(sub_pd(self.0, other.0), sub_pd(self.1, other.1));
                Mul for D: mul(self, other) = Self(mul_pd(self.0, other.0), mul_pd(self.1, other.1));
                Div for D: div(self, other) = Self(div_pd(self.0, other.0), div_pd(self.1, other.1));
                Neg for D: neg(self) = Self(neg_pd(self.0), neg_pd(self.1));
            }

            impl Neg for F {
                type Output = Self;
                #[inline(always)]
                fn neg(self) -> Self {
                    Self::of_bits(Real::bits(self) ^ U::splat(1 << 31))
                }
            }

            impl Mask for M {
                inlined! {
                    fn bits(self) -> u32 = bits_of_answers(self.0);
                    fn from_bits(bits: u32) -> Self = Self(answers_of_bits(bits));
                }
            }

            impl Bits for U {
                inlined! {
                    fn splat(x: u32) -> Self = Self(set1_epi32(x as i32));
                    fn shl<const N: i32>(self) -> Self = Self(sll_epi32(self.0, _mm_cvtsi32_si128(N)));
                    fn shr<const N: i32>(self) -> Self = Self(srl_epi32(self.0, _mm_cvtsi32_si128(N)));
                }
                #[inline(always)]
                fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
                    let mut all = [0u32; LANES];
                    for (lane, x) in all.iter_mut().enumerate() {
                        *x = f(lane);
                    }
                    // SAFETY: the rule; as many numbers as are read
                    unsafe { Self(loadu_si(all.as_ptr().cast())) }
                }
                #[inline(always)]
                fn lanes(self) -> [u32; MOST] {
                    let mut all = [0; MOST];
                    // SAFETY: the rule; room for at least as many numbers as are written
                    unsafe { storeu_si(all.as_mut_ptr().cast(), self.0) };
                    all
                }
            }

            impl Double for D {
                type Single = F;
                inlined! {
                    fn splat(x: f64) -> Self = Self(set1_pd(x), set1_pd(x));
                    fn wide(x: F) -> Self = Self(cvtps_pd(low(x.0)), cvtps_pd(high(x.0)));
                    fn narrow(self) -> F = F(both(cvtpd_ps(self.0), cvtpd_ps(self.1)));
                    fn sqrt(self) -> Self = Self(sqrt_pd(self.0), sqrt_pd(self.1));
                    fn max(self, other: Self) -> Self = Self(max_pd(self.0, other.0), max_pd(self.1, other.1));
                    fn min(self, other: Self) -> Self = Self(min_pd(self.0, other.0), min_pd(self.1, other.1));
                    fn is_negative(self) -> M =
                        M::from_bits(negative_pd(self.0) | negative_pd(self.1) << (LANES / 2));
                }
            }

            impl Real for F {
                const LANES: usize = LANES;
                type M = M;
                type B = U;
                type D = D;
                inlined! {
                    fn splat(x: f32) -> Self = Self(set1_ps(x));
                    fn order(mask: M) -> U = U(order_of_answers(mask.0));
                    fn ordered(self, order: U) -> Self = Self(permute_ps(order.0, self.0));
                    fn sqrt(self) -> Self = Self(sqrt_ps(self.0));
                    fn min(self, other: Self) -> Self = Self(min_ps(self.0, other.0));
                    fn max(self, other: Self) -> Self = Self(max_ps(self.0, other.0));
                    fn round(self) -> Self =
                        Self(round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0));
                    fn lt(self, other: Self) -> M = M(cmp_ps::<_CMP_LT_OQ>(self.0, other.0));
                    fn le(self, other: Self) -> M = M(cmp_ps::<_CMP_LE_OQ>(self.0, other.0));
                    fn eq(self, other: Self) -> M = M(cmp_ps::<_CMP_EQ_OQ>(self.0, other.0));
                    fn same(a: U, b: U) -> M = M(cmpeq_epi32(a.0, b.0));
                    fn select(mask: M, a: Self, b: Self) -> Self = Self(blend_ps(mask.0, b.0, a.0));
                    fn bits(self) -> U = U(castps_si(self.0));
                    fn of_bits(bits: U) -> Self = Self(castsi_ps(bits.0));
                    fn of_int(bits: U) -> Self = Self(cvtepi32_ps(bits.0));
                    fn to_int(self) -> U = U(cvttps_epi32(self.0));
                }
                #[inline(always)]
                fn abs(self) -> Self {
                    Self::of_bits(Real::bits(self) & U::splat(!(1 << 31)))
                }
                #[inline(always)]
                fn copysign(self, sign: Self) -> Self {
                    let sign = Real::bits(sign) & U::splat(1 << 31);
                    Self::of_bits(Real::bits(self.abs()) | sign)
                }
                #[inline(always)]
                fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
                    let mut all = [0.0; LANES];
                    for (lane, x) in all.iter_mut().enumerate() {
                        *x = f(lane);
                    }
                    Self::load(&all, 0)
                }
                #[inline(always)]
                fn lane(self, lane: usize) -> f32 {
                    self.lanes()[lane]
                }
                #[inline(always)]
                fn lanes(self) -> [f32; MOST] {
                    let mut all = [0.0; MOST];
                    self.store(&mut all, 0);
                    all
                }
                #[inline(always)]
                fn load(from: &[f32], first: usize) -> Self {
                    let from = &from[first..first + LANES];
                    // SAFETY: the rule; as many numbers as are read
                    unsafe { Self(loadu_ps(from.as_ptr())) }
                }
                #[inline(always)]
                fn store(self, to: &mut [f32], first: usize) {
                    let to = &mut to[first..first + LANES];
                    // SAFETY: the rule; room for as many numbers as are written
                    unsafe { storeu_ps(to.as_mut_ptr(), self.0) };
                }
                #[inline(always)]
                fn gather(from: &[f32], places: U) -> Self {
                    let last = from.len().wrapping_sub(1);
                    assert!(last < 1 << 31, "none, or too many to gather from");
                    // SAFETY: the rule; no place beyond the last number, where 4 is the size of one
                    unsafe {
                        let places = min_epu32(places.0, set1_epi32(last as i32));
                        Self(gather_ps::<4>(places, from.as_ptr()))
                    }
                }
                #[inline(always)]
                fn apart<P: Part<Self>>(part: P) -> P::Output {
                    // SAFETY: the rule
                    unsafe { apart(part) }
                }
            }
        };
    }

    // ---- single rays ----

    /// So many lanes for single rays, out of what the module around calls its registers and instructions.
    macro_rules! lanes_of_one_ray {
        ($lanes:literal) => {
            impl Lanes<$lanes> for Avx2 {
                type F = Singles;
                inlined! {
                    fn splat(self, x: f32) -> Singles = set1_ps(x);
                    fn add(self, a: Singles, b: Singles) -> Singles = add_ps(a, b);
                    fn sub(self, a: Singles, b: Singles) -> Singles = sub_ps(a, b);
                    fn mul(self, a: Singles, b: Singles) -> Singles = mul_ps(a, b);
                    fn div(self, a: Singles, b: Singles) -> Singles = div_ps(a, b);
                    fn min(self, a: Singles, b: Singles) -> Singles = min_ps(a, b);
                    fn max(self, a: Singles, b: Singles) -> Singles = max_ps(a, b);
                    fn select(self, signs: Singles, a: Singles, b: Singles) -> Singles = blendv_ps(b, a, signs);
                    fn signs(self, a: Singles) -> u32 = movemask_ps(a) as u32;
                    fn le(self, a: Singles, b: Singles) -> u32 = movemask_ps(cmp_ps::<_CMP_LE_OQ>(a, b)) as u32;
                    fn lt(self, a: Singles, b: Singles) -> u32 = movemask_ps(cmp_ps::<_CMP_LT_OQ>(a, b)) as u32;
                }
                #[inline(always)]
                fn load(self, from: &[f32; $lanes]) -> Singles {
                    // SAFETY: the rule; as many numbers as are read
                    unsafe { loadu_ps(from.as_ptr()) }
                }
                #[inline(always)]
                fn load_signs(self, from: &[u32; $lanes]) -> Singles {
                    // SAFETY: as above, and every pattern of 32 bits is an f32
                    unsafe { loadu_ps(from.as_ptr().cast()) }
                }
                #[inline(always)]
                fn store(self, a: Singles) -> [f32; $lanes] {
                    let mut to = [0.0; $lanes];
                    // SAFETY: the rule; room for as many numbers as are written
                    unsafe { storeu_ps(to.as_mut_ptr(), a) };
                    to
                }
            }
        };
    }

    impl Simd for Avx2 {
        #[inline(always)]
        fn prefetch<T>(self, at: &T) {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let at = std::ptr::from_ref(at).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(64) {
                // SAFETY: a hint, which reads nothing and may speak of any address
                unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(64 * line)) };
            }
        }
    }

    // ---- what the instructions are called; a function where there is no single one, or with other arguments ----

    /// Four lanes.
    mod four {
        use std::arch::x86_64::{
            __m128 as Singles, _CMP_LE_OQ, _CMP_LT_OQ, _mm_add_ps as add_ps,
            _mm_blendv_ps as blendv_ps, _mm_cmp_ps as cmp_ps, _mm_div_ps as div_ps,
            _mm_loadu_ps as loadu_ps, _mm_max_ps as max_ps, _mm_min_ps as min_ps,
            _mm_movemask_ps as movemask_ps, _mm_mul_ps as mul_ps, _mm_set1_ps as set1_ps,
            _mm_storeu_ps as storeu_ps, _mm_sub_ps as sub_ps,
        };

        use super::{Avx2, Lanes};

        lanes_of_one_ray!(4);
    }

    /// Eight lanes: AVX2.
    mod eight {
        use std::arch::x86_64::*;
        use std::arch::x86_64::{
            __m128 as Half, __m256 as Singles, __m256 as Answers, __m256d as Doubles,
            __m256i as Words, _mm256_add_epi32 as add_epi32, _mm256_add_pd as add_pd,
            _mm256_add_ps as add_ps, _mm256_and_ps as and_answers, _mm256_and_si256 as and_si,
            _mm256_blendv_ps as blendv_ps, _mm256_castps_si256 as castps_si,
            _mm256_castps256_ps128 as low, _mm256_castsi256_ps as castsi_ps,
            _mm256_cmp_ps as cmp_ps, _mm256_cvtepi32_ps as cvtepi32_ps,
            _mm256_cvtpd_ps as cvtpd_ps, _mm256_cvtps_pd as cvtps_pd,
            _mm256_cvttps_epi32 as cvttps_epi32, _mm256_div_pd as div_pd, _mm256_div_ps as div_ps,
            _mm256_loadu_ps as loadu_ps, _mm256_loadu_si256 as loadu_si, _mm256_max_pd as max_pd,
            _mm256_max_ps as max_ps, _mm256_min_epu32 as min_epu32, _mm256_min_pd as min_pd,
            _mm256_min_ps as min_ps, _mm256_movemask_ps as movemask_ps, _mm256_mul_pd as mul_pd,
            _mm256_mul_ps as mul_ps, _mm256_mullo_epi32 as mullo_epi32, _mm256_or_ps as or_answers,
            _mm256_or_si256 as or_si, _mm256_round_ps as round_ps, _mm256_set1_epi32 as set1_epi32,
            _mm256_set1_pd as set1_pd, _mm256_set1_ps as set1_ps, _mm256_sll_epi32 as sll_epi32,
            _mm256_sqrt_pd as sqrt_pd, _mm256_sqrt_ps as sqrt_ps, _mm256_srl_epi32 as srl_epi32,
            _mm256_storeu_ps as storeu_ps, _mm256_storeu_si256 as storeu_si,
            _mm256_sub_epi32 as sub_epi32, _mm256_sub_pd as sub_pd, _mm256_sub_ps as sub_ps,
            _mm256_xor_si256 as xor_si,
        };

        use super::*;

        // an answer is all bits of a lane, or none
        lanes!(8, "avx2,bmi1,bmi2");
        lanes_of_one_ray!(8);

        #[target_feature(enable = "avx2")]
        #[inline]
        fn not_answers(a: Answers) -> Answers {
            _mm256_xor_ps(a, castsi_ps(set1_epi32(-1)))
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn bits_of_answers(a: Answers) -> u32 {
            movemask_ps(a) as u32
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn answers_of_bits(bits: u32) -> Answers {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            cmpeq_epi32(and_si(set1_epi32(bits as i32), lane), lane)
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn cmpeq_epi32(a: Words, b: Words) -> Answers {
            castsi_ps(_mm256_cmpeq_epi32(a, b))
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn blend_ps(mask: Answers, a: Singles, b: Singles) -> Singles {
            blendv_ps(a, b, mask)
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn permute_ps(order: Words, a: Singles) -> Singles {
            _mm256_permutevar8x32_ps(a, order)
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        unsafe fn gather_ps<const SIZE: i32>(places: Words, from: *const f32) -> Singles {
            // SAFETY: the caller knows that no place is beyond the last number
            unsafe { _mm256_i32gather_ps::<SIZE>(from, places) }
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn order_of_answers(a: Answers) -> Words {
            let order = &ORDERS[bits_of_answers(a) as usize % ORDERS.len()];
            // SAFETY: as many numbers as are read
            unsafe { loadu_si(order.as_ptr().cast()) }
        }

        /// For each set of lanes the order in which they come first.
        static ORDERS: [[u32; LANES]; 1 << LANES] = {
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
        };

        #[target_feature(enable = "avx2")]
        #[inline]
        fn high(a: Singles) -> Half {
            _mm256_extractf128_ps::<1>(a)
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn both(low: Half, high: Half) -> Singles {
            _mm256_set_m128(high, low)
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn neg_pd(a: Doubles) -> Doubles {
            _mm256_xor_pd(a, set1_pd(-0.0))
        }

        #[target_feature(enable = "avx2")]
        #[inline]
        fn negative_pd(a: Doubles) -> u32 {
            let answers = _mm256_cmp_pd::<_CMP_LT_OQ>(a, _mm256_setzero_pd());
            _mm256_movemask_pd(answers) as u32
        }
    }

    /// Sixteen lanes: AVX-512.
    mod sixteen {
        use std::arch::x86_64::*;
        use std::arch::x86_64::{
            __m256 as Half, __m512 as Singles, __m512d as Doubles, __m512i as Words,
            __mmask16 as Answers, _cvtmask16_u32 as bits_of_answers,
            _cvtu32_mask16 as answers_of_bits, _kand_mask16 as and_answers,
            _knot_mask16 as not_answers, _kor_mask16 as or_answers, _mm512_add_epi32 as add_epi32,
            _mm512_add_pd as add_pd, _mm512_add_ps as add_ps, _mm512_and_si512 as and_si,
            _mm512_castps_si512 as castps_si, _mm512_castps512_ps256 as low,
            _mm512_castsi512_ps as castsi_ps, _mm512_cmp_ps_mask as cmp_ps,
            _mm512_cmpeq_epi32_mask as cmpeq_epi32, _mm512_cvtepi32_ps as cvtepi32_ps,
            _mm512_cvtpd_ps as cvtpd_ps, _mm512_cvtps_pd as cvtps_pd,
            _mm512_cvttps_epi32 as cvttps_epi32, _mm512_div_pd as div_pd, _mm512_div_ps as div_ps,
            _mm512_i32gather_ps as gather_ps, _mm512_loadu_ps as loadu_ps,
            _mm512_loadu_si512 as loadu_si, _mm512_mask_blend_ps as blend_ps,
            _mm512_max_pd as max_pd, _mm512_max_ps as max_ps, _mm512_min_epu32 as min_epu32,
            _mm512_min_pd as min_pd, _mm512_min_ps as min_ps, _mm512_mul_pd as mul_pd,
            _mm512_mul_ps as mul_ps, _mm512_mullo_epi32 as mullo_epi32, _mm512_or_si512 as or_si,
            _mm512_permutexvar_ps as permute_ps, _mm512_roundscale_ps as round_ps,
            _mm512_set1_epi32 as set1_epi32, _mm512_set1_pd as set1_pd, _mm512_set1_ps as set1_ps,
            _mm512_sll_epi32 as sll_epi32, _mm512_sqrt_pd as sqrt_pd, _mm512_sqrt_ps as sqrt_ps,
            _mm512_srl_epi32 as srl_epi32, _mm512_storeu_ps as storeu_ps,
            _mm512_storeu_si512 as storeu_si, _mm512_sub_epi32 as sub_epi32,
            _mm512_sub_pd as sub_pd, _mm512_sub_ps as sub_ps, _mm512_xor_si512 as xor_si,
        };

        use super::*;

        // an answer is a bit
        lanes!(16, "avx512f,avx2,bmi1,bmi2");

        #[target_feature(enable = "avx512f")]
        #[inline]
        fn order_of_answers(a: Answers) -> Words {
            let all = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            _mm512_maskz_compress_epi32(a, all)
        }

        #[target_feature(enable = "avx512f")]
        #[inline]
        fn high(a: Singles) -> Half {
            _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(a)))
        }

        #[target_feature(enable = "avx512f")]
        #[inline]
        fn both(low: Half, high: Half) -> Singles {
            let low = _mm512_castpd256_pd512(_mm256_castps_pd(low));
            _mm512_castpd_ps(_mm512_insertf64x4::<1>(low, _mm256_castps_pd(high)))
        }

        #[target_feature(enable = "avx512f")]
        #[inline]
        fn neg_pd(a: Doubles) -> Doubles {
            let sign = _mm512_castpd_si512(set1_pd(-0.0));
            _mm512_castsi512_pd(xor_si(_mm512_castpd_si512(a), sign))
        }

        #[target_feature(enable = "avx512f")]
        #[inline]
        fn negative_pd(a: Doubles) -> u32 {
            u32::from(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, _mm512_setzero_pd()))
        }
    }
}

/// So many equal elements, in memory of large pages where the system has them and the list is long: rays go astray less
/// often.
pub(crate) fn filled_in_large_pages<T: Copy>(element: T, count: usize) -> Vec<T> {
    let mut list: Vec<T> = Vec::with_capacity(count);
    #[cfg(target_os = "linux")]
    advise_large_pages(&list);
    list.resize(count, element);
    list
}

/// Asks for large pages where a list has room for its elements.
#[cfg(target_os = "linux")]
fn advise_large_pages<T>(list: &Vec<T>) {
    const LARGE: usize = 2 << 20;
    const MADV_HUGEPAGE: i32 = 14;
    // SAFETY: the signature of POSIX systems' C library, which the standard library links on Linux
    unsafe extern "C" {
        fn madvise(address: *mut std::ffi::c_void, length: usize, advice: i32) -> i32;
    }
    let bytes = list.capacity() * size_of::<T>();
    if bytes >= 2 * LARGE {
        let begin = (list.as_ptr() as usize).next_multiple_of(LARGE);
        let length = (list.as_ptr() as usize + bytes - begin) / LARGE * LARGE;
        // SAFETY: whole pages within memory that the list owns; the advice neither reads nor changes what is in them,
        // and where it is refused nothing is lost
        unsafe { madvise(begin as *mut _, length, MADV_HUGEPAGE) };
    }
}
