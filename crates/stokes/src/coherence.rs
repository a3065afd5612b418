//! What one measures of the light's coherence: degrees at a separation, and the ellipse over which it lasts.
//!
//! Degrees of polarization, angles and the polarization ellipse belong to one point: they are those of
//! [`GeneralizedStokes::stokes`]. Nothing here is clamped. Light without intensity (`C0(0) ≤ 0`) has degree 0 by
//! definition, as in [`crate::StokesVector`].

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use thiserror::Error;

use crate::basis::modes;
use crate::beam::{Components, GeneralizedStokes};
use crate::hermite::{MAX_ORDER, PI_FOURTH_ROOT_INVERSE};
use crate::plane;
use crate::series::HermiteSeries;

/// Why light has no coherence ellipse.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CoherenceError {
    /// There is no light whose coherence could be asked for.
    #[error("coherence: the intensity is {intensity}, expected a positive number")]
    Dark {
        /// `C0(0)`.
        intensity: f64,
    },
    /// `|C0|` does not fall in every direction.
    #[error(
        "coherence: the curvature of −ln |C0| at zero separation is {larger} and {smaller} (1 for a Gaussian of the \
         light's shape), expected both positive (beyond their rounding error {rounding}): the series has no maximum there; \
         raise its order or choose a shape nearer to the light's"
    )]
    NoMaximum {
        /// The larger curvature, in whitened coordinates.
        larger: f64,
        /// The smaller curvature, in whitened coordinates.
        smaller: f64,
        /// Bound of the error of both.
        rounding: f64,
    },
}

/// The separations over which light is coherent: an ellipse across the ray.
///
/// On it the Gaussian that meets `|γ|` at zero separation has fallen to `e^(−1/2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoherenceEllipse {
    /// Semi-major axis, m.
    pub semi_major: f64,
    /// Semi-minor axis, m.
    pub semi_minor: f64,
    /// Angle of the major axis from the frame's `x`, radians in `[0, π)`; 0 for a circle.
    pub orientation: f64,
}

impl GeneralizedStokes {
    /// The series of `C0` and its factor.
    fn total(&self) -> Option<(f64, &HermiteSeries)> {
        match self.components() {
            Components::Shared { modes, stokes } => Some((stokes.s0(), modes)),
            Components::Separate(series) => series[0].as_ref().map(|series| (1.0, series)),
        }
    }

    /// Spectral intensity `C0(0)`, in the unit of the light.
    ///
    /// Source: Eq. (S4.7).
    #[must_use]
    pub fn intensity(&self) -> f64 {
        self.total().map_or(0.0, |(amplitude, series)| {
            amplitude * series.value_at_zero(self.shape()) / (self.distance() * self.distance())
        })
    }

    /// Degree of coherence `γ(ξ) = C0(ξ)/C0(0)` of two points `separation` metres apart across the ray; 0 for dark
    /// light.
    ///
    /// Its modulus is the visibility of the fringes of two pinholes there, 1 at zero separation and at most 1 for
    /// light that exists; its argument is their shift. In the far field both points have the same intensity.
    ///
    /// Source: Eq. (S4.8).
    #[must_use]
    pub fn degree_of_coherence(&self, separation: &Vector2<f64>) -> Complex64 {
        match self.total() {
            Some((_, series)) if self.intensity() > 0.0 => {
                let w = self.far_field_argument(separation);
                series.value(self.shape(), &w) / series.value_at_zero(self.shape())
            }
            _ => Complex64::ZERO,
        }
    }

    /// Degree of cross-polarization `√(|C1|² + |C2|² + |C3|²)/|C0|` of two points `separation` metres apart.
    ///
    /// Real, the same in every frame, and what correlations of intensity measure; the degree of polarization at zero
    /// separation. It may exceed 1 elsewhere, and is infinite where `C0` alone vanishes. Where all four vanish it
    /// is 0, unless they share their modes: then it is the same number everywhere.
    ///
    /// Source: Shirai & Wolf, Opt. Commun. 272 (2007); Eq. (S4.9) with moduli and the first power of `C0`.
    #[must_use]
    pub fn degree_of_cross_polarization(&self, separation: &Vector2<f64>) -> f64 {
        let [c0, rest @ ..] = self.ratios(separation);
        let [c1, c2, c3] = rest.map(Complex64::norm);
        let polarized = c1.hypot(c2).hypot(c3);
        if polarized == 0.0 {
            0.0
        } else {
            polarized / c0.norm()
        }
    }

