//! Films, crystal plates and given matrices, as facets of a surface have them.

use csdm::CloudeSpectrum;
use csdm::birefringent::{CrystalLayer, CrystalStack, Incidence, PlateMueller};
use csdm::film::{FilmError, Layer, Stack};
use nalgebra::{Vector3, Vector4};
use num_complex::Complex64;
use stokes::{Frame, Mueller};

use super::boundary::dark;
use super::error::SurfaceError;
use super::facet::{Facet, RayFrames, from_axes};
use crate::geometry::Geometry;

/// Rounding that given matrices may carry.
const ROUNDING: f64 = 1e-9;

/// Isotropic films between a front and a back medium, phases in `exp(+iωt)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    front: f64,
    /// Met from the front.
    stack: Stack,
    /// Index of the back medium and the stack met from there; `None` where it absorbs.
    back: Option<(f64, Stack)>,
}

impl Film {
    /// The films `layers`, the first one in front, between media of index `front` and `back`.
    ///
    /// # Errors
    ///
    /// As [`Stack::new`].
    pub fn new(front: f64, layers: Vec<Layer>, back: Complex64) -> Result<Self, FilmError> {
        let stack = Stack::new(front, layers, back)?;
        let reversed = || Ok::<_, FilmError>((back.re, stack.reversed()?));
        Ok(Self {
            front,
            back: if back.im == 0.0 {
                Some(reversed()?)
            } else {
                None
            },
            stack,
        })
    }

    /// Index of the front and of the back medium, where that does not absorb.
    pub(super) fn indices(&self) -> [Option<f64>; 2] {
        [
            Some(self.front),
            self.back.as_ref().map(|(index, _)| *index),
        ]
    }

    /// The matrix between s–p frames about the facet.
    pub(super) fn mueller(
        &self,
        geometry: &Geometry,
        facet: &Facet,
    ) -> Result<Mueller, SurfaceError> {
        let met = match (&self.back, facet.from_behind) {
            (_, false) => &self.stack,
            (Some((_, stack)), true) => stack,
            (None, true) => return Ok(dark()),
        };
        let amplitudes = met.amplitudes(facet.cos_i, geometry.wavelength());
        if !facet.transmitted {
            return Ok(amplitudes.reflection_mueller());
        }
        if self.back.is_none() {
            return Ok(dark());
        }
        Ok(amplitudes.transmission_mueller()?)
    }
}

/// How the internal reflections of a crystal plate are added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum InternalReflections {
    /// Their fields: thin plates, laser light.
    #[default]
    Coherent,
    /// Their powers, in layers thicker than this many metres.
    Incoherent {
        /// Thickness below which fields are added, m.
        coherent_below: f64,
    },
    /// Not at all: the direct beam.
    SinglePass,
}

/// Crystals between a front and a back medium.
///
/// The crystals' x axis is the surface's first tangent, and their z axis points into the surface, against its normal. On
/// a tilted facet both are turned with the normal.
#[derive(Clone, Debug, PartialEq)]
pub struct CrystalPlate {
    indices: [f64; 2],
    absorbing: bool,
    stack: CrystalStack,
    reflections: InternalReflections,
}

impl CrystalPlate {
    /// The crystals `layers`, the first one in front, between media of index `front` and `back`.
    ///
    /// # Errors
    ///
    /// As [`CrystalStack::new`].
    pub fn new(
        front: f64,
        layers: Vec<CrystalLayer>,
        back: Complex64,
        reflections: InternalReflections,
    ) -> Result<Self, FilmError> {
        Ok(Self {
            indices: [front, back.re],
            absorbing: back.im != 0.0,
            stack: CrystalStack::new(front, layers, back)?,
            reflections,
        })
    }

    /// Index of the front and of the back medium, where that does not absorb.
    pub(super) fn indices(&self) -> [Option<f64>; 2] {
        let [front, back] = self.indices;
        [Some(front), (!self.absorbing).then_some(back)]
    }

