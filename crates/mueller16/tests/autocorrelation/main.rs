//! Claims: every autocorrelation is the function that it stands for, to the error that it states.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod gaussian_heights;
mod k_correlated_heights;
mod k_correlation;
mod phase_screen;
mod superposed;
mod tables;
