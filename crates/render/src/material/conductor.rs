//! `conductor`: a smooth metal mirror.
//!
//! | parameter              | type     | meaning                                                    | default |
//! |------------------------|----------|------------------------------------------------------------|---------|
//! | `material`             | string   | a named metal (`Au`, `Ag`, `Cu`, …) instead of `eta`, `k`   | –       |
//! | `eta`, `k`             | spectrum | index of refraction η − i k against the medium outside      | 0, 1    |
//! | `specular_reflectance` | spectrum | factor on the reflected power (not physical)               | 1       |
//!
//! ```xml
//! <bsdf type="conductor"><string name="material" value="Ag"/></bsdf>
//! ```
//!
//! The default (η = 0, k = 1) reflects all power but is a retarder away from normal incidence; `material="none"` is
//! the same. One-sided.

use glam::Vec3A;
use mueller16::ConductorInterface;

use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, mirror, unknown_name};
use crate::coherence::Coherence;
use crate::ior;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// Complex index and reflectance factor of a metal, by wavelength.
#[derive(Clone, Debug)]
pub struct Metal {
    eta: Spectrum,
    k: Spectrum,
    reflectance: Spectrum,
    /// The interface, if the index is the same at every wavelength.
    fixed: Option<ConductorInterface>,
}

/// The surface of a metal in vacuum; `None` where a table's index is zero, outside its wavelengths.
#[inline]
fn interface(eta: f32, k: f32) -> Option<ConductorInterface> {
    ConductorInterface::new(1.0, f64::from(eta), f64::from(k)).ok()
}

impl Metal {
    /// Index η − ik, and the factor on the power.
    #[inline(always)]
    pub(super) fn spectra(&self) -> [&Spectrum; 3] {
        [&self.eta, &self.k, &self.reflectance]
    }

    /// Whether it reflects all wavelengths of a range, nm, in the same way.
    pub(super) fn is_grey(&self, range: [f64; 2]) -> bool {
        [&self.eta, &self.k, &self.reflectance]
            .iter()
            .all(|spectrum| spectrum.is_constant_over(range))
    }

    /// Reads `material` or `eta` and `k`, and `specular_reflectance`.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let (eta, k) = match object.optional_string("material")? {
            Some(_) if object.has("eta") || object.has("k") => {
                return Err(object.error_at(
                    "material",
                    "both 'material' and 'eta', 'k' are given, expected one of them",
                ));
            }
            Some(name) => ior::named_conductor(&name)
                .ok_or_else(|| unknown_name(object, "material", &name, ior::conductor_names()))?,
            None => (
                object.spectrum("eta", SpectrumUse::Unbounded, Spectrum::constant(0.0))?,
                object.spectrum("k", SpectrumUse::Unbounded, Spectrum::constant(1.0))?,
            ),
        };
        let reflectance = object.factor("specular_reflectance")?;
        let fixed = (eta.is_constant() && k.is_constant())
            .then(|| interface(eta.value(0.0), k.value(0.0)))
            .flatten();
        Ok(Self {
            eta,
            k,
            reflectance,
            fixed,
        })
    }

    /// Reflection at an angle of incidence, at one wavelength; first axis perpendicular to the plane of incidence.
    #[inline]
    pub fn reflection(&self, cos_i: f32, wavelength: f32) -> Element {
        let at = |wavelength| interface(self.eta.value(wavelength), self.k.value(wavelength));
        match self.fixed.or_else(|| at(wavelength)) {
            Some(interface) => Element::from(interface.reflection(f64::from(cos_i)))
                .scaled(self.reflectance.value(wavelength)),
            None => Element::BLACK,
        }
    }
}

/// A smooth metal surface.
#[derive(Clone, Debug)]
pub struct Conductor {
    metal: Metal,
}

impl Conductor {
    /// What it is made of.
    #[inline(always)]
    pub(super) fn metal(&self) -> &Metal {
        &self.metal
    }

    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            metal: Metal::read(object)?,
        })
    }
}

impl Matter for Conductor {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], _: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        (o.z > 0.0).then(|| Departure::mirrored(o, 1.0))
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        _: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let response = L::diattenuating_retarder(axis_s(Vec3A::Z, i), |lane| {
            self.metal.reflection(i.z, wavelengths[lane])
        });
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, _: Part, _: &[f32]) -> Option<Vec3A> {
        (at.o.z > 0.0).then(|| mirror(at.o, Vec3A::Z))
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.metal.is_grey(range)
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            ..Traits::default()
        }
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }
}
