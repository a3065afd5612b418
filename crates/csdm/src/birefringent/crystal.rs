//! A homogeneous anisotropic medium: its principal indices, its axes, its optical activity.

use nalgebra::{Matrix3, Rotation3, Vector3};
use num_complex::Complex64;
use thiserror::Error;

use super::uniaxial::Uniaxial;
use crate::layered::is_index;

/// Why numbers describe no crystal, or no direction of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CrystalError {
    /// A principal index is out of range, or its medium gains.
    #[error(
        "crystal: refractive index eta - ik with eta = {eta} and k = {k}, expected eta >= 0, k >= 0 and a modulus \
         between 1e-8 and 1e8"
    )]
    Index {
        /// Real part.
        eta: f64,
        /// Extinction coefficient.
        k: f64,
    },
    /// Two vectors that span no plane.
    #[error(
        "crystal: axes ({}, {}, {}) and ({}, {}, {}) span no plane, expected two finite vectors that are not parallel",
        .first[0], .first[1], .first[2], .second[0], .second[1], .second[2]
    )]
    Axes {
        /// Direction of the first axis.
        first: [f64; 3],
        /// Direction of the second axis.
        second: [f64; 3],
    },
    /// The gyration is not symmetric, not finite, or too large for the index.
    #[error(
        "crystal: gyration ({row}, {column}) is {value}, expected a symmetric matrix of numbers below a tenth of the \
         smallest index, {index}"
    )]
    Gyration {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// What was found there.
        value: f64,
        /// Modulus of the smallest principal index.
        index: f64,
    },
    /// A cosine and a sine of two angles.
    #[error(
        "incidence: cosine {cos_i} and sine {sin_i}, expected those of one angle between 0 and 90° (to 1e-5)"
    )]
    Sine {
        /// Of the angle of incidence.
        cos_i: f64,
        /// Of the angle of incidence.
        sin_i: f64,
    },
    /// The angles of a direction of incidence.
    #[error(
        "incidence: cosine {cos_i} and azimuth {azimuth} rad, expected a cosine between 0 and 1 and a finite azimuth"
    )]
    Incidence {
        /// Cosine of the angle of incidence.
        cos_i: f64,
        /// Azimuth in radians.
        azimuth: f64,
    },
}

/// An anisotropic medium that may absorb and be optically active, in the axes of a plate.
///
/// Plate axes: z is the normal, away from the incident medium; x, y in the faces, right-handed.
///
/// ```text
/// D = ε₀ ε E + (i/c) K H,   B = μ₀ H − (i/c) K E,   K = tr γ − 2γ        in exp(+iωt)
/// ```
///
/// with a symmetric permittivity ε of principal values n² and a real symmetric gyration γ. These relations are
/// reciprocal, and lossless where the indices are real, at the faces too.
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., sections 15.1, 15.6 (crystals, absorbing crystals); Lakhtakia,
/// Varadan & Varadan, Time-Harmonic Electromagnetic Fields in Chiral Media, 1989, for the form of K.
#[derive(Clone, Debug, PartialEq)]
pub struct Crystal {
    permittivity: Matrix3<Complex64>,
    coupling: Matrix3<f64>,
    /// Columns: the crystal's axes in plate axes.
    axes: Matrix3<f64>,
    smallest_index: f64,
    lossless: bool,
    /// Where it is lossless, inactive, and two of its indices are equal.
    uniaxial: Option<Uniaxial>,
}

impl Crystal {
    /// An isotropic medium of refractive index `index`, `η − ik`.
    ///
    /// # Errors
    ///
    /// When the index is not `η − ik` with `η, k ≥ 0` and a modulus between 1e-8 and 1e8.
    pub fn isotropic(index: Complex64) -> Result<Self, CrystalError> {
        Self::biaxial([index; 3], Vector3::x(), Vector3::y())
    }

    /// A uniaxial medium with its optic axis along `axis`, of any length, in plate axes.
    ///
    /// The optic axis is the third one of the crystal.
    ///
    /// # Errors
    ///
    /// When an index is not `η − ik` with `η, k ≥ 0` and a modulus between 1e-8 and 1e8, or the axis is zero or not
    /// finite.
    pub fn uniaxial(
        ordinary: Complex64,
        extraordinary: Complex64,
        axis: Vector3<f64>,
    ) -> Result<Self, CrystalError> {
        // the unit vector most nearly across the axis
        let across = Vector3::ith(axis.iamin(), 1.0);
        Self::biaxial(
            [ordinary, extraordinary, ordinary],
            axis.cross(&across),
            axis,
        )
        .map(Self::reordered)
        .map_err(|error| match error {
            CrystalError::Axes { .. } => CrystalError::Axes {
                first: axis.into(),
                second: axis.into(),
            },
            other => other,
        })
    }

