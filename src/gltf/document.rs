use std::path::PathBuf;

use serde_json::Value;

/// A glTF file as it was read: its JSON untouched, its buffers in memory.
///
/// Import reads it, export edits it; what neither knows (extras, animations, unknown extensions)
/// goes through as it came.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file it came from; relative URIs start at its folder.
    pub path: PathBuf,
    /// The whole JSON document.
    pub json: Value,
    /// The bytes of each entry of `buffers`, at least `byteLength` long.
    pub buffers: Vec<Vec<u8>>,
}

/// Which primitive of a [`Document`] an object of the scene was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrimitiveKey {
    /// Index into `nodes`.
    pub node: usize,
    /// Index into `meshes`.
    pub mesh: usize,
    /// Index into the mesh's `primitives`.
    pub primitive: usize,
}
