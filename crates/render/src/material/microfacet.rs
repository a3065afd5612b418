//! Microfacet distributions: Beckmann and GGX, anisotropic, with sampling of visible normals.
//!
//! `alpha` is the root mean square slope times √2 (Beckmann) of the facets along U and V.
//!
//! Source: Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007 (D, and the rational fit
//! of the Beckmann shadowing term, its Eq. 27 ff.); Heitz, Understanding the Masking-Shadowing Function, JCGT 3(2), 2014.

mod gaussian;

use std::f32::consts::{PI, TAU};

use glam::Vec3A;

use crate::scene::{Object, SceneError};
pub(super) use gaussian::{inverse_erf, seen_area, visible_slope};

/// The statistics of facet slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Gaussian slopes.
    Beckmann,
    /// Trowbridge–Reitz slopes, with long tails.
    Ggx,
}

/// A distribution of facet normals.
#[derive(Clone, Copy, Debug)]
pub struct Microfacets {
    pub(super) kind: Kind,
    pub(super) alpha_u: f32,
    pub(super) alpha_v: f32,
    /// 1/α along U and V.
    pub(super) inverse: [f32; 2],
    /// D(m) along the normal, 1/(π α_u α_v).
    pub(super) peak: f32,
    /// Draw only normals that the viewer sees.
    pub(super) visible: bool,
}

impl Microfacets {
    /// A distribution with given widths, sampling visible normals.
    pub fn new(kind: Kind, alpha_u: f32, alpha_v: f32) -> Self {
        Self {
            kind,
            alpha_u,
            alpha_v,
            inverse: [alpha_u.recip(), alpha_v.recip()],
            peak: (PI * alpha_u * alpha_v).recip(),
            visible: true,
        }
    }

