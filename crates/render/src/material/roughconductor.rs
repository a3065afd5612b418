//! `roughconductor`: a metal with a rough surface of mirror facets.
//!
//! | parameter              | type     | meaning                                                    | default    |
//! |------------------------|----------|------------------------------------------------------------|------------|
//! | `distribution`         | string   | `beckmann` or `ggx`                                        | `beckmann` |
//! | `alpha`                | float    | roughness, or `alpha_u`, `alpha_v` along and across axis U | 0.1        |
//! | `sample_visible`       | boolean  | draw only facets that the viewer sees                      | true       |
//! | `material`             | string   | a named metal instead of `eta`, `k`                        | –          |
//! | `eta`, `k`             | spectrum | index of refraction η − i k                                | 0, 1       |
//! | `specular_reflectance` | spectrum | factor on the reflected power (not physical)               | 1          |
//!
//! ```xml
//! <bsdf type="roughconductor">
//!     <string name="material" value="Au"/><float name="alpha" value="0.2"/><string name="distribution" value="ggx"/>
//! </bsdf>
//! ```
//!
//! BRDF `F D G1(i) G1(o)/(4 cos i cos o)` with the Mueller matrix F of the facet that mirrors `i` into `o`. Single
//! scattering: light that would meet a second facet is lost. One-sided.
//!
//! Source: Walter et al., EGSR 2007, Eq. 20.

use glam::Vec3A;

use super::conductor::Metal;
use super::microfacet::Microfacets;
use super::{Departure, Effect, Matter, Part, Vertex, axis_s, dark, mirror};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::scene::{Object, SceneError};

/// A rough metal surface.
#[derive(Clone, Debug)]
pub struct RoughConductor {
    metal: Metal,
    facets: Microfacets,
}

impl RoughConductor {
    /// What it is made of.
    #[inline(always)]
    pub(super) fn metal(&self) -> &Metal {
        &self.metal
    }

    /// Its facets.
    #[inline(always)]
    pub(super) fn facets(&self) -> &Microfacets {
        &self.facets
    }

    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            metal: Metal::read(object)?,
            facets: Microfacets::read(object)?,
        })
    }
}

impl Matter for RoughConductor {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z <= 0.0 {
            return None;
        }
        let (m, density) = self.facets.sample_mirror(o, [u[1], u[2]]);
        let i = mirror(o, m);
        if i.z <= 0.0 {
            return None;
        }
        Departure::continuous(i, density, 1.0)
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
            return dark::<L>();
        }
        let h = (o + i).normalize();
        let cos = i.dot(h).min(1.0);
        let (weight, density) = self.facets.mirrored(o, i, h);
        let response = L::diattenuating_retarder(axis_s(h, i), |lane| {
            self.metal.reflection(cos, wavelengths[lane]).scaled(weight)
        });
        (response, density)
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.metal.is_grey(range)
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }
}
