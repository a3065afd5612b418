//! Matter: interfaces and optical elements as Mueller matrices, and the theorem of light-matter interaction.
//!
//! Signs and frames are those of the page of [`stokes`].
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
mod plates;
mod population;
mod recurrence;
mod relief;
mod scatterers;
mod shared_shape;
mod state;
mod surface;
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
    Profile, Sharing, Validity,
};
pub use incident::{IncidentCoherence, IncidentError};
pub use interface::{ConductorInterface, DielectricInterface, IndexError, Transmitted};
pub use mode_choice::ModeChoice;
pub use openings::{
    AngularSpectrum, LitOpenings, Opening, OpeningError, Openings, PlaneWave, SlitView,
    fringe_visibility,
};
pub use population::{Matter, MatterError, Population};
pub use relief::{Flat, Relief, SharpOrder, Superposed};
pub use scatterers::{PairFarField, PointScatterer, PointScatterers, ScattererError};
pub use state::StateTransfer;
pub use surface::{
    Boundary, CrystalPlate, EnergyCap, Film, InternalReflections, Passage, PlaneElement, RayFrames,
    Specular, Surface, SurfaceError, smith_beckmann,
};
pub use theorem::{Amplitudes, Energy, InteractionError, Transfer};
