//! Instructions of particular processors and systems: AVX2, chosen at run time, and memory in large pages.
//!
//! One of the files of the program with `unsafe`; the others are `lanes/avx2.rs` and `lanes/avx512.rs`. What it does for
//! speed changes no result: the portable twin of [`Avx2`] is `Portable`, operation by operation.
#![expect(
    unsafe_code,
    reason = "intrinsics are sound where the processor has them: each block says how that is known"
)]

use super::bvh::Bvh;
use super::lanes::Portable;
#[cfg(target_arch = "x86_64")]
use super::lanes::{Lanes, Simd};
use super::ray::{Hit, Ray};
use super::walk::walk;

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
    /// The best that this processor has, or the portable ones where the environment says `BREWSTER_SIMD=portable`.
    pub(super) fn choose() -> Self {
        if std::env::var_os("BREWSTER_SIMD").is_some_and(|wish| wish == "portable") {
            return Self::Portable;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::detect() {
            return Self::Avx2(avx2);
        }
        Self::Portable
    }

    /// Visits what the ray may hit.
    #[inline]
    pub(super) fn walk<const ANY: bool>(
        self,
        bvh: &Bvh,
        ray: &Ray,
        stack: &mut [u64],
        shape: impl Fn(u32, f32) -> Option<(f32, f32, f32)>,
    ) -> Option<Hit> {
        match self {
            Self::Portable => walk_portable::<ANY>(bvh, ray, stack, shape),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => {
                // SAFETY: a value of `Avx2` exists only where `detect` has found these instructions
                unsafe { walk_avx2::<ANY>(avx2, bvh, ray, stack, shape) }
            }
        }
    }
}

/// The whole traversal with portable instructions, out of the way of scenes of one shape.
#[inline(never)]
fn walk_portable<const ANY: bool>(
    bvh: &Bvh,
    ray: &Ray,
    stack: &mut [u64],
    shape: impl Fn(u32, f32) -> Option<(f32, f32, f32)>,
) -> Option<Hit> {
    walk::<_, ANY>(Portable, bvh, ray, stack, shape)
}

/// The permission to use AVX2 and the bit manipulations that came with it.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// Some only where the processor has the instructions: the one place that makes a value.
    fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        found.then_some(Self(()))
    }
}

/// The whole traversal with these instructions, so that everything in it is inlined.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn walk_avx2<const ANY: bool>(
    avx2: Avx2,
    bvh: &Bvh,
    ray: &Ray,
    stack: &mut [u64],
    shape: impl Fn(u32, f32) -> Option<(f32, f32, f32)>,
) -> Option<Hit> {
    walk::<_, ANY>(avx2, bvh, ray, stack, shape)
}

/// Lanes out of intrinsics that differ only in their prefix.
#[cfg(target_arch = "x86_64")]
macro_rules! lanes {
    ($n:literal, $register:ident, $load:ident, $store:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident,
     $div:ident, $min:ident, $max:ident, $blend:ident, $mask:ident, $compare:ident) => {
        impl Lanes<$n> for Avx2 {
            type F = arch::$register;

            #[inline(always)]
            fn load(self, from: &[f32; $n]) -> Self::F {
                // SAFETY: `self` proves AVX2; the array has as many numbers as are read, alignment is not asked for
                unsafe { arch::$load(from.as_ptr()) }
            }

            #[inline(always)]
            fn load_signs(self, from: &[u32; $n]) -> Self::F {
                // SAFETY: as above, and every pattern of 32 bits is an f32
                unsafe { arch::$load(from.as_ptr().cast()) }
            }

            #[inline(always)]
            fn splat(self, x: f32) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$splat(x) }
            }

            #[inline(always)]
            fn store(self, a: Self::F) -> [f32; $n] {
                let mut to = [0.0; $n];
                // SAFETY: `self` proves AVX2; the array has room for as many numbers as are written
                unsafe { arch::$store(to.as_mut_ptr(), a) };
                to
            }

            #[inline(always)]
            fn add(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$add(a, b) }
            }

            #[inline(always)]
            fn sub(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$sub(a, b) }
            }

            #[inline(always)]
            fn mul(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$mul(a, b) }
            }

            #[inline(always)]
            fn div(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$div(a, b) }
            }

            #[inline(always)]
            fn min(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$min(a, b) }
            }

            #[inline(always)]
            fn max(self, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$max(a, b) }
            }

            #[inline(always)]
            fn select(self, signs: Self::F, a: Self::F, b: Self::F) -> Self::F {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$blend(b, a, signs) }
            }

            #[inline(always)]
            fn signs(self, a: Self::F) -> u32 {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$mask(a) as u32 }
            }

            #[inline(always)]
            fn le(self, a: Self::F, b: Self::F) -> u32 {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$mask(arch::$compare::<{ arch::_CMP_LE_OQ }>(a, b)) as u32 }
            }

            #[inline(always)]
            fn lt(self, a: Self::F, b: Self::F) -> u32 {
                // SAFETY: `self` proves AVX2
                unsafe { arch::$mask(arch::$compare::<{ arch::_CMP_LT_OQ }>(a, b)) as u32 }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64 as arch;

#[cfg(target_arch = "x86_64")]
lanes!(
    8,
    __m256,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_set1_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_blendv_ps,
    _mm256_movemask_ps,
    _mm256_cmp_ps
);
#[cfg(target_arch = "x86_64")]
lanes!(
    4,
    __m128,
    _mm_loadu_ps,
    _mm_storeu_ps,
    _mm_set1_ps,
    _mm_add_ps,
    _mm_sub_ps,
    _mm_mul_ps,
    _mm_div_ps,
    _mm_min_ps,
    _mm_max_ps,
    _mm_blendv_ps,
    _mm_movemask_ps,
    _mm_cmp_ps
);

#[cfg(target_arch = "x86_64")]
impl Simd for Avx2 {
    #[inline(always)]
    fn prefetch<T>(self, at: &T) {
        let lines = size_of::<T>().div_ceil(64);
        for line in 0..lines {
            // SAFETY: a hint, which reads nothing; the address lies within what `at` refers to
            unsafe {
                let address = std::ptr::from_ref(at).cast::<i8>().add(64 * line);
                arch::_mm_prefetch::<{ arch::_MM_HINT_T0 }>(address);
            }
        }
    }
}

/// So many equal elements, in memory of large pages where the system has them and the list is long: rays go astray less
/// often.
pub(super) fn filled_in_large_pages<T: Copy>(element: T, count: usize) -> Vec<T> {
    let mut list: Vec<T> = Vec::with_capacity(count);
    #[cfg(target_os = "linux")]
    {
        const LARGE: usize = 2 << 20;
        let bytes = count * size_of::<T>();
        if bytes >= 2 * LARGE {
            let begin = (list.as_ptr() as usize).next_multiple_of(LARGE);
            let end = list.as_ptr() as usize + bytes;
            // SAFETY: whole pages within memory that `list` owns; the advice neither reads nor changes what is in
            // them, and where it is refused nothing is lost
            unsafe {
                madvise(
                    begin as *mut _,
                    (end - begin) / LARGE * LARGE,
                    MADV_HUGEPAGE,
                )
            };
        }
    }
    list.resize(count, element);
    list
}

#[cfg(target_os = "linux")]
const MADV_HUGEPAGE: i32 = 14;

#[cfg(target_os = "linux")]
// SAFETY: the signature of POSIX systems' C library, which the standard library links on Linux
unsafe extern "C" {
    fn madvise(address: *mut std::ffi::c_void, length: usize, advice: i32) -> i32;
}
