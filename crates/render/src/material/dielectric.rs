//! `dielectric`: a smooth interface between two transparent media, with refraction.
//!
//! | parameter                | type            | meaning                                         | default |
//! |--------------------------|-----------------|-------------------------------------------------|---------|
//! | `int_ior`                | float or string | index on the side opposite to the normal        | `bk7`   |
//! | `ext_ior`                | float or string | index on the side of the normal                 | `air`   |
//! | `specular_reflectance`   | spectrum        | factor on the reflected power (not physical)    | 1       |
//! | `specular_transmittance` | spectrum        | factor on the transmitted power (not physical)  | 1       |
//!
//! ```xml
//! <bsdf type="dielectric"><string name="int_ior" value="water"/></bsdf>
//! ```
//!
//! Both sides. Total internal reflection retards. Radiance that enters a denser medium grows by the squared ratio of
//! the indices.

use glam::Vec3A;
use mueller16::DielectricInterface;

use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, mirror, unknown_name};
use crate::coherence::Coherence;
use crate::ior;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// A smooth dielectric surface.
#[derive(Clone, Debug)]
pub struct Dielectric {
    faces: Faces,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

/// Reads an index of refraction: a number, or the name of a medium.
pub fn read_index(object: &Object, parameter: &str, default: &str) -> Result<f64, SceneError> {
    let index = if object.is_string(parameter) || !object.has(parameter) {
        let name = object.string(parameter, default)?;
        ior::named_dielectric(&name)
            .ok_or_else(|| unknown_name(object, parameter, &name, ior::dielectric_names()))?
    } else {
        object.required_float(parameter)?
    };
    if index > 0.0 && index.is_finite() {
        Ok(index)
    } else {
        Err(object.error_at(
            parameter,
            format!("an index of refraction of {index}, expected a positive number"),
        ))
    }
}

/// The boundary of two clear media, as light from either of them meets it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Faces {
    /// Light that comes from the side of the normal.
    outside: DielectricInterface,
    /// Light that comes from the other side.
    inside: DielectricInterface,
    /// Index inside over index outside.
    eta: f32,
}

impl Faces {
    /// Reads `int_ior`, by default that of a medium, and `ext_ior`.
    pub(super) fn read(object: &Object, default: &str) -> Result<Self, SceneError> {
        let inside = read_index(object, "int_ior", default)?;
        let outside = read_index(object, "ext_ior", "air")?;
        let face = DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?;
        Ok(Self {
            outside: face,
            inside: face.reversed(),
            eta: (inside / outside) as f32,
        })
    }

    /// The face for light on the side of the normal, or on the other.
    #[inline(always)]
    pub(super) fn side(&self, above: bool) -> &DielectricInterface {
        if above { &self.outside } else { &self.inside }
    }

    /// Index on the other side over that on a side.
    #[inline(always)]
    pub(super) fn eta(&self, above: bool) -> f32 {
        if above { self.eta } else { self.eta.recip() }
    }

    /// Indices on the side of the normal and on the other.
    #[inline(always)]
    pub(super) fn indices(&self) -> [f64; 2] {
        [self.outside.n_incident(), self.outside.n_transmitted()]
    }
}

/// The parameter that makes matter glass; `None` where it is a metal.
///
/// # Errors
///
/// Where there are parameters of both.
pub(super) fn glass_parameter(object: &Object) -> Result<Option<&'static str>, SceneError> {
    let given = |names: &[&'static str]| names.iter().copied().find(|name| object.has(name));
    let glass = given(&["int_ior", "ext_ior"]);
    match (given(&["material", "eta", "k"]), glass) {
        (Some(metal), Some(glass)) => Err(object.error_at(
            metal,
            format!("both '{metal}' and '{glass}' are given, expected a metal or glass"),
        )),
        _ => Ok(glass),
    }
}

impl Dielectric {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        Ok(Self {
            faces: Faces::read(object, "bk7")?,
            reflectance: object.factor("specular_reflectance")?,
            transmittance: object.factor("specular_transmittance")?,
        })
    }
}

impl Dielectric {
    /// Indices on the side of the normal and on the other.
    #[inline(always)]
    pub(super) fn indices(&self) -> [f64; 2] {
        self.faces.indices()
    }

    /// Factors on what is reflected and on what is transmitted.
    #[inline(always)]
    pub(super) fn factors(&self) -> [&Spectrum; 2] {
        [&self.reflectance, &self.transmittance]
    }

    /// Where refracted light comes from, and the index there over that on the side of `o`.
    #[inline]
    fn refracted(&self, o: Vec3A) -> Option<(Vec3A, f32)> {
        let cos_o = f64::from(o.z.abs());
        let above = o.z > 0.0;
        let cos_i = self.faces.side(above).transmission(cos_o)?.cos_t as f32;
        let eta = self.faces.eta(above);
        // Snell's law across, the cosine along: normalised once more in single precision
        let i = Vec3A::new(-o.x / eta, -o.y / eta, -cos_i.copysign(o.z)).normalize();
        Some((i, eta))
    }
}

impl Matter for Dielectric {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z == 0.0 {
            return None;
        }
        let cos_o = f64::from(o.z.abs());
        let interface = self.faces.side(o.z > 0.0);
        let reflection = Element::from(interface.reflection(cos_o));
        // in proportion to what the sensor sees of unpolarized light on either way
        let seen = at.sight.along(axis_s(Vec3A::Z, o), o);
        let reflected = (reflection.mean + seen * reflection.difference).clamp(0.0, 1.0);
        if u[0] < reflected {
            return Some(Departure::mirrored(o, reflected));
        }
        let (i, eta) = self.refracted(o)?;
        Some(Departure {
            direction: i,
            density: 1.0 - reflected,
            part: Part::Discrete(1),
            eta,
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
        let axis = axis_s(Vec3A::Z, i);
        let interface = self.faces.side(i.z > 0.0);
        let cos_i = f64::from(i.z.abs());
        let response = if o.z * i.z > 0.0 {
            let element = Element::from(interface.reflection(cos_i));
            L::diattenuating_retarder(axis, |lane| {
                element.scaled(self.reflectance.value(wavelengths[lane]))
            })
        } else {
            // the light comes from the side of `i`: radiance counts by the squared index of its medium
            let eta = self.faces.eta(o.z > 0.0);
            let element = interface.transmission(cos_i).map_or(Element::BLACK, |t| {
                Element::from(t.element).scaled((eta * eta).recip())
            });
            L::diattenuating_retarder(axis, |lane| {
                element.scaled(self.transmittance.value(wavelengths[lane]))
            })
        };
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        match part {
            Part::Discrete(0) => Some(mirror(at.o, Vec3A::Z)),
            _ => self.refracted(at.o).map(|(i, _)| i),
        }
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            chooses: true,
            ..Traits::default()
        }
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
