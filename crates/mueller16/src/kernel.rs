//! The angular integral of the theorem for one Gaussian of R: a two-term recurrence over the incident modes.
//!
//! With `V` the root of the incident light over the tangent plane, `S = DᵀD/m` the covariance of the Gaussian and `φ` the
//! tangential wave vector from the centre of its lobe,
//!
//! ```text
//! F{e^(−xᵀS⁻¹x/2) h_a h_b(Vx)}(φ) = (−i)^(a+b) g_ab
//! g_00      = 2√π √|K| e^(−φᵀKφ/2)                               K = (S⁻¹ + VᵀV)⁻¹                        (T6.2)
//! g_(a+1,b) = [√2 z₁ g_ab + M₁₁ √a g_(a−1,b) + M₁₂ √b g_(a,b−1)]/√(a+1)      z = V K φ,  M = 1 − 2 V K Vᵀ   (T6.3)
//! ```
//!
//! A series `Σ c_ab φ_ab` with the real coefficients `s_ab = (−i)^(a+b) c_ab` gives `Σ s_ab g_ab`: everything is real.
//!
//! No matrix is inverted. In coordinates where S is `1/m`, `A = V Dᵀ`, and
//!
//! ```text
//! Δ = m² + m ‖A‖² + δ²                 δ = det V det D
//! √|K|   = |det D|/√Δ                  φᵀKφ = (m |Dφ|² + |c|²)/Δ          c = det D adj(V)ᵀφ
//! V K φ  = (m A Dφ + δ c)/Δ            M = [(m² − δ² + m ‖A‖²) 1 − 2 m A Aᵀ]/Δ
//! ```
//!
//! All sums but that of M are of one sign, so that a thin lobe, a thin light and their limits (`V = 0`: a plane wave; `m = 0`:
//! the image of the source) keep their digits without a case of their own.

use nalgebra::{Matrix2, Vector2};
use std::f64::consts::FRAC_1_SQRT_2;
use stokes::{HermiteSeries, Real, plane};

use crate::autocorrelation::GaussianFamily;

/// What the Gaussians of a family share when they meet light of one root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting<'a> {
    family: &'a GaussianFamily,
    root: &'a Matrix2<f64>,
    /// `A = V Dᵀ`, its rows' squares and their product.
    a: Matrix2<f64>,
    squares: [f64; 2],
    across: f64,
    delta: f64,
}

/// One Gaussian met by light: the start and the factors of the recurrence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GaussianLobe {
    /// `g_00` times the weight, m².
    pub(crate) start: f64,
    /// `z = V K φ`.
    pub(crate) z: [f64; 2],
    /// `M₁₁, M₁₂, M₂₂`.
    pub(crate) m: [f64; 3],
}

impl<'a> Meeting<'a> {
    pub(crate) fn new(
        family: &'a GaussianFamily,
        root: &'a Matrix2<f64>,
        root_determinant: f64,
    ) -> Self {
        let a = plane::product(root, &family.root().transpose());
        Self {
            family,
            root,
            a,
            squares: [a.m11 * a.m11 + a.m12 * a.m12, a.m21 * a.m21 + a.m22 * a.m22],
            across: plane::sum_of_products(a.m11, a.m21, a.m12, a.m22),
            delta: root_determinant * family.root_determinant(),
        }
    }

