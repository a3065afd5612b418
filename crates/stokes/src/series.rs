//! One component of the light: a Hermite-Gauss series whose coefficients are those of a Hermitian function.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use num_complex::Complex64;
use smallvec::{SmallVec, smallvec};
use thiserror::Error;

use crate::basis::{mode_count, mode_index, modes};
use crate::hermite::MAX_ORDER;
use crate::lanes::parity_sums;
use crate::shape::ShapeMatrix;
use crate::symmetric_power::raise;

/// Why numbers are no series.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SeriesError {
    /// The number of coefficients is not that of all modes up to an order.
    #[error(
        "series: found {found} coefficients, expected 1, 3, 6, 10, …: (N+1)(N+2)/2 for order N"
    )]
    Count {
        /// How many there are.
        found: usize,
    },
    /// The order is beyond what the functions are made for.
    #[error("series: order {order}, expected at most 256")]
    Order {
        /// The order.
        order: usize,
    },
    /// A coefficient is infinite or not a number.
    #[error("series: coefficient ({a}, {b}) is {value}, expected a finite number")]
    NotFinite {
        /// Order along the first axis.
        a: usize,
        /// Order along the second axis.
        b: usize,
        /// The coefficient.
        value: Complex64,
    },
    /// The function would not be Hermitian.
    #[error(
        "series: coefficient ({a}, {b}) is {value}, expected a purely {expected} number, since C(−ξ) is the conjugate of \
         C(ξ): even orders are real, odd ones imaginary"
    )]
    NotHermitian {
        /// Order along the first axis.
        a: usize,
        /// Order along the second axis.
        b: usize,
        /// The coefficient.
        value: Complex64,
        /// `"real"` or `"imaginary"`.
        expected: &'static str,
    },
}

/// A Hermite-Gauss series `Σ c_ab φ_ab(w; W)` over the modes a + b ≤ N, in the whitened basis.
///
/// A coherence function is Hermitian, `C(−ξ) = C(ξ)*`, so that coefficients of even total order are real and those
/// of odd order imaginary. What is stored is the *real* number `s_ab = (−i)^(a+b) c_ab`, which is also the
/// coefficient of the Wigner function (S3.3). Unit: that of C times m² times `|det W|^(−1/2)`.
///
/// A series of order 0 is one number and needs no memory of its own.
///
/// ```
/// use num_complex::Complex64;
/// use stokes::HermiteSeries;
/// let tilted = HermiteSeries::from_modes(&[(0, 0, 1.0.into()), (1, 0, Complex64::new(0.0, 0.15))])?;
/// assert_eq!(tilted.order(), 1);
/// assert_eq!(tilted.real_coefficient(1, 0), 0.15);
/// assert_eq!(tilted.coefficient(1, 0), Complex64::new(0.0, 0.15));
/// # Ok::<(), stokes::SeriesError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct HermiteSeries {
    order: usize,
    /// In the order of [`crate::modes`].
    real: SmallVec<[f64; 1]>,
    /// Whether an odd total order holds a number other than 0.
    odd: bool,
}

impl HermiteSeries {
    /// The series of the one mode (0, 0), without allocation.
    ///
    /// A number that is not finite is refused by [`crate::GeneralizedStokes::new`].
    #[must_use]
    pub fn fundamental(c00: f64) -> Self {
        Self {
            order: 0,
            real: smallvec![c00],
            odd: false,
        }
    }

    /// The series with real coefficients `s_ab = (−i)^(a+b) c_ab`, in the order of [`crate::modes`].
    ///
    /// # Errors
    ///
    /// When their number is not that of all modes up to an order of at most [`MAX_ORDER`], or one is not finite.
    pub fn from_real_coefficients(real: &[f64]) -> Result<Self, SeriesError> {
        let order = order_of(real.len())?;
        let series = Self::from_real_parts(order, real);
        series.finite()?;
        Ok(series)
    }

    /// An error if a coefficient is not a finite number.
    pub(crate) fn finite(&self) -> Result<(), SeriesError> {
        let mut coefficients = modes(self.order).zip(&self.real);
        match coefficients.find(|(_, s)| !s.is_finite()) {
            Some(((a, b), _)) => {
                let value = self.coefficient(a, b);
                Err(SeriesError::NotFinite { a, b, value })
            }
            None => Ok(()),
        }
    }

