//! Small glTF files made in code, for tests.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use serde_json::{Value, json};

use super::error::GltfError;
use super::import::{GltfScene, import};
use crate::radiosity::Object;

pub(super) const I8: u32 = 5120;
pub(super) const U8: u32 = 5121;
pub(super) const I16: u32 = 5122;
pub(super) const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const F32: u32 = 5126;

/// A document with one buffer.
#[derive(Clone)]
pub(super) struct File {
    pub(super) json: Value,
    pub(super) bin: Vec<u8>,
}

pub(super) fn f32_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(super) fn u16_bytes(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

impl File {
    pub(super) fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" },
                "buffers": [{ "byteLength": 0 }],
                "bufferViews": [],
                "accessors": [],
                "meshes": [],
                "materials": [],
                "nodes": [],
                "scenes": [{ "nodes": [] }],
                "scene": 0
            }),
            bin: Vec::new(),
        }
    }

    /// One node with one triangle in the xy plane, right angle at zero, seen from +z; no indices.
    pub(super) fn triangle() -> Self {
        let mut file = Self::new();
        let positions = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        file.mesh(json!({ "attributes": { "POSITION": positions } }));
        file.root_node(json!({ "mesh": 0, "name": "tri" }));
        file
    }

    /// Appends to an array of the document.
    pub(super) fn push(&mut self, list: &str, entry: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(entry);
        list.len() - 1
    }

    pub(super) fn root_node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        let roots = self.json["scenes"][0]["nodes"].as_array_mut().unwrap();
        roots.push(json!(index));
        index
    }

    pub(super) fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    pub(super) fn accessor(
        &mut self,
        component: u32,
        ty: &str,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": ty, "count": count }),
        )
    }

    pub(super) fn floats(&mut self, ty: &str, values: &[f32]) -> usize {
        let width = match ty {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(F32, ty, values.len() / width, &f32_bytes(values))
    }

    /// An image of one row of texels, with a texture.
    pub(super) fn texture(&mut self, texels: &[[u8; 4]]) -> usize {
        let view = self.view(&png(texels));
        let image = self.push(
            "images",
            json!({ "bufferView": view, "mimeType": "image/png" }),
        );
        self.push("textures", json!({ "source": image }))
    }

    /// Gives the first primitive a material.
    pub(super) fn material(&mut self, material: Value) {
        let index = self.push("materials", material);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(index);
    }

    pub(super) fn attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec(&self.json).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        glb_of(&json, &self.bin)
    }

    /// The document as `.gltf` text, its buffer at `uri`.
    pub(super) fn gltf(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = json!(uri);
        serde_json::to_vec_pretty(&json).unwrap()
    }

    pub(super) fn gltf_embedded(&self) -> Vec<u8> {
        self.gltf(&data_uri("application/octet-stream", &self.bin))
    }

    pub(super) fn try_load(&self) -> Result<GltfScene, GltfError> {
        import(Path::new("test.glb"), &self.glb())
    }

    pub(super) fn load(&self) -> GltfScene {
        self.try_load().unwrap()
    }

    /// What is wrong with the file.
    pub(super) fn reason(&self) -> String {
        match self.try_load() {
            Err(GltfError::Invalid { reason, .. }) => reason,
            Err(other) => panic!("another error: {other}"),
            Ok(_) => panic!("no error"),
        }
    }
}

pub(super) fn glb_of(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut glb = b"glTF".to_vec();
    glb.extend(2_u32.to_le_bytes());
    glb.extend((12 + 8 + json.len() as u32 + 8 + bin.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb
}

pub(super) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A PNG of one row of texels.
pub(super) fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let raw = texels.iter().flatten().copied().collect();
    let image = image::RgbaImage::from_raw(texels.len() as u32, 1, raw).unwrap();
    encode(&image.into())
}

pub(super) fn encode(image: &image::DynamicImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Whether a note has all the words.
pub(super) fn noted(scene: &GltfScene, words: &[&str]) -> bool {
    let has = |note: &&String| words.iter().all(|word| note.contains(word));
    scene.notes.iter().any(|note| has(&note))
}

pub(super) fn first(scene: &GltfScene) -> &Object {
    &scene.scene.objects[0]
}

pub(super) fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// Length: twice the triangle's area.
pub(super) fn face_normal(object: &Object, triangle: usize) -> Vec3 {
    let [a, b, c] = object.triangles[triangle].map(|i| object.positions[i as usize]);
    (b - a).cross(c - a)
}
