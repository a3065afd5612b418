//! The paper's covariant family `Ψ^Θ_nm` of Hermite-Gauss functions and its dual, for exchange and for proof.
//!
//! ```text
//! Σ 2^((n+m)/2)/√(n! m!) a₁ⁿ a₂ᵐ Ψ_nm(x) = e^(−xᵀΘ⁻¹x/2 + aᵀΘ⁻¹(2x − a)) / (π^(1/2) |Θ|^(1/4))            (S1.2)
//! Σ 2^((n+m)/2)/√(n! m!) a₁ⁿ a₂ᵐ Ψ̃_nm(x) = e^(−xᵀΘ⁻¹x/2 + aᵀ(2x − Θa)) / (π^(1/2) |Θ|^(1/4))             (S1.3)
//! ```
//!
//! Light in this crate is a series over the whitened basis ([`crate::whitened_mode`]), in which coefficients mean
//! amplitudes. Here neither family is orthogonal, the functions have a unit that grows with their order, and a thin
//! shape makes them huge and cancelling. With `u = Θ⁻¹x, G = Θ⁻¹` (dual: `u = x, G = Θ`) both obey
//!
//! ```text
//! √(n+1) g_{n+1,m} = √2 u₁ g_nm − G₁₁ √n g_{n−1,m} − G₁₂ √m g_{n,m−1}
//! ```
//!
//! which is evaluated in numbers of twice the precision, with an exponent of their own, after both axes are scaled
//! by powers of two. Speed is not the aim.

use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2};

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;

use crate::double::Double;
use crate::hermite::{MAX_ORDER, Scaled, scaled_exponential};
use crate::series::quarter_turns;
use crate::shape::{ShapeError, finite_vector, positive_definite};

/// Which of the two biorthogonal families, `⟨Ψ_nm|Ψ̃_n'm'⟩ = δ` (S1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// `Ψ^Θ_nm` of (S1.2), in which the paper expands light; unit: that of x to the power −(n+m) − 1.
    Covariant,
    /// `Ψ̃^Θ_nm` of (S1.3), on which coefficients are projected; unit: that of x to the power (n+m) − 1.
    Dual,
}

/// The function `Ψ^Θ_nm` or its dual at `x`; Θ in the unit of x².
///
/// Infinite where the value exceeds `f64::MAX`, which thin and small shapes reach at ordinary orders.
///
/// Source: (S1.2) and (S1.3) with the norm of two dimensions, `(π² |Θ|)^(1/4)`.
///
/// Accuracy: relative error below 5 ε for the given numbers, for orders up to 40 along each axis, condition numbers
/// of Θ up to 1e14 and x out to 8 standard deviations (tests/covariant.rs). A rounding of those numbers themselves
/// changes the value by the condition number of Θ times ε and more.
///
/// # Errors
///
/// When Θ is not finite, symmetric and positive definite, `x` is not finite, or an order exceeds [`MAX_ORDER`].
///
/// ```
/// use nalgebra::{Matrix2, Vector2};
/// use stokes::{Family, covariant_mode};
/// // for Θ = 1 both are products of one-dimensional functions: h_2(0) h_0(0) = −1/√(2π)
/// let found = covariant_mode(Family::Covariant, 2, 0, &Matrix2::identity(), &Vector2::zeros())?;
/// assert!((found + 0.398_942_280_401_432_7).abs() < 1e-15);
/// # Ok::<(), stokes::ShapeError>(())
/// ```
pub fn covariant_mode(
    family: Family,
    n: usize,
    m: usize,
    theta: &Matrix2<f64>,
    x: &Vector2<f64>,
) -> Result<f64, ShapeError> {
    let theta = UnitTheta::new(n, m, theta)?;
    finite_vector(x, "point")?;
    let [e1, e2] = theta.axes;
    let Some(x) = scaled_point(x, [-e1, -e2]) else {
        return Ok(0.0);
    };
    let dual_x = theta.inverse_times(x);
    let square = x[0] * dual_x[0] + x[1] * dual_x[1];
    let u = match family {
        Family::Covariant => dual_x,
        Family::Dual => x,
    };
    let norm = theta.fourth_root(-1);
    Ok(theta.value(theta.quadratic(family), n, m, u, square, norm))
}

