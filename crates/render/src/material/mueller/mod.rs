//! `mueller`: any element or surface of which the Mueller matrix is known.
//!
//! | parameter  | type   | meaning                                                                               | default |
//! |------------|--------|---------------------------------------------------------------------------------------|---------|
//! | `matrix`   | string | 16 numbers, row by row                                                                | –       |
//! | `filename` | string | instead: a table of matrices over wavelength and angle                                | –       |
//! | `mode`     | string | `transmission`: straight through; `reflection`: a mirror                              | `transmission` |
//! | `theta`    | float  | degrees by which the element is turned about its normal, from U toward V; not for mirrors | 0   |
//!
//! ```xml
//! <bsdf type="mueller"><string name="matrix" value="0.5 0.5 0 0  0.5 0.5 0 0  0 0 0 0  0 0 0 0"/></bsdf>
//! ```
//!
//! Transmission, both sides: the matrix holds for light that leaves toward the side of the normal; its first axis is U
//! projected across the ray, as for `retarder`. From the other side it is X Mᵀ X, X = diag(1, 1, −1, 1): what reciprocity
//! says. Reflection, one side: the first axis is perpendicular to the plane of incidence (s).
//!
//! A table is a text of rows of numbers. A header of words on top names its columns: `wavelength_nm`, `angle_deg` (to the
//! normal), one or both, then `m00 m01 … m33`. It must be complete: all angles at all wavelengths. Between its entries matrices are
//! interpolated linearly, which keeps them possible; at angles outside the nearest one holds, wavelengths outside are an error.
//!
//! A matrix that no mixture of Jones matrices makes, or that gains power, is refused. Eigenvalues of its coherency matrix
//! down to −1e-3 times the largest count as rounding: the nearest matrix that is possible is taken, and a notice says so.
//!
//! Source: Cloude, Optik 75, 26 (1986), for what is possible.

mod table;

use glam::Vec3A;
use mueller16::element;
use stokes::Mueller;

use super::polarizer::axis_for;
use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, mirror, narrowed};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::scene::{Object, SceneError};
use table::Table;

/// An element given by its Mueller matrices.
#[derive(Clone, Debug)]
pub struct MuellerElement {
    table: Table,
    reflects: bool,
    turn: (f64, f64),
    effect: Effect,
}

impl MuellerElement {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let table = match (object.has("matrix"), object.has("filename")) {
            (true, false) => Table::of_matrix(object)?,
            (false, true) => Table::of_file(object)?,
            _ => {
                return Err(object.error(
                    "bsdf 'mueller' has no matrix or two, expected either 'matrix' or 'filename'",
                ));
            }
        };
        let mode = object.choice("mode", "transmission", &["transmission", "reflection"])?;
        let reflects = mode == "reflection";
        let theta = if reflects {
            0.0
        } else {
            object.float("theta", 0.0)?.to_radians()
        };
        let effect = table.effect();
        Ok(Self {
            table,
            reflects,
            turn: theta.sin_cos(),
            effect,
        })
    }

    /// Whether it is a mirror, met from one side only.
    pub fn is_mirror(&self) -> bool {
        self.reflects
    }
}

impl Matter for MuellerElement {
    fn sample(&self, at: &Vertex, _: &[f32], _: [f32; 3]) -> Option<Departure> {
        if !self.reflects {
            return Some(Departure::straight(at.o, 1.0));
        }
        (at.o.z > 0.0).then(|| Departure::mirrored(at.o, 1.0))
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let cos = i.z.abs().min(1.0);
        let from_back = !self.reflects && at.o.z < 0.0;
        let axis = if self.reflects {
            axis_s(Vec3A::Z, i)
        } else {
            axis_for(at.o, |k| element::retarder_fast_axis(self.turn, k))
        };
        let response = L::general(axis, axis, |lane| {
            let matrix = self.table.at(wavelengths[lane], cos);
            narrowed(&if from_back { matrix.reversed() } else { matrix })
        });
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, _: Part, _: &[f32]) -> Option<Vec3A> {
        Some(if self.reflects {
            mirror(at.o, Vec3A::Z)
        } else {
            -at.o
        })
    }

    fn is_grey(&self, _: [f64; 2]) -> bool {
        self.table.is_grey()
    }

    fn effect(&self) -> Effect {
        self.effect
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: !self.reflects,
            ..Traits::default()
        }
    }

    fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        self.table.check(range)
    }
}

/// What a matrix can do to polarization, from either side.
fn effect_of(mueller: &Mueller) -> Effect {
    let m = |row, column| mueller.element(row, column) != 0.0;
    let pure = csdm::CloudeSpectrum::of(mueller)
        .and_then(|spectrum| spectrum.jones_matrix(1e-9))
        .is_ok();
    Effect {
        depolarizes: !pure,
        makes_linear: m(1, 0) || m(2, 0) || m(0, 1) || m(0, 2),
        makes_circular: m(3, 0) || m(0, 3),
        retards: m(3, 1) || m(3, 2) || m(1, 3) || m(2, 3),
    }
}

#[cfg(test)]
mod tests;
