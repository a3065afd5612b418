//! The coherence of incident light as a surface sees it: a root over the tangent plane and the modes over it.

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{GeneralizedStokes, HermiteSeries, plane};
use thiserror::Error;

use crate::geometry::Geometry;

/// Why numbers are no coherence of incident light.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum IncidentError {
    /// The light comes from another direction than the geometry says.
    #[error(
        "incident light: it propagates at {angle} rad from the line to the source, expected the same line (to 1e-6)"
    )]
    OtherDirection {
        /// The angle.
        angle: f64,
    },
    /// The wavelengths differ.
    #[error(
        "incident light: its wavelength is {light} m and the geometry's {geometry} m, expected the same"
    )]
    OtherWavelength {
        /// Of the light, m.
        light: f64,
        /// Of the geometry, m.
        geometry: f64,
    },
    /// An entry of the root is not a number that can be squared.
    #[error(
        "incident light: an entry of the root is {value} 1/m, expected a modulus of at most 1e30"
    )]
    Root {
        /// The entry.
        value: f64,
    },
    /// The series has no value at zero separation to divide by.
    #[error(
        "incident light: the modes add up to {value} at zero separation, expected a positive number"
    )]
    Dark {
        /// The sum.
        value: f64,
    },
}

/// The normalized mutual coherence `γ(x)` of incident light over a surface, `γ(0) = 1`.
///
/// ```text
/// γ(x) = Σ c_ab h_a(y₁) h_b(y₂),   y = V x,   V = W (n k₀/s) E T
/// ```
///
/// `V` (2×2, 1/m) is all that the shape of the light enters through: `VᵀV` is the covariance of the wave vectors in the
/// surface. A plane wave has `V = 0`.
///
/// Source: the argument `(k/s) Q' r'` of Theorem S4.1 (i), restricted to the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct IncidentCoherence {
    root: Matrix2<f64>,
    determinant: f64,
    modes: HermiteSeries,
}

impl IncidentCoherence {
    /// A plane wave, coherent over the whole surface.
    #[must_use]
    pub fn plane_wave() -> Self {
        Self {
            root: Matrix2::zeros(),
            determinant: 0.0,
            modes: HermiteSeries::fundamental(std::f64::consts::PI.sqrt()),
        }
    }

    /// Coherence with root `V` over the tangent plane, 1/m, and these modes, which are scaled to `γ(0) = 1`.
    ///
    /// # Errors
    ///
    /// When an entry of the root exceeds 1e30 or the modes add up to nothing positive at 0.
    pub fn new(root: Matrix2<f64>, modes: &HermiteSeries) -> Result<Self, IncidentError> {
        let determinant = plane::determinant(&root);
        Self::with_determinant(root, determinant, modes)
    }

    /// Light from a Gaussian source of these apparent angles: `angular_root` Ω (rad, rows of the source, columns of the
    /// tangent plane), `V = n k₀ Ω`.
    ///
    /// # Errors
    ///
    /// As [`IncidentCoherence::new`].
    pub fn gaussian(
        geometry: &Geometry,
        angular_root: &Matrix2<f64>,
    ) -> Result<Self, IncidentError> {
        let root = angular_root * wavenumber(geometry);
        Self::new(root, &HermiteSeries::fundamental(1.0))
    }

    pub(crate) fn with_determinant(
        root: Matrix2<f64>,
        determinant: f64,
        modes: &HermiteSeries,
    ) -> Result<Self, IncidentError> {
        if let Some(value) = root.iter().find(|v| v.is_nan() || v.abs() > 1e30) {
            return Err(IncidentError::Root { value: *value });
        }
        let value = modes.sum_at_zero();
        if !(value > 0.0 && value.is_finite()) {
            return Err(IncidentError::Dark { value });
        }
        Ok(Self {
            root,
            determinant,
            modes: modes.scaled(1.0 / value),
        })
    }

    /// The root V over the tangent plane, 2×2, 1/m.
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        &self.root
    }

    /// `det V`, 1/m².
    #[must_use]
    pub fn root_determinant(&self) -> f64 {
        self.determinant
    }

    /// The modes, normalized to 1 at zero separation.
    #[must_use]
    pub fn modes(&self) -> &HermiteSeries {
        &self.modes
    }

    /// `γ(x)` at a separation in the surface, metres.
    #[must_use]
    pub fn value(&self, x: &Vector2<f64>) -> Complex64 {
        let y = plane::apply(&self.root, x);
        let unit = stokes::ShapeMatrix::isotropic(1.0);
        unit.map_or(Complex64::ZERO, |unit| self.modes.value(&unit, &y))
    }
}

/// The root `V` of light over the geometry's tangent plane, its determinant, and the factor `√|det W|/s²` that leads
/// from the coefficients of the light to the field on the surface.
pub(crate) fn root_of(
    light: &GeneralizedStokes,
    geometry: &Geometry,
) -> Result<(Matrix2<f64>, f64, f64), IncidentError> {
    let frame = light.frame();
    let angle = (frame.z() + geometry.to_source()).norm();
    if angle.is_nan() || angle > 1e-6 {
        return Err(IncidentError::OtherDirection { angle });
    }
    let (ours, theirs) = (geometry.wavelength().metres(), light.wavelength().metres());
    if (ours - theirs).abs() > 1e-12 * ours {
        return Err(IncidentError::OtherWavelength {
            light: theirs,
            geometry: ours,
        });
    }
    let s = light.distance();
    let b = incident_map([frame.x(), frame.y()], geometry, s);
    let root = plane::product(light.shape().root(), &b);
    let determinant = plane::determinant(light.shape().root()) * plane::determinant(&b);
    let factor = light.shape().root_determinant().sqrt() / (s * s);
    Ok((root, determinant, factor))
}

/// `B = (n k₀/s) E T`, which takes a separation in the surface to the far-field argument of light from the distance s
/// with transverse axes `axes`.
pub(crate) fn incident_map(
    axes: [Vector3<f64>; 2],
    geometry: &Geometry,
    distance: f64,
) -> Matrix2<f64> {
    let scale = wavenumber(geometry) / distance;
    let [t1, t2] = geometry.tangents();
    let [e1, e2] = axes;
    Matrix2::new(e1.dot(&t1), e1.dot(&t2), e2.dot(&t1), e2.dot(&t2)) * scale
}

/// `n k₀` where the light comes from.
pub(crate) fn wavenumber(geometry: &Geometry) -> f64 {
    geometry.n_incident() * geometry.wavelength().wavenumber().radians_per_metre()
}
