//! The energy of a rough surface, and the reciprocal cap that keeps it from making light.
//!
//! ```text
//! A(i) = ∫ f cos_o dω / (1 − e^(−g)),  M = 1          g in the mirror or Snell direction of i
//! f → f / max(1, A(i), A(o))
//! ```
//!
//! As `g` depends on the outgoing direction, nothing guarantees `A = 1`: it is 1.000 up to 30° and for smooth or gentle
//! relief, and grows toward grazing incidence.

use nalgebra::Matrix2;
use stokes::Wavelength;

use super::Passage;
use super::error::SurfaceError;
use super::hemisphere::Hemisphere;
use super::table::Table;
use crate::accuracy::Tolerance;
use crate::geometry::Geometry;
use crate::relief::Relief;
use crate::theorem::Energy;

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
    /// When the lobe of the relief is not round and centred, the relief has no autocorrelation for some `φ_z`, or an index
    /// is not a number between 1e-3 and 1e3.
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
            )?)
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