    /// The complex degree of cross-polarization, `√(C1² + C2² + C3²)/C0` (no moduli); `None` where `C0` vanishes or is
    /// too small to divide by.
    ///
    /// Equals `√(1 − 4 det C/tr² C)`, which is Eq. (S4.4) at a separation; of the two roots the one with
    /// non-negative real part. The same in every frame. Its modulus is at most
    /// [`GeneralizedStokes::degree_of_cross_polarization`].
    ///
    /// Source: Eq. (S4.9) with the first power of `C0`.
    #[must_use]
    pub fn complex_degree_of_cross_polarization(
        &self,
        separation: &Vector2<f64>,
    ) -> Option<Complex64> {
        let [c0, rest @ ..] = self.ratios(separation);
        let (modulus, most) = (
            c0.norm(),
            rest.iter().fold(0.0, |most: f64, c| most.max(c.norm())),
        );
        if modulus == 0.0 {
            return None;
        }
        if most == 0.0 {
            return Some(Complex64::ZERO);
        }
        // numbers of modulus near 1, whose squares neither over- nor underflow
        let turn = (c0 / modulus).conj();
        let squares = rest.map(|c| (c / most * turn).powi(2));
        let factor = most / modulus;
        factor
            .is_finite()
            .then(|| squares.iter().sum::<Complex64>().sqrt() * factor)
    }

    /// Four numbers in the ratio of the `C_j`: where they share their modes, the four amplitudes.
    fn ratios(&self, separation: &Vector2<f64>) -> [Complex64; 4] {
        match self.components() {
            Components::Shared { stokes, .. } => stokes.to_array().map(Complex64::from),
            Components::Separate(_) => self.at_separation(separation),
        }
    }

    /// The ellipse of separations over which the light is coherent.
    ///
    /// From the exact curvature of `ln |C0|` at zero separation, `−∇∇ᵀ ln |C0| = k² Γ`, where `Γ` is the covariance of
    /// the directions that the light comes from: semi-axes `1/(k √eig Γ)`. For a series of order 0 they are
    /// `(r/k) √eig Θ`. Odd orders shift the mean direction, which does not count. Relative error of a few `ε` times
    /// `Σ|terms|/C0`, for any condition number of the shape.
    ///
    /// # Errors
    ///
    /// When the light is dark, or its truncated series has no maximum at zero separation.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector3};
    /// use stokes::*;
    /// // the sun, 9.3 mrad across, as a Gaussian of its variance: radius 4λ/(2π · 9.3 mrad)
    /// let (distance, spread) = (1.5e11, 1.5e11 * 9.3e-3 / 4.0);
    /// let light = GeneralizedStokes::new(
    ///     Components::Shared {
    ///         modes: HermiteSeries::fundamental(1.0),
    ///         stokes: StokesVector::UNPOLARIZED,
    ///     },
    ///     ShapeMatrix::from_root(&Matrix2::from_diagonal_element(spread))?,
    ///     Frame::with_x_along(Vector3::z(), Vector3::x())?,
    ///     Wavelength::from_metres(550e-9)?,
    ///     distance,
    /// )?;
    /// let ellipse = light.coherence_ellipse()?;
    /// assert!((ellipse.semi_major - 37.65e-6).abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn coherence_ellipse(&self) -> Result<CoherenceEllipse, CoherenceError> {
        let intensity = self.intensity();
        let (Some((_, series)), true) = (self.total(), intensity > 0.0) else {
            return Err(CoherenceError::Dark { intensity });
        };
        let fall = Jet::at_zero(series).log_fall()?;
        // (root of the fall)·W has the squares of its singular values for eigenvalues of the whole
        let root = plane::product(&plane::symmetric_root(&fall), self.shape().root());
        let plane::SingularValues {
            values: [large, small],
            right,
            ..
        } = plane::singular_values(&root);
        let to_metres = self.distance() / self.wavelength().wavenumber().radians_per_metre();
        let round = large - small <= 8.0 * f64::EPSILON * large;
        let orientation = if round {
            0.0
        } else {
            axis_angle(right.m12, right.m22)
        };
        Ok(CoherenceEllipse {
            semi_major: to_metres / small,
            semi_minor: to_metres / large,
            orientation,
        })
    }
}