    /// The series with the coefficients `c_ab` of the modes (a, b) that are named; the others are 0. A mode that is
    /// named twice counts twice.
    ///
    /// # Errors
    ///
    /// When a coefficient is not finite, its order exceeds [`MAX_ORDER`], or an even order is not real, an odd one
    /// not imaginary (to 1e-12 of the coefficient).
    pub fn from_modes(modes: &[(usize, usize, Complex64)]) -> Result<Self, SeriesError> {
        let order = modes.iter().map(|(a, b, _)| a + b).max().unwrap_or(0);
        if order > MAX_ORDER {
            return Err(SeriesError::Order { order });
        }
        let mut real: SmallVec<[f64; 1]> = smallvec![0.0; mode_count(order)];
        for &(a, b, value) in modes {
            if !(value.re.is_finite() && value.im.is_finite()) {
                return Err(SeriesError::NotFinite { a, b, value });
            }
            let turned = value * Complex64::new(0.0, -1.0).powu((a + b) as u32);
            if turned.im.abs() > 1e-12 * turned.re.abs() {
                let expected = if (a + b) % 2 == 0 {
                    "real"
                } else {
                    "imaginary"
                };
                return Err(SeriesError::NotHermitian {
                    a,
                    b,
                    value,
                    expected,
                });
            }
            real[mode_index(a, b)] += turned.re;
        }
        Ok(Self::from_valid(order, real))
    }

    /// As [`HermiteSeries::from_real_coefficients`], for numbers of the right count; finite ones or yet to be checked.
    pub(crate) fn from_real_parts(order: usize, real: &[f64]) -> Self {
        debug_assert_eq!(
            real.len(),
            mode_count(order),
            "coefficients of order {order}"
        );
        Self::from_valid(order, SmallVec::from_slice(real))
    }

    /// Whether the coefficients have memory of their own.
    #[cfg(test)]
    pub(crate) fn is_on_the_heap(&self) -> bool {
        self.real.spilled()
    }

    fn from_valid(order: usize, real: SmallVec<[f64; 1]>) -> Self {
        let odd = (1..=order)
            .step_by(2)
            .any(|n| total_order(&real, n).iter().any(|s| *s != 0.0));
        Self { order, real, odd }
    }

    /// Highest total order N.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Whether an odd order is there: light whose source is not symmetric about its phase centre.
    #[must_use]
    pub fn has_odd_orders(&self) -> bool {
        self.odd
    }

    /// The real coefficients `s_ab = (−i)^(a+b) c_ab`, in the order of [`crate::modes`].
    #[inline]
    #[must_use]
    pub fn real_coefficients(&self) -> &[f64] {
        &self.real
    }

    /// The real number `s_ab = (−i)^(a+b) c_ab`; 0 beyond the order.
    #[must_use]
    pub fn real_coefficient(&self, a: usize, b: usize) -> f64 {
        if a + b <= self.order {
            self.real[mode_index(a, b)]
        } else {
            0.0
        }
    }

    /// The coefficient `c_ab`: real for even a + b, imaginary for odd; 0 beyond the order.
    #[must_use]
    pub fn coefficient(&self, a: usize, b: usize) -> Complex64 {
        quarter_turns(self.real_coefficient(a, b), a + b)
    }

    /// The L² norm of the function, `√Σ|c_ab|²` (Parseval).
    #[must_use]
    pub fn norm(&self) -> f64 {
        norm(&self.real)
    }

    /// The series without the orders above `order`, and the L² norm of what was cut off.
    ///
    /// ```
    /// use stokes::HermiteSeries;
    /// let series = HermiteSeries::from_real_coefficients(&[2.0, 0.3, 0.4])?;
    /// let (kept, lost) = series.truncated(0);
    /// assert_eq!((kept.order(), lost), (0, 0.5));
    /// # Ok::<(), stokes::SeriesError>(())
    /// ```
    #[must_use]
    pub fn truncated(&self, order: usize) -> (Self, f64) {
        if order >= self.order {
            return (self.clone(), 0.0);
        }
        let (kept, lost) = self.real.split_at(mode_count(order));
        (
            Self::from_valid(order, SmallVec::from_slice(kept)),
            norm(lost),
        )
    }

