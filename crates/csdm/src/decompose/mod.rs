//! What kind of element a Mueller matrix is: which Jones matrices make it up, and which diattenuator, retarder and
//! depolarizer.

mod cloude;
mod lu_chipman;
mod realizable;
mod rotation3;
mod svd3;

use nalgebra::Matrix4;

pub use cloude::{CloudeSpectrum, WeightedJones, coherency_matrix};
pub use lu_chipman::{NoPolarDecomposition, PolarDecomposition};
pub use realizable::NotRealizable;

/// The first element, by rows, that is infinite or not a number: its row, its column and its value.
fn not_finite(matrix: &Matrix4<f64>) -> Option<(usize, usize, f64)> {
    (0..16)
        .map(|i| (i / 4, i % 4, matrix[(i / 4, i % 4)]))
        .find(|(.., value)| !value.is_finite())
}
