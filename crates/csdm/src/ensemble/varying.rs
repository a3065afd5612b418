//! Deterministic elements that vary across the aperture: `T(r)` as a function of place.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use thiserror::Error;

use super::Element;
use crate::jones::JonesMatrix;
use crate::sixteen::TransferTensor;

/// Why a pattern cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PatternError {
    /// A length is not positive.
    #[error("{element}: {what} is {value} m, expected a positive number")]
    NotPositive {
        /// Which element.
        element: &'static str,
        /// Which length.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// A table has too few rows.
    #[error("voltage response: the table has {rows} rows, expected at least 2")]
    TooShort {
        /// Rows found.
        rows: usize,
    },
    /// A table's row is not finite, or does not lie above the row before.
    #[error(
        "voltage response: row {row} is ({volts} V, {retardance} rad), expected finite numbers and a voltage above \
         that of the row before"
    )]
    BadRow {
        /// Which row, from 0.
        row: usize,
        /// Its voltage.
        volts: f64,
        /// Its retardance.
        retardance: f64,
    },
}

/// A deterministic element with the Jones matrix `T(r)`, given as a function of the point in metres.
///
/// ```
/// use csdm::{Element, JonesMatrix, Varying};
/// use nalgebra::Vector2;
/// // a wedge polarizer pair: the axis turns by 90° over a millimetre
/// let wheel = Varying::new(|r: &Vector2<f64>| {
///     JonesMatrix::linear_polarizer().rotated(r.x / 1e-3 * std::f64::consts::FRAC_PI_2)
/// });
/// let out = wheel.mueller_at(&Vector2::new(0.5e-3, 0.0)) * stokes::StokesVector::UNPOLARIZED;
/// assert!((out.s2() - 0.5).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Varying<F> {
    jones: F,
}

impl<F: Fn(&Vector2<f64>) -> JonesMatrix> Varying<F> {
    /// The element with the Jones matrix `jones(r)` at the point `r`.
    #[must_use]
    pub fn new(jones: F) -> Self {
        Self { jones }
    }

    /// The Jones matrix at a point.
    #[must_use]
    pub fn at(&self, point: &Vector2<f64>) -> JonesMatrix {
        (self.jones)(point)
    }
}

impl<F: Fn(&Vector2<f64>) -> JonesMatrix> Element for Varying<F> {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        TransferTensor::of_jones(&self.at(first), &self.at(second))
    }
}

/// Soft aperture about the origin, with its own width on each axis of polarization:
/// `T = diag(e^{−|r|²/w_x²}, e^{−|r|²/w_y²})`.
///
/// Source: Shirai & Wolf 2004, J. Opt. Soc. Am. A 21, 1907, for equal widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianAperture {
    widths: [f64; 2],
}

impl GaussianAperture {
    /// The aperture of these `widths` w, metres: radii at which the amplitude along `x`, respectively `y`, falls to
    /// `1/e`. An infinite width does not limit its axis.
    ///
    /// # Errors
    ///
    /// When a width is not positive.
    pub fn new(widths: [f64; 2]) -> Result<Self, PatternError> {
        for (value, what) in widths
            .into_iter()
            .zip(["the width along x", "the width along y"])
        {
            positive("gaussian aperture", what, value)?;
        }
        Ok(Self { widths })
    }
}

impl Element for GaussianAperture {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let amplitude = |r: &Vector2<f64>, width: f64| (-(r / width).norm_squared()).exp();
        let moment = |i: usize, j: usize| {
            (amplitude(first, self.widths[i]) * amplitude(second, self.widths[j])).into()
        };
        TransferTensor::of_diagonal(Matrix2::from_fn(moment))
    }
}

