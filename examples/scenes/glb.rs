use glam::{Quat, Vec3};
use serde_json::{Map, Value, json};

use super::shapes::Shape;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;

/// A glTF 2.0 document with one scene, as it grows.
#[derive(Default)]
pub(super) struct Glb {
    name: &'static str,
    lists: Map<String, Value>,
    extensions_used: Vec<&'static str>,
    lights: Vec<Value>,
    binary: Vec<u8>,
}

/// Index of a material of a [`Glb`].
#[derive(Clone, Copy)]
pub(super) struct MaterialIndex(usize);

/// Index of a mesh of a [`Glb`].
#[derive(Clone, Copy)]
pub(super) struct MeshIndex(usize);

/// Index of a texture of a [`Glb`].
#[derive(Clone, Copy)]
pub(super) struct TextureIndex(pub usize);

impl Glb {
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            ..Self::default()
        }
    }

    /// A dull material that reflects `color` (linear RGB), changed by `extra` properties.
    pub(super) fn material(&mut self, name: &str, color: [f64; 3], extra: Value) -> MaterialIndex {
        let [r, g, b] = color;
        let mut material = json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
        });
        merge(&mut material, extra);
        if let Some(extensions) = material.get("extensions")
            && extensions.get("KHR_materials_emissive_strength").is_some()
        {
            self.use_extension("KHR_materials_emissive_strength");
        }
        MaterialIndex(self.push("materials", material))
    }

    /// A repeating texture from the bytes of a PNG.
    pub(super) fn texture(&mut self, name: &str, png: &[u8]) -> TextureIndex {
        let view = self.buffer_view(png, None);
        let image = self.push(
            "images",
            json!({ "bufferView": view, "mimeType": "image/png", "name": name }),
        );
        let sampler = self.push("samplers", json!({ "wrapS": 10497, "wrapT": 10497 }));
        let texture = json!({ "name": name, "sampler": sampler, "source": image });
        TextureIndex(self.push("textures", texture))
    }

    /// A mesh of one primitive; with texture coordinates if `textured`.
    pub(super) fn mesh(
        &mut self,
        name: &str,
        shape: &Shape,
        material: MaterialIndex,
        textured: bool,
    ) -> MeshIndex {
        let vec3 = |v: &[Vec3]| v.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
        let positions = self.float_accessor("VEC3", &vec3(&shape.positions));
        let bounds = |fold: fn(Vec3, Vec3) -> Vec3| {
            let corner = shape.positions.iter().copied().reduce(fold);
            corner.unwrap_or_default().to_array()
        };
        self.lists["accessors"][positions]["min"] = json!(bounds(Vec3::min));
        self.lists["accessors"][positions]["max"] = json!(bounds(Vec3::max));
        let normals = self.float_accessor("VEC3", &vec3(&shape.normals));
        let mut attributes = json!({ "NORMAL": normals, "POSITION": positions });
        if textured {
            let uvs: Vec<f32> = shape.uvs.iter().flat_map(|uv| uv.to_array()).collect();
            attributes["TEXCOORD_0"] = json!(self.float_accessor("VEC2", &uvs));
        }
        let indices = self.index_accessor(&shape.triangles);
        let primitive = json!({
            "attributes": attributes,
            "indices": indices,
            "material": material.0,
        });
        MeshIndex(self.push("meshes", json!({ "name": name, "primitives": [primitive] })))
    }

    /// A node that shows a mesh, placed by the `placement` properties.
    pub(super) fn node(&mut self, name: &str, mesh: MeshIndex, placement: Value) {
        let mut node = json!({ "mesh": mesh.0, "name": name });
        merge(&mut node, placement);
        self.push("nodes", node);
    }

    /// A mesh with a node of the same name at the origin.
    pub(super) fn object(&mut self, name: &str, shape: &Shape, material: MaterialIndex) {
        let mesh = self.mesh(name, shape, material, false);
        self.node(name, mesh, json!({}));
    }

    /// A light of `KHR_lights_punctual` at `position`, shining along `direction`.
    pub(super) fn light(&mut self, name: &str, light: Value, position: Vec3, direction: Vec3) {
        self.use_extension("KHR_lights_punctual");
        let mut light = light;
        merge(&mut light, json!({ "name": name }));
        let index = self.lights.len();
        self.lights.push(light);
        let mut node = json!({
            "extensions": { "KHR_lights_punctual": { "light": index } },
            "name": name,
        });
        merge(&mut node, looking(position, direction));
        self.push("nodes", node);
    }

    /// A camera at `position`, looking along `direction`; `yfov` in radians.
    pub(super) fn camera(&mut self, position: Vec3, direction: Vec3, yfov: f64, aspect: f64) {
        let camera = json!({
            "name": "Camera",
            "perspective": { "aspectRatio": aspect, "yfov": yfov, "zfar": 100.0, "znear": 0.1 },
            "type": "perspective",
        });
        let index = self.push("cameras", camera);
        let mut node = json!({ "camera": index, "name": "Camera" });
        merge(&mut node, looking(position, direction));
        self.push("nodes", node);
    }

    /// The bytes of the file.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let count = self.lists["nodes"].as_array().map_or(0, Vec::len);
        let nodes: Vec<usize> = (0..count).collect();
        self.push("scenes", json!({ "name": self.name, "nodes": nodes }));
        let mut root = Value::Object(self.lists);
        let asset = json!({ "generator": "bevy_fresco make_scenes", "version": "2.0" });
        root["asset"] = asset;
        root["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        root["scene"] = json!(0);
        if !self.extensions_used.is_empty() {
            root["extensionsUsed"] = json!(self.extensions_used);
        }
        if !self.lights.is_empty() {
            root["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        container(&sorted(root).to_string(), self.binary)
    }

    fn use_extension(&mut self, name: &'static str) {
        if !self.extensions_used.contains(&name) {
            self.extensions_used.push(name);
        }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.lists.entry(list).or_insert_with(|| json!([]));
        let Value::Array(list) = list else {
            unreachable!("all lists are arrays");
        };
        list.push(value);
        list.len() - 1
    }

    fn buffer_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteLength": bytes.len(), "byteOffset": offset });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.push("bufferViews", view)
    }

    fn float_accessor(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.buffer_view(&bytes, Some(ARRAY_BUFFER));
        let count = values.len() / if kind == "VEC3" { 3 } else { 2 };
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }),
        )
    }

    fn index_accessor(&mut self, triangles: &[[u32; 3]]) -> usize {
        let indices = triangles.as_flattened();
        let bytes: Vec<u8> = indices
            .iter()
            .flat_map(|&i| {
                u16::try_from(i)
                    .expect("scenes have small meshes")
                    .to_le_bytes()
            })
            .collect();
        let view = self.buffer_view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.push(
            "accessors",
            json!({
                "bufferView": view,
                "componentType": UNSIGNED_SHORT,
                "count": indices.len(),
                "type": "SCALAR",
            }),
        )
    }
}

