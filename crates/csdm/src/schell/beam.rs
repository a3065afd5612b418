//! A Gaussian Schell-model beam and what ABCD systems, apertures and random screens make of it.
//!
//! Each element of the cross-spectral density matrix is a Gaussian of the mean `m` and the difference `d` of the two
//! points, and every first-order system keeps it one:
//!
//! ```text
//! W_ij = A_ij e^{ −mᵀΣ⁻¹m/2 − dᵀL⁻¹d/2 + i mᵀK d }        ⟨xxᵀ⟩ = Σ,  ⟨xθᵀ⟩ = ΣK/k,  ⟨θθᵀ⟩ = L⁻¹/k² + KᵀΣK/k²
//! Σ' = (A + BKᵀ/k) Σ (A + BKᵀ/k)ᵀ + B L⁻¹ Bᵀ/k²           L' = (A + BK/k) L (A + BK/k)ᵀ + B Σ⁻¹ Bᵀ/k²
//! Σ'K' = k (A + BKᵀ/k) Σ (C + DKᵀ/k)ᵀ + B L⁻¹ Dᵀ/k         A'_ij = A_ij √(|Σ|/|Σ'|)
//! ```
//!
//! Both widths are sums of positive matrices: nothing cancels at any distance, where recovering `L'` from the
//! moments would lose all digits. Matrix elements are `⟨E_i(m − d/2) E_j*(m + d/2)⟩` in `exp(+iωt)`, so that the
//! spatial phase `+K` is that of the diverging wave `e^{+ikr}`; at one point `S3 = −2 Im W_xy`.
//!
//! Source: second moments of a Gaussian Wigner function under `V → S V Sᵀ`; for one axis Shirai & Wolf (2004).

use nalgebra::{Matrix2, SymmetricEigen, Vector2};
use num_complex::Complex64;
use stokes::{StokesVector, Wavelength};

use super::SchellError;
use crate::abcd::AstigmaticTransfer;

/// One Gaussian element of the cross-spectral density matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) amplitude: Complex64,
    /// Σ, m².
    pub(super) spread: Matrix2<f64>,
    /// L, m².
    pub(super) coherence: Matrix2<f64>,
    /// K, 1/m².
    pub(super) curvature: Matrix2<f64>,
}

impl Element {
    fn through(&self, system: &AstigmaticTransfer, k: f64) -> Self {
        let Self {
            spread: sigma,
            coherence: ell,
            curvature: kappa,
            ..
        } = *self;
        let AstigmaticTransfer { a, b, c, d } = *system;
        let bent = kappa.transpose() / k;
        let positions = a + b * bent;
        let slopes = c + d * bent;
        let twisted = a + b * kappa / k;
        let diverging = inverse(&ell) / k;
        let spread = positions * sigma * positions.transpose() + b * diverging * b.transpose() / k;
        let coherence =
            twisted * ell * twisted.transpose() + b * inverse(&sigma) * b.transpose() / (k * k);
        let joint = positions * sigma * slopes.transpose() * k + b * diverging * d.transpose();
        Self {
            amplitude: self.amplitude * (sigma.determinant() / spread.determinant()).sqrt(),
            spread,
            coherence,
            curvature: inverse(&spread) * joint,
        }
    }

    fn value(&self, mean: &Vector2<f64>, difference: &Vector2<f64>) -> Complex64 {
        let quadratic = |m: &Matrix2<f64>, v: &Vector2<f64>| v.dot(&(inverse(m) * v));
        let decay = quadratic(&self.spread, mean) + quadratic(&self.coherence, difference);
        let phase = mean.dot(&(self.curvature * difference));
        self.amplitude * (-0.5 * decay).exp() * Complex64::cis(phase)
    }
}

/// Inverse of a positive definite matrix.
fn inverse(m: &Matrix2<f64>) -> Matrix2<f64> {
    Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / m.determinant()
}

/// An electromagnetic Gaussian Schell-model beam in one transverse plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchellBeam {
    pub(super) wavelength: Wavelength,
    /// xx, yy, xy.
    pub(super) elements: [Element; 3],
}

impl SchellBeam {
    fn map(&self, change: impl FnMut(Element) -> Element) -> Self {
        Self {
            wavelength: self.wavelength,
            elements: self.elements.map(change),
        }
    }