    /// A biaxial medium with refractive indices `indices` along its three principal axes.
    ///
    /// In plate axes: the first principal axis lies along `first`, the second in the plane of `first` and `second` on
    /// the side of `second`, the third completes a right-handed frame. The vectors may have any length.
    ///
    /// # Errors
    ///
    /// When an index is not `η − ik` with `η, k ≥ 0` and a modulus between 1e-8 and 1e8, or the vectors are not finite
    /// or parallel.
    pub fn biaxial(
        indices: [Complex64; 3],
        first: Vector3<f64>,
        second: Vector3<f64>,
    ) -> Result<Self, CrystalError> {
        if let Some(n) = indices.iter().find(|n| !is_index(**n)) {
            return Err(CrystalError::Index {
                eta: n.re,
                k: -n.im,
            });
        }
        let axes = right_handed(first, second).ok_or(CrystalError::Axes {
            first: first.into(),
            second: second.into(),
        })?;
        let complex = axes.map(Complex64::from);
        let squares = Matrix3::from_diagonal(&Vector3::from(indices.map(|n| n * n)));
        let permittivity = complex * squares * complex.transpose();
        Ok(Self {
            // symmetric to the last bit: that is reciprocity
            permittivity: (permittivity + permittivity.transpose()).scale(0.5),
            coupling: Matrix3::zeros(),
            axes,
            smallest_index: indices.iter().fold(f64::INFINITY, |m, n| m.min(n.norm())),
            lossless: indices.iter().all(|n| (n * n).im == 0.0),
            uniaxial: uniaxial_part(indices, &axes),
        })
    }

    /// The same medium with optical activity: `gyration` γ is symmetric, dimensionless, in the crystal's own axes.
    ///
    /// Half the difference of the indices of the two circular waves along a unit vector u is `uᵀγu` (exactly, where the
    /// medium is isotropic). Light along u is turned by `k₀ uᵀγu` radians a metre, counter-clockwise for the receiver
    /// where positive, from either side: `γ = ρ λ₀/2π` with ρ the rotatory power in rad/m.
    ///
    /// # Errors
    ///
    /// When γ is not finite and symmetric, or an entry reaches a tenth of the smallest index.
    pub fn with_gyration(mut self, gyration: &Matrix3<f64>) -> Result<Self, CrystalError> {
        for row in 0..3 {
            for column in 0..3 {
                let value = gyration[(row, column)];
                let small = value.abs() < 0.1 * self.smallest_index;
                if !small || value != gyration[(column, row)] {
                    return Err(CrystalError::Gyration {
                        row,
                        column,
                        value,
                        index: self.smallest_index,
                    });
                }
            }
        }
        let coupling = Matrix3::identity() * gyration.trace() - gyration * 2.0;
        let coupling = self.axes * coupling * self.axes.transpose();
        self.coupling = (coupling + coupling.transpose()) * 0.5;
        self.uniaxial = None;
        Ok(self)
    }

    /// The medium turned by `angle` radians about the normal of the plate, from x to y.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner();
        let complex = turn.map(Complex64::from);
        let permittivity = complex * self.permittivity * complex.transpose();
        let coupling = turn * self.coupling * turn.transpose();
        Self {
            permittivity: (permittivity + permittivity.transpose()).scale(0.5),
            coupling: (coupling + coupling.transpose()) * 0.5,
            axes: turn * self.axes,
            uniaxial: self.uniaxial.map(|part| Uniaxial {
                axis: turn * part.axis,
                ..part
            }),
            ..*self
        }
    }

    /// Relative permittivity ε in plate axes.
    #[must_use]
    pub fn permittivity(&self) -> Matrix3<Complex64> {
        self.permittivity
    }

    /// The coupling K of electric and magnetic fields, in plate axes.
    pub(super) fn coupling(&self) -> &Matrix3<f64> {
        &self.coupling
    }

    /// Whether the medium neither absorbs nor gains.
    pub(super) fn is_lossless(&self) -> bool {
        self.lossless
    }

    /// Its permittivity, where it is lossless and inactive.
    pub(super) fn clear_permittivity(&self) -> Option<Matrix3<f64>> {
        (self.lossless && self.coupling == Matrix3::zeros())
            .then(|| self.permittivity.map(|c| c.re))
    }

    /// Its axis and permittivities, where it is lossless, inactive and uniaxial.
    pub(super) fn uniaxial_part(&self) -> Option<&Uniaxial> {
        self.uniaxial.as_ref()
    }

    /// The crystal with its second axis called the third: `(1, 2, 3) → (3, 1, 2)`.
    fn reordered(mut self) -> Self {
        let old = self.axes;
        self.axes = Matrix3::from_columns(&[old.column(2), old.column(0), old.column(1)]);
        self
    }
}

