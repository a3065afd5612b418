//! Claim: matter and light that only waves explain agree with closed forms through the whole program.
//!
//! One module a plugin or a subject.

mod grating;
mod slits;
