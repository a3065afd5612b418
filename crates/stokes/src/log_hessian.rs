//! The Hessian of the logarithm of a function, and the shape matrix that it is.
//!
//! ```text
//! ∂² ln f = (1/f) ∂²f − (1/f²) ∇f ∇fᵀ                                                              (Lemma S2.1)
//! (A + u vᵀ)⁻¹ = A⁻¹ − t A⁻¹u vᵀA⁻¹,     t = 1/(1 + vᵀA⁻¹u)                                        (Lemma S2.2)
//! [∂² ln f]⁻¹ = A⁻¹ − t₁ A⁻¹B₁A⁻¹,       A = ∂²f/f,  B₁ = −∇f ∇fᵀ/f²                                    (S2.16)
//! t₁ = [1 − (1/f) tr(∇f ∇fᵀ (∂²f)⁻¹)]⁻¹                                                                (S2.17)
//! ```
//!
//! (S2.17) is printed without the inverse of `∂²f`. For complex f, that of an envelope off its phase centre, what
//! matters is `ln |f|`, whose Hessian is the real part.

use nalgebra::{Matrix2, Scalar, Vector2};
use num_complex::Complex64;

use crate::plane;
use crate::shape::{ShapeError, ShapeMatrix, finite, finite_vector};

/// Hessian of `ln |f|` from the value, the gradient and the Hessian of `f` at the same point.
///
/// 2×2, in the inverse square of the unit of the coordinates; `f` is real or complex, of either sign. Symmetric to
/// the last bit if `hessian` is.
///
/// Source: Lemma S2.1, its real part.
///
/// Error: a few ε of `|∂²f/f| + |∇f/f|²`, of which little is left in the sum far from a maximum.
///
/// # Errors
///
/// When `f` is 0 or not finite, or a derivative is not finite.
///
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// // f = e^(−x² − y²/2 + y) at 0: ln f has the Hessian diag(−2, −1)
/// let found = stokes::log_hessian(1.0, &Vector2::new(0.0, 1.0), &Matrix2::new(-2.0, 0.0, 0.0, 0.0))?;
/// assert_eq!(found, Matrix2::new(-2.0, 0.0, 0.0, -1.0));
/// # Ok::<(), stokes::ShapeError>(())
/// ```
pub fn log_hessian<T>(
    f: T,
    gradient: &Vector2<T>,
    hessian: &Matrix2<T>,
) -> Result<Matrix2<f64>, ShapeError>
where
    T: Scalar + Copy + Into<Complex64>,
{
    let f: Complex64 = f.into();
    let largest = f.re.abs().max(f.im.abs());
    if !(f.re.is_finite() && f.im.is_finite()) || largest == 0.0 {
        return Err(ShapeError::NoLogarithm { value: f.norm() });
    }
    let gradient = gradient.map(Into::into);
    let hessian = hessian.map(Into::into);
    for part in [|z: Complex64| z.re, |z: Complex64| z.im] {
        finite_vector(&gradient.map(part), "gradient of f")?;
        finite(&hessian.map(part), "Hessian of f")?;
    }
    // only ratios to f matter: no square over- or underflows if f is near 1
    let exponent = -libm::ilogb(largest);
    let scaled =
        |z: Complex64| Complex64::new(libm::scalbn(z.re, exponent), libm::scalbn(z.im, exponent));
    let over_f = scaled(f).inv();
    let [g1, g2] = [gradient.x, gradient.y].map(|entry| scaled(entry) * over_f);
    // Re(g_i g_j) = p_i p_j − q_i q_j
    let squares = |a: Complex64, b: Complex64| plane::sum_of_products(a.re, b.re, -a.im, b.im);
    let off = squares(g1, g2);
    let curvature = hessian.map(|entry| (scaled(entry) * over_f).re);
    let log = curvature - Matrix2::new(squares(g1, g1), off, off, squares(g2, g2));
    finite(&log, "Hessian of ln |f|")?;
    Ok(log)
}

