//! Claim: matter and light that only waves explain agree with closed forms through the whole program.
//!
//! One module a plugin or a subject.

mod birefringent;
mod clear_sky;
mod coherence;
mod egsm;
mod emitters;
mod given_matrices;
mod layered;
mod mueller;
mod rhomb;
mod through_plates;
mod wave_scenes;
