//! Fields behind the light: Jones matrices, cross-spectral density matrices, ensembles, interfaces, films, crystals,
//! and Gaussian Schell-model beams.
//!
//! The crate `stokes` describes light by (generalized) Stokes parameters. Here are the fields that these are averages
//! of: what an element does to one realization of a field ([`JonesMatrix`]), what it does in the mean to a pair of
//! points ([`Element`]), and the two-way bridge to the sixteen numbers between Stokes parameters
//! ([`GeneralizedMueller`], [`CloudeSpectrum`]). It follows sections S4, S4.1 and S4.3 of the supplemental of S.
//! Steinberg and L.-Q. Yan, *Physical Light-Matter Interaction in Hermite-Gauss Space* (2021); equations are cited by
//! its numbers.
//!
//! ```
//! use csdm::film::Stack;
//! use stokes::{StokesVector, Wavelength};
//! // Fresnel's rhomb, index 1.49661, met inside at 51.782°: 45° of phase between p and s at each of two bounces
//! let sodium = Wavelength::from_metres(589.3e-9)?;
//! let face = Stack::new(1.49661, vec![], 1.0.into())?.amplitudes(51.782f64.to_radians().cos(), sodium);
//! let phase = (face.reflected.p / face.reflected.s).arg();
//! assert!((phase.abs().to_degrees() - 45.0).abs() < 1e-3);
//! // linear light at +45° leaves it right circular
//! let rhomb = face.reflection() * face.reflection();
//! let out = rhomb.mueller() * StokesVector::DIAGONAL;
//! assert!((out - StokesVector::RIGHT_CIRCULAR).to_vector().norm() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Signs
//!
//! Those of the page of [`stokes`]; what they mean for fields:
//!
//! - **Time factor** `exp(+iωt)`: the real field is `Re[E e^{iωt}]`; indices are `n = η − ik`; a wave that travels
//!   along `+z` is `e^{−ikz}` and decays in an absorbing medium. Programs in `exp(−iωt)` have the conjugate of every
//!   amplitude.
//! - **Jones matrices** act on `(E_x, E_y)` in the frame of the ray. `x` is s and `y` is p at an interface; each ray
//!   has its own p axis, `p = k × s`, so that `r_p = −r_s` at normal incidence and a mirror has the matrix of a
//!   half-wave plate.
//! - **Products** are met from the right: `second * first`.
//! - **Two points**: a matrix of the points `first` and `second` is `⟨E(r₁) E(r₂)†⟩`. Light in the phase convention
//!   of the renderer has the points exchanged: [`CrossSpectralDensity::of_light`] leads from it to fields, and
//!   [`GeneralizedMueller::scattering`] from elements to it.
//! - **Powers**: amplitudes of transmission are of the electric field; [`fresnel::power_weight`] leads to powers, and
//!   Mueller matrices of transmission contain it. The change of radiance with the solid angle (n²) is in none of
//!   them.
//! - **Angles** are counter-clockwise for a receiver who faces the source: [`JonesMatrix::rotated`] turns the element.
//!
//! # Notation
//!
//! | symbol | name | unit | where |
//! |---|---|---|---|
//! | E = (E_x, E_y) | field in `exp(+iωt)` | √ of that of S | [`stokes_vector`] |
//! | T, J | Jones matrix | 1 | [`JonesMatrix`] |
//! | δ | retardance: the slow axis gets `e^{−iδ}` | rad | [`JonesMatrix::linear_retarder`] |
//! | ψ, χ | azimuth and ellipticity of an eigenpolarization | rad | [`JonesMatrix::homogeneous`] |
//! | T = U H | retarder behind diattenuator | 1 | [`JonesPolar`] |
//! | C(r₁, r₂) | cross-spectral density matrix (S4.1) | that of S | [`CrossSpectralDensity`] |
//! | I = tr C | spectral intensity (S4.2) | that of S | [`CrossSpectralDensity::intensity`] |
//! | γ(r₁, r₂) | spectral degree of coherence (S4.3) | 1 | [`CrossSpectralDensity::spectral_degree_of_coherence`] |
//! | P | degree of polarization (S4.4) | 1 | [`CrossSpectralDensity::degree_of_polarization`] |
//! | σ_j = 2 τ_j | Pauli matrices in the order of S (S4.5) | 1 | [`CrossSpectralDensity`] |
//! | C_j = tr(σ_j C) | generalized Stokes parameters (S4.6) | that of S | [`CrossSpectralDensity::generalized_stokes`] |
//! | 𝒫(r₁, r₂) | degree of cross-polarization (S4.9, corrected) | 1 | [`CrossSpectralDensity::degree_of_cross_polarization`] |
//! | E_(ap),(bq) | moments `⟨T_ap(r₁) T*_bq(r₂)⟩` (S4.12) | 1 | [`TransferTensor`] |
//! | M_lj(r₁, r₂) | the sixteen | 1 | [`GeneralizedMueller`] |
//! | Σ^(j→l) = M_lj* | mutual scattering functions (Theorem S4.1) | 1 | [`GeneralizedMueller::scattering`] |
//! | H, λ_i | Cloude's coherency matrix, its eigenvalues | 1 | [`coherency_matrix`], [`CloudeSpectrum`] |
//! | M_Δ M_R M_D | depolarizer, retarder, diattenuator of Lu & Chipman | 1 | [`PolarDecomposition`] |
//! | s_x, s_y; c; l | deviations, correlation, lengths of random phases | rad; 1; m | [`PhaseScreen`] |
//! | n = η − ik | refractive index | 1 | [`fresnel`], [`film::Layer`] |
//! | w = n₂ cos θ₂ | normal component of the wave vector over k₀ | 1 | [`fresnel::normal_index`] |
//! | r_s, r_p, t_s, t_p | amplitudes of an interface or a stack | 1 | [`fresnel::Amplitudes`] |
//! | ε, gyration | permittivity and optical activity of a crystal | 1 | [`birefringent::Crystal`] |
//! | A, B, C, D | ray-transfer matrix | 1, m, 1/m, 1 | [`RayTransfer`], [`AstigmaticTransfer`] |
//! | A_i, B_xy, σ, δ_ij | Schell-model source | √S, 1, m, m | [`SchellSource`] |
//! | Σ, L, K | spread, coherence and curvature of a Schell-model beam | m², m², 1/m² | [`SchellBeam`] |
//!
//! # Where the paper's formulas are corrected
//!
//! Each with a test that shows the printed claim failing, in `tests/errata.rs` unless another place is named.
//!
//! - (S4.5), (S4.6): with the `e^{−iωt}` that belongs to the paper's `e^{+ikr}`, `C_3` is *minus* the S3 of optics.
//!   Here fields are in `exp(+iωt)`, and nothing changes sign.
//! - (S4.4): `√(1 − 4 det C/tr² C)` as written has lost its digits for nearly unpolarized light, and with it `1 − P`
//!   for nearly polarized light (`src/coherence.rs`); [`CrossSpectralDensity::unpolarized_fraction`] has them.
//! - Below (S4.6): the cone `|(C_1, C_2, C_3)| ≤ |C_0|` holds at one point only (`src/positivity.rs`); of two points
//!   [`CrossSpectralDensity::check_pair`] holds.
//! - (S4.9): `1/|C_0|` and moduli in place of `1/C_0²` and squares (`src/coherence.rs`).
//! - Below (S4.12): a deterministic element has 14 real numbers at two points and an ensemble 16 complex ones, not 16
//!   real ones each (`src/sixteen.rs`).
//! - Theorem S4.1: the sixteen are signed mutual intensities, no squares of sixteen scattering amplitudes; and
//!   wherever the phase of `T` depends on the place they enter as `M_lj*` (`src/ensemble/varying.rs`: without the
//!   conjugate a polarization grating deflects to the wrong side; `tests/two_conventions.rs`).
#![forbid(unsafe_code)]