/// The value at 0 of `Ψ^Θ_nm` or its dual, by the sum over compositions; 0 for odd n + m.
///
/// With the symmetric root no two terms have different signs, so that nothing cancels: relative error below
/// `8 (n+m) ε` for any Θ that is accepted.
///
/// Source: (S1.7) in two dimensions. The sum runs over *compositions* of n and m, that is, over all 2×2 matrices of
/// natural numbers with column sums n and m and even row sums; the product's index is not the order l.
///
/// # Errors
///
/// As [`covariant_mode`].
pub fn covariant_mode_at_zero(
    family: Family,
    n: usize,
    m: usize,
    theta: &Matrix2<f64>,
) -> Result<f64, ShapeError> {
    let theta = UnitTheta::new(n, m, theta)?;
    if (n + m) % 2 == 1 {
        return Ok(0.0);
    }
    let quadratic = theta.quadratic(family);
    let [g11, g12, g22] = quadratic.g.map(|entry| entry.head);
    // the symmetric root of G, whose determinant is known without a difference
    let s = quadratic.root_determinant;
    let t = (g11 + g22 + 2.0 * s).sqrt();
    let [q11, q12, q22] = [(g11 + s) / t, g12 / t, (g22 + s) / t];
    let choose = binomials(n + m);
    // (r − 1)!!/√r!, the value of a one-dimensional function at 0 but for sign and unit
    let at_zero = |r: usize| {
        (1..=r / 2)
            .map(|j| (2 * j - 1) as f64 / (2 * j) as f64)
            .product::<f64>()
            .sqrt()
    };
    let mut sum = 0.0;
    for t11 in 0..=n {
        for t12 in (t11 % 2..=m).step_by(2) {
            let (t21, t22) = (n - t11, m - t12);
            let (r1, r2) = (t11 + t12, t21 + t22);
            // √(n! m! r1! r2!)/(t11! t12! t21! t22!)
            let ways = choose[n][t11].sqrt()
                * choose[m][t12].sqrt()
                * choose[r1][t11].sqrt()
                * choose[r2][t21].sqrt();
            sum += ways
                * at_zero(r1)
                * at_zero(r2)
                * q11.powi(t11 as i32)
                * q12.abs().powi((t12 + t21) as i32)
                * q22.powi(t22 as i32);
        }
    }
    // every term has t12 + t21 of the parity of n, and i^(−r1 − r2) is common
    let negative = ((n + m) / 2 % 2 == 1) != (n % 2 == 1 && q12 < 0.0);
    let mantissa = if negative { -sum } else { sum };
    let norm = theta.fourth_root(-1);
    let exponent = quadratic.exponent(n, m) + norm.exponent;
    Ok(scalbn(
        mantissa * norm.mantissa * FRAC_2_SQRT_PI / 2.0,
        i64::from(exponent),
    ))
}

/// The Fourier transform `∫ Ψ^Θ_nm(x) e^(−iζ·x) d²x` or that of the dual, at `zeta` (in the inverse unit of x).
///
/// It is `2π (−i)^(n+m)` times the function of the *other* family with Θ⁻¹. (The functions are therefore no
/// eigenfunctions of the transform unless Θ = 1, as the remark after (S1.6) has it.) Θ⁻¹ is never rounded.
///
/// Source: (S1.6). Accuracy as [`covariant_mode`].
///
/// # Errors
///
/// As [`covariant_mode`].
pub fn covariant_mode_fourier(
    family: Family,
    n: usize,
    m: usize,
    theta: &Matrix2<f64>,
    zeta: &Vector2<f64>,
) -> Result<Complex64, ShapeError> {
    let theta = UnitTheta::new(n, m, theta)?;
    finite_vector(zeta, "frequency")?;
    let Some(zeta) = scaled_point(zeta, theta.axes) else {
        return Ok(Complex64::ZERO);
    };
    let theta_zeta = theta.times(zeta);
    let square = zeta[0] * theta_zeta[0] + zeta[1] * theta_zeta[1];
    let u = match family {
        Family::Covariant => zeta,
        Family::Dual => theta_zeta,
    };
    let mut norm = theta.fourth_root(1);
    norm.mantissa *= 2.0 * PI;
    let value = theta.value(theta.quadratic(family), n, m, u, square, norm);
    Ok(quarter_turns(value, n + m).conj())
}

