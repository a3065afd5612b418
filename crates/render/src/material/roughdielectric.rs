//! `roughdielectric`: ground glass, an interface of refracting facets between two transparent media.
//!
//! | parameter                | type            | meaning                                                    | default    |
//! |--------------------------|-----------------|------------------------------------------------------------|------------|
//! | `int_ior`                | float or string | index on the side opposite to the normal                   | `bk7`      |
//! | `ext_ior`                | float or string | index on the side of the normal, another one               | `air`      |
//! | `distribution`           | string          | `beckmann` or `ggx`                                        | `beckmann` |
//! | `alpha`                  | float           | roughness, or `alpha_u`, `alpha_v` along and across axis U | 0.1        |
//! | `sample_visible`         | boolean         | draw only facets that the viewer sees                      | true       |
//! | `specular_reflectance`   | spectrum        | factor on the reflected power (not physical)               | 1          |
//! | `specular_transmittance` | spectrum        | factor on the transmitted power (not physical)             | 1          |
//!
//! ```xml
//! <bsdf type="roughdielectric">
//!     <string name="distribution" value="ggx"/><float name="alpha" value="0.3"/><string name="int_ior" value="water"/>
//! </bsdf>
//! ```
//!
//! Both sides. Each facet reflects and refracts as `dielectric` does, with its own plane of incidence: M(h) is Fresnel's
//! Mueller matrix of the facet h that takes `i` into `o`, total reflection with its retardance. Single scattering. With
//! η the index on the light's side over that on the camera's side, h along `o + i` or `o + η i`,
//!
//! ```text
//! f cos i = M(h) D G1(i) G1(o)/(4 cos o)                                       reflection
//! f cos i = M(h) D G1(i) G1(o) |i·h| |o·h|/(cos o (o·h + η i·h)²)              refraction, radiance
//! ```
//!
//! Source: Walter et al., EGSR 2007, Eqs. 20, 21.

use glam::Vec3A;

use super::dielectric::Faces;
use super::microfacet::Microfacets;
use super::{Departure, Effect, Matter, Part, Vertex, axis_s, dark, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// A rough dielectric surface.
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    faces: Faces,
    facets: Microfacets,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

/// Reads `int_ior` and `ext_ior` of matter that needs two different media.
pub(super) fn read_two_indices(object: &Object, default: &str) -> Result<Faces, SceneError> {
    let faces = Faces::read(object, default)?;
    let [outside, inside] = faces.indices();
    if inside == outside {
        return Err(object.error_at(
            "int_ior",
            format!(
                "the media on both sides of {} have the index {inside}, expected two different ones; \
                 a surface that changes nothing is a bsdf 'null'",
                object.describe()
            ),
        ));
    }
    Ok(faces)
}

/// A facet that takes light from `i` to `o`, seen with `o` above the surface.
struct Facet {
    /// Its normal, above the surface.
    h: Vec3A,
    /// Both on the same side.
    reflects: bool,
    o_h: f32,
    /// Negative in refraction.
    i_h: f32,
    /// Index on the side of `i` over that on the side of `o`.
    eta: f32,
}

impl Facet {
    /// Directions in which light hits no facet on its front, or leaves it through its back, have none.
    #[inline]
    fn between(o: Vec3A, i: Vec3A, eta: f32) -> Option<Self> {
        let reflects = i.z > 0.0;
        let sum = if reflects { o + i } else { o + i * eta };
        let mut h = sum.try_normalize()?;
        if h.z < 0.0 {
            h = -h;
        }
        let (o_h, i_h) = (o.dot(h), i.dot(h));
        let front = o_h > 0.0 && (i_h > 0.0) == reflects && i_h != 0.0 && i.z != 0.0;
        front.then_some(Self {
            h,
            reflects,
            o_h: o_h.min(1.0),
            i_h: i_h.clamp(-1.0, 1.0),
            eta,
        })
    }

    /// Solid angle of h over that of i, without the factor |i·h| η² of refraction.
    #[inline]
    fn squeeze(&self) -> f32 {
        if self.reflects {
            (4.0 * self.o_h).recip()
        } else {
            let sum = self.o_h + self.eta * self.i_h;
            (sum * sum).recip()
        }
    }
}

impl RoughDielectric {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            faces: read_two_indices(object, "bk7")?,
            facets: Microfacets::read(object)?,
            reflectance: object.factor("specular_reflectance")?,
            transmittance: object.factor("specular_transmittance")?,
        })
    }

    /// Reflected share of unpolarized light at a facet, the same from both sides.
    #[inline]
    fn reflected(&self, up: bool, o_h: f32) -> f32 {
        self.faces.side(up).reflection(f64::from(o_h)).mean as f32
    }

    /// Density of [`Matter::sample`], `o` above the surface.
    #[inline]
    fn density(&self, o: Vec3A, facet: &Facet, reflected: f32) -> f32 {
        let facets = self.facets.sampling_density(o, facet.h) * facet.squeeze();
        if facet.reflects {
            reflected * facets
        } else {
            (1.0 - reflected) * facets * facet.i_h.abs() * facet.eta * facet.eta
        }
    }
}

