//! The rough retardation plate: one random surface that takes coherence and polarization.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::Wavelength;

use super::Element;
use super::screen::{ScreenError, decorrelation, gaussian_moment, not_negative, positive};
use crate::sixteen::TransferTensor;

/// Its name in messages.
const ELEMENT: &str = "rough retarder";

/// Depolarizing retardation plate with one rough surface, at normal incidence.
///
/// Model: a thin birefringent plate with its principal axes along `x` and `y`, indices `n_x` and `n_y`, of thickness
/// `t + h(r)` in a medium of index `n₀`. One Gaussian height `h`, with correlation `e^{−d²/l²}`, delays both axes:
///
/// ```text
/// T = diag(e^{−iφ_x}, e^{−iφ_y}),   φ_i = k₀ (n_i − n₀)(t + h),   s_i = k₀ (n_i − n₀) σ_h
/// ```
///
/// so the two phases are fully correlated and differ by a random retardance of standard deviation
/// `s = k₀ |n_x − n_y| σ_h`. Light at 45° to the axes keeps the degree of polarization `e^{−s²/2}`. Neglected:
/// reflection at the surfaces, refraction at the slopes.
///
/// Source: the plate of Ma et al. 2015, J. Opt. Soc. Am. A 32, 2346, a rough retardation plate with zero-mean Gaussian
/// statistics; the formulas are those of [`crate::PhaseScreen`].
///
/// Calcite, 0.3 µm rough, in sodium light:
/// ```
/// use csdm::{Element, RoughRetarder};
/// use stokes::{StokesVector, Wavelength};
/// let light = Wavelength::from_metres(589.3e-9)?;
/// let plate = RoughRetarder::new(light, [1.658, 1.486], 1.0, 1e-3, 0.3e-6, 20e-6)?;
/// let degree = (plate.mueller_at(&nalgebra::Vector2::zeros()) * StokesVector::DIAGONAL).degree_of_polarization();
/// let s = plate.retardance_deviation();
/// assert!((s - 0.5502).abs() < 1e-4 && (degree - (-0.5 * s * s).exp()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughRetarder {
    mean_retardance: f64,
    deviations: [f64; 2],
    length: f64,
}

impl RoughRetarder {
    /// A plate with `indices` along `x` and `y` in a medium of index `outside`, mean `thickness` t, standard deviation
    /// `roughness` σ_h and correlation length `length` l of its surface, all in metres.
    ///
    /// # Errors
    ///
    /// When an index or the length is not positive, or the thickness or the roughness is negative.
    pub fn new(
        wavelength: Wavelength,
        indices: [f64; 2],
        outside: f64,
        thickness: f64,
        roughness: f64,
        length: f64,
    ) -> Result<Self, ScreenError> {
        let [nx, ny] = indices;
        positive(ELEMENT, "the index along x", nx)?;
        positive(ELEMENT, "the index along y", ny)?;
        positive(ELEMENT, "the index outside", outside)?;
        not_negative(ELEMENT, "the thickness", thickness)?;
        not_negative(ELEMENT, "the roughness", roughness)?;
        positive(ELEMENT, "the correlation length of the surface", length)?;
        let k0 = wavelength.wavenumber().radians_per_metre();
        Ok(Self {
            mean_retardance: k0 * (ny - nx) * thickness,
            deviations: [nx, ny].map(|n| k0 * (n - outside) * roughness),
            length,
        })
    }

    /// Mean retardance `k₀ (n_y − n_x) t` of the `y` axis behind the `x` axis, radians.
    #[must_use]
    pub fn mean_retardance(&self) -> f64 {
        self.mean_retardance
    }

    /// Standard deviations of the phases along `x` and `y`, `k₀ (n_i − n₀) σ_h`, radians; negative where the index is below
    /// that outside.
    #[must_use]
    pub fn deviations(&self) -> [f64; 2] {
        self.deviations
    }

    /// Length at which the correlation of the surface falls to `1/e`, metres.
    #[must_use]
    pub fn correlation_length(&self) -> f64 {
        self.length
    }

