//! Partially coherent light as a list of incoherent plane waves, as many as a tolerance needs over given separations.
//!
//! ```text
//! γ(x) = Σ_i p_i e^(−i q_i·x)            |error| ≤ tolerance for every separation within the extent
//! ```
//!
//! Which nodes: for a Gaussian of root V (`q = Vᵀu`) Gauss-Hermite nodes where the phase `Y = max |(Vx)_i|` is small, by
//! `n! Y^(2n)/(2n)!`; else, and for every Hermite-Gauss series, the trapezoidal rule, whose only error but the cut tail is
//! γ itself one period of the grid away (Poisson). For a rectangular source Gauss-Legendre, for a disk Gauss-Legendre in
//! the square of the radius and equal angles; their remainders are those of the Gauss rules for `cos` and `J_0`.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::HermiteSeries;

use super::error::OpeningError;
use super::rules::{
    Rule, check_count, gaussian_rule, least_count, legendre, legendre_remainder, legendre_rule,
    ln_factorial, trapezoidal_rule,
};
use crate::accuracy::Tolerance;
use crate::incident::IncidentCoherence;

/// One plane wave: its tangential wave vector beside that of the ray to the source's phase centre, and its share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneWave {
    /// `n k₀ Tᵀθ`, rad/m, θ the apparent place of the source's point in radians.
    pub wave_vector: Vector2<f64>,
    /// Dimensionless. Those of light add up to 1.
    pub weight: f64,
}

/// Light as incoherent plane waves: for a screen, all that coherence is.
///
/// ```
/// use mueller16::{AngularSpectrum, Tolerance};
/// use nalgebra::{Matrix2, Vector2};
/// // a lamp of half-angle 1 mrad in green light; coherence over 0.2 mm is 2 J₁(u)/u, u = k α x
/// let k = std::f64::consts::TAU / 550e-9;
/// let reach = Tolerance::relative(1e-9)?;
/// let lamp = AngularSpectrum::disk(&Matrix2::from_diagonal_element(1e-3 * k), [2e-4; 2], reach)?;
/// let gamma = lamp.degree_of_coherence(&Vector2::new(1e-4, 0.0));
/// assert!((gamma.re - 0.8455).abs() < 1e-4 && gamma.im.abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AngularSpectrum {
    waves: Vec<PlaneWave>,
    error: f64,
}

impl AngularSpectrum {
    /// Fully coherent light.
    #[must_use]
    pub fn plane_wave() -> Self {
        let wave = PlaneWave {
            wave_vector: Vector2::zeros(),
            weight: 1.0,
        };
        Self {
            waves: vec![wave],
            error: 0.0,
        }
    }

    /// The light of given incoherent points; weights as they are.
    ///
    /// # Errors
    ///
    /// When there is none or a number is not finite.
    pub fn of_waves(waves: Vec<PlaneWave>) -> Result<Self, OpeningError> {
        let wrong = |what, value| OpeningError::Value {
            what,
            value,
            expected: "a finite number",
        };
        if waves.is_empty() {
            return Err(OpeningError::Value {
                what: "the number of plane waves",
                value: 0.0,
                expected: "at least 1",
            });
        }
        for wave in &waves {
            let q = wave.wave_vector;
            for (what, value) in [
                ("a wave vector", q.x),
                ("a wave vector", q.y),
                ("a weight", wave.weight),
            ] {
                if !value.is_finite() {
                    return Err(wrong(what, value));
                }
            }
        }
        Ok(Self { waves, error: 0.0 })
    }

    /// Light of this coherence, for separations up to `extent` metres along each tangent ([`super::Openings::extent`]).
    ///
    /// # Errors
    ///
    /// When the tolerance needs more than 2²⁰ waves, or an extent is not a length.
    pub fn of_coherence(
        light: &IncidentCoherence,
        extent: [f64; 2],
        tolerance: Tolerance,
    ) -> Result<Self, OpeningError> {
        Self::of_series(light.root(), light.modes(), extent, tolerance.get())
    }

    /// As [`AngularSpectrum::of_coherence`], for `Σ c_ab h_a(y₁) h_b(y₂)`, y = V x, of any value at 0: one component of
    /// polarized light. The error is absolute.
    pub(super) fn of_series(
        root: &Matrix2<f64>,
        series: &HermiteSeries,
        extent: [f64; 2],
        tolerance: f64,
    ) -> Result<Self, OpeningError> {
        let phases = phases(root, extent)?;
        // functions of modulus at most 1, of which this much is added up
        let size = match series.order() {
            0 => series.sum_at_zero().abs(),
            _ => series.real_coefficients().iter().map(|s| s.abs()).sum(),
        };
        if size == 0.0 {
            // no light: any one wave has none of it
            let mut dark = Self::plane_wave();
            dark.waves[0].weight = 0.0;
            return Ok(dark);
        }
        let epsilon = (0.5 * tolerance / size).clamp(1e-17, 0.25);
        let [first, second] = phases.map(|phase| match series.order() {
            0 => gaussian_rule(phase, epsilon),
            order => trapezoidal_rule(order, phase, epsilon),
        });
        let (first, second) = (first?, second?);
        let mut product = product(root, [&first, &second], phases)?;
        product.error *= size;
        if series.order() == 0 {
            let value = series.sum_at_zero();
            for wave in &mut product.waves {
                wave.weight *= value;
            }
            return Ok(product);
        }
        let places = first
            .nodes
            .iter()
            .flat_map(|u| second.nodes.iter().map(move |v| (u.0, v.0)));
        for (wave, (u, v)) in product.waves.iter_mut().zip(places) {
            // (−1)^(a+b) s_ab h_a(u) h_b(v)/2π: the parity of the modes is in the sign
            wave.weight *= series.real_sum(&Vector2::new(-u, -v)) / std::f64::consts::TAU;
        }
        let largest = product
            .waves
            .iter()
            .map(|w| w.weight.abs())
            .fold(0.0, f64::max);
        // what all the dropped ones weigh together is below the rounding of the sum
        let least = largest * 1e-17 / product.waves.len() as f64;
        product.waves.retain(|wave| wave.weight.abs() > least);
        Ok(product)
    }