    /// The lobes of all Gaussians at the tangential wave vector `phi`, rad/m; `None` for a delta, which no light
    /// without width averages.
    pub(crate) fn lobes(
        &self,
        phi: &Vector2<f64>,
    ) -> impl Iterator<Item = Option<GaussianLobe>> + '_ {
        let phi = *phi;
        self.family.terms().iter().map(move |term| {
            // a shift of 0 leaves every bit as it is
            let at = phi - term.shift;
            self.lobe(term.weight, term.rate, &at)
        })
    }

    #[inline]
    fn lobe(&self, weight: f64, m: f64, phi: &Vector2<f64>) -> Option<GaussianLobe> {
        let [r1, r2] = self.squares;
        let det_d = self.family.root_determinant();
        let det = m * m + m * (r1 + r2) + self.delta * self.delta;
        if det == 0.0 {
            return None;
        }
        let d = plane::apply(self.family.root(), phi);
        let v = self.root;
        let c = Vector2::new(
            plane::sum_of_products(v.m22, phi.x, -v.m21, phi.y),
            plane::sum_of_products(v.m11, phi.y, -v.m12, phi.x),
        ) * det_d;
        let inverse = 1.0 / det;
        let exponent = 0.5 * (m * d.norm_squared() + c.norm_squared()) * inverse;
        let along = plane::apply(&self.a, &d);
        // (m² − δ²) as a product: exact where the two are close
        let even = (m - self.delta) * (m + self.delta);
        Some(GaussianLobe {
            start: weight * 2.0 * PI_ROOT * det_d.abs() * (-exponent).exp() * inverse.sqrt(),
            z: [
                (m * along.x + self.delta * c.x) * inverse,
                (m * along.y + self.delta * c.y) * inverse,
            ],
            m: [
                (even + m * (r2 - r1)) * inverse,
                -2.0 * m * self.across * inverse,
                (even + m * (r1 - r2)) * inverse,
            ],
        })
    }
}

const PI_ROOT: f64 = 1.772_453_850_905_516;

/// `√0 … √256`.
static ROOTS: [f64; stokes::MAX_ORDER + 1] = {
    let (mut roots, mut n) = ([0.0; stokes::MAX_ORDER + 1], 0);
    while n < roots.len() {
        roots[n] = ((n as u128) << 118).isqrt() as f64 / (1_u64 << 59) as f64;
        n += 1;
    }
    roots
};

/// `Σ s_ab g_ab` for each series; 0 for one that is absent.
///
/// Error at most a few `order·ε` of `|s| · F{R}(0)`: the recurrence is bounded, `|g_ab| ≤ π^(−1/2) F{R}(0)`. No
/// allocation. What is absent or shorter changes no bit of the other sums.
#[inline]
pub(crate) fn contract<const J: usize>(
    lobe: &GaussianLobe,
    series: [Option<&HermiteSeries>; J],
) -> [f64; J] {
    let count = |s: &HermiteSeries| s.order() + 1;
    let counts = series.map(|s| s.map_or(0, count));
    let coefficients = series.map(|s| s.map_or(&[][..], HermiteSeries::real_coefficients));
    match counts.iter().max().copied().unwrap_or(0) {
        0 | 1 => coefficients.map(|s| s.first().map_or(0.0, |s| s * lobe.start)),
        2..=5 => sized::<J, 5>(lobe, coefficients, counts),
        6..=17 => sized::<J, 17>(lobe, coefficients, counts),
        18..=65 => sized::<J, 65>(lobe, coefficients, counts),
        _ => sized::<J, { stokes::MAX_ORDER + 1 }>(lobe, coefficients, counts),
    }
}

