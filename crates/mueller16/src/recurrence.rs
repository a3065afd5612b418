//! The recurrence over modes, for several Gaussians side by side, and the sums of series over it.
//!
//! A recurrence along one axis, `g_(a+1,b)` from `g_ab`, loses digits where M is far from diagonal: in axes of its own
//! no step amplifies, in others the coupling `M₁₂` has to cancel what the steps along one axis make too large. By
//! Euler's theorem the sum of both, which is the same in all axes, needs no cancellation:
//!
//! ```text
//! n g_ab = √a (√2 z₁ g_(a−1,b) + …) + √b (√2 z₂ g_(a,b−1) + …)      n = a + b
//! u_ab   = √(2/n) (z₁ u_(a−1,b) + z₂ u_(a,b−1))
//!        + √((n−1)/n) (M₁₁ u_(a−2,b) + 2 M₁₂ u_(a−1,b−1) + M₂₂ u_(a,b−2)),      u_ab = √(n!/(a! b!)) g_ab
//! ```

use stokes::{HermiteSeries, Real};

/// Gaussians side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobes<T, const L: usize> {
    /// The recurrence's first number.
    pub(crate) start: [T; L],
    /// `z = V K φ`.
    pub(crate) z: [[T; L]; 2],
    /// `M₁₁, M₁₂, M₂₂`.
    pub(crate) m: [[T; L]; 3],
}

impl<T: Real, const L: usize> Default for Lobes<T, L> {
    #[inline(always)]
    fn default() -> Self {
        let zero = [T::zero(); L];
        Self {
            start: zero,
            z: [zero; 2],
            m: [zero; 3],
        }
    }
}

/// Series to be summed; one that is absent costs nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Modes<'a, const J: usize> {
    coefficients: [&'a [f64]; J],
    /// Orders of each, from 0 on: 0 for one that is absent.
    counts: [usize; J],
    /// 2 where odd orders vanish, else 1.
    strides: [usize; J],
    /// The largest of the counts, at least 1.
    count: usize,
}

