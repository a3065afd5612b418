//! Lemma 4.3 for rectangular openings in an opaque screen: slits under partially coherent light.
//!
//! ```text
//! F_n(κ)  = a b sinc(κ_x a/2π) sinc(κ_y b/2π) e^(−iκ·x_n),   sinc u = sin(πu)/(πu)
//! T̃(κ)    = Σ_n T_n F_n(κ)*                                       Jones matrix of the screen for one plane wave, m²
//! f_t     = (n_o²/(λ₀² A_s)) ∫ p(q) M(T̃(φ_t + q)) d²q             1/sr, p the light's distribution of wave vectors
//!         = (n_o²/(λ₀² A_s)) Σ_nm M(T_n, T_m)* ∫∫_nm γ(x₁ − x₂) e^(−iφ·(x₁ − x₂)) d²x₁ d²x₂
//! ```
//!
//! Both lines are one: `γ(x) = ∫ p(q) e^(−iq·x) d²q` (Van Cittert and Zernike). The first is what is computed: light is a
//! list of incoherent plane waves ([`AngularSpectrum`]), the coherence over every single opening is kept, and with
//! weights that are not negative each result is a sum of Mueller matrices of Jones matrices, hence realizable. With
//! `A_s` the area of the screen, the albedo is the open fraction; radiant intensity is `f_t cos_i cos_o A_s E`, radiance
//! `f_t cos_i E`, with E the irradiance across the incident ray.
//!
//! # More than one such element
//!
//! A screen is no locally stationary matter: light behind it has a coherence that depends on where it is, not on
//! separations alone. For one screen seen by a receiver that does not matter, and any incoherent source is served by the
//! average over its points. For a chain of two (slits behind slits) the light between them must be kept as a function of
//! two points: neither radiance, nor the modes of Lemma 4.3 about one direction, which change from place to place on the
//! second screen as fast as its fringes do. What such a chain needs is, for each plane wave of the source, the field: a sum
//! over all paths through opening n of the first and m of the second of `T_m T_n` times the phase of the path
//! ([`Openings::seen_between`] has the phases of one leg), squared at the end, then the sum over the waves.

mod error;
mod lit;
mod points;
mod rules;
mod screen;
mod spectrum;
mod view;

pub use error::OpeningError;
pub use lit::LitOpenings;
pub use screen::{Opening, Openings, fringe_visibility};
pub use spectrum::{AngularSpectrum, PlaneWave};
pub use view::SlitView;
