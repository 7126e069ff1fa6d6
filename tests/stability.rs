//! What radiosity programs fail at.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

#[path = "stability/coincident.rs"]
mod coincident;
#[path = "stability/degenerate.rs"]
mod degenerate;
#[path = "stability/enclosures.rs"]
mod enclosures;
#[path = "stability/solved.rs"]
mod solved;