    /// The beam behind an optical system.
    ///
    /// Source: second moments, `V → S V Sᵀ`; error of a few `f64::EPSILON` times the condition number of the widths.
    #[must_use]
    pub fn through(&self, system: &AstigmaticTransfer) -> Self {
        let k = self.wavelength.wavenumber().radians_per_metre();
        self.map(|element| element.through(system, k))
    }

    /// The beam behind an aperture of Gaussian amplitude transmittance `e^{−x²/w_x² − y²/w_y²}`, widths in metres; an
    /// infinite width is no aperture.
    ///
    /// # Errors
    ///
    /// When a width is not positive.
    pub fn through_aperture(&self, widths: [f64; 2]) -> Result<Self, SchellError> {
        let curb = widths.map(|w| 1.0 / (w * w));
        for (value, curb) in widths.into_iter().zip(curb) {
            if !(value > 0.0 && curb.is_finite()) {
                return Err(SchellError::Number {
                    what: "an aperture's width",
                    value,
                    expected: "a positive length",
                });
            }
        }
        let curb = Matrix2::from_diagonal(&curb.into());
        // e^{−r1²/w² − r2²/w²} = e^{−2m²/w² − d²/(2w²)}
        Ok(self.map(|element| {
            let spread = inverse(&(inverse(&element.spread) + curb * 4.0));
            Element {
                spread,
                coherence: inverse(&(inverse(&element.coherence) + curb)),
                ..element
            }
        }))
    }

