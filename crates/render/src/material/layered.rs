//! `layered`: thin films on metal or glass, or free in the air, with the interference of all their reflections.
//!
//! | parameter                | type                  | meaning                                                     | default |
//! |--------------------------|-----------------------|-------------------------------------------------------------|---------|
//! | `thickness`              | string or float       | of each film, outermost first: `100nm, 60nm`                 | none: no films |
//! | `ior`                    | string, float, spectrum | index of each film: `1.46, TiO2`; a number, `2-0.5i`, a name, or a table in a file | – |
//! | `int_ior`                | the same, one         | substrate, on the side opposite to the normal               | free film: `ext_ior` again |
//! | `ext_ior`                | float or string       | index on the side of the normal                             | `air`   |
//! | `wedge`, `wedge_origin`  | vector, point         | 1/m, m: thicknesses grow by `1 + wedge·(x − wedge_origin)`, world | 0 |
//! | `specular_reflectance`   | spectrum              | factor on the reflected power (not physical)                | 1       |
//! | `specular_transmittance` | spectrum              | factor on the transmitted power (not physical)              | 1       |
//!
//! ```xml
//! <bsdf type="layered">
//!     <string name="thickness" value="120nm"/><string name="ior" value="2.3"/><string name="int_ior" value="Nb"/>
//! </bsdf>
//! ```
//!
//! A free film lets the rest of the light straight through. A transparent substrate refracts it, as `dielectric` does,
//! and is met from both sides; a substrate that absorbs is opaque, and the matter one-sided. The fields of plane waves
//! are summed exactly: the light must stay coherent over the films, as that of lamps does over a few micrometres.
//!
//! Source: Born & Wolf, Principles of Optics, 7th ed., section 1.6.

use csdm::film::{Layer, Stack, StackAmplitudes};
use glam::Vec3A;
use num_complex::Complex64;
use stokes::{DiattenuatingRetarder, Wavelength};

use super::dielectric::read_index;
use super::index::Index;
use super::wedge::Wedge;
use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// Neither way is taken less often than this where both are open.
const LEAST_CHOICE: f32 = 1e-3;

/// What is behind the films.
#[derive(Clone, Debug)]
enum Substrate {
    /// The medium before them.
    Free,
    /// A transparent medium.
    Clear(Index),
    /// A medium that absorbs.
    Opaque(Index),
}

/// A stack of thin films.
#[derive(Clone, Debug)]
pub struct Layered {
    films: Vec<(Index, f64)>,
    outside: f64,
    substrate: Substrate,
    wedge: Option<Wedge>,
    /// From outside and from inside, where they are the same at all wavelengths and places.
    fixed: Option<[Stack; 2]>,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl Layered {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let films = read_films(object)?;
        let outside = read_index(object, "ext_ior", "air")?;
        let substrate = if object.has("int_ior") {
            let index = Index::read(object, "int_ior", "")?;
            match (index.absorbs(), index.is_constant()) {
                (true, _) => Substrate::Opaque(index),
                (false, true) if index.at(550.0).re == outside => Substrate::Free,
                (false, _) => Substrate::Clear(index),
            }
        } else if films.is_empty() {
            return Err(object.error(
                "bsdf 'layered' has neither films nor a substrate, expected 'thickness' and 'ior', or 'int_ior'",
            ));
        } else {
            Substrate::Free
        };
        let mut layered = Self {
            films,
            outside,
            substrate,
            wedge: Wedge::read(object)?,
            fixed: None,
            reflectance: object.factor("specular_reflectance")?,
            transmittance: object.factor("specular_transmittance")?,
        };
        let constant = match &layered.substrate {
            Substrate::Free => true,
            Substrate::Clear(index) | Substrate::Opaque(index) => index.is_constant(),
        };
        if constant && layered.wedge.is_none() && layered.films.iter().all(|f| f.0.is_constant()) {
            let stack = |from_outside| layered.stack(from_outside, 550.0, 1.0);
            layered.fixed = stack(true).map(|front| {
                // an opaque substrate has no other side
                let back = stack(false).unwrap_or_else(|| front.clone());
                [front, back]
            });
        }
        Ok(layered)
    }

