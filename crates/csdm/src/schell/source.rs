//! The electromagnetic Gaussian Schell-model source, and the light that it sends.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector, Wavelength,
};

use super::SchellError;
use super::beam::{Element, SchellBeam};
use crate::abcd::{AstigmaticTransfer, RayTransfer};

/// An electromagnetic Gaussian Schell-model source: round, all elements with the same spread of intensity.
///
/// ```text
/// W_ij(r1, r2) = A_i A_j B_ij e^{−(r1² + r2²)/(4σ²)} e^{−(r1 − r2)²/(2δ_ij²)},      B_ii = 1
/// ```
///
/// Source: Korotkova & Wolf (2005). Their `⟨E_i* E_j⟩` in `exp(−iωt)` is our `⟨E_i E_j*⟩` in `exp(+iωt)`: `B_xy` is
/// the same number, S3 has the other sign.
///
/// ```
/// use nalgebra::Vector2;
/// use num_complex::Complex64;
/// use stokes::Wavelength;
/// let red = Wavelength::from_metres(632.8e-9)?;
/// let none = Complex64::new(0.0, 0.0);
/// let source = csdm::SchellSource::new(red, [1.0, 1.0], none, 1e-2, [2e-4, 4e-4, 3.2e-4])?;
/// // unpolarized light that becomes 56 % polarized by travelling 100 m
/// let far = source.beam().through(&csdm::AstigmaticTransfer::round(&csdm::RayTransfer::free_space(100.0)?));
/// let light = far.stokes(&Vector2::zeros());
/// assert!((light.s1() / light.s0() + 0.5643040).abs() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchellSource {
    wavelength: Wavelength,
    amplitudes: [f64; 2],
    correlation: Complex64,
    sigma: f64,
    widths: [f64; 3],
}

impl SchellSource {
    /// The source with amplitudes `[A_x, A_y]` (roots of the peak spectral densities), their correlation `B_xy`, the
    /// standard deviation `sigma` of intensity and coherence widths `[δ_xx, δ_yy, δ_xy]`, in metres.
    ///
    /// # Errors
    ///
    /// When a length is not positive, an amplitude is negative, or `|B_xy|` exceeds 1. Whether a field has such
    /// correlations is [`SchellSource::realizability`].
    pub fn new(
        wavelength: Wavelength,
        amplitudes: [f64; 2],
        correlation: Complex64,
        sigma: f64,
        widths: [f64; 3],
    ) -> Result<Self, SchellError> {
        let check = |holds: bool, what, value, expected| {
            if holds {
                Ok(())
            } else {
                Err(SchellError::Number {
                    what,
                    value,
                    expected,
                })
            }
        };
        for value in amplitudes {
            let holds = value >= 0.0 && value.is_finite();
            check(
                holds,
                "an amplitude",
                value,
                "a finite number, not negative",
            )?;
        }
        let modulus = correlation.norm();
        check(modulus <= 1.0, "|Bxy|", modulus, "a number in 0..=1")?;
        let expected = "a finite positive length in metres";
        for value in [sigma, widths[0], widths[1], widths[2]] {
            // squares of the widths and of their inverses have to be numbers
            let holds = (1e-70..=1e70).contains(&value);
            check(holds, "a width", value, expected)?;
        }
        Ok(Self {
            wavelength,
            amplitudes,
            correlation,
            sigma,
            widths,
        })
    }

    /// Whether a field has these correlations: `(δxx² + δyy²)/2 ≤ δxy² ≤ δxx δyy/|Bxy|`, necessary and sufficient.
    ///
    /// # Errors
    ///
    /// When it has not (to 1e-12 of the limits), with the limits.
    pub fn realizability(&self) -> Result<(), SchellError> {
        let [xx, yy, width] = self.widths;
        let b = self.correlation.norm();
        if b == 0.0 || self.amplitudes.contains(&0.0) {
            // no correlation of the two fields to be realized
            return Ok(());
        }
        let least = xx.hypot(yy) / 2f64.sqrt();
        let most = (xx * yy / b).sqrt();
        if width >= least * (1.0 - 1e-12) && width <= most * (1.0 + 1e-12) {
            Ok(())
        } else {
            Err(SchellError::NotRealizable { width, least, most })
        }
    }

