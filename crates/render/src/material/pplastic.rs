//! `pplastic`: a diffuse base under a rough dielectric surface; both parts polarize.
//!
//! | parameter              | type            | meaning                                                    | default         |
//! |------------------------|-----------------|------------------------------------------------------------|-----------------|
//! | `diffuse_reflectance`  | spectrum        | reflected fraction of the base                             | 0.5             |
//! | `specular_reflectance` | spectrum        | factor on the surface reflection (not physical)            | 1               |
//! | `int_ior`              | float or string | index of the plastic                                       | `polypropylene` |
//! | `ext_ior`              | float or string | index outside                                              | `air`           |
//! | `distribution`         | string          | `beckmann` or `ggx`                                        | `beckmann`      |
//! | `alpha`                | float           | roughness, or `alpha_u`, `alpha_v` along and across axis U | 0.1             |
//! | `sample_visible`       | boolean         | draw only facets that the viewer sees                      | true            |
//!
//! ```xml
//! <bsdf type="pplastic"><rgb name="diffuse_reflectance" value="0.1, 0.3, 0.5"/><float name="alpha" value="0.05"/></bsdf>
//! ```
//!
//! Light enters through the surface, is depolarized by the base and leaves through the surface: polarized across the
//! plane of reflection near the highlight, along it near the rim. No internal reflections between base and surface.
//! One-sided.
//!
//! Source: Baek et al., Simultaneous Acquisition of Polarimetric SVBRDF and Normals, TOG 37(6), 2018.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use mueller16::DielectricInterface;

use super::dielectric::read_index;
use super::microfacet::Microfacets;
use super::{Departure, Effect, Matter, Part, Vertex, axis_s, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A diffuse base under a rough dielectric surface.
#[derive(Clone, Debug)]
pub struct Pplastic {
    surface: DielectricInterface,
    base: Spectrum,
    reflectance: Spectrum,
    facets: Microfacets,
}

impl Pplastic {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let inside = read_index(object, "int_ior", "polypropylene")?;
        let outside = read_index(object, "ext_ior", "air")?;
        let reflectance = |name, default| {
            object.spectrum(name, SpectrumUse::Reflectance, Spectrum::constant(default))
        };
        Ok(Self {
            surface: DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?,
            base: reflectance("diffuse_reflectance", 0.5)?,
            reflectance: reflectance("specular_reflectance", 1.0)?,
            facets: Microfacets::read(object)?,
        })
    }

    /// Probability of drawing a facet rather than a direction from the base.
    #[inline]
    fn surface_probability(&self, o: Vec3A, wavelengths: &[f32]) -> f32 {
        let r = self.surface.reflection(f64::from(o.z.min(1.0))).mean as f32;
        let surface = r * self.reflectance.value(wavelengths[0]);
        let base = (1.0 - r) * self.base.value(wavelengths[0]);
        // both stay possible: the wavelengths may differ
        (surface / (surface + base)).clamp(0.1, 0.9)
    }

    /// Passage through the surface, for light that arrives from or leaves to outside at `cos`.
    #[inline]
    fn passage(&self, cos: f32) -> Element {
        self.surface
            .transmission(f64::from(cos.min(1.0)))
            .map_or(Element::BLACK, |t| Element::from(t.element))
    }

    #[inline]
    fn density(&self, o: Vec3A, i: Vec3A, h: Vec3A, wavelengths: &[f32]) -> f32 {
        let p = self.surface_probability(o, wavelengths);
        p * self.facets.sampling_density(o, h) / (4.0 * o.dot(h)) + (1.0 - p) * i.z * FRAC_1_PI
    }
}

impl Matter for Pplastic {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z <= 0.0 {
            return None;
        }
        let i = if u[0] < self.surface_probability(o, wavelengths) {
            mirror(o, self.facets.sample(o, [u[1], u[2]]))
        } else {
            cosine_hemisphere([u[1], u[2]])
        };
        if i.z <= 0.0 {
            return None;
        }
        let density = self.density(o, i, (o + i).normalize(), wavelengths);
        (density > 0.0 && density.is_finite()).then_some(Departure {
            direction: i,
            density,
            part: Part::Continuous,
            eta: 1.0,
        })
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
        let o = at.o;
        if o.z <= 0.0 || i.z <= 0.0 {
            return (L::depolarizing(|_| 0.0), 0.0);
        }
        let h = (o + i).normalize();
        let facets =
            self.facets.density(h) * self.facets.shadowing(i, h) * self.facets.shadowing(o, h)
                / (4.0 * o.z);
        let mirrored =
            Element::from(self.surface.reflection(f64::from(i.dot(h).min(1.0)))).scaled(facets);
        let surface = L::diattenuating_retarder(axis_s(h, i), |lane| {
            mirrored.scaled(self.reflectance.value(wavelengths[lane]))
        });
        let base = L::depolarizer_between(
            (axis_s(Vec3A::Z, o), self.passage(o.z)),
            |lane| self.base.value(wavelengths[lane]) * i.z * FRAC_1_PI,
            (axis_s(Vec3A::Z, i), self.passage(i.z)),
        );
        (
            L::sum(surface, base, o, -i),
            self.density(o, i, h, wavelengths),
        )
    }

    fn is_discrete(&self) -> bool {
        false
    }

    fn effect(&self) -> Effect {
        Effect {
            depolarizes: true,
            makes_linear: true,
            ..Effect::default()
        }
    }
}
