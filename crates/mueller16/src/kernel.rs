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
use std::f64::consts::TAU;
use stokes::{HermiteSeries, Real, plane};

use crate::accuracy::Tolerance;
use crate::autocorrelation::{GaussianFamily, GaussianTerm};
use crate::recurrence::{Lobes, Modes};

/// Gaussians that are met side by side.
const LANES: usize = 4;

/// Least Δ: below, its root has no digits, and its Gaussian is a delta.
const LEAST_DELTA: f64 = 1e-280;

/// Highest order of the recurrence in f32; beyond it f64 steps in.
const MAX_ORDER_F32: usize = 64;

/// What is made of a family of Gaussians: which modes are summed, and how far from a lobe they are still there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Request<'a, const J: usize> {
    modes: Modes<'a, J>,
    /// Largest `φᵀKφ/2`.
    reach: f64,
}

impl<'a, const J: usize> Request<'a, J> {
    /// These series, with everything that the arithmetic can hold, or with Gaussians left out for a tolerance.
    ///
    /// By Cauchy's bound on the generating function, `|g_ab| ≤ g_00(0) e √n e^(n − (√x − √n)²)` at `x = φᵀKφ/2 ≥ n`:
    /// what is left out is below the tolerance times `g_00(0) Σ|s_ab|`.
    pub(crate) fn new(
        series: [Option<&'a HermiteSeries>; J],
        tolerance: Option<Tolerance>,
    ) -> Self {
        let modes = Modes::new(series);
        let reach = tolerance.map_or(f64::INFINITY, |tolerance| {
            let n = modes.order() as f64;
            let digits = 1.0 + 0.5 * n.max(1.0).ln() - tolerance.get().ln();
            (n.sqrt() + (n + digits).sqrt()).powi(2)
        });
        Self { modes, reach }
    }
}

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

/// What Gaussians with one centre share: `|Dφ|²`, `|c|²`, `A Dφ` and c.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    d_squared: f64,
    c_squared: f64,
    along: [f64; 2],
    c: [f64; 2],
}

impl<'a> Meeting<'a> {
    #[inline(always)]
    pub(crate) fn new(
        family: &'a GaussianFamily,
        root: &'a Matrix2<f64>,
        root_determinant: f64,
    ) -> Self {
        let (d, v) = (family.root(), root);
        let [a11, a21, a12, a22] = sums_of_products(
            [v.m11, v.m21, v.m11, v.m21],
            [d.m11, d.m11, d.m21, d.m21],
            [v.m12, v.m22, v.m12, v.m22],
            [d.m12, d.m12, d.m22, d.m22],
        );
        let squares = [a11 * a11 + a12 * a12, a21 * a21 + a22 * a22];
        let [across] = sums_of_products([a11], [a21], [a12], [a22]);
        // axes that are turned by rounding alone are not turned
        let turned = across.abs() > f64::EPSILON * squares[0].max(squares[1]);
        Self {
            family,
            root,
            a: Matrix2::new(a11, a12, a21, a22),
            squares,
            across: if turned { across } else { 0.0 },
            delta: root_determinant * family.root_determinant(),
        }
    }

    /// Adds the integrals of all Gaussians at the tangential wave vector `phi`, rad/m, to `sums`, m²; `None` for a
    /// delta, which no light without width averages.
    ///
    /// Exponents and factors are formed in f64, the recurrence runs in T.
    #[inline(always)]
    pub(crate) fn add<T: Real, const J: usize>(
        &self,
        phi: &Vector2<f64>,
        request: &Request<'_, J>,
        sums: &mut [f64; J],
    ) -> Option<()> {
        let order = request.modes.order();
        if order == 0 {
            self.add_all::<T, J, false>(phi, request, sums)
        } else if order > MAX_ORDER_F32 {
            self.add_all::<f64, J, true>(phi, request, sums)
        } else {
            self.add_all::<T, J, true>(phi, request, sums)
        }
    }

