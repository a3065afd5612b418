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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The transform of a mixture of Gaussians with weights, centres and covariances, and its derivatives at `w`.
    fn transform(
        terms: &[(f64, Vector2<f64>, Matrix2<f64>)],
        w: &Vector2<f64>,
    ) -> (Complex64, Vector2<Complex64>, Matrix2<Complex64>) {
        let mut sum = (
            Complex64::ZERO,
            Vector2::from_element(Complex64::ZERO),
            Matrix2::from_element(Complex64::ZERO),
        );
        for (weight, centre, s) in terms {
            let exponent = Complex64::new(-0.5 * w.dot(&(s * w)), -w.dot(centre));
            let value = weight * exponent.exp();
            let sw = s * w;
            let slope = Vector2::from_fn(|i, _| Complex64::new(-sw[i], -centre[i]));
            sum.0 += value;
            sum.1 += slope * value;
            sum.2 += (slope * slope.transpose() - s.map(Complex64::from)) * value;
        }
        sum
    }

    /// Hessian of `ln |f|` by differences of fourth order.
    fn differences(log: impl Fn(f64, f64) -> f64, h: f64) -> Matrix2<f64> {
        let along = |dx: f64, dy: f64| {
            let at = |s: f64| log(s * h * dx, s * h * dy);
            (-at(2.0) + 16.0 * at(1.0) - 30.0 * at(0.0) + 16.0 * at(-1.0) - at(-2.0))
                / (12.0 * h * h)
        };
        let (xx, yy) = (along(1.0, 0.0), along(0.0, 1.0));
        let xy = (along(1.0, 1.0) - along(1.0, -1.0)) / 4.0;
        Matrix2::new(xx, xy, xy, yy)
    }

    fn covariance() -> impl Strategy<Value = Matrix2<f64>> {
        (0.2..2.0f64, 0.2..2.0f64, -0.9..0.9f64).prop_map(|(a, b, r)| {
            let off = r * (a * b).sqrt();
            Matrix2::new(a, off, off, b)
        })
    }

    fn point() -> impl Strategy<Value = Vector2<f64>> {
        (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y)| Vector2::new(x, y))
    }

    proptest! {
        #[test]
        fn the_log_hessian_is_that_of_finite_differences(
            m1 in point(), m2 in point(), s1 in covariance(), s2 in covariance(), w in point(), weight in 0.1..0.5f64,
        ) {
            // off-centre and complex; weights 1 and below 1/2 keep f away from 0 near the origin
            let terms = [(1.0, m1, s1), (weight, m2, s2)];
            let w = 0.3 * w;
            let (f, gradient, hessian) = transform(&terms, &w);
            let found = log_hessian(f, &gradient, &hessian).unwrap();
            let log = |dx: f64, dy: f64| transform(&terms, &(w + Vector2::new(dx, dy))).0.norm().ln();
            let h = 5e-3;
            let (expected, coarse) = (differences(log, h), differences(log, 2.0 * h));
            // the truncation grows 16-fold with the step; ln |f| is right to 3 ε, its weights add up to 64/12
            let truncation = (coarse - expected).amax() / 4.0;
            prop_assert!((found - expected).amax() < truncation + 24.0 * f64::EPSILON / (h * h));
        }

        #[test]
        fn an_off_centre_gaussian_has_the_same_shape_everywhere(
            p in covariance(), x in point(), scale in -200i32..200, negative in any::<bool>(),
        ) {
            // f = ± 2^scale e^(−xᵀPx/2), up to three standard deviations off its centre
            let x = 2.0 * x;
            let size = if negative { -1.0 } else { 1.0 } * libm::scalbn(1.0, 4 * scale);
            let f = size * (-0.5 * x.dot(&(p * x))).exp();
            let slope = -p * x;
            let gradient = slope * f;
            let hessian = (slope * slope.transpose() - p) * f;
            let hessian = Matrix2::new(hessian.m11, hessian.m12, hessian.m12, hessian.m22);
            let found = log_hessian(f, &gradient, &hessian).unwrap();
            let size = p.amax() + slope.norm_squared();
            prop_assert!((found + p).amax() <= 16.0 * f64::EPSILON * size);
            let theta = -inverse_log_hessian(f, &gradient, &hessian).unwrap();
            let condition = p.norm() * theta.norm();
            prop_assert!((theta * p - Matrix2::identity()).amax() <= 32.0 * f64::EPSILON * size * theta.norm() * condition);
            let shape = ShapeMatrix::from_derivatives(f, &gradient, &hessian).unwrap();
            prop_assert!((shape.theta() - theta).amax() <= 32.0 * f64::EPSILON * condition * theta.amax());
        }

        #[test]
        fn two_updates_of_rank_one_are_the_inverse_of_the_sum(
            a in covariance(), u in point(), v in point(), p in point(), q in point(),
        ) {
            let sum = a + u * v.transpose() + p * q.transpose();
            prop_assume!(sum.determinant().abs() > 1e-2 && (a + u * v.transpose()).determinant().abs() > 1e-2);
            let first = inverse_of_sum(&a.try_inverse().unwrap(), &u, &v).unwrap();
            let second = inverse_of_sum(&first, &p, &q).unwrap();
            // each factor of the error is at most the largest matrix over the smallest determinant: 8/1e-2
            prop_assert!((second * sum - Matrix2::identity()).amax() < 64.0 * f64::EPSILON * 800.0f64.powi(2));
        }
    }

    #[test]
    fn the_closed_form_holds_where_its_own_matrix_is_singular() {
        // at one standard deviation A = ggᵀ − P is singular, ln f is not
        let (g, p) = (Vector2::new(1.0, 0.0), Matrix2::identity());
        let a = g * g.transpose() - p;
        assert_eq!(a.determinant(), 0.0);
        let found = inverse_log_hessian(1.0, &g, &a).unwrap();
        assert_eq!(found, -p);
    }

    #[test]
    fn a_sum_that_is_singular_has_no_inverse() {
        let u = Vector2::new(1.0, 0.0);
        assert_eq!(inverse_of_sum(&Matrix2::identity(), &u, &-u), None);
    }

    #[test]
    fn what_has_no_shape_is_refused_with_its_numbers() {
        let (flat, zero) = (Vector2::zeros(), Matrix2::zeros());
        let text = |f: f64, gradient: Vector2<f64>, hessian: Matrix2<f64>| {
            ShapeMatrix::from_derivatives(f, &gradient, &hessian)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            text(0.0, flat, -Matrix2::identity()),
            "shape: the function is 0 where its logarithm is differentiated, expected a finite number other than 0"
        );
        assert_eq!(
            text(f64::NAN, flat, -Matrix2::identity()),
            "shape: the function is NaN where its logarithm is differentiated, expected a finite number other than 0"
        );
        assert_eq!(
            text(1.0, Vector2::new(0.0, f64::INFINITY), -Matrix2::identity()),
            "shape: entry (1, 0) of the gradient of f is inf, expected a finite number"
        );
        // a saddle
        assert_eq!(
            text(2.0, flat, Matrix2::new(-4.0, 0.0, 0.0, 2.0)),
            "shape: the negated Hessian of ln |f| has eigenvalues 2 and -1, expected both positive (beyond 4e-16 of \
             the larger)"
        );
        // a minimum of f < 0 is a maximum of |f|
        assert!(ShapeMatrix::from_derivatives(-1.0, &flat, &Matrix2::identity()).is_ok());
        assert_eq!(
            inverse_log_hessian(1.0, &flat, &zero)
                .unwrap_err()
                .to_string(),
            "shape: the Hessian of ln |f| has eigenvalues 0 and 0, expected both other than 0 (beyond 4e-16 of the \
             larger)"
        );
    }
}
