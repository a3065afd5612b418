//! Brewster: a polarization-aware renderer, from scene file to Stokes image.

pub mod analyzer;
pub mod cli;
pub mod coherence;
pub mod colour;
pub mod compare;
pub mod emitter;
pub mod engine;
pub mod eval;
pub mod film;
pub mod filter;
pub mod geometry;
pub mod image;
mod intrinsics;
pub mod ior;
pub mod lanes;
pub mod light;
pub mod lights;
pub mod maps;
pub mod material;
pub mod output;
pub mod path;
pub mod plan;
pub mod sampler;
pub mod scene;
pub mod sensor;
pub mod shape;
pub mod spectrum;
