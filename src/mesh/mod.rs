//! Meshes as pure geometry: refinement that keeps shared edges together, position classes.

mod refined;

pub use refined::{RefinedMesh, SurfacePoint};
