//! Rough metal, a path a lane: the facets of `microfacet.rs`.

use std::f32::consts::{FRAC_1_PI, PI};

use super::super::microfacet::{Kind, Microfacets};
use super::super::roughconductor::RoughConductor;
use super::{Departures, Vertices, axes_s, mirrored};
use crate::lanes::{Mask, Real, V3, acos, exp, ln, sin_cos_turns};
use crate::light::Element;
use crate::light::abreast::{Abreast, Elements};

impl RoughConductor {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        let facets = Facets::of(self.facets());
        let front = lanes & at.o.z.gt(R::zero());
        let m = facets.sample(at.o, [u[1], u[2]], front);
        let i = mirrored(at.o, m);
        let (weight, density) = facets.mirrored(at.o, i, m);
        let exist = front & i.z.gt(R::zero()) & density.gt(R::zero());
        let cos = i.dot(m).min(R::one());
        let mut elements = L::diagonals(Elements::splat(Element::BLACK));
        for (to, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *to = self.metal().reflections(cos, *wave).scaled(weight);
        }
        Departures {
            exist,
            direction: i,
            density,
            continuous: exist,
            straight: R::nowhere(),
            eta: R::one(),
            answers: L::diagonal_lanes(axes_s(m, i), &elements),
        }
    }

    #[inline(always)]
    pub(super) fn answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let facets = Facets::of(self.facets());
        let lit = at.o.z.gt(R::zero()) & i.z.gt(R::zero());
        let h = (at.o + i).normalize();
        let (weight, density) = facets.mirrored(at.o, i, h);
        let cos = i.dot(h).min(R::one());
        let mut elements = L::diagonals(Elements::splat(Element::BLACK));
        for (to, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *to = self.metal().reflections(cos, *wave).scaled(weight);
        }
        (
            L::diagonal_lanes(axes_s(h, i), &elements),
            density.only(lit),
        )
    }
}

/// The statistics of facet slopes: see [`Microfacets`].
#[derive(Clone, Copy)]
struct Facets<R> {
    kind: Kind,
    alpha: [R; 2],
    visible: bool,
}

impl<R: Real> Facets<R> {
    #[inline(always)]
    fn of(facets: &Microfacets) -> Self {
        let (kind, alpha, visible) = facets.parameters();
        Self {
            kind,
            alpha: [R::splat(alpha[0]), R::splat(alpha[1])],
            visible,
        }
    }

    /// D(m).
    #[inline(always)]
    fn density(&self, m: V3<R>) -> R {
        let [u, v] = self.alpha;
        let (x, y) = (m.x / u, m.y / v);
        let area = R::splat(PI) * u * v;
        let cos2 = m.z * m.z;
        let slope2 = x * x + y * y;
        let density = match self.kind {
            Kind::Beckmann => exp(-(slope2 / cos2)) / (area * cos2 * cos2),
            Kind::Ggx => {
                let q = slope2 + cos2;
                (area * q * q).recip()
            }
        };
        density.only(m.z.gt(R::zero()))
    }

    /// 1/(α tan θ).
    #[inline(always)]
    fn slope_ratio(&self, v: V3<R>) -> R {
        let (x, y) = (v.x * self.alpha[0], v.y * self.alpha[1]);
        v.z.abs() / (x * x + y * y).sqrt()
    }

    /// G1 by Walter's fit, and the exact one that normalises visible normals.
    #[inline(always)]
    fn shadowings(&self, a: R) -> (R, R) {
        let one = R::one();
        match self.kind {
            Kind::Ggx => {
                let g = R::splat(2.0) / (one + (one + (a * a).recip()).sqrt());
                (g, g)
            }
            Kind::Beckmann => {
                let lambda = exp(-(a * a))
                    * (R::splat(0.5 / PI.sqrt()) / a - R::splat(0.5) * scaled_erfc(a));
                let exact = (one + lambda).recip();
                let exact = R::select(a.gt(R::splat(4.0)), one, exact);
                (self.fitted(a), exact)
            }
        }
    }

    /// Walter's fit, or GGX itself.
    #[inline(always)]
    fn fitted(&self, a: R) -> R {
        let one = R::one();
        match self.kind {
            Kind::Ggx => R::splat(2.0) / (one + (one + (a * a).recip()).sqrt()),
            Kind::Beckmann => {
                let a2 = a * a;
                let fit = (R::splat(3.535) * a + R::splat(2.181) * a2)
                    / (one + R::splat(2.276) * a + R::splat(2.577) * a2);
                R::select(a.ge(R::splat(1.6)), one, fit)
            }
        }
    }

    /// See [`Microfacets::mirrored`].
    #[inline(always)]
    fn mirrored(&self, o: V3<R>, i: V3<R>, h: V3<R>) -> (R, R) {
        let facets = self.density(h);
        let (seen, exact) = self.shadowings(self.slope_ratio(o));
        let lit = self.fitted(self.slope_ratio(i));
        let along = o.dot(h);
        let quarter = R::splat(0.25) / o.z;
        // facets seen from behind are hidden
        let front = (along * o.z).gt(R::zero()) & (i.dot(h) * i.z).gt(R::zero());
        let weight = (facets * lit * seen * quarter).only(front);
        let drawn = if self.visible {
            // G1 (o·m) D/(4 (o·m) |o.z|)
            (exact * facets * quarter).only(along.gt(R::zero()))
        } else {
            facets * h.z / (R::splat(4.0) * along)
        };
        (weight, drawn)
    }

