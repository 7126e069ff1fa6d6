//! Meshes raised by height maps in a running world.
//!
//! Put a [`Displacement`] on an entity with a mesh and add [`DisplacementPlugin`]: the mesh is raised in the
//! background and shown in the place of the one it was made from, and made again when something changes. How it
//! is raised is [`crate::displacement`]'s.
//!
//! # The chain
//!
//! What an entity shows is the end of a chain. Each link keeps what it was made from, and writes `Mesh3d` only
//! when it has something new:
//!
//! ```text
//!   source ────────► displaced ────────────► lit
//!    │     DisplacedMesh  │     BakedLighting   │
//!    └── handle of many   └── of this entity    └── of this entity, `Mesh3d`
//! ```
//!
//! To find where the chain begins it is followed back from `Mesh3d`: if that is the lit copy, to what was lit; if
//! that is the displaced mesh, to its source. Whatever is found there that neither link has made was written by
//! somebody else, and is a new source. A new displaced mesh is to baked light a new mesh, and is lit anew.
//!
//! # What is a change
//!
//! ```text
//!  source's content ─┐
//!  map, by identity ─┼─ order ── known? ── nothing            a task                   the frame after
//!  component's values ┘              └─── new, start ───────► displace ─► attributes ─► swap in
//! ```
//!
//! Content is compared, not change ticks: writing a value over itself starts nothing, and neither do the meshes
//! that this plugin and baked light write.
//!
//! | file | what happens |
//! |---|---|
//! | `component`, `status`, `reflect` | what users see |
//! | `chain` | the way back to the source |
//! | `order` | what is to be made, or what stands against it |
//! | `job` | the work in its task |
//! | `attributes`, `skin` | from the raised surface to a mesh with all that the source's vertices have |
//! | `drive` | when work starts and ends |

mod attributes;
mod chain;
mod component;
mod drive;
mod job;
mod order;
mod plugin;
mod reflect;
mod skin;
mod status;

pub use super::radiosity::mesh_data::MeshProblem;
pub use component::{DisplacedMesh, Displacement};
pub use plugin::{DisplacementPlugin, DisplacementSystems};
pub use reflect::{
    DirectionReflect, DisplacementSettingsReflect, KernelReflect, SpacingReflect,
    TessellationReflect,
};
pub use status::{DisplacementProblem, DisplacementStatus};

#[cfg(test)]
mod attributes_test;
