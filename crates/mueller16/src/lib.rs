//! Matter: what interfaces, rough surfaces, gratings, openings and optical elements make of polarized, partially coherent
//! light.
//!
//! Light is a generalized Stokes vector ([`stokes::GeneralizedStokes`]): four Stokes parameters of two points, each a
//! Hermite-Gauss series. Matter whose statistics hardly change over a correlation length is up to sixteen mutual
//! scattering functions, one for each pair of an incident and an outgoing parameter. Theorem S4.1 of the supplemental of
//! S. Steinberg and L.-Q. Yan, *Physical Light-Matter Interaction in Hermite-Gauss Space* (2021), "the paper" below, says
//! how the second turns the first into the light that is scattered; Lemma 4.3 says it for single scatterers and openings.
//! Signs and frames are those of the page of [`stokes`], fields those of [`csdm`].
//!
//! ```
//! use mueller16::*;
//! use nalgebra::{Matrix2, Vector2, Vector3};
//! use stokes::{Envelope, Frame, ModeWidth, Mueller, StokesVector, Wavelength};
//! let green = Wavelength::from_metres(550e-9)?;
//! let (sin, cos) = 45f64.to_radians().sin_cos();
//! let mirror = Geometry::on_plane(Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos), green)?;
//! // a lamp of 1 mm at 1 m, polarized across the plane of incidence
//! let lamp = Envelope::gaussian(&Matrix2::from_diagonal_element(1e-6))?.modes(ModeWidth::VarianceMatched, 0)?;
//! let frame = Frame::with_x_across(-mirror.to_source(), Vector3::z())?;
//! let light = lamp.light(StokesVector::HORIZONTAL, &Matrix2::identity(), frame, green, 1.0)?;
//! // rough glass, correlated over 10 µm, of which 50 µm (standard deviation) are lit
//! let fresnel = Mueller::from(DielectricInterface::new(1.0, 1.5)?.reflection(cos));
//! let rough = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10))?;
//! let lit = Envelope::gaussian(&Matrix2::from_diagonal_element(2.5e-9))?;
//! let glass = Matter::new(vec![Population::of_mueller(&fresnel, rough, lit)?])?;
//! // six channels: glass retards nothing between s and p but their sign
//! assert_eq!(glass.channels().set().to_string(), "6 (blocks)");
//! // what it scatters into the mirror direction, at 2 m
//! let modes = glass.modes(ModeWidth::VarianceMatched, 0)?;
//! let out = Frame::with_x_across(mirror.to_observer(), Vector3::z())?;
//! let [scattered] = &glass.scatter(&modes, &mirror, &light, Energy::Conserving, out, 2.0)?[..] else { panic!() };
//! assert!((scattered.stokes().stokes.degree_of_polarization() - 1.0).abs() < 1e-15);
//! // Van Cittert and Zernike: the lit patch is coherent to e^(−1/2) over λr/(2πσ) = 3.50 mm
//! let gamma = scattered.degree_of_coherence(&Vector2::new(3.501_4e-3, 0.0));
//! assert!((gamma.re - (-0.5f64).exp()).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The theorem, and where its factors are
//!
//! Locally stationary matter has `Σ^(j→l)(x₁, x₂) = I^(j→l)((x₁ + x₂)/2) R^(j→l)(x₁ − x₂)`, an envelope and an
//! autocorrelation for each channel `j → l`. Light of the shape W' that comes from a distance s then leaves as
//!
//! ```text
//! c^(l)_ab = Σ_j ⟨f^(j→l) | φ_ab(·; W)⟩ A^(j→l)                                              Theorem S4.1 (i)
//! A^(j→l)  = (n_o²/(s²λ₀²)) Σ_ab c'^(j)_ab F{R^(j→l) φ_ab(B·; W')}(φ_t)
//! WᵀW      = −∂²/∂w² ln |f^(0→0)|(0) = Pᵀ Cov(I^(0→0)) P                                   Theorem S4.1 (ii)
//! ```
//!
//! | symbol | name | unit | where | cost |
//! |---|---|---|---|---|
//! | ŝ, r̂ | directions to source and observer | 1 | [`Geometry`] | |
//! | φ = k₀ (n_o r̂ + n_i ŝ) | wave vector given to the matter | rad/m | [`Geometry::momentum_transfer`] | 6 products |
//! | φ_t, φ_z | its part in the surface, along the normal | rad/m | [`Geometry::tangential`], [`Geometry::normal_component`] | 3 products each |
//! | M_lj | response at one point; real | 1 | [`Population`], [`surface::Boundary`] | csdm's |
//! | R | autocorrelation, a sum of T Gaussians | 1 | [`Autocorrelation`], [`Relief`] | once for each φ_z |
//! | g = (φ_z σ_h)² | phase variance of rough heights | rad² | [`GaussianHeights::phase_variance`] | |
//! | I | envelope | 1 | [`stokes::Envelope`] | once |
//! | j → l | channels that are there | | [`ChannelSet`], [`Channels`] | once for each φ_z |
//! | B = (n_i k₀/s) E T | from the surface to the light's argument | 1/m² | [`Geometry::incident_map`] | |
//! | V = W'B | root of the light over the surface | 1/m | [`IncidentCoherence`] | 4 products of 2 |
//! | F{R φ_ab(B·; W')}(φ_t) | lobe of R for a mode | m³ | [`Autocorrelation::lobe_for`] | (N + 1)(N + 2)/2 steps for each Gaussian |
//! | A^(j→l) | amplitudes | light/m² | [`Channels::amplitudes`] | 1 product for each channel there |
//! | T_lj = (n_o/λ₀)² F{R^(j→l) γ}(φ_t) | transfer of light that shares its modes | 1/sr | [`Channels::transfer`] | the same |
//! | f = F{I}(P ·) | angular coherence of the envelope | m² | [`stokes::Envelope::far_field`] | |
//! | μ_ab = ⟨f, φ_ab⟩ | its modes | m | [`Matter::modes`] | once: a direction changes W alone |
//! | P | outgoing transverse axes in the surface's | 1 | [`Geometry::outgoing_projection`] | 12 products |
//! | W = D P, DᵀD = Cov(I) | outgoing shape | m | [`Matter::scatter`], [`Matter::shape`] | 1 product of 2×2 |
//! | O | obliquity of rough heights | 1 | [`Geometry::obliquity`], [`Energy`] | |
//!
//! Channels of one autocorrelation cost one sum over its Gaussians and the modes, whatever their number; light that shares
//! its modes costs one series, light that does not one for each component that a channel starts from. What is absent
//! (a channel, a component, a mode, a Gaussian out of reach of a tolerance) costs nothing and changes no other
//! number. [`Channels::transfer`] has the times.
//!
//! Light of several envelopes leaves as that many parts, each with a shape of its own ([`Matter::scatter`]); the next
//! encounter takes them one by one ([`Channels::transfer_of_state`]), or over one common shape as the theorem is written
//! ([`Matter::scatter_in_one_shape`]).
//!
//! # Kinds of matter
//!
//! | matter | where |
//! |---|---|
//! | smooth and rough interfaces, films and crystals on them, phase screens | [`surface::Surface`], [`surface::Boundary`] |
//! | heights: Gaussian, exponential, K-correlated; sums of reliefs | [`GaussianHeights`], [`ExponentialHeights`], [`KCorrelatedHeights`], [`Superposed`] |
//! | spectra: K-correlation (fractal, exponential), measured | [`KCorrelation`], [`TabulatedSpectrum`] |
//! | gratings: orders, directions, efficiencies; periodic polarization | [`Grating`], [`CoupledOrders`], [`PolarizationPattern`] |
//! | polarizers, retarders, depolarizers | [`surface::linear_polarizer`] and its neighbours; [`element`] between the axes of a plate |
//! | point scatterers, openings (Lemma 4.3) | [`PointScatterers`], [`Openings`] |
//!
//! # Accuracy
//!
//! Whoever gives a [`Tolerance`] is told what was chosen for it: the method and the Gaussians of a relief
//! ([`Approximation`]), the modes or Gaussians of a footprint ([`FootprintChoice`]), the order of outgoing modes
//! ([`ModeChoice`]); [`Footprint::transfer`] does all of it in one call. [`Domain`] says where the theorem holds at all.
//!
//! # Where the paper's formulas are corrected
//!
//! Each with a test that shows the printed claim failing (`tests/laws/errata.rs`); those of the functions themselves are
//! with [`stokes`], those of fields with [`csdm`].
//!
//! - (S2.1), (S2.2): as printed there is no cosine, and a unit mirror reflects `1/cos²θ` of the power. [`Energy`] has
//!   the factors.
//! - (S2.3), (S2.5): separations are transverse; the longitudinal part of ξ is lost at first order.
//! - (S2.6), (S2.8), (S2.9): factors `(r/k)²` and `2π`, those of the plane, for `(r/k)³` and `(2π)^(3/2)`.
//! - Theorem S4.1 (i): projected are the *dual* functions of the *outgoing* shape, and the Fourier transform's argument
//!   turns with the *incident* frame Q'.
//! - Theorem S4.1 (ii): a minus sign, the frame of the outgoing light, and the restriction to the transverse plane
//!   *before* the inversion.
//! - Theorem S4.1: the sixteen are signed mutual intensities; no squares of sixteen amplitudes are `M22 < 0` of a mirror.
//! - Odd orders of light do not vanish on scattering: they carry the skew of the source into the scattered power.
#![forbid(unsafe_code)]

