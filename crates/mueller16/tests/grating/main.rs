//! Claims: gratings and patterns diffract into the orders, directions and efficiencies that are known of them.

mod autocorrelations;
mod directions;
mod light;
mod numbers;
mod orders;
mod polarization_patterns;