/// Polarization grating: a linear retarder whose fast axis turns by half a turn in each `period` (metres) along `x`,
/// counter-clockwise for a receiver who faces the source; fast along `x` at the origin. `retardance` in radians.
///
/// With a half-wave retardance all right circular light (`S3 > 0`) leaves as left circular light, deflected to
/// `k_x = −2π/period`, and all left circular light the other way; with less, `cos²(δ/2)` goes on straight.
///
/// Source: Oh & Escuti 2008, Achromatic diffraction from polarization gratings, Opt. Lett. 33, 2287.
///
/// # Errors
///
/// When the period is not positive.
pub fn polarization_grating(
    period: f64,
    retardance: f64,
) -> Result<Varying<impl Fn(&Vector2<f64>) -> JonesMatrix>, PatternError> {
    positive("polarization grating", "the period", period)?;
    let plate = JonesMatrix::linear_retarder(retardance);
    Ok(Varying::new(move |r: &Vector2<f64>| {
        plate.rotated(PI * r.x / period)
    }))
}

/// Liquid-crystal modulator of parallel alignment, director along `x`: light along `x` is delayed by `retardance(r)`
/// radians, light along `y` passes unchanged, `T = diag(e^{−iδ(r)}, 1)`.
///
/// For a pattern of voltages compose with [`VoltageResponse::retardance`].
///
/// Source: the spatial light modulators named at the end of section S4.3 of the supplemental of Steinberg & Yan 2021.
///
/// ```
/// use csdm::{liquid_crystal_modulator, Element, VoltageResponse};
/// use std::f64::consts::PI;
/// // a cell that goes from δ = 2π at 1 V to 0 at 5 V, driven by a ramp of 1 V/mm
/// let response = VoltageResponse::new(vec![(1.0, 2.0 * PI), (5.0, 0.0)])?;
/// let cell = liquid_crystal_modulator(move |r| response.retardance(1e3 * r.x));
/// let out = cell.mueller_at(&nalgebra::Vector2::new(3e-3, 0.0)) * stokes::StokesVector::DIAGONAL;
/// assert!((out.s2() + 1.0).abs() < 1e-15);
/// # Ok::<(), csdm::PatternError>(())
/// ```
pub fn liquid_crystal_modulator(
    retardance: impl Fn(&Vector2<f64>) -> f64,
) -> Varying<impl Fn(&Vector2<f64>) -> JonesMatrix> {
    Varying::new(move |r: &Vector2<f64>| {
        JonesMatrix::diagonal(Complex64::cis(-retardance(r)), Complex64::from(1.0))
    })
}

/// Measured retardance of a cell against its voltage, linear between the rows of a table and constant beyond its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct VoltageResponse {
    rows: Vec<(f64, f64)>,
}

impl VoltageResponse {
    /// The response through rows of (volts, radians), by increasing voltage.
    ///
    /// # Errors
    ///
    /// When there are fewer than two rows, a number is not finite, or a voltage is not above the one before.
    pub fn new(rows: Vec<(f64, f64)>) -> Result<Self, PatternError> {
        if rows.len() < 2 {
            return Err(PatternError::TooShort { rows: rows.len() });
        }
        let mut before = f64::NEG_INFINITY;
        for (row, &(volts, retardance)) in rows.iter().enumerate() {
            let finite = volts.is_finite() && retardance.is_finite();
            if !finite || volts <= before {
                return Err(PatternError::BadRow {
                    row,
                    volts,
                    retardance,
                });
            }
            before = volts;
        }
        Ok(Self { rows })
    }

    /// Retardance at `volts`, radians.
    #[must_use]
    pub fn retardance(&self, volts: f64) -> f64 {
        let above = self.rows.partition_point(|row| row.0 <= volts);
        if above == 0 {
            return self.rows[0].1;
        }
        let (v0, d0) = self.rows[above - 1];
        match self.rows.get(above) {
            Some(&(v1, d1)) => d0 + (d1 - d0) * ((volts - v0) / (v1 - v0)),
            None => d0,
        }
    }
}