mod abcd;
pub mod birefringent;
mod coherence;
mod csdm;
mod decompose;
mod doubled;
mod elements;
mod ensemble;
pub mod film;
pub mod fresnel;
mod jones;
mod jones_polar;
mod layered;
mod positivity;
mod scale;
mod schell;
mod sixteen;
#[cfg(test)]
mod test_ensembles;

pub use abcd::{AstigmaticTransfer, RayTransfer, RayTransferError};
pub use csdm::CrossSpectralDensity;
pub use decompose::{
    CloudeSpectrum, NoPolarDecomposition, NotRealizable, PolarDecomposition, WeightedJones,
    coherency_matrix,
};
pub use elements::ElementError;
pub use ensemble::{
    BadWeights, CorrelationLengths, Element, GaussianAperture, LightEstimate, Mixture, MonteCarlo,
    PatternError, PhaseScreen, RandomStream, RoughRetarder, ScreenError, Sequence, SixteenEstimate,
    TooFewSamples, Turned, Varying, VoltageResponse, liquid_crystal_modulator,
    polarization_grating,
};
pub use jones::{JonesMatrix, stokes_vector};
pub use jones_polar::JonesPolar;
pub use positivity::CoherenceError;
pub use schell::{SchellBeam, SchellError, SchellSource};
pub use sixteen::{GeneralizedMueller, NotReal, TransferTensor};
