//! Form factors against what is known about them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod closed_form;
#[path = "../common/mod.rs"]
mod common;
mod estimators;
mod formulas;
mod meshes;
mod solves;
mod stability;
mod truth;
