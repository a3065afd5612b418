//! Claim: matter and light that only waves explain agree with closed forms through the whole program.
//!
//! One module a plugin or a subject.

mod birefringent;
mod given_matrices;
mod layered;
mod clear_sky;
mod egsm;
mod emitters;
mod mueller;
mod rhomb;
mod through_plates;
