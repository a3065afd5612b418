//! `birefringent`: a crystal plate, a stretched film or a liquid-crystal cell with the same medium on both sides.
//!
//! | parameter               | type          | meaning                                                        | default |
//! |-------------------------|---------------|----------------------------------------------------------------|---------|
//! | `thickness`             | string, float | `0.2mm`, or metres                                             | –       |
//! | `no`, `ne`              | string, float, spectrum | ordinary and extraordinary index of a uniaxial crystal: a number, a name (`quartz_o`), a table | – |
//! | `n1`, `n2`, `n3`        | the same      | principal indices of a biaxial crystal, instead of `no`, `ne`  | –       |
//! | `axis`                  | vector        | optic axis, or the axis of `n1`; in (U, V, normal)             | 1, 0, 0 |
//! | `axis2`                 | vector        | the axis of `n2` (its part across `axis`)                      | 0, 1, 0 |
//! | `twist`                 | float         | degrees by which the axes turn from the back face to the front, from U toward V | 0 |
//! | `ext_ior`               | float, string | index on both sides; the plate's own: no reflections           | `air`   |
//! | `reflections`           | string        | internal ones: `single` (none: the direct light), `incoherent` (powers add), `coherent` (fields add) | `incoherent` |
//! | `wedge`, `wedge_origin` | vector, point | 1/m, m: the thickness grows by `1 + wedge·(x − wedge_origin)`, world | 0 |
//!
//! ```xml
//! <bsdf type="birefringent">
//!     <string name="thickness" value="1mm"/>
//!     <string name="no" value="calcite_o"/><string name="ne" value="calcite_e"/>
//!     <vector name="axis" x="0" y="0" z="1"/>
//! </bsdf>
//! ```
//!
//! Both sides. Light goes straight through, the small shifts of the ordinary and the extraordinary image left out, with
//! the exact retardance and Fresnel losses of its direction; the rest is reflected. `coherent` shows the fringes of
//! the faces, which lamps show in thin films only. A twisted plate is a stack of slices of at most 10 degrees.
//!
//! Maxwell's equations are solved at every vertex and wavelength: a few microseconds for `single` and clear uniaxial crystals,
//! up to tens of microseconds for others, longer than all else on a path.
//!
//! Source: Berreman, J. Opt. Soc. Am. 62, 502 (1972), as solved by `csdm::birefringent`.

use std::borrow::Cow;
use std::sync::OnceLock;

use csdm::birefringent::{
    Crystal, CrystalError, CrystalLayer, CrystalStack, Incidence, JonesSide, PlateMueller,
};
use glam::{DVec3, Mat4, Vec3A};
use mueller16::DielectricInterface;
use nalgebra::Vector3;
use stokes::{Mueller, Wavelength};

use super::dielectric::read_index;
use super::index::Index;
use super::wedge::Wedge;
use super::{Departure, Effect, Matter, Part, Traits, Vertex, mirror, narrowed};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::scene::{Object, SceneError};

/// Largest turn of the axes within one slice of a twisted plate, degrees.
const SLICE: f64 = 10.0;

/// Neither way is taken less often than this.
const LEAST_CHOICE: f32 = 1e-3;

/// What becomes of light that the faces reflect inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reflections {
    Single,
    Incoherent,
    Coherent,
}

/// A crystal plate.
#[derive(Clone, Debug)]
pub struct Birefringent {
    indices: [Index; 3],
    axes: [Vector3<f64>; 2],
    thickness: f64,
    /// Radians, from the back face to the front.
    twist: f64,
    slices: u32,
    outside: f64,
    reflections: Reflections,
    wedge: Option<Wedge>,
    /// Whether the indices are the same at all wavelengths.
    constant: bool,
    /// The first wavelength that was asked for, and the plate there: in light of one wavelength the only one.
    kept: OnceLock<(f32, Option<CrystalStack>)>,
}

