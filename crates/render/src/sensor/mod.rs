//! Sensors: what a camera sample sees.

pub mod perspective;
