//! Light as an attribute, one mesh for each node.

use bevy_fresco::gltf::{BakedPrimitive, ExportOptions, GltfError};
use serde_json::{Value, json};

use crate::build::*;

/// One mesh with a triangle and a line.
fn triangle_and_line() -> Builder {
    let mut builder = Builder::new();
    let position = builder.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let line = builder.indices(&[0, 1]);
    let mesh = json!({"name": "pair", "extras": 5, "primitives": [
        {"attributes": {"POSITION": position}},
        {"attributes": {"POSITION": position}, "indices": line, "mode": 1},
    ]});
    builder.push("meshes", mesh);
    builder
}

#[test]
fn light_becomes_an_attribute() {
    let document = triangle_and_line().document();
    let light = light(3);
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    let accessor = output.accessor(&output.primitive(0, 0)["attributes"]["_BAKED_LIGHT"]);
    assert_eq!(accessor["type"], "VEC3");
    let view = accessor["bufferView"].as_u64().unwrap() as usize;
    assert_eq!(output.json["bufferViews"][view]["target"], 34962);
    let expected: Vec<f32> = light.light.iter().flat_map(|l| l.to_array()).collect();
    assert_eq!(output.attribute(0, "_BAKED_LIGHT"), expected);
    assert_eq!(
        output.primitive(0, 1),
        &document.json["meshes"][0]["primitives"][1]
    );
    assert!(output.notes.is_empty());
}

#[test]
fn instances_get_meshes_of_their_own() {
    let mut builder = triangle_and_line();
    builder.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "name": "b"}, {"mesh": 0}]);
    builder.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let document = builder.document();
    let lights = [light(3), light(3), light(3)];
    let all: Vec<_> = (0..3)
        .map(|node| baked(key(node, 0, 0), &lights[node]))
        .collect();
    let output = export(&document, &all);
    let meshes: Vec<_> = (0..3)
        .map(|node| output.json["nodes"][node]["mesh"].clone())
        .collect();
    assert_eq!(meshes, [0, 1, 2]);
    assert_eq!(output.json["meshes"].as_array().unwrap().len(), 3);
    assert_eq!(output.json["meshes"][1]["name"], "pair_node1");
    assert_eq!(output.json["meshes"][2]["extras"], 5);
    let of = |mesh| output.primitive(mesh, 0)["attributes"].clone();
    assert_eq!(of(0)["POSITION"], of(2)["POSITION"]);
    assert_ne!(of(0)["_BAKED_LIGHT"], of(2)["_BAKED_LIGHT"]);
    // A node that is not baked keeps the mesh as it was.
    let output = export(&document, &all[1..2]);
    assert_eq!(output.json["nodes"][0]["mesh"], 0);
    assert_eq!(output.json["nodes"][1]["mesh"], 1);
    assert_eq!(output.json["meshes"][0], document.json["meshes"][0]);
}

#[test]
fn an_earlier_bake_is_overwritten() {
    let document = triangle(|b| json!({"_BAKED_LIGHT": b.floats("VEC3", &[9.0; 9])}));
    let light = light(3);
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    let expected: Vec<f32> = light.light.iter().flat_map(|l| l.to_array()).collect();
    assert_eq!(output.attribute(0, "_BAKED_LIGHT"), expected);
    // In its place, so that the file does not grow.
    assert_eq!(output.json["accessors"], document.json["accessors"]);
    assert_eq!(output.bin.len(), document.buffers[0].len());
    let output = export_split(&document);
    assert_eq!(output.attribute(0, "_BAKED_LIGHT").len(), 18);
}

fn refused(baked: &[BakedPrimitive<'_>], word: &str) {
    let document = triangle(|_| json!({}));
    let error = try_export(&document, baked, &ExportOptions::default());
    let error = error.err().unwrap();
    assert!(matches!(error, GltfError::Export { .. }));
    assert!(error.to_string().contains(word), "{error}");
}

#[test]
fn light_must_fit_and_be_finite() {
    refused(&[baked(key(0, 0, 0), &light(2))], "2 vertices");
    let mut bad = light(3);
    for value in [f32::NAN, f32::INFINITY] {
        bad.light[1].y = value;
        refused(&[baked(key(0, 0, 0), &bad)], "vertex 1");
    }
    let good = light(3);
    refused(&[baked(key(0, 0, 1), &good)], "primitive: 1");
    refused(&[baked(key(0, 1, 0), &good)], "mesh: 1");
    let once = baked(key(0, 0, 0), &good);
    refused(&[once, once], "twice");
    for refined in [
        |mesh: &mut bevy_fresco::mesh::RefinedMesh| mesh.triangles[0][0] = 6,
        |mesh: &mut bevy_fresco::mesh::RefinedMesh| mesh.vertices[0].triangle = 1,
        |mesh: &mut bevy_fresco::mesh::RefinedMesh| mesh.vertices[0].barycentrics.x = f32::NAN,
        |mesh: &mut bevy_fresco::mesh::RefinedMesh| mesh.vertices[0].barycentrics.x = 0.0,
    ] {
        let mut mesh = split_in_four(0);
        refined(&mut mesh);
        refused(&[baked(key(0, 0, 0), &refined_light(mesh))], "does not fit");
    }
}

#[test]
fn broken_documents_are_errors() {
    let good = light(3);
    let fails = |change: &dyn Fn(&mut bevy_fresco::gltf::Document)| {
        let mut document = triangle(|_| json!({}));
        change(&mut document);
        let baked = [baked(key(0, 0, 0), &good)];
        assert!(try_export(&document, &baked, &ExportOptions::default()).is_err());
        let split = refined_light(split_in_four(0));
        let baked = [crate::build::baked(key(0, 0, 0), &split)];
        assert!(try_export(&document, &baked, &ExportOptions::default()).is_err());
    };
    fails(&|d| d.json["bufferViews"][0]["buffer"] = 1.into());
    fails(&|d| d.buffers[0].truncate(3));
    fails(&|d| d.buffers.clear());
    fails(&|d| d.json["accessors"] = json!([]));
    fails(&|d| d.json["accessors"][0]["count"] = 4.into());
    fails(&|d| d.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(-1));
    fails(&|d| d.json["meshes"][0]["primitives"][0]["attributes"] = Value::Null);
}

#[test]
fn shared_light_of_an_earlier_bake_is_not_overwritten() {
    let mut document = triangle(|b| json!({"_BAKED_LIGHT": b.floats("VEC3", &[9.0; 9])}));
    document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
    document.json["scenes"][0]["nodes"] = json!([0, 1]);
    let light = light(3);
    let output = export(&document, &[baked(key(1, 0, 0), &light)]);
    assert_eq!(output.attribute(0, "_BAKED_LIGHT"), [9.0; 9]);
    assert_eq!(output.attribute(1, "_BAKED_LIGHT")[3], 1.0);
    // Nor is an accessor that means something else as well.
    let mut document = triangle(|b| json!({"_BAKED_LIGHT": b.floats("VEC3", &[9.0; 9])}));
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["_OTHER"] = attributes["_BAKED_LIGHT"].clone();
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    assert_eq!(output.attribute(0, "_OTHER"), [9.0; 9]);
    assert_eq!(output.attribute(0, "_BAKED_LIGHT")[3], 1.0);
}