/// As [`contract`], for series of `counts` orders with at most `SIZE` of them.
#[inline]
fn sized<const J: usize, const SIZE: usize>(
    lobe: &GaussianLobe,
    series: [&[f64]; J],
    counts: [usize; J],
) -> [f64; J] {
    let steps = f64::steps();
    let count = counts.into_iter().max().unwrap_or(0).min(SIZE);
    let [z1, z2] = lobe.z;
    let [m11, m12, m22] = lobe.m;
    // row b = 0, and the row before it, which is nothing
    let (mut row, mut before) = ([0.0; SIZE], [0.0; SIZE]);
    row[0] = lobe.start;
    let mut last = 0.0;
    for a in 1..count {
        let [up, down] = steps[a - 1];
        row[a] = up * z1 * row[a - 1] + m11 * down * last;
        last = row[a - 1];
    }
    let mut sums = [0.0; J];
    for b in 0..count {
        for (sum, (s, length)) in sums.iter_mut().zip(series.iter().zip(counts)) {
            let mut place = stokes::mode_index(0, b);
            for (a, g) in row[..length.saturating_sub(b)].iter().enumerate() {
                *sum += s[place] * g;
                place += a + b + 1;
            }
        }
        if b + 1 == count {
            break;
        }
        let [up, down] = steps[b];
        let (along, back, across) = (up * z2, m22 * down, m12 * up * FRAC_1_SQRT_2);
        let mut left = 0.0;
        for a in 0..count - b - 1 {
            before[a] = along * row[a] + back * before[a] + across * ROOTS[a] * left;
            left = row[a];
        }
        std::mem::swap(&mut row, &mut before);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autocorrelation::GaussianTerm;
    use num_complex::Complex64;

    /// `∫ e^(−xᵀS⁻¹x/2) h_a h_b(Vx) e^(−iφ·x) d²x` by the trapezoidal rule.
    fn quadrature(
        s: &Matrix2<f64>,
        v: &Matrix2<f64>,
        phi: &Vector2<f64>,
        [a, b]: [usize; 2],
    ) -> Complex64 {
        let (half, step) = (240_i32, 0.05);
        let inverse = plane::inverse(s);
        let mut sum = Complex64::ZERO;
        for i in -half..=half {
            for j in -half..=half {
                let x = Vector2::new(f64::from(i), f64::from(j)) * step;
                let y = v * x;
                let f = (-0.5 * x.dot(&(inverse * x))).exp()
                    * stokes::hermite(a, y.x)
                    * stokes::hermite(b, y.y);
                sum += Complex64::cis(-phi.dot(&x)) * f;
            }
        }
        sum * step * step
    }

    #[test]
    fn modes_are_the_fourier_integral() {
        let root = Matrix2::new(1.1, -0.3, 0.4, 0.8);
        let v = Matrix2::new(0.7, 0.2, -0.5, 0.9);
        let phi = Vector2::new(1.3, -0.6);
        let term = GaussianTerm {
            weight: 1.0,
            rate: 1.7,
            shift: Vector2::new(0.4, 0.3),
        };
        let family = GaussianFamily::new(&root, [term]).unwrap();
        let meeting = Meeting::new(&family, &v, plane::determinant(&v));
        let lobe = meeting.lobes(&phi).next().unwrap().unwrap();
        let s = root.transpose() * root / 1.7;
        for [a, b] in [
            [0, 0],
            [1, 0],
            [0, 1],
            [2, 0],
            [1, 1],
            [3, 2],
            [0, 5],
            [4, 3],
        ] {
            let mut series = vec![0.0; stokes::mode_count(a + b)];
            series[stokes::mode_index(a, b)] = 1.0;
            let series = HermiteSeries::from_real_coefficients(&series).unwrap();
            let [g] = contract(&lobe, [Some(&series)]);
            let expected = quadrature(&s, &v, &(phi - term.shift), [a, b]);
            let found = Complex64::new(0.0, -1.0).powu((a + b) as u32) * g;
            // the trapezoidal rule is exact for a Gaussian to e^(−π²/(h² K⁻¹)); 231,361 roundings of numbers ≤ 0.6
            assert!(
                (found - expected).norm() < 1e-13,
                "{a} {b}: {found} {expected}"
            );
        }
    }

    #[test]
    fn several_series_are_contracted_as_one_by_one() {
        let root = Matrix2::new(1.1, -0.3, 0.4, 0.8);
        let v = Matrix2::new(0.7, 0.2, -0.5, 0.9);
        let family = GaussianFamily::new(&root, [GaussianTerm::centred(0.7, 1.3)]).unwrap();
        let meeting = Meeting::new(&family, &v, plane::determinant(&v));
        let lobe = meeting
            .lobes(&Vector2::new(0.4, 2.0))
            .next()
            .unwrap()
            .unwrap();
        for order in [1, 4, 5, 16, 17, 64, 65, 256] {
            let long: Vec<_> = (0..stokes::mode_count(order))
                .map(|i| (i as f64).sin())
                .collect();
            let long = HermiteSeries::from_real_coefficients(&long).unwrap();
            let (short, _) = long.truncated(order / 2);
            let [x, y, z] = contract(&lobe, [Some(&long), None, Some(&short)]);
            assert_eq!(([x], y), (contract(&lobe, [Some(&long)]), 0.0));
            assert_eq!([z], contract(&lobe, [Some(&short)]));
        }
    }
}