    /// Whether nothing passes, and light meets it from one side only.
    pub fn is_opaque(&self) -> bool {
        matches!(self.substrate, Substrate::Opaque(_))
    }

    /// The stack as light from one side meets it.
    fn stack(&self, from_outside: bool, wavelength: f32, factor: f64) -> Option<Stack> {
        let layer = |(index, thickness): &(Index, f64)| Layer {
            index: index.at(wavelength),
            thickness: thickness * factor,
        };
        let inside = self.inside(wavelength);
        if from_outside {
            let layers = self.films.iter().map(layer).collect();
            return Stack::new(self.outside, layers, inside).ok();
        }
        let layers = self.films.iter().rev().map(layer).collect();
        if inside.im != 0.0 {
            return None;
        }
        Stack::new(inside.re, layers, self.outside.into()).ok()
    }

    #[inline]
    fn inside(&self, wavelength: f32) -> Complex64 {
        match &self.substrate {
            Substrate::Free => self.outside.into(),
            Substrate::Clear(index) | Substrate::Opaque(index) => index.at(wavelength),
        }
    }

    /// Amplitudes for light from the side of local `i`; `None` for light that cannot be.
    #[inline]
    fn amplitudes(&self, i: Vec3A, position: Vec3A, wavelength: f32) -> Option<StackAmplitudes> {
        let cos_i = f64::from(i.z.abs().min(1.0));
        let from_outside = i.z > 0.0;
        let light = Wavelength::from_metres(f64::from(wavelength) * 1e-9).ok()?;
        if let Some([front, back]) = &self.fixed {
            let stack = if from_outside { front } else { back };
            return Some(stack.amplitudes(cos_i, light));
        }
        let factor = self.wedge.map_or(1.0, |wedge| wedge.factor(position));
        let stack = self.stack(from_outside, wavelength, factor)?;
        Some(stack.amplitudes(cos_i, light))
    }

    /// Index on the side of `i` over that on the side of `o`, for light that passes toward `o`.
    #[inline]
    fn eta(&self, o: Vec3A, wavelength: f32) -> f32 {
        let eta = match &self.substrate {
            Substrate::Clear(index) => (index.at(wavelength).re / self.outside) as f32,
            _ => 1.0,
        };
        if o.z > 0.0 { eta } else { eta.recip() }
    }

    /// Where light that passes toward `o` comes from; `None` where nothing can.
    #[inline]
    fn refracted(&self, o: Vec3A, wavelength: f32) -> Option<(Vec3A, f32)> {
        match &self.substrate {
            Substrate::Free => Some((-o, 1.0)),
            Substrate::Opaque(_) => None,
            Substrate::Clear(_) => {
                let eta = self.eta(o, wavelength);
                let (x, y) = (-o.x / eta, -o.y / eta);
                let square = 1.0 - x * x - y * y;
                (square > 0.0).then(|| {
                    let z = -square.sqrt().copysign(o.z);
                    (Vec3A::new(x, y, z).normalize(), eta)
                })
            }
        }
    }

    /// How often to look for what the films reflect.
    ///
    /// Before glass and such, the share of unpolarized light that is reflected, of all that is not absorbed. Free
    /// films reflect a few percent, and are made to be looked at: the share of the square roots, which is best where one
    /// of the two sides is dark and nobody knows which.
    fn reflected_share(&self, at: &Vertex, wavelengths: &[f32]) -> f32 {
        let (mut reflected, mut passed) = (0.0, 0.0);
        for &wavelength in wavelengths {
            // by reciprocity the same as for light that comes from where it is seen
            if let Some(a) = self.amplitudes(at.o, at.position, wavelength) {
                reflected += a.reflectance().iter().sum::<f64>();
                passed += a.transmittance().iter().sum::<f64>();
            }
        }
        if matches!(self.substrate, Substrate::Free) {
            (reflected, passed) = (reflected.sqrt(), passed.sqrt());
        }
        let share = (reflected / (reflected + passed)) as f32;
        if share.is_finite() {
            share.clamp(LEAST_CHOICE, 1.0 - LEAST_CHOICE)
        } else {
            0.5
        }
    }
}

