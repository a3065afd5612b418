//! Heights sampled over one cell of a grating, and their orders by the discrete Fourier transform.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use num_complex::Complex64;
use rustfft::FftPlanner;

use super::GratingError;
use super::profile::check;

/// Largest number of samples.
const MOST: usize = 1 << 22;

/// Heights of one cell, row after row, at equal steps; columns go along the first direction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Samples {
    heights: Vec<f64>,
    columns: usize,
}

impl Samples {
    pub(super) fn new(heights: Vec<f64>, columns: usize) -> Result<Self, GratingError> {
        let found = heights.len();
        if found == 0 || columns == 0 {
            return Err(GratingError::TooFew {
                what: "samples",
                found,
                least: 1,
            });
        }
        if found > MOST || !found.is_multiple_of(columns) {
            return Err(GratingError::Samples {
                found,
                columns,
                most: MOST,
            });
        }
        for height in &heights {
            check("height of a sample", *height, [-1.0, 1.0])?;
        }
        Ok(Self { heights, columns })
    }

    pub(super) fn depth(&self) -> f64 {
        let highest = self.heights.iter().copied().fold(f64::MIN, f64::max);
        highest - self.heights.iter().copied().fold(f64::MAX, f64::min)
    }

    /// Numbers of columns and of rows.
    fn counts(&self) -> [usize; 2] {
        [self.columns, self.heights.len() / self.columns]
    }

    /// The orders that as many samples hold, along the columns' and the rows' direction.
    pub(super) fn orders(&self) -> [RangeInclusive<i32>; 2] {
        self.counts().map(|n| {
            let n = i32::try_from(n).expect("at most 2^22");
            -(n / 2)..=(n - 1) / 2
        })
    }

    /// One amplitude, by the sum itself; 0 for an order that the samples do not hold.
    pub(super) fn amplitude(&self, phi_z: f64, order: [i32; 2]) -> Complex64 {
        let held = self.orders();
        if !(held[0].contains(&order[0]) && held[1].contains(&order[1])) {
            return Complex64::ZERO;
        }
        let [columns, rows] = self.counts();
        // q n/N less its whole turns, in whole numbers
        let turn = |q: i32, n: usize, of: usize| {
            let rest = (i64::from(q) * n as i64).rem_euclid(of as i64);
            TAU * rest as f64 / of as f64
        };
        let sum: Complex64 = (0..rows)
            .map(|row| {
                let heights = &self.heights[row * columns..][..columns];
                let line: Complex64 = heights
                    .iter()
                    .enumerate()
                    .map(|(n, h)| Complex64::cis(-(phi_z * h) - turn(order[0], n, columns)))
                    .sum();
                line * Complex64::cis(-turn(order[1], row, rows))
            })
            .sum();
        sum / self.heights.len() as f64
    }

    /// Amplitudes of orders along the columns' direction of a single row.
    pub(super) fn line_amplitudes(
        &self,
        phi_z: f64,
        orders: RangeInclusive<i32>,
    ) -> Vec<Complex64> {
        let held = &self.orders()[0];
        let all = self.transform(phi_z);
        let of = |q: i32| {
            if held.contains(&q) {
                all[q.rem_euclid(self.columns as i32) as usize]
            } else {
                Complex64::ZERO
            }
        };
        orders.map(of).collect()
    }

    /// All orders with their amplitudes.
    pub(super) fn all_amplitudes(
        &self,
        phi_z: f64,
    ) -> impl Iterator<Item = ([i32; 2], Complex64)> + use<> {
        let [columns, rows] = self.counts();
        let signed = |index: usize, n: usize| {
            let (index, n) = (index as i32, n as i32);
            if index > (n - 1) / 2 {
                index - n
            } else {
                index
            }
        };
        self.transform(phi_z)
            .into_iter()
            .enumerate()
            .map(move |(at, t)| {
                (
                    [signed(at % columns, columns), signed(at / columns, rows)],
                    t,
                )
            })
    }

    /// The discrete Fourier transform of `e^(−iφ_z h)` over the number of samples, order 0 first.
    fn transform(&self, phi_z: f64) -> Vec<Complex64> {
        let [columns, rows] = self.counts();
        let scale = 1.0 / self.heights.len() as f64;
        let mut values: Vec<Complex64> = self
            .heights
            .iter()
            .map(|h| Complex64::from_polar(scale, -phi_z * h))
            .collect();
        let mut planner = FftPlanner::new();
        planner.plan_fft_forward(columns).process(&mut values);
        if rows > 1 {
            let along = planner.plan_fft_forward(rows);
            let mut line = vec![Complex64::ZERO; rows];
            for column in 0..columns {
                for (row, value) in line.iter_mut().enumerate() {
                    *value = values[row * columns + column];
                }
                along.process(&mut line);
                for (row, value) in line.iter().enumerate() {
                    values[row * columns + column] = *value;
                }
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_transform_is_the_sum_over_the_cell() {
        for (columns, rows) in [(1, 1), (8, 1), (7, 1), (6, 5), (4, 8), (1, 9)] {
            let heights: Vec<f64> = (0..columns * rows)
                .map(|n| 1e-7 * (1.0 + 2.3 * n as f64 + 0.1 * (n * n) as f64).sin())
                .collect();
            let samples = Samples::new(heights, columns).unwrap();
            let mut total = 0.0;
            for (order, fast) in samples.all_amplitudes(3e7) {
                let slow = samples.amplitude(3e7, order);
                // 40 terms of modulus 1/40
                assert!((fast - slow).norm() < 1e-15, "{order:?} {fast} {slow}");
                total += fast.norm_sqr();
            }
            // Parseval
            assert!((total - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn columns_go_along_the_first_direction() {
        // a phase ramp −2πx over the columns alone is order −1 of the first index
        let heights: Vec<f64> = (0..12).map(|n| (n % 4) as f64 / 4.0 * 1e-7).collect();
        let samples = Samples::new(heights, 4).unwrap();
        let t = samples.amplitude(TAU / 1e-7, [-1, 0]);
        assert!((t - 1.0).norm() < 1e-15, "{t}");
    }

    #[test]
    fn cells_that_are_none_are_refused() {
        assert!(Samples::new(vec![], 1).is_err());
        assert!(Samples::new(vec![0.0; 6], 0).is_err());
        let uneven = Samples::new(vec![0.0; 6], 4).unwrap_err();
        assert_eq!(
            uneven.to_string(),
            "grating: 6 samples in rows of 4, expected whole rows and at most 4194304 samples"
        );
        assert!(Samples::new(vec![0.0, f64::NAN], 2).is_err());
    }
}
