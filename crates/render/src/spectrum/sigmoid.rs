//! Colours as smooth spectra between 0 and 1: the sigmoid of a quadratic in the wavelength,
//!
//! ```text
//! s(λ) = ½ + x/(2√(1 + x²)),   x = c₀t² + c₁t + c₂,   t = (λ − 360 nm)/470 nm
//! ```
//!
//! whose three coefficients are fitted when the scene is read, such that the spectrum has the colour under D65.
//!
//! Source: Jakob & Hanika 2019, A low-dimensional function space for efficient spectral upsampling.

use crate::colour::{self, FIRST_NM, LAST_NM};

/// Wavelength scaled to 0..1 over the visible range.
fn unit(nm: f64) -> f64 {
    (nm - FIRST_NM) / (LAST_NM - FIRST_NM)
}

fn polynomial([c0, c1, c2]: &[f64; 3], t: f64) -> f64 {
    (c0 * t + c1) * t + c2
}

/// The value at a wavelength, for given coefficients.
pub(super) fn value(coefficients: &[f64; 3], nm: f64) -> f64 {
    sigmoid(polynomial(coefficients, unit(nm)))
}

fn sigmoid(x: f64) -> f64 {
    0.5 + 0.5 * x / (1.0 + x * x).sqrt()
}

/// Derivative of [`sigmoid`].
fn slope(x: f64) -> f64 {
    0.5 / (1.0 + x * x).powf(1.5)
}

/// The `x` at which the sigmoid is `value`, for `value` inside 0..1.
fn logit(value: f64) -> f64 {
    let twice = 2.0 * value - 1.0;
    twice / (1.0 - twice * twice).sqrt()
}

/// Coefficients of the same value at every wavelength, inside 0..1.
pub(super) fn constant(value: f64) -> [f64; 3] {
    [0.0, 0.0, logit(value)]
}

/// Coefficients of the sigmoid whose colour under D65 is `rgb`, components in 0..1.
///
/// Damped Gauss-Newton along a straight way from the grey of the same mean, where the answer is known. Where a
/// colour cannot be reached the nearest point on the way is kept.
pub(super) fn fit(rgb: [f64; 3]) -> [f64; 3] {
    const STEPS: u32 = 16;
    let grey = (rgb.iter().sum::<f64>() / 3.0).clamp(0.01, 0.99);
    let mut coefficients = constant(grey);
    for step in 1..=STEPS {
        let on = f64::from(step) / f64::from(STEPS);
        let target = rgb.map(|c| grey + on * (c - grey));
        approach(&mut coefficients, target);
    }
    coefficients
}

/// Levenberg-Marquardt from where `coefficients` stand.
fn approach(coefficients: &mut [f64; 3], target: [f64; 3]) {
    use nalgebra::{Matrix3, Vector3};
    let target = Vector3::from(target);
    let mut damping = 1e-6;
    let (mut residual, mut jacobian) = response(coefficients, target);
    for _ in 0..60 {
        if residual.norm() < 1e-10 {
            return;
        }
        let normal = jacobian.transpose() * jacobian;
        let damped = normal + Matrix3::from_diagonal(&normal.diagonal()) * damping;
        let Some(inverse) = damped.try_inverse() else {
            return;
        };
        let step: Vector3<f64> = inverse * (jacobian.transpose() * residual);
        let trial = [0, 1, 2].map(|i| coefficients[i] - step[i]);
        let (trial_residual, trial_jacobian) = response(&trial, target);
        if trial_residual.norm() < residual.norm() {
            *coefficients = trial;
            (residual, jacobian) = (trial_residual, trial_jacobian);
            damping = (damping * 0.2).max(1e-12);
        } else {
            damping *= 10.0;
            if damping > 1e8 {
                return;
            }
        }
    }
}

/// Colour minus target, and its derivatives by the coefficients.
fn response(
    coefficients: &[f64; 3],
    target: nalgebra::Vector3<f64>,
) -> (nalgebra::Vector3<f64>, nalgebra::Matrix3<f64>) {
    let mut colour = -target;
    let mut jacobian = nalgebra::Matrix3::zeros();
    for (weights, row) in colour::white_weights().iter().zip(0u32..) {
        let t = unit(FIRST_NM + f64::from(row));
        let x = polynomial(coefficients, t);
        let (value, slope) = (sigmoid(x), slope(x));
        for (c, weight) in weights.iter().enumerate() {
            colour[c] += weight * value;
            jacobian[(c, 0)] += weight * slope * t * t;
            jacobian[(c, 1)] += weight * slope * t;
            jacobian[(c, 2)] += weight * slope;
        }
    }
    (colour, jacobian)
}

#[cfg(test)]
mod tests {
    use crate::colour::white_weights;
    use crate::spectrum::Spectrum;

    fn error_of(rgb: [f64; 3]) -> f64 {
        let spectrum = Spectrum::rgb_reflectance(rgb);
        let found = white_weights()
            .iter()
            .enumerate()
            .fold([0.0; 3], |sum, (row, weights)| {
                let value = f64::from(spectrum.value(360.0 + row as f32));
                [0, 1, 2].map(|c| sum[c] + weights[c] * value)
            });
        (0..3)
            .map(|c| (found[c] - rgb[c]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn reflectances_keep_their_colour() {
        // a grid over sRGB, in linear values
        let levels = [0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95];
        for r in levels {
            for g in levels {
                for b in levels {
                    let error = error_of([r, g, b]);
                    assert!(error < 1e-3, "{r} {g} {b}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_corners_of_srgb_come_near() {
        for corner in 1..7u8 {
            let rgb = [0, 1, 2].map(|c| f64::from(corner >> c & 1));
            let error = error_of(rgb);
            assert!(error < 0.02, "{rgb:?}: {error}");
        }
    }

    #[test]
    fn reflectances_lie_between_0_and_1() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [2.0, -1.0, 0.3]] {
            let spectrum = Spectrum::rgb_reflectance(rgb);
            assert!((360..=830).all(|nm| (0.0..=1.0).contains(&spectrum.value(nm as f32))));
        }
    }
}
