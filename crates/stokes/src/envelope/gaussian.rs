//! Gaussian profiles and their sums.
//!
//! With `y = T x`, a Gaussian of covariance S about m has whitened moments whose generating function is Gaussian:
//!
//! ```text
//! Q = T S Tᵀ,  ν = T m,  u = (1 + Q)⁻¹ ν,  G = (1 − Q)(1 + Q)⁻¹
//! J_00 = mass π^(−1/2) |1 + Q|^(−1/2) e^(−νᵀ(1+Q)⁻¹ν/2)
//! √(a+1) J_{a+1,b} = √2 u₁ J_ab − G₁₁ √a J_{a−1,b} − G₁₂ √b J_{a,b−1}         and likewise for b
//! ```
//!
//! `|G| ≤ 1`, so the recurrence is as stable as that of `h_n` itself, to which it reduces for a point (Q = 0).

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

use crate::basis::{mode_count, mode_index};
use crate::plane::{self, SingularValues};
use crate::shape::ShapeMatrix;

use super::{EnvelopeError, GaussianPatch};

/// One Gaussian of a mixture: `peak · e^(−(x−centre)ᵀ covariance⁻¹ (x−centre)/2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianPeak {
    /// Intensity at the centre, positive.
    pub peak: f64,
    /// Place of the centre, m.
    pub centre: Vector2<f64>,
    /// Covariance, 2×2, m².
    pub covariance: Matrix2<f64>,
}

/// A checked Gaussian.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gaussian {
    pub(crate) peak: f64,
    pub(crate) centre: Vector2<f64>,
    pub(crate) covariance: Matrix2<f64>,
    /// The symmetric root of the covariance.
    root: Matrix2<f64>,
    /// `|covariance|^(1/2)`
    root_determinant: f64,
}

impl Gaussian {
    pub(crate) fn new(index: usize, given: &GaussianPeak) -> Result<Self, EnvelopeError> {
        if !(f64::MIN_POSITIVE..=1e100).contains(&given.peak) {
            let value = given.peak;
            return Err(EnvelopeError::Peak { index, value });
        }
        super::position("the x of a centre", given.centre.x)?;
        super::position("the y of a centre", given.centre.y)?;
        let shape = ShapeMatrix::from_covariance(&given.covariance)?;
        let off = 0.5 * given.covariance.m12 + 0.5 * given.covariance.m21;
        let covariance = Matrix2::new(given.covariance.m11, off, off, given.covariance.m22);
        Ok(Self {
            peak: given.peak,
            centre: given.centre,
            covariance,
            root: *shape.root(),
            root_determinant: plane::determinant(&covariance).sqrt(),
        })
    }

    /// Its integral.
    pub(crate) fn mass(&self) -> f64 {
        std::f64::consts::TAU * self.peak * self.root_determinant
    }

    pub(crate) fn value(&self, x: &Vector2<f64>) -> f64 {
        let y =
            plane::apply(&plane::adjugate(&self.root), &(x - self.centre)) / self.root_determinant;
        self.peak * (-0.5 * y.norm_squared()).exp()
    }

    pub(crate) fn fourier(&self, u: &Vector2<f64>) -> Complex64 {
        let spread = plane::apply(&self.root, u).norm_squared();
        Complex64::from_polar(self.mass() * (-0.5 * spread).exp(), -u.dot(&self.centre))
    }

    /// The same Gaussian by its integral.
    pub(crate) fn patch(&self) -> GaussianPatch {
        GaussianPatch {
            weight: self.mass(),
            centre: self.centre,
            covariance: self.covariance,
        }
    }

    /// Adds `∫ I(x) h_a(y₁) h_b(y₂) d²x`, `y = T (x − origin)`, to `moments`, a + b ≤ `order`.
    pub(crate) fn add_moments(
        &self,
        t: &Matrix2<f64>,
        origin: &Vector2<f64>,
        order: usize,
        moments: &mut [f64],
    ) {
        let SingularValues { left, values, .. } =
            plane::singular_values(&plane::product(t, &self.root));
        let spread = values.map(|s| 1.0 + s * s);
        let turned = |first: f64, second: f64| {
            plane::product(
                &Matrix2::new(
                    left.m11 * first,
                    left.m12 * second,
                    left.m21 * first,
                    left.m22 * second,
                ),
                &left.transpose(),
            )
        };
        let g = turned(
            (1.0 - values[0]) * (1.0 + values[0]) / spread[0],
            (1.0 - values[1]) * (1.0 + values[1]) / spread[1],
        );
        let nu = plane::apply(t, &(self.centre - origin));
        let along = left.tr_mul(&nu);
        let u = left * Vector2::new(along.x / spread[0], along.y / spread[1]);
        let exponent = along.x * along.x / spread[0] + along.y * along.y / spread[1];
        let start = self.mass() * std::f64::consts::FRAC_2_SQRT_PI * 0.5 * (-0.5 * exponent).exp()
            / (spread[0].sqrt() * spread[1].sqrt());

        let mut own = vec![0.0; mode_count(order)];
        own[0] = start;
        let root = |n: usize| (n as f64).sqrt();
        let sqrt2 = std::f64::consts::SQRT_2;
        for n in 0..order {
            for b in 0..=n {
                let a = n - b;
                let mut next = sqrt2 * u.x * own[mode_index(a, b)];
                if a > 0 {
                    next -= g.m11 * root(a) * own[mode_index(a - 1, b)];
                }
                if b > 0 {
                    next -= g.m12 * root(b) * own[mode_index(a, b - 1)];
                }
                own[mode_index(a + 1, b)] = next / root(a + 1);
            }
            let mut last = sqrt2 * u.y * own[mode_index(0, n)];
            if n > 0 {
                last -= g.m22 * root(n) * own[mode_index(0, n - 1)];
            }
            own[mode_index(0, n + 1)] = last / root(n + 1);
        }
        for (sum, value) in moments.iter_mut().zip(&own) {
            *sum += value;
        }
    }
}