/// Index and thickness of the films, outermost first.
fn read_films(object: &Object) -> Result<Vec<(Index, f64)>, SceneError> {
    let thicknesses = object.micro_lengths("thickness")?;
    for (i, thickness) in thicknesses.iter().enumerate() {
        if *thickness <= 0.0 {
            return Err(object.error_at(
                "thickness",
                format!(
                    "film {} of bsdf 'layered' has a thickness of {thickness} m, expected a positive length; leave \
                     the film out if there is none",
                    i + 1
                ),
            ));
        }
    }
    let indices = if object.is_string("ior") {
        let texts = object.texts("ior")?;
        let read = texts.iter().map(|text| Index::of_text(object, "ior", text));
        read.collect::<Result<Vec<_>, _>>()?
    } else if object.has("ior") {
        vec![Index::read(object, "ior", "")?]
    } else {
        // asked for all the same, so that it is a known name
        object.texts("ior")?;
        Vec::new()
    };
    if indices.len() != thicknesses.len() {
        let place = if object.has("thickness") {
            "thickness"
        } else {
            "ior"
        };
        return Err(object.error_at(
            place,
            format!(
                "bsdf 'layered' has {} in 'thickness' and {} in 'ior', expected one of each for every film",
                counted(thicknesses.len(), "length", "lengths"),
                counted(indices.len(), "index", "indices")
            ),
        ));
    }
    Ok(indices.into_iter().zip(thicknesses).collect())
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

impl Matter for Layered {
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z == 0.0 || (self.is_opaque() && o.z < 0.0) {
            return None;
        }
        let passed = self.refracted(o, wavelengths[0]);
        let reflected = match passed {
            Some(_) => self.reflected_share(at, wavelengths),
            None => 1.0,
        };
        match passed {
            Some((direction, eta)) if u[0] >= reflected => Some(Departure {
                direction,
                density: 1.0 - reflected,
                part: match self.substrate {
                    Substrate::Free => Part::Straight,
                    _ => Part::Discrete(1),
                },
                eta,
            }),
            _ => Some(Departure::mirrored(o, reflected)),
        }
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let reflects = at.o.z * i.z > 0.0;
        let response = L::diattenuating_retarder(axis_s(Vec3A::Z, i), |lane| {
            let wavelength = wavelengths[lane];
            let Some(a) = self.amplitudes(i, at.position, wavelength) else {
                return Element::BLACK;
            };
            if reflects {
                return Element::from(DiattenuatingRetarder::from_amplitudes(
                    a.reflected.s,
                    a.reflected.p,
                ))
                .scaled(self.reflectance.value(wavelength));
            }
            // radiance counts by the squared index; both polarizations have the same weight in clear media
            let eta = self.eta(at.o, wavelength);
            let weight = a.power_weight[0] as f32 / (eta * eta);
            if !weight.is_finite() {
                return Element::BLACK;
            }
            Element::from(DiattenuatingRetarder::from_amplitudes(
                a.transmitted.s,
                a.transmitted.p,
            ))
            .scaled(weight * self.transmittance.value(wavelength))
        });
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, part: Part, wavelengths: &[f32]) -> Option<Vec3A> {
        match part {
            Part::Discrete(0) => Some(mirror(at.o, Vec3A::Z)),
            _ => self.refracted(at.o, wavelengths[0]).map(|(i, _)| i),
        }
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: matches!(self.substrate, Substrate::Free),
            disperses: matches!(&self.substrate, Substrate::Clear(index) if !index.is_constant()),
            ..Traits::default()
        }
    }

    fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        for (index, _) in &self.films {
            index.check(range)?;
        }
        match &self.substrate {
            Substrate::Free => Ok(()),
            Substrate::Clear(index) | Substrate::Opaque(index) => index.check(range),
        }
    }
}

#[cfg(test)]
mod tests;