impl<'a, const J: usize> Modes<'a, J> {
    #[inline]
    pub(crate) fn new(series: [Option<&'a HermiteSeries>; J]) -> Self {
        let counts = series.map(|s| s.map_or(0, |s| s.order() + 1));
        Self {
            coefficients: series.map(|s| s.map_or(&[][..], HermiteSeries::real_coefficients)),
            counts,
            strides: series.map(|s| s.map_or(1, |s| 2 - usize::from(s.has_odd_orders()))),
            count: counts.into_iter().max().unwrap_or(0).max(1),
        }
    }

    /// Highest order of any.
    #[inline]
    pub(crate) fn order(&self) -> usize {
        self.count - 1
    }

    /// `s_00 g_00` for each series.
    #[inline(always)]
    pub(crate) fn fundamental<T: Real, const L: usize>(&self, lobes: &Lobes<T, L>) -> [[T; L]; J] {
        self.coefficients.map(|s| {
            let s = T::from_f64(s.first().copied().unwrap_or(0.0));
            lobes.start.map(|g| s * g)
        })
    }

    /// `Σ s_ab g_ab` for each series; 0 for one that is absent.
    ///
    /// Without `ACROSS`, which is for `M₁₂ = 0`, its term is left out. In f64 the error, that of the lobe included, is
    /// at most `32 (order + 1) ε` of `Σ|s_ab|` times `g_00` at the centre of the lobe (`tests/stability.rs`), in f32
    /// 2e-5 of it up to order 64. No allocation. What is absent or shorter, or lies in another lane, changes no bit of
    /// a sum.
    #[inline]
    pub(crate) fn contract<T: Real, const L: usize, const ACROSS: bool>(
        &self,
        lobes: &Lobes<T, L>,
    ) -> [[T; L]; J] {
        match self.count {
            0..=2 => self.sized::<T, L, ACROSS, 4>(lobes),
            3 => self.sized::<T, L, ACROSS, 5>(lobes),
            4 => self.sized::<T, L, ACROSS, 6>(lobes),
            5 => self.sized::<T, L, ACROSS, 7>(lobes),
            6..=17 => self.sized::<T, L, ACROSS, 19>(lobes),
            18..=65 => self.sized::<T, L, ACROSS, 67>(lobes),
            _ => self.sized::<T, L, ACROSS, { stokes::MAX_ORDER + 3 }>(lobes),
        }
    }

    /// `SIZE` is two more than the largest count.
    #[inline]
    fn sized<T: Real, const L: usize, const ACROSS: bool, const SIZE: usize>(
        &self,
        lobes: &Lobes<T, L>,
    ) -> [[T; L]; J] {
        let steps = T::steps();
        // known to the compiler where it is small
        let count = if SIZE <= 7 {
            SIZE - 2
        } else {
            self.count.min(SIZE - 2)
        };
        let ([z1, z2], [m11, m12, m22]) = (lobes.z, lobes.m);
        // two degrees in turn: (a, b) at the place b + 2, zeros around
        let mut degrees = [[[T::zero(); L]; SIZE]; 2];
        let [now, before] = &mut degrees;
        let (mut now, mut before) = (now, before);
        now[2] = lobes.start;
        let mut sums = [[T::zero(); L]; J];
        self.add_degree(0, now, &mut sums);
        for n in 1..count {
            let [up, down] = steps[n - 1];
            let along = [z1.map(|z| up * z), z2.map(|z| up * z)];
            let back = [m11.map(|m| down * m), m22.map(|m| down * m)];
            let across = m12.map(|m| (down + down) * m);
            for b in (0..=n).rev() {
                // all lanes are read before one is written, so that they are one vector
                let (g, left) = (now[b + 2], now[b + 1]);
                let [last, skew, far] = [before[b + 2], before[b + 1], before[b]];
                before[b + 2] = std::array::from_fn(|l| {
                    let forth = along[0][l] * g[l] + along[1][l] * left[l];
                    let back = back[0][l] * last[l] + back[1][l] * far[l];
                    if ACROSS {
                        forth + (back + across[l] * skew[l])
                    } else {
                        forth + back
                    }
                });
            }
            std::mem::swap(&mut now, &mut before);
            self.add_degree(n, now, &mut sums);
        }
        sums
    }

    /// Adds `Σ s_ab g_ab` over the modes of degree n.
    #[inline(always)]
    fn add_degree<T: Real, const L: usize, const SIZE: usize>(
        &self,
        n: usize,
        u: &[[T; L]; SIZE],
        sums: &mut [[T; L]; J],
    ) {
        let first = stokes::mode_index(n, 0);
        let mut long = [0.0; SIZE];
        let weights = if SIZE - 3 <= TABLED || n <= TABLED {
            &WEIGHTS[first..=first + n]
        } else {
            weights_into(n, &mut long)
        };
        for (j, sum) in sums.iter_mut().enumerate() {
            if n >= self.counts[j] || n & (self.strides[j] - 1) != 0 {
                continue;
            }
            let s = &self.coefficients[j][first..=first + n];
            let mut part = [T::zero(); L];
            for ((s, weight), u) in s.iter().zip(weights).zip(&u[2..]) {
                let s = T::from_f64(s * weight);
                for l in 0..L {
                    part[l] += s * u[l];
                }
            }
            for l in 0..L {
                sum[l] += part[l];
            }
        }
    }
}

/// Highest degree of [`WEIGHTS`].
const TABLED: usize = 64;

/// `√(a! b!/n!)` of the modes to degree 64, good to 1 ε: `C(64, 32)` has 61 bits.
static WEIGHTS: [f64; stokes::mode_count(TABLED)] = {
    let mut weights = [1.0; stokes::mode_count(TABLED)];
    let mut n = 1;
    while n <= TABLED {
        let (mut b, mut binomial) = (0, 1_u128);
        while b <= n {
            let shift = binomial.leading_zeros() & !1;
            let root = (binomial << shift).isqrt() as f64 / (1_u64 << (shift / 2)) as f64;
            weights[stokes::mode_index(n - b, b)] = 1.0 / root;
            binomial = binomial * (n - b) as u128 / (b + 1) as u128;
            b += 1;
        }
        n += 1;
    }
    weights
};

/// The same for any degree: from both ends, each of at most n/2 steps off by 2 ε.
#[inline(never)]
fn weights_into(n: usize, weights: &mut [f64]) -> &[f64] {
    let mut weight = 1.0;
    for b in 0..=n / 2 {
        (weights[b], weights[n - b]) = (weight, weight);
        weight *= ((b + 1) as f64 / (n - b) as f64).sqrt();
    }
    &weights[..=n]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(order: usize) -> HermiteSeries {
        let long: Vec<_> = (0..stokes::mode_count(order))
            .map(|i| (i as f64 + 0.3).sin())
            .collect();
        HermiteSeries::from_real_coefficients(&long).unwrap()
    }

    /// Lanes of different lobes; `across` is M₁₂.
    fn lobes(across: f64) -> Lobes<f64, 4> {
        Lobes {
            start: [0.7, 0.01, 0.3, 1e-9],
            z: [[0.4, -2.0, 0.0, 5.0], [1.1, 0.3, -0.2, 3.0]],
            m: [[0.3, -0.9, 0.0, -1.0], [across; 4], [-0.5, 0.2, 0.85, -1.0]],
        }
    }

    fn lane(lobes: &Lobes<f64, 4>, l: usize) -> Lobes<f64, 1> {
        Lobes {
            start: [lobes.start[l]],
            z: lobes.z.map(|z| [z[l]]),
            m: lobes.m.map(|m| [m[l]]),
        }
    }

    const ORDERS: [usize; 12] = [0, 1, 2, 3, 4, 5, 16, 17, 33, 64, 65, 256];

    #[test]
    fn lanes_and_series_do_not_touch_each_other() {
        let lobes = lobes(0.1);
        for order in ORDERS {
            let long = series(order);
            let (short, _) = long.truncated(order / 2);
            let together =
                Modes::new([Some(&long), None, Some(&short)]).contract::<_, _, true>(&lobes);
            for l in 0..4 {
                let alone =
                    |s| Modes::new([Some(s)]).contract::<_, _, true>(&lane(&lobes, l))[0][0];
                let found = together.map(|sums| sums[l]);
                assert_eq!(found, [alone(&long), 0.0, alone(&short)], "{order} {l}");
            }
        }
    }

    #[test]
    fn axes_apart_are_the_general_case_without_its_cross_term() {
        let lobes = lobes(0.0);
        for order in ORDERS {
            let series = series(order);
            let modes = Modes::new([Some(&series)]);
            let [apart] = modes.contract::<_, _, false>(&lobes);
            let [general] = modes.contract::<_, _, true>(&lobes);
            for l in 0..4 {
                // 1 of the modes is at most e^(|z|²/2) times the start; every one of `order` steps rounds four times
                let most =
                    lobes.start[l] * (0.5 * (lobes.z[0][l].powi(2) + lobes.z[1][l].powi(2))).exp();
                let count = stokes::mode_count(order) as f64;
                let limit = 4.0 * (order + 1) as f64 * f64::EPSILON * most * count;
                let error = (apart[l] - general[l]).abs();
                assert!(error <= limit, "{order} {l}: {error:e}, limit {limit:e}");
            }
        }
    }

    #[test]
    fn odd_orders_that_vanish_are_skipped_without_a_trace() {
        for order in ORDERS {
            let mut even = series(order).real_coefficients().to_vec();
            for (s, (a, b)) in even.iter_mut().zip(stokes::modes(order)) {
                *s *= f64::from((a + b) % 2 == 0);
            }
            let even = HermiteSeries::from_real_coefficients(&even).unwrap();
            let skipping = Modes::new([Some(&even)]);
            assert_eq!(skipping.strides, [2]);
            let all = Modes {
                strides: [1],
                ..skipping
            };
            let lobes = lobes(0.1);
            assert_eq!(
                skipping.contract::<_, _, true>(&lobes),
                all.contract::<_, _, true>(&lobes)
            );
        }
    }
}
