//! Coefficients over the covariant family of the paper, and back.
//!
//! ```text
//! c_white = Sym(W) c_cov        c_cov = Sym(W⁻¹) c_white        order by order
//! ```

use nalgebra::Matrix2;
use num_complex::Complex64;

use crate::basis::modes;
use crate::series::{HermiteSeries, SeriesError, order_of, quarter_turns};
use crate::shape::ShapeMatrix;

impl HermiteSeries {
    /// The series over the whitened basis of `shape` of the function `Σ č_nm Ψ^Θ_nm(w)`.
    ///
    /// `coefficients` are the paper's `č_nm` for all modes up to an order, in the order of [`crate::modes`]. The
    /// unit of č_nm is that of the function times that of w to the power n + m + 1.
    ///
    /// Source: Definition 4.1 and (S1.2): `c = Sym(W) č`.
    ///
    /// Error: `N ε |W|^N |č|` in order N, `|W|` the larger singular value of the root. If `č` comes from light of
    /// norm 1 its size is `|W⁻¹|^N`, and `cond(Θ)^(N/2) ε` is what remains uncertain: whitened coefficients are
    /// the ones to store.
    ///
    /// # Errors
    ///
    /// When the number of coefficients is not that of all modes up to an order of at most [`crate::MAX_ORDER`], a
    /// coefficient (given or resulting) is not finite, or an even order is not real, an odd one not imaginary (to
    /// 1e-12 of the coefficient).
    ///
    /// ```
    /// use num_complex::Complex64;
    /// use stokes::{HermiteSeries, ShapeMatrix};
    /// // Θ⁻¹ = 4: an order-1 coefficient is multiplied by W = 2
    /// let shape = ShapeMatrix::isotropic(0.25)?;
    /// let series = HermiteSeries::from_covariant(
    ///     &shape,
    ///     &[1.0.into(), Complex64::new(0.0, 0.3), 0.0.into()],
    /// )?;
    /// assert_eq!(series.coefficient(1, 0), Complex64::new(0.0, 0.6));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_covariant(
        shape: &ShapeMatrix,
        coefficients: &[Complex64],
    ) -> Result<Self, SeriesError> {
        let order = order_of(coefficients.len())?;
        let named: Vec<_> = modes(order)
            .zip(coefficients)
            .map(|((a, b), c)| (a, b, *c))
            .collect();
        let covariant = Self::from_modes(&named)?;
        Self::from_real_coefficients(&raised(&covariant, shape.root()))
    }

    /// The paper's coefficients `č_nm` of this series over `shape`, all modes in the order of [`crate::modes`]: the
    /// projections `⟨f|Ψ̃^Θ_nm⟩` on the dual family.
    ///
    /// The unit of č_nm is that of the function times that of w to the power n + m + 1. Infinite where a
    /// coefficient exceeds `f64::MAX`: for a footprint of 0.1 mm they grow like 1e4 to the power n + m.
    ///
    /// Source: (S1.4), Lemma 4.3: `č = Sym(W⁻¹) c`.
    ///
    /// Error: `N ε |W⁻¹|^N |c|` in order N: a small coefficient of a thin shape has no right digits, though
    /// `Sym(W) č` has.
    #[must_use]
    pub fn to_covariant(&self, shape: &ShapeMatrix) -> Vec<Complex64> {
        let covariant = raised(self, &crate::plane::inverse(shape.root()));
        modes(self.order())
            .zip(covariant)
            .map(|((a, b), s)| quarter_turns(s, a + b))
            .collect()
    }
}

/// `Sym(map)` applied order by order, the size of `map` as a power of two apart.
fn raised(series: &HermiteSeries, map: &Matrix2<f64>) -> Vec<f64> {
    let exponent = libm::ilogb(map.amax()) + 1;
    let unit = map.map(|entry| libm::scalbn(entry, -exponent));
    let raised = series.raised(&unit);
    modes(series.order())
        .zip(raised)
        .map(|((a, b), s)| libm::scalbn(s, exponent * (a + b) as i32))
        .collect()
}
