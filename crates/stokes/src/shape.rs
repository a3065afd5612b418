//! The shape matrix Θ of a Hermite-Gauss series, held as a root `W` with `Θ⁻¹ = WᵀW`.
//!
//! The root is what everything is computed from: `y = W w` are the whitened coordinates in which the basis is
//! orthonormal. Entries of `Θ` itself lose half the digits of a thin shape, so it is only an input and an output.

use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

use crate::plane;

/// Largest condition number of Θ: beyond it the angles of the two axes are no longer known in f64.
pub const MAX_CONDITION: f64 = 1e24;

/// Singular values of a root lie in this range, so that no square or determinant over- or underflows.
const ROOT_RANGE: [f64; 2] = [1e-70, 1e70];

/// Largest asymmetry `|m12 − m21|/√(m11 m22)` of a matrix that is taken for symmetric.
const ASYMMETRY: f64 = 1e-12;

/// Why a matrix is no shape.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// An entry is infinite or not a number.
    #[error("shape: entry ({row}, {column}) of the {what} is {value}, expected a finite number")]
    NotFinite {
        /// Which matrix.
        what: &'static str,
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// What was found there.
        value: f64,
    },
    /// The matrix should be symmetric and is not.
    #[error(
        "shape: the {what} is not symmetric: found {upper} and {lower} off the diagonal, expected \
         the same number (to 1e-12 of √(m11 m22))"
    )]
    NotSymmetric {
        /// Which matrix.
        what: &'static str,
        /// Entry (0, 1).
        upper: f64,
        /// Entry (1, 0).
        lower: f64,
    },
    /// An eigenvalue has the wrong sign, or is zero within the rounding of the entries.
    #[error(
        "shape: the {what} has eigenvalues {larger} and {smaller}, expected both {expected} (beyond \
         4e-16 of the larger)"
    )]
    NotDefinite {
        /// Which matrix.
        what: &'static str,
        /// The eigenvalue of larger modulus.
        larger: f64,
        /// The eigenvalue of smaller modulus.
        smaller: f64,
        /// What the eigenvalues should be.
        expected: &'static str,
    },
    /// The root is singular or nearly so.
    #[error(
        "shape: condition number {condition} of Θ, expected at most 1e24; the shape is a line: give \
         its thin axis a width"
    )]
    Singular {
        /// The condition number of Θ.
        condition: f64,
    },
    /// A width is outside what the arithmetic can square.
    #[error(
        "shape: a singular value of the root is {value}, expected 1e-70 to 1e70; choose another unit"
    )]
    OutOfRange {
        /// The singular value.
        value: f64,
    },
    /// An order is beyond what the functions are made for.
    #[error("shape: a mode of order {order} along one axis, expected at most 256")]
    Order {
        /// The order.
        order: usize,
    },
    /// The function whose logarithm was to be differentiated vanishes.
    #[error(
        "shape: the function is {value} where its logarithm is differentiated, expected a finite number other than 0"
    )]
    NoLogarithm {
        /// Its modulus there.
        value: f64,
    },
}

/// Shape matrix Θ of a Hermite-Gauss series, 2×2 symmetric positive definite.
///
/// Held as a root `W`, `Θ⁻¹ = WᵀW`. In the far field Θ has the unit of `w²`, 1/m², and `W` is a length: the spread
/// of the source as the receiver sees it (`W = D P`, `DᵀD` the covariance of the source). Roots that differ by an
/// orthogonal matrix on the left make the same Θ but different coefficients ([`crate::HermiteSeries`]).
///
/// Source: Definition 4.1 and Lemma 4.4 of the paper.
///
/// ```
/// use nalgebra::Matrix2;
/// use stokes::ShapeMatrix;
/// let shape = ShapeMatrix::from_covariance(&Matrix2::new(4.0, 0.0, 0.0, 1.0))?;
/// assert_eq!(shape.theta(), Matrix2::new(0.25, 0.0, 0.0, 1.0));
/// assert_eq!(shape.condition_number(), 4.0);
/// # Ok::<(), stokes::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeMatrix {
    root: Matrix2<f64>,
    /// `|det W|`, cached: every evaluation needs its root.
    determinant: f64,
}

impl ShapeMatrix {
    /// The shape with root `W`.
    ///
    /// # Errors
    ///
    /// When an entry is not finite, or the root is singular: cond Θ above [`MAX_CONDITION`].
    pub fn from_root(root: &Matrix2<f64>) -> Result<Self, ShapeError> {
        finite(root, "root")?;
        let [large, small] = plane::singular_values(root).values;
        // a root of zeros has no condition number, which is as bad as an infinite one
        let condition = if small > 0.0 {
            (large / small).powi(2)
        } else {
            f64::INFINITY
        };
        if condition > MAX_CONDITION {
            return Err(ShapeError::Singular { condition });
        }
        for value in [large, small] {
            if !(ROOT_RANGE[0]..=ROOT_RANGE[1]).contains(&value) {
                return Err(ShapeError::OutOfRange { value });
            }
        }
        Ok(Self {
            root: *root,
            determinant: plane::determinant(root).abs(),
        })
    }

