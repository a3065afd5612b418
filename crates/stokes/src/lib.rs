//! Light: Stokes vectors, transverse frames, Mueller matrices.
#![forbid(unsafe_code)]
