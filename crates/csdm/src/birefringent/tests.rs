//! Tests of crystal plates: closed forms, an independent calculation, laws.

mod cells;
mod fast;
mod incoherent;
mod laws;
mod plates;

use super::*;
use crate::JonesMatrix;
use num_complex::Complex64;
use stokes::Wavelength;

const I: Complex64 = Complex64::I;
const LAMBDA: f64 = 500e-9;

fn light() -> Wavelength {
    Wavelength::from_metres(LAMBDA).unwrap()
}

fn layer(crystal: &Crystal, wavelengths: f64) -> CrystalLayer {
    CrystalLayer {
        crystal: crystal.clone(),
        thickness: wavelengths * LAMBDA,
    }
}

fn stack(before: f64, layers: Vec<CrystalLayer>, behind: f64) -> CrystalStack {
    CrystalStack::new(before, layers, behind.into()).unwrap()
}

fn at(cos_i: f64, azimuth: f64) -> Incidence {
    Incidence::new(cos_i, azimuth).unwrap()
}

fn distance(a: &JonesMatrix, b: &JonesMatrix) -> f64 {
    (a.to_matrix() - b.to_matrix()).norm()
}

fn scaled(jones: JonesMatrix, factor: Complex64) -> JonesMatrix {
    JonesMatrix::diagonal(factor, factor) * jones
}

fn isotropic(n: f64) -> Crystal {
    Crystal::isotropic(n.into()).unwrap()
}
