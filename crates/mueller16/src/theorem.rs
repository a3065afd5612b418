//! Theorem S4.1: the scattered modes and shape, for any incident series and any set of channels.
//!
//! ```text
//! A^(j→l)  = (n_o²/(s²λ²)) Σ c'^(j)_ab F{R^(j→l) φ_ab(B·; W')}(φ_t)                        amplitudes
//! S_l      = Σ_j A^(j→l)                                                                  Stokes amplitudes
//! c^(l)_ab = Σ_j ⟨f^(j→l) | φ_ab(·; W)⟩ A^(j→l) = μ_ab S_l,    W = D P                       scattered light
//! ```

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};
use smallvec::{SmallVec, smallvec};
use stokes::{
    Components, EnvelopeModes, Frame, GeneralizedStokes, HermiteSeries, LightError, Mueller, Real,
    StokesVector,
};
use thiserror::Error;

use crate::accuracy::Tolerance;
use crate::autocorrelation::Autocorrelation;
use crate::channels::{Channels, Group};
use crate::geometry::{Geometry, GeometryError};
use crate::incident::{self, IncidentCoherence, IncidentError};
use crate::kernel::{LANES, Meeting, Request};
use crate::population::Matter;

/// Why the theorem has no answer.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InteractionError {
    /// The directions.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The light.
    #[error(transparent)]
    Incident(#[from] IncidentError),
    /// The scattered light.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The shape of the scattered light.
    #[error(transparent)]
    Shape(#[from] stokes::ShapeError),
    /// The envelopes.
    #[error(transparent)]
    Envelope(#[from] stokes::EnvelopeError),
    /// There is no scattered intensity to take a shape from.
    #[error(
        "interaction: the matter scatters no intensity (0 → 0), expected some: it has no shape"
    )]
    Dark,
    /// A delta met light without width.
    #[error(
        "interaction: an autocorrelation that does not decay meets light without angular width (det V = {determinant}): \
         its lobe is a delta; trace it as a mirror or an order, or give the light a width"
    )]
    Delta {
        /// Determinant of the light's root over the surface.
        determinant: f64,
    },
    /// Modes were given for another number of envelopes.
    #[error(
        "interaction: modes of {found} envelopes, expected {expected}, one set for each envelope of the matter"
    )]
    Envelopes {
        /// How many were given.
        found: usize,
        /// How many the matter has.
        expected: usize,
    },
}

/// Which factor beside the theorem's own multiplies the scattered light.
///
/// The paper's Eqs. (S2.2) and (S2.3) hold no cosine; as printed, a unit mirror reflects `1/cos²θ` of the power.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Energy {
    /// None: Theorem S4.1 as printed.
    Printed,
    /// `cos_i cos_o`: phase screens, gratings and everything whose lobe does not depend on the facet that makes it.
    #[default]
    Conserving,
    /// `cos_i cos_o` times [`Geometry::obliquity`]: the diffuse part of rough height surfaces.
    HeightSurface,
}

impl Energy {
    /// The factor for these directions; at most 1 for the cosines alone.
    ///
    /// # Errors
    ///
    /// When a direction is at grazing incidence; never for [`Energy::Printed`]. As [`Geometry::obliquity`] for
    /// [`Energy::HeightSurface`].
    pub fn factor(self, geometry: &Geometry) -> Result<f64, GeometryError> {
        match self {
            Self::Printed => Ok(1.0),
            Self::Conserving => {
                let [cos_i, cos_o] = geometry.cosines()?;
                Ok((cos_i * cos_o).abs())
            }
            Self::HeightSurface => {
                let [cos_i, cos_o] = geometry.cosines()?;
                Ok((cos_i * cos_o).abs() * geometry.obliquity()?)
            }
        }
    }
}

/// The real numbers `T_lj` of one encounter: outgoing Stokes parameters per incident ones, one matrix for each envelope.
///
/// `T_lj = (n_o²/λ₀²) F{R^(j→l) γ}(φ_t)`, in 1/sr: the bidirectional scattering function without its obliquity.
///
/// | light | call |
/// |---|---|
/// | one coherence over the surface | [`Channels::transfer`] |
/// | the same, fewer Gaussians or f32 for a tolerance | [`Channels::transfer_in`] |
/// | a source in parts ([`crate::Footprint::resolved_for`]) that share one Stokes vector | [`Channels::transfer_of`] |
/// | parts of their own Stokes vectors, from matter of several envelopes | [`Channels::transfer_of_state`] |
/// | a source and a relief to a tolerance, all chosen here | [`crate::Footprint::transfer`] |
/// | any series of modes, four of them if need be | [`Channels::amplitudes`], [`Matter::scatter`] |
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transfer(SmallVec<[Matrix4<f64>; 1]>);