/// Angle of an undirected axis, in `[0, π)`.
fn axis_angle(x: f64, y: f64) -> f64 {
    let angle = y.atan2(x);
    let folded = if angle < 0.0 {
        angle + std::f64::consts::PI
    } else {
        angle
    };
    if folded < std::f64::consts::PI {
        folded
    } else {
        0.0
    }
}

/// Value and derivatives at 0 of `Σ c_ab h_a(y1) h_b(y2)`; the gradient of a Hermitian function is imaginary there.
struct Jet {
    value: f64,
    /// Imaginary part of the gradient.
    gradient: Vector2<f64>,
    hessian: Matrix2<f64>,
    /// Sum of the moduli of what was summed.
    magnitude: f64,
}

impl Jet {
    /// From `h_n = −√((n−1)/n) h_{n−2}`, `h_n' = √(2n) h_{n−1}` and `h_n'' = −(2n+1) h_n` at 0.
    fn at_zero(series: &HermiteSeries) -> Self {
        // h_n(0) for even n, h_n'(0) for odd n: the other one vanishes
        let mut h = [PI_FOURTH_ROOT_INVERSE; MAX_ORDER + 1];
        for n in 1..=series.order() {
            let order = n as f64;
            h[n] = if n % 2 == 1 {
                (2.0 * order).sqrt() * h[n - 1]
            } else {
                -((order - 1.0) / order).sqrt() * h[n - 2]
            };
        }
        let mut jet = Self {
            value: 0.0,
            gradient: Vector2::zeros(),
            hessian: Matrix2::zeros(),
            magnitude: 0.0,
        };
        for ((a, b), s) in modes(series.order()).zip(series.real_coefficients()) {
            // c_ab = i^(a+b) s_ab
            let sign = if (a + b) % 4 < 2 { 1.0 } else { -1.0 };
            let term = sign * s * h[a] * h[b];
            jet.magnitude += (2 * (a + b) + 1) as f64 * term.abs();
            match (a % 2, b % 2) {
                (0, 0) => {
                    jet.value += term;
                    jet.hessian.m11 -= (2 * a + 1) as f64 * term;
                    jet.hessian.m22 -= (2 * b + 1) as f64 * term;
                }
                (1, 0) => jet.gradient.x += term,
                (0, 1) => jet.gradient.y += term,
                _ => jet.hessian.m12 += term,
            }
        }
        jet.hessian.m21 = jet.hessian.m12;
        jet
    }

