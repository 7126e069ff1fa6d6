//! glTF in and out, without Bevy.

mod accessor;
mod camera;
mod check;
mod container;
mod document;
mod error;
mod hierarchy;
mod import;
mod material;
mod notes;
mod placed;
mod primitive;
mod punctual;
mod texture;

pub use camera::{GltfCamera, GltfProjection};
pub use document::{Document, PrimitiveKey};
pub use error::GltfError;
pub use import::{GltfScene, load};

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
