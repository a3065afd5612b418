//! Random phases: screens with jointly Gaussian phases on the two axes.

use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

use super::Element;
use crate::sixteen::TransferTensor;

/// Relative slack of the conditions on correlation lengths.
const ROUNDING: f64 = 1e-12;

/// Why no random surface or screen has these numbers.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ScreenError {
    /// A standard deviation is negative or not finite.
    #[error("phase screen: {what} is {value}, expected a finite number that is not negative")]
    Negative {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// A length is not positive and finite.
    #[error("phase screen: {what} is {value}, expected a finite positive number")]
    NotPositive {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// The correlation of the two phases at one point is out of range.
    #[error("phase screen: the correlation of the two phases is {correlation}, expected -1 to 1")]
    Correlation {
        /// What was found.
        correlation: f64,
    },
    /// The cross-correlation is too short.
    #[error(
        "phase screen: the length of the cross-correlation is {found} m, expected at least {least} m (the root mean square \
         of the other two): fine structure would be more correlated than present"
    )]
    CrossTooShort {
        /// `l_xy`.
        found: f64,
        /// `√((l_xx² + l_yy²)/2)`.
        least: f64,
    },
    /// The cross-correlation is too long for its strength.
    #[error(
        "phase screen: the length of the cross-correlation is {found} m, expected at most {most} m at a correlation of \
         {correlation}: coarse structure would be more correlated than present"
    )]
    CrossTooLong {
        /// `l_xy`.
        found: f64,
        /// `√(l_xx l_yy/|c|)`.
        most: f64,
        /// `c`.
        correlation: f64,
    },
}

/// Lengths at which the correlations of a phase screen fall to `1/e`, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrelationLengths {
    /// Of the phase on the `x` axis with itself.
    pub xx: f64,
    /// Of the phase on the `y` axis with itself.
    pub yy: f64,
    /// Of the two with each other.
    pub xy: f64,
}

/// Random phases on the two axes, zero-mean, jointly Gaussian, statistically the same everywhere; no loss.
///
/// ```text
/// T = diag(e^{iφ_x}, e^{iφ_y}),   ⟨φ_i(r₁) φ_j(r₂)⟩ = s_i s_j c_ij η_ij(|r₁ − r₂|),   η_ij(d) = e^{−d²/l_ij²}
/// e_ij = ⟨T_ii(r₁) T*_jj(r₂)⟩ = exp(−(s_i² + s_j²)/2 + s_i s_j c_ij η_ij)
/// ```
///
/// evaluated as `exp(−(s_i − s_j)²/2 − s_i s_j (1 − c_ij η_ij))`, with `1 − η` from `expm1`: strong screens lose no digits
/// to the difference of large squares.
///
/// Source: Shirai & Wolf 2004, J. Opt. Soc. Am. A 21, 1907; Ma et al. 2015, J. Opt. Soc. Am. A 32, 2346 (cited at the
/// end of section S4.3 of the supplemental of Steinberg & Yan 2021).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseScreen {
    deviations: [f64; 2],
    correlation: f64,
    lengths: CorrelationLengths,
}

impl PhaseScreen {
    /// Phases with standard `deviations` (radians, along `x` and `y`), their `correlation` at one point (−1 to 1), and
    /// correlation lengths.
    ///
    /// # Errors
    ///
    /// When a number is out of range, or no Gaussian process has these correlations: its spectral matrix is not negative
    /// exactly if `(l_xx² + l_yy²)/2 ≤ l_xy² ≤ l_xx l_yy/|c|` (for `c ≠ 0` and two phases).
    pub fn new(
        deviations: [f64; 2],
        correlation: f64,
        lengths: CorrelationLengths,
    ) -> Result<Self, ScreenError> {
        let screen = Self::without_spectral_check(deviations, correlation, lengths)?;
        screen.check_spectrum()?;
        Ok(screen)
    }

