//! Why a surface has no answer.

use stokes::Mueller;
use thiserror::Error;

use crate::autocorrelation::AutocorrelationError;
use crate::geometry::GeometryError;
use crate::theorem::InteractionError;

/// Why a surface has no answer for an encounter, or numbers make no surface.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SurfaceError {
    /// The directions.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The relief.
    #[error(transparent)]
    Relief(#[from] AutocorrelationError),
    /// The orders of a grating.
    #[error(transparent)]
    Grating(#[from] crate::grating::GratingError),
    /// The theorem.
    #[error(transparent)]
    Interaction(#[from] InteractionError),
    /// A ray has no frame.
    #[error(transparent)]
    NoFrame(#[from] stokes::FrameError),
    /// A frame belongs to another ray.
    #[error(
        "surface: the frame of the {ray} light is {angle} rad from its ray, expected the same line (to 1e-6)"
    )]
    Frame {
        /// `"incident"` or `"outgoing"`.
        ray: &'static str,
        /// The angle.
        angle: f64,
    },
    /// A cosine of incidence is none.
    #[error("surface: the cosine of incidence is {found}, expected a number from 1e-9 to 1")]
    Cosine {
        /// What was found.
        found: f64,
    },
    /// The geometry is between other media than the boundary.
    #[error(
        "surface: the geometry has the index {found} on the {side} side of the surface and the boundary {expected}, \
         expected the same (to 1e-9)"
    )]
    Medium {
        /// `"front"`, where the normal points, or `"back"`.
        side: &'static str,
        /// Of the geometry.
        found: f64,
        /// Of the boundary.
        expected: f64,
    },
    /// Light from behind a crystal for which the front medium carries no wave.
    #[error(
        "surface: light from behind a crystal at cosine {cosine} has no wave in front, expected less than the critical \
         angle; turn the plate over"
    )]
    CrystalFromBehind {
        /// Cosine at the facet, behind it.
        cosine: f64,
    },
    /// A crystal or film has no Mueller matrix here.
    #[error(transparent)]
    Film(#[from] csdm::film::FilmError),
    /// The direction of incidence on a crystal.
    #[error(transparent)]
    Crystal(#[from] csdm::birefringent::CrystalError),
    /// A given matrix is made by no ensemble of Jones matrices.
    #[error("surface: the matrix of {what}: {reason}")]
    NotRealizable {
        /// `"reflection"` or `"transmission"`.
        what: &'static str,
        /// The eigenvalue, or the element.
        reason: csdm::NotRealizable,
    },
    /// Given matrices make light.
    #[error(
        "surface: reflection and transmission together pass up to {power} of some light's power, expected at most 1"
    )]
    Active {
        /// The largest share.
        power: f64,
    },
    /// A given matrix of reflection is not that of reciprocal matter.
    #[error(
        "surface: element ({row}, {column}) of the matrix of reflection is {found}, expected {expected} as in X Mᵀ X with \
         X = diag(1, 1, -1, 1): reciprocal matter"
    )]
    NotReciprocal {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The element.
        found: f64,
        /// That of the reversed matrix.
        expected: f64,
    },
    /// Shadowing was asked of a relief without slopes.
    #[error(
        "surface: shadowing needs the slopes of the relief, and they have no finite variance; expected a differentiable \
         relief, or no shadowing"
    )]
    NoSlopes,
    /// The cap was asked of a relief whose lobe depends on azimuth.
    #[error(
        "surface: the energy cap holds for lobes that are round about the mirror direction, and this relief has a term with \
         the principal widths {widths:?} m at {shift} rad/m"
    )]
    NotRound {
        /// Singular values of the term's root, m.
        widths: [f64; 2],
        /// Modulus of the term's shift, rad/m.
        shift: f64,
    },
    /// The cap was made for other light or other media.
    #[error(
        "surface: no energy cap for a wavelength of {wavelength} m from index {incident} to {outgoing}; make one with \
         `with_cap`"
    )]
    NoCap {
        /// Vacuum wavelength, m.
        wavelength: f64,
        /// Index of the source's medium.
        incident: f64,
        /// Index of the observer's medium.
        outgoing: f64,
    },
}

impl SurfaceError {
    pub(super) fn not_reciprocal(mueller: &Mueller, tolerance: f64) -> Option<Self> {
        let reversed = mueller.reversed();
        let cells = (0..16).map(|i| (i / 4, i % 4));
        cells
            .map(|(row, column)| {
                (
                    row,
                    column,
                    mueller.element(row, column),
                    reversed.element(row, column),
                )
            })
            .find(|(_, _, found, expected)| {
                let difference = (found - expected).abs();
                difference.is_nan() || difference > tolerance
            })
            .map(|(row, column, found, expected)| Self::NotReciprocal {
                row,
                column,
                found,
                expected,
            })
    }
}
