//! Any ensemble that can be drawn, averaged by Monte Carlo, with its standard error.

use std::f64::consts::TAU;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2};
use num_complex::Complex64;
use thiserror::Error;

use super::Element;
use crate::csdm::CrossSpectralDensity;
use crate::jones::JonesMatrix;
use crate::sixteen::{GeneralizedMueller, TransferTensor};

/// A sample from which no standard error can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("monte carlo: {samples} samples, expected at least 2: one has no standard error")]
pub struct TooFewSamples {
    /// How many were asked for.
    pub samples: u32,
}

/// The random numbers of one realization.
#[derive(Debug)]
pub struct RandomStream {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl RandomStream {
    fn new(seed: u64, realization: u32) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(u64::from(realization));
        Self {
            generator,
            spare: None,
        }
    }

    /// A number that is uniform in `0.0..1.0`, on a lattice of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        // the 53 upper bits: exact in f64
        (self.generator.next_u64() >> 11) as f64 * 0.5f64.powi(53)
    }

    /// A normal number of mean 0 and standard deviation 1, by the method of Box and Muller.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // 1 − u is never 0
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }
}

/// An ensemble of elements from a function that draws one: `draw(random)` is a realization `T(r)`, itself a function of
/// the point in metres. Every pair of points costs `samples` draws.
///
/// Realization `i` of seed `s` comes from stream `i` of the ChaCha8 generator with key `s`: the same numbers on every
/// machine, in any order and at every pair of points. The sample is thus one fixed mixture of deterministic elements, and
/// what it makes of light is realizable between all pairs of points, whatever its standard error.
///
/// ```
/// use csdm::{Element, JonesMatrix, MonteCarlo, RandomStream};
/// use nalgebra::Vector2;
/// // a retarder of random retardance, standard deviation 1 rad: e^{−1/2} of diagonal light stays polarized
/// let ensemble = MonteCarlo::new(10_000, 1, |random: &mut RandomStream| {
///     let plate = JonesMatrix::linear_retarder(random.normal());
///     move |_: &Vector2<f64>| plate
/// })?;
/// let here = Vector2::zeros();
/// let estimate = ensemble.estimate(&here, &here);
/// let error = estimate.mean.element(2, 2).re - (-0.5f64).exp();
/// assert!(error.abs() < 4.0 * estimate.standard_error[(2, 2)].re);
/// # Ok::<(), csdm::TooFewSamples>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct MonteCarlo<D> {
    samples: u32,
    seed: u64,
    draw: D,
}

/// An estimate of the sixteen numbers at a pair of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixteenEstimate {
    /// The mean over the sample.
    pub mean: GeneralizedMueller,
    /// Standard error of the real part of each number, and, as imaginary part, of its imaginary part.
    pub standard_error: Matrix4<Complex64>,
}

/// An estimate of what an ensemble makes of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightEstimate {
    /// The mean over the sample.
    pub mean: CrossSpectralDensity,
    /// Standard error of the real part of each element, and, as imaginary part, of its imaginary part.
    pub standard_error: Matrix2<Complex64>,
}

