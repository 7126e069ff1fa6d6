//! The file in the making: one JSON document and one binary chunk, to which things are appended.

use std::{ops::Range, path::PathBuf};

use serde_json::{Map, Value, json};

use super::Exported;
use crate::gltf::{
    Document, GltfError,
    accessor_json::{AccessorData, ElementKind, accessor_count, read_accessor, whole},
};

/// Target of buffer views with vertex attributes.
pub(super) const ARRAY_BUFFER: u32 = 34962;
/// Target of buffer views with vertex indices.
pub(super) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Lists that the exporter appends to.
const LISTS: [&str; 6] = [
    "accessors",
    "bufferViews",
    "buffers",
    "extensionsUsed",
    "materials",
    "meshes",
];

/// A glTF document whose buffers are one.
///
/// Nothing is ever taken out of its lists, so indices that unknown extensions hold stay right.
pub(super) struct Glb {
    pub(super) path: PathBuf,
    pub(super) json: Value,
    pub(super) notes: Vec<String>,
    bin: Vec<u8>,
}

/// Numbers to be written as an accessor.
#[derive(Clone, Debug)]
pub(super) enum Numbers {
    Float(Vec<f32>),
    U16(Vec<u16>),
    U32(Vec<u32>),
}

impl Glb {
    /// Copies a document and joins its buffers.
    pub(super) fn merge(document: &Document) -> Result<Self, GltfError> {
        let mut glb = Self {
            path: document.path.clone(),
            json: document.json.clone(),
            notes: Vec::new(),
            bin: Vec::new(),
        };
        glb.check_lists()?;
        let starts = glb.join_buffers(&document.buffers)?;
        let views = glb
            .json
            .get_mut("bufferViews")
            .and_then(Value::as_array_mut);
        for (index, view) in views.into_iter().flatten().enumerate() {
            if let Err(reason) = move_view(view, &starts) {
                return Err(glb.invalid(format!("bufferView {index}: {reason}")));
            }
        }
        Ok(glb)
    }

    /// What is appended to must be a list.
    fn check_lists(&self) -> Result<(), GltfError> {
        for name in LISTS {
            if self.json.get(name).is_some_and(|list| !list.is_array()) {
                return Err(self.invalid(format!("{name} is not a list")));
            }
        }
        match self.json.is_object() && self.json["asset"].is_object() {
            true => Ok(()),
            false => Err(self.invalid("it has no asset".to_owned())),
        }
    }

    /// Appends all buffers to the binary chunk; returns where each begins.
    fn join_buffers(&mut self, buffers: &[Vec<u8>]) -> Result<Vec<usize>, GltfError> {
        let described = self.json["buffers"].as_array().map_or(0, Vec::len);
        if described != buffers.len() {
            return Err(self.refuse(format!(
                "it describes {described} buffers but {} were loaded",
                buffers.len()
            )));
        }
        let mut starts = Vec::new();
        for (index, bytes) in buffers.iter().enumerate() {
            let length = whole(&self.json["buffers"][index], "byteLength")
                .map_err(|reason| self.invalid(reason))?
                .unwrap_or(bytes.len());
            let Some(bytes) = bytes.get(..length) else {
                return Err(self.invalid(format!("buffer {index} is shorter than it says")));
            };
            starts.push(self.push_bytes(bytes));
        }
        Ok(starts)
    }

    /// Appends bytes at a multiple of four and returns where they begin.
    fn push_bytes(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let start = self.bin.len();
        self.bin.extend_from_slice(bytes);
        start
    }

