//! Builds glTF documents and takes exported files apart.

use bevy_fresco::{
    gltf::{
        BakedPrimitive, Document, ExportOptions, Exported, GltfError, LightEncoding, PrimitiveKey,
        to_glb,
    },
    mesh::{RefinedMesh, SurfacePoint},
    radiosity::ObjectLight,
};
use glam::Vec3;
use serde_json::{Value, json};

/// A document in the making, with one buffer.
pub(crate) struct Builder {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Builder {
    pub(crate) fn new() -> Self {
        Self {
            json: json!({
                "asset": {"version": "2.0", "generator": "test"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [],
                "accessors": [],
                "bufferViews": [],
            }),
            bin: Vec::new(),
        }
    }

    /// Appends an accessor of any kind.
    pub(crate) fn raw(
        &mut self,
        kind: &str,
        component: u32,
        normalized: bool,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()}),
        );
        self.bin.extend(bytes);
        let mut accessor =
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        if normalized {
            accessor["normalized"] = true.into();
        }
        self.push("accessors", accessor)
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.raw(kind, 5126, false, values.len() / width(kind), &bytes)
    }

    pub(crate) fn positions(&mut self, values: &[[f32; 3]]) -> usize {
        let accessor = self.floats("VEC3", values.as_flattened());
        let column = |axis: usize| values.iter().map(move |p| p[axis]);
        let min = [0, 1, 2].map(|axis| column(axis).fold(f32::MAX, f32::min));
        let max = [0, 1, 2].map(|axis| column(axis).fold(f32::MIN, f32::max));
        self.json["accessors"][accessor]["min"] = json!(min);
        self.json["accessors"][accessor]["max"] = json!(max);
        accessor
    }

    pub(crate) fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.raw("SCALAR", 5123, false, values.len(), &bytes)
    }

    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    pub(crate) fn document(mut self) -> Document {
        self.json["buffers"] = json!([{"uri": "scene.bin", "byteLength": self.bin.len()}]);
        Document {
            path: "scene.gltf".into(),
            json: self.json,
            buffers: vec![self.bin],
        }
    }
}

/// The unit triangle; further attributes are made by `add`.
pub(crate) fn triangle(add: impl FnOnce(&mut Builder) -> Value) -> Document {
    let mut builder = Builder::new();
    let position = builder.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let mut attributes = json!({"POSITION": position});
    let more = add(&mut builder);
    attributes
        .as_object_mut()
        .unwrap()
        .extend(more.as_object().unwrap().clone());
    builder.push(
        "meshes",
        json!({"primitives": [{"attributes": attributes}]}),
    );
    builder.document()
}

pub(crate) const ONE_TRIANGLE: &[[u32; 3]] = &[[0, 1, 2]];

/// Corners, then the middles of the edges 0-1, 1-2 and 2-0, as four triangles.
pub(crate) fn split_in_four(triangle: u32) -> RefinedMesh {
    let middle = |a: f32, b: f32, c: f32| SurfacePoint {
        triangle,
        barycentrics: Vec3::new(a, b, c),
    };
    RefinedMesh {
        vertices: vec![
            SurfacePoint::corner(triangle, 0),
            SurfacePoint::corner(triangle, 1),
            SurfacePoint::corner(triangle, 2),
            middle(0.5, 0.5, 0.0),
            middle(0.0, 0.5, 0.5),
            middle(0.5, 0.0, 0.5),
        ],
        triangles: vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        sources: vec![triangle; 4],
    }
}

/// Light that differs from vertex to vertex.
pub(crate) fn light(count: usize) -> ObjectLight {
    ObjectLight {
        mesh: None,
        light: (0..count)
            .map(|i| Vec3::new(i as f32, 0.5, 100.25))
            .collect(),
        gradient: Vec::new(),
        quality: Vec::new(),
    }
}

pub(crate) fn refined_light(mesh: RefinedMesh) -> ObjectLight {
    ObjectLight {
        mesh: Some(mesh.clone().into()),
        ..light(mesh.vertices.len())
    }
}

pub(crate) fn key(node: usize, mesh: usize, primitive: usize) -> PrimitiveKey {
    PrimitiveKey {
        node,
        mesh,
        primitive,
    }
}

pub(crate) fn baked<'a>(key: PrimitiveKey, light: &'a ObjectLight) -> BakedPrimitive<'a> {
    BakedPrimitive {
        key,
        light,
        triangles: ONE_TRIANGLE,
        flipped: false,
    }
}

