//! The sharp part of a surface: mirror and Snell pairs, and the orders of gratings.

use nalgebra::Vector2;
use stokes::{Envelope, Frame, Mueller};

use super::error::SurfaceError;
use super::facet::RayFrames;
use super::{Boundary, Surface};
use crate::accuracy::Tolerance;
use crate::autocorrelation::Autocorrelation;
use crate::geometry::Geometry;
use crate::population::Population;
use crate::relief::Relief;

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
    /// Each direction has its own `φ_z`, for which the relief is asked again. Orders below the tolerance, and those that
    /// do not propagate, are left out. Without obliquity, shadowing or cap: weights of one encounter need not add up to 1
    /// for gratings. The matrix leads from the frame `incident` to that of s about the surface's normal.
    ///
    /// # Errors
    ///
    /// As [`Boundary::mueller`], when the source is at grazing incidence, and when the relief has no autocorrelation for
    /// the `φ_z` of a direction.
    pub fn specular(
        &self,
        geometry: &Geometry,
        incident: Frame,
        tolerance: Tolerance,
    ) -> Result<Vec<Specular>, SurfaceError> {
        geometry.cosines()?;
        let mut places = self.places(geometry, tolerance)?;
        let mut found = vec![];
        let mut next = 0;
        while next < places.len() {
            let place = places[next];
            next += 1;
            let Some(beam) = towards(geometry, &place)? else {
                continue;
            };
            let (r, _) = self
                .relief
                .autocorrelation(beam.normal_component(), tolerance)?;
            let mut weight = 0.0;
            for (more, at) in r.deltas() {
                if at == place {
                    weight += more;
                } else if !places.contains(&at) {
                    places.push(at);
                }
            }
            if weight == 0.0 {
                continue;
            }
            let outgoing = RayFrames::of_surface(&beam)?.outgoing;
            let frames = RayFrames { incident, outgoing };
            found.push(Specular {
                geometry: beam,
                frames,
                place,
                weight,
                mueller: sharp(&self.boundary, &beam, &frames, &place)?,
            });
        }
        Ok(found)
    }

    /// Where the deltas are for light into the normal and for light that grazes: most, or all, orders.
    fn places(
        &self,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<Vec<Vector2<f64>>, SurfaceError> {
        let k0 = geometry.wavelength().wavenumber().radians_per_metre();
        let across = k0 * geometry.n_incident() * geometry.cos_incident();
        let upright = k0 * geometry.n_outgoing() * geometry.cos_outgoing().signum();
        let mut places = vec![Vector2::zeros()];
        for phi_z in [across, across + 0.5 * upright, across + upright] {
            for (_, place) in self.relief.autocorrelation(phi_z, tolerance)?.0.deltas() {
                if !places.contains(&place) {
                    places.push(place);
                }
            }
        }
        Ok(places)
    }
}

/// The encounter with light that leaves at `φ_t = place` on the observer's side; `None` where it does not propagate.
fn towards(geometry: &Geometry, place: &Vector2<f64>) -> Result<Option<Geometry>, SurfaceError> {
    let k0 = geometry.wavelength().wavenumber().radians_per_metre();
    let [t1, t2] = geometry.tangents();
    let i = geometry.to_source();
    let along = Vector2::new(t1.dot(&i), t2.dot(&i));
    let given = place / (k0 * geometry.n_outgoing());
    let ratio = geometry.n_incident() / geometry.n_outgoing();
    let o = given - along * ratio;
    // 1 − |o|² from the cosine of the source: a mirror keeps its digits at grazing incidence
    let cos_i = geometry.cos_incident();
    let squared = (1.0 - ratio) * (1.0 + ratio)
        + (ratio * cos_i).powi(2)
        + (2.0 * ratio * along - given).dot(&given);
    if squared <= 0.0 {
        return Ok(None);
    }
    let side = geometry.cos_outgoing().signum();
    let observer = t1 * o.x + t2 * o.y + geometry.normal() * (side * squared.sqrt());
    let beam = Geometry::new(i, observer, [t1, t2], geometry.wavelength())?
        .between(geometry.n_incident(), geometry.n_outgoing())?;
    Ok(Some(beam))
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
