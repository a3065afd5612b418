//! The diffuse albedo of a relief under a unit response, by quadrature over the outgoing directions.

use nalgebra::{Matrix2, Vector2};
use stokes::{Wavelength, plane};

use super::error::SurfaceError;
use super::quadrature::{graded, integrate};
use super::{Passage, smith_beckmann};
use crate::accuracy::Tolerance;
use crate::autocorrelation::Autocorrelation;
use crate::geometry::{LEAST_COSINE, check_index};
use crate::relief::Relief;
use crate::theorem::Energy;

/// Relative difference of two widths of a round lobe.
const SAME: f64 = 1e-9;

/// What is integrated: all outgoing directions of light from one side.
pub(super) struct Hemisphere<'a, R> {
    relief: &'a R,
    energy: Energy,
    slopes: Option<&'a Matrix2<f64>>,
    k0: f64,
    /// Of the incident and the outgoing medium.
    indices: [f64; 2],
    reflected: bool,
    pub(super) tolerance: f64,
}

/// Diffuse light of a unit response.
#[derive(Clone, Copy, Debug)]
pub(super) struct Albedo {
    /// `∫ f cos_o dω`
    pub(super) diffuse: f64,
    /// `1 − e^(−g)` of the mirror or Snell direction.
    pub(super) share: f64,
}

impl<'a, R: Relief> Hemisphere<'a, R> {
    pub(super) fn new(
        relief: &'a R,
        energy: Energy,
        slopes: Option<&'a Matrix2<f64>>,
        wavelength: Wavelength,
        incident: f64,
        passage: Passage,
        tolerance: f64,
    ) -> Result<Self, SurfaceError> {
        let (outgoing, reflected) = match passage {
            Passage::Reflection => (incident, true),
            Passage::TransmissionInto(other) => (other, false),
        };
        check_index("incident", incident)?;
        check_index("outgoing", outgoing)?;
        Ok(Self {
            relief,
            energy,
            slopes,
            k0: wavelength.wavenumber().radians_per_metre(),
            indices: [incident, outgoing],
            reflected,
            tolerance,
        })
    }

    /// The vertical wave vector for two cosines, both positive.
    fn phi_z(&self, cos_i: f64, cos_o: f64) -> f64 {
        let [n_i, n_o] = self.indices;
        let sign = if self.reflected { 1.0 } else { -1.0 };
        self.k0 * (n_i * cos_i + sign * n_o * cos_o)
    }

    /// Cosine of the mirror or Snell direction; 0 beyond the critical angle.
    fn cos_specular(&self, cos_i: f64) -> f64 {
        let [n_i, n_o] = self.indices;
        let sine = n_i / n_o * ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
        ((1.0 - sine) * (1.0 + sine)).max(0.0).sqrt()
    }

    fn lobe(&self, phi_z: f64) -> Result<Autocorrelation, SurfaceError> {
        // a tenth: what the sum leaves out must not be most of the error
        let tolerance = Tolerance::relative(0.1 * self.tolerance).unwrap_or(Tolerance::ROUNDING);
        let (r, _) = self.relief.autocorrelation(phi_z, tolerance)?;
        let r = r.without_deltas();
        check_round(&r)?;
        Ok(r)
    }

    /// The share of the power that must be in the diffuse part: all but the mirror's.
    fn diffuse_share(&self, cos_i: f64) -> Result<f64, SurfaceError> {
        let cos_o = if self.reflected {
            cos_i
        } else {
            self.cos_specular(cos_i)
        };
        Ok(self.lobe(self.phi_z(cos_i, cos_o))?.at_zero())
    }

    /// `A(i)`; 0 where there is no diffuse light.
    pub(super) fn ratio(&self, cos_i: f64) -> Result<f64, SurfaceError> {
        let Albedo { diffuse, share } = self.albedo(cos_i)?;
        Ok(if share > 0.0 { diffuse / share } else { 0.0 })
    }

    /// Errors below the tolerance times itself and times the share.
    pub(super) fn albedo(&self, cos_i: f64) -> Result<Albedo, SurfaceError> {
        if !(LEAST_COSINE..=1.0).contains(&cos_i) {
            return Err(SurfaceError::Cosine { found: cos_i });
        }
        let share = self.diffuse_share(cos_i)?;
        let diffuse = if share > 0.0 {
            self.integral(cos_i, share)?
        } else {
            0.0
        };
        Ok(Albedo { diffuse, share })
    }