pub(crate) fn colors(exposure: f32) -> ExportOptions {
    ExportOptions {
        encoding: LightEncoding::VertexColors { exposure },
        ..Default::default()
    }
}

/// An exported file, taken apart.
pub(crate) struct Output {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
    pub(crate) notes: Vec<String>,
}

pub(crate) fn try_export(
    document: &Document,
    baked: &[BakedPrimitive<'_>],
    options: &ExportOptions,
) -> Result<Output, GltfError> {
    to_glb(document, baked, &[], options).map(Output::new)
}

pub(crate) fn export(document: &Document, baked: &[BakedPrimitive<'_>]) -> Output {
    try_export(document, baked, &ExportOptions::default()).unwrap()
}

/// Exports the only primitive of a document cut in four.
pub(crate) fn export_split(document: &Document) -> Output {
    export(
        document,
        &[baked(key(0, 0, 0), &refined_light(split_in_four(0)))],
    )
}

impl Output {
    /// Checks the container and lets the `gltf` crate check the rest.
    pub(crate) fn new(exported: Exported) -> Self {
        let Exported { bytes, notes } = exported;
        gltf::Gltf::from_slice(&bytes).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(word(8), bytes.len());
        let json_end = 20 + word(12);
        assert_eq!((json_end % 4, bytes.len() % 4), (0, 0));
        let json: Value = serde_json::from_slice(&bytes[20..json_end]).unwrap();
        let output = Self {
            json,
            bin: bytes[json_end + 8..].to_vec(),
            notes,
        };
        output.check();
        output
    }

    fn check(&self) {
        let buffers = self.json["buffers"].as_array().unwrap();
        assert_eq!(buffers.len(), 1);
        let length = buffers[0]["byteLength"].as_u64().unwrap();
        assert_eq!(length.next_multiple_of(4), self.bin.len() as u64);
        for view in self.json["bufferViews"].as_array().unwrap() {
            let start = view["byteOffset"].as_u64().unwrap_or(0);
            assert!(start + view["byteLength"].as_u64().unwrap() <= length);
            assert_eq!(view["buffer"], 0);
        }
        for accessor in self.json["accessors"].as_array().unwrap() {
            if let Some(view) = accessor["bufferView"].as_u64() {
                let view = &self.json["bufferViews"][view as usize];
                let size = match accessor["componentType"].as_u64().unwrap() {
                    5120 | 5121 => 1,
                    5122 | 5123 => 2,
                    _ => 4,
                };
                let width = width(accessor["type"].as_str().unwrap()) as u64;
                let needed = accessor["count"].as_u64().unwrap() * width * size;
                assert!(needed <= view["byteLength"].as_u64().unwrap());
            }
        }
    }

    pub(crate) fn primitive(&self, mesh: usize, primitive: usize) -> &Value {
        &self.json["meshes"][mesh]["primitives"][primitive]
    }

    /// An attribute of the first primitive of `mesh`, which must be of floats.
    pub(crate) fn attribute(&self, mesh: usize, name: &str) -> Vec<f32> {
        self.floats(&self.primitive(mesh, 0)["attributes"][name])
    }

    pub(crate) fn accessor(&self, index: &Value) -> &Value {
        &self.json["accessors"][index.as_u64().unwrap() as usize]
    }

    pub(crate) fn floats(&self, accessor: &Value) -> Vec<f32> {
        let bytes = self.bytes(accessor, 5126, 4);
        let floats = bytes.chunks_exact(4);
        floats
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect()
    }

    pub(crate) fn shorts(&self, accessor: &Value) -> Vec<u16> {
        let bytes = self.bytes(accessor, 5123, 2);
        let shorts = bytes.chunks_exact(2);
        shorts
            .map(|b| u16::from_le_bytes(b.try_into().unwrap()))
            .collect()
    }

    fn bytes(&self, accessor: &Value, component: u64, size: usize) -> &[u8] {
        let accessor = self.accessor(accessor);
        assert_eq!(accessor["componentType"], component);
        let view = accessor["bufferView"].as_u64().unwrap() as usize;
        let start = self.json["bufferViews"][view]["byteOffset"].as_u64();
        let start = start.unwrap_or(0) as usize;
        let width = width(accessor["type"].as_str().unwrap());
        let length = accessor["count"].as_u64().unwrap() as usize * width * size;
        &self.bin[start..start + length]
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        _ => 16,
    }
}
