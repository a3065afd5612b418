//! Light: Stokes vectors, and *generalized* Stokes vectors in Hermite-Gauss space.
//!
//! A generalized Stokes vector is four Stokes parameters of two points: polarization and coherence in one object. Each
//! parameter is a series of Hermite-Gauss functions of the separation, and the four share one shape matrix
//! ([`GeneralizedStokes`]). Where the two points coincide it is the classical [`StokesVector`]. The crate follows
//! sections S1, S2.4, S3 and S4.1 of the supplemental of S. Steinberg and L.-Q. Yan, *Physical Light-Matter Interaction
//! in Hermite-Gauss Space* (2021), below "the paper"; equations are cited by its numbers.
//!
//! ```
//! use nalgebra::{Matrix2, Vector2, Vector3};
//! use stokes::*;
//! // a square lamp of 2 mm, linearly polarized to 30 %, 4 m away in green light
//! let lamp = Envelope::rectangle(1e-3, 1e-3)?;
//! let modes = lamp.modes(ModeWidth::VarianceMatched, 16)?;
//! let (shape, series) = modes.in_direction(&Matrix2::identity())?;
//! let light = GeneralizedStokes::new(
//!     Components::Shared { modes: series, stokes: StokesVector::new(1.0, 0.3, 0.0, 0.0) },
//!     shape,
//!     Frame::with_x_along(Vector3::z(), Vector3::x())?,
//!     Wavelength::from_metres(550e-9)?,
//!     4.0,
//! )?;
//! assert!((light.stokes().stokes.degree_of_polarization() - 0.3).abs() < 1e-15);
//! // van Cittert and Zernike: the first zero of a square's coherence is at λr/width = 1.1 mm, and order 16 leaves 0.004
//! let gamma = light.degree_of_coherence(&Vector2::new(1.1e-3, 0.0));
//! assert!(gamma.norm() < 0.005);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Signs, decided once
//!
//! - **Time factor** `exp(+iωt)`: an absorbing medium has index `n = η − ik` with `k ≥ 0`, and a slow axis
//!   multiplies the field by `e^{−iδ}`.
//! - **Frame**: right-handed `(x, y, z)` with `z` along the propagation of the light. Light is looked at by a
//!   receiver who faces its source, `x` to the right and `y` up; angles are counter-clockwise for that receiver.
//! - **S1 > 0**: the field vibrates along `x`. **S2 > 0**: along `x + y`.
//! - **S3 > 0**: the field turns *clockwise* for that receiver ("right-handed" in optics). In `exp(+iωt)`
//!   `S3 = i⟨E_x E_y* − E_y E_x*⟩ = −2 Im⟨E_x E_y*⟩`, so `E = (1, i)/√2` has `S3 = +1`.
//! - **Spatial phases** are the paper's: forward waves `e^{+ikr}`, Fourier kernel `e^{−iz·x}` without prefactor (the inverse
//!   has `(2π)⁻²`). Both conventions hold together in `C_j(ξ₁, ξ₂) = tr(σ_j ⟨E(r+ξ₂) E†(r+ξ₁)⟩)`, fields in `exp(+iωt)`:
//!   the matrix index of the fields with the two points swapped.
//! - **Separation** `ξ = ξ₁ − ξ₂`, across the ray, in the frame's axes; `C(−ξ) = C(ξ)*`.
//! - **Rotation**: [`FrameRotation`] leads from the old to the new `x` axis; [`Mueller::rotated`] turns the element.
//! - **s and p**: `x` of the frame is s, perpendicular to the plane of incidence (`normal × propagation` on every
//!   side), `y = z × x` is p. Hence `r_p = −r_s` at normal incidence.
//! - **Order of media**: first the one that the light comes from.
//!
//! # Notation
//!
//! | symbol | name | unit | where |
//! |---|---|---|---|
//! | λ₀ | vacuum wavelength | m | [`Wavelength`] |
//! | k = 2π/λ₀ | vacuum wavenumber | rad/m | [`Wavenumber`] |
//! | (x, y, z) | transverse frame, z along propagation | 1 | [`Frame`] |
//! | cos 2t, sin 2t | rotation of a frame by t | 1 | [`FrameRotation`] |
//! | S = [S0, S1, S2, S3] | Stokes vector | W/m², W/(m² sr), … | [`StokesVector`] |
//! | P = √(S1² + S2² + S3²)/S0 | degree of polarization (S4.4) | 1 | [`StokesVector::degree_of_polarization`] |
//! | ς₁, ς₂ | semi-axes of the polarization ellipse (S4.10, corrected) | √ of the unit of S | [`StokesVector::ellipse`] |
//! | ψ = ½ atan2(S2, S1) | orientation of the ellipse (S4.11, corrected) | rad | [`StokesVector::orientation_angle`] |
//! | χ = ½ atan2(S3, √(S1² + S2²)) | ellipticity angle | rad | [`StokesVector::ellipticity_angle`] |
//! | M | Mueller matrix | 1 | [`Mueller`] |
//! | a, b, c, s | diattenuator and retarder on common axes | 1 | [`DiattenuatingRetarder`] |
//! | h_n(t) | Hermite-Gauss function of one variable (S1.1) | 1 | [`hermite`], [`hermite_all`] |
//! | φ_ab(w; W) | whitened orthonormal mode, a + b ≤ N | m | [`whitened_mode`], [`all_modes`], [`all_modes_at`] |
//! | Ψ^Θ_nm, Ψ̃^Θ_nm | the paper's covariant family and its dual (S1.2, S1.3, in the plane) | m^(1±(n+m)) | [`covariant_mode`] |
//! | Sym^N(A) | a linear map's action on the modes of total order N | | [`symmetric_power`] |
//! | Θ | shape matrix (Definition 4.1, Lemma 4.4) | 1/m² | [`ShapeMatrix`] |
//! | W | its root, Θ⁻¹ = WᵀW | m | [`ShapeMatrix::root`] |
//! | y = W w | whitened coordinates | 1 | [`ShapeMatrix::whiten`] |
//! | A, B₁, t₁ | parts of an inverse log-Hessian (S2.14 to S2.17, corrected) | 1/m², 1/m², 1 | [`inverse_log_hessian`] |
//! | č_nm | covariant coefficients (Definition 4.1) | | [`HermiteSeries::from_covariant`] |
//! | c_ab = i^(a+b) s_ab | whitened coefficients, s_ab real | | [`HermiteSeries`] |
//! | r | distance from the last source or scatterer | m | [`GeneralizedStokes::distance`] |
//! | ξ = ξ₁ − ξ₂ | transverse separation of two points | m | [`GeneralizedStokes::at_separation`] |
//! | w = (k/r) ξ | far-field argument (S3.2) | 1/m | [`GeneralizedStokes::far_field_argument`] |
//! | C_j(ξ) | generalized Stokes parameters (S4.6) | that of S | [`GeneralizedStokes::at_separation`] |
//! | I = C_0(0) | spectral intensity (S4.7) | that of S | [`GeneralizedStokes::intensity`] |
//! | γ(ξ) | spectral degree of coherence (S4.8) | 1 | [`GeneralizedStokes::degree_of_coherence`] |
//! | 𝒫(ξ) | degree of cross-polarization (S4.9, corrected) | 1 | [`GeneralizedStokes::degree_of_cross_polarization`] |
//! | 𝒲_j(ζ) | Wigner-Ville distribution (S3.3) | that of S times m² | [`GeneralizedStokes::wigner`] |
//! | I(m) | envelope: intensity over a source | that of S | [`Envelope`] |
//! | f(w) = F{I}(P w) | its angular coherence | that of S times m² | [`Envelope::fourier`] |
//! | D | root of its covariance, DᵀD = Cov | m | [`EnvelopeModes`] |
//! | P | transverse axes in the source's plane, P_rc = t_r·e_c | 1 | [`EnvelopeModes::in_direction`] |
//!
//! # Where the paper's formulas are corrected
//!
//! The paper's sections S1 and S2 are written for three dimensions; light is transverse, so everything here is the
//! two-dimensional form: norm `(π²|Θ|)^(1/4)` in (S1.2), (S1.3) and (S2.10), Fourier factor `2π` in (S2.8), Jacobian
//! `(r/k)²` in (S2.6). Where a printed formula is wrong, `tests/errata` of this crate shows it failing and the one used
//! here holding: (S1.5), the remark after (S1.6), (S1.7) (compositions, not partitions), (S2.12), (S2.13) and
//! Theorem S4.1 (ii) (sign), (S2.17), property (1) of the Wigner function, (S3.4), (S3.5), the cone after (S4.6), (S4.9),
//! (S4.10), (S4.11).
//!
//! # Cost and error
//!
//! What `validation/run_time_against_error.py` measures and writes here, on one core, built for nothing newer than SSE2
//! (`docs/run_time_against_error.csv`, whose first line names machine and date, drawn in
//! `docs/run_time_against_error.png`). Time to sum a Gaussian's series of order N at a point: [`contract`] in f64,
//! [`contract_at`] for 16 points in f32; time to find the coefficients of a square ([`Envelope::modes`]). Errors of the
//! truncated far field in the L² norm, relative: a Gaussian over a shape of twice its variance, a square whose half-width
//! is 4 σ of the shape. Evaluation in f32 adds less than 1e-6 of the largest value (measured within three standard
//! deviations).
//!
//! | N | sum in f64, ns | sum in f32, ns a point | coefficients, µs | error, Gaussian | error, square |
//! |---|---|---|---|---|---|
//! | 0 | 15 | 4.9 | 0.45 | 0.33 | 0.90 |
//! | 2 | 15 | 4.1 | 0.52 | 0.11 | 0.78 |
//! | 4 | 26 | 6.1 | 0.62 | 0.037 | 0.65 |
//! | 8 | 40 | 10 | 0.80 | 0.0041 | 0.38 |
//! | 16 | 148 | 26 | 1.5 | 5.1e-5 | 0.21 |
//! | 32 | 338 | 76 | 3.8 | 7.7e-9 | 0.15 |
//! | 64 | 902 | 256 | 12 | 1.8e-16 | 0.12 |
//!
//! A hard edge converges as N^(−1/4) only: split such a source instead ([`Envelope::patches_for`]).
#![forbid(unsafe_code)]