    /// Light of a uniform rectangular source: wave vectors `spread·u`, `|u₁|, |u₂| ≤ 1`; `spread` 2×2, rad/m.
    ///
    /// # Errors
    ///
    /// As [`AngularSpectrum::of_coherence`]; when an entry of `spread` is not finite.
    pub fn rectangle(
        spread: &Matrix2<f64>,
        extent: [f64; 2],
        tolerance: Tolerance,
    ) -> Result<Self, OpeningError> {
        let root = spread.transpose();
        let phases = phases(&root, extent)?;
        let [first, second] = phases.map(|phase| legendre_rule(phase, 0.5 * tolerance.get()));
        product(&root, [&first?, &second?], phases)
    }

    /// Light of a uniform elliptic source: wave vectors `spread·u`, `|u| ≤ 1`; `spread` 2×2, rad/m.
    ///
    /// # Errors
    ///
    /// As [`AngularSpectrum::rectangle`].
    pub fn disk(
        spread: &Matrix2<f64>,
        extent: [f64; 2],
        tolerance: Tolerance,
    ) -> Result<Self, OpeningError> {
        let root = spread.transpose();
        let [y1, y2] = phases(&root, extent)?;
        let phase = y1.hypot(y2);
        let (radial, radial_error) = least_count(0.5 * tolerance.get(), phase, |n| {
            // f = J_0(Y√t) on 0..1: |f^(2n)| ≤ (Y²/4)^(2n)/(2n)!
            let derivative = 2.0 * n * (0.25 * phase * phase).ln() - ln_factorial(2.0 * n);
            legendre_remainder(n) + derivative
        })?;
        let (angular, angular_error) = least_count(0.5 * tolerance.get(), phase, |n| {
            // aliases 2 Σ |J_(mn)(Y)|, |J_n(Y)| ≤ (Y/2)^n/n!, the second beyond the first by less than it
            4f64.ln() + n * (0.5 * phase).ln() - ln_factorial(n)
        })?;
        check_count(radial as f64 * angular as f64, phase)?;
        let angles = (0..angular)
            .map(|i| (std::f64::consts::TAU * (i as f64 + 0.5) / angular as f64).sin_cos());
        let rule = legendre(radial);
        let waves = rule
            .iter()
            .flat_map(|(t, weight)| {
                let radius = (0.5 + 0.5 * t).sqrt();
                angles.clone().map(move |(sin, cos)| PlaneWave {
                    wave_vector: spread * Vector2::new(radius * cos, radius * sin),
                    weight: 0.5 * weight / angular as f64,
                })
            })
            .collect();
        Ok(Self {
            waves,
            error: radial_error + angular_error,
        })
    }

    /// The plane waves.
    #[must_use]
    pub fn waves(&self) -> &[PlaneWave] {
        &self.waves
    }

    /// Bound on the error of `γ(x)` within the extent that was asked for.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// `γ(x) = Σ p e^(−iq·x)` at a separation in the surface, m.
    #[must_use]
    pub fn degree_of_coherence(&self, x: &Vector2<f64>) -> Complex64 {
        self.waves
            .iter()
            .map(|wave| Complex64::from_polar(wave.weight, -wave.wave_vector.dot(x)))
            .sum()
    }
}

/// `max |(V x)_i|` over the extent.
fn phases(root: &Matrix2<f64>, extent: [f64; 2]) -> Result<[f64; 2], OpeningError> {
    for (what, value) in [
        ("the extent along x", extent[0]),
        ("the extent along y", extent[1]),
    ] {
        if !(0.0..=1e30).contains(&value) {
            return Err(OpeningError::Value {
                what,
                value,
                expected: "a length of at most 1e30 m",
            });
        }
    }
    let phase = |row: usize| root[(row, 0)].abs() * extent[0] + root[(row, 1)].abs() * extent[1];
    let phases = [phase(0), phase(1)];
    match phases.into_iter().find(|phase| !phase.is_finite()) {
        Some(value) => Err(OpeningError::Value {
            what: "the phase of the light over the openings",
            value,
            expected: "a finite number",
        }),
        None => Ok(phases),
    }
}

fn product(
    root: &Matrix2<f64>,
    [first, second]: [&Rule; 2],
    phases: [f64; 2],
) -> Result<AngularSpectrum, OpeningError> {
    let count = first.nodes.len() as f64 * second.nodes.len() as f64;
    check_count(count, phases[0].max(phases[1]))?;
    let map = root.transpose();
    let waves = first
        .nodes
        .iter()
        .flat_map(|(u, p)| {
            second.nodes.iter().map(move |(v, q)| PlaneWave {
                wave_vector: map * Vector2::new(*u, *v),
                weight: p * q,
            })
        })
        .collect();
    Ok(AngularSpectrum {
        waves,
        error: first.error + second.error,
    })
}
