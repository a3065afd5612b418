//! The Wigner function of light in Hermite-Gauss space: its radiance, point by point of the source.
//!
//! ```text
//! Wd_j(ζ) = ∫ C_j(ξ) e^(−iζ·ξ) d²ξ = (2π/k²) Σ s_ab φ_ab((r/k) ζ; W^(−T)),      s_ab = (−i)^(a+b) c_ab
//! C_j(0)  = (2π)⁻² ∫ Wd_j(ζ) d²ζ
//! ```
//!
//! It is real, term by term, since `C(−ξ) = C(ξ)*`: odd orders are no exception, they make it lopsided. Light that
//! comes from the point `m` of the source arrives with the transverse wave vector `ζ = −(k/r) m`; written as a
//! function of `m`, the Wigner function does not depend on the distance, which is the invariance of radiance.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use crate::beam::GeneralizedStokes;
use crate::vector::StokesVector;

impl GeneralizedStokes {
    /// The Wigner function `Wd_j(ζ)` of the four components at a transverse wave vector `ζ`, rad/m.
    ///
    /// In the unit of the light times m². `ζ` in the axes of the light's frame. A single value may lie outside the
    /// cone of Stokes vectors only if the light does not exist ([`GeneralizedStokes::realizability`]). Error:
    /// that of the functions ([`crate::hermite`]) times the norm of the series. No allocation.
    ///
    /// Source: Eq. (S3.3), in the whitened basis.
    #[must_use]
    pub fn wigner(&self, zeta: &Vector2<f64>) -> StokesVector {
        let k = self.wavelength().wavenumber().radians_per_metre();
        self.radiance_at(&(zeta * (self.distance() / k)))
    }

