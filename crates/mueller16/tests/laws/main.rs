//! Claim: Theorem S4.1 as it is computed is the integral that it stands for, and keeps the laws of light and its limits.
//!
//! Everything is compared with sums over points of surfaces and sources, with closed forms, or with itself by another way;
//! nothing with earlier output.

#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod chain;
mod domain;
mod errata;
mod footprint;
mod limits;
mod media;
mod realizability;
mod skipping;
mod theorem;
mod tools;