    /// As [`PhaseScreen::new`], without asking whether a process with these correlations exists: the closed form serves
    /// for any lengths, but light behind such a screen may fail [`crate::CrossSpectralDensity::check_pair`].
    ///
    /// # Errors
    ///
    /// When a number is out of range.
    pub fn without_spectral_check(
        deviations: [f64; 2],
        correlation: f64,
        lengths: CorrelationLengths,
    ) -> Result<Self, ScreenError> {
        let [sx, sy] = deviations;
        not_negative("the standard deviation along x", sx)?;
        not_negative("the standard deviation along y", sy)?;
        positive("the correlation length along x", lengths.xx)?;
        positive("the correlation length along y", lengths.yy)?;
        positive("the length of the cross-correlation", lengths.xy)?;
        if !(-1.0..=1.0).contains(&correlation) {
            return Err(ScreenError::Correlation { correlation });
        }
        Ok(Self {
            deviations,
            correlation,
            lengths,
        })
    }

    /// Independent phases on the two axes, with standard `deviations` in radians and correlation `lengths` in metres.
    ///
    /// # Errors
    ///
    /// When a number is out of range.
    pub fn independent(deviations: [f64; 2], lengths: [f64; 2]) -> Result<Self, ScreenError> {
        let [xx, yy] = lengths;
        let xy = xx.max(yy);
        Self::new(deviations, 0.0, CorrelationLengths { xx, yy, xy })
    }

    /// Asks whether a Gaussian process with these correlations exists.
    ///
    /// # Errors
    ///
    /// With the length of the cross-correlation and its bound.
    pub fn check_spectrum(&self) -> Result<(), ScreenError> {
        let CorrelationLengths { xx, yy, xy } = self.lengths;
        let correlation = self.correlation;
        let [sx, sy] = self.deviations;
        if correlation == 0.0 || sx == 0.0 || sy == 0.0 {
            return Ok(());
        }
        let least = xx.hypot(yy) * std::f64::consts::FRAC_1_SQRT_2;
        if xy < least * (1.0 - ROUNDING) {
            return Err(ScreenError::CrossTooShort { found: xy, least });
        }
        let most = xx.sqrt() * yy.sqrt() / correlation.abs().sqrt();
        if xy > most * (1.0 + ROUNDING) {
            return Err(ScreenError::CrossTooLong {
                found: xy,
                most,
                correlation,
            });
        }
        Ok(())
    }
}

impl Element for PhaseScreen {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let distance = (first - second).norm();
        let [sx, sy] = self.deviations;
        let CorrelationLengths { xx, yy, xy } = self.lengths;
        let moment = |si: f64, sj: f64, c: f64, length: f64| {
            let loss = (1.0 - c) + c * decorrelation(distance, length);
            gaussian_moment(si, sj, loss).into()
        };
        let cross = moment(sx, sy, self.correlation, xy);
        TransferTensor::of_diagonal(Matrix2::new(
            moment(sx, sx, 1.0, xx),
            cross,
            cross,
            moment(sy, sy, 1.0, yy),
        ))
    }
}

/// `1 − e^{−d²/l²}`.
pub(super) fn decorrelation(distance: f64, length: f64) -> f64 {
    let ratio = distance / length;
    -(-ratio * ratio).exp_m1()
}

/// `⟨e^{i(a − b)}⟩` of two Gaussian phases of deviations `si`, `sj` and correlation `1 − loss`.
pub(super) fn gaussian_moment(si: f64, sj: f64, loss: f64) -> f64 {
    let difference = si - sj;
    (-0.5 * difference * difference - si * sj * loss).exp()
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), ScreenError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ScreenError::NotPositive { what, value })
    }
}