    /// The shape with `Θ⁻¹ = covariance`, its root the symmetric one.
    ///
    /// By Lemma 4.4 this is the shape of light from an incoherent source with this covariance of intensity over the
    /// plane across the ray.
    ///
    /// # Errors
    ///
    /// When the matrix is not finite, not symmetric or not positive definite.
    pub fn from_covariance(covariance: &Matrix2<f64>) -> Result<Self, ShapeError> {
        let covariance = positive_definite(covariance, "covariance")?;
        Self::from_root(&symmetric_root(&covariance))
    }

    /// The shape Θ itself, its root the symmetric one of `Θ⁻¹`.
    ///
    /// The root's relative error is the condition number of Θ times that of its entries.
    ///
    /// # Errors
    ///
    /// When the matrix is not finite, not symmetric or not positive definite.
    pub fn from_theta(theta: &Matrix2<f64>) -> Result<Self, ShapeError> {
        let theta = positive_definite(theta, "shape matrix Θ")?;
        // (√Θ)⁻¹, whose adjugate needs no difference
        let (unit, half) = unit(&theta);
        let root = plane::symmetric_root(&unit);
        let inverse = plane::adjugate(&root) / plane::determinant(&unit).sqrt();
        Self::from_root(&inverse.map(|entry| libm::scalbn(entry, -half)))
    }

    /// The shape of the Gaussian that meets `f` at its centre, from the Hessian of `ln |f|` there: `Θ⁻¹ = −H`.
    ///
    /// Source: Lemma 4.4 and Eq. (S2.13), with the minus sign and restricted to the transverse plane *before* it is
    /// inverted. [`crate::log_hessian`] makes `H` from derivatives of `f` itself.
    ///
    /// # Errors
    ///
    /// When the Hessian is not finite, not symmetric or not negative definite (no maximum).
    pub fn from_log_hessian(hessian: &Matrix2<f64>) -> Result<Self, ShapeError> {
        let hessian = positive_definite(&-hessian, "negated Hessian of ln |f|")?;
        Self::from_root(&symmetric_root(&hessian))
    }

    /// The shape with `Θ = variance · 1`.
    ///
    /// # Errors
    ///
    /// When `variance` is not finite and positive.
    pub fn isotropic(variance: f64) -> Result<Self, ShapeError> {
        Self::from_theta(&Matrix2::from_diagonal_element(variance))
    }

    /// The root `W`, `Θ⁻¹ = WᵀW`.
    #[inline]
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        &self.root
    }

    /// The shape matrix `Θ = (WᵀW)⁻¹`.
    #[must_use]
    pub fn theta(&self) -> Matrix2<f64> {
        // (WᵀW)⁻¹ = A Aᵀ / |W|² with A the adjugate
        gram(&plane::adjugate(&self.root).transpose()) / (self.determinant * self.determinant)
    }

    /// Its inverse `Θ⁻¹ = WᵀW`: the covariance of the source as the receiver sees it.
    #[must_use]
    pub fn covariance(&self) -> Matrix2<f64> {
        gram(&self.root)
    }

    /// `|det W| = |Θ|^(-1/2)`, always positive.
    #[inline]
    #[must_use]
    pub fn root_determinant(&self) -> f64 {
        self.determinant
    }

    /// Ratio of the eigenvalues of Θ, at least 1.
    ///
    /// Relative error of a few `f64::EPSILON` for the given root.
    #[must_use]
    pub fn condition_number(&self) -> f64 {
        let [large, small] = plane::singular_values(&self.root).values;
        (large / small).powi(2)
    }

    /// Whether Θ is a multiple of the identity, to 4 roundings.
    #[must_use]
    pub fn is_isotropic(&self) -> bool {
        let c = self.covariance();
        self.is_diagonal() && (c.m11 - c.m22).abs() <= 4.0 * f64::EPSILON * c.m11
    }

    /// Whether Θ is diagonal, to 4 roundings.
    #[must_use]
    pub fn is_diagonal(&self) -> bool {
        let c = self.covariance();
        c.m12.abs() <= 4.0 * f64::EPSILON * (c.m11 * c.m22).sqrt()
    }

    /// Whitened coordinates `y = W w`, each right to a few units in its last place for any condition number.
    #[inline]
    #[must_use]
    pub fn whiten(&self, w: &Vector2<f64>) -> Vector2<f64> {
        let y = plane::apply(&self.root, w);
        if y.x.is_finite() && y.y.is_finite() {
            return y;
        }
        // the products overflowed: what does not cancel is infinitely far
        let scale = w.amax();
        plane::apply(&self.root, &(w / scale)) * scale
    }

    /// `W⁻¹ y`, the inverse of [`ShapeMatrix::whiten`].
    #[must_use]
    pub fn unwhiten(&self, y: &Vector2<f64>) -> Vector2<f64> {
        plane::apply(&plane::adjugate(&self.root), y) / plane::determinant(&self.root)
    }

    /// The shape `Θ⁻¹` with root `W^(−T)`, to which the Fourier transform leads (Eq. S1.6).
    #[must_use]
    pub fn fourier_dual(&self) -> Self {
        Self {
            root: plane::inverse(&self.root).transpose(),
            determinant: 1.0 / self.determinant,
        }
    }

    /// The shape with root `W·m`: the same function of coordinates `m w`.
    ///
    /// # Errors
    ///
    /// When the product is singular.
    pub fn in_coordinates(&self, m: &Matrix2<f64>) -> Result<Self, ShapeError> {
        Self::from_root(&plane::product(&self.root, m))
    }

    /// The same function in axes turned by the angle whose cosine and sine are given: `W Rᵀ`, `R = [c s; −s c]`.
    #[must_use]
    pub fn in_turned_axes(&self, cos: f64, sin: f64) -> Self {
        Self {
            root: plane::product(&self.root, &Matrix2::new(cos, -sin, sin, cos)),
            determinant: self.determinant,
        }
    }

    /// The same Θ with another root, `U W` for orthogonal `U`.
    ///
    /// # Errors
    ///
    /// When `u` is not finite or so far from orthogonal that the product is singular.
    pub fn with_root_turned_by(&self, u: &Matrix2<f64>) -> Result<Self, ShapeError> {
        Self::from_root(&plane::product(u, &self.root))
    }
}

