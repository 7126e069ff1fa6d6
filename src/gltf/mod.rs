//! glTF in and out, without Bevy.

mod document;
mod error;

pub use document::{Document, PrimitiveKey};
pub use error::GltfError;