pub(super) fn not_negative(what: &'static str, value: f64) -> Result<(), ScreenError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(ScreenError::Negative { what, value })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::csdm::CrossSpectralDensity;
    use num_complex::Complex64;
    use stokes::StokesVector;

    fn lengths(xx: f64, yy: f64, xy: f64) -> CorrelationLengths {
        CorrelationLengths { xx, yy, xy }
    }

    /// `⟨f(a, b)⟩` over two standard normal numbers of correlation `rho`, by the trapezoidal rule.
    pub(crate) fn normal_average(rho: f64, f: impl Fn(f64, f64) -> Complex64) -> Complex64 {
        let (steps, reach) = (240, 9.0);
        let node = |i: i32| reach * f64::from(2 * i - steps) / f64::from(steps);
        let weight = 2.0 * reach / f64::from(steps) / (2.0 * std::f64::consts::PI).sqrt();
        let mut sum = Complex64::from(0.0);
        for i in 0..=steps {
            for j in 0..=steps {
                let (u, v) = (node(i), node(j));
                let gauss = weight * weight * (-0.5 * (u * u + v * v)).exp();
                sum += f(u, rho * u + (1.0 - rho * rho).sqrt() * v) * gauss;
            }
        }
        sum
    }

    #[test]
    fn moments_are_averages_over_gaussian_phases() {
        let (sx, sy, c, l) = (0.7, 1.3, -0.6, lengths(2e-4, 3e-4, 2.6e-4));
        let screen = PhaseScreen::new([sx, sy], c, l).unwrap();
        for distance in [0.0, 1e-4, 5e-4] {
            let there = Vector2::new(0.6, -0.8) * distance;
            let tensor = screen.transfer(&Vector2::zeros(), &there).to_matrix();
            let eta = |length: f64| (-(distance / length).powi(2)).exp();
            let moment = |si: f64, sj: f64, rho: f64| {
                normal_average(rho, |a, b| Complex64::cis(si * a - sj * b))
            };
            let xx = moment(sx, sx, eta(l.xx));
            let yy = moment(sy, sy, eta(l.yy));
            let xy = moment(sx, sy, c * eta(l.xy));
            assert!((tensor[(0, 0)] - xx).norm() < 1e-13);
            assert!((tensor[(3, 3)] - yy).norm() < 1e-13);
            assert!((tensor[(0, 3)] - xy).norm() < 1e-13);
            assert!((tensor[(3, 0)] - xy.conj()).norm() < 1e-13);
        }
    }

    #[test]
    fn equal_phases_do_not_depolarize_and_independent_ones_do() {
        let here = Vector2::zeros();
        let same = PhaseScreen::new([30.0, 30.0], 1.0, lengths(1e-4, 1e-4, 1e-4)).unwrap();
        assert!((same.mueller_at(&here) * StokesVector::DIAGONAL).s2() == 1.0);
        let independent = PhaseScreen::independent([30.0, 30.0], [1e-4, 1e-4]).unwrap();
        assert!((independent.mueller_at(&here) * StokesVector::DIAGONAL).s2() < 1e-300);
    }

    #[test]
    fn correlations_that_no_process_has_are_refused_with_their_bounds() {
        let error = PhaseScreen::new([1.0, 1.0], 0.5, lengths(2e-4, 3e-4, 2.5e-4)).unwrap_err();
        let ScreenError::CrossTooShort { least, .. } = error else {
            panic!("{error}");
        };
        assert!((least - 6.5f64.sqrt() * 1e-4).abs() < 1e-18);
        let error = PhaseScreen::new([1.0, 1.0], 1.0, lengths(2e-4, 3e-4, 2.6e-4)).unwrap_err();
        let ScreenError::CrossTooLong { most, .. } = error else {
            panic!("{error}");
        };
        assert!((most - 6f64.sqrt() * 1e-4).abs() < 1e-18);
        assert!(PhaseScreen::independent([-1.0, 1.0], [1.0, 1.0]).is_err());
        assert!(PhaseScreen::independent([1.0, 1.0], [0.0, 1.0]).is_err());
        assert!(PhaseScreen::new([1.0, 1.0], 1.5, lengths(1.0, 1.0, 1.0)).is_err());
    }

    #[test]
    fn light_behind_an_impossible_screen_is_caught_and_behind_a_possible_one_passes() {
        // weak screens: C ≈ 1 − phase correlations, so their matrix has to be positive
        let light = CrossSpectralDensity::from_stokes(StokesVector::DIAGONAL).unwrap();
        let pair_is_physical = |screen: &PhaseScreen, distance: f64| {
            let (a, b) = (Vector2::zeros(), Vector2::new(distance, 0.0));
            let at = |p: &Vector2<f64>, q: &Vector2<f64>| screen.act_on(&light, p, q);
            at(&a, &b)
                .check_pair(&at(&a, &a), &at(&b, &b), 1e-13)
                .is_ok()
        };
        let possible = PhaseScreen::new([0.5, 0.5], 0.9, lengths(1.0, 1.0, 1.02)).unwrap();
        assert!(
            [0.1, 0.5, 1.0, 2.0]
                .iter()
                .all(|d| pair_is_physical(&possible, *d))
        );
        let impossible =
            PhaseScreen::without_spectral_check([0.5, 0.5], 1.0, lengths(1.0, 1.0, 0.5)).unwrap();
        assert!(!pair_is_physical(&impossible, 0.5));
    }
}