impl Birefringent {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let thickness = object.positive_length("thickness")?.ok_or_else(|| {
            object.error(
                "bsdf 'birefringent' has no parameter 'thickness', expected a length such as '0.2mm'",
            )
        })?;
        let twist = object.float("twist", 0.0)?;
        if twist.abs() > 3600.0 {
            return Err(object.error_at(
                "twist",
                format!("a twist of {twist} degrees, expected at most ten turns"),
            ));
        }
        let reflections = object.choice(
            "reflections",
            "incoherent",
            &["single", "incoherent", "coherent"],
        )?;
        let reflections = match reflections.as_str() {
            "single" => Reflections::Single,
            "coherent" => Reflections::Coherent,
            _ => Reflections::Incoherent,
        };
        let indices = read_indices(object)?;
        Ok(Self {
            constant: indices.iter().all(Index::is_constant),
            indices,
            axes: read_axes(object)?,
            thickness,
            twist: twist.to_radians(),
            slices: (twist.abs() / SLICE).ceil().max(1.0) as u32,
            outside: read_index(object, "ext_ior", "air")?,
            reflections,
            wedge: Wedge::read(object)?,
            kept: OnceLock::new(),
        })
    }

    /// The plate at one wavelength, where its thickness is that of the scene file.
    fn stack(&self, wavelength: f32) -> Option<CrystalStack> {
        let indices = self.indices.each_ref().map(|index| index.at(wavelength));
        let crystal = Crystal::biaxial(indices, self.axes[0], self.axes[1]).ok()?;
        let count = f64::from(self.slices);
        let layers = (0..self.slices).map(|slice| CrystalLayer {
            crystal: if self.twist == 0.0 {
                crystal.clone()
            } else {
                crystal.turned(self.twist * (f64::from(slice) + 0.5) / count)
            },
            thickness: self.thickness / count,
        });
        CrystalStack::new(self.outside, layers.collect(), self.outside.into()).ok()
    }

    /// The plate at one wavelength and place; the same whichever wavelength was first.
    fn stack_at(&self, wavelength: f32, position: Vec3A) -> Option<Cow<'_, CrystalStack>> {
        let (first, kept) = self
            .kept
            .get_or_init(|| (wavelength, self.stack(wavelength)));
        let stack = if self.constant || *first == wavelength {
            Cow::Borrowed(kept.as_ref()?)
        } else {
            Cow::Owned(self.stack(wavelength)?)
        };
        let Some(wedge) = self.wedge else {
            return Some(stack);
        };
        stack.thickened(wedge.factor(position)).ok().map(Cow::Owned)
    }

    /// Mueller matrix for light from local `i`, in the frames of [`axis_across`].
    fn mueller(&self, at: &Vertex, i: Vec3A, wavelength: f32, reflects: bool) -> Option<Mueller> {
        let k = -i.as_dvec3().normalize();
        let (s, sine) = axis_across(k);
        let (cosine, sine) = (k.z.abs().min(1.0), sine.min(1.0));
        let incidence = Incidence::with_sine(cosine, sine, s.y.atan2(s.x)).ok()?;
        let light = Wavelength::from_metres(f64::from(wavelength) * 1e-9).ok()?;
        let stack = self.stack_at(wavelength, at.position)?;
        let forward = k.z > 0.0;
        let of_jones = |side: JonesSide| {
            if reflects {
                Some(side.reflection_mueller())
            } else {
                side.transmission_mueller().ok()
            }
        };
        let of_plate = |plate: csdm::birefringent::PlateJones| {
            if forward {
                of_jones(plate.front)
            } else {
                plate.back.and_then(of_jones)
            }
        };
        match self.reflections {
            Reflections::Single => of_plate(stack.single_pass(&incidence, light)),
            Reflections::Coherent => of_plate(stack.coherent(&incidence, light)),
            Reflections::Incoherent => {
                let PlateMueller { front, back } = stack.incoherent(&incidence, light, 0.0).ok()?;
                let side = if forward { Some(front) } else { back };
                side.map(|side| {
                    if reflects {
                        side.reflection
                    } else {
                        side.transmission
                    }
                })
            }
        }
    }

    /// About how much of the light an isotropic plate of the same mean index reflects.
    fn reflected_share(&self, cos_i: f32, wavelength: f32) -> f32 {
        let mean = self
            .indices
            .iter()
            .map(|n| n.at(wavelength).re)
            .sum::<f64>()
            / 3.0;
        let face = DielectricInterface::new(self.outside, mean)
            .map_or(0.0, |face| face.reflection(f64::from(cos_i)).mean as f32);
        let share = match self.reflections {
            Reflections::Single => face / (face + (1.0 - face) * (1.0 - face)),
            _ => 2.0 * face / (1.0 + face),
        };
        share.clamp(LEAST_CHOICE, 1.0 - LEAST_CHOICE)
    }
}