    /// The generalized radiance that arrives from the point `position` of the source, `Wd(−(k/r) position)`.
    ///
    /// In the unit of the light times m². `position` is metres along the axes of the light's frame, from the phase
    /// centre of the source: the receiver who faces it sees positive `x` to the right and `y` up. Divided by `λ²`
    /// this is the density over the source of the intensity `r² C_j(0)` that it sends here. The same number at every
    /// distance, to the last bit.
    ///
    /// Source: Eq. (S3.5), whose argument is minus the position.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector2, Vector3};
    /// use stokes::*;
    /// // a round Gaussian source of 1 mm (standard deviation), intensity 1 at 1 m
    /// let shape = ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3))?;
    /// let c00 = 1.0 / whitened_mode(0, 0, &shape, &Vector2::zeros());
    /// let light = GeneralizedStokes::new(
    ///     Components::Shared {
    ///         modes: HermiteSeries::fundamental(c00),
    ///         stokes: StokesVector::UNPOLARIZED,
    ///     },
    ///     shape,
    ///     Frame::with_x_along(Vector3::z(), Vector3::x())?,
    ///     Wavelength::from_metres(500e-9)?,
    ///     1.0,
    /// )?;
    /// // density at the centre 1/(2π σ²)
    /// let density = light.generalized_radiance(&Vector2::zeros()).s0() / 500e-9f64.powi(2);
    /// assert!((density * 1e-6 - 0.159_154_943_091_895).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn generalized_radiance(&self, position: &Vector2<f64>) -> StokesVector {
        self.radiance_at(&-position)
    }

    /// `(2π/k²) Σ s_ab φ_ab(z; W^(−T))`.
    fn radiance_at(&self, z: &Vector2<f64>) -> StokesVector {
        let y = self.shape().fourier_dual().whiten(z);
        let unit = self.radiance_unit();
        let sums = self.components().map(|series| series.real_sum(&y));
        StokesVector::from(sums) * unit
    }

    /// What a sum `Σ s_ab h_a h_b` is multiplied by to become a radiance, `(2π/k²) |det W|^(−1/2)`; m.
    pub(crate) fn radiance_unit(&self) -> f64 {
        let lambda = self.wavelength().metres();
        lambda * lambda / TAU / self.shape().root_determinant().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Components, Frame, HermiteSeries, ShapeMatrix, StokesVector, Wavelength, mode_count,
    };
    use nalgebra::{Matrix2, Vector3};
    use num_complex::Complex64;

    const GREEN: f64 = 550e-9;

    fn light(components: Components, root: Matrix2<f64>, distance: f64) -> GeneralizedStokes {
        GeneralizedStokes::new(
            components,
            ShapeMatrix::from_root(&root).unwrap(),
            Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
            Wavelength::from_metres(GREEN).unwrap(),
            distance,
        )
        .unwrap()
    }

    fn skew_root() -> Matrix2<f64> {
        Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3)
    }

    /// Four different series of orders 5, 1, 4 and 3, with odd modes in each.
    fn lopsided() -> Components {
        let series = |order: usize, seed: f64| {
            let real: Vec<f64> = (0..mode_count(order))
                .map(|place| (seed + 1.7 * place as f64).sin() / (1.0 + place as f64))
                .collect();
            Some(HermiteSeries::from_real_coefficients(&real).unwrap())
        };
        Components::Separate([
            series(5, 1.0),
            series(1, 0.2),
            series(4, -0.9),
            series(3, 2.2),
        ])
    }

    /// Points of a grid in whitened coordinates and the area of one: the trapezoidal rule, exact to rounding here.
    ///
    /// `h_5` and its transform fall below 1e-16 at 9.5, and aliases are `2π/0.25 = 25` apart.
    fn grid() -> impl Iterator<Item = Vector2<f64>> {
        (-40..=40)
            .flat_map(|i| (-40..=40).map(move |j| Vector2::new(f64::from(i), f64::from(j)) * 0.25))
    }

    const CELL: f64 = 0.25 * 0.25;

    #[test]
    fn the_wigner_function_is_the_transform_of_the_coherence() {
        let light = light(lopsided(), skew_root(), 3.0);
        let k = light.wavelength().wavenumber().radians_per_metre();
        let to_metres = 3.0 / k;
        let jacobian = to_metres * to_metres / light.shape().root_determinant() * CELL;
        let unit = light.radiance_unit();
        for y in [
            [0.0, 0.0],
            [0.9, -0.4],
            [-0.9, 0.4],
            [-1.8, -2.1],
            [3.0, 0.5],
        ] {
            // a wave vector where the function is not small
            let z = skew_root().transpose() * Vector2::new(y[0], y[1]);
            let zeta = z / to_metres;
            let mut sums = [Complex64::ZERO; 4];
            for y in grid() {
                let xi = light.shape().unwhiten(&y) * to_metres;
                let kernel = Complex64::cis(-zeta.dot(&xi));
                let c = light.at_separation(&xi);
                for (sum, c) in sums.iter_mut().zip(c) {
                    *sum += kernel * c * jacobian;
                }
            }
            let found = light.wigner(&zeta).to_array();
            for (sum, found) in sums.iter().zip(found) {
                // norms are below 2, and each of the 6561 terms carries a few roundings of its phase
                assert!(sum.im.abs() < 1e-14 * unit, "{sum} {unit}");
                assert!(
                    (sum.re - found).abs() < 1e-14 * unit,
                    "{sum} {found} {unit}"
                );
            }
            // none of the odd modes may be lost: the opposite wave vector differs
            let opposite = light.wigner(&-zeta).to_array();
            if zeta.norm() > 0.0 {
                assert!((found[1] - opposite[1]).abs() > 1e-3 * unit);
            }
        }
    }

    #[test]
    fn each_mode_is_its_transform_of_the_dual_shape() {
        // (S3.3) mode by mode, through the public basis: (2π/k²) φ_ab((r/k) ζ; W^(−T))
        for (a, b) in [(0, 0), (1, 0), (0, 3), (2, 1)] {
            let mut real = vec![0.0; mode_count(a + b)];
            real[crate::mode_index(a, b)] = 0.7;
            let modes = HermiteSeries::from_real_coefficients(&real).unwrap();
            let stokes = StokesVector::UNPOLARIZED;
            let light = light(Components::Shared { modes, stokes }, skew_root(), 3.0);
            let k = light.wavelength().wavenumber().radians_per_metre();
            let z = Vector2::new(0.6e-3, -0.2e-3);
            let dual = light.shape().fourier_dual();
            let expected = 0.7 * TAU / (k * k) * crate::whitened_mode(a, b, &dual, &z);
            let found = light.wigner(&(z * (k / 3.0))).s0();
            assert!(
                (found - expected).abs() < 1e-14 * light.radiance_unit(),
                "{a} {b}"
            );
        }
    }

    #[test]
    fn the_integral_over_wave_vectors_is_the_stokes_vector() {
        let light = light(lopsided(), skew_root(), 0.4);
        let k = light.wavelength().wavenumber().radians_per_metre();
        let per_metre = k / 0.4;
        let jacobian = per_metre * per_metre * light.shape().root_determinant() * CELL;
        let sum = grid().fold(StokesVector::DARK, |sum, y| {
            sum + light.wigner(&(skew_root().transpose() * y * per_metre)) * jacobian
        });
        let mean = sum * (1.0 / (TAU * TAU));
        let stokes = light.stokes().stokes;
        let scale = light.shape().root_determinant().sqrt() / 0.16;
        assert!(
            (mean - stokes).to_vector().amax() < 1e-14 * scale,
            "{mean:?} {stokes:?}"
        );
        // and no component vanishes by which a factor could hide
        assert!(stokes.to_vector().amin() > 1e-2 * scale);
    }

    #[test]
    fn radiance_is_constant_along_the_ray() {
        let near = light(lopsided(), skew_root(), 0.01);
        for distance in [0.3, 17.0, 1e6] {
            let far = near.clone().propagated_to(distance).unwrap();
            for m in [[0.0, 0.0], [1e-3, -0.4e-3], [-2e-3, 2e-3]] {
                let m = Vector2::new(m[0], m[1]);
                assert_eq!(far.generalized_radiance(&m), near.generalized_radiance(&m));
                let k = far.wavelength().wavenumber().radians_per_metre();
                let by_wave_vector = far.wigner(&(m * (-k / distance)));
                let difference = by_wave_vector - far.generalized_radiance(&m);
                // the argument is rounded twice, and slopes are below 4
                assert!(difference.to_vector().amax() < 16.0 * f64::EPSILON * far.radiance_unit());
            }
        }
    }

    #[test]
    fn a_source_point_off_the_axis_is_seen_where_it_is() {
        // a Gaussian source of spread σ about m0, by the definition C = (1/r²) ∫ I(m) e^(−i(k/r) m·ξ) d²m
        let (sigma, m0, r) = (1e-3, Vector2::new(0.3e-3, -0.15e-3), 2.0);
        let root = Matrix2::from_diagonal_element(sigma);
        // modes of e^(−|y|²/2 − i y·t), t = m0/σ, from the generating function: s_ab = (−t/√2)^a.. /√(a! b!) · const
        let t = m0 / sigma;
        let order = 16;
        let factorial = |n: usize| (1..=n).map(|i| i as f64).product::<f64>();
        let real: Vec<f64> = crate::modes(order)
            .map(|(a, b)| {
                let power =
                    |x: f64, n: usize| (-x / 2f64.sqrt()).powi(n as i32) / factorial(n).sqrt();
                power(t.x, a) * power(t.y, b) * (-0.25 * t.norm_squared()).exp()
            })
            .collect();
        let modes = HermiteSeries::from_real_coefficients(&real).unwrap();
        let light = light(
            Components::Shared {
                modes,
                stokes: StokesVector::HORIZONTAL,
            },
            root,
            r,
        );
        // it is that source: phase −(k/r) m0·ξ
        let k = light.wavelength().wavenumber().radians_per_metre();
        let xi = Vector2::new(40e-6, 90e-6);
        let phase = -(k / r) * m0.dot(&xi);
        let gamma = light.at_separation(&xi)[0] / light.stokes().stokes.s0();
        assert!(
            (gamma.arg() - phase).abs() < 1e-12,
            "{} {phase}",
            gamma.arg()
        );
        // its radiance is the Gaussian about +m0
        let centre = light.generalized_radiance(&m0).s0();
        for off in [[0.0, 0.0], [1e-3, 0.0], [-0.2e-3, 0.7e-3]] {
            let off: Vector2<f64> = off.into();
            let expected = (-0.5 * off.norm_squared() / (sigma * sigma)).exp();
            let found = light.generalized_radiance(&(m0 + off)).s0() / centre;
            // the modes from 17 on: (0.34/√2)^17/√17! < 1e-17
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
        // and its density integrates to the intensity at r times r²: peak 2πσ² density
        let density = centre / (GREEN * GREEN);
        let total = density * TAU * sigma * sigma;
        assert!((total / (light.stokes().stokes.s0() * r * r) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn incoherent_light_comes_from_everywhere_alike() {
        // W → ∞ over a fixed window |ζ| ≤ 1e4/m: 1 − Wd(ζ)/Wd(0) → ½ |W^(−T) (r/k) ζ|²
        let r = 1.0;
        for spread in [1e-3, 1e-2, 1.0, 100.0] {
            let modes = HermiteSeries::fundamental(1.0);
            let stokes = StokesVector::UNPOLARIZED;
            let light = light(
                Components::Shared { modes, stokes },
                Matrix2::new(spread, 0.0, 0.0, 2.0 * spread),
                r,
            );
            let k = light.wavelength().wavenumber().radians_per_metre();
            let zeta = Vector2::new(6e3, 8e3);
            let u = (0.5 * (6e3 * r / k / spread).powi(2)) + 0.5 * (4e3 * r / k / spread).powi(2);
            let fall = 1.0 - light.wigner(&zeta).s0() / light.wigner(&Vector2::zeros()).s0();
            assert!(
                (fall + (-u).exp_m1()).abs() < 4.0 * f64::EPSILON,
                "{spread}: {fall} {u}"
            );
            assert!(spread < 1.0 || fall < 1e-6);
        }
        // with odd modes the fall is of first order: ten times the width, a tenth of it
        let fall = |spread: f64| {
            let light = light(lopsided(), Matrix2::from_diagonal_element(spread), r);
            let zeta = Vector2::new(6e3, 8e3);
            (light.wigner(&zeta) - light.wigner(&Vector2::zeros())).to_vector()
                / light.radiance_unit()
        };
        let (narrow, wide) = (fall(1.0), fall(10.0));
        assert!((narrow - wide * 10.0).amax() < 1e-2 * narrow.amax());
    }

    #[test]
    fn coherent_light_is_one_plane_wave() {
        // W → 0 at fixed intensity: the integral stays and the width goes with W
        let r = 1.0;
        for shrink in [1.0, 1e-4, 1e-8] {
            let root = skew_root() * shrink;
            let c00 = 1.0 / (root.determinant() / std::f64::consts::PI).sqrt();
            let light = light(
                Components::Shared {
                    modes: HermiteSeries::fundamental(c00),
                    stokes: StokesVector::UNPOLARIZED,
                },
                root,
                r,
            );
            let k = light.wavelength().wavenumber().radians_per_metre();
            let cell = (k / r).powi(2) * root.determinant().abs() * CELL / (TAU * TAU);
            let (mut sum, mut second) = (0.0, Matrix2::zeros());
            for y in grid() {
                let zeta = root.transpose() * y * (k / r);
                let weight = light.wigner(&zeta).s0() * cell;
                sum += weight;
                second += zeta * zeta.transpose() * weight;
            }
            assert!((sum - 1.0).abs() < 1e-13, "{sum}");
            let expected = root.transpose() * root * (k / r).powi(2);
            assert!((second - expected).amax() < 1e-13 * expected.amax());
            // and two points 1 mm apart are coherent but for ½ (k W ξ/r)²
            let xi = Vector2::new(1e-3, 0.0);
            let lost = 1.0 - light.at_separation(&xi)[0].norm();
            assert!(lost <= 0.5 * (k * 1.3e-3 * shrink * 1e-3 / r).powi(2) + 1e-15);
        }
    }
}