mod accuracy;
mod autocorrelation;
mod channels;
mod domain;
pub mod element;
mod footprint;
mod geometry;
mod grating;
mod incident;
mod interface;
mod kernel;
mod lobe;
mod mode_choice;
mod openings;
mod phase_screen;
mod population;
mod recurrence;
mod relief;
mod scatterers;
mod shared_shape;
mod state;
pub mod surface;
mod theorem;

pub use accuracy::{Approximation, BadTolerance, Method, Tolerance};
pub use autocorrelation::{
    Autocorrelation, AutocorrelationError, ExponentialHeights, GaussianFamily, GaussianHeights,
    GaussianTerm, KCorrelatedHeights, KCorrelation, TableError, TabulatedSpectrum,
};
pub use channels::{ChannelSet, Channels};
pub use domain::{Domain, DomainError, MOST_PARAXIAL, MOST_PHASE};
pub use footprint::{
    Footprint, FootprintChoice, FootprintError, IncidentPart, Representation, TransferReport,
};
pub use geometry::{Geometry, GeometryError, LEAST_COSINE};
pub use grating::{
    Blaze, CoupledOrders, Grating, GratingError, LosslessOrders, Mount, Order, PolarizationPattern,
    Profile, Validity,
};
pub use incident::{IncidentCoherence, IncidentError};
pub use interface::{ConductorInterface, DielectricInterface, IndexError, Transmitted};
pub use mode_choice::ModeChoice;
pub use openings::{
    AngularSpectrum, LitOpenings, Opening, OpeningError, Openings, PlaneWave, SlitView,
    fringe_visibility,
};
pub use population::{Matter, MatterError, Population};
pub use relief::{Flat, Relief, Superposed};
pub use scatterers::{PairFarField, PointScatterer, PointScatterers, ScattererError};
pub use state::StateTransfer;
pub use theorem::{Amplitudes, Energy, InteractionError, Transfer};