impl Transfer {
    /// The matrix of the envelope of that number; zero for one that the matter does not have.
    #[must_use]
    pub fn of_envelope(&self, envelope: usize) -> Mueller {
        self.0.get(envelope).copied().unwrap_or_default().into()
    }

    /// The sum over all envelopes: what a receiver of power sees.
    #[must_use]
    pub fn total(&self) -> Mueller {
        self.0.iter().sum::<Matrix4<f64>>().into()
    }

    /// Adds `factor` times another.
    pub(crate) fn add(&mut self, factor: f64, other: &Self) {
        if self.0.len() < other.0.len() {
            self.0.resize(other.0.len(), Matrix4::zeros());
        }
        for (mine, more) in self.0.iter_mut().zip(&other.0) {
            *mine += more * factor;
        }
    }
}

/// The amplitudes `A^(j→l)` of Theorem S4.1 and their sums, for each envelope; the unit of the incident light per m².
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitudes(SmallVec<[Matrix4<f64>; 1]>);

impl Amplitudes {
    /// `A^(j→l)` of an envelope.
    ///
    /// # Panics
    ///
    /// When j or l is not below 4.
    #[must_use]
    pub fn channel(&self, j: usize, l: usize, envelope: usize) -> f64 {
        self.0.get(envelope).map_or(0.0, |a| a[(l, j)])
    }

    /// `S_l = Σ_j A^(j→l)` of an envelope.
    #[must_use]
    pub fn stokes(&self, envelope: usize) -> StokesVector {
        let sums = self
            .0
            .get(envelope)
            .map_or(Vector4::zeros(), Matrix4::column_sum);
        StokesVector::from(sums)
    }
}

impl Channels {
    /// What these channels make of light of this coherence whose four parameters share their modes.
    ///
    /// Cost: one recurrence for each Gaussian of each different autocorrelation, `(N + 1)(N + 2)/2` steps for light of
    /// order N, whatever the number of channels; no allocation for one envelope. Autocorrelations of one Gaussian each are
    /// met four at a time.
    ///
    /// Least times over rounds on one core, built for nothing newer than SSE2. The first line of
    /// `docs/interaction_run_time.csv` names machine and date, the file has the rest, with errors;
    /// `validation/run_time_against_error.py` measures it all and writes this table:
    ///
    /// | part | matter | N | ns |
    /// |---|---|---|---|
    /// | yardstick | 4 channels of one autocorrelation | 0 | 98 |
    /// | yardstick | 4 channels of 4 autocorrelations | 0 | 247 |
    /// | yardstick | 16 channels of one autocorrelation | 4 | 168 |
    /// | yardstick | 16 channels of 16 autocorrelations | 4 | 1497 |
    /// | yardstick | the same with 4 series | 4 | 2791 |
    /// | skip | 64 Gaussians | 4 | 1950 |
    /// | skip | 64 Gaussians isotropic | 4 | 1729 |
    /// | skip | 64 Gaussians in f32 | 4 | 1389 |
    /// | grating | all orders | 0 | 830 |
    /// | grating | orders within 1e-4 | 0 | 773 |
    ///
    /// # Errors
    ///
    /// When an autocorrelation that does not decay meets a plane wave.
    pub fn transfer(
        &self,
        geometry: &Geometry,
        light: &IncidentCoherence,
    ) -> Result<Transfer, InteractionError> {
        self.transfer_by::<f64>(geometry, light, None)
    }