impl Matter for RoughDielectric {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let up = at.o.z > 0.0;
        if at.o.z == 0.0 {
            return None;
        }
        // the distribution of facets is even: the back is the front seen through the origin
        let o = if up { at.o } else { -at.o };
        let m = self.facets.sample(o, [u[1], u[2]]);
        let o_m = o.dot(m).min(1.0);
        if o_m <= 0.0 {
            return None;
        }
        let reflected = self.reflected(up, o_m);
        let reflects = u[0] < reflected;
        let (i, eta) = if reflects {
            (mirror(o, m), 1.0)
        } else {
            let cos_i = self.faces.side(up).transmission(f64::from(o_m))?.cos_t as f32;
            let eta = self.faces.eta(up);
            ((m * (o_m / eta - cos_i) - o / eta).normalize(), eta)
        };
        if (i.z > 0.0) != reflects {
            return None;
        }
        let facet = Facet::between(o, i, self.faces.eta(up))?;
        let density = self.density(o, &facet, self.reflected(up, facet.o_h));
        Departure::continuous(if up { i } else { -i }, density, eta)
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let up = at.o.z > 0.0;
        let (o, i) = if up { (at.o, i) } else { (-at.o, -i) };
        if o.z <= 0.0 {
            return dark::<L>();
        }
        let Some(facet) = Facet::between(o, i, self.faces.eta(up)) else {
            return dark::<L>();
        };
        let h = facet.h;
        let weight = self.facets.lit(o, i, h) / o.z * facet.squeeze();
        let axis = axis_s(h, i);
        let density = self.density(o, &facet, self.reflected(up, facet.o_h));
        let response = if facet.reflects {
            let element = Element::from(self.faces.side(up).reflection(f64::from(facet.i_h)))
                .scaled(weight * facet.o_h);
            L::diattenuating_retarder(axis, |lane| {
                element.scaled(self.reflectance.value(wavelengths[lane]))
            })
        } else {
            let element = self
                .faces
                .side(!up)
                .transmission(f64::from(-facet.i_h))
                .map_or(Element::BLACK, |t| Element::from(t.element))
                .scaled(weight * facet.o_h * -facet.i_h);
            L::diattenuating_retarder(axis, |lane| {
                element.scaled(self.transmittance.value(wavelengths[lane]))
            })
        };
        (response, density)
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.reflectance.is_constant_over(range) && self.transmittance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        // total internal reflection retards
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::testing::{
        assert_drawn_as_dense, assert_retraced, difference, material_of, mean_over_draws,
        of_indices, reflectances, respond, toward,
    };

    fn glass(alpha: &str) -> crate::material::Material {
        of_indices("roughdielectric", [1.5, 1.0], alpha)
    }

    const BECKMANN: &str =
        "<float name='alpha_u' value='0.4'/><float name='alpha_v' value='0.25'/>";
    const GGX: &str = "<string name='distribution' value='ggx'/><float name='alpha' value='0.3'/>";

    #[test]
    fn drawn_directions_follow_their_density() {
        for alpha in [BECKMANN, GGX] {
            for o in [toward(40.0, 20.0), -toward(30.0, -50.0)] {
                assert_drawn_as_dense(alpha, &glass(alpha), o, 12);
            }
        }
    }

    #[test]
    fn light_retraces_its_path() {
        let glass = glass(BECKMANN);
        let index = |v: Vec3A| if v.z > 0.0 { 1.0 } else { 1.5 };
        for way in [
            (toward(30.0, 10.0), toward(50.0, 160.0)),
            (toward(30.0, 10.0), -toward(25.0, 40.0)),
            (-toward(20.0, 80.0), toward(35.0, 85.0)),
            (-toward(60.0, 80.0), -toward(50.0, 240.0)),
        ] {
            // products of some ten single-precision numbers
            assert_retraced(&glass, way, index, 1e-5);
        }
    }

    #[test]
    fn no_power_is_made_and_little_is_lost() {
        for (alpha, least) in [
            (BECKMANN, 0.93),
            (GGX, 0.85),
            ("<float name='alpha' value='0.05'/>", 0.985),
        ] {
            for o in [toward(5.0, 0.0), toward(50.0, 30.0), -toward(20.0, 0.0)] {
                // radiance per squared index is what is conserved
                let (sum, error) = mean_over_draws(&glass(alpha), o, 40_000, |_, eta| eta * eta);
                let albedo = f64::from(sum.x_axis.x);
                assert!(
                    albedo < 1.0 + 5.0 * error + 1e-5 && albedo > least,
                    "{alpha} {o}: {albedo} ± {error}"
                );
            }
        }
    }

