//! Matter: interfaces and optical elements as Mueller matrices.
//!
//! Signs and frames are those of the page of [`stokes`]. [`DielectricInterface`] and [`ConductorInterface`] are
//! smooth boundaries, written between the s-p frames of the two rays; [`element`] holds ideal polarizers and
//! retarders and says where their axes lie for an oblique ray.
#![forbid(unsafe_code)]

pub mod element;
mod interface;

pub use interface::{ConductorInterface, DielectricInterface, IndexError, Transmitted};
