//! Fields: Jones matrices, Fresnel amplitudes, and the way from them to Mueller matrices.
#![forbid(unsafe_code)]
