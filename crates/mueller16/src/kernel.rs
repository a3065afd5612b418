//! The angular integral of the theorem for one Gaussian of R: a two-term recurrence over the incident modes.
//!
//! With `V` the root of the incident light over the tangent plane, `S = DᵀD/m` the covariance of the Gaussian and `φ` the
//! tangential wave vector from the centre of its lobe,
//!
//! ```text
//! F{e^(−xᵀS⁻¹x/2) h_a h_b(Vx)}(φ) = (−i)^(a+b) g_ab
//! g_00      = 2√π √|K| e^(−φᵀKφ/2)                               K = (S⁻¹ + VᵀV)⁻¹
//! g_(a+1,b) = [√2 z₁ g_ab + M₁₁ √a g_(a−1,b) + M₁₂ √b g_(a,b−1)]/√(a+1)      z = V K φ,  M = 1 − 2 V K Vᵀ
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
use stokes::{HermiteSeries, Real, plane};

use crate::accuracy::Tolerance;
use crate::autocorrelation::{GaussianFamily, GaussianTerm};
use crate::recurrence::{Lobes, Modes};

/// Gaussians that are met side by side.
pub(crate) const LANES: usize = 4;

/// `√π`
const PI_ROOT: f64 = 1.772_453_850_905_516;

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

    /// The integrals of Gaussians that are alone in their families, one of each.
    #[inline(always)]
    pub(crate) fn side_by_side<T: Real, const L: usize>(
        meetings: &[Self; L],
        phi: &Vector2<f64>,
        request: &Request<'_, 1>,
    ) -> Option<[f64; L]> {
        let order = request.modes.order();
        if order == 0 {
            Self::singles::<T, L, false>(meetings, phi, request)
        } else if order > MAX_ORDER_F32 {
            Self::singles::<f64, L, true>(meetings, phi, request)
        } else {
            Self::singles::<T, L, true>(meetings, phi, request)
        }
    }

    #[inline(always)]
    fn singles<T: Real, const L: usize, const MODES: bool>(
        meetings: &[Self; L],
        phi: &Vector2<f64>,
        request: &Request<'_, 1>,
    ) -> Option<[f64; L]> {
        let mut terms = [GaussianTerm::centred(0.0, 1.0); L];
        for (term, meeting) in terms.iter_mut().zip(meetings) {
            *term = *meeting.family.terms().first()?;
        }
        let places = std::array::from_fn(|l| meetings[l].place::<MODES>(&(phi - terms[l].shift)));
        let [found] = Self::block::<T, L, 1, MODES>(meetings.each_ref(), &terms, &places, request)?;
        Some(found)
    }

    #[inline(always)]
    fn add_all<T: Real, const J: usize, const MODES: bool>(
        &self,
        phi: &Vector2<f64>,
        request: &Request<'_, J>,
        sums: &mut [f64; J],
    ) -> Option<()> {
        let terms = self.family.terms();
        if let [term] = terms {
            let place = self.place::<MODES>(&(phi - term.shift));
            return self.add_block::<T, 1, J, MODES>(&[*term], &[place], request, sums);
        }
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
        let found = Self::block::<T, L, J, MODES>([self; L], terms, places, request)?;
        for (sum, found) in sums.iter_mut().zip(found) {
            for found in found {
                *sum += found;
            }
        }
        Some(())
    }

    /// The integrals of each series over Gaussians that need not share a family.
    #[inline(always)]
    fn block<T: Real, const L: usize, const J: usize, const MODES: bool>(
        meetings: [&Self; L],
        terms: &[GaussianTerm; L],
        places: &[Place; L],
        request: &Request<'_, J>,
    ) -> Option<[[f64; L]; J]> {
        let (lobes, scale) = Self::lobes::<T, L, MODES>(meetings, terms, places, request.reach)?;
        if scale == [0.0; L] {
            return Some([[0.0; L]; J]);
        }
        let found = if !MODES {
            request.modes.fundamental(&lobes)
        } else if meetings.iter().all(|meeting| meeting.across == 0.0) {
            request.modes.contract::<T, L, false>(&lobes)
        } else {
            request.modes.contract::<T, L, true>(&lobes)
        };
        Some(found.map(|found| std::array::from_fn(|l| found[l].to_f64() * scale[l])))
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
        meetings: [&Self; L],
        terms: &[GaussianTerm; L],
        places: &[Place; L],
        reach: f64,
    ) -> Option<(Lobes<T, L>, [f64; L])> {
        let r1 = meetings.map(|meeting| meeting.squares[0]);
        let r2 = meetings.map(|meeting| meeting.squares[1]);
        let delta = meetings.map(|meeting| meeting.delta);
        let det_d = meetings.map(|meeting| meeting.family.root_determinant().abs());
        // e^(x/2) leaves room before the largest number, and x/2 is one that `Real::decay` takes
        let reach = reach.min(0.9 * T::NEAR.to_f64() * T::NEAR.to_f64());
        // step by step over all lanes, by which each step becomes vector code
        let rate: [f64; L] = std::array::from_fn(|l| terms[l].rate);
        let det: [f64; L] = std::array::from_fn(|l| {
            let (m, delta) = (rate[l], delta[l]);
            m * m + m * (r1[l] + r2[l]) + delta * delta
        });
        let inverse = det.map(|det| 1.0 / det);
        let x: [f64; L] = std::array::from_fn(|l| {
            0.5 * (rate[l] * places[l].d_squared + places[l].c_squared) * inverse[l]
        });
        // not a number counts as far
        let near = x.map(|x| x <= reach);
        let start: [T; L] =
            std::array::from_fn(|l| T::from_f64(if near[l] { 0.5 * x[l] } else { 0.0 }).decay());
        let height: [f64; L] =
            std::array::from_fn(|l| 2.0 * PI_ROOT * det_d[l] * inverse[l].sqrt());
        let scale: [f64; L] = std::array::from_fn(|l| {
            let factor = terms[l].weight * height[l] * start[l].to_f64();
            if near[l] { factor } else { 0.0 }
        });
        let mut lobes = Lobes {
            start,
            ..Lobes::<T, L>::default()
        };
        if MODES {
            for axis in 0..2 {
                let z: [f64; L] = std::array::from_fn(|l| {
                    let Place { along, c, .. } = places[l];
                    let z = (rate[l] * along[axis] + delta[l] * c[axis]) * inverse[l];
                    if near[l] { z } else { 0.0 }
                });
                lobes.z[axis] = z.map(T::from_f64);
            }
            // (m² − δ²) as a product: exact where the two are close
            for l in 0..L {
                let (m, delta) = (rate[l], delta[l]);
                let (even, skew) = ((m - delta) * (m + delta), m * (r2[l] - r1[l]));
                lobes.m[0][l] = T::from_f64((even + skew) * inverse[l]);
                lobes.m[1][l] = T::from_f64(-2.0 * m * meetings[l].across * inverse[l]);
                lobes.m[2][l] = T::from_f64((even - skew) * inverse[l]);
            }
        }
        let least = det.into_iter().fold(f64::INFINITY, f64::min);
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
    let (mut sums, mut cancels) = ([0.0; N], [false; N]);
    for i in 0..N {
        let (first, second) = (a[i] * b[i], c[i] * d[i]);
        sums[i] = first + second;
        let most = if first.abs() > second.abs() {
            first.abs()
        } else {
            second.abs()
        };
        cancels[i] = sums[i].abs() < 0.25 * most;
    }
    for i in 0..N {
        if cancels[i] {
            sums[i] = cancelling(a[i], b[i], c[i], d[i]);
        }
    }
    sums
}

#[cold]
#[inline(never)]
fn cancelling(a: f64, b: f64, c: f64, d: f64) -> f64 {
    plane::sum_of_products(a, b, c, d)
}

#[cfg(test)]
mod tests;
