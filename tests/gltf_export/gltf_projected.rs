//! Texture coordinates written into a file.

use bevy_fresco::gltf::{ProjectedPrimitive, to_projected_glb};
use bevy_fresco::mesh::UvMesh;
use glam::Vec2;
use serde_json::json;

use crate::build::{ONE_TRIANGLE, Output, key, triangle};

/// They followed other texture coordinates, in the mesh and in what morph targets add to it.
#[test]
fn tangents_go_with_the_old_coordinates() {
    let mut document = triangle(|b| {
        let tangents = b.floats("VEC4", [1.0, 0.0, 0.0, 1.0].repeat(3).as_slice());
        let deltas = b.positions(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 4.0]]);
        let turns = b.floats("VEC3", &[0.5; 9]);
        json!({"TANGENT": tangents, "_D": deltas, "_T": turns})
    });
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    let attributes = primitive["attributes"].as_object_mut().unwrap();
    let (deltas, turns) = (attributes.shift_remove("_D"), attributes.shift_remove("_T"));
    primitive["targets"] = json!([{"POSITION": deltas, "TANGENT": turns}]);
    let mesh = UvMesh {
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        sources: vec![0, 1, 2],
        triangles: ONE_TRIANGLE.to_vec(),
        over_poles: Vec::new(),
    };
    let projected = ProjectedPrimitive {
        key: key(0, 0, 0),
        triangles: ONE_TRIANGLE,
        mesh: &mesh,
    };
    let output = Output::new(to_projected_glb(&document, &[projected]).unwrap());
    let primitive = output.primitive(0, 0);
    let names = |attributes: &serde_json::Value| -> Vec<String> {
        attributes.as_object().unwrap().keys().cloned().collect()
    };
    assert_eq!(names(&primitive["attributes"]), ["POSITION", "TEXCOORD_0"]);
    assert_eq!(names(&primitive["targets"][0]), ["POSITION"]);
    let uvs = output.attribute(0, "TEXCOORD_0");
    assert_eq!(uvs, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
}