/// Indices along the axis of n1, of n2, and across both.
fn read_indices(object: &Object) -> Result<[Index; 3], SceneError> {
    let uniaxial = ["no", "ne"].map(|name| object.has(name));
    let biaxial = ["n1", "n2", "n3"].map(|name| object.has(name));
    let read = |name| Index::read(object, name, "");
    match (uniaxial, biaxial) {
        ([true, true], [false, false, false]) => {
            let (ordinary, extraordinary) = (read("no")?, read("ne")?);
            Ok([extraordinary, ordinary.clone(), ordinary])
        }
        ([false, false], [true, true, true]) => Ok([read("n1")?, read("n2")?, read("n3")?]),
        _ => Err(object.error(
            "the indices of bsdf 'birefringent' are not complete, expected either 'no' and 'ne', or 'n1', 'n2' \
             and 'n3'",
        )),
    }
}

/// The axis of n1, and one that lies with it in the plane of the axis of n2.
fn read_axes(object: &Object) -> Result<[Vector3<f64>; 2], SceneError> {
    let uniaxial = object.has("no");
    let first = Vector3::from(object.optional_vector("axis")?.unwrap_or([1.0, 0.0, 0.0]));
    if first.norm() == 0.0 {
        return Err(object.error_at(
            "axis",
            "the axis of bsdf 'birefringent' is (0, 0, 0), expected a vector of some length, in (U, V, normal)",
        ));
    }
    let second = if uniaxial {
        // any vector across serves
        first.cross(&Vector3::ith(first.iamin(), 1.0))
    } else {
        Vector3::from(object.optional_vector("axis2")?.unwrap_or([0.0, 1.0, 0.0]))
    };
    match Crystal::biaxial([1.5.into(); 3], first, second) {
        Ok(_) => Ok([first, second]),
        Err(CrystalError::Axes { .. }) => Err(object.error_at(
            if object.has("axis2") { "axis2" } else { "axis" },
            format!(
                "'axis' ({}, {}, {}) and 'axis2' ({}, {}, {}) of bsdf 'birefringent' span no plane, expected two \
                 vectors that are not parallel",
                first.x, first.y, first.z, second.x, second.y, second.z
            ),
        )),
        Err(error) => Err(object.error(error)),
    }
}

impl Matter for Birefringent {
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z == 0.0 {
            return None;
        }
        let reflected = self.reflected_share(o.z.abs().min(1.0), wavelengths[0]);
        Some(if u[0] < reflected {
            Departure::mirrored(o, reflected)
        } else {
            Departure::straight(o, 1.0 - reflected)
        })
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
        let axis = axis_across(-i.as_dvec3().normalize()).0.as_vec3a();
        let response = L::general(axis, axis, |lane| {
            self.mueller(at, i, wavelengths[lane], reflects)
                .map_or(Mat4::ZERO, |m| narrowed(&m))
        });
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        Some(match part {
            Part::Discrete(_) => mirror(at.o, Vec3A::Z),
            _ => -at.o,
        })
    }

    fn effect(&self) -> Effect {
        // a face polarizes, the plate behind it retards: one vertex does it all
        Effect {
            depolarizes: self.reflections == Reflections::Incoherent,
            makes_linear: true,
            makes_circular: true,
            retards: true,
        }
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: true,
            ..Traits::default()
        }
    }

    fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        self.indices.iter().try_for_each(|index| index.check(range))
    }
}

/// The s axis of light along `k`, in the faces, and the sine of its angle to the normal.
///
/// `s = t × normal` with t the direction of travel along the faces; any axis for light along the normal.
#[inline]
fn axis_across(k: DVec3) -> (DVec3, f64) {
    let sine = k.truncate().length();
    if sine > 0.0 {
        (DVec3::new(k.y / sine, -k.x / sine, 0.0), sine)
    } else {
        (DVec3::X, 0.0)
    }
}

#[cfg(test)]
mod tests;
