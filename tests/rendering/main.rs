//! Draws small scenes with the real renderer and compares pixels with what they must be.
//!
//! Runs without a GPU. `SAVE_PICTURES=1` keeps every picture, not only those of failures.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]
#![allow(clippy::print_stdout, reason = "how close the pictures came")]

mod bumps;
mod changes;
mod closed_form;
mod deformed;
mod directional;
mod displaced;
mod double_light;
mod fresco_views;
mod gizmos;
mod like_bevys_lightmap;
mod many_materials;
mod other_devices;
mod parallax;
mod picture;
mod scenery;
mod stage;
mod without_light;
