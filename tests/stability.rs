//! What radiosity programs fail at.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

#[path = "stability/coincident.rs"]
mod coincident;
#[path = "stability/degenerate.rs"]
mod degenerate;
#[path = "stability/determinism.rs"]
mod determinism;
#[path = "stability/emitters.rs"]
mod emitters;
#[path = "stability/enclosures.rs"]
mod enclosures;
#[path = "stability/instances.rs"]
#[cfg(feature = "gltf")]
mod instances;
#[path = "stability/leaks.rs"]
mod leaks;
#[path = "stability/precision.rs"]
mod precision;
#[path = "stability/solved.rs"]
mod solved;