    #[inline(always)]
    fn add_all<T: Real, const J: usize, const MODES: bool>(
        &self,
        phi: &Vector2<f64>,
        request: &Request<'_, J>,
        sums: &mut [f64; J],
    ) -> Option<()> {
        let terms = self.family.terms();
        let mut shift = Vector2::zeros();
        let mut place = self.place::<MODES>(phi);
        // many Gaussians have one centre
        let mut place_of = |term: &GaussianTerm| {
            if term.shift != shift {
                shift = term.shift;
                place = self.place::<MODES>(&(phi - shift));
            }
            place
        };
        let (blocks, rest) = terms.as_chunks::<LANES>();
        for block in blocks {
            let places = block.each_ref().map(&mut place_of);
            self.add_block::<T, LANES, J, MODES>(block, &places, request, sums)?;
        }
        for term in rest {
            let place = place_of(term);
            self.add_block::<T, 1, J, MODES>(&[*term], &[place], request, sums)?;
        }
        Some(())
    }

    #[inline(always)]
    fn add_block<T: Real, const L: usize, const J: usize, const MODES: bool>(
        &self,
        terms: &[GaussianTerm; L],
        places: &[Place; L],
        request: &Request<'_, J>,
        sums: &mut [f64; J],
    ) -> Option<()> {
        let (lobes, scale) = self.lobes::<T, L, MODES>(terms, places, request.reach)?;
        if scale == [0.0; L] {
            return Some(());
        }
        let found = if !MODES {
            request.modes.fundamental(&lobes)
        } else if self.across == 0.0 {
            request.modes.contract::<T, L, false>(&lobes)
        } else {
            request.modes.contract::<T, L, true>(&lobes)
        };
        for (sum, found) in sums.iter_mut().zip(found) {
            for (found, scale) in found.into_iter().zip(scale) {
                *sum += found.to_f64() * scale;
            }
        }
        Some(())
    }

    #[inline(always)]
    fn place<const MODES: bool>(&self, phi: &Vector2<f64>) -> Place {
        let (d, v, a) = (self.family.root(), self.root, &self.a);
        let det_d = self.family.root_determinant();
        let [d1, d2, c1, c2] = sums_of_products(
            [d.m11, d.m21, v.m22, v.m11],
            [phi.x, phi.x, phi.x, phi.y],
            [d.m12, d.m22, -v.m21, -v.m12],
            [phi.y, phi.y, phi.y, phi.x],
        );
        let (c1, c2) = (c1 * det_d, c2 * det_d);
        let along = if MODES {
            sums_of_products([a.m11, a.m21], [d1; 2], [a.m12, a.m22], [d2; 2])
        } else {
            [0.0; 2]
        };
        Place {
            d_squared: d1 * d1 + d2 * d2,
            c_squared: c1 * c1 + c2 * c2,
            along,
            c: [c1, c2],
        }
    }

    /// Gaussians side by side, each begun with `e^(−x/2)`, `x = φᵀKφ/2`, and the factors of what is made of them,
    /// which hold the other half: neither underflows, and `e^(x/2)`, by which the recurrence grows at most, is a
    /// number. What lies beyond reach has the factor 0.
    #[inline(always)]
    fn lobes<T: Real, const L: usize, const MODES: bool>(
        &self,
        terms: &[GaussianTerm; L],
        places: &[Place; L],
        reach: f64,
    ) -> Option<(Lobes<T, L>, [f64; L])> {
        let [r1, r2] = self.squares;
        let delta = self.delta;
        let det_d = self.family.root_determinant().abs();
        // e^(x/2) leaves nine digits before the largest number, and √x is one that `Real::gaussian` takes
        let near = 0.9 * T::NEAR.to_f64().powi(2);
        let reach = near.min(reach);
        let mut lobes = Lobes::<T, L>::default();
        let mut scale = [0.0; L];
        let mut least = f64::INFINITY;
        for l in 0..L {
            let (m, place) = (terms[l].rate, &places[l]);
            let det = m * m + m * (r1 + r2) + delta * delta;
            least = least.min(det);
            let inverse = 1.0 / det;
            let x = 0.5 * (m * place.d_squared + place.c_squared) * inverse;
            // not a number counts as far
            let is_near = x <= reach;
            let x = if is_near { x } else { 0.0 };
            let start = T::from_f64(x.sqrt()).gaussian();
            let factor = terms[l].weight * TAU * det_d * inverse.sqrt() * start.to_f64();
            scale[l] = if is_near { factor } else { 0.0 };
            lobes.start[l] = start;
            if MODES {
                let inverse = if is_near { inverse } else { 0.0 };
                // (m² − δ²) as a product: exact where the two are close
                let even = (m - delta) * (m + delta);
                for axis in 0..2 {
                    let z = (m * place.along[axis] + delta * place.c[axis]) * inverse;
                    lobes.z[axis][l] = T::from_f64(if is_near { z } else { 0.0 });
                }
                lobes.m[0][l] = T::from_f64((even + m * (r2 - r1)) * inverse);
                lobes.m[1][l] = T::from_f64(-2.0 * m * self.across * inverse);
                lobes.m[2][l] = T::from_f64((even + m * (r1 - r2)) * inverse);
            }
        }
        (least >= LEAST_DELTA).then_some((lobes, scale))
    }
}