    /// The sum `self + factor · other`, of the larger order.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let (mut real, order) = if other.order > self.order {
            let mut real = self.real.clone();
            real.resize(other.real.len(), 0.0);
            (real, other.order)
        } else {
            (self.real.clone(), self.order)
        };
        for (sum, s) in real.iter_mut().zip(&other.real) {
            *sum += factor * s;
        }
        Self::from_valid(order, real)
    }

    /// Every coefficient times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let real = self.real.iter().map(|s| factor * s).collect();
        Self::from_valid(self.order, real)
    }

    /// The coefficients of the same function for the root `U W`, `U` orthogonal: `Sym(U) c`, order by order.
    ///
    /// Norms are kept to `N·ε`; the relation holds for any `U`, by which coefficients of the paper's covariant
    /// family become whitened ones.
    #[must_use]
    pub fn with_root_turned_by(&self, u: &Matrix2<f64>) -> Self {
        Self::from_valid(self.order, self.raised(u))
    }

    /// `Sym^n(map)` times the coefficients of each total order n.
    pub(crate) fn raised(&self, map: &Matrix2<f64>) -> SmallVec<[f64; 1]> {
        // Sym⁰ = 1
        let mut real = SmallVec::from_slice(total_order(&self.real, 0));
        let mut power = DMatrix::from_element(1, 1, 1.0);
        for n in 1..=self.order {
            power = raise(map, &power);
            let raised = &power * DVector::from_column_slice(total_order(&self.real, n));
            real.extend_from_slice(raised.as_slice());
        }
        real
    }

    /// The value at `w`, `Σ c_ab φ_ab(w; W)`.
    ///
    /// Error: that of the functions ([`crate::hermite`]) times `|det W|^(1/2)` times the norm. No allocation.
    #[must_use]
    pub fn value(&self, shape: &ShapeMatrix, w: &Vector2<f64>) -> Complex64 {
        let y = shape.whiten(w);
        let [re, im] = parity_sums(self.order, &self.real, [y.x, y.y], self.odd, true);
        Complex64::new(re, im) * shape.root_determinant().sqrt()
    }

    /// The sum of the real coefficients, `Σ s_ab h_a(y1) h_b(y2)`, at a whitened point `y`.
    #[must_use]
    pub fn real_sum(&self, y: &Vector2<f64>) -> f64 {
        let [even, odd] = parity_sums(self.order, &self.real, [y.x, y.y], self.odd, false);
        even + odd
    }

    /// The value at 0, which is real; error as [`HermiteSeries::value`].
    #[must_use]
    pub fn value_at_zero(&self, shape: &ShapeMatrix) -> f64 {
        self.sum_at_zero() * shape.root_determinant().sqrt()
    }

    /// `Σ c_ab h_a(0) h_b(0)`, to which odd orders contribute nothing.
    #[must_use]
    pub fn sum_at_zero(&self) -> f64 {
        let [sum, _] = parity_sums(self.order, &self.real, [0.0; 2], false, true);
        sum
    }
}

/// `iⁿ s`.
pub(crate) fn quarter_turns(s: f64, n: usize) -> Complex64 {
    match n % 4 {
        0 => Complex64::new(s, 0.0),
        1 => Complex64::new(0.0, s),
        2 => Complex64::new(-s, 0.0),
        _ => Complex64::new(0.0, -s),
    }
}

/// The coefficients with a + b = n.
pub(crate) fn total_order(real: &[f64], n: usize) -> &[f64] {
    &real[mode_index(n, 0)..mode_count(n)]
}

pub(crate) fn order_of(count: usize) -> Result<usize, SeriesError> {
    let mut order = 0;
    while mode_count(order) < count && order <= MAX_ORDER {
        order += 1;
    }
    if order > MAX_ORDER {
        Err(SeriesError::Order { order })
    } else if mode_count(order) == count {
        Ok(order)
    } else {
        Err(SeriesError::Count { found: count })
    }
}

/// `√Σx²` without overflow.
pub(crate) fn norm(values: &[f64]) -> f64 {
    let scale = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    scale
        * values
            .iter()
            .map(|x| (x / scale).powi(2))
            .sum::<f64>()
            .sqrt()
}
