//! A diffuse base under a dielectric surface: what `plastic`, `pplastic` and `roughplastic` share.
//!
//! ```text
//! f = surface(i, o) + T(o) diag(w, 0, 0, 0) T(i)
//! ```
//!
//! with the passages T through the surface, smooth or tabulated, and the weight w of a base that may get back what the
//! surface reflects inside.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use mueller16::DielectricInterface;

use super::microfacet::Microfacets;
use super::roughplastic::RoughPassages;
use super::{Departure, Effect, Matter, Part, Vertex, axis_s, dark};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A diffuse base that sends light back to a surface which keeps some of it inside.
#[derive(Clone, Debug)]
pub(super) struct Base {
    pub(super) reflectance: Spectrum,
    /// Diffuse reflectance of the surface from inside.
    pub(super) inner: f32,
    pub(super) nonlinear: bool,
    /// 1/(π η²)
    pub(super) scale: f32,
}

impl Base {
    /// Reads `diffuse_reflectance`: of a base whose light all leaves.
    pub(super) fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: object.spectrum(
                "diffuse_reflectance",
                SpectrumUse::Reflectance,
                Spectrum::constant(0.5),
            )?,
            inner: 0.0,
            nonlinear: false,
            scale: FRAC_1_PI,
        })
    }

    /// Reads `diffuse_reflectance` and `nonlinear`; `inner` is the diffuse reflectance of the surface from inside.
    pub(super) fn read_under(
        object: &Object,
        surface: &DielectricInterface,
        inner: f64,
    ) -> Result<Self, SceneError> {
        let eta = surface.n_transmitted() / surface.n_incident();
        Ok(Self {
            inner: inner as f32,
            nonlinear: object.boolean("nonlinear", false)?,
            scale: FRAC_1_PI / (eta * eta) as f32,
            ..Self::read(object)?
        })
    }

    /// What it returns to outside between two passages, per steradian and projected solid angle.
    #[inline]
    fn weight(&self, wavelength: f32) -> f32 {
        let r = self.reflectance.value(wavelength);
        let again = if self.nonlinear { r } else { 1.0 };
        r * self.scale / (1.0 - again * self.inner)
    }
}

/// What passes a surface, over the cosine outside.
#[derive(Clone, Debug)]
pub(super) enum Passages {
    /// Fresnel's.
    Smooth,
    /// Those of facets.
    Rough(Box<RoughPassages>),
}

/// A dielectric surface over a diffuse base.
#[derive(Clone, Debug)]
pub(super) struct Coat {
    pub(super) surface: DielectricInterface,
    pub(super) passages: Passages,
    pub(super) base: Base,
    pub(super) reflectance: Spectrum,
}

impl Coat {
    /// Reads `specular_reflectance`.
    pub(super) fn read(
        object: &Object,
        surface: DielectricInterface,
        passages: Passages,
        base: Base,
    ) -> Result<Self, SceneError> {
        Ok(Self {
            surface,
            passages,
            base,
            reflectance: object.factor("specular_reflectance")?,
        })
    }

    /// Passage through the surface, for light that arrives from or leaves to outside at `cos`.
    #[inline]
    fn passage(&self, cos: f32) -> Element {
        match &self.passages {
            Passages::Smooth => self
                .surface
                .transmission(f64::from(cos.min(1.0)))
                .map_or(Element::BLACK, |t| Element::from(t.element)),
            Passages::Rough(table) => table.at(cos),
        }
    }

    /// Probability of drawing the surface rather than the base, by their albedos, at most 0.9 and at least 0.3: the
    /// wavelengths may differ, connections find most of the base's light, and all polarization comes from the surface.
    #[inline]
    pub(super) fn surface_probability(&self, o: Vec3A, wavelengths: &[f32]) -> f32 {
        let r = match &self.passages {
            Passages::Smooth => self.surface.reflection(f64::from(o.z.min(1.0))).mean as f32,
            Passages::Rough(table) => (1.0 - table.at(o.z).mean).max(0.0),
        };
        let surface = r * self.reflectance.value(wavelengths[0]);
        let base = (1.0 - r) * self.base.reflectance.value(wavelengths[0]);
        let share = surface / (surface + base);
        if share.is_nan() {
            0.5
        } else {
            share.clamp(0.3, 0.9)
        }
    }

    /// Reflection where the normal is `h`, for light along `−i`.
    #[inline]
    pub(super) fn mirrored<L: Light>(
        &self,
        h: Vec3A,
        i: Vec3A,
        weight: f32,
        wavelengths: &[f32],
    ) -> L::Response {
        let cos = f64::from(i.dot(h).min(1.0));
        let element = Element::from(self.surface.reflection(cos)).scaled(weight);
        L::diattenuating_retarder(axis_s(h, i), |lane| {
            element.scaled(self.reflectance.value(wavelengths[lane]))
        })
    }

    /// What the base returns, times cos i.
    #[inline]
    pub(super) fn diffuse<L: Light>(&self, o: Vec3A, i: Vec3A, wavelengths: &[f32]) -> L::Response {
        L::depolarizer_between(
            (axis_s(Vec3A::Z, o), self.passage(o.z)),
            |lane| self.base.weight(wavelengths[lane]) * i.z,
            (axis_s(Vec3A::Z, i), self.passage(i.z)),
        )
    }

    /// Whether it does the same to light of all wavelengths of a range, nm.
    pub(super) fn is_grey(&self, range: [f64; 2]) -> bool {
        self.base.reflectance.is_constant_over(range) && self.reflectance.is_constant_over(range)
    }

    /// What it can do to polarization.
    pub(super) fn effect(&self) -> Effect {
        Effect {
            depolarizes: true,
            makes_linear: true,
            // plastic that is thinner matter than its surroundings reflects totally
            retards: self.surface.n_incident() > self.surface.n_transmitted(),
            ..Effect::default()
        }
    }
}

/// A diffuse base under a rough dielectric surface: `pplastic` and `roughplastic`.
#[derive(Clone, Debug)]
pub struct RoughlyCoated {
    pub(super) coat: Coat,
    pub(super) facets: Microfacets,
}

/// Density of a direction drawn with probability `p` from facets, with this density, and else by its cosine.
#[inline]
fn joint_density(p: f32, of_facets: f32, i: Vec3A) -> f32 {
    p * of_facets + (1.0 - p) * i.z * FRAC_1_PI
}

impl Matter for RoughlyCoated {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z <= 0.0 {
            return None;
        }
        let p = self.coat.surface_probability(o, wavelengths);
        let (i, of_facets) = if u[0] < p {
            let (m, density) = self.facets.sample_mirror(o, [u[1], u[2]]);
            (super::mirror(o, m), density)
        } else {
            let i = cosine_hemisphere([u[1], u[2]]);
            (i, self.facets.mirror_density(o, (o + i).normalize()))
        };
        if i.z <= 0.0 {
            return None;
        }
        Departure::continuous(i, joint_density(p, of_facets, i), 1.0)
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
        let (weight, of_facets) = self.facets.mirrored(o, i, h);
        let surface = self.coat.mirrored::<L>(h, i, weight, wavelengths);
        let base = self.coat.diffuse::<L>(o, i, wavelengths);
        let p = self.coat.surface_probability(o, wavelengths);
        (L::sum(surface, base, o, -i), joint_density(p, of_facets, i))
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.coat.is_grey(range)
    }

    fn effect(&self) -> Effect {
        self.coat.effect()
    }
}
