//! The energy of a rough surface, and the reciprocal cap that keeps it from making light.
//!
//! ```text
//! A(i) = ∫ f cos_o dω / (1 − e^(−g)),  M = 1          g in the mirror or Snell direction of i
//! f → f / max(1, A(i), A(o))
//! ```
//!
//! As `g` depends on the outgoing direction, nothing guarantees `A = 1`: it is 1.000 up to 30° and for smooth or gentle
//! relief, and grows toward grazing incidence.

use nalgebra::{Matrix2, Vector2};
use stokes::{Wavelength, plane};

use super::error::SurfaceError;
use super::quadrature::{graded, integrate};
use super::{Passage, smith_beckmann};
use crate::accuracy::Tolerance;
use crate::autocorrelation::Autocorrelation;
use crate::geometry::Geometry;
use crate::relief::Relief;
use crate::theorem::Energy;

/// Least cosine in a table; below it `ln A` goes on as a line in `ln cos`.
const LEAST: f64 = 1e-3;
/// Intervals of `ln cos` to begin with.
const INTERVALS: usize = 6;
/// How often one is halved at most.
const DEEPEST: usize = 6;
/// Relative difference of wavelengths or indices that are meant to be one.
const SAME: f64 = 1e-9;

/// The diffuse energy of a relief between two media at one wavelength, tabulated over the angle of incidence.
///
/// With the factor `1/max(1, A(i), A(o))` on the diffuse part, mirror and diffuse light together have at most the
/// incident power, and reciprocity is kept. With shadowing in A the cap is idle where the surface is a microfacet model.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyCap {
    wavelength: Wavelength,
    incident: f64,
    passage: Passage,
    /// From the incident medium; for transmission also from the other one.
    tables: Vec<Table>,
}

impl EnergyCap {
    /// The table for light of a wavelength from a medium of index `incident`, reflected or passing into another.
    ///
    /// `slopes` are those of the shadowing, if there is any. The integral over the hemisphere and the interpolation in the
    /// table each keep the tolerance, but no better than 1e-6; see [`EnergyCap::error`].
    ///
    /// # Errors
    ///
    /// When the lobe of the relief is not round and centred, or the relief has no autocorrelation for some `φ_z`.
    pub fn new(
        relief: &impl Relief,
        energy: Energy,
        slopes: Option<&Matrix2<f64>>,
        wavelength: Wavelength,
        incident: f64,
        passage: Passage,
        tolerance: Tolerance,
    ) -> Result<Self, SurfaceError> {
        let tolerance = tolerance.get().max(1e-6);
        let from = |incident, passage| {
            Table::new(&Hemisphere::new(
                relief, energy, slopes, wavelength, incident, passage, tolerance,
            ))
        };
        let mut tables = vec![from(incident, passage)?];
        if let Passage::TransmissionInto(other) = passage {
            tables.push(from(other, Passage::TransmissionInto(incident))?);
        }
        Ok(Self {
            wavelength,
            incident,
            passage,
            tables,
        })
    }

    /// `1/max(1, A(i), A(o))`; `None` for another wavelength, other media, or the other of reflection and transmission.
    #[must_use]
    pub fn factor(&self, geometry: &Geometry) -> Option<f64> {
        let same = |a: f64, b: f64| (a - b).abs() <= SAME * b;
        let (n_i, n_o) = (geometry.n_incident(), geometry.n_outgoing());
        if !same(geometry.wavelength().metres(), self.wavelength.metres()) {
            return None;
        }
        let [from_i, from_o] = match self.passage {
            Passage::Reflection if geometry.is_reflection() && same(n_i, self.incident) => [0, 0],
            Passage::TransmissionInto(other) if !geometry.is_reflection() => {
                if same(n_i, self.incident) && same(n_o, other) {
                    [0, 1]
                } else if same(n_o, self.incident) && same(n_i, other) {
                    [1, 0]
                } else {
                    return None;
                }
            }
            _ => return None,
        };
        let a_i = self.tables[from_i].value(geometry.cos_incident().abs());
        let a_o = self.tables[from_o].value(geometry.cos_outgoing().abs());
        Some(1.0 / a_i.max(a_o).max(1.0))
    }

    /// `A` for light from the incident medium at this cosine, in `0.0..=1.0`, as the table has it: to [`EnergyCap::error`]
    /// where it is above 1, coarser below, where the cap is idle.
    #[must_use]
    pub fn albedo_ratio(&self, cosine: f64) -> f64 {
        self.tables[0].value(cosine.abs())
    }

    /// Relative error of the interpolated A, the largest that was found in the middles of the table's last intervals, for
    /// cosines of at least 1e-3.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.tables.iter().map(|t| t.error).fold(0.0, f64::max)
    }
}

