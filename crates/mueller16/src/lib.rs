//! Matter: interfaces and optical elements as Mueller matrices, and the theorem of light-matter interaction.
//!
//! Signs and frames are those of the page of [`stokes`].
#![forbid(unsafe_code)]

mod accuracy;
mod autocorrelation;
mod channels;
pub mod element;
mod geometry;
mod grating;
mod incident;
mod interface;
mod kernel;
mod population;
mod relief;
mod theorem;

pub use accuracy::{Approximation, BadTolerance, Method, Tolerance};
pub use autocorrelation::{Autocorrelation, AutocorrelationError, GaussianFamily, GaussianTerm};
pub use channels::{ChannelSet, Channels};
pub use geometry::{Geometry, GeometryError, LEAST_COSINE};
pub use grating::{
    Blaze, CoupledOrders, Grating, GratingError, LosslessOrders, Mount, Order, PolarizationPattern,
    Profile, Validity,
};
pub use incident::{IncidentCoherence, IncidentError};
pub use interface::{ConductorInterface, DielectricInterface, IndexError, Transmitted};
pub use population::{Matter, MatterError, Population};
pub use relief::{Flat, Relief, Superposed};
pub use theorem::{Amplitudes, Energy, InteractionError, Transfer};