    /// Appends a buffer view and returns its index.
    pub(super) fn push_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let start = self.push_bytes(bytes);
        let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.push("bufferViews", view)
    }

    /// Appends an accessor with a buffer view of its own and returns its index.
    ///
    /// With `bounds` it gets `min` and `max`, which positions must have.
    pub(super) fn push_accessor(
        &mut self,
        kind: ElementKind,
        numbers: &Numbers,
        target: u32,
        bounds: bool,
    ) -> usize {
        let (component, count) = match numbers {
            Numbers::Float(values) => (5126, values.len()),
            Numbers::U16(values) => (5123, values.len()),
            Numbers::U32(values) => (5125, values.len()),
        };
        let view = self.push_view(&numbers.to_bytes(), Some(target));
        let mut accessor = json!({
            "bufferView": view,
            "componentType": component,
            "count": count / kind.width(),
            "type": kind.name(),
        });
        if let (true, Numbers::Float(values)) = (bounds, numbers) {
            let (min, max) = min_max(values, kind.width());
            accessor["min"] = min.into();
            accessor["max"] = max.into();
        }
        self.push("accessors", accessor)
    }

    /// Writes over bytes that are there already; false if the length differs.
    pub(super) fn overwrite(&mut self, range: Range<usize>, numbers: &Numbers) -> bool {
        let bytes = numbers.to_bytes();
        match self.bin.get_mut(range) {
            Some(place) if place.len() == bytes.len() => {
                place.copy_from_slice(&bytes);
                true
            }
            _ => false,
        }
    }

    /// Appends to one of the document's lists and returns the index.
    pub(super) fn push(&mut self, list: &str, item: Value) -> usize {
        let Some(list) = list_mut(&mut self.json, list) else {
            return 0;
        };
        list.push(item);
        list.len() - 1
    }

    /// Adds a name to `extensionsUsed`.
    pub(super) fn use_extension(&mut self, name: &str) {
        if let Some(used) = list_mut(&mut self.json, "extensionsUsed")
            && !used.iter().any(|used| used == name)
        {
            used.push(name.into());
        }
    }

    /// Says of an extension no more that it is used.
    pub(super) fn drop_extension(&mut self, name: &str) {
        for list in ["extensionsUsed", "extensionsRequired"] {
            let Some(Value::Array(names)) = self.json.get_mut(list) else {
                continue;
            };
            names.retain(|used| used != name);
            // glTF wants no empty lists.
            if names.is_empty()
                && let Some(json) = self.json.as_object_mut()
            {
                json.remove(list);
            }
        }
    }

    /// Reads an accessor that must have `count` elements.
    pub(super) fn read(&self, accessor: usize, count: usize) -> Result<AccessorData, GltfError> {
        let found = self.count(accessor)?;
        if found != count {
            return Err(self.invalid(format!(
                "accessor {accessor} has {found} elements where its primitive has {count} vertices"
            )));
        }
        read_accessor(&self.json, &[&self.bin], accessor).map_err(|reason| self.invalid(reason))
    }

    /// How many elements an accessor has.
    pub(super) fn count(&self, accessor: usize) -> Result<usize, GltfError> {
        accessor_count(&self.json, accessor).map_err(|reason| self.invalid(reason))
    }

    /// An error of the file that was read.
    pub(super) fn invalid(&self, reason: String) -> GltfError {
        GltfError::Invalid {
            path: self.path.clone(),
            reason,
        }
    }

    /// An error of what is to be added to the file.
    pub(super) fn refuse(&self, reason: String) -> GltfError {
        GltfError::Export {
            path: self.path.clone(),
            reason,
        }
    }

    /// Puts the file together.
    pub(super) fn finish(mut self) -> Result<Exported, GltfError> {
        self.describe_buffer();
        // Of what a `Value` can hold, nothing fails to be written.
        let json =
            serde_json::to_vec(&self.json).map_err(|error| self.refuse(error.to_string()))?;
        let total = glb_length(json.len(), self.bin.len()).ok_or_else(|| {
            self.refuse(
                "the result is 4 GiB or more, too much for one .glb: split the scene".into(),
            )
        })?;
        let mut bytes = Vec::with_capacity(total as usize);
        bytes.extend(b"glTF");
        bytes.extend(2u32.to_le_bytes());
        bytes.extend(total.to_le_bytes());
        push_chunk(&mut bytes, b"JSON", json, b' ');
        if !self.bin.is_empty() {
            push_chunk(&mut bytes, b"BIN\0", self.bin, 0);
        }
        Ok(Exported {
            bytes,
            notes: self.notes,
        })
    }

    /// Leaves one entry in `buffers`: what the first was, with the length of all.
    fn describe_buffer(&mut self) {
        if self.bin.is_empty() {
            return;
        }
        let length = self.bin.len();
        let Some(buffers) = list_mut(&mut self.json, "buffers") else {
            return;
        };
        buffers.truncate(1);
        if buffers.is_empty() {
            buffers.push(json!({}));
        }
        if let Some(buffer) = buffers[0].as_object_mut() {
            buffer.shift_remove("uri");
            buffer.insert("byteLength".into(), length.into());
        }
    }
}