    /// Standard deviation of the retardance, `k₀ |n_x − n_y| σ_h`, radians.
    #[must_use]
    pub fn retardance_deviation(&self) -> f64 {
        (self.deviations[0] - self.deviations[1]).abs()
    }
}

impl Element for RoughRetarder {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let loss = decorrelation((first - second).norm(), self.length);
        let [sx, sy] = self.deviations;
        // T_xx T*_yy has the phase φ_y − φ_x: y is delayed by the retardance
        let cross = Complex64::cis(self.mean_retardance) * gaussian_moment(sx, sy, loss);
        TransferTensor::of_diagonal(Matrix2::new(
            gaussian_moment(sx, sx, loss).into(),
            cross,
            cross.conj(),
            gaussian_moment(sy, sy, loss).into(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::screen::tests::normal_average;
    use stokes::StokesVector;

    #[test]
    fn a_rough_retardation_plate_has_the_published_degree_of_polarization() {
        // e^{−s²/2}: .9692, .8825, .6065, .1353
        let light = Wavelength::from_metres(500e-9).unwrap();
        let k0 = light.wavenumber().radians_per_metre();
        for (s, degree) in [(0.25, 0.9692), (0.5, 0.8825), (1.0, 0.6065), (2.0, 0.1353)] {
            let roughness = s / (k0 * 0.1);
            let plate = RoughRetarder::new(light, [1.5, 1.6], 1.0, 2e-6, roughness, 1e-5).unwrap();
            let out = plate.mueller_at(&Vector2::zeros()) * StokesVector::DIAGONAL;
            assert!((out.degree_of_polarization() - degree).abs() < 5e-5);
            assert!((out.degree_of_polarization() - (-0.5 * s * s).exp()).abs() < 1e-14);
            // light along an axis keeps its polarization
            let along = plate.mueller_at(&Vector2::zeros()) * StokesVector::HORIZONTAL;
            assert!((along - StokesVector::HORIZONTAL).to_vector().norm() < 1e-15);
        }
    }

    #[test]
    fn a_smooth_retardation_plate_is_a_retarder() {
        let light = Wavelength::from_metres(500e-9).unwrap();
        // y slower by 0.01 · 12.5 µm = λ/4
        let plate = RoughRetarder::new(light, [1.5, 1.51], 1.0, 12.5e-6, 0.0, 1.0).unwrap();
        let expected = crate::JonesMatrix::linear_retarder(plate.mean_retardance()).mueller();
        let found = plate.mueller_at(&Vector2::zeros());
        assert!((found.to_matrix() - expected.to_matrix()).amax() < 1e-15);
        assert!((found * StokesVector::DIAGONAL).s3() < -0.999_999);
    }

    #[test]
    fn a_rough_plate_takes_coherence_by_both_phases_and_polarization_by_their_difference() {
        let light = Wavelength::from_metres(500e-9).unwrap();
        let plate = RoughRetarder::new(light, [1.5, 1.6], 1.0, 1e-6, 60e-9, 1e-5).unwrap();
        let k0 = light.wavenumber().radians_per_metre();
        let phase = |n: f64, h: f64| -k0 * (n - 1.0) * (1e-6 + h * 60e-9);
        let there = Vector2::new(4e-6, 3e-6);
        let tensor = plate.transfer(&Vector2::zeros(), &there).to_matrix();
        let average = |ni: f64, nj: f64| {
            normal_average((-0.25f64).exp(), |a, b| {
                Complex64::cis(phase(ni, a) - phase(nj, b))
            })
        };
        assert!((tensor[(0, 0)] - average(1.5, 1.5)).norm() < 1e-13);
        assert!((tensor[(0, 3)] - average(1.5, 1.6)).norm() < 1e-13);
        assert!((tensor[(3, 0)] - average(1.6, 1.5)).norm() < 1e-13);
        assert!((tensor[(3, 3)] - average(1.6, 1.6)).norm() < 1e-13);
    }
}
