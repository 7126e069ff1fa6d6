//! Vertices placed by the light: how good a bake is that was asked for an error, and whether its
//! meshes hold together.
//!
//! | file | |
//! |---|---|
//! | `truth` | how good the truth is that all others are held to |
//! | `leaks` | light behind walls, under blocks and past partitions |
//! | `watertight` | refined meshes are the surfaces they refine, without cracks |
//! | `asked` | the error is at most what was asked for |
//! | `budgets` | vertices, memory and seconds are kept |

#![allow(
    clippy::print_stderr,
    reason = "tables of figures, for who runs a test to see them"
)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod asked;
mod budgets;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/known/mod.rs"]
mod known;
mod leaks;
mod truth;
mod watertight;