    /// `(λ²/(2π²)) (1/(4σ²) + 1/δ²)`, the larger of xx and yy: what has to be much less than 1 for the light to be a
    /// beam.
    #[must_use]
    pub fn divergence_ratio(&self) -> f64 {
        let lambda = self.wavelength.metres();
        let [xx, yy, _] = self.transverse();
        lambda * lambda / (2.0 * PI * PI) / xx.min(yy)
    }

    /// `ℓ²` of the three elements: `1/ℓ² = 1/(4σ²) + 1/δ²`.
    fn transverse(&self) -> [f64; 3] {
        self.widths.map(|delta| {
            let inverse = 0.25 / (self.sigma * self.sigma) + 1.0 / (delta * delta);
            1.0 / inverse
        })
    }

    /// `A_i A_j B_ij` for xx, yy and xy.
    fn amplitudes(&self) -> [Complex64; 3] {
        let [x, y] = self.amplitudes;
        [(x * x).into(), (y * y).into(), self.correlation * x * y]
    }

    /// The light in the plane of the source.
    #[must_use]
    pub fn beam(&self) -> SchellBeam {
        let (amplitudes, ells) = (self.amplitudes(), self.transverse());
        SchellBeam {
            wavelength: self.wavelength,
            elements: std::array::from_fn(|i| Element {
                amplitude: amplitudes[i],
                spread: Matrix2::from_diagonal_element(self.sigma * self.sigma),
                coherence: Matrix2::from_diagonal_element(ells[i]),
                curvature: Matrix2::zeros(),
            }),
        }
    }

    /// The Stokes vector at `rho` across the axis and `z` along it, metres, after free space.
    ///
    /// # Errors
    ///
    /// When `z` is not finite.
    pub fn stokes(&self, rho: &Vector2<f64>, z: f64) -> Result<StokesVector, SchellError> {
        let space = RayTransfer::free_space(z).map_err(|_| SchellError::Number {
            what: "the distance",
            value: z,
            expected: "a finite number of metres",
        })?;
        Ok(self
            .beam()
            .through(&AstigmaticTransfer::round(&space))
            .stokes(rho))
    }

    /// Coherence widths `[δ_xx, δ_yy, δ_xy]` after `z` metres of free space, m: each grows with its own beam.
    #[must_use]
    pub fn coherence_widths(&self, z: f64) -> [f64; 3] {
        let k = self.wavelength.wavenumber().radians_per_metre();
        let ells = self.transverse();
        std::array::from_fn(|i| {
            let spread = z / (k * self.sigma * ells[i].sqrt());
            self.widths[i] * 1f64.hypot(spread)
        })
    }

    /// The radiance of the source's centre at `sine` of the angle from its axis, `[S0, S1, S2, S3]` in the source's
    /// axes projected across the ray; unit of `A²` per steradian.
    ///
    /// Without Walther's cosine, so that its integral over the hemisphere against the cosine is the exitance: that
    /// of a Gaussian in `sin θ`. Elsewhere on the source it is `e^(−x²/(2σ²))` times as much.
    #[must_use]
    pub fn radiance(&self, sine: f64) -> StokesVector {
        let k = self.wavelength.wavenumber().radians_per_metre();
        let (amplitudes, ells) = (self.amplitudes(), self.transverse());
        let [xx, yy, xy]: [Complex64; 3] = std::array::from_fn(|i| {
            let k2l2 = k * k * ells[i];
            amplitudes[i] * (k2l2 / (2.0 * PI)) * (-0.5 * k2l2 * sine * sine).exp()
        });
        StokesVector::new(xx.re + yy.re, xx.re - yy.re, 2.0 * xy.re, -2.0 * xy.im)
    }

