//! Claims: surfaces conserve energy, keep reciprocity, and meet the interfaces and the microfacet model in their limits.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod boundaries;
mod energy;
mod known;
mod laws;
mod microfacets;
mod numbers;
mod orders;
mod plates;
mod relief;
