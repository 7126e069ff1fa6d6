//! Light that was baked in a running world, saved to a file and shown in another run without a solver.
//!
//! ```text
//!  a world with light ──LightBake::of──► LightBake ──write──► room.light_bake
//!                                                                   │ asset server
//!  the same entities, with light ◄── each finds its own ◄── LitBy(handle) on their root
//! ```
//!
//! | file | what happens |
//! |---|---|
//! | `asset` | what a file holds, checked as it is read |
//! | `identity` | how an entity is found again: its [`LightBakeId`], else names from the root down, and its mesh |
//! | `save` | from a world to a [`LightBake`] |
//! | `show` | from a [`LightBake`] to meshes |

mod asset;
mod identity;
mod save;
mod show;

pub use asset::{LightBake, LightBakeLoader, UnreadableLightBake};
pub use identity::LightBakeId;
pub use save::LightBakeError;
pub use show::{LitBy, LitByStatus};

pub(super) use show::plugin;

#[cfg(all(test, feature = "examples", feature = "gltf"))]
mod sample_test;
