//! Heights with a Gaussian correlation, by the plain Poisson sum: slow, and short enough to be seen to be right.

use mueller16::{
    Approximation, Autocorrelation, AutocorrelationError, GaussianTerm, Method, Relief, Tolerance,
};
use nalgebra::{Matrix2, Vector3};
use stokes::Wavelength;

/// Of standard deviation `sigma` and correlation `e^(−x²/l²)`, metres; `exponent` replaces `(φ_z σ)²` where it is given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainHeights {
    pub(crate) sigma: f64,
    pub(crate) length: f64,
    pub(crate) exponent: Option<f64>,
}

impl Relief for PlainHeights {
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let g = self.exponent.unwrap_or((phi_z * self.sigma).powi(2));
        let mut terms = vec![GaussianTerm::centred((-g).exp(), 0.0)];
        // e^(−g) g^m/m! from its logarithm, within 9 deviations of the Poisson distribution
        let spread = 9.0 * g.sqrt() + 9.0;
        let first = (g - spread).max(1.0).floor() as u32;
        let mut log_factorial: f64 = (1..first).map(|m| f64::from(m).ln()).sum();
        for m in first..=(g + spread) as u32 {
            log_factorial += f64::from(m).ln();
            let weight = (f64::from(m) * g.ln() - g - log_factorial).exp();
            if weight > 0.01 * tolerance.get() * (-(-g).exp_m1()) / (1.0 + g) {
                terms.push(GaussianTerm::centred(weight, f64::from(m)));
            }
        }
        let root = Matrix2::from_diagonal_element(self.length / 2f64.sqrt());
        let approximation = Approximation {
            method: Method::PoissonSum,
            terms: terms.len(),
            error: 0.1 * tolerance.get(),
        };
        Ok((Autocorrelation::of_family(&root, terms)?, approximation))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        let slope = 2f64.sqrt() * self.sigma / self.length;
        Some(Matrix2::from_diagonal_element(slope * slope))
    }
}

pub(crate) const WAVELENGTH: f64 = 500e-9;

pub(crate) fn green() -> Wavelength {
    Wavelength::from_metres(WAVELENGTH).unwrap()
}

/// In wavelengths.
pub(crate) fn heights(sigma: f64, length: f64) -> PlainHeights {
    PlainHeights {
        sigma: sigma * WAVELENGTH,
        length: length * WAVELENGTH,
        exponent: None,
    }
}

pub(crate) fn direction(polar: f64, azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = polar.sin_cos();
    Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}
