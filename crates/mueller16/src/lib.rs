//! Matter: interfaces and optical elements as Mueller matrices.
#![forbid(unsafe_code)]