    /// As [`Channels::transfer`], with modes in numbers of type T and without the Gaussians that are negligible here.
    ///
    /// Left out is what contributes less than `tolerance` times the peak of its own lobe times `Σ|c_ab|`; a grating
    /// loses the orders far from the direction. In f32 the error is at most 2e-5 of the largest value of the lobe times
    /// `Σ|c_ab|`, up to order 64 (beyond, f64 is used): wave vectors, widths and exponents are f64 in either case.
    ///
    /// # Errors
    ///
    /// As [`Channels::transfer`].
    pub fn transfer_in<T: Real>(
        &self,
        geometry: &Geometry,
        light: &IncidentCoherence,
        tolerance: Tolerance,
    ) -> Result<Transfer, InteractionError> {
        self.transfer_by::<T>(geometry, light, Some(tolerance))
    }

    #[inline]
    fn transfer_by<T: Real>(
        &self,
        geometry: &Geometry,
        light: &IncidentCoherence,
        tolerance: Option<Tolerance>,
    ) -> Result<Transfer, InteractionError> {
        let phi = geometry.tangential();
        let scale = per_square_wavelength(geometry);
        let root = (light.root(), light.root_determinant());
        let request = Request::new([Some(light.modes())], tolerance);
        let mut matrices = self.zeros();
        let (blocks, rest) = self.groups().as_chunks::<LANES>();
        for block in blocks {
            let sums = side_by_side::<T>(block, root, &phi, &request)?;
            for (group, sum) in block.iter().zip(sums) {
                group.add_to(&mut matrices[group.envelope], &[scale * sum; 4]);
            }
        }
        for group in rest {
            let [sum] = integrate::<T, 1>(&group.autocorrelation, root, &phi, &request)?;
            group.add_to(&mut matrices[group.envelope], &[scale * sum; 4]);
        }
        Ok(Transfer(matrices))
    }

    /// The amplitudes `A^(j→l)` of Theorem S4.1 for light of any series.
    ///
    /// # Errors
    ///
    /// When the light comes from elsewhere than the geometry says or has another wavelength, or an autocorrelation that
    /// does not decay meets light without width.
    pub fn amplitudes(
        &self,
        geometry: &Geometry,
        light: &GeneralizedStokes,
    ) -> Result<Amplitudes, InteractionError> {
        let (root, determinant, factor) = incident::root_of(light, geometry)?;
        let phi = geometry.tangential();
        let scale = per_square_wavelength(geometry) * factor;
        let mut matrices = self.zeros();
        for group in self.groups() {
            let sums = sums(group, (&root, determinant), &phi, light)?;
            group.add_to(&mut matrices[group.envelope], &sums.map(|sum| scale * sum));
        }
        Ok(Amplitudes(matrices))
    }

    /// A matrix for each envelope; one needs no memory of its own.
    fn zeros(&self) -> SmallVec<[Matrix4<f64>; 1]> {
        smallvec![Matrix4::zeros(); self.envelope_count()]
    }

    /// The Mueller matrices that must be realizable: those of the lobe at each of `at`, then one for each delta order.
    pub(crate) fn spectral_muellers(&self, envelope: usize, at: &[Vector2<f64>]) -> Vec<Mueller> {
        let groups = || {
            self.groups()
                .iter()
                .filter(|group| group.envelope == envelope)
        };
        let mut found: Vec<Mueller> = at
            .iter()
            .map(|phi| {
                let sum: Matrix4<f64> = groups()
                    .map(|g| g.mueller * g.autocorrelation.spectrum(phi))
                    .sum();
                sum.into()
            })
            .collect();
        let mut orders: Vec<(Vector2<f64>, Matrix4<f64>)> = vec![];
        for group in groups() {
            for (weight, place) in group.autocorrelation.deltas() {
                match orders.iter_mut().find(|(known, _)| *known == place) {
                    Some((_, sum)) => *sum += group.mueller * weight,
                    None => orders.push((place, group.mueller * weight)),
                }
            }
        }
        found.extend(orders.into_iter().map(|(_, sum)| Mueller::from(sum)));
        found
    }
}

