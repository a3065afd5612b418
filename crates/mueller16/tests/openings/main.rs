//! Claims: scatterers and openings that are not locally stationary diffract as Lemma 4.3 says.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod angular_spectrum;
mod as_points;
mod energy;
mod fresnel_arago;
mod near_slits;
mod numbers;
mod patterns;
mod point_scatterers;
mod visibility;