/// A node's properties for standing at `position` and looking (or shining) along `direction`.
fn looking(position: Vec3, direction: Vec3) -> Value {
    let back = -direction.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let rotation = Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back));
    // Six places are plenty, and the same on every machine.
    let short = |v: f32| (f64::from(v) * 1e6).round() / 1e6 + 0.0;
    json!({
        "rotation": rotation.to_array().map(short),
        "translation": position.to_array().map(short),
    })
}

/// Adds the properties of `extra` to those of `value`, objects in objects too.
fn merge(value: &mut Value, extra: Value) {
    match (value, extra) {
        (Value::Object(into), Value::Object(from)) => {
            for (name, extra) in from {
                merge(into.entry(name).or_insert(Value::Null), extra);
            }
        }
        (value, extra) => *value = extra,
    }
}

/// Names in alphabetical order, which other crates' features may turn off in `serde_json`.
fn sorted(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.into_iter().collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            entries.into_iter().map(|(k, v)| (k, sorted(v))).collect()
        }
        Value::Array(values) => values.into_iter().map(sorted).collect(),
        value => value,
    }
}

/// The GLB container, version 2: a header and two chunks, each padded to four bytes.
fn container(json: &str, mut binary: Vec<u8>) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = Vec::with_capacity(total);
    bytes.extend(b"glTF");
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
