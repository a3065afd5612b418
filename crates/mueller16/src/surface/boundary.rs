//! What a facet of a surface does to polarization.

use stokes::{DiattenuatingRetarder, Mueller};

use super::error::SurfaceError;
use super::facet::{Facet, RayFrames};
use super::layers::{CrystalPlate, Film, PlaneElement};
use crate::geometry::Geometry;
use crate::interface::{ConductorInterface, DielectricInterface};

/// Relative difference of two indices that are meant to be one.
const SAME_INDEX: f64 = 1e-9;

/// What stands at every facet of a surface: the front medium is on the side of the surface's normal.
///
/// ```text
/// M(h),  h = φ/|φ|        the facet that reflects or refracts the source's direction into the observer's
/// ```
///
/// Matrices act on power: transmission holds `n_o|o·h|/(n_i|i·h|)`, and the `(n_o/n_i)²` of radiance is not in them. They
/// vanish where the facet would be met from its back on either side, and where it reflects totally.
#[derive(Clone, Debug, PartialEq)]
pub enum Boundary {
    /// Between two transparent media, the incident one in front.
    Dielectric(DielectricInterface),
    /// A metal behind a transparent medium. Nothing passes, and nothing comes from behind.
    Conductor(ConductorInterface),
    /// Isotropic films, the same on every facet.
    Film(Film),
    /// Crystals, turned with every facet.
    Crystal(CrystalPlate),
    /// Given matrices.
    Element(PlaneElement),
    /// Reflects everything on both sides and passes nothing: `diag(1, 1, −1, −1)` in s and p, a half-wave plate as
    /// `r_p = −r_s` of every metal at normal incidence.
    Mirror,
    /// Refracts everything on both sides and reflects nothing: the unit matrix in s and p. Where no facet refracts, as
    /// beyond the critical angle, nothing passes.
    Window,
}

impl Boundary {
    /// The Mueller matrix of reflection or transmission at the facet `h = φ/|φ|` of an encounter, written between the
    /// given frames.
    ///
    /// Dimensionless; acts on power. Stable at normal incidence, where the plane of incidence is undefined, and in mirror
    /// and Snell directions. Between media of equal index nothing is deflected, and every transmission but the exactly
    /// straight one vanishes.
    ///
    /// Source: Fresnel's equations at the half vector, Walter et al. 2007, Microfacet Models for Refraction through Rough
    /// Surfaces, Eqs. (13), (16), with polarization.
    ///
    /// # Errors
    ///
    /// When a frame is that of another ray or the geometry's indices are not the boundary's.
    ///
    /// Brewster's angle: only s-light is reflected, 14.8 % of it
    /// ```
    /// use mueller16::{DielectricInterface, Geometry, Boundary, RayFrames};
    /// use nalgebra::Vector3;
    /// let glass = Boundary::Dielectric(DielectricInterface::new(1.0, 1.5)?);
    /// let (sin, cos) = 1.5f64.atan().sin_cos();
    /// let green = stokes::Wavelength::from_metres(550e-9)?;
    /// let mirror = Geometry::on_plane(Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos), green)?;
    /// let m = glass.mueller(&mirror, &RayFrames::of_surface(&mirror)?)?;
    /// assert!((m.element(0, 0) - 0.0739645).abs() < 1e-7 && (m.element(0, 1) - m.element(0, 0)).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mueller(
        &self,
        geometry: &Geometry,
        frames: &RayFrames,
    ) -> Result<Mueller, SurfaceError> {
        frames.check(geometry)?;
        self.check_media(geometry)?;
        match Facet::between(geometry, frames) {
            Some(facet) => self.at(&facet, geometry, frames),
            None => Ok(dark()),
        }
    }

    /// The same at the surface's own normal, for a mirror or a Snell pair.
    pub(super) fn mueller_of_plane(
        &self,
        geometry: &Geometry,
        frames: &RayFrames,
    ) -> Result<Mueller, SurfaceError> {
        frames.check(geometry)?;
        self.check_media(geometry)?;
        match Facet::along(geometry, geometry.normal(), frames) {
            Some(facet) => self.at(&facet, geometry, frames),
            None => Ok(dark()),
        }
    }

    /// Index of the front and of the back medium; `None` where any will do.
    #[must_use]
    pub fn indices(&self) -> [Option<f64>; 2] {
        match self {
            Self::Dielectric(face) => [Some(face.n_incident()), Some(face.n_transmitted())],
            Self::Conductor(metal) => [Some(metal.n_incident()), None],
            Self::Film(film) => film.indices(),
            Self::Crystal(plate) => plate.indices(),
            Self::Element(_) | Self::Mirror | Self::Window => [None, None],
        }
    }

    fn check_media(&self, geometry: &Geometry) -> Result<(), SurfaceError> {
        let indices = self.indices();
        let seen = [
            (geometry.cos_incident(), geometry.n_incident()),
            (geometry.cos_outgoing(), geometry.n_outgoing()),
        ];
        for (cosine, found) in seen {
            let (side, expected) = if cosine < 0.0 {
                ("back", indices[1])
            } else {
                ("front", indices[0])
            };
            match expected {
                Some(expected) if (found - expected).abs() > SAME_INDEX * expected => {
                    return Err(SurfaceError::Medium {
                        side,
                        found,
                        expected,
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn at(
        &self,
        facet: &Facet,
        geometry: &Geometry,
        frames: &RayFrames,
    ) -> Result<Mueller, SurfaceError> {
        let in_sp = match self {
            Self::Dielectric(face) => {
                let face = if facet.from_behind {
                    face.reversed()
                } else {
                    *face
                };
                if facet.transmitted {
                    let passed = face.transmission(facet.cos_i);
                    passed.map_or(dark(), |t| t.element.to_mueller())
                } else {
                    face.reflection(facet.cos_i).to_mueller()
                }
            }
            Self::Conductor(metal) if !facet.transmitted && !facet.from_behind => {
                metal.reflection(facet.cos_i).to_mueller()
            }
            Self::Conductor(_) => dark(),
            Self::Film(film) => film.mueller(geometry, facet)?,
            Self::Crystal(plate) => plate.mueller(geometry, facet)?,
            Self::Element(element) => return Ok(element.mueller(geometry, facet, frames)),
            Self::Mirror if !facet.transmitted => {
                DiattenuatingRetarder::from_real_amplitudes(1.0, -1.0).to_mueller()
            }
            Self::Window if facet.transmitted => Mueller::identity(),
            Self::Mirror | Self::Window => dark(),
        };
        Ok(facet.in_frames(&in_sp, frames))
    }
}

/// Nothing comes out.
pub(super) fn dark() -> Mueller {
    Mueller::depolarizer(0.0)
}
