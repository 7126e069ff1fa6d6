//! Gradients of light: in the space of the mesh, wherever its node stands.

use bevy_fresco::radiosity::ObjectLight;
use glam::{Mat3, Quat, Vec3};
use serde_json::json;

use crate::build::*;

const GRADIENTS: [Vec3; 3] = [
    Vec3::new(0.0, 3.0, 1.0),
    Vec3::new(-2.0, 0.25, 0.0),
    Vec3::new(0.5, -7.0, 4.0),
];

fn directional() -> ObjectLight {
    ObjectLight {
        gradient: GRADIENTS.to_vec(),
        ..light(3)
    }
}

fn vectors(output: &Output, mesh: usize) -> Vec<Vec3> {
    let numbers = output.attribute(mesh, "_BAKED_LIGHT_GRADIENT");
    numbers.chunks(3).map(Vec3::from_slice).collect()
}

/// What the contract says a loader makes of them.
fn in_world(world_from_mesh: Mat3, gradients: &[Vec3]) -> Vec<Vec3> {
    let scale = world_from_mesh.determinant().abs().cbrt();
    gradients
        .iter()
        .map(|g| world_from_mesh * *g / scale)
        .collect()
}

fn assert_near(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((*a - *b).length() < 1e-4, "{a} {b}");
    }
}

#[test]
fn gradients_become_an_attribute_that_turns_with_the_mesh() {
    let mut document = triangle(|_| json!({}));
    let turned = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.8);
    // Mirrored, stretched, and below another node.
    let size = Vec3::new(2.0, -0.5, 3.0);
    document.json["nodes"] = json!([
        {"mesh": 0, "scale": size.to_array(), "translation": [1.0, 2.0, 3.0]},
        {"children": [0], "rotation": turned.to_array()},
    ]);
    document.json["scenes"][0]["nodes"] = json!([1]);
    let light = directional();
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    let accessor = output.accessor(&output.primitive(0, 0)["attributes"]["_BAKED_LIGHT_GRADIENT"]);
    assert_eq!(accessor["type"], "VEC3");
    assert_eq!(
        output.json["asset"]["extras"]["fresco"]["directional"],
        true
    );
    let world = Mat3::from_quat(turned) * Mat3::from_diagonal(size);
    assert_near(&in_world(world, &vectors(&output, 0)), &GRADIENTS);
    assert!(output.notes.is_empty());
}

#[test]
fn instances_have_gradients_of_their_own() {
    let mut document = triangle(|_| json!({}));
    let turned = Quat::from_rotation_x(1.0);
    document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "rotation": turned.to_array()}]);
    document.json["scenes"][0]["nodes"] = json!([0, 1]);
    let light = directional();
    let both = [baked(key(0, 0, 0), &light), baked(key(1, 0, 0), &light)];
    let output = export(&document, &both);
    assert_eq!(vectors(&output, 0), GRADIENTS);
    assert_near(
        &in_world(Mat3::from_quat(turned), &vectors(&output, 1)),
        &GRADIENTS,
    );
    assert!(vectors(&output, 1)[0].distance(GRADIENTS[0]) > 1.0);
}

#[test]
fn refined_meshes_and_skins_have_them_too() {
    let mut light = refined_light(split_in_four(0));
    light.gradient = (0..6).map(|i| Vec3::new(1.0, i as f32, 2.0)).collect();
    let document = triangle(|_| json!({}));
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    assert_eq!(vectors(&output, 0), light.gradient);
    // A skin stands where its joints are.
    let mut document = triangle(|b| {
        json!({
            "JOINTS_0": b.raw("VEC4", 5121, false, 3, &[0; 12]),
            "WEIGHTS_0": b.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3)),
        })
    });
    let turned = Quat::from_rotation_z(0.5).to_array();
    document.json["nodes"][0] = json!({"mesh": 0, "skin": 0, "rotation": turned});
    document.json["skins"] = json!([{"joints": [0]}]);
    let light = directional();
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    assert_eq!(vectors(&output, 0), GRADIENTS);
}

#[test]
fn gradients_of_an_earlier_bake_are_overwritten_or_go() {
    let document = triangle(|b| {
        json!({
            "_BAKED_LIGHT": b.floats("VEC3", &[9.0; 9]),
            "_BAKED_LIGHT_GRADIENT": b.floats("VEC3", &[8.0; 9]),
        })
    });
    let with = directional();
    let output = export(&document, &[baked(key(0, 0, 0), &with)]);
    assert_eq!(vectors(&output, 0), GRADIENTS);
    assert_eq!(output.bin.len(), document.buffers[0].len());
    let without = light(3);
    let output = export(&document, &[baked(key(0, 0, 0), &without)]);
    let is_there = |o: &Output| {
        o.primitive(0, 0)["attributes"]
            .get("_BAKED_LIGHT_GRADIENT")
            .is_some()
    };
    assert!(!is_there(&output));
    assert!(output.json["asset"]["extras"]["fresco"]["directional"].is_null());
    let output = try_export(&document, &[baked(key(0, 0, 0), &with)], &colors(1.0)).unwrap();
    assert!(!is_there(&output));
}

#[test]
fn what_cannot_be_written_is_said() {
    let mut document = triangle(|_| json!({}));
    let mut light = directional();
    light.gradient[2].x = f32::NAN;
    let fails = |light: &ObjectLight, word: &str| {
        let error = try_export(
            &document,
            &[baked(key(0, 0, 0), light)],
            &Default::default(),
        );
        let error = error.err().unwrap().to_string();
        assert!(error.contains(word), "{error}");
    };
    fails(&light, "gradient of");
    light.gradient.pop();
    fails(&light, "gradients for 2");
    document.json["nodes"][0]["scale"] = json!([1.0, 1.0, 0.0]);
    let light = directional();
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    assert_eq!(vectors(&output, 0), [Vec3::ZERO; 3]);
    assert!(output.notes[0].contains("flattens"), "{:?}", output.notes);
}