/// What is integrated: all outgoing directions of light from one side.
pub(super) struct Hemisphere<'a, R> {
    relief: &'a R,
    energy: Energy,
    slopes: Option<&'a Matrix2<f64>>,
    k0: f64,
    /// Of the incident and the outgoing medium.
    indices: [f64; 2],
    reflected: bool,
    tolerance: f64,
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
    ) -> Self {
        let (outgoing, reflected) = match passage {
            Passage::Reflection => (incident, true),
            Passage::TransmissionInto(other) => (other, false),
        };
        Self {
            relief,
            energy,
            slopes,
            k0: wavelength.wavenumber().radians_per_metre(),
            indices: [incident, outgoing],
            reflected,
            tolerance,
        }
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
    fn ratio(&self, cos_i: f64) -> Result<f64, SurfaceError> {
        let Albedo { diffuse, share } = self.albedo(cos_i)?;
        Ok(if share > 0.0 { diffuse / share } else { 0.0 })
    }

    /// Errors below the tolerance times itself and times the share.
    pub(super) fn albedo(&self, cos_i: f64) -> Result<Albedo, SurfaceError> {
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

/// `ln A` over `ln cos`, interpolated by cubics that are monotone where the values are.
///
/// Source: Fritsch and Carlson 1980, Monotone Piecewise Cubic Interpolation, with the slopes of Fritsch and Butland 1984.
#[derive(Clone, Debug, PartialEq)]
struct Table {
    /// `ln cos`, increasing to 0.
    x: Vec<f64>,
    /// `ln A`
    y: Vec<f64>,
    slopes: Vec<f64>,
    error: f64,
}

impl Table {
    fn new<R: Relief>(hemisphere: &Hemisphere<'_, R>) -> Result<Self, SurfaceError> {
        // a surface without diffuse light has A = 0
        let value = |x: f64| Ok::<_, SurfaceError>(hemisphere.ratio(x.exp())?.max(1e-300).ln());
        let mut nodes = vec![];
        for step in 0..=INTERVALS {
            let x = LEAST.ln() * (1.0 - step as f64 / INTERVALS as f64);
            nodes.push((x, value(x)?, true));
        }
        let mut error: f64 = 0.0;
        for depth in 0..=DEEPEST {
            let table = Self::of(&nodes);
            let mut finer = vec![nodes[0]];
            let mut worst: f64 = 0.0;
            for pair in nodes.windows(2) {
                let ((a, _, _), (b, last, open)) = (pair[0], pair[1]);
                if open {
                    let middle = 0.5 * (a + b);
                    let exact = value(middle)?;
                    // where the cap is idle on both sides A need not be known
                    let off = (table.log_value(middle).max(0.0) - exact.max(0.0)).abs();
                    let again = off > hemisphere.tolerance && depth < DEEPEST;
                    worst = worst.max(off);
                    if !again {
                        error = error.max(off);
                    }
                    finer.push((middle, exact, again));
                    finer.push((b, last, again));
                } else {
                    finer.push((b, last, false));
                }
            }
            nodes = finer;
            if worst <= hemisphere.tolerance {
                break;
            }
        }
        let mut table = Self::of(&nodes);
        table.error = error.exp_m1();
        Ok(table)
    }

    fn of(nodes: &[(f64, f64, bool)]) -> Self {
        let x: Vec<f64> = nodes.iter().map(|n| n.0).collect();
        let y: Vec<f64> = nodes.iter().map(|n| n.1).collect();
        let secants: Vec<f64> = (1..x.len())
            .map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1]))
            .collect();
        let last = secants.len();
        let slopes = (0..=last)
            .map(|i| {
                if i == 0 || i == last {
                    return secants[i.min(last - 1)];
                }
                let (left, right) = (secants[i - 1], secants[i]);
                if left * right <= 0.0 {
                    return 0.0;
                }
                let (h1, h2) = (x[i] - x[i - 1], x[i + 1] - x[i]);
                let (w1, w2) = (2.0 * h2 + h1, h2 + 2.0 * h1);
                (w1 + w2) / (w1 / left + w2 / right)
            })
            .collect();
        Self {
            x,
            y,
            slopes,
            error: 0.0,
        }
    }

    fn value(&self, cosine: f64) -> f64 {
        self.log_value(cosine.max(f64::MIN_POSITIVE).ln().min(0.0))
            .exp()
    }

    fn log_value(&self, at: f64) -> f64 {
        let (x, y) = (&self.x, &self.y);
        if at <= x[0] {
            return y[0] + self.slopes[0] * (at - x[0]);
        }
        let i = x.partition_point(|node| *node < at).clamp(1, x.len() - 1);
        let h = x[i] - x[i - 1];
        let t = (at - x[i - 1]) / h;
        let (one, back) = (t * t * (3.0 - 2.0 * t), 1.0 - t);
        y[i - 1] * (1.0 - one)
            + y[i] * one
            + h * t * back * (self.slopes[i - 1] * back - self.slopes[i] * t)
    }
}