    /// Draws facet normals for viewers above the surface.
    #[inline(always)]
    fn sample(&self, o: V3<R>, u: [R; 2], lanes: R::M) -> V3<R> {
        let [a, b] = self.alpha;
        let one = R::one();
        if !self.visible {
            let slope2 = match self.kind {
                Kind::Beckmann => -ln(one - u[0]),
                Kind::Ggx => u[0] / (one - u[0]),
            };
            let (sin, cos) = sin_cos_turns(u[1]);
            let slope = slope2.max(R::zero()).sqrt();
            return V3::new(a * slope * cos, b * slope * sin, one).normalize();
        }
        let stretched = V3::new(o.x * a, o.y * b, o.z).normalize();
        match self.kind {
            Kind::Ggx => {
                let z = (one - u[0]) * (one + stretched.z) - stretched.z;
                let r = (one - z * z).max(R::zero()).sqrt();
                let (sin, cos) = sin_cos_turns(u[1]);
                let h = V3::new(r * cos, r * sin, z) + stretched;
                V3::new(h.x * a, h.y * b, h.z.max(R::zero())).normalize()
            }
            Kind::Beckmann => {
                let sin = (stretched.x * stretched.x + stretched.y * stretched.y).sqrt();
                let tilted = sin.gt(R::zero());
                let cos_phi = R::select(tilted, stretched.x / sin, one);
                let sin_phi = R::select(tilted, stretched.y / sin, R::zero());
                let slope_x = visible_slope(stretched.z, sin, u[0], lanes);
                let slope_y = inverse_erf(u[1] + u[1] - one);
                let x = cos_phi * slope_x - sin_phi * slope_y;
                let y = sin_phi * slope_x + cos_phi * slope_y;
                V3::new(-(a * x), -(b * y), one).normalize()
            }
        }
    }
}

/// F of `visible_slope`.
#[inline(always)]
fn cumulative<R: Real>(cos: R, sin: R, b: R, x: R) -> R {
    let half_root_pi = R::splat(0.5 * FRAC_1_PI.sqrt());
    R::splat(0.5) * cos * (R::one() + b) + sin * half_root_pi * exp(-(x * x))
}

/// See `visible_slope` in `microfacet/gaussian.rs`: the same Newton steps, until all lanes are there.
#[inline(always)]
fn visible_slope<R: Real>(cos: R, sin: R, u: R, lanes: R::M) -> R {
    let (one, half) = (R::one(), R::splat(0.5));
    let flat = sin.lt(R::splat(1e-4));
    let cot = cos / sin.max(R::splat(1e-4));
    let b_max = one - exp(-(cot * cot)) * scaled_erfc(cot);
    let whole = cumulative(cos, sin, b_max, cot);
    let (target, tolerance) = (u * whole, R::splat(1e-5) * whole);
    let theta = acos(cos.clamp(0.0, 1.0));
    let fit =
        one + theta * (R::splat(-0.876) + theta * (R::splat(0.4265) - R::splat(0.0594) * theta));
    let rest = (one - u).max(R::splat(1e-30));
    let (mut low, mut high) = (-one, b_max);
    let mut b = b_max - (one + b_max) * exp(fit * ln(rest));
    // seen from above the slopes are Gaussian
    b = R::select(flat, u + u - one, b);
    let mut x = R::zero();
    let mut open = lanes;
    for _ in 0..12 {
        let inside = b.ge(low) & b.le(high);
        b = R::select(inside | flat, b, half * (low + high));
        let here = inverse_erf(b);
        x = R::select(open, here, x);
        let excess = cumulative(cos, sin, b, here) - target;
        open = open & excess.abs().ge(tolerance) & !flat;
        if !open.any() {
            break;
        }
        let above = excess.gt(R::zero());
        high = R::select(above, b, high);
        low = R::select(above, low, b);
        b = b - (excess + excess) / (cos - here * sin);
    }
    x
}

/// See `scaled_erfc` in `microfacet/gaussian.rs`.
#[inline(always)]
fn scaled_erfc<R: Real>(x: R) -> R {
    let t = (R::one() + R::splat(0.327_591_1) * x).recip();
    let mut sum = R::splat(1.061_405_4);
    for c in [-1.453_152, 1.421_413_7, -0.284_496_74, 0.254_829_6] {
        sum = sum * t + R::splat(c);
    }
    t * sum
}

/// See `inverse_erf` in `microfacet/gaussian.rs`.
#[inline(always)]
fn inverse_erf<R: Real>(x: R) -> R {
    let x = x.clamp(-0.999_999_9, 0.999_999_9);
    let w = -ln((R::one() - x) * (R::one() + x));
    let near = [
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        0.000_218_580_87,
        -0.001_253_725,
        -0.004_177_681_6,
        0.246_640_73,
        1.501_409_4,
    ];
    let v = w - R::splat(2.5);
    let mut p = R::splat(2.810_226_4e-8);
    for c in near {
        p = p * v + R::splat(c);
    }
    let far = w.ge(R::splat(5.0));
    if far.any() {
        let tail = [
            0.000_100_950_56,
            0.001_349_343_2,
            -0.003_673_428_4,
            0.005_739_507_7,
            -0.007_622_461_3,
            0.009_438_870_5,
            1.001_674_1,
            2.832_976_8,
        ];
        let v = w.max(R::zero()).sqrt() - R::splat(3.0);
        let mut q = R::splat(-0.000_200_214_26);
        for c in tail {
            q = q * v + R::splat(c);
        }
        p = R::select(far, q, p);
    }
    p * x
}