impl Numbers {
    fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Float(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::U16(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Self::U32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        }
    }
}

/// The object under `key`, made if it is not there; `None` if something else is.
pub(super) fn object_mut<'a>(json: &'a mut Value, key: &str) -> Option<&'a mut Map<String, Value>> {
    json.as_object_mut()?
        .entry(key)
        .or_insert_with(|| json!({}))
        .as_object_mut()
}

fn list_mut<'a>(json: &'a mut Value, key: &str) -> Option<&'a mut Vec<Value>> {
    json.as_object_mut()?
        .entry(key)
        .or_insert_with(|| json!([]))
        .as_array_mut()
}

/// Points a buffer view, and compressed alternatives of it in extensions, into the joint buffer.
fn move_view(view: &mut Value, starts: &[usize]) -> Result<(), String> {
    move_reference(view, starts)?;
    let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
    for extension in extensions.into_iter().flat_map(|map| map.values_mut()) {
        if extension.get("buffer").is_some_and(Value::is_u64) {
            move_reference(extension, starts)?;
        }
    }
    Ok(())
}

fn move_reference(json: &mut Value, starts: &[usize]) -> Result<(), String> {
    let buffer = whole(json, "buffer")?.ok_or("it has no buffer")?;
    let start = starts
        .get(buffer)
        .ok_or_else(|| format!("there is no buffer {buffer}"))?;
    let offset = whole(json, "byteOffset")?
        .unwrap_or(0)
        .checked_add(*start)
        .ok_or("byteOffset is too large")?;
    json["buffer"] = 0.into();
    if offset != 0 || json.get("byteOffset").is_some() {
        json["byteOffset"] = offset.into();
    }
    Ok(())
}

fn min_max(values: &[f32], width: usize) -> (Vec<f32>, Vec<f32>) {
    let mut min = vec![f32::INFINITY; width];
    let mut max = vec![f32::NEG_INFINITY; width];
    for element in values.chunks_exact(width) {
        for (number, &value) in element.iter().enumerate() {
            min[number] = min[number].min(value);
            max[number] = max[number].max(value);
        }
    }
    (min, max)
}

fn push_chunk(bytes: &mut Vec<u8>, kind: &[u8; 4], content: Vec<u8>, padding: u8) {
    let length = content.len().next_multiple_of(4);
    // Within `u32`: `glb_length` has checked the sum.
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend(kind);
    let end = bytes.len() + length;
    bytes.extend(content);
    bytes.resize(end, padding);
}

/// The length of the whole file, if its header can hold it.
fn glb_length(json: usize, bin: usize) -> Option<u32> {
    let padded = |length: usize| (length as u64).next_multiple_of(4);
    let bin = if bin == 0 { 0 } else { 8 + padded(bin) };
    u32::try_from(12 + 8 + padded(json) + bin).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gltf_glb_length_is_limited() {
        assert_eq!(glb_length(1, 0), Some(24));
        assert_eq!(glb_length(4, 5), Some(40));
        assert_eq!(glb_length(4, 0xffff_ffe0 - 4), Some(0xffff_fffc));
        assert_eq!(glb_length(4, 0xffff_fff0), None);
    }

    #[test]
    fn gltf_compressed_alternatives_of_views_move_too() {
        let mut view = json!({"buffer": 1, "byteLength": 4, "extensions": {
            "EXT_meshopt_compression": {"buffer": 0, "byteOffset": 4}, "OTHER": {"x": 1}}});
        move_view(&mut view, &[0, 100]).unwrap();
        let expected = json!({"buffer": 0, "byteOffset": 100, "byteLength": 4, "extensions": {
            "EXT_meshopt_compression": {"buffer": 0, "byteOffset": 4}, "OTHER": {"x": 1}}});
        assert_eq!(view, expected);
        assert!(move_view(&mut json!({"buffer": 2}), &[0, 100]).is_err());
        assert!(move_view(&mut json!({"buffer": 1, "byteOffset": u64::MAX}), &[0, 100]).is_err());
    }
}
