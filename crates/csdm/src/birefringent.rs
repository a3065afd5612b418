//! Crystal plates: uniaxial, biaxial, absorbing and optically active layers, at any orientation and incidence.
//!
//! A [`CrystalStack`] is a sequence of homogeneous [`Crystal`] layers with parallel faces between isotropic
//! half-spaces; a liquid-crystal cell is a stack of slices, each a little turned. It is solved three ways:
//!
//! - [`CrystalStack::coherent`]: all internal reflections interfere (thin plates, laser light);
//! - [`CrystalStack::incoherent`]: powers of successive internal reflections add, retardance is kept (thick plates);
//! - [`CrystalStack::single_pass`]: no internal reflections (immersed or coated plates, the direct beam).
//!
//! Frames: plate axes x, y in the faces, z the normal, away from the incident medium, right-handed. The s axis lies
//! in the faces at [`Incidence::azimuth`] from x toward y; light travels toward `z × s`. Jones matrices act on
//! `(E_s, E_p)` with `p = k × s` for each ray, so that `r_p = −r_s` for a mirror at normal incidence. Light from the
//! back comes with the same tangential wave vector; the reversed path of the transmitted light is the back of the
//! same stack at azimuth + π, and its matrix is [`JonesMatrix::reversed`](crate::JonesMatrix::reversed) of the matrix
//! forward, powers weighted.
//!
//! Method. Berreman's 4×4 equations are written in waves whose difference of powers is the flux. A thin slice of a
//! layer is then a contraction of the waves that enter it, on both sides; it is doubled by Redheffer's star product
//! until it is the layer. Eigenvectors, which fail where waves coincide, and products of transfer matrices, which
//! overflow in absorbing layers, do not occur; the scattering matrix of a lossless layer is kept unitary, any other a
//! contraction. The price is an error of about `4 f64::EPSILON k₀ d |M|`, |M| ≤ 2(1 + |ε|), in the phase and in what
//! little is absorbed, times the finesse of a resonator, and a hundred small products for each layer. Where single
//! waves are wanted (one pass, incoherent sums, refraction) forward and backward waves are split as two subspaces; in
//! lossless uniaxial crystals these have a closed form, in other lossless crystals they are found in real numbers.
//!
//! Source: Berreman, J. Opt. Soc. Am. 62, 502 (1972); Redheffer, J. Math. and Phys. 41, 1 (1962), for the star product.

mod clear;
mod crystal;
mod faces;
mod generator;
mod half_space;
mod refraction;
mod scattering;
mod stack;
mod uniaxial;

pub use crystal::{Crystal, CrystalError};
pub use refraction::RefractedWave;
pub use stack::{
    CrystalLayer, CrystalStack, Incidence, JonesSide, MuellerSide, PlateJones, PlateMueller,
};

#[cfg(test)]
mod tests;