    #[test]
    fn it_becomes_smooth_glass() {
        let rough = glass("<float name='alpha' value='1e-3'/>");
        let smooth = of_indices("dielectric", [1.5, 1.0], "");
        for o in [toward(45.0, 70.0), -toward(30.0, 10.0), -toward(60.0, 10.0)] {
            for transmits in [false, true] {
                let kept = |i: Vec3A, _: f32| {
                    if (i.z * o.z < 0.0) == transmits {
                        1.0
                    } else {
                        0.0
                    }
                };
                let (a, error) = mean_over_draws(&rough, o, 20_000, kept);
                let (b, noise) = mean_over_draws(&smooth, o, 20_000, kept);
                // facets are tilted by 1e-3: Fresnel's coefficients change by less than that
                let allowed = 5.0 * error.hypot(noise) + 2e-3;
                let off = f64::from(difference(&a, &b));
                assert!(off < allowed, "{o} {transmits}: {off}, {allowed} allowed");
            }
        }
    }

    #[test]
    fn refracted_light_is_the_sum_over_its_facets() {
        // what a viewer at 35° sees of a uniform unpolarized world below: facets by slope against directions by solid angle
        let (alpha, eta) = (0.3, 1.5);
        let glass = glass("<float name='alpha' value='0.3'/>");
        let o = toward(35.0, 0.0);
        let od = o.as_dvec3();
        let facets = Microfacets::new(crate::material::microfacet::Kind::Beckmann, 0.3, 0.3);
        let mut expected = [0.0; 3];
        let n = 600;
        for place in 0..n * n {
            let slope = |k: usize| ((k as f64 + 0.5) / n as f64 * 2.0 - 1.0) * 4.5 * alpha;
            let (x, y) = (slope(place / n), slope(place % n));
            let m = glam::DVec3::new(-x, -y, 1.0).normalize();
            let cos = od.dot(m);
            if cos <= 0.0 {
                continue;
            }
            let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
            let i = (m * (cos / eta - cos_t) - od / eta).normalize();
            let g1 = facets.shadowing(o, Vec3A::Z) * facets.shadowing(i.as_vec3a(), m.as_vec3a());
            let cell = (9.0 * alpha / n as f64).powi(2);
            let density =
                (-(x * x + y * y) / (alpha * alpha)).exp() / (std::f64::consts::PI * alpha * alpha);
            // area of the facet seen over that of the surface seen
            let weight = density * cell * cos / (m.z * od.z) * f64::from(g1);
            let [r_s, r_p] = reflectances(eta, cos);
            let (mean, polarized) = (1.0 - 0.5 * (r_s + r_p), 0.5 * (r_p - r_s));
            let frame = |normal: glam::DVec3| normal.cross(od).normalize();
            let (s, z) = (frame(m), frame(glam::DVec3::Z));
            let angle = z.cross(s).dot(od).atan2(z.dot(s));
            let lost = weight / (eta * eta);
            expected[0] += lost * mean;
            expected[1] += lost * polarized * (2.0 * angle).cos();
            expected[2] += lost * polarized * (2.0 * angle).sin();
        }
        let mut found = [0.0; 3];
        let (rings, sectors) = (700, 700);
        for ring in 0..rings {
            for sector in 0..sectors {
                let z = -(ring as f32 + 0.5) / rings as f32;
                let turn = (sector as f32 + 0.5) / sectors as f32 * std::f32::consts::TAU;
                let r = (1.0 - z * z).sqrt();
                let i = Vec3A::new(r * turn.cos(), r * turn.sin(), z);
                let column = respond(&glass, o, i, Part::Continuous).0.x_axis;
                let area = std::f64::consts::TAU / (rings * sectors) as f64;
                for (sum, c) in found.iter_mut().zip(column.to_array()) {
                    *sum += f64::from(c) * area;
                }
            }
        }
        for k in 0..3 {
            // both grids are finer than the lobe by a factor of 100
            assert!(
                (found[k] - expected[k]).abs() < 2e-4,
                "{found:?} {expected:?}"
            );
        }
        assert!(expected[1].abs() > 5e-3);
    }

    #[test]
    fn equal_media_are_refused() {
        let error = material_of(
            "<bsdf type='roughdielectric'><float name='ext_ior' value='1.5'/><float name='int_ior' value='1.5'/></bsdf>",
        );
        let message = error.unwrap_err().to_string();
        assert!(message.starts_with("test.xml:2:65: the media on both sides of bsdf 'roughdielectric' have the index 1.5, expected two"), "{message}");
        let error =
            material_of("<bsdf type='roughdielectric'><float name='alpha' value='-1'/></bsdf>");
        assert_eq!(
            error.unwrap_err().to_string(),
            "test.xml:2:30: a roughness of -1, expected a positive number"
        );
    }
}
