//! Brewster: a polarization-aware renderer, from scene file to Stokes image.
#![deny(unsafe_code)]

pub mod cli;
pub mod compare;
pub mod image;
pub mod maps;
pub mod output;