    /// The light that the whole source sends along the unit vector `direction`, `distance` metres away.
    ///
    /// `source` is its frame: `z` the axis, `x` and `y` those of the amplitudes; the light's frame has `source.x()`
    /// projected across the ray. One Gaussian shape for all four parameters, since the elements share their spread.
    ///
    /// # Errors
    ///
    /// When no field has these correlations, the direction does not lead forward, or the distance is no far field.
    pub fn light(
        &self,
        source: &Frame,
        direction: &Vector3<f64>,
        distance: f64,
    ) -> Result<GeneralizedStokes, SchellError> {
        self.realizability()?;
        let frame = Frame::with_x_along(*direction, source.x())?;
        let cosine = frame.z().dot(&source.z());
        if cosine.is_nan() || cosine <= 0.0 {
            return Err(SchellError::Behind { cosine });
        }
        let project = Matrix2::new(
            source.x().dot(&frame.x()),
            source.x().dot(&frame.y()),
            source.y().dot(&frame.x()),
            source.y().dot(&frame.y()),
        );
        let shape = ShapeMatrix::from_root(&(project * self.sigma))?;
        let sine = frame.z().cross(&source.z()).norm();
        let area = 2.0 * PI * self.sigma * self.sigma;
        // φ_00(0) = √(|det W|/π)
        let modes = HermiteSeries::fundamental((PI / shape.root_determinant()).sqrt());
        let components = Components::Shared {
            modes,
            stokes: self.radiance(sine) * (area * cosine),
        };
        Ok(GeneralizedStokes::new(
            components,
            shape,
            frame,
            self.wavelength,
            distance,
        )?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: f64 = 632.8e-9;

    fn source(amplitudes: [f64; 2], b: Complex64, sigma: f64, widths: [f64; 3]) -> SchellSource {
        let red = Wavelength::from_metres(RED).unwrap();
        SchellSource::new(red, amplitudes, b, sigma, widths).unwrap()
    }

    fn uncorrelated(amplitudes: [f64; 2], sigma: f64, dx: f64, dy: f64) -> SchellSource {
        source(
            amplitudes,
            Complex64::new(0.0, 0.0),
            sigma,
            [dx, dy, dx.hypot(dy)],
        )
    }

    /// S1/S0 on the axis at distance z, published to the digits given.
    #[test]
    fn an_unpolarized_source_becomes_polarized_on_the_way() {
        let equal = uncorrelated([1.0, 1.0], 1e-2, 2e-4, 4e-4);
        let weaker_y = uncorrelated([1.0, 0.5f64.sqrt()], 1e-2, 2e-4, 4e-4);
        let ratio = |source: &SchellSource, z: f64| {
            let light = source.stokes(&Vector2::zeros(), z).unwrap();
            light.s1() / light.s0()
        };
        for (z, expected, half_unit) in [
            (0.0, 0.0, 1e-15),
            (1.0, -0.000_949_416, 5e-10),
            (10.0, -0.082_081_2, 5e-8),
            (100.0, -0.564_304_0, 5e-8),
            (1000.0, -0.599_525_8, 5e-8),
            (1e7, -0.599_904_0, 5e-8),
        ] {
            assert!((ratio(&equal, z) - expected).abs() < half_unit, "{z}");
        }
        for (z, expected) in [
            (0.0, 0.333_333_3),
            (1.0, 0.332_489_1),
            (10.0, 0.258_319_8),
            (100.0, -0.284_482_1),
            (1000.0, -0.332_674_8),
            (1e7, -0.333_200_0),
        ] {
            assert!((ratio(&weaker_y, z) - expected).abs() < 5e-8, "{z}");
        }
    }

    /// S1/S0 against the angle from the axis; the radiance follows sin θ.
    #[test]
    fn polarization_depends_on_the_direction() {
        let source = uncorrelated([1.0, 1.0], 1e-2, 1e-6, 2e-6);
        for (theta, expected) in [
            (0.0f64, -0.6),
            (0.02, -0.580_74),
            (0.05, -0.468_73),
            (0.08, -0.217_40),
            (0.12, 0.350_93),
            (0.2, 0.976_93),
        ] {
            let light = source.radiance(theta.sin());
            assert!(
                (light.s1() / light.s0() - expected).abs() < 5.1e-6,
                "{theta}"
            );
        }
        assert!(
            source
                .radiance(0.096_972_7f64.sin())
                .degree_of_polarization()
                < 1e-5
        );
    }

    #[test]
    fn correlated_fields_have_the_published_polarization() {
        let source = source(
            [1.0, 1.0],
            Complex64::new(0.3, 0.2),
            1e-2,
            [1e-6, 2e-6, 1.8e-6],
        );
        source.realizability().unwrap();
        let light = source.radiance(0.1f64.sin());
        let expected = [1.0, 0.043_778, 0.337_541, -0.225_027];
        for (found, expected) in light.to_array().into_iter().zip(expected) {
            assert!((found / light.s0() - expected).abs() < 6e-7, "{found}");
        }
        assert!((light.degree_of_polarization() - 0.408_029).abs() < 6e-7);
    }

    #[test]
    fn the_limits_of_the_cross_coherence_are_sharp() {
        let at = |b: f64, width: f64| {
            source(
                [1.0, 1.0],
                Complex64::new(0.0, b),
                1e-2,
                [1e-6, 2e-6, width],
            )
            .realizability()
        };
        let edge = 2.5f64.sqrt() * 1e-6;
        assert!(at(0.8, edge).is_ok());
        let text = at(0.81, edge).unwrap_err().to_string();
        assert!(text.contains("δxy"), "{text}");
        assert!(at(0.8, 0.99 * edge).is_err() && at(0.0, 0.1 * edge).is_ok());
    }

    #[test]
    fn wrong_numbers_are_named() {
        let red = Wavelength::from_metres(RED).unwrap();
        let make = |a: f64, b: f64, sigma: f64, width: f64| {
            SchellSource::new(
                red,
                [a, 1.0],
                Complex64::new(b, 0.0),
                sigma,
                [width, 1e-3, 1e-3],
            )
        };
        for (broken, what) in [
            (make(-1.0, 0.0, 1e-2, 1e-3), "amplitude"),
            (make(1.0, 1.1, 1e-2, 1e-3), "|Bxy|"),
            (make(1.0, f64::NAN, 1e-2, 1e-3), "|Bxy|"),
            (make(1.0, 0.0, 0.0, 1e-3), "width"),
            (make(1.0, 0.0, 1e-2, f64::INFINITY), "width"),
        ] {
            let text = broken.unwrap_err().to_string();
            assert!(text.contains(what), "{text}");
        }
    }

    #[test]
    fn the_far_field_of_the_light_is_that_of_the_beam() {
        let source = source(
            [1.0, 0.8],
            Complex64::new(0.1, 0.2),
            1e-3,
            [1e-4, 1.2e-4, 1.3e-4],
        );
        let frame = Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap();
        let distance = 1e5;
        let tilt = 2e-4f64;
        let direction = Vector3::new(tilt, 0.0, (1.0 - tilt * tilt).sqrt());
        let light = source.light(&frame, &direction, distance).unwrap();
        let beam = source
            .stokes(&Vector2::new(tilt * distance, 0.0), distance)
            .unwrap();
        // paraxial against exact direction: tilt² ; near against far field: (kσℓ/z)²
        let relative = (light.stokes().stokes - beam).to_vector().norm() / beam.s0();
        assert!(relative < 1e-5, "{relative}");
        let widths = light.shape().theta();
        assert!((widths.m11 * 1e-6 - 1.0).abs() < 1e-6);
    }
}
