//! The recurrence over modes, for several Gaussians side by side, and the sums of series over it.

use std::f64::consts::FRAC_1_SQRT_2;
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
    /// Without `ACROSS`, which is for `M₁₂ = 0`, `g_ab = g_a0 g_0b/g_00`. In f64 the error, that of the lobe included,
    /// is at most `32 (order + 1) ε` of `Σ|s_ab|` times `g_00` at the centre of the lobe (`tests/stability.rs`), in f32
    /// 2e-5 of it up to order 64. No allocation. What is absent or shorter, or lies in another lane, changes no bit of
    /// a sum.
    #[inline]
    pub(crate) fn contract<T: Real, const L: usize, const ACROSS: bool>(
        &self,
        lobes: &Lobes<T, L>,
    ) -> [[T; L]; J] {
        match self.count {
            0..=2 => self.sized::<T, L, ACROSS, 2>(lobes),
            3 => self.sized::<T, L, ACROSS, 3>(lobes),
            4 => self.sized::<T, L, ACROSS, 4>(lobes),
            5 => self.sized::<T, L, ACROSS, 5>(lobes),
            6..=17 => self.sized::<T, L, ACROSS, 17>(lobes),
            18..=65 => self.sized::<T, L, ACROSS, 65>(lobes),
            _ => self.sized::<T, L, ACROSS, { stokes::MAX_ORDER + 1 }>(lobes),
        }
    }

    #[inline]
    fn sized<T: Real, const L: usize, const ACROSS: bool, const SIZE: usize>(
        &self,
        lobes: &Lobes<T, L>,
    ) -> [[T; L]; J] {
        let steps = T::steps();
        // known to the compiler where it is small
        let count = if SIZE <= 5 {
            SIZE
        } else {
            self.count.min(SIZE)
        };
        let [z1, z2] = lobes.z;
        let [m11, m12, m22] = lobes.m;
        // row b = 0, and the row before it, which is nothing
        let mut rows = [[[T::zero(); L]; SIZE]; 2];
        let [row, before] = &mut rows;
        let (mut row, mut before) = (row, before);
        row[0] = lobes.start;
        let mut last = [T::zero(); L];
        for a in 1..count {
            let [up, down] = steps[a - 1];
            let now = row[a - 1];
            for l in 0..L {
                row[a][l] = up * z1[l] * now[l] + m11[l] * down * last[l];
            }
            last = now;
        }
        let mut sums = [[T::zero(); L]; J];
        // row b over row 0, where they are multiples
        let (mut multiple, mut earlier) = ([T::one(); L], [T::zero(); L]);
        for b in 0..count {
            for (j, sum) in sums.iter_mut().enumerate() {
                let along = self.along(j, b, row);
                for l in 0..L {
                    sum[l] += if ACROSS {
                        along[l]
                    } else {
                        along[l] * multiple[l]
                    };
                }
            }
            let Some([up, down]) = steps.get(b).filter(|_| b + 1 < count).copied() else {
                break;
            };
            let (along, back) = (z2.map(|z| up * z), m22.map(|m| m * down));
            if !ACROSS {
                for l in 0..L {
                    let next = along[l] * multiple[l] + back[l] * earlier[l];
                    (earlier[l], multiple[l]) = (multiple[l], next);
                }
                continue;
            }
            let across = m12.map(|m| m * (up * T::from_f64(FRAC_1_SQRT_2)));
            let mut left = [T::zero(); L];
            for a in 0..count - b - 1 {
                let root = T::from_f64(ROOTS[a]);
                let now = row[a];
                for l in 0..L {
                    before[a][l] =
                        along[l] * now[l] + back[l] * before[a][l] + across[l] * (root * left[l]);
                }
                left = now;
            }
            std::mem::swap(&mut row, &mut before);
        }
        sums
    }

    /// `Σ_a s_ab g_a` of series j over a row.
    #[inline(always)]
    fn along<T: Real, const L: usize>(&self, j: usize, b: usize, row: &[[T; L]]) -> [T; L] {
        let (s, stride) = (self.coefficients[j], self.strides[j]);
        let mut sum = [T::zero(); L];
        let end = self.counts[j].saturating_sub(b).min(row.len());
        let mut a = b & (stride - 1);
        while a < end {
            let s = T::from_f64(s[stokes::mode_index(a, b)]);
            for l in 0..L {
                sum[l] += s * row[a][l];
            }
            a += stride;
        }
        sum
    }
}

/// `√0 … √256`.
static ROOTS: [f64; stokes::MAX_ORDER + 1] = {
    let (mut roots, mut n) = ([0.0; stokes::MAX_ORDER + 1], 0);
    while n < roots.len() {
        roots[n] = ((n as u128) << 118).isqrt() as f64 / (1_u64 << 59) as f64;
        n += 1;
    }
    roots
};

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
