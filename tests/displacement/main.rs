//! Displacement, held to the failure modes that other implementations have. Tests are named by the list in
//! `docs/displacement.md`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod accuracy;
mod adaptive;
mod meshes;
mod robust;
mod watertight;