fn positive(element: &'static str, what: &'static str, value: f64) -> Result<(), PatternError> {
    if value > 0.0 {
        Ok(())
    } else {
        Err(PatternError::NotPositive {
            element,
            what,
            value,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::csdm::CrossSpectralDensity;
    use nalgebra::{Matrix4, Vector4};
    use stokes::StokesVector;

    const PERIOD: f64 = 10e-6;

    /// Stokes vector of diffraction order `q` behind scattering functions `Σ(x₁, x₂)`, by the double Fourier sum with
    /// the kernel `e^{−iqG(x₁ − x₂)}` over one period.
    fn order(
        q: i32,
        light: StokesVector,
        scattering: impl Fn(&Vector2<f64>, &Vector2<f64>) -> Matrix4<Complex64>,
    ) -> Vector4<Complex64> {
        let steps = 16;
        let x = |i: i32| Vector2::new(PERIOD * f64::from(i) / f64::from(steps), 0.0);
        let incident = light.to_vector().map(Complex64::from);
        let mut sum = Vector4::zeros();
        for i in 0..steps {
            for j in 0..steps {
                let phase = -2.0 * PI * f64::from(q * (i - j)) / f64::from(steps);
                sum += scattering(&x(i), &x(j)) * incident * Complex64::cis(phase);
            }
        }
        sum / Complex64::from(f64::from(steps * steps))
    }

    fn near(found: Vector4<Complex64>, expected: StokesVector) -> bool {
        (found - expected.to_vector().map(Complex64::from)).norm() < 1e-14
    }

    #[test]
    fn a_polarization_grating_sends_right_circular_light_to_the_order_minus_one_as_left() {
        let grating = polarization_grating(PERIOD, PI).unwrap();
        let scattering =
            |a: &Vector2<f64>, b: &Vector2<f64>| grating.generalized_mueller(a, b).scattering();
        let light = StokesVector::RIGHT_CIRCULAR;
        for q in -3..=3 {
            let expected = if q == -1 {
                StokesVector::LEFT_CIRCULAR
            } else {
                StokesVector::DARK
            };
            assert!(near(order(q, light, scattering), expected), "{q}");
        }
        let out = order(1, StokesVector::LEFT_CIRCULAR, scattering);
        assert!(near(out, StokesVector::RIGHT_CIRCULAR));
        // Σ = M without the conjugate has the polarization right and the side wrong
        let without =
            |a: &Vector2<f64>, b: &Vector2<f64>| grating.generalized_mueller(a, b).to_matrix();
        assert!(near(order(1, light, without), StokesVector::LEFT_CIRCULAR));
        assert!(near(order(-1, light, without), StokesVector::DARK));
    }

    #[test]
    fn the_real_field_behind_a_polarization_grating_travels_to_negative_x() {
        // written with cosines only: light (cos ωt, −sin ωt), half-wave plate with its fast axis at πx/p mirrors it to
        // (cos(ωt + 2πx/p), sin(ωt + 2πx/p)); constant phase moves to −x
        let grating = polarization_grating(PERIOD, PI).unwrap();
        let i = Complex64::new(0.0, 1.0);
        let field = Vector2::new(Complex64::from(1.0), i);
        for (x, wt) in [(1e-6, 0.3), (4.4e-6, 2.0), (-2e-6, 5.0)] {
            let out = grating.at(&Vector2::new(x, 0.0)).apply(field) * Complex64::cis(wt);
            let phase = wt + 2.0 * PI * x / PERIOD;
            assert!((out.x.re - phase.cos()).abs() < 1e-14);
            assert!((out.y.re - phase.sin()).abs() < 1e-14);
        }
        // the fields' own matrix: e^{−ik_x x} with k_x = −2π/p
        let light = CrossSpectralDensity::of_fields(field, field);
        let (a, b) = (Vector2::new(1e-6, 0.0), Vector2::zeros());
        let out = grating.act_on(&light, &a, &b).to_matrix().trace();
        assert!((out - 2.0 * Complex64::cis(2.0 * PI * 1e-6 / PERIOD)).norm() < 1e-14);
    }

    #[test]
    fn a_weak_polarization_grating_lets_light_go_on() {
        let retardance = 0.9f64;
        let grating = polarization_grating(PERIOD, retardance).unwrap();
        let scattering =
            |a: &Vector2<f64>, b: &Vector2<f64>| grating.generalized_mueller(a, b).scattering();
        let straight = (0.5 * retardance).cos().powi(2);
        let right = StokesVector::RIGHT_CIRCULAR;
        assert!(near(order(0, right, scattering), right * straight));
        let left = StokesVector::LEFT_CIRCULAR;
        assert!(near(order(-1, right, scattering), left * (1.0 - straight)));
        // linear light goes to both sides alike
        let linear = StokesVector::HORIZONTAL;
        for (q, state) in [(-1, left), (1, right)] {
            let expected = state * (0.5 * (1.0 - straight));
            assert!(near(order(q, linear, scattering), expected));
        }
    }

    #[test]
    fn a_modulators_ramp_deflects_its_axis_only() {
        // δ = G x along x: e^{−iGx} is a wave with k_x = +G
        let ramp = liquid_crystal_modulator(|r| 2.0 * PI * r.x / PERIOD);
        let scattering =
            |a: &Vector2<f64>, b: &Vector2<f64>| ramp.generalized_mueller(a, b).scattering();
        let light = StokesVector::DIAGONAL;
        let half = 0.5;
        assert!(near(
            order(1, light, scattering),
            StokesVector::HORIZONTAL * half
        ));
        assert!(near(
            order(0, light, scattering),
            StokesVector::VERTICAL * half
        ));
        assert!(near(order(-1, light, scattering), StokesVector::DARK));
    }

    #[test]
    fn a_table_of_voltages_is_interpolated_and_checked() {
        let response = VoltageResponse::new(vec![(1.0, 6.0), (2.0, 4.0), (4.0, 1.0)]).unwrap();
        let found = [0.0, 1.0, 1.5, 2.0, 3.0, 9.0].map(|volts| response.retardance(volts));
        assert_eq!(found, [6.0, 6.0, 5.0, 4.0, 2.5, 1.0]);
        assert_eq!(
            VoltageResponse::new(vec![(1.0, 6.0)]),
            Err(PatternError::TooShort { rows: 1 })
        );
        let error = VoltageResponse::new(vec![(1.0, 6.0), (1.0, 4.0)]).unwrap_err();
        assert!(matches!(error, PatternError::BadRow { row: 1, .. }));
    }

    #[test]
    fn a_soft_aperture_keeps_a_gaussian_of_each_axis() {
        // w_y = ∞: S0 = (e^{−2 r²/w²} + 1)/2
        let aperture = GaussianAperture::new([1e-3, f64::INFINITY]).unwrap();
        let point = Vector2::new(0.3e-3, 0.4e-3);
        let out = aperture.mueller_at(&point) * StokesVector::UNPOLARIZED;
        assert!((out.s0() - 0.5 * ((-0.5f64).exp() + 1.0)).abs() < 1e-15);
        assert!((out.s1() - 0.5 * ((-0.5f64).exp() - 1.0)).abs() < 1e-15);
        let there = Vector2::new(-0.6e-3, 0.8e-3);
        let tensor = aperture.transfer(&point, &there).to_matrix();
        assert!((tensor[(0, 0)].re - (-0.25f64 - 1.0).exp()).abs() < 1e-15);
        assert!((tensor[(0, 3)].re - (-0.25f64).exp()).abs() < 1e-15);
        assert!((tensor[(3, 0)].re - (-1.0f64).exp()).abs() < 1e-15);
        assert!(GaussianAperture::new([0.0, 1.0]).is_err());
        assert!(polarization_grating(f64::NAN, 1.0).is_err());
    }
}
