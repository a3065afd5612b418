//! Random phase screens as matter: jointly Gaussian phases on the two axes, their channels and autocorrelations.

use csdm::{CorrelationLengths, PhaseScreen, RoughRetarder};
use nalgebra::Matrix2;
use stokes::Mueller;

use crate::accuracy::{Approximation, Method, Tolerance};
use crate::autocorrelation::{Autocorrelation, AutocorrelationError, GaussianTerm};
use crate::channels::Channels;

/// Phases against each other beyond this leave `e^(−40) = 4e-18` of the light in their common part: nothing of it is seen
/// beside the intensity.
const OPPOSED: f64 = 40.0;

impl Channels {
    /// The channels of a random phase screen, in the frame of its axes `x` and `y`.
    ///
    /// ```text
    /// e_ij = exp(−(s_i² + s_j²)/2 + s_i s_j c_ij η_ij),     η_ij = e^(−|x|²/l_ij²),  c_ii = 1
    /// M00 = M11 = (e_xx + e_yy)/2     M01 = M10 = (e_xx − e_yy)/2     M22 = M33 = e_xy
    /// ```
    ///
    /// `e_ii` is that of heights with `g = s_i²`, and `e_xy` the same with `g = s_x s_y c` times a number, for phases that go
    /// together. The energy factor is [`crate::Energy::Conserving`]: the phases do not depend on the directions.
    ///
    /// Accuracy: for every `e_ij` the error of its lobe, without what does not decay, is at most half of the tolerance of
    /// that lobe's largest value. Phases that go against each other (`c < 0`) make an alternating sum: of its lobe that
    /// bound holds for light of Gaussian coherence, and rounding is 1e-16 of the lobe of the intensity, not of its own.
    /// Where `−s_x s_y c > 40` the lobe of `e_xy` is left out: no more than 1e-15 of that of the intensity, as long as the
    /// lengths pass [`PhaseScreen::check_spectrum`].
    ///
    /// Source: Shirai & Wolf 2004, J. Opt. Soc. Am. A 21, 1907; Ma et al. 2015, J. Opt. Soc. Am. A 32, 2346.
    ///
    /// # Errors
    ///
    /// When the variance of a phase is above 1e24, or a length outside 1.5e-30 to 1e30 m.
    ///
    /// ```
    /// use mueller16::{Channels, Tolerance};
    /// // independent phases of 1 rad on the two axes: S2 and S3 keep e⁻¹ = 36.79 %
    /// let screen = csdm::PhaseScreen::independent([1.0, 1.0], [50e-6, 50e-6])?;
    /// let (matter, _) = Channels::of_phase_screen(&screen, Tolerance::relative(1e-6)?)?;
    /// assert!((matter.mueller().element(2, 2) - 0.367_879).abs() < 1e-6);
    /// assert_eq!(matter.set(), mueller16::ChannelSet::DIAGONAL);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_phase_screen(
        screen: &PhaseScreen,
        tolerance: Tolerance,
    ) -> Result<(Self, Approximation), AutocorrelationError> {
        let phases = Phases {
            deviations: screen.deviations(),
            correlation: screen.correlation(),
            lengths: screen.lengths(),
            retardance: 0.0,
        };
        phases.channels(tolerance)
    }

    /// The channels of a birefringent plate with a rough surface, in the frame of its axes `x` and `y`.
    ///
    /// Those of a phase screen whose phases go together, or against each other where one index is below that outside,
    /// and `e_xy` turned by the mean retardance δ of the y axis:
    ///
    /// ```text
    /// M22 = M33 = e_xy cos δ      M23 = −M32 = e_xy sin δ
    /// ```
    ///
    /// Accuracy as [`Channels::of_phase_screen`].
    ///
    /// Source: Ma et al. 2015, J. Opt. Soc. Am. A 32, 2346.
    ///
    /// # Errors
    ///
    /// As [`Channels::of_phase_screen`].
    ///
    /// ```
    /// use mueller16::{Channels, Tolerance};
    /// // a quarter of a wave: S2 becomes −S3, of which e^(−s²/2) is left, s the deviation of the retardance
    /// let light = stokes::Wavelength::from_metres(500e-9)?;
    /// let plate = csdm::RoughRetarder::new(light, [1.5, 1.51], 1.0, 12.5e-6, 2e-6, 20e-6)?;
    /// let (matter, _) = Channels::of_rough_retarder(&plate, Tolerance::relative(1e-6)?)?;
    /// let s: f64 = 0.251_327_412;
    /// assert!((matter.mueller().element(3, 2) + (-0.5 * s * s).exp()).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_rough_retarder(
        plate: &RoughRetarder,
        tolerance: Tolerance,
    ) -> Result<(Self, Approximation), AutocorrelationError> {
        let [s_x, s_y] = plate.deviations();
        let length = plate.correlation_length();
        let phases = Phases {
            deviations: [s_x.abs(), s_y.abs()],
            correlation: s_x.signum() * s_y.signum(),
            lengths: CorrelationLengths {
                xx: length,
                yy: length,
                xy: length,
            },
            retardance: plate.mean_retardance(),
        };
        phases.channels(tolerance)
    }
}

