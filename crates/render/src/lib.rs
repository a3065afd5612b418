//! Brewster: a polarization-aware renderer, from scene file to Stokes image.
#![deny(unsafe_code)]

pub mod cli;
pub mod colour;
pub mod ior;
pub mod spectrum;