impl Matter {
    /// The light that this matter scatters toward the observer, one for each envelope: Theorem S4.1 (i) and (ii).
    ///
    /// `modes` are [`Matter::modes`]; `outgoing` is the frame of the scattered light, `distance` the way from the matter.
    /// Light of different envelopes adds incoherently; each part has its own shape.
    ///
    /// # Errors
    ///
    /// As [`Channels::amplitudes`] and [`Energy::factor`]; when the surface is seen edge-on or the far field is not
    /// reached.
    pub fn scatter(
        &self,
        modes: &[EnvelopeModes],
        geometry: &Geometry,
        light: &GeneralizedStokes,
        energy: Energy,
        outgoing: Frame,
        distance: f64,
    ) -> Result<Vec<GeneralizedStokes>, InteractionError> {
        let (found, expected) = (modes.len(), self.envelopes().len());
        if found != expected {
            return Err(InteractionError::Envelopes { found, expected });
        }
        let factor = energy.factor(geometry)?;
        let amplitudes = self.channels().amplitudes(geometry, light)?;
        let projection = geometry.outgoing_projection(&outgoing);
        let wavelength = geometry.wavelength();
        let parts = modes.iter().enumerate().map(|(place, modes)| {
            let stokes = amplitudes.stokes(place) * factor;
            Ok(modes.light(stokes, &projection, outgoing, wavelength, distance)?)
        });
        parts.collect()
    }
}

/// `(n_o/λ₀)²`
fn per_square_wavelength(geometry: &Geometry) -> f64 {
    (geometry.n_outgoing() / geometry.wavelength().metres()).powi(2)
}

/// For each incident parameter that a channel of the group starts from, the integral of its series; 0 for the others.
fn sums(
    group: &Group,
    root: (&Matrix2<f64>, f64),
    phi: &Vector2<f64>,
    light: &GeneralizedStokes,
) -> Result<[f64; 4], InteractionError> {
    let autocorrelation = &group.autocorrelation;
    let sources = group.set.sources();
    match light.components() {
        Components::Shared { modes, stokes } => {
            let request = Request::new([Some(modes)], None);
            let [sum] = integrate::<f64, 1>(autocorrelation, root, phi, &request)?;
            let amplitudes = stokes.to_array();
            Ok(std::array::from_fn(|j| {
                if sources[j] { sum * amplitudes[j] } else { 0.0 }
            }))
        }
        Components::Separate(series) => {
            let needed: [Option<&HermiteSeries>; 4] =
                std::array::from_fn(|j| series[j].as_ref().filter(|_| sources[j]));
            let mut present = (0..4).filter(|j| needed[*j].is_some());
            if let (Some(j), None) = (present.next(), present.next()) {
                let request = Request::new([needed[j]], None);
                let [sum] = integrate::<f64, 1>(autocorrelation, root, phi, &request)?;
                let mut sums = [0.0; 4];
                sums[j] = sum;
                return Ok(sums);
            }
            integrate::<f64, 4>(autocorrelation, root, phi, &Request::new(needed, None))
        }
    }
}

/// As [`integrate`] for one series and each of these groups; those of one Gaussian each are met at once.
#[inline(always)]
fn side_by_side<T: Real>(
    groups: &[Group; LANES],
    root: (&Matrix2<f64>, f64),
    phi: &Vector2<f64>,
    request: &Request<'_, 1>,
) -> Result<[f64; LANES], InteractionError> {
    let single = |group: &Group| matches!(group.autocorrelation.families(), [family] if family.terms().len() == 1);
    if groups.iter().all(single) {
        let meetings = groups
            .each_ref()
            .map(|group| Meeting::new(&group.autocorrelation.families()[0], root.0, root.1));
        let determinant = root.1;
        return Meeting::side_by_side::<T, LANES>(&meetings, phi, request)
            .ok_or(InteractionError::Delta { determinant });
    }
    let mut sums = [0.0; LANES];
    for (sum, group) in sums.iter_mut().zip(groups) {
        [*sum] = integrate::<T, 1>(&group.autocorrelation, root, phi, request)?;
    }
    Ok(sums)
}

/// `F{R Σ c_ab h_a h_b(V·)}(φ)` for each series, m².
#[inline(always)]
pub(crate) fn integrate<T: Real, const J: usize>(
    autocorrelation: &Autocorrelation,
    (root, determinant): (&Matrix2<f64>, f64),
    phi: &Vector2<f64>,
    request: &Request<'_, J>,
) -> Result<[f64; J], InteractionError> {
    let mut sums = [0.0; J];
    for family in autocorrelation.families() {
        Meeting::new(family, root, determinant)
            .add::<T, J>(phi, request, &mut sums)
            .ok_or(InteractionError::Delta { determinant })?;
    }
    Ok(sums)
}
