//! glTF in and out, without Bevy.

mod accessor_json;
mod document;
mod error;
mod export;
mod write;

pub use document::{Document, PrimitiveKey};
pub use error::GltfError;
pub use export::{BakedPrimitive, ExportOptions, Exported, LightEncoding, to_glb};
pub use write::write_atomically;