    fn integral(&self, cos_i: f64, scale: f64) -> Result<f64, SurfaceError> {
        let [n_i, n_o] = self.indices;
        let sin_i = ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
        let peak = if self.reflected {
            cos_i.acos()
        } else {
            (n_i / n_o * sin_i).min(1.0).asin()
        };
        let k_o = self.k0 * n_o;
        let narrow = |r: &Autocorrelation| narrowest(r) / k_o;
        let width = narrow(&self.lobe(self.phi_z(cos_i, peak.cos()))?);
        let edges = graded(0.0, std::f64::consts::FRAC_PI_2, peak, width);
        let absolute = self.tolerance * scale / 16.0;
        let mut over_polar = |theta: f64| -> Result<f64, SurfaceError> {
            let (sin_o, cos_o) = theta.sin_cos();
            let phi_z = self.phi_z(cos_i, cos_o);
            let r = self.lobe(phi_z)?;
            let width = (narrow(&r) / sin_o).min(std::f64::consts::PI);
            let mut over_azimuth = |psi: f64| -> Result<f64, SurfaceError> {
                let (sin_psi, cos_psi) = psi.sin_cos();
                let o = Vector2::new(-sin_o * cos_psi, sin_o * sin_psi) * n_o;
                let phi_t = (o + Vector2::new(sin_i * n_i, 0.0)) * self.k0;
                let i_o = if self.reflected {
                    cos_i * cos_o - sin_i * sin_o * cos_psi
                } else {
                    -cos_i * cos_o - sin_i * sin_o * cos_psi
                };
                Ok(r.spectrum(&phi_t) * self.obliquity([cos_i, cos_o], i_o, phi_z))
            };
            let half_turn = graded(0.0, std::f64::consts::PI, 0.0, width);
            let area = 2.0 * sin_o * (k_o / std::f64::consts::TAU).powi(2);
            let half = integrate(
                &mut over_azimuth,
                &half_turn,
                self.tolerance,
                absolute / area,
            )?;
            Ok(half * area * self.shadowed(cos_i) * self.shadowed(cos_o))
        };
        integrate(&mut over_polar, &edges, self.tolerance, absolute)
    }

    /// The factor of f beside the lobe, times `cos_o`; 0 where no facet leads from i to o.
    fn obliquity(&self, [cos_i, cos_o]: [f64; 2], i_o: f64, phi_z: f64) -> f64 {
        let [n_i, n_o] = self.indices;
        // i·φ and o·φ over k₀
        let (on_i, on_o) = (n_i + n_o * i_o, n_o + n_i * i_o);
        let side = if self.reflected { 1.0 } else { -1.0 };
        if phi_z == 0.0 || on_i * phi_z <= 0.0 || side * on_o * phi_z <= 0.0 {
            return 0.0;
        }
        match self.energy {
            Energy::Printed => 1.0 / cos_i,
            Energy::Conserving => cos_o,
            Energy::HeightSurface => {
                let vertical = phi_z / self.k0;
                (on_i * on_o).abs() / (cos_i * vertical * vertical)
            }
        }
    }

    fn shadowed(&self, cosine: f64) -> f64 {
        self.slopes
            .map_or(1.0, |slopes| smith_beckmann(slopes, cosine, &Vector2::x()))
    }
}

/// Whether every Gaussian is round and about the mirror direction.
fn check_round(r: &Autocorrelation) -> Result<(), SurfaceError> {
    for family in r.families() {
        let widths = plane::singular_values(family.root()).values;
        let shift = family
            .terms()
            .iter()
            .map(|t| t.shift.norm())
            .fold(0.0, f64::max);
        if (widths[0] - widths[1]).abs() > SAME * widths[0] || shift > 0.0 {
            return Err(SurfaceError::NotRound { widths, shift });
        }
    }
    Ok(())
}

/// Standard deviation of the narrowest lobe, rad/m.
fn narrowest(r: &Autocorrelation) -> f64 {
    let deviations = r.families().iter().flat_map(|family| {
        let root = family.root_determinant().abs().sqrt();
        family.terms().iter().map(move |t| t.rate.sqrt() / root)
    });
    deviations.fold(f64::INFINITY, f64::min)
}