    /// Reads `distribution`, `alpha` or `alpha_u` and `alpha_v`, and `sample_visible`.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let kind = match object
            .choice("distribution", "beckmann", &["beckmann", "ggx"])?
            .as_str()
        {
            "ggx" => Kind::Ggx,
            _ => Kind::Beckmann,
        };
        let width = |name: &str, default: f64| {
            let alpha = object.float(name, default)?;
            if alpha > 0.0 {
                // narrower lobes vanish in single precision, and look like a smooth surface; of wider ones all facets
                // stand on edge, and squares of slopes would not fit
                Ok(alpha.clamp(1e-4, 1e6) as f32)
            } else {
                Err(object.error_at(
                    name,
                    format!("a roughness of {alpha}, expected a positive number"),
                ))
            }
        };
        let split = object.has("alpha_u") || object.has("alpha_v");
        if split && object.has("alpha") {
            return Err(object.error_at(
                "alpha",
                "both 'alpha' and 'alpha_u', 'alpha_v' are given, expected one of them",
            ));
        }
        let alpha = width("alpha", 0.1)?;
        let (alpha_u, alpha_v) = (
            width("alpha_u", f64::from(alpha))?,
            width("alpha_v", f64::from(alpha))?,
        );
        Ok(Self {
            visible: object.boolean("sample_visible", true)?,
            ..Self::new(kind, alpha_u, alpha_v)
        })
    }

    /// Whether it is the same along U and V.
    pub fn is_isotropic(&self) -> bool {
        self.alpha_u == self.alpha_v
    }

    /// The same facets, drawn as the viewer sees them.
    pub fn seen(self) -> Self {
        Self {
            visible: true,
            ..self
        }
    }

    /// Density of facet normals per steradian of their direction, D(m).
    #[inline]
    pub fn density(&self, m: Vec3A) -> f32 {
        // next to the plane 1/cos⁴ would not fit into single precision
        if m.z <= 1e-9 {
            return 0.0;
        }
        let (x, y) = (m.x * self.inverse[0], m.y * self.inverse[1]);
        let cos2 = m.z * m.z;
        match self.kind {
            Kind::Beckmann => {
                let sec2 = cos2.recip();
                self.peak * (-(x * x + y * y) * sec2).exp() * (sec2 * sec2)
            }
            Kind::Ggx => {
                let q = x * x + y * y + cos2;
                self.peak / (q * q)
            }
        }
    }

    /// Height over the plane and distance along it of a direction, where slopes are made those of unit roughness: α tan θ
    /// is the second over the first, with the α of the azimuth.
    #[inline]
    fn stretched(&self, v: Vec3A) -> (f32, f32) {
        let (x, y) = (v.x * self.alpha_u, v.y * self.alpha_v);
        (v.z.abs(), (x * x + y * y).sqrt())
    }

    /// The fraction of a facet that is seen from `v`, G1(v, m): Smith's, for Beckmann by Walter's rational fit.
    #[inline]
    pub fn shadowing(&self, v: Vec3A, m: Vec3A) -> f32 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        let (part, whole) = self.seen_fraction(v);
        part / whole
    }

    /// G1 of facets on the viewer's side, as a fraction: a product of several takes one division.
    #[inline]
    fn seen_fraction(&self, v: Vec3A) -> (f32, f32) {
        let (z, r) = self.stretched(v);
        match self.kind {
            Kind::Beckmann if z >= 1.6 * r => (1.0, 1.0),
            Kind::Beckmann => (
                z * (3.535 * r + 2.181 * z),
                r * r + z * (2.276 * r + 2.577 * z),
            ),
            Kind::Ggx => (2.0 * z, z + (z * z + r * r).sqrt()),
        }
    }

    /// D(h) G1(i) G1(o): the facets that lead from one direction to the other, and that both see.
    #[inline]
    pub fn lit(&self, o: Vec3A, i: Vec3A, h: Vec3A) -> f32 {
        self.density(h) * self.shadowing(i, h) * self.shadowing(o, h)
    }

    /// BRDF × cos i of facets that mirror everything, `D G1(i) G1(o)/(4 cos o)`, and the density of
    /// [`Microfacets::mirror_density`]; h halves the directions, which are both above the surface.
    ///
    /// Source: Walter et al. 2007, Eq. 20.
    #[inline]
    pub fn mirrored(&self, o: Vec3A, i: Vec3A, h: Vec3A) -> (f32, f32) {
        let facets = self.density(h);
        let ((a, b), (c, d)) = (self.seen_fraction(i), self.seen_fraction(o));
        let weight = facets * (a * c) / (4.0 * o.z * (b * d));
        (weight, self.mirrored_density(o, h, facets))
    }

    /// Density per steradian of the mirror direction of `o` at normals that [`Microfacets::sample`] draws.
    #[inline]
    pub fn mirror_density(&self, o: Vec3A, m: Vec3A) -> f32 {
        self.mirrored_density(o, m, self.density(m))
    }

    /// The same where D(m) is known: the cosine between `o` and `m` cancels if only visible facets are drawn.
    #[inline]
    fn mirrored_density(&self, o: Vec3A, m: Vec3A, facets: f32) -> f32 {
        if self.visible {
            facets / (4.0 * self.seen_area(o))
        } else {
            facets * m.z / (4.0 * o.dot(m))
        }
    }

    /// Area of all facets as seen from `v`, over that of the plane: cos v/G1 with Smith's G1 without the fit. It
    /// normalises the density of visible normals.
    #[inline]
    fn seen_area(&self, v: Vec3A) -> f32 {
        let (z, r) = self.stretched(v);
        match self.kind {
            Kind::Beckmann => seen_area(z, r),
            Kind::Ggx => 0.5 * (z + (z * z + r * r).sqrt()),
        }
    }

    /// Density per steradian with which [`Microfacets::sample`] draws the normal `m` for a viewer at `o`.
    #[inline]
    pub fn sampling_density(&self, o: Vec3A, m: Vec3A) -> f32 {
        let facets = self.density(m);
        if self.visible {
            o.dot(m).max(0.0) * facets / self.seen_area(o)
        } else {
            facets * m.z
        }
    }

    /// Draws a facet normal for a viewer at `o` (above the surface).
    #[inline]
    pub fn sample(&self, o: Vec3A, u: [f32; 2]) -> Vec3A {
        self.draw(o, u).0
    }

    /// Draws a facet normal, and says how dense the mirror direction of `o` is: [`Microfacets::mirror_density`].
    #[inline]
    pub fn sample_mirror(&self, o: Vec3A, u: [f32; 2]) -> (Vec3A, f32) {
        let (m, facets, area) = self.draw(o, u);
        let density = match area {
            Some(area) => facets / (4.0 * area),
            None => facets * m.z / (4.0 * o.dot(m)),
        };
        (m, density)
    }

    /// Draws a facet normal; with D(m), and the area that is seen if only visible facets are drawn.
    #[inline]
    fn draw(&self, o: Vec3A, u: [f32; 2]) -> (Vec3A, f32, Option<f32>) {
        if !self.visible {
            let m = self.sample_all(u);
            return (m, self.density(m), None);
        }
        let (x, y) = (o.x * self.alpha_u, o.y * self.alpha_v);
        let (z, r) = self.stretched(o);
        match self.kind {
            Kind::Ggx => {
                // Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, HPG 2023
                let length = (z * z + r * r).sqrt();
                let view = Vec3A::new(x, y, z) / length;
                let up = (1.0 - u[0]) * (1.0 + view.z) - view.z;
                let across = (1.0 - up * up).max(0.0).sqrt();
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let h = Vec3A::new(across * cos, across * sin, up) + view;
                let m = Vec3A::new(h.x * self.alpha_u, h.y * self.alpha_v, h.z.max(0.0));
                let ratio = m.length_squared() / h.length_squared();
                let facets = if h.z > 0.0 {
                    self.peak * ratio * ratio
                } else {
                    0.0
                };
                (m.normalize(), facets, Some(0.5 * (z + length)))
            }
            Kind::Beckmann => {
                let (cos_phi, sin_phi) = if r > 0.0 {
                    (x * r.recip(), y * r.recip())
                } else {
                    (1.0, 0.0)
                };
                let area = seen_area(z, r);
                let along = visible_slope(z, r, area, u[0]);
                let across = inverse_erf(2.0 * u[1] - 1.0);
                let x = cos_phi * along - sin_phi * across;
                let y = sin_phi * along + cos_phi * across;
                let m = Vec3A::new(-self.alpha_u * x, -self.alpha_v * y, 1.0);
                let sec2 = m.length_squared();
                let bell = (-(along * along + across * across)).exp();
                let facets = self.peak * bell * (sec2 * sec2);
                (m / sec2.sqrt(), facets, Some(area))
            }
        }
    }

    /// Draws from D(m) cos m.
    fn sample_all(&self, u: [f32; 2]) -> Vec3A {
        let slope2 = match self.kind {
            Kind::Beckmann => -(1.0 - u[0]).ln(),
            Kind::Ggx => u[0] / (1.0 - u[0]),
        };
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let slope = slope2.sqrt();
        Vec3A::new(self.alpha_u * slope * cos, self.alpha_v * slope * sin, 1.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::SampleStream;

    const CASES: [(Kind, f32, f32); 6] = [
        (Kind::Beckmann, 0.1, 0.1),
        (Kind::Beckmann, 0.5, 0.5),
        (Kind::Beckmann, 0.4, 0.15),
        (Kind::Ggx, 0.1, 0.1),
        (Kind::Ggx, 0.5, 0.5),
        (Kind::Ggx, 0.4, 0.15),
    ];

    fn view(degrees: f32, azimuth: f32) -> Vec3A {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3A::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    /// Integral over the hemisphere of m in the projected slope plane, which covers the lobe evenly.
    fn integrate(alpha: (f32, f32), f: impl Fn(Vec3A) -> f64) -> f64 {
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                // slopes by a tangent map: covers the tails of GGX
                let (a, b) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
                let (ta, tb) = (
                    ((a - 0.5) * std::f64::consts::PI).tan(),
                    ((b - 0.5) * std::f64::consts::PI).tan(),
                );
                let jacobian = std::f64::consts::PI.powi(2) * (1.0 + ta * ta) * (1.0 + tb * tb);
                let (x, y) = (ta * f64::from(alpha.0), tb * f64::from(alpha.1));
                let m = Vec3A::new(x as f32, y as f32, 1.0).normalize();
                // solid angle of a slope element: cos³
                let cos = (1.0 + x * x + y * y).sqrt().recip();
                sum += f(m) * cos.powi(3) * jacobian * f64::from(alpha.0 * alpha.1);
            }
        }
        sum / (n * n) as f64
    }

    #[test]
    fn facets_cover_the_macroscopic_surface_exactly() {
        for (kind, a, b) in CASES {
            let d = Microfacets::new(kind, a, b);
            let covered = integrate((a, b), |m| f64::from(d.density(m) * m.z));
            assert!((covered - 1.0).abs() < 2e-3, "{kind:?} {a} {b}: {covered}");
        }
    }

    #[test]
    fn visible_normals_are_a_probability_density_for_every_view() {
        for (kind, a, b) in CASES {
            let d = Microfacets::new(kind, a, b);
            for degrees in [0.5, 30.0, 60.0, 85.0] {
                let o = view(degrees, 0.7);
                let total = integrate((a, b), |m| f64::from(d.sampling_density(o, m)));
                assert!(
                    (total - 1.0).abs() < 3e-3,
                    "{kind:?} {a} {b} {degrees}: {total}"
                );
            }
        }
    }

    /// χ² of drawn normals against their density in 8 × 8 cells of equal probability of D(m) cos m; 63 degrees of
    /// freedom, merged where fewer than 20 are expected; 1e-5 quantile of χ²(63) is 118.
    #[test]
    fn drawn_normals_follow_their_density() {
        for (kind, a, b) in CASES {
            for degrees in [0.0, 30.0, 70.0, 85.0] {
                let d = Microfacets::new(kind, a, b);
                let o = view(degrees, 0.7);
                let cell = |m: Vec3A| {
                    let (x, y) = (m.x / (m.z * a), m.y / (m.z * b));
                    let r2 = f64::from(x * x + y * y);
                    let p = match kind {
                        Kind::Beckmann => 1.0 - (-r2).exp(),
                        Kind::Ggx => r2 / (1.0 + r2),
                    };
                    let angle =
                        (f64::from(y.atan2(x)) / std::f64::consts::TAU + 0.5).min(0.999_999);
                    (p.min(0.999_999) * 8.0) as usize * 8 + (angle * 8.0) as usize
                };
                let n = 200_000;
                let mut counts = [0.0; 64];
                for i in 0..n {
                    counts[cell(d.sample(o, SampleStream::new(11, 0, i).pair(0)))] += 1.0;
                }
                // expected: many points of D(m) cos m itself, weighted by the ratio of the densities
                let mut expected = [0.0; 64];
                let k = 1000;
                for i in 0..k {
                    for j in 0..k {
                        // the ratio grows as 1/√(1 − u) toward grazing normals: substituted away
                        let rest = 1.0 - (i as f32 + 0.5) / k as f32;
                        let m = d.sample_all([1.0 - rest * rest, (j as f32 + 0.5) / k as f32]);
                        let weight =
                            f64::from(2.0 * rest * d.sampling_density(o, m) / (d.density(m) * m.z));
                        expected[cell(m)] += weight * n as f64 / (k * k) as f64;
                    }
                }
                let (mut chi2, mut rest) = (0.0, (0.0, 0.0));
                for (c, e) in counts.iter().zip(expected) {
                    if e > 20.0 {
                        chi2 += (c - e) * (c - e) / e;
                    } else {
                        rest = (rest.0 + c, rest.1 + e);
                    }
                }
                if rest.1 > 5.0 {
                    chi2 += f64::powi(rest.0 - rest.1, 2) / rest.1;
                }
                assert!(chi2 < 118.0, "{kind:?} {a} {b} at {degrees}: χ² = {chi2}");
            }
        }
    }

    #[test]
    fn a_drawn_normal_comes_with_the_density_of_its_mirror_direction() {
        for (kind, a, b) in CASES {
            for visible in [true, false] {
                let d = Microfacets {
                    visible,
                    ..Microfacets::new(kind, a, b)
                };
                for degrees in [0.0, 30.0, 70.0, 89.0] {
                    let o = view(degrees, 0.7);
                    for i in 0..1000 {
                        let u = SampleStream::new(12, 0, i).pair(0);
                        let (m, drawn) = d.sample_mirror(o, u);
                        assert_eq!(m, d.sample(o, u));
                        // cosines of normals near the plane round by 6e-8 of 1, and D grows with 1/cos⁴ of them
                        let bound = 2e-5 + 1e-6 / m.z;
                        let expected = d.sampling_density(o, m) / (4.0 * o.dot(m));
                        assert!(
                            (drawn / expected - 1.0).abs() < bound || o.dot(m) < 1e-3,
                            "{kind:?} {a} {b} {degrees}: {m}, {drawn} {expected}"
                        );
                        assert!((d.mirror_density(o, m) / drawn - 1.0).abs() < bound);
                    }
                }
            }
        }
    }

    #[test]
    fn the_rational_fit_of_shadowing_stays_within_its_error() {
        // Walter et al. 2007 state a relative error below 0.35 %
        let d = Microfacets::new(Kind::Beckmann, 0.3, 0.3);
        for degrees in 1..90 {
            let v = view(degrees as f32, 0.0);
            let ratio = d.shadowing(v, Vec3A::Z) * d.seen_area(v) / v.z;
            assert!((ratio - 1.0).abs() < 3.5e-3, "{degrees}: {ratio}");
        }
    }
}