/// `a·b + c·d` entry by entry, each right to `4.5 ε`: where no entry cancels the plain sums are, elsewhere
/// [`plane::sum_of_products`].
#[inline(always)]
fn sums_of_products<const N: usize>(
    a: [f64; N],
    b: [f64; N],
    c: [f64; N],
    d: [f64; N],
) -> [f64; N] {
    let (mut sums, mut cancels) = ([0.0; N], false);
    for i in 0..N {
        let (first, second) = (a[i] * b[i], c[i] * d[i]);
        sums[i] = first + second;
        let most = if first.abs() > second.abs() {
            first.abs()
        } else {
            second.abs()
        };
        cancels |= sums[i].abs() < 0.25 * most;
    }
    if cancels {
        cancelling(&a, &b, &c, &d, &mut sums);
    }
    sums
}

#[cold]
#[inline(never)]
fn cancelling(a: &[f64], b: &[f64], c: &[f64], d: &[f64], sums: &mut [f64]) {
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = plane::sum_of_products(a[i], b[i], c[i], d[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

    const ROOT: Matrix2<f64> = Matrix2::new(1.1, 0.4, -0.3, 0.8);
    const LIGHT: Matrix2<f64> = Matrix2::new(0.7, -0.5, 0.2, 0.9);

    fn sum_in<T: Real>(
        family: &GaussianFamily,
        v: &Matrix2<f64>,
        phi: &Vector2<f64>,
        series: &HermiteSeries,
        tolerance: Option<Tolerance>,
    ) -> f64 {
        let request = Request::new([Some(series)], tolerance);
        let mut sums = [0.0];
        let meeting = Meeting::new(family, v, plane::determinant(v));
        meeting.add::<T, 1>(phi, &request, &mut sums).unwrap();
        sums[0]
    }

    fn ramp(order: usize) -> HermiteSeries {
        let s: Vec<_> = (0..stokes::mode_count(order))
            .map(|i| (i as f64 + 0.3).sin())
            .collect();
        HermiteSeries::from_real_coefficients(&s).unwrap()
    }

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
        let phi = Vector2::new(1.3, -0.6);
        let term = GaussianTerm {
            weight: 1.0,
            rate: 1.7,
            shift: Vector2::new(0.4, 0.3),
        };
        // and with axes of light and matter along each other
        let apart = (
            Matrix2::new(1.1, 0.0, 0.0, 0.6),
            Matrix2::new(0.7, 0.0, 0.0, -0.9),
        );
        for (root, v) in [(ROOT, LIGHT), apart] {
            let family = GaussianFamily::new(&root, [term]).unwrap();
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
                let g = sum_in::<f64>(&family, &v, &phi, &series, None);
                let expected = quadrature(&s, &v, &(phi - term.shift), [a, b]);
                let found = Complex64::new(0.0, -1.0).powu((a + b) as u32) * g;
                // the trapezoidal rule is exact for a Gaussian to e^(−π²/(h² K⁻¹)); 231,361 roundings of numbers ≤ 0.6
                assert!(
                    (found - expected).norm() < 1e-13,
                    "{a} {b}: {found} {expected}"
                );
            }
        }
    }

    fn terms(count: usize) -> Vec<GaussianTerm> {
        (0..count)
            .map(|i| {
                let i = i as f64;
                GaussianTerm {
                    weight: (i + 0.5).cos(),
                    rate: 0.3 + i,
                    // some with a common centre
                    shift: Vector2::new((0.5 * i).floor(), -0.3 * (0.5 * i).floor()),
                }
            })
            .collect()
    }

    #[test]
    fn a_family_is_the_sum_of_its_gaussians_bit_by_bit() {
        let phi = Vector2::new(1.3, -0.6);
        for order in [0, 3, 20] {
            let series = ramp(order);
            for count in [1, 2, 4, 5, 11] {
                let terms = terms(count);
                let of = |terms: &[GaussianTerm]| {
                    let family = GaussianFamily::new(&ROOT, terms.iter().copied()).unwrap();
                    sum_in::<f64>(&family, &LIGHT, &phi, &series, None)
                };
                let one_by_one = terms.chunks(1).fold(0.0, |sum, term| sum + of(term));
                assert_eq!(of(&terms), one_by_one, "{order} {count}");
            }
        }
    }

    #[test]
    fn what_a_tolerance_leaves_out_is_below_it() {
        let mut left_out = 0;
        for order in [0, 1, 4, 9, 30] {
            let series = ramp(order);
            let norm: f64 = series.real_coefficients().iter().map(|s| s.abs()).sum();
            for tolerance in [1e-12, 1e-6, 1e-2] {
                for step in 0..60 {
                    let phi = Vector2::new(0.3, 0.5) * f64::from(step);
                    for v in [LIGHT, LIGHT * 30.0, LIGHT * 0.01] {
                        let family =
                            GaussianFamily::new(&ROOT, [GaussianTerm::centred(2.0, 1.7)]).unwrap();
                        let asked = Some(Tolerance::relative(tolerance).unwrap());
                        let found = sum_in::<f64>(&family, &v, &phi, &series, asked);
                        let whole = sum_in::<f64>(&family, &v, &phi, &series, None);
                        let flat = HermiteSeries::fundamental(1.0);
                        let peak = sum_in::<f64>(&family, &v, &Vector2::zeros(), &flat, None);
                        let limit = tolerance * norm * peak;
                        assert!((found - whole).abs() <= limit, "{order} {tolerance} {phi}");
                        left_out += usize::from(found == 0.0 && whole != 0.0);
                    }
                }
            }
        }
        assert!(left_out > 500, "{left_out}");
    }

    #[test]
    fn single_precision_is_good_to_2e_5_of_the_lobe() {
        for order in [0, 1, 4, 8, 16, 33, 64] {
            let series = ramp(order);
            let norm: f64 = series.real_coefficients().iter().map(|s| s.abs()).sum();
            for v in [LIGHT, LIGHT * 30.0, LIGHT * 0.03] {
                let family = GaussianFamily::new(&ROOT, terms(7)).unwrap();
                let peak: f64 = terms(7)
                    .into_iter()
                    .map(|t| {
                        let centred = GaussianTerm::centred(t.weight.abs(), t.rate);
                        let family = GaussianFamily::new(&ROOT, [centred]).unwrap();
                        let flat = HermiteSeries::fundamental(1.0);
                        sum_in::<f64>(&family, &v, &Vector2::zeros(), &flat, None)
                    })
                    .sum();
                for step in 0..40 {
                    let phi = Vector2::new(0.31, -0.47) * f64::from(step);
                    let single = sum_in::<f32>(&family, &v, &phi, &series, None);
                    let double = sum_in::<f64>(&family, &v, &phi, &series, None);
                    let error = (single - double).abs() / (peak * norm);
                    assert!(error < 2e-5, "{order} {phi}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn a_delta_is_refused_and_no_distance_makes_nonsense() {
        let family = GaussianFamily::new(&ROOT, [GaussianTerm::centred(1.0, 0.0)]).unwrap();
        let flat = HermiteSeries::fundamental(1.0);
        let request = Request::new([Some(&flat)], None);
        for v in [Matrix2::zeros(), Matrix2::new(1.0, 0.0, 0.0, 0.0)] {
            let meeting = Meeting::new(&family, &v, 0.0);
            assert_eq!(
                meeting.add::<f64, 1>(&Vector2::zeros(), &request, &mut [0.0]),
                None
            );
        }
        for far in [1e3, 1e30, 1e200, f64::MAX, f64::INFINITY] {
            for v in [LIGHT, LIGHT * 1e20] {
                let phi = Vector2::new(far, -far);
                let found = sum_in::<f64>(&family, &v, &phi, &ramp(6), None);
                assert!(found.is_finite(), "{far}");
            }
        }
    }
}
