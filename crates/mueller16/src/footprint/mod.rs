//! The footprint of a source, or of the previous scatterer, as a surface sees it: its coherence by one series or by
//! positive Gaussians, chosen for the lobes that will see it.
//!
//! ```text
//! γ(x) = f(C x)/f(0),   C = (n k₀/s) T'ᵀ (1 − ŝŝᵀ) T,   V = D C         T' axes of the footprint, T of the surface
//! F{R γ}(φ) = ∫ I(m) F{R}(φ + Cᵀm) d²m / f(0)
//! ```
//!
//! The second line is why a lobe decides how well γ must be known: what is finer than the lobe is averaged.

mod choice;

use nalgebra::{Matrix2, Vector3};
use stokes::{Envelope, EnvelopeError, EnvelopeModes, Mueller, Patches, plane};
use thiserror::Error;

use crate::accuracy::{Approximation, Tolerance};
use crate::autocorrelation::AutocorrelationError;
use crate::channels::Channels;
use crate::geometry::{Geometry, GeometryError};
use crate::incident::{IncidentCoherence, IncidentError, wavenumber};
use crate::relief::Relief;
use crate::theorem::{InteractionError, Transfer};

/// Why a footprint has no coherence on a surface, or none to the tolerance.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FootprintError {
    /// The distance is no distance.
    #[error("footprint: the distance is {0} m, expected a finite positive number")]
    Distance(f64),
    /// Its axes.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Its modes or patches.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// Its coherence.
    #[error(transparent)]
    Incident(#[from] IncidentError),
    /// The matter's autocorrelation.
    #[error(transparent)]
    Autocorrelation(#[from] AutocorrelationError),
    /// The transfer.
    #[error(transparent)]
    Interaction(#[from] InteractionError),
    /// A lobe that is a delta shows the footprint as it is.
    #[error(
        "footprint: an autocorrelation that does not decay (weight {weight}) shows an image of the source, which no finite \
         number of modes or Gaussians reaches at every point; trace it as a mirror or an order, and ask for the rest \
         (`without_deltas`)"
    )]
    Delta {
        /// The weight of the delta.
        weight: f64,
    },
}

/// A source of light in its place: intensity profile, axes of its plane, distance of its centroid.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    envelope: Envelope,
    tangents: [Vector3<f64>; 2],
    distance: f64,
}

/// One part of a footprint: what a surface needs of it.
#[derive(Clone, Debug, PartialEq)]
pub struct IncidentPart {
    /// Its share of the whole's integral; the shares add up to 1.
    pub share: f64,
    /// The encounter, lit from the centroid of the part.
    pub geometry: Geometry,
    /// Distance of that centroid, m.
    pub distance: f64,
    /// Its coherence over the surface.
    pub coherence: IncidentCoherence,
}

/// How a footprint was represented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Representation {
    /// One series of Hermite-Gauss modes up to this order; it may be negative somewhere.
    Modes {
        /// The order.
        order: usize,
    },
    /// A sum of positive Gaussians, each with its own direction.
    Gaussians {
        /// How many.
        count: usize,
    },
}

/// What was chosen for a footprint, and how far from the exact one its transfer can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootprintChoice {
    /// The representation.
    pub representation: Representation,
    /// Bound on the error of `F{R γ}(φ)` at any φ, over the sum of the largest values that the Gaussians of R reach.
    pub error: f64,
    /// Standard deviation of the narrowest lobe on the plane of the footprint along its thin axis, m; infinite where there is none.
    pub lobe: f64,
}

/// A transfer, what was chosen for it, and what it does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferReport {
    /// The transfer of the parts that decay, per irradiance of the whole footprint.
    pub transfer: Transfer,
    /// What was chosen for the autocorrelation.
    pub autocorrelation: Approximation,
    /// What was chosen for the footprint.
    pub footprint: FootprintChoice,
    /// Weight of the mirror part or of the sharp orders, which have to be traced as such.
    pub delta_weight: f64,
}

impl TransferReport {
    /// Bound on the error of the transfer, over the sum of the largest values that its Gaussians reach.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.autocorrelation.error + self.footprint.error
    }
}

impl Footprint {
    /// The profile `envelope` in the plane with the unit axes `tangents`, its centroid `distance` metres away.
    ///
    /// # Errors
    ///
    /// When the axes are not perpendicular unit vectors (to 1e-6) or the distance is not finite and positive.
    pub fn new(
        envelope: Envelope,
        tangents: [Vector3<f64>; 2],
        distance: f64,
    ) -> Result<Self, FootprintError> {
        if !(distance.is_finite() && distance > 0.0) {
            return Err(FootprintError::Distance(distance));
        }
        crate::geometry::check_axes(&tangents)?;
        Ok(Self {
            envelope,
            tangents,
            distance,
        })
    }

    /// The profile.
    #[must_use]
    pub fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    /// Distance of the centroid, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// `C`, which takes a separation in the surface to a wave vector in the footprint's plane: `C = (n k₀/s) T'ᵀ Π T`.
    ///
    /// 2×2, 1/m².
    ///
    /// Source: the factorised form of Theorem S4.1, where the incident transverse frame cancels.
    #[must_use]
    pub fn angular_map(&self, geometry: &Geometry) -> Matrix2<f64> {
        angular_map(&self.tangents, geometry, self.distance)
    }