/// Θ in units of its own axes: `Θ = D Θ′ D` with `D = diag(2^axes)` and the diagonal of Θ′ in 1..4.
struct UnitTheta {
    axes: [i32; 2],
    /// Entries 11, 12 and 22 of Θ′.
    t: [f64; 3],
    determinant: Double,
}

/// The form `aᵀGa` of a generating function, `G = D′ G″ D′` with the larger diagonal entry of G″ in ¼..1.
struct Quadratic {
    g: [Double; 3],
    /// `√|G″|`.
    root_determinant: f64,
    /// `u = D′ u″` divides by these powers of two …
    step: i32,
    /// … and each order along an axis multiplies by these.
    per_order: [i32; 2],
}

impl Quadratic {
    fn exponent(&self, n: usize, m: usize) -> i32 {
        // orders are at most 256 and exponents at most a few thousand
        self.per_order[0] * n as i32 + self.per_order[1] * m as i32
    }
}

impl UnitTheta {
    fn new(n: usize, m: usize, theta: &Matrix2<f64>) -> Result<Self, ShapeError> {
        if let Some(order) = [n, m].into_iter().find(|order| *order > MAX_ORDER) {
            return Err(ShapeError::Order { order });
        }
        let theta = positive_definite(theta, "shape matrix Θ")?;
        let axes = [theta.m11, theta.m22].map(|entry| libm::ilogb(entry).div_euclid(2));
        let t = [
            libm::scalbn(theta.m11, -2 * axes[0]),
            libm::scalbn(theta.m12, -axes[0] - axes[1]),
            libm::scalbn(theta.m22, -2 * axes[1]),
        ];
        Ok(Self {
            axes,
            t,
            determinant: Double::product(t[0], t[2]) - Double::product(t[1], t[1]),
        })
    }

    /// `Θ′ v`.
    fn times(&self, v: [Double; 2]) -> [Double; 2] {
        let [t11, t12, t22] = self.t.map(Double::from);
        [t11 * v[0] + t12 * v[1], t12 * v[0] + t22 * v[1]]
    }

    /// `Θ′⁻¹ v`.
    fn inverse_times(&self, v: [Double; 2]) -> [Double; 2] {
        let [t11, t12, t22] = self.t.map(Double::from);
        [
            (t22 * v[0] - t12 * v[1]) / self.determinant,
            (t11 * v[1] - t12 * v[0]) / self.determinant,
        ]
    }

    /// `|Θ|^(1/4)` or, with sign −1, `|Θ|^(−1/4)`.
    fn fourth_root(&self, sign: i32) -> Scaled {
        let root = self.determinant.head.sqrt().sqrt();
        let halves = sign * (self.axes[0] + self.axes[1]);
        let odd = if halves % 2 == 0 { 1.0 } else { SQRT_2 };
        Scaled {
            mantissa: odd * if sign > 0 { root } else { 1.0 / root },
            exponent: halves.div_euclid(2),
        }
    }

    /// `G = Θ⁻¹` for the covariant family, `G = Θ` for the dual.
    fn quadratic(&self, family: Family) -> Quadratic {
        let [t11, t12, t22] = self.t.map(Double::from);
        let (det, root) = (self.determinant, self.determinant.head.sqrt());
        let (g, root, sign) = match family {
            Family::Covariant => ([t22 / det, -t12 / det, t11 / det], 1.0 / root, -1),
            Family::Dual => ([t11, t12, t22], root, 1),
        };
        let step = libm::ilogb(g[0].head.max(g[2].head)).div_euclid(2) + 1;
        Quadratic {
            g: g.map(|entry| entry.scaled(-2 * step)),
            root_determinant: libm::scalbn(root, -2 * step),
            step,
            per_order: self.axes.map(|axis| step + sign * axis),
        }
    }

