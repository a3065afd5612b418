//! Mirror facets of rough surfaces, a path a lane: see `microfacet.rs`.

use super::super::microfacet::{Kind, Microfacets, inverse_erf, seen_area, visible_slope};
use crate::lanes::{Real, V3, exp, ln, sin_cos_turns};

/// The statistics of facet slopes.
#[derive(Clone, Copy)]
pub(super) struct Facets<'a>(pub(super) &'a Microfacets);

impl Facets<'_> {
    /// Widths along U and V.
    #[inline(always)]
    fn widths<R: Real>(&self) -> [R; 2] {
        [R::splat(self.0.alpha_u), R::splat(self.0.alpha_v)]
    }

    /// See [`Microfacets::density`].
    #[inline(always)]
    pub(super) fn density<R: Real>(&self, m: V3<R>) -> R {
        let [u, v] = self.0.inverse;
        let (x, y) = (m.x * R::splat(u), m.y * R::splat(v));
        let (peak, cos2) = (R::splat(self.0.peak), m.z * m.z);
        let slope2 = x * x + y * y;
        let density = match self.0.kind {
            Kind::Beckmann => {
                let sec2 = cos2.recip();
                peak * exp(-(slope2 * sec2)) * (sec2 * sec2)
            }
            Kind::Ggx => {
                let q = slope2 + cos2;
                peak / (q * q)
            }
        };
        density.only(m.z.gt(R::splat(1e-9)))
    }

    /// See [`Microfacets::stretched`].
    #[inline(always)]
    fn stretched<R: Real>(&self, v: V3<R>) -> (R, R) {
        let [a, b] = self.widths::<R>();
        let (x, y) = (v.x * a, v.y * b);
        (v.z.abs(), (x * x + y * y).sqrt())
    }

    /// See [`Microfacets::seen_fraction`].
    #[inline(always)]
    fn seen_fraction<R: Real>(&self, v: V3<R>) -> (R, R) {
        let (z, r) = self.stretched(v);
        match self.0.kind {
            Kind::Beckmann => {
                let part = z * (R::splat(3.535) * r + R::splat(2.181) * z);
                let whole = r * r + z * (R::splat(2.276) * r + R::splat(2.577) * z);
                let steep = z.ge(R::splat(1.6) * r);
                let one = R::one();
                (R::select(steep, one, part), R::select(steep, one, whole))
            }
            Kind::Ggx => (z + z, z + (z * z + r * r).sqrt()),
        }
    }

    /// See [`Microfacets::seen_area`].
    #[inline(always)]
    fn seen_area<R: Real>(&self, v: V3<R>) -> R {
        let (z, r) = self.stretched(v);
        match self.0.kind {
            Kind::Beckmann => seen_area(z, r),
            Kind::Ggx => R::splat(0.5) * (z + (z * z + r * r).sqrt()),
        }
    }

    /// See [`Microfacets::mirrored`]; `facets` is D(h).
    #[inline(always)]
    pub(super) fn mirrored<R: Real>(&self, o: V3<R>, i: V3<R>, h: V3<R>, facets: R) -> (R, R) {
        let ((a, b), (c, d)) = (self.seen_fraction(i), self.seen_fraction(o));
        let four = R::splat(4.0);
        let weight = facets * (a * c) / (four * o.z * (b * d));
        let density = if self.0.visible {
            facets / (four * self.seen_area(o))
        } else {
            facets * h.z / (four * o.dot(h))
        };
        (weight, density)
    }

    /// Draws facet normals for viewers above the surface, with D(m): see [`Microfacets::sample`].
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, o: V3<R>, u: [R; 2]) -> (V3<R>, R) {
        if !self.0.visible {
            let m = self.sample_all(u);
            return (m, self.density(m));
        }
        let one = R::one();
        let [a, b] = self.widths::<R>();
        let peak = R::splat(self.0.peak);
        let (x, y) = (o.x * a, o.y * b);
        let (z, r) = self.stretched(o);
        match self.0.kind {
            Kind::Ggx => {
                let shrink = (z * z + r * r).sqrt().recip();
                let view = V3::new(x, y, z) * shrink;
                let up = (one - u[0]) * (one + view.z) - view.z;
                let across = (one - up * up).max(R::zero()).sqrt();
                let (sin, cos) = sin_cos_turns(u[1]);
                let h = V3::new(across * cos, across * sin, up) + view;
                let m = V3::new(h.x * a, h.y * b, h.z.max(R::zero()));
                let ratio = m.squared() / h.squared();
                let facets = (peak * ratio * ratio).only(h.z.gt(R::zero()));
                (m.normalize(), facets)
            }
            Kind::Beckmann => {
                let (tilted, inverse) = (r.gt(R::zero()), r.recip());
                let cos_phi = R::select(tilted, x * inverse, one);
                let sin_phi = R::select(tilted, y * inverse, R::zero());
                let along = visible_slope(z, r, seen_area(z, r), u[0]);
                let across = inverse_erf(u[1] + u[1] - one);
                let x = cos_phi * along - sin_phi * across;
                let y = sin_phi * along + cos_phi * across;
                let m = V3::new(-(a * x), -(b * y), one);
                let sec2 = m.squared();
                let facets = peak * exp(-(along * along + across * across)) * (sec2 * sec2);
                (m * sec2.sqrt().recip(), facets)
            }
        }
    }

    /// See [`Microfacets::sample_all`].
    #[inline(always)]
    fn sample_all<R: Real>(&self, u: [R; 2]) -> V3<R> {
        let [a, b] = self.widths::<R>();
        let rest = R::one() - u[0];
        let slope2 = match self.0.kind {
            Kind::Beckmann => -ln(rest),
            Kind::Ggx => u[0] / rest,
        };
        let (sin, cos) = sin_cos_turns(u[1]);
        let slope = slope2.max(R::zero()).sqrt();
        V3::new(a * slope * cos, b * slope * sin, R::one()).normalize()
    }
}