    /// `−∇∇ᵀ ln |f| = −f''/f + Re(f' f'ᵀ/f²)`, where `f'` is imaginary.
    fn log_fall(&self) -> Result<Matrix2<f64>, CoherenceError> {
        let slope = self.gradient / self.value;
        let fall = -self.hessian / self.value - slope * slope.transpose();
        let [larger, smaller] = plane::eigenvalues(&fall);
        let rounding =
            16.0 * f64::EPSILON * (self.magnitude / self.value).abs() * (1.0 + slope.norm());
        if smaller > rounding {
            Ok(fall)
        } else {
            Err(CoherenceError::NoMaximum {
                larger,
                smaller,
                rounding,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, ShapeMatrix, StokesVector, Wavelength, mode_count};
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    const DISTANCE: f64 = 2.0;

    fn light(components: Components, root: Matrix2<f64>) -> GeneralizedStokes {
        GeneralizedStokes::new(
            components,
            ShapeMatrix::from_root(&root).unwrap(),
            Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
            Wavelength::from_metres(500e-9).unwrap(),
            DISTANCE,
        )
        .unwrap()
    }

    fn shared(real: &[f64], root: Matrix2<f64>) -> GeneralizedStokes {
        let modes = HermiteSeries::from_real_coefficients(real).unwrap();
        let stokes = StokesVector::new(2.0, 0.6, 0.0, 0.8);
        light(Components::Shared { modes, stokes }, root)
    }

    fn separate(real: [&[f64]; 4]) -> GeneralizedStokes {
        let series = real.map(|real| HermiteSeries::from_real_coefficients(real).ok());
        light(
            Components::Separate(series),
            Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3),
        )
    }

    /// Separation at whitened coordinates `y`.
    fn separation(light: &GeneralizedStokes, y: [f64; 2]) -> Vector2<f64> {
        let k = light.wavelength().wavenumber().radians_per_metre();
        light.shape().unwhiten(&y.into()) * (DISTANCE / k)
    }

    #[test]
    fn a_long_source_makes_a_coherence_ellipse_across_it() {
        // a source 10 mm by 1 mm, its length at 0.5 rad: coherence is widest at 0.5 + π/2
        let (sin, cos) = 0.5f64.sin_cos();
        let root = Matrix2::new(10e-3, 0.0, 0.0, 1e-3) * Matrix2::new(cos, sin, -sin, cos);
        let light = shared(&[1.0], root);
        let ellipse = light.coherence_ellipse().unwrap();
        let k = light.wavelength().wavenumber().radians_per_metre();
        assert!((ellipse.semi_major * k * 1e-3 / DISTANCE - 1.0).abs() < 1e-14);
        assert!((ellipse.semi_minor * k * 10e-3 / DISTANCE - 1.0).abs() < 1e-14);
        assert!((ellipse.orientation - 0.5 - FRAC_PI_2).abs() < 1e-15);
        // and there the degree of coherence is e^(−1/2), for order 0 exactly
        for (length, angle) in [
            (ellipse.semi_major, 0.5 + FRAC_PI_2),
            (ellipse.semi_minor, 0.5),
        ] {
            let xi = Vector2::new(angle.cos(), angle.sin()) * length;
            let gamma = light.degree_of_coherence(&xi);
            assert!((gamma - (-0.5f64).exp()).norm() < 1e-14, "{gamma}");
        }
    }

    #[test]
    fn the_ellipse_is_the_spread_of_directions() {
        // k²Γ by quadrature of the Wigner function: an average over directions, no derivative
        for real in [
            &[1.0][..],
            &[1.0, 0.3, -0.2],
            &[1.0, 0.2, -0.3, -0.1, 0.25, 0.3],
            &[
                1.0, 0.2, -0.3, -0.1, 0.25, 0.3, 0.1, 0.0, -0.2, 0.15, 0.2, -0.1, 0.3, 0.1, -0.2,
            ],
        ] {
            let root = Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3);
            let light = shared(real, root);
            let k = light.wavelength().wavenumber().radians_per_metre();
            let (mut sum, mut first, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
            // the trapezoidal rule, exact to rounding: h_4 is below 1e-16 at 9.5
            for i in -80..=80 {
                for j in -80..=80 {
                    let y = Vector2::new(f64::from(i), f64::from(j)) * 0.125;
                    let direction = root.transpose() * y / DISTANCE;
                    let weight = light.wigner(&(direction * k)).s0();
                    sum += weight;
                    first += direction * weight;
                    second += direction * direction.transpose() * weight;
                }
            }
            let mean: Vector2<f64> = first / sum;
            let gamma = second / sum - mean * mean.transpose();
            let eigen = gamma.symmetric_eigen();
            let (major, minor) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
                (0, 1)
            } else {
                (1, 0)
            };
            let ellipse = light.coherence_ellipse().unwrap();
            let expected = [major, minor].map(|i| 1.0 / (k * eigen.eigenvalues[i].sqrt()));
            // moments of 26,000 terms, by a difference that may halve
            assert!((ellipse.semi_major / expected[0] - 1.0).abs() < 1e-12);
            assert!((ellipse.semi_minor / expected[1] - 1.0).abs() < 1e-12);
            let axis = eigen.eigenvectors.column(major);
            let off = (ellipse.orientation - axis[1].atan2(axis[0]) + FRAC_PI_2).rem_euclid(PI);
            assert!((off - FRAC_PI_2).abs() < 1e-12);
        }
    }

    #[test]
    fn high_orders_have_the_curvature_of_their_differences() {
        // order 64, along both axes and across: −∂² ln|γ| by a central difference
        let mut real = vec![0.0; mode_count(64)];
        for (place, (a, b)) in modes(64).enumerate() {
            let n = (a + b) as f64;
            real[place] = if a + b == 0 {
                1.0
            } else {
                0.1 * (place as f64).sin() / (n * n * n)
            };
        }
        let light = shared(&real, Matrix2::from_diagonal_element(1e-3));
        let fall = Jet::at_zero(light.total().unwrap().1).log_fall().unwrap();
        let step = 1e-3;
        for [x, y] in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]] {
            let gamma = light
                .degree_of_coherence(&separation(&light, [x * step, y * step]))
                .norm();
            let found = -2.0 * gamma.ln() / (step * step);
            let expected = Vector2::new(x, y).dot(&(fall * Vector2::new(x, y)));
            // the next term is of order (2N+1)²·step²/12 of the coefficients there, rounding 2ε/step²
            assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn thin_and_round_shapes_keep_their_axes() {
        for ratio in [1.0, 1.0 + 1e-9, 1e3, 1e6, 1e11] {
            let light = shared(&[1.0], Matrix2::new(1e-3, 0.0, 0.0, 1e-3 / ratio));
            let ellipse = light.coherence_ellipse().unwrap();
            let radius = DISTANCE / (light.wavelength().wavenumber().radians_per_metre() * 1e-3);
            assert!((ellipse.semi_minor / radius - 1.0).abs() < 4.0 * f64::EPSILON);
            assert!((ellipse.semi_major / radius / ratio - 1.0).abs() < 8.0 * f64::EPSILON);
            let expected = if ratio > 1.0 { FRAC_PI_2 } else { 0.0 };
            assert!((ellipse.orientation - expected).abs() < 1e-15, "{ratio}");
        }
        // a circle that is round but for its rounding has no orientation
        let (sin, cos) = 1.1f64.sin_cos();
        let round = shared(&[1.0], Matrix2::new(cos, sin, -sin, cos) * 1e-3);
        assert_eq!(round.coherence_ellipse().unwrap().orientation, 0.0);
    }

    #[test]
    fn light_without_a_maximum_says_so() {
        // c2 = 1/2: f(0) = 1 − 1/√8, −f'' = 1 − 5/√8 along the first axis
        let light = shared(&[1.0, 0.0, 0.0, -0.5, 0.0, 0.0], Matrix2::identity());
        let error = light.coherence_ellipse().unwrap_err();
        let expected = (1.0 - 5.0 / 8f64.sqrt()) / (1.0 - 1.0 / 8f64.sqrt());
        match error {
            CoherenceError::NoMaximum {
                larger,
                smaller,
                rounding,
            } => {
                assert!((larger - 1.0).abs() < 1e-15);
                assert!((smaller - expected).abs() < 1e-14);
                assert!(rounding < 1e-13);
            }
            CoherenceError::Dark { .. } => panic!("{error}"),
        }
        let text = error.to_string();
        assert!(text.starts_with("coherence: the curvature of −ln |C0| at zero separation is "));
        assert!(text.contains("expected both positive"), "{text}");
        for stokes in [StokesVector::DARK, StokesVector::new(-1.0, 0.0, 0.0, 0.0)] {
            let modes = HermiteSeries::fundamental(1.0);
            let dark = light_of(modes, stokes);
            let text = dark.coherence_ellipse().unwrap_err().to_string();
            assert!(text.starts_with("coherence: the intensity is "), "{text}");
            assert_eq!(
                dark.degree_of_coherence(&Vector2::new(1e-4, 0.0)),
                Complex64::ZERO
            );
        }
    }

    fn light_of(modes: HermiteSeries, stokes: StokesVector) -> GeneralizedStokes {
        light(Components::Shared { modes, stokes }, Matrix2::identity())
    }

    #[test]
    fn an_off_axis_source_shifts_the_fringes_and_not_their_visibility() {
        // e^(−|y|²/2)(1 + i ε √2 y1): phase atan(ε √2 y1)
        let light = shared(&[1.0, 0.3, 0.0], Matrix2::from_diagonal_element(1e-3));
        let gamma = light.degree_of_coherence(&separation(&light, [0.7, 0.0]));
        let expected = Complex64::new(1.0, 0.3 * 2f64.sqrt() * 0.7) * (-0.245f64).exp();
        assert!(
            (gamma - expected).norm() < 4.0 * f64::EPSILON,
            "{gamma} {expected}"
        );
        assert_eq!(light.degree_of_coherence(&Vector2::zeros()), Complex64::ONE);
    }

    #[test]
    fn cross_polarization_exceeds_one_and_ends_in_infinity() {
        let c = [0.1, 0.2, 0.3];
        // C0 = h2-like vanishes on a ring that the others do not know
        let light = separate([&[0.0, 1.0, 0.0], &c, &[0.0], &[0.0]]);
        assert_eq!(
            light.degree_of_cross_polarization(&Vector2::zeros()),
            f64::INFINITY
        );
        assert_eq!(
            light.complex_degree_of_cross_polarization(&Vector2::zeros()),
            None
        );
        // far out all are below the smallest number
        let far = separation(&light, [60.0, 60.0]);
        assert_eq!(light.degree_of_cross_polarization(&far), 0.0);
        // shared modes: the degree of polarization everywhere, even there
        let light = shared(&[1.0, 0.3, 0.0], Matrix2::from_diagonal_element(1e-3));
        for y in [[0.0, 0.0], [1.0, -2.0], [60.0, 60.0]] {
            let xi = separation(&light, y);
            assert_eq!(light.degree_of_cross_polarization(&xi), 0.5);
            let complex = light.complex_degree_of_cross_polarization(&xi).unwrap();
            assert!((complex - 0.5).norm() < 4.0 * f64::EPSILON);
        }
    }

    #[test]
    fn cross_polarization_survives_extreme_units() {
        let unit = [
            [1.0, 0.2, 0.1],
            [0.3, 0.1, -0.2],
            [-0.2, 0.0, 0.1],
            [0.1, 0.2, 0.3],
        ];
        let values = |scale: f64| {
            let scaled = unit.map(|series| series.map(|s| s * scale));
            let light = separate(scaled.each_ref().map(|series| &series[..]));
            let xi = separation(&light, [0.8, -0.5]);
            (
                light.degree_of_cross_polarization(&xi),
                light.complex_degree_of_cross_polarization(&xi).unwrap(),
            )
        };
        let (degree, complex) = values(1.0);
        for scale in [1e-280, 1e-170, 1e170, 1e280] {
            let (d, c) = values(scale);
            assert!((d / degree - 1.0).abs() < 1e-14, "{scale}");
            assert!((c - complex).norm() < 1e-14, "{scale}");
        }
    }

    proptest! {
        #[test]
        fn cross_polarization_is_that_of_the_coherence_matrix(
            s in prop::array::uniform12(-1.0..1.0f64),
            y in prop::array::uniform2(-2.0..2.0f64),
        ) {
            let light = separate([&s[0..3], &s[3..6], &s[6..9], &s[9..12]]);
            let xi = separation(&light, y);
            let [c0, c1, c2, c3] = light.at_separation(&xi);
            let i = Complex64::I;
            // [[xx, xy], [yx, yy]] with C3 = i(xy − yx)
            let (xx, yy) = (0.5 * (c0 + c1), 0.5 * (c0 - c1));
            let (xy, yx) = (0.5 * (c2 - i * c3), 0.5 * (c2 + i * c3));
            let trace = (xx + yy).norm_sqr();
            let squares = [xx, yy, xy, yx].map(|c| c.norm_sqr()).iter().sum::<f64>();
            prop_assume!(trace > 1e-6 * squares);
            // the square has the roundings of 2 squares/trace; the trace, summed here from its two parts, those of
            // √(squares/trace) on top
            let degree = light.degree_of_cross_polarization(&xi).powi(2);
            let eps = 32.0 * f64::EPSILON * squares / trace;
            let cancelled = eps * (1.0 + (squares / trace).sqrt());
            prop_assert!((degree - (2.0 * squares / trace - 1.0)).abs() <= cancelled);
            let complex = light.complex_degree_of_cross_polarization(&xi).unwrap();
            let expected = 1.0 - 4.0 * (xx * yy - xy * yx) / (c0 * c0);
            prop_assert!((complex.powi(2) - expected).norm() <= eps);
            prop_assert!(complex.re >= 0.0 && complex.norm() <= degree.sqrt() * (1.0 + 1e-14));
        }
    }
}
