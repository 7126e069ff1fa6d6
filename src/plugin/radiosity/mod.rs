//! Baked light in a running world.
//!
//! Mark what does not move with [`StaticLighting`] and add [`RadiosityPlugin`]: its light is baked in the
//! background, put into its vertices, and baked again when something changes.
//!
//! ```text
//!  who is static     what it looks like now    a thread of its own       the entities' meshes
//!  inherit ────────► survey ─────────────────► extract ─► Baker::bake ─► apply
//!  restore           key = same? nothing       redoes what changed       a few a frame
//! ```
//!
//! | file | what happens |
//! |---|---|
//! | `components`, `settings`, `status` | what users see |
//! | `inherit` | who is static; what stops being so gets its own mesh and material back |
//! | `material` | materials are moved to the extension that shows baked light, and followed |
//! | `assets` | copies of meshes, images and materials, renewed when their content changes |
//! | `survey`, `lights`, `key` | the static world as it is, with a key that tells whether it is another |
//! | `drive` | when a bake starts, and what is told of it |
//! | `job` | the bake on its thread |
//! | `scene`, `mesh_data`, `textures` | Bevy's data in the bake's terms |
//! | `shown` | what meshes carry for a view in the place of light |
//! | `apply` | light into meshes |
//! | `diagnostics` | times and counts |
//! | `gizmos` | lines that show how light was found |

mod apply;
pub(in crate::plugin) mod assets;
mod components;
mod diagnostics;
mod drive;
mod gizmos;
mod inherit;
mod job;
mod key;
mod lights;
mod material;
pub(in crate::plugin) mod mesh_data;
mod plugin;
mod scene;
mod settings;
mod shown;
mod status;
mod survey;
mod textures;

pub use components::{
    BakedLighting, LightBaking, NoStaticLighting, NotBaked, OriginalMaterial, StaticLighting,
};
pub use diagnostics::RadiosityDiagnostics;
pub use gizmos::RadiosityGizmos;
pub(in crate::plugin) use inherit::StaticMarks;
pub use plugin::{RadiosityPlugin, RadiositySystems};
pub use settings::{BakeSettingsReflect, RadiositySettings};
pub use status::{
    BakeFailed, BakeFinished, BakeStarted, BakeState, CancelBake, RadiosityStatus, Rebake,
};

#[cfg(test)]
mod mesh_data_test;
#[cfg(all(test, feature = "examples", feature = "gltf"))]
pub(in crate::plugin) mod two_doors_test;
