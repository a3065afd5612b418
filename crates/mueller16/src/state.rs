//! The state of light after matter of several envelopes: one Stokes vector for each, and the real matrix that leads to the
//! next encounter.
//!
//! ```text
//! S^(q)_l = Σ_p Σ_j T^(p→q)_lj S^(p)_j        p envelope of the previous matter, q of this one
//! ```
//!
//! Parts of different envelopes come from different places with different shapes; each has its own geometry and coherence.

use stokes::{Mueller, StokesVector};

use crate::channels::Channels;
use crate::geometry::Geometry;
use crate::incident::IncidentCoherence;
use crate::theorem::{InteractionError, Transfer};

/// The matrix from the K Stokes vectors of the previous matter to those of this one: 4 × 4K for each envelope.
#[derive(Clone, Debug, PartialEq)]
pub struct StateTransfer {
    columns: Vec<Transfer>,
    envelopes: usize,
}

impl StateTransfer {
    /// The block from the part `from` of the previous matter to the envelope `to` of this one; zero where there is none.
    #[must_use]
    pub fn block(&self, from: usize, to: usize) -> Mueller {
        let zero = || Mueller::from_rows([[0.0; 4]; 4]);
        self.columns
            .get(from)
            .map_or_else(zero, |t| t.of_envelope(to))
    }

    /// The state after this matter, one Stokes vector for each envelope, from the state before it; parts that are not
    /// given are dark.
    #[must_use]
    pub fn apply(&self, state: &[StokesVector]) -> Vec<StokesVector> {
        let sum = |to| {
            let parts = self.columns.iter().zip(state);
            parts.fold(StokesVector::DARK, |sum, (transfer, stokes)| {
                sum + transfer.of_envelope(to) * *stokes
            })
        };
        (0..self.envelopes).map(sum).collect()
    }
}

impl Channels {
    /// The transfer of light in parts, such as the previous matter of K envelopes scatters: for each part its own encounter
    /// and coherence.
    ///
    /// Each part's Stokes vector is that at zero separation on this surface, its share of the irradiance normal to its ray.
    ///
    /// # Errors
    ///
    /// As [`Channels::transfer`].
    pub fn transfer_of_state(
        &self,
        parts: &[(Geometry, IncidentCoherence)],
    ) -> Result<StateTransfer, InteractionError> {
        let columns: Result<_, _> = parts
            .iter()
            .map(|(geometry, light)| self.transfer(geometry, light))
            .collect();
        Ok(StateTransfer {
            columns: columns?,
            envelopes: self.envelope_count(),
        })
    }
}