    /// The beam behind a random phase screen, in the quadratic approximation of its correlation.
    ///
    /// `deviations` are the standard deviations of the phases of x and y in radians, `correlation` that between the
    /// two at one point, `lengths` the correlation lengths (xx, yy, xy) of `e^{−d²/l²}` in metres.
    ///
    /// # Errors
    ///
    /// When a deviation is negative or not finite, the correlation is beyond ±1, or a length is not positive.
    pub fn through_phase_screen(
        &self,
        deviations: [f64; 2],
        correlation: f64,
        lengths: [f64; 3],
    ) -> Result<Self, SchellError> {
        for value in deviations {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(SchellError::Number {
                    what: "a phase's standard deviation",
                    value,
                    expected: "a finite number of radians, not negative",
                });
            }
        }
        if !(-1.0..=1.0).contains(&correlation) {
            return Err(SchellError::Number {
                what: "the correlation of the two phases",
                value: correlation,
                expected: "a number in -1..=1",
            });
        }
        for value in lengths {
            if value.is_nan() || value <= 0.0 {
                return Err(SchellError::Number {
                    what: "a correlation length",
                    value,
                    expected: "a positive length",
                });
            }
        }
        let [sx, sy] = deviations;
        let pairs = [(sx, sx, 1.0), (sy, sy, 1.0), (sx, sy, correlation)];
        let mut screened = *self;
        for ((element, (s, t, c)), l) in screened.elements.iter_mut().zip(pairs).zip(lengths) {
            // ⟨e^{i(φ_i − φ_j)}⟩ = e^{−(s² + t²)/2 + s t c e^{−d²/l²}}
            element.amplitude *= (-0.5 * (s - t) * (s - t) - s * t * (1.0 - c)).exp();
            let washed = Matrix2::from_diagonal_element(2.0 * s * t * c / (l * l));
            let coherence = inverse(&element.coherence) + washed;
            let least = SymmetricEigen::new(coherence).eigenvalues.min();
            if least.is_nan() || least <= 0.0 {
                return Err(SchellError::Number {
                    what: "the inverse square of the cross-coherence behind the screen",
                    value: least,
                    expected: "a positive number: anticorrelated phases need a longer correlation length",
                });
            }
            element.coherence = inverse(&coherence);
        }
        Ok(screened)
    }

    /// The matrix `⟨E_i(m − d/2) E_j*(m + d/2)⟩` of two points with mean `m` and difference `d`, in metres.
    #[must_use]
    pub fn cross_spectral_density(
        &self,
        mean: &Vector2<f64>,
        difference: &Vector2<f64>,
    ) -> Matrix2<Complex64> {
        let [xx, yy, xy] = self.elements.map(|element| element.value(mean, difference));
        let [.., back] = self
            .elements
            .map(|element| element.value(mean, &-difference));
        Matrix2::new(xx, xy, back.conj(), yy)
    }

    /// The Stokes vector at one point of the plane, in the beam's frame.
    #[must_use]
    pub fn stokes(&self, at: &Vector2<f64>) -> StokesVector {
        let [xx, yy, xy] = self
            .elements
            .map(|element| element.value(at, &Vector2::zeros()));
        StokesVector::new(xx.re + yy.re, xx.re - yy.re, 2.0 * xy.re, -2.0 * xy.im)
    }

    /// Covariances `Σ` of the elements xx, yy and xy over the plane, m².
    #[must_use]
    pub fn spreads(&self) -> [Matrix2<f64>; 3] {
        self.elements.map(|element| element.spread)
    }

    /// Matrices `L` of the elements xx, yy and xy: they fall to e^(−1/2) where `dᵀL⁻¹d = 1`; m².
    #[must_use]
    pub fn coherences(&self) -> [Matrix2<f64>; 3] {
        self.elements.map(|element| element.coherence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abcd::RayTransfer;
    use crate::schell::SchellSource;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const RED: f64 = 632.8e-9;

    fn source(amplitudes: [f64; 2], b: Complex64, sigma: f64, widths: [f64; 3]) -> SchellSource {
        let red = Wavelength::from_metres(RED).unwrap();
        SchellSource::new(red, amplitudes, b, sigma, widths).unwrap()
    }

    /// The Collins integral of both points by brute force, one axis, as an oracle without moments.
    fn collins([sigma, delta]: [f64; 2], system: &RayTransfer, out: [f64; 2]) -> Complex64 {
        let k = 2.0 * PI / RED;

        let points = 1600;
        let reach = 9.0 * sigma;
        let step = 2.0 * reach / f64::from(points);
        let grid: Vec<f64> = (0..=points).map(|i| f64::from(i) * step - reach).collect();
        let kernel = |x: f64, x_out: f64| {
            let phase = system.a() * x * x - 2.0 * x * x_out + system.d() * x_out * x_out;
            Complex64::cis(0.5 * k / system.b() * phase) * (-x * x / (4.0 * sigma * sigma)).exp()
        };
        let first: Vec<_> = grid.iter().map(|x| kernel(*x, out[0])).collect();
        let second: Vec<_> = grid.iter().map(|x| kernel(*x, out[1]).conj()).collect();
        let mut sum = Complex64::new(0.0, 0.0);
        for (x1, f) in grid.iter().zip(&first) {
            for (x2, g) in grid.iter().zip(&second) {
                let d = x1 - x2;
                sum += f * g * (-d * d / (2.0 * delta * delta)).exp();
            }
        }
        sum * step * step * k / (2.0 * PI * system.b().abs())
    }

    #[test]
    fn a_lens_and_free_space_agree_with_the_collins_integral() {
        let (sigma, delta) = (1e-3, 4e-4);
        let source = source([1.0, 1.0], Complex64::new(0.0, 0.0), sigma, [delta; 3]);
        let system = RayTransfer::free_space(3.0).unwrap()
            * RayTransfer::thin_lens(2.0).unwrap()
            * RayTransfer::free_space(1.5).unwrap();
        let beam = source.beam().through(&AstigmaticTransfer::round(&system));
        let centre = collins([sigma, delta], &system, [0.0, 0.0]);
        for (r1, r2) in [(0.0, 0.0), (4e-4, -1e-4), (-8e-4, 3e-4)] {
            let mean = Vector2::new(0.5 * (r1 + r2), 0.0);
            let difference = Vector2::new(r1 - r2, 0.0);
            let found = beam.cross_spectral_density(&mean, &difference)[(0, 0)];
            let expected = collins([sigma, delta], &system, [r1, r2]);
            // the y axis contributes the same factor to every point of the x axis
            let on_axis = beam.cross_spectral_density(&Vector2::zeros(), &Vector2::zeros())[(0, 0)];
            let difference = (found / on_axis - expected / centre).norm();
            assert!(difference < 1e-10, "{difference}");
            // and is the root of the value on the axis
            assert!((on_axis.re.sqrt() - centre.re).abs() < 1e-10);
        }
    }

    #[test]
    fn a_screen_of_independent_phases_depolarizes() {
        // fully correlated fields: linear light at 45°
        let source = source(
            [1.0, 1.0],
            Complex64::new(1.0, 0.0),
            1e-3,
            [1e-4, 1e-4, 1e-4],
        );
        let behind = source
            .beam()
            .through_phase_screen([1.0, 1.0], 0.0, [1e-3; 3])
            .unwrap();
        let degree = behind.stokes(&Vector2::zeros()).degree_of_polarization();
        assert!((degree - (-1.0f64).exp()).abs() < 1e-15);
        let together = source
            .beam()
            .through_phase_screen([1.0, 1.0], 1.0, [1e-3; 3])
            .unwrap();
        assert!((together.stokes(&Vector2::zeros()).degree_of_polarization() - 1.0).abs() < 1e-15);
        assert!(
            source
                .beam()
                .through_phase_screen([1.0, -1.0], 0.0, [1e-3; 3])
                .is_err()
        );
        assert!(
            source
                .beam()
                .through_phase_screen([4.0, 4.0], -1.0, [1e-5; 3])
                .is_err()
        );
    }

    #[test]
    fn an_aperture_multiplies_the_two_transmittances() {
        let beam = source(
            [1.0, 0.7],
            Complex64::new(0.2, 0.1),
            1e-3,
            [1e-4, 2e-4, 1.6e-4],
        )
        .beam();
        let (wx, wy) = (4e-4, 9e-4);
        let behind = beam.through_aperture([wx, wy]).unwrap();
        let (r1, r2) = (Vector2::new(1e-4, -2e-4), Vector2::new(-5e-5, 3e-4));
        let t = |r: &Vector2<f64>| (-(r.x / wx).powi(2) - (r.y / wy).powi(2)).exp();
        let (mean, difference) = ((r1 + r2) * 0.5, r1 - r2);
        let found = behind.cross_spectral_density(&mean, &difference);
        let expected =
            beam.cross_spectral_density(&mean, &difference) * Complex64::from(t(&r1) * t(&r2));
        assert!((found - expected).norm() < 1e-14);
        assert!(beam.through_aperture([0.0, 1.0]).is_err());
        let open = beam.through_aperture([f64::INFINITY; 2]).unwrap();
        assert!((open.stokes(&r1) - beam.stokes(&r1)).to_vector().norm() < 1e-15);
    }

    proptest! {
        #[test]
        fn systems_compose(
            f in prop_oneof![0.2..5.0f64, -5.0..-0.2f64], z in 0.0..4.0f64, angle in 0.0..3.0f64,
        ) {
            let beam = source([1.0, 0.7], Complex64::new(0.2, 0.1), 1e-3, [1e-4, 2e-4, 1.6e-4]).beam();
            let lens = AstigmaticTransfer::along_axes(
                &RayTransfer::thin_lens(f).unwrap(), &RayTransfer::identity(),
            ).rotated(angle);
            let space = AstigmaticTransfer::round(&RayTransfer::free_space(z).unwrap());
            let steps = beam.through(&lens).through(&space).through(&lens);
            let at_once = beam.through(&(lens * space * lens));
            let (m, d) = (Vector2::new(2e-4, -1e-4), Vector2::new(3e-5, 5e-5));
            let a = steps.cross_spectral_density(&m, &d);
            let b = at_once.cross_spectral_density(&m, &d);
            prop_assert!((a - b).norm() <= 1e-10 * b.norm(), "{}", (a - b).norm() / b.norm());
        }

        #[test]
        fn a_lossless_system_keeps_the_power(f in 0.2..5.0f64, z in 0.0..1e6f64) {
            let beam = source([1.0, 0.7], Complex64::new(0.2, 0.1), 1e-3, [1e-4, 2e-4, 1.6e-4]).beam();
            let system = RayTransfer::free_space(z).unwrap() * RayTransfer::thin_lens(f).unwrap();
            let behind = beam.through(&AstigmaticTransfer::round(&system));
            let power = |beam: &SchellBeam| {
                let [xx, yy, _] = beam.elements.map(|e| e.amplitude.re * e.spread.determinant().sqrt());
                xx + yy
            };
            prop_assert!((power(&behind) / power(&beam) - 1.0).abs() < 1e-12);
        }
    }
}