/// Which principal axis differs from the two others, if it is the only one and no index is complex.
fn uniaxial_part(indices: [Complex64; 3], axes: &Matrix3<f64>) -> Option<Uniaxial> {
    if indices.iter().any(|n| n.im != 0.0) {
        return None;
    }
    let n = indices.map(|n| n.re);
    let odd = (0..3).find(|&i| n[(i + 1) % 3] == n[(i + 2) % 3])?;
    let ordinary = n[(odd + 1) % 3];
    Some(Uniaxial {
        ordinary: ordinary * ordinary,
        extraordinary: n[odd] * n[odd],
        axis: axes.column(odd).into_owned(),
    })
}

/// The orthonormal right-handed frame whose first axis is along `first`, the second toward `second`.
fn right_handed(first: Vector3<f64>, second: Vector3<f64>) -> Option<Matrix3<f64>> {
    // scaled before the products, which could overflow
    let unit = |v: Vector3<f64>| v.unscale(v.amax()).try_normalize(0.0);
    let (first, second) = (unit(first)?, unit(second)?);
    let third = first.cross(&second).try_normalize(1e-12)?;
    let axes = Matrix3::from_columns(&[first, third.cross(&first), third]);
    axes.iter().all(|c| c.is_finite()).then_some(axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calcite(axis: Vector3<f64>) -> Crystal {
        Crystal::uniaxial(1.6584.into(), 1.4864.into(), axis).unwrap()
    }

    #[test]
    fn the_permittivity_along_the_optic_axis_is_the_extraordinary_one() {
        for axis in [
            Vector3::new(0.0, 0.0, 1.0),
            Vector3::new(1e200, 2e200, -0.3e200),
            Vector3::new(1.0, 1.0, 1.0) * 1e-300,
        ] {
            let u = axis.unscale(axis.amax()).normalize().map(Complex64::from);
            let epsilon = calcite(axis).permittivity();
            assert!((epsilon * u - u * Complex64::from(1.4864 * 1.4864)).norm() < 1e-15);
            assert!(
                (epsilon.trace().re - 2.0 * 1.6584f64.powi(2) - 1.4864f64.powi(2)).abs() < 3e-15
            );
        }
    }

    #[test]
    fn the_third_axis_of_a_uniaxial_crystal_is_the_optic_axis() {
        let axis = Vector3::new(0.3, -0.5, 0.2).normalize();
        let gyration = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1e-3));
        let active = calcite(axis).with_gyration(&gyration).unwrap();
        // K = tr γ − 2γ
        let expected = (Matrix3::identity() - axis * axis.transpose() * 2.0) * 1e-3;
        assert!((active.coupling() - expected).amax() < 1e-18);
    }

    #[test]
    fn turning_from_x_to_y_takes_an_axis_along() {
        let (a, b) = (Vector3::new(1.0, 0.0, 0.4), Vector3::new(0.0, 1.0, 0.4));
        let turned = calcite(a).turned(std::f64::consts::FRAC_PI_2);
        assert!((turned.permittivity() - calcite(b).permittivity()).norm() < 1e-15);
    }

    #[test]
    fn bad_numbers_are_named() {
        let n = Complex64::from(1.5);
        let error = Crystal::isotropic(Complex64::new(1.5, 0.2)).unwrap_err();
        assert!(error.to_string().contains("k = -0.2"), "{error}");
        let error = Crystal::uniaxial(n, n, Vector3::zeros()).unwrap_err();
        assert!(matches!(error, CrystalError::Axes { .. }));
        let error = Crystal::biaxial([n; 3], Vector3::x(), Vector3::x() * -2.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "crystal: axes (1, 0, 0) and (-2, -0, -0) span no plane, expected two finite vectors that are not parallel"
        );
        assert!(Crystal::biaxial([n; 3], Vector3::x(), Vector3::y() * f64::NAN).is_err());
        let strong = Matrix3::identity() * 0.2;
        let error = Crystal::isotropic(n).unwrap().with_gyration(&strong);
        assert!(matches!(
            error,
            Err(CrystalError::Gyration {
                row: 0,
                column: 0,
                ..
            })
        ));
        let mut skew = Matrix3::zeros();
        skew[(1, 2)] = 1e-3;
        let error = Crystal::isotropic(n).unwrap().with_gyration(&skew);
        assert!(matches!(
            error,
            Err(CrystalError::Gyration {
                row: 1,
                column: 2,
                ..
            })
        ));
    }
}