    /// `norm/√π · e^(−square/2)` times the polynomial of `u` and the quadratic form.
    fn value(
        &self,
        quadratic: Quadratic,
        n: usize,
        m: usize,
        u: [Double; 2],
        square: Double,
        norm: Scaled,
    ) -> f64 {
        let Some(gaussian) = scaled_exponential(0.5 * square.head, 0.5 * square.tail) else {
            return 0.0;
        };
        let u = u.map(|entry| entry.scaled(-quadratic.step));
        let polynomial = polynomial(n, m, u, quadratic.g);
        let exponent = quadratic.exponent(n, m) + norm.exponent + gaussian.exponent;
        scalbn(
            norm.mantissa * FRAC_2_SQRT_PI / 2.0 * gaussian.mantissa * polynomial.mantissa,
            i64::from(exponent) + i64::from(polynomial.exponent),
        )
    }
}

/// `√(n! m!)/2^((n+m)/2)` times the coefficient of a₁ⁿa₂ᵐ in `e^(2a·u − aᵀGa)`.
fn polynomial(n: usize, m: usize, u: [Double; 2], [g11, g12, g22]: [Double; 3]) -> Scaled {
    const STEP: i32 = 400;
    let limit = libm::scalbn(1.0, STEP);
    let roots: Vec<Double> = (0..=n.max(m)).map(|i| Double::root(i as f64)).collect();
    let [v1, v2] = u.map(|entry| entry * Double::root(2.0));
    // one column holds g_ab for all b; the first one follows from b alone
    let (mut before, mut now) = (vec![Double::ZERO; m + 1], vec![Double::ZERO; m + 1]);
    let mut exponent = 0;
    now[0] = Double::from(1.0);
    for b in 0..m {
        let down = if b > 0 {
            g22 * roots[b] * now[b - 1]
        } else {
            Double::ZERO
        };
        now[b + 1] = (v2 * now[b] - down) / roots[b + 1];
        if now[b + 1].head.abs() > limit {
            now.iter_mut()
                .for_each(|entry| *entry = entry.scaled(-STEP));
            exponent += STEP;
        }
    }
    for a in 0..n {
        let mut largest = 0.0f64;
        // from the far end, so that `before` can be overwritten: g_{a+1,b} needs column a at b and b − 1 only
        for b in (0..=m).rev() {
            let across = if b > 0 {
                g12 * roots[b] * now[b - 1]
            } else {
                Double::ZERO
            };
            before[b] = (v1 * now[b] - g11 * roots[a] * before[b] - across) / roots[a + 1];
            largest = largest.max(before[b].head.abs());
        }
        std::mem::swap(&mut before, &mut now);
        if largest > limit {
            for entry in now.iter_mut().chain(&mut before) {
                *entry = entry.scaled(-STEP);
            }
            exponent += STEP;
        }
    }
    Scaled {
        mantissa: now[m].head,
        exponent,
    }
}

/// Pascal's triangle down to row `last`.
fn binomials(last: usize) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![1.0]];
    for n in 0..last {
        let above = &rows[n];
        let row = (0..=n + 1)
            .map(|k| {
                let left = if k > 0 { above[k - 1] } else { 0.0 };
                left + above.get(k).copied().unwrap_or(0.0)
            })
            .collect();
        rows.push(row);
    }
    rows
}

/// The point times `2^exponents`, `None` so far out that every mode is 0.
fn scaled_point(x: &Vector2<f64>, exponents: [i32; 2]) -> Option<[Double; 2]> {
    let scaled = [
        libm::scalbn(x.x, exponents[0]),
        libm::scalbn(x.y, exponents[1]),
    ];
    // the Gaussian is below e^(−1e183) there, beyond any power of a unit
    scaled
        .iter()
        .all(|entry| entry.abs() < 1e100)
        .then(|| scaled.map(Double::from))
}

fn scalbn(mantissa: f64, exponent: i64) -> f64 {
    // beyond ±5000 every mantissa here is infinite or 0
    libm::scalbn(mantissa, exponent.clamp(-5000, 5000) as i32)
}
