//! Claim: where the answer can be written down, the renderer finds it.

mod dielectrics;
mod elements;
mod mirrors;
mod paper;
mod plates;
mod rough_metal;
