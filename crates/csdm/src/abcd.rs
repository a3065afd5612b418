//! Ray-transfer ("ABCD") matrices of first-order optical systems, per axis and for both axes together.
//!
//! ```text
//! | x'  |   | A B | | x  |         S J Sᵀ = J,   J = |  0 1 |
//! | θ'  | = | C D | | θ  |                           | −1 0 |
//! ```
//!
//! `x` is a transverse position in metres, `θ` the slope of the ray against the axis times the index of the medium.
//! Then every lossless system is symplectic, which for one axis means determinant 1.
//!
//! Source: Siegman, Lasers (1986), chapter 15.

use std::ops::Mul;

use nalgebra::{Matrix2, Matrix4};
use thiserror::Error;

/// Largest entry of `S J Sᵀ − J` of a matrix that is taken for symplectic, relative to its squared norm.
const SYMPLECTIC: f64 = 1e-12;

/// Why a matrix is no optical system.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RayTransferError {
    /// An entry is infinite or not a number.
    #[error("ray transfer: an entry is {value}, expected finite numbers")]
    NotFinite {
        /// The entry.
        value: f64,
    },
    /// The system would not conserve the volume of phase space.
    #[error(
        "ray transfer: the matrix is off a symplectic one (AD − BC = 1) by {defect} of its squared norm, expected at most 1e-12"
    )]
    NotSymplectic {
        /// Largest entry of `S J Sᵀ − J`, over the squared norm.
        defect: f64,
    },
    /// A focal length of zero.
    #[error("ray transfer: {what} is {value} m, expected a finite number other than 0")]
    NoLength {
        /// Which length.
        what: &'static str,
        /// What was found.
        value: f64,
    },
}

/// 2×2 ray-transfer matrix of one transverse axis.
///
/// Systems multiply from the right: `second * first`.
///
/// ```
/// use csdm::RayTransfer;
/// // from the front to the back focal plane of a lens: x' = f θ, θ' = −x/f
/// let f = 0.2;
/// let gap = RayTransfer::free_space(f)?;
/// let system = gap * RayTransfer::thin_lens(f)? * gap;
/// assert!(system.a().abs() < 1e-15 && system.d().abs() < 1e-15);
/// assert!((system.b() - f).abs() < 1e-15);
/// # Ok::<(), csdm::RayTransferError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayTransfer(Matrix2<f64>);

impl RayTransfer {
    /// The system `[[a, b], [c, d]]`; a and d dimensionless, b in metres, c in 1/m.
    ///
    /// # Errors
    ///
    /// When an entry is not finite or the determinant is not 1.
    pub fn new(a: f64, b: f64, c: f64, d: f64) -> Result<Self, RayTransferError> {
        for value in [a, b, c, d] {
            if !value.is_finite() {
                return Err(RayTransferError::NotFinite { value });
            }
        }
        // a d and b c have no unit, so their sizes are what rounding is measured by
        let defect = (a * d - b * c - 1.0).abs() / (1.0 + (a * d).abs() + (b * c).abs());
        if defect > SYMPLECTIC {
            return Err(RayTransferError::NotSymplectic { defect });
        }
        Ok(Self(Matrix2::new(a, b, c, d)))
    }

    /// Nothing in the way.
    #[must_use]
    pub fn identity() -> Self {
        Self(Matrix2::identity())
    }

    /// A length of homogeneous medium: metres over its index, so the length itself in air.
    ///
    /// # Errors
    ///
    /// When `reduced_length` is not finite.
    pub fn free_space(reduced_length: f64) -> Result<Self, RayTransferError> {
        Self::new(1.0, reduced_length, 0.0, 1.0)
    }

    /// A thin lens (or a mirror of radius 2f) of focal length `f` metres, positive when it collects.
    ///
    /// # Errors
    ///
    /// When `f` is 0 or not a number; an infinite one is no lens.
    pub fn thin_lens(f: f64) -> Result<Self, RayTransferError> {
        if f == 0.0 || f.is_nan() {
            return Err(RayTransferError::NoLength {
                what: "the focal length",
                value: f,
            });
        }
        Self::new(1.0, 0.0, -1.0 / f, 1.0)
    }

    /// An ideal telescope or a plane of refraction seen along its meridian: positions times `m`, slopes over `m`.
    ///
    /// # Errors
    ///
    /// When `m` is 0 or not finite.
    pub fn magnifier(m: f64) -> Result<Self, RayTransferError> {
        Self::new(m, 0.0, 0.0, 1.0 / m)
    }

    /// Entry A.
    #[must_use]
    pub fn a(&self) -> f64 {
        self.0.m11
    }

    /// Entry B, m.
    #[must_use]
    pub fn b(&self) -> f64 {
        self.0.m12
    }

    /// Entry C, 1/m.
    #[must_use]
    pub fn c(&self) -> f64 {
        self.0.m21
    }

    /// Entry D.
    #[must_use]
    pub fn d(&self) -> f64 {
        self.0.m22
    }
}

/// Systems in sequence: the right factor is met first.
impl Mul for RayTransfer {
    type Output = Self;
    fn mul(self, first: Self) -> Self {
        Self(self.0 * first.0)
    }
}

/// 4×4 ray-transfer matrix of both transverse axes: an astigmatic system at any orientation.
///
/// Blocks `A, B, C, D` are 2×2 and act on `(x, y)` and the two slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AstigmaticTransfer {
    /// Positions from positions, dimensionless.
    pub(crate) a: Matrix2<f64>,
    /// Positions from slopes, m.
    pub(crate) b: Matrix2<f64>,
    /// Slopes from positions, 1/m.
    pub(crate) c: Matrix2<f64>,
    /// Slopes from slopes, dimensionless.
    pub(crate) d: Matrix2<f64>,
}