mod basis;
mod beam;
mod coherence;
mod coherence_ellipse;
mod components;
mod covariant;
mod covariant_series;
mod double;
mod envelope;
mod frame;
mod gaussian;
mod hermite;
mod lanes;
mod log_hessian;
mod mueller;
mod observables;
pub mod plane;
mod realizability;
mod reshape;
mod series;
mod shape;
mod symmetric_power;
mod units;
mod vector;
mod wigner;

pub use basis::{all_modes, mode_count, mode_index, modes, whitened_mode};
pub use beam::{GeneralizedStokes, LEAST_FAR_FIELD, LightError, Loss};
pub use coherence_ellipse::{CoherenceEllipse, CoherenceError};
pub use components::Components;
pub use covariant::{Family, covariant_mode, covariant_mode_at_zero, covariant_mode_fourier};
pub use envelope::{
    Envelope, EnvelopeError, EnvelopeModes, GaussianPatch, GaussianPeak, MAX_PATCHES, ModeWidth,
    Patches, surface_projection,
};
pub use frame::{Frame, FrameError, FrameRotation};
pub use hermite::{MAX_ORDER, Real, hermite};
pub use lanes::{all_modes_at, contract, contract_at, hermite_all, hermite_all_at};
pub use log_hessian::{inverse_log_hessian, inverse_of_sum, log_hessian};
pub use mueller::{DiattenuatingRetarder, Mueller};
pub use observables::{Handedness, PolarizationEllipse};
pub use realizability::{Realizability, Violation};
pub use reshape::overlap;
pub use series::{HermiteSeries, SeriesError};
pub use shape::{MAX_CONDITION, ShapeError, ShapeMatrix};
pub use symmetric_power::symmetric_power;
pub use units::{NotPositive, Wavelength, Wavenumber};
pub use vector::{FramedStokes, StokesVector};