    /// The coherence of the footprint by its modes, seen from the surface of the geometry.
    ///
    /// Scaled to 1 at zero separation as every coherence: power is exact, and the transfer to lobes wider than the footprint. Lobes
    /// narrower than it see truncated modes best as they are, `modes.sum_at_zero() / modes.area()` times as bright.
    ///
    /// # Errors
    ///
    /// When a root exceeds 1e30/m or the modes add up to nothing positive at 0.
    pub fn coherence(
        &self,
        geometry: &Geometry,
        modes: &EnvelopeModes,
    ) -> Result<IncidentCoherence, IncidentError> {
        of_root(modes.root(), &self.angular_map(geometry), modes.series())
    }

    /// The parts of the footprint that let the lobes of `channels` see it to the tolerance, and what was chosen: one
    /// series if a low order is enough, otherwise Gaussians.
    ///
    /// The bound is that of the paraxial transfer; directions to the parts are exact. For series it is the integral of `R |γ − γ_N|`
    /// (to some per cent), for Gaussians [`Patches::error`] for a round lobe of the narrowest width. Takes some
    /// milliseconds: ask once for a source and a surface, not for every ray.
    ///
    /// # Errors
    ///
    /// When a channel does not decay, or the lobe is so narrow that the Gaussians would be too many.
    pub fn resolved_for(
        &self,
        channels: &Channels,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<(Vec<IncidentPart>, FootprintChoice), FootprintError> {
        let map = self.angular_map(geometry);
        let lobes = choice::Lobes::of(channels, &map)?;
        let whole = |modes: &EnvelopeModes, error| {
            let part = IncidentPart {
                share: 1.0,
                geometry: *geometry,
                distance: self.distance,
                coherence: of_root(modes.root(), &map, modes.series())?,
            };
            let representation = Representation::Modes {
                order: modes.series().order(),
            };
            let choice = FootprintChoice {
                representation,
                error,
                lobe: lobes.narrowest,
            };
            Ok((vec![part], choice))
        };
        if let Some((modes, error)) = lobes.order_for(&self.envelope, &map, tolerance.get())? {
            return whole(&modes, error);
        }
        let patches = self
            .envelope
            .patches_for(lobes.narrowest, tolerance.get())?;
        let choice = FootprintChoice {
            representation: Representation::Gaussians {
                count: patches.patches().len(),
            },
            error: patches.error(lobes.narrowest)?,
            lobe: lobes.narrowest,
        };
        Ok((self.parts(geometry, &patches)?, choice))
    }

    /// The given patches, each lit from its own centre.
    ///
    /// # Errors
    ///
    /// When a root exceeds 1e30/m.
    pub fn parts(
        &self,
        geometry: &Geometry,
        patches: &Patches,
    ) -> Result<Vec<IncidentPart>, FootprintError> {
        let origin = self.envelope.centroid();
        let [t1, t2] = self.tangents;
        let parts = patches.patches().iter().map(|patch| {
            let m = patch.centre - origin;
            let way = geometry.to_source() * self.distance + t1 * m.x + t2 * m.y;
            let distance = way.norm();
            let geometry = geometry.lit_from(way / distance)?;
            let map = angular_map(&self.tangents, &geometry, distance);
            let root = plane::symmetric_root(&patch.covariance);
            Ok(IncidentPart {
                share: patch.weight / self.envelope.area(),
                geometry,
                distance,
                coherence: of_root(&root, &map, &stokes::HermiteSeries::fundamental(1.0))?,
            })
        });
        parts.collect()
    }

    /// The transfer of light of this footprint by the relief, with the response `mueller`, to the tolerance, and what
    /// was chosen for it; half of the tolerance goes to the relief, half to the footprint.
    ///
    /// # Errors
    ///
    /// As [`Relief::autocorrelation`] and [`Footprint::resolved_for`].
    pub fn transfer(
        &self,
        relief: &dyn Relief,
        mueller: &Mueller,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<TransferReport, FootprintError> {
        let half = tolerance.half();
        let (r, autocorrelation) = relief.autocorrelation(geometry.normal_component(), half)?;
        let delta_weight = r.delta_weight();
        let channels = Channels::new(mueller, r.without_deltas());
        let (parts, footprint) = self.resolved_for(&channels, geometry, half)?;
        Ok(TransferReport {
            transfer: channels.transfer_of(&parts)?,
            autocorrelation,
            footprint,
            delta_weight,
        })
    }
}

impl Channels {
    /// The transfer of a footprint in parts: the sum of `share · transfer`, per irradiance of the whole.
    ///
    /// # Errors
    ///
    /// As [`Channels::transfer`].
    pub fn transfer_of(&self, parts: &[IncidentPart]) -> Result<Transfer, InteractionError> {
        let mut sum = Transfer::default();
        for part in parts {
            sum.add(part.share, &self.transfer(&part.geometry, &part.coherence)?);
        }
        Ok(sum)
    }
}

fn of_root(
    root: &Matrix2<f64>,
    map: &Matrix2<f64>,
    modes: &stokes::HermiteSeries,
) -> Result<IncidentCoherence, IncidentError> {
    let determinant = plane::determinant(root) * plane::determinant(map);
    IncidentCoherence::with_determinant(plane::product(root, map), determinant, modes)
}

/// `(n k₀/s) T'ᵀ (1 − ŝŝᵀ) T`.
fn angular_map(tangents: &[Vector3<f64>; 2], geometry: &Geometry, distance: f64) -> Matrix2<f64> {
    let s = geometry.to_source();
    let across = tangents.map(|t| t - s * s.dot(&t));
    let theirs = geometry.tangents();
    Matrix2::from_fn(|row, column| across[row].dot(&theirs[column]))
        * (wavenumber(geometry) / distance)
}
