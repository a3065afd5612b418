//! Light: Stokes vectors, transverse frames, Mueller matrices.
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
//! | k₀ = 2π/λ₀ | vacuum wavenumber | rad/m | [`Wavenumber`] |
//! | (x, y, z) | transverse frame, z along propagation | 1 | [`Frame`] |
//! | cos 2t, sin 2t | rotation of a frame by t | 1 | [`FrameRotation`] |
//! | S = [S0, S1, S2, S3] | Stokes vector | W/m², W/(m² sr), … | [`StokesVector`] |
//! | P = √(S1² + S2² + S3²)/S0 | degree of polarization | 1 | [`StokesVector::degree_of_polarization`] |
//! | ψ = ½ atan2(S2, S1) | angle of linear polarization | rad | [`StokesVector::angle_of_linear_polarization`] |
//! | χ = ½ atan2(S3, √(S1² + S2²)) | ellipticity angle | rad | [`StokesVector::ellipticity_angle`] |
//! | M | Mueller matrix | 1 | [`Mueller`] |
//! | I(x), f(w) = F{I}(Pw) | intensity profile, its far field | any, × m² | [`Envelope`] |
//! | P | a plane's axes seen along a ray | 1 | [`surface_projection`] |
//! | D, W = D P | root of a profile's modes, of their shape | m | [`EnvelopeModes::in_direction`] |
//! | μ_ab | modes of a profile's far field | – | [`EnvelopeModes`] |
//! | a, b, c, s | diattenuator and retarder on common axes | 1 | [`DiattenuatingRetarder`] |
//!
//! # Cost and error
//!
//! What `cargo run --release -p stokes --example run_time_against_error -- OUT.csv` prints, on one core of a 2 GHz Xeon
//! that others used too (`docs/run_time_against_error.csv`; its build knows nothing newer than SSE2). Nanoseconds to
//! sum a series of order N at a point: [`contract`] in f64, [`contract_at`] for 16 points in f32. Errors of the
//! truncated far field in the L² norm, relative: a Gaussian over a shape of twice its variance, a square whose
//! half-width is 4 σ of the shape. Evaluation in f32 adds less than 1e-6 of the largest value (measured
//! within three standard deviations).
//!
//! | N | f64, ns | f32, 16 points, ns a point | Gaussian | square |
//! |---|---|---|---|---|
//! | 0 | 12 | 3.5 | 0.33 | 0.90 |
//! | 2 | 18 | 4.6 | 0.11 | 0.78 |
//! | 4 | 27 | 6.2 | 0.037 | 0.65 |
//! | 8 | 50 | 15 | 0.0041 | 0.38 |
//! | 16 | 210 | 39 | 5.1e-5 | 0.21 |
//! | 32 | 502 | 113 | 7.7e-9 | 0.15 |
//! | 64 | 1167 | 389 | 1.8e-16 | 0.12 |
//!
//! A hard edge converges as N^(−1/4) only: split such a source instead ([`Envelope::patches_for`]).
#![forbid(unsafe_code)]

mod basis;
mod beam;
mod envelope;
mod frame;
mod gaussian;
mod hermite;
mod lanes;
mod mueller;
mod observables;
mod plane;
mod reshape;
mod series;
mod shape;
mod symmetric_power;
mod units;
mod vector;

pub use basis::{all_modes, mode_count, mode_index, modes, whitened_mode};
pub use beam::{Components, GeneralizedStokes, LEAST_FAR_FIELD, LightError, Loss};
pub use envelope::{
    Envelope, EnvelopeError, EnvelopeModes, GaussianPatch, GaussianPeak, MAX_PATCHES, ModeWidth,
    Patches, surface_projection,
};
pub use frame::{Frame, FrameError, FrameRotation};
pub use hermite::{MAX_ORDER, Real, hermite};
pub use lanes::{all_modes_at, contract, contract_at, hermite_all, hermite_all_at};
pub use mueller::{DiattenuatingRetarder, Mueller};
pub use observables::{Handedness, PolarizationEllipse};
pub use reshape::overlap;
pub use series::{HermiteSeries, SeriesError};
pub use shape::{MAX_CONDITION, ShapeError, ShapeMatrix};
pub use symmetric_power::symmetric_power;
pub use units::{NotPositive, Wavelength, Wavenumber};
pub use vector::{FramedStokes, StokesVector};