/// Inverse of the Hessian of `ln |f|`: minus the shape matrix Θ of the Gaussian that meets `f` at a maximum.
///
/// 2×2, in the square of the unit of the coordinates. No maximum is needed here.
///
/// Source: (S2.16), with the inverse in (S2.17) that is missing in print. For two dimensions it is evaluated as
/// `(adj A + adj B₁)/(|A| + tr(B₁ adj A))`, that is, with numerator and denominator times `|A|`: A is singular one
/// standard deviation off the centre of any Gaussian, where its logarithm is as good as elsewhere.
///
/// # Errors
///
/// As [`log_hessian`], and when the Hessian of `ln |f|` is singular (to 4e-16 of its larger eigenvalue).
pub fn inverse_log_hessian<T>(
    f: T,
    gradient: &Vector2<T>,
    hessian: &Matrix2<T>,
) -> Result<Matrix2<f64>, ShapeError>
where
    T: Scalar + Copy + Into<Complex64>,
{
    let log = log_hessian(f, gradient, hessian)?;
    // adj is linear in two dimensions, and |A| + tr(B₁ adj A) is |A + B₁|
    let unit = log.amax();
    let singular = |[larger, smaller]: [f64; 2]| ShapeError::NotDefinite {
        what: "Hessian of ln |f|",
        larger,
        smaller,
        expected: "other than 0",
    };
    if unit == 0.0 {
        return Err(singular([0.0; 2]));
    }
    let scaled = log / unit;
    let values = plane::singular_values(&scaled).values;
    if values[1] <= 2.0 * f64::EPSILON * values[0] {
        return Err(singular(values.map(|value| value * unit)));
    }
    Ok(plane::inverse(&scaled) / unit)
}

/// `(A + u vᵀ)⁻¹` from `A⁻¹`; `None` when the sum is singular.
///
/// Sums of more matrices of rank 1 follow one after another.
///
/// Source: Lemma S2.2 (Sherman and Morrison); t is `1/(1 + vᵀA⁻¹u)`. The relative error is a few ε of
/// `|A⁻¹| |u| |v| |t|`.
///
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// let x = Vector2::x();
/// let found = stokes::inverse_of_sum(&Matrix2::identity(), &x, &x);
/// assert_eq!(found, Some(Matrix2::new(0.5, 0.0, 0.0, 1.0)));
/// ```
#[must_use]
pub fn inverse_of_sum(
    inverse: &Matrix2<f64>,
    u: &Vector2<f64>,
    v: &Vector2<f64>,
) -> Option<Matrix2<f64>> {
    let (left, right) = (
        plane::apply(inverse, u),
        plane::apply(&inverse.transpose(), v),
    );
    let t = 1.0 / (1.0 + plane::sum_of_products(v.x, left.x, v.y, left.y));
    let sum = inverse - t * left * right.transpose();
    sum.iter().all(|entry| entry.is_finite()).then_some(sum)
}

impl ShapeMatrix {
    /// The shape of the Gaussian that meets `f` at its maximum, from the value, gradient and Hessian of `f` there.
    ///
    /// `Θ = −[∂² ln |f|]⁻¹`, in the square of the unit of the coordinates; `f` is real or complex. The coordinates
    /// are those of the transverse plane: restrict a Hessian to it *before* this.
    ///
    /// Source: Theorem S4.1 (ii) with the minus sign, (S2.16) and (S2.17).
    ///
    /// # Errors
    ///
    /// When `f` is 0 or not finite, a derivative is not finite, the Hessian is not symmetric, or `ln |f|` has no
    /// maximum to second order: its Hessian is not negative definite.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector2};
    /// use stokes::ShapeMatrix;
    /// // the transform of a rectangle of half-widths 3 and 1: f = 12 (1 − 3x²/2 − y²/6 …), Θ = diag(1/3, 3)
    /// let hessian = Matrix2::new(-36.0, 0.0, 0.0, -4.0);
    /// let shape = ShapeMatrix::from_derivatives(12.0, &Vector2::zeros(), &hessian)?;
    /// assert!((shape.theta() - Matrix2::new(1.0 / 3.0, 0.0, 0.0, 3.0)).amax() < 4e-15);
    /// # Ok::<(), stokes::ShapeError>(())
    /// ```
    pub fn from_derivatives<T>(
        f: T,
        gradient: &Vector2<T>,
        hessian: &Matrix2<T>,
    ) -> Result<Self, ShapeError>
    where
        T: Scalar + Copy + Into<Complex64>,
    {
        Self::from_log_hessian(&log_hessian(f, gradient, hessian)?)
    }
}