/// Jointly Gaussian phases on two axes, and the mean by which y is behind.
struct Phases {
    deviations: [f64; 2],
    correlation: f64,
    lengths: CorrelationLengths,
    retardance: f64,
}

impl Phases {
    fn channels(
        &self,
        tolerance: Tolerance,
    ) -> Result<(Channels, Approximation), AutocorrelationError> {
        let [s_x, s_y] = self.deviations;
        let lengths = self.lengths;
        let one_axis = |s: f64, length: f64| {
            Autocorrelation::of_gaussian_phase(s * s, &root(length), tolerance)
        };
        let parts = [
            (intensities(1.0), one_axis(s_x, lengths.xx)?),
            (intensities(-1.0), one_axis(s_y, lengths.yy)?),
            (crossed(self.retardance), self.cross(tolerance)?),
        ];
        let mut channels = Channels::default();
        let mut worst: Option<Approximation> = None;
        for (mueller, (autocorrelation, chosen)) in parts {
            channels = channels.with(&mueller, autocorrelation, 0);
            if worst.is_none_or(|known| known.error < chosen.error) {
                worst = Some(chosen);
            }
        }
        let terms = channels.groups().iter();
        let exact = Approximation {
            method: Method::Exact,
            terms: 0,
            error: 0.0,
        };
        let approximation = Approximation {
            terms: terms.map(|group| group.autocorrelation.term_count()).sum(),
            ..worst.unwrap_or(exact)
        };
        Ok((channels, approximation))
    }

    /// `e_xy` without the mean retardance.
    fn cross(
        &self,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let [s_x, s_y] = self.deviations;
        let root = root(self.lengths.xy);
        let (together, difference) = (s_x * s_y, s_x - s_y);
        let a = together * self.correlation;
        if a >= 0.0 {
            // no difference of large squares
            let scale =
                (-0.5 * difference * difference - together * (1.0 - self.correlation)).exp();
            let (r, chosen) = Autocorrelation::of_gaussian_phase(a, &root, tolerance)?;
            return Ok((r.scaled(scale), chosen));
        }
        let apart = (-0.5 * (s_x * s_x + s_y * s_y)).exp();
        let (terms, error) = if -a > OPPOSED {
            (vec![], f64::EPSILON)
        } else {
            alternating(-a, 0.5 * tolerance.get())
        };
        let constant = GaussianTerm::centred(1.0, 0.0);
        let r = Autocorrelation::of_family(&root, [constant].into_iter().chain(terms))?;
        let chosen = Approximation {
            method: Method::PoissonSum,
            terms: r.term_count(),
            error,
        };
        Ok((r.scaled(apart), chosen))
    }
}

/// `e^(−aη) − 1 = Σ (−a)^m/m! η^m`, and a bound on what is left out, of its lobe's largest value.
///
/// `1 − e^(−aη) ≥ (1 − e^(−a)) η`, and no power of η has a larger lobe than η: the rest of the series, over `1 − e^(−a)`,
/// is that bound.
fn alternating(a: f64, target: f64) -> (Vec<GaussianTerm>, f64) {
    let allowed = -(-a).exp_m1();
    let mut terms = vec![];
    let (mut m, mut weight) = (1.0, -a);
    loop {
        terms.push(GaussianTerm::centred(weight, m));
        m += 1.0;
        weight *= -a / m;
        // the rest is below a geometric series
        let ratio = a / (m + 1.0);
        let rest = weight.abs() / ((1.0 - ratio) * allowed);
        if ratio < 1.0 && rest <= target {
            return (terms, rest);
        }
    }
}

/// `D = l/√2` of `e^(−|x|²/l²)`.
fn root(length: f64) -> Matrix2<f64> {
    Matrix2::from_diagonal_element(length * std::f64::consts::FRAC_1_SQRT_2)
}

/// What passes along one axis alone: `sign` 1 for x, −1 for y.
fn intensities(sign: f64) -> Mueller {
    let (same, other) = (0.5, 0.5 * sign);
    let dark = [0.0; 4];
    Mueller::from_rows([[same, other, 0.0, 0.0], [other, same, 0.0, 0.0], dark, dark])
}

/// What passes of the two axes together, y behind by the retardance: `e_xy = e^(iδ)` times a real number.
fn crossed(retardance: f64) -> Mueller {
    let (dark, (sin, cos)) = ([0.0; 4], retardance.sin_cos());
    Mueller::from_rows([dark, dark, [0.0, 0.0, cos, sin], [0.0, 0.0, -sin, cos]])
}