impl<D, T> MonteCarlo<D>
where
    D: Fn(&mut RandomStream) -> T,
    T: Fn(&Vector2<f64>) -> JonesMatrix,
{
    /// The ensemble of `samples` realizations of `draw`, of the given seed.
    ///
    /// # Errors
    ///
    /// When there are fewer than two samples.
    pub fn new(samples: u32, seed: u64, draw: D) -> Result<Self, TooFewSamples> {
        if samples < 2 {
            return Err(TooFewSamples { samples });
        }
        Ok(Self {
            samples,
            seed,
            draw,
        })
    }

    /// The sixteen numbers at the points `first` and `second`, with their standard errors.
    #[must_use]
    pub fn estimate(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> SixteenEstimate {
        let (mean, standard_error) = self.average(|realization| {
            GeneralizedMueller::of_jones(&realization(first), &realization(second)).to_matrix()
        });
        SixteenEstimate {
            mean: mean.into(),
            standard_error,
        }
    }

    /// What the ensemble makes of `light` at the points `first` and `second`, with its standard error.
    ///
    /// Source: Eq. (S4.12).
    #[must_use]
    pub fn estimate_light(
        &self,
        light: &CrossSpectralDensity,
        first: &Vector2<f64>,
        second: &Vector2<f64>,
    ) -> LightEstimate {
        let (mean, standard_error) = self.average(|realization| {
            let (t1, t2) = (
                realization(first).to_matrix(),
                realization(second).to_matrix(),
            );
            t1 * light.to_matrix() * t2.adjoint()
        });
        LightEstimate {
            mean: CrossSpectralDensity(mean),
            standard_error,
        }
    }

    /// Mean and standard error of a matrix over the sample, real and imaginary parts apart, by Welford's recurrence.
    fn average<const N: usize>(
        &self,
        value: impl Fn(&T) -> SMatrix<Complex64, N, N>,
    ) -> (SMatrix<Complex64, N, N>, SMatrix<Complex64, N, N>) {
        let mut mean = SMatrix::<Complex64, N, N>::zeros();
        let mut squares = SMatrix::<Complex64, N, N>::zeros();
        for i in 0..self.samples {
            let realization = (self.draw)(&mut RandomStream::new(self.seed, i));
            let sample = value(&realization);
            let before = sample - mean;
            mean += before / Complex64::from(f64::from(i) + 1.0);
            let after = sample - mean;
            squares += before.zip_map(&after, |b, a| Complex64::new(b.re * a.re, b.im * a.im));
        }
        let samples = f64::from(self.samples);
        let error = |square: f64| (square / (samples * (samples - 1.0))).sqrt();
        (
            mean,
            squares.map(|s| Complex64::new(error(s.re), error(s.im))),
        )
    }
}

/// The mean over the sample; see [`MonteCarlo::estimate`] for its standard error.
impl<D, T> Element for MonteCarlo<D>
where
    D: Fn(&mut RandomStream) -> T,
    T: Fn(&Vector2<f64>) -> JonesMatrix,
{
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let (mean, _) = self.average(|realization| {
            TransferTensor::of_jones(&realization(first), &realization(second)).to_matrix()
        });
        mean.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::RoughRetarder;
    use stokes::{StokesVector, Wavelength};

    const LENGTH: f64 = 1e-5;

    /// A rough plate as an ensemble: heights at the origin and at `r` from two normal numbers, correlation `e^{−r²/l²}`.
    fn rough(
        samples: u32,
        seed: u64,
    ) -> (
        MonteCarlo<impl Fn(&mut RandomStream) -> Plate>,
        RoughRetarder,
    ) {
        let light = Wavelength::from_metres(500e-9).unwrap();
        let k0 = light.wavenumber().radians_per_metre();
        let (indices, thickness, roughness) = ([1.5, 1.6], 1e-6, 60e-9);
        let plate = RoughRetarder::new(light, indices, 1.0, thickness, roughness, LENGTH).unwrap();
        let draw = move |random: &mut RandomStream| -> Plate {
            let (a, b) = (random.normal(), random.normal());
            Box::new(move |r: &Vector2<f64>| {
                let rho = (-r.norm_squared() / (LENGTH * LENGTH)).exp();
                let height = roughness * (rho * a + (1.0 - rho * rho).sqrt() * b);
                let [x, y] =
                    indices.map(|n| Complex64::cis(-k0 * (n - 1.0) * (thickness + height)));
                JonesMatrix::diagonal(x, y)
            })
        };
        (MonteCarlo::new(samples, seed, draw).unwrap(), plate)
    }

    type Plate = Box<dyn Fn(&Vector2<f64>) -> JonesMatrix>;

    #[test]
    fn a_rough_plate_drawn_at_random_is_the_closed_form_within_its_error() {
        // 24 numbers that vary, 5 standard errors: false alarm once in 7e4 seeds
        let (ensemble, plate) = rough(20_000, 7);
        let (here, there) = (Vector2::zeros(), Vector2::new(6e-6, 0.0));
        let estimate = ensemble.estimate(&here, &there);
        let exact = plate.generalized_mueller(&here, &there).to_matrix();
        let error = estimate.mean.to_matrix() - exact;
        for (error, bound) in error.iter().zip(estimate.standard_error.iter()) {
            assert!(error.re.abs() <= 5.0 * bound.re + 1e-15);
            assert!(error.im.abs() <= 5.0 * bound.im + 1e-15);
        }
        assert!(error.camax() > 1e-4);
        let light = CrossSpectralDensity::from_stokes(StokesVector::new(1.0, 0.2, 0.5, -0.3));
        let light = light.unwrap();
        let estimate = ensemble.estimate_light(&light, &here, &there);
        let exact = plate.act_on(&light, &here, &there).to_matrix();
        let error = estimate.mean.to_matrix() - exact;
        for (error, bound) in error.iter().zip(estimate.standard_error.iter()) {
            assert!(error.re.abs() <= 5.0 * bound.re && error.im.abs() <= 5.0 * bound.im);
        }
    }

    #[test]
    fn standard_errors_are_what_estimates_scatter_by() {
        // 64 independent estimates of ⟨cos δ⟩: their scatter against the mean of their own errors. The relative standard
        // deviation of a standard deviation from 64 values is 1/√126 = 9 %: 4 of these
        let here = Vector2::zeros();
        let estimates: Vec<(f64, f64)> = (0..64)
            .map(|seed| {
                let estimate = rough(200, 1000 + seed).0.estimate(&here, &here);
                (
                    estimate.mean.element(2, 2).re,
                    estimate.standard_error[(2, 2)].re,
                )
            })
            .collect();
        let count = estimates.len() as f64;
        let mean = estimates.iter().map(|e| e.0).sum::<f64>() / count;
        let scatter = estimates.iter().map(|e| (e.0 - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let claimed = estimates.iter().map(|e| e.1).sum::<f64>() / count;
        assert!((scatter.sqrt() / claimed - 1.0).abs() < 0.36);
    }

    #[test]
    fn the_sample_is_the_same_at_every_pair_and_realizable_there() {
        let (ensemble, _) = rough(5, 3);
        let light = CrossSpectralDensity::from_stokes(StokesVector::DIAGONAL).unwrap();
        let (here, there) = (Vector2::zeros(), Vector2::new(6e-6, 0.0));
        let at = |a, b| ensemble.act_on(&light, a, b);
        let pair = at(&here, &there);
        pair.check_pair(&at(&here, &here), &at(&there, &there), 1e-14)
            .unwrap();
        let estimate = ensemble.estimate(&here, &there);
        let same = ensemble.generalized_mueller(&here, &there).to_matrix();
        assert!((estimate.mean.to_matrix() - same).camax() < 1e-14);
        assert_ne!(
            rough(5, 4).0.estimate(&here, &there).mean,
            estimate.mean,
            "another seed, another sample"
        );
    }

    #[test]
    fn streams_are_uniform_and_normal() {
        // moments of 20 000 numbers, one from each stream: 5 standard errors
        let count = 20_000u32;
        let average = |value: &dyn Fn(&mut RandomStream) -> f64| {
            let sum: f64 = (0..count)
                .map(|i| value(&mut RandomStream::new(11, i)))
                .sum();
            sum / f64::from(count)
        };
        let limit = |variance: f64| 5.0 * (variance / f64::from(count)).sqrt();
        assert!((average(&RandomStream::uniform) - 0.5).abs() < limit(1.0 / 12.0));
        assert!(average(&RandomStream::normal).abs() < limit(1.0));
        assert!((average(&|r| r.normal().powi(2)) - 1.0).abs() < limit(2.0));
        assert!((average(&|r| r.normal().powi(4)) - 3.0).abs() < limit(96.0));
        assert!(average(&|r| r.normal() * r.normal()).abs() < limit(1.0));
        // neighbouring streams know nothing of each other
        let product = |i| RandomStream::new(11, i).normal() * RandomStream::new(11, i + 1).normal();
        let sum: f64 = (0..count).map(product).sum();
        assert!((sum / f64::from(count)).abs() < limit(1.0));
    }

    #[test]
    fn one_sample_is_refused() {
        let draw = |_: &mut RandomStream| |_: &Vector2<f64>| JonesMatrix::identity();
        let error = MonteCarlo::new(1, 0, draw).err().unwrap();
        assert_eq!(
            error.to_string(),
            "monte carlo: 1 samples, expected at least 2: one has no standard error"
        );
    }
}
