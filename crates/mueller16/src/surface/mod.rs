//! Interfaces as populations: what every facet does to polarization, over the relief of a surface.
//!
//! ```text
//! f = (n_o²/λ₀²) O(i,o) F{R γ}(φ_t) M(h)        diffuse, 1/sr;     h = φ/|φ|
//! e^(−g) M(n)                                   mirror and Snell pairs: a delta, without O, shadowing or cap
//! ```
//!
//! `O` is [`Geometry::obliquity`] for heights, by which great roughness is the microfacet model of Beckmann, and 1 for
//! phase screens and gratings.

mod boundary;
mod energy;
mod error;
mod facet;
mod hemisphere;
mod layers;
mod quadrature;
mod shadowing;
mod specular;
mod table;

use nalgebra::{Matrix2, Vector2, Vector3};
use stokes::{Envelope, Mueller, Wavelength};

pub use boundary::Boundary;
pub use energy::EnergyCap;
pub use error::SurfaceError;
pub use facet::RayFrames;
pub use layers::{CrystalPlate, Film, InternalReflections, PlaneElement};
pub use shadowing::smith_beckmann;
pub use specular::Specular;

use crate::accuracy::Tolerance;
use crate::channels::Channels;
use crate::geometry::Geometry;
use crate::incident::IncidentCoherence;
use crate::population::Population;
use crate::relief::Relief;
use crate::theorem::Energy;

/// A boundary on every facet of a relief.
///
/// Gold, smooth: a mirror and nothing else.
/// ```
/// use mueller16::{Boundary, RayFrames, Surface};
/// use mueller16::{ConductorInterface, Flat, Geometry, Tolerance};
/// use nalgebra::Vector3;
/// let gold = Boundary::Conductor(ConductorInterface::new(1.0, 0.183, 3.43)?);
/// let surface = Surface::of_heights(gold, Flat);
/// let (sin, cos) = 75f64.to_radians().sin_cos();
/// let red = stokes::Wavelength::from_metres(633e-9)?;
/// let mirror = Geometry::on_plane(Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos), red)?;
/// let incident = RayFrames::of_surface(&mirror)?.incident;
/// let [beam] = &surface.specular(&mirror, incident, Tolerance::ROUNDING)?[..] else { panic!() };
/// assert!((beam.weight * beam.mueller.element(0, 0) - 0.9394557).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Surface<R> {
    boundary: Boundary,
    relief: R,
    energy: Energy,
    /// Covariance of the slopes, where there is shadowing.
    shadowing: Option<Matrix2<f64>>,
    caps: Vec<EnergyCap>,
}

impl<R: Relief> Surface<R> {
    /// A surface of random heights, with the obliquity factor, without shadowing and cap.
    #[must_use]
    pub fn of_heights(boundary: Boundary, relief: R) -> Self {
        Self::with_energy(boundary, relief, Energy::HeightSurface)
    }

    /// A phase screen or a grating, without obliquity factor. Gratings share their light as their [`crate::Sharing`] says.
    #[must_use]
    pub fn of_phases(boundary: Boundary, relief: R) -> Self {
        Self::with_energy(boundary, relief, Energy::Conserving)
    }

    fn with_energy(boundary: Boundary, relief: R, energy: Energy) -> Self {
        Self {
            boundary,
            relief,
            energy,
            shadowing: None,
            caps: vec![],
        }
    }

    /// The same with Smith's `G1(i) G1(o)` on the diffuse part, as microfacet models have it; see [`smith_beckmann`].
    ///
    /// Caps that were made without it are dropped.
    ///
    /// # Errors
    ///
    /// When the relief has no slopes.
    pub fn with_shadowing(mut self) -> Result<Self, SurfaceError> {
        self.shadowing = Some(
            self.relief
                .slope_covariance()
                .ok_or(SurfaceError::NoSlopes)?,
        );
        self.caps.clear();
        Ok(self)
    }

    /// The same with an energy cap for light of one wavelength between one pair of media, in both directions; see
    /// [`EnergyCap`]. Once a surface has a cap, encounters for which it has none are errors.
    ///
    /// # Errors
    ///
    /// As [`EnergyCap::new`].
    pub fn with_cap(
        mut self,
        wavelength: Wavelength,
        incident: f64,
        outgoing: Passage,
        tolerance: Tolerance,
    ) -> Result<Self, SurfaceError> {
        let cap = EnergyCap::new(
            &self.relief,
            self.energy,
            self.shadowing.as_ref(),
            wavelength,
            incident,
            outgoing,
            tolerance,
        )?;
        self.caps.push(cap);
        Ok(self)
    }

