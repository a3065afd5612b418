//! Claim: matter and light that only waves explain agree with closed forms through the whole program.
//!
//! One module a plugin or a subject.

mod birefringent;
mod clear_sky;
mod coherence;
mod egsm;
mod emitters;
mod given_matrices;
mod grating;
mod irradiancemeter;
mod layered;
mod mueller;
mod partial_light;
mod plastic;
mod rhomb;
mod roughdielectric;
mod roughsurface;
mod scatterer16;
mod slits;
mod thindielectric;
mod through_plates;
mod wave_scenes;
