//! Random ensembles of fields at two points, for the property tests of the cross-spectral density matrix.

use nalgebra::Vector2;
use num_complex::Complex64;
use proptest::prelude::*;

use crate::csdm::CrossSpectralDensity;

fn complex() -> impl Strategy<Value = Complex64> {
    (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(re, im)| Complex64::new(re, im))
}

/// An ensemble of up to three fields, each at two points.
pub(crate) fn fields() -> impl Strategy<Value = Vec<[Vector2<Complex64>; 2]>> {
    let pair = prop::array::uniform4(complex())
        .prop_map(|[a, b, c, d]| [Vector2::new(a, b), Vector2::new(c, d)]);
    prop::collection::vec(pair, 1..4)
}

/// The sum of `⟨E(r_i) E(r_j)†⟩` over the ensemble.
pub(crate) fn average(
    fields: &[[Vector2<Complex64>; 2]],
    i: usize,
    j: usize,
) -> CrossSpectralDensity {
    fields
        .iter()
        .map(|pair| CrossSpectralDensity::of_fields(pair[i], pair[j]))
        .reduce(|sum, one| sum.plus(&one))
        .unwrap()
}