/// A matrix as `4^half` times one of size 1, whose determinant neither over- nor underflows.
fn unit(m: &Matrix2<f64>) -> (Matrix2<f64>, i32) {
    let half = libm::ilogb(m.amax()).div_euclid(2);
    (m.map(|entry| libm::scalbn(entry, -2 * half)), half)
}

/// The symmetric root of a positive definite matrix of any size.
fn symmetric_root(m: &Matrix2<f64>) -> Matrix2<f64> {
    let (unit, half) = unit(m);
    plane::symmetric_root(&unit).map(|entry| libm::scalbn(entry, half))
}

/// `mᵀm`, symmetric to the last bit.
fn gram(m: &Matrix2<f64>) -> Matrix2<f64> {
    let off = plane::sum_of_products(m.m11, m.m12, m.m21, m.m22);
    Matrix2::new(
        m.m11 * m.m11 + m.m21 * m.m21,
        off,
        off,
        m.m12 * m.m12 + m.m22 * m.m22,
    )
}

pub(crate) fn finite(m: &Matrix2<f64>, what: &'static str) -> Result<(), ShapeError> {
    for row in 0..2 {
        for column in 0..2 {
            let value = m[(row, column)];
            if !value.is_finite() {
                return Err(ShapeError::NotFinite {
                    what,
                    row,
                    column,
                    value,
                });
            }
        }
    }
    Ok(())
}

pub(crate) fn finite_vector(v: &Vector2<f64>, what: &'static str) -> Result<(), ShapeError> {
    for (row, value) in v.iter().copied().enumerate() {
        if !value.is_finite() {
            let column = 0;
            return Err(ShapeError::NotFinite {
                what,
                row,
                column,
                value,
            });
        }
    }
    Ok(())
}

/// The matrix, exactly symmetric, or what is wrong with it.
pub(crate) fn positive_definite(
    m: &Matrix2<f64>,
    what: &'static str,
) -> Result<Matrix2<f64>, ShapeError> {
    finite(m, what)?;
    let scale = (m.m11.abs().sqrt() * m.m22.abs().sqrt()).max(f64::MIN_POSITIVE);
    if (m.m12 - m.m21).abs() > ASYMMETRY * scale {
        return Err(ShapeError::NotSymmetric {
            what,
            upper: m.m12,
            lower: m.m21,
        });
    }
    let off = 0.5 * m.m12 + 0.5 * m.m21;
    let symmetric = Matrix2::new(m.m11, off, off, m.m22);
    // in units of the largest entry, where no product overflows
    let unit = symmetric.amax();
    let [larger, smaller] = if unit > 0.0 {
        plane::eigenvalues(&(symmetric / unit)).map(|value| value * unit)
    } else {
        [0.0; 2]
    };
    if smaller > 2.0 * f64::EPSILON * larger {
        Ok(symmetric)
    } else {
        Err(ShapeError::NotDefinite {
            what,
            larger,
            smaller,
            expected: "positive",
        })
    }
}
