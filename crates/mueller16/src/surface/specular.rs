//! The sharp part of a surface: mirror and Snell pairs, and the orders of gratings.

use nalgebra::Vector2;
use stokes::{Envelope, Frame, Mueller};

use super::error::SurfaceError;
use super::facet::RayFrames;
use super::{Boundary, Surface};
use crate::accuracy::Tolerance;
use crate::autocorrelation::Autocorrelation;
use crate::geometry::{Geometry, GeometryError};
use crate::population::Population;
use crate::relief::{Relief, SharpOrder};

/// Light that leaves a surface in one direction: `weight · mueller` of the incident power.
#[derive(Clone, Debug, PartialEq)]
pub struct Specular {
    /// The encounter in the direction in which the light leaves.
    pub geometry: Geometry,
    /// Frames of `mueller`.
    pub frames: RayFrames,
    /// Its tangential wave vector `φ_t`, rad/m: 0 for mirror and Snell pairs, qG for an order.
    pub place: Vector2<f64>,
    /// Share of the power: `e^(−g)`, or the efficiency of the order, for the `φ_z` of this direction.
    /// See [`crate::Sharing`] for gratings.
    pub weight: f64,
    /// What the facet does, `M(n)` for mirror and Snell pairs.
    pub mueller: Mueller,
}

impl Specular {
    /// The same as a population of one constant, shifted autocorrelation; for [`crate::Energy::Conserving`].
    #[must_use]
    pub fn population(&self, envelope: Envelope) -> Population {
        let order = Autocorrelation::constant(self.weight).shifted(&self.place);
        Population::of_sixteen(&self.mueller, order, envelope)
    }
}

impl<R: Relief> Surface<R> {
    /// Every direction into which light leaves sharply: on the observer's side of the encounter, from its source. The
    /// observer's direction itself does not matter.
    ///
    /// Each direction has its own `φ_z`. Orders are those of [`Relief::orders`], shared so that no more leaves than comes;
    /// without them, what does not decay in R, asked again for the `φ_z` of each. Those below the tolerance, and those that do
    /// not propagate, are left out. Without obliquity, shadowing or cap for the diffuse part. The matrix leads from the
    /// frame `incident` to that of s about the surface's normal.
    ///
    /// The grooves of a disc of 1.6 µm pitch, deep enough to send light into four orders beside the mirror:
    /// ```
    /// use mueller16::{Boundary, Geometry, Grating, Profile, RayFrames, Sharing, Surface, Tolerance};
    /// use nalgebra::{Vector2, Vector3};
    /// let disc = Grating::lines(1.6e-6, Vector2::x(), Profile::sinusoidal(120e-9)?)?;
    /// let green = stokes::Wavelength::from_metres(550e-9)?;
    /// let straight = Geometry::on_plane(Vector3::z(), Vector3::z(), green)?;
    /// let incident = RayFrames::of_surface(&straight)?.incident;
    /// let total = |sharing| {
    ///     let surface = Surface::of_phases(Boundary::Mirror, disc.clone().shared(sharing));
    ///     let beams = surface.specular(&straight, incident, Tolerance::ROUNDING)?;
    ///     Ok::<f64, mueller16::SurfaceError>(beams.iter().map(|beam| beam.weight).sum())
    /// };
    /// assert!((total(Sharing::Capped)? - 0.946).abs() < 5e-4);
    /// assert!((total(Sharing::Lossless)? - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Boundary::mueller`], when the source is at grazing incidence, and when the relief has no autocorrelation for
    /// the `φ_z` of a direction or more orders than are listed.
    pub fn specular(
        &self,
        geometry: &Geometry,
        incident: Frame,
        tolerance: Tolerance,
    ) -> Result<Vec<Specular>, SurfaceError> {
        geometry.cosines()?;
        let orders = match self.relief.orders(geometry, tolerance)? {
            Some(orders) => orders,
            None => self.deltas(geometry, tolerance)?,
        };
        let beams = orders.into_iter().map(|order| {
            let outgoing = RayFrames::of_surface(&order.geometry)?.outgoing;
            let frames = RayFrames { incident, outgoing };
            Ok(Specular {
                geometry: order.geometry,
                frames,
                place: order.place,
                weight: order.weight,
                mueller: sharp(&self.boundary, &order.geometry, &frames, &order.place)?,
            })
        });
        beams.collect()
    }

    /// The mirror, and what else R shows that does not decay.
    fn deltas(
        &self,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<Vec<SharpOrder>, SurfaceError> {
        let mut places = vec![Vector2::zeros()];
        let mut found = vec![];
        let mut next = 0;
        while let Some(&place) = places.get(next) {
            next += 1;
            let geometry = match geometry.observed_at(&place) {
                Ok(seen) if seen.cos_outgoing() != 0.0 => seen,
                Ok(_) | Err(GeometryError::Evanescent { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            let phi_z = geometry.normal_component();
            let (r, _) = self.relief.autocorrelation(phi_z, tolerance)?;
            let mut weight = 0.0;
            for (more, at) in r.deltas() {
                if at == place {
                    weight += more;
                } else if !places.contains(&at) {
                    places.push(at);
                }
            }
            if weight > 0.0 {
                found.push(SharpOrder {
                    geometry,
                    place,
                    weight,
                });
            }
        }
        Ok(found)
    }
}

fn sharp(
    boundary: &Boundary,
    geometry: &Geometry,
    frames: &RayFrames,
    place: &Vector2<f64>,
) -> Result<Mueller, SurfaceError> {
    if place.norm_squared() == 0.0 {
        boundary.mueller_of_plane(geometry, frames)
    } else {
        boundary.mueller(geometry, frames)
    }
}
