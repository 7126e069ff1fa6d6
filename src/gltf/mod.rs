//! glTF in and out, without Bevy.
//!
//! [`load`] reads a file into a [`Scene`](crate::radiosity::Scene) and keeps the [`Document`] it
//! came from; [`to_glb`] writes that document again with baked light in its vertices. What neither
//! knows goes through untouched. The contract of what is written stands in `docs/file_formats.md`.
//!
//! [`load_surfaces`] and [`to_displaced_glb`] do the same for meshes that are displaced, each in its own space, and
//! [`to_projected_glb`] for meshes that get texture coordinates.
//!
//! | in | out |
//! |---|---|
//! | `container`, `check`: bytes and JSON, limits checked first | `export`: light into the JSON |
//! | `accessor`, `hierarchy`, `primitive`: geometry in world space; `surfaces`: in mesh space | `accessor_json`: attributes to refine |
//! | `material`, `texture`, `punctual`, `camera`: looks and light; `relief`: their height maps | `write`: whole files or none |

mod accessor;
mod accessor_json;
mod camera;
mod check;
mod container;
mod document;
mod error;
mod export;
mod hierarchy;
mod import;
mod material;
mod notes;
mod placed;
mod primitive;
mod punctual;
mod relief;
mod surfaces;
mod texture;
mod write;

pub use camera::{GltfCamera, GltfProjection};
pub use document::{Document, PrimitiveKey};
pub use error::GltfError;
pub use export::{
    BakedPrimitive, DisplacedPrimitive, ExportOptions, Exported, LightEncoding, ProjectedPrimitive,
    to_displaced_glb, to_glb, to_projected_glb,
};
pub use import::{GltfScene, load};
pub use relief::MaterialDisplacement;
pub use surfaces::{GltfSurfaces, MeshSurface, PrimitiveSurface, load_surfaces};
pub use write::write_atomically;

#[cfg(test)]
mod container_test;
#[cfg(test)]
mod fuzz_test;
#[cfg(test)]
mod geometry_test;
#[cfg(test)]
mod light_test;
#[cfg(test)]
mod malformed_test;
#[cfg(test)]
mod material_test;
#[cfg(test)]
mod placed_test;
#[cfg(test)]
mod test_file;