    /// The diffuse albedo `∫ f cos_o dω` with `M = 1`, shadowing included and without cap, for light at `cosine` in
    /// `1e-9..=1.0`; dimensionless.
    ///
    /// By quadrature over the hemisphere, to the tolerance, but no better than 1e-9.
    ///
    /// # Errors
    ///
    /// As [`EnergyCap::new`], and when the cosine is out of its range.
    pub fn diffuse_albedo(
        &self,
        cosine: f64,
        wavelength: Wavelength,
        incident: f64,
        passage: Passage,
        tolerance: Tolerance,
    ) -> Result<f64, SurfaceError> {
        let slopes = self.shadowing.as_ref();
        let hemisphere = hemisphere::Hemisphere::new(
            &self.relief,
            self.energy,
            slopes,
            wavelength,
            incident,
            passage,
            tolerance.get().max(1e-9),
        )?;
        Ok(hemisphere.albedo(cosine)?.diffuse)
    }

    /// What every facet does to polarization.
    #[must_use]
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// The relief.
    #[must_use]
    pub fn relief(&self) -> &R {
        &self.relief
    }

    /// Which factor belongs to the diffuse part: what [`crate::Matter::scatter`] is to be given for it.
    #[must_use]
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// The caps, in the order in which they were made.
    #[must_use]
    pub fn caps(&self) -> &[EnergyCap] {
        &self.caps
    }

    /// The diffuse part at an encounter: `M(h)` with the autocorrelation that is left without mirror and orders, times
    /// shadowing and cap. The factor of [`Surface::energy`] is not in it.
    ///
    /// # Errors
    ///
    /// As [`Boundary::mueller`]; when the relief has no autocorrelation for this `φ_z`, or the surface no cap for these
    /// media.
    pub fn diffuse(
        &self,
        geometry: &Geometry,
        frames: &RayFrames,
        envelope: Envelope,
        tolerance: Tolerance,
    ) -> Result<Population, SurfaceError> {
        let (mueller, autocorrelation) = self.diffuse_parts(geometry, frames, tolerance)?;
        Ok(Population::of_sixteen(&mueller, autocorrelation, envelope))
    }

    /// The bidirectional scattering function of the diffuse part under light of any coherence, 4×4, 1/sr:
    /// `L_o = f cos_i E_⊥`, `E_⊥` the irradiance across the ray.
    ///
    /// # Errors
    ///
    /// As [`Surface::diffuse`] and [`Energy::factor`].
    pub fn scattering_function(
        &self,
        geometry: &Geometry,
        frames: &RayFrames,
        light: &IncidentCoherence,
        tolerance: Tolerance,
    ) -> Result<Mueller, SurfaceError> {
        let [cos_i, cos_o] = geometry.cosines()?;
        let (mueller, autocorrelation) = self.diffuse_parts(geometry, frames, tolerance)?;
        let transfer = Channels::new(&mueller, autocorrelation).transfer(geometry, light)?;
        if geometry.normal_component() == 0.0 {
            return Ok(boundary::dark());
        }
        let factor = self.energy.factor(geometry)? / (cos_i * cos_o).abs();
        Ok(transfer.total() * factor)
    }

    fn diffuse_parts(
        &self,
        geometry: &Geometry,
        frames: &RayFrames,
        tolerance: Tolerance,
    ) -> Result<(Mueller, crate::Autocorrelation), SurfaceError> {
        let mueller = self.boundary.mueller(geometry, frames)?;
        let none = || (boundary::dark(), crate::Autocorrelation::default());
        if mueller.element(0, 0) == 0.0 {
            return Ok(none());
        }
        let capped = self.capped(geometry)? * self.relief.energy_cap(geometry)?;
        let factor = self.shadowed(geometry) * capped;
        let phi_z = geometry.normal_component();
        let (r, _) = self.relief.autocorrelation(phi_z, tolerance)?;
        Ok((mueller, r.without_deltas().scaled(factor)))
    }

    fn shadowed(&self, geometry: &Geometry) -> f64 {
        let Some(slopes) = &self.shadowing else {
            return 1.0;
        };
        let [t1, t2] = geometry.tangents();
        let of = |direction: Vector3<f64>| {
            let tangential = Vector2::new(t1.dot(&direction), t2.dot(&direction));
            smith_beckmann(slopes, geometry.normal().dot(&direction), &tangential)
        };
        of(geometry.to_source()) * of(geometry.to_observer())
    }

    fn capped(&self, geometry: &Geometry) -> Result<f64, SurfaceError> {
        if self.caps.is_empty() {
            return Ok(1.0);
        }
        let found = self.caps.iter().find_map(|cap| cap.factor(geometry));
        found.ok_or(SurfaceError::NoCap {
            wavelength: geometry.wavelength().metres(),
            incident: geometry.n_incident(),
            outgoing: geometry.n_outgoing(),
        })
    }
}

/// What light does at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// It stays in its medium.
    Reflection,
    /// It passes into a medium of this index.
    TransmissionInto(f64),
}