impl AstigmaticTransfer {
    /// The system with these blocks.
    ///
    /// # Errors
    ///
    /// When an entry is not finite, or the matrix is not symplectic: `A Bᵀ` and `C Dᵀ` symmetric, `A Dᵀ − B Cᵀ = 1`.
    pub fn new(
        a: Matrix2<f64>,
        b: Matrix2<f64>,
        c: Matrix2<f64>,
        d: Matrix2<f64>,
    ) -> Result<Self, RayTransferError> {
        for block in [a, b, c, d] {
            if let Some(value) = block.iter().find(|value| !value.is_finite()) {
                return Err(RayTransferError::NotFinite { value: *value });
            }
        }
        let relative = |difference: Matrix2<f64>, size: f64| {
            if size > 0.0 {
                difference.amax() / size
            } else {
                0.0
            }
        };
        let positions = a * b.transpose();
        let slopes = c * d.transpose();
        let volume = a * d.transpose() - b * c.transpose() - Matrix2::identity();
        let defect = [
            relative(positions - positions.transpose(), a.norm() * b.norm()),
            relative(slopes - slopes.transpose(), c.norm() * d.norm()),
            relative(volume, 1.0 + a.norm() * d.norm() + b.norm() * c.norm()),
        ]
        .into_iter()
        .fold(0.0, f64::max);
        if defect > SYMPLECTIC {
            return Err(RayTransferError::NotSymplectic { defect });
        }
        Ok(Self { a, b, c, d })
    }

    /// Independent systems along x and y.
    #[must_use]
    pub fn along_axes(x: &RayTransfer, y: &RayTransfer) -> Self {
        let diagonal = |x: f64, y: f64| Matrix2::new(x, 0.0, 0.0, y);
        Self {
            a: diagonal(x.a(), y.a()),
            b: diagonal(x.b(), y.b()),
            c: diagonal(x.c(), y.c()),
            d: diagonal(x.d(), y.d()),
        }
    }

    /// The same system along both axes.
    #[must_use]
    pub fn round(system: &RayTransfer) -> Self {
        Self::along_axes(system, system)
    }

    /// The system turned by `angle` radians about its axis, counter-clockwise for the receiver.
    #[must_use]
    pub fn rotated(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let turned = |block: Matrix2<f64>| turn * block * turn.transpose();
        Self {
            a: turned(self.a),
            b: turned(self.b),
            c: turned(self.c),
            d: turned(self.d),
        }
    }

    /// The whole matrix, in the order `(x, y, θx, θy)`.
    #[must_use]
    pub fn to_matrix(&self) -> Matrix4<f64> {
        let blocks = [[self.a, self.b], [self.c, self.d]];
        Matrix4::from_fn(|row, column| blocks[row / 2][column / 2][(row % 2, column % 2)])
    }
}

impl Mul for AstigmaticTransfer {
    type Output = Self;
    fn mul(self, first: Self) -> Self {
        Self {
            a: self.a * first.a + self.b * first.c,
            b: self.a * first.b + self.b * first.d,
            c: self.c * first.a + self.d * first.c,
            d: self.c * first.b + self.d * first.d,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_system() -> impl Strategy<Value = RayTransfer> {
        (
            -1.0..1.0f64,
            prop_oneof![0.1..3.0f64, -3.0..-0.1f64],
            -1.0..1.0f64,
        )
            .prop_map(|(before, f, after)| {
                RayTransfer::free_space(after).unwrap()
                    * RayTransfer::thin_lens(f).unwrap()
                    * RayTransfer::free_space(before).unwrap()
            })
    }

    #[test]
    fn an_image_is_where_the_lens_equation_says() {
        // 1/0.3 + 1/0.6 = 1/0.2; magnification −2
        let system = RayTransfer::free_space(0.6).unwrap()
            * RayTransfer::thin_lens(0.2).unwrap()
            * RayTransfer::free_space(0.3).unwrap();
        assert!(system.b().abs() < 1e-15);
        assert!((system.a() + 2.0).abs() < 1e-14 && (system.d() + 0.5).abs() < 1e-14);
    }

    #[test]
    fn what_gains_phase_space_is_refused() {
        let text = RayTransfer::new(1.0, 0.5, 0.0, 2.0)
            .unwrap_err()
            .to_string();
        assert!(text.contains("AD − BC = 1"), "{text}");
        assert!(RayTransfer::new(1.0, f64::NAN, 0.0, 1.0).is_err());
        assert!(RayTransfer::thin_lens(0.0).is_err());
        assert!(RayTransfer::magnifier(0.0).is_err());
        let skewed = Matrix2::new(1.0, 0.2, 0.0, 1.0);
        let one = Matrix2::identity();
        // a shear of positions alone
        assert!(AstigmaticTransfer::new(skewed, one * 0.1, Matrix2::zeros(), one).is_err());
    }

    proptest! {
        #[test]
        fn products_and_rotations_stay_symplectic(
            first in any_system(), second in any_system(), third in any_system(), angle in -4.0..4.0f64,
        ) {
            let system = AstigmaticTransfer::along_axes(&first, &second).rotated(angle)
                * AstigmaticTransfer::along_axes(&third, &first);
            let AstigmaticTransfer { a, b, c, d } = system;
            prop_assert!(AstigmaticTransfer::new(a, b, c, d).is_ok());
            let s = system.to_matrix();
            let mut j = Matrix4::zeros();
            for axis in 0..2 {
                j[(axis, axis + 2)] = 1.0;
                j[(axis + 2, axis)] = -1.0;
            }
            let defect = (s * j * s.transpose() - j).amax();
            prop_assert!(defect <= 64.0 * f64::EPSILON * s.norm_squared(), "{defect}");
        }
    }
}