    /// The matrix between s–p frames about the facet.
    pub(super) fn mueller(
        &self,
        geometry: &Geometry,
        facet: &Facet,
    ) -> Result<Mueller, SurfaceError> {
        let (cosine, sine) = if facet.from_behind {
            let [front, back] = self.indices;
            let sine = back / front * facet.sin_i;
            let squared = (1.0 - sine) * (1.0 + sine);
            if squared <= 0.0 && facet.transmitted {
                return Ok(dark());
            }
            if squared < 0.0 {
                return Err(SurfaceError::CrystalFromBehind {
                    cosine: facet.cos_i,
                });
            }
            (squared.sqrt(), sine)
        } else {
            (facet.cos_i, facet.sin_i)
        };
        let incidence = Incidence::with_sine(cosine, sine, facet.azimuth(geometry))?;
        let wavelength = geometry.wavelength();
        let jones = match self.reflections {
            InternalReflections::Incoherent { coherent_below } => {
                let PlateMueller { front, back } =
                    self.stack
                        .incoherent(&incidence, wavelength, coherent_below)?;
                let side = if facet.from_behind { back } else { Some(front) };
                return Ok(side.map_or(dark(), |side| {
                    if facet.transmitted {
                        side.transmission
                    } else {
                        side.reflection
                    }
                }));
            }
            InternalReflections::Coherent => self.stack.coherent(&incidence, wavelength),
            InternalReflections::SinglePass => self.stack.single_pass(&incidence, wavelength),
        };
        let side = if facet.from_behind {
            jones.back
        } else {
            Some(jones.front)
        };
        match side {
            None => Ok(dark()),
            Some(side) if !facet.transmitted => Ok(side.reflection_mueller()),
            Some(_) if self.absorbing => Ok(dark()),
            Some(side) => Ok(side.transmission_mueller()?),
        }
    }
}

/// A flat element with given matrices: polarizing, depolarizing, measured.
///
/// They are written in frames whose x axis is the surface's first tangent projected across each ray (the normal projected,
/// for a ray along that tangent), and do not depend on the angle of incidence. From behind light is reflected by the same
/// matrix and transmitted by the reversed one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneElement {
    reflection: Mueller,
    transmission: Mueller,
}

impl PlaneElement {
    /// The element that reflects and transmits so.
    ///
    /// An ideal polarizer: nothing is reflected, and the field along the first tangent passes.
    /// ```
    /// use mueller16::PlaneElement;
    /// use stokes::Mueller;
    /// let polarizer = mueller16::element::linear_polarizer().to_mueller();
    /// assert!(PlaneElement::new(&Mueller::depolarizer(0.0), &polarizer).is_ok());
    /// // with a reflection of the same light it would double its power
    /// assert!(PlaneElement::new(&polarizer, &polarizer).is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// When no ensemble of Jones matrices has a matrix, both together pass more power than comes, or the matrix of
    /// reflection is not its own reversed one (to 1e-9 each).
    pub fn new(reflection: &Mueller, transmission: &Mueller) -> Result<Self, SurfaceError> {
        for (what, mueller) in [("reflection", reflection), ("transmission", transmission)] {
            CloudeSpectrum::of(mueller)
                .and_then(|spectrum| spectrum.check_realizable(ROUNDING))
                .map_err(|reason| SurfaceError::NotRealizable { what, reason })?;
        }
        if let Some(error) = SurfaceError::not_reciprocal(reflection, ROUNDING) {
            return Err(error);
        }
        let both_sides = [*transmission, transmission.reversed()];
        for passed in both_sides {
            let row: Vector4<f64> = (reflection.to_matrix() + passed.to_matrix())
                .row(0)
                .transpose();
            let power = row[0] + Vector3::new(row[1], row[2], row[3]).norm();
            if power.is_nan() || power > 1.0 + ROUNDING {
                return Err(SurfaceError::Active { power });
            }
        }
        Ok(Self {
            reflection: *reflection,
            transmission: *transmission,
        })
    }

    pub(super) fn mueller(
        &self,
        geometry: &Geometry,
        facet: &Facet,
        frames: &RayFrames,
    ) -> Mueller {
        let axis = |frame: &Frame| {
            let [t1, _] = geometry.tangents();
            let across = t1.cross(&frame.z()).norm();
            if across < 1e-12 {
                geometry.normal()
            } else {
                t1
            }
        };
        let mueller = match (facet.transmitted, facet.from_behind) {
            (false, _) => self.reflection,
            (true, false) => self.transmission,
            (true, true) => self.transmission.reversed(),
        };
        let axes = [axis(&frames.incident), axis(&frames.outgoing)];
        from_axes(&mueller, axes, frames)
    }
}
