//! Geometry cut finer: every kind of attribute, every kind of source.

use bevy_fresco::{gltf::BakedPrimitive, mesh::RefinedMesh};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use crate::build::*;

#[test]
fn positions_are_cut_with_bounds() {
    let output = export_split(&triangle(|_| json!({})));
    let positions = output.attribute(0, "POSITION");
    assert_eq!(
        positions[..9],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    );
    assert_eq!(
        positions[9..],
        [0.5, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.5, 0.0]
    );
    let primitive = output.primitive(0, 0);
    let accessor = output.accessor(&primitive["attributes"]["POSITION"]);
    assert_eq!(accessor["min"], json!([0.0, 0.0, 0.0]));
    assert_eq!(accessor["max"], json!([1.0, 1.0, 0.0]));
    let indices = output.shorts(&primitive["indices"]);
    assert_eq!(indices, [0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5]);
    let view = output.accessor(&primitive["indices"])["bufferView"].as_u64();
    assert_eq!(
        output.json["bufferViews"][view.unwrap() as usize]["target"],
        34963
    );
}

#[test]
fn directions_stay_unit_vectors() {
    let output = export_split(&triangle(|b| {
        let normal = b.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0]);
        let tangent = [
            [1.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 1.0, -1.0],
            [0.0, 0.0, 1.0, -1.0],
        ];
        json!({"NORMAL": normal, "TANGENT": b.floats("VEC4", tangent.as_flattened())})
    }));
    let half = 0.5f32.sqrt();
    let normals = output.attribute(0, "NORMAL");
    assert_eq!(normals[9..12], [half, half, 0.0]);
    // Opposite normals have no mean; one of them is taken.
    assert_eq!(normals[12..15], [0.0, 1.0, 0.0]);
    let tangents = output.attribute(0, "TANGENT");
    assert_eq!(tangents[12..16], [half, 0.0, half, 1.0]);
    assert_eq!(tangents[16..20], [0.0, 0.0, 1.0, -1.0]);
}

#[test]
fn the_heaviest_corner_decides_handedness() {
    let mut mesh = split_in_four(0);
    mesh.vertices[3].barycentrics = Vec3::new(0.25, 0.75, 0.0);
    let document = triangle(|b| {
        let tangent = [
            [1.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, -1.0],
            [1.0, 0.0, 0.0, 1.0],
        ];
        json!({"TANGENT": b.floats("VEC4", tangent.as_flattened())})
    });
    let output = export(&document, &[baked(key(0, 0, 0), &refined_light(mesh))]);
    assert_eq!(
        output.attribute(0, "TANGENT")[12..16],
        [1.0, 0.0, 0.0, -1.0]
    );
}

#[test]
fn numbers_of_all_kinds_are_interpolated() {
    let output = export_split(&triangle(|b| {
        let uv = b.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 3.0]);
        // Normalised bytes, padded to four.
        let color = b.raw(
            "VEC4",
            5121,
            true,
            3,
            &[0, 0, 0, 255, 255, 0, 0, 255, 0, 51, 0, 255],
        );
        let ids = b.floats("SCALAR", &[3.0, 8.0, 8.0]);
        let heat = b.floats("SCALAR", &[1.0, 3.0, 5.0]);
        let mat = b.floats(
            "MAT2",
            &[0.0, 1.0, 2.0, 3.0, 2.0, 3.0, 4.0, 5.0, 0.0, 0.0, 0.0, 0.0],
        );
        json!({"TEXCOORD_3": uv, "COLOR_0": color, "_FEATURE_ID_0": ids, "_HEAT": heat,
               "_MATRIX": mat})
    }));
    assert_eq!(output.attribute(0, "TEXCOORD_3")[8..10], [0.5, 1.5]);
    let color = output.attribute(0, "COLOR_0");
    assert_eq!(color[12..20], [0.5, 0.0, 0.0, 1.0, 0.5, 0.1, 0.0, 1.0]);
    assert_eq!(output.attribute(0, "_FEATURE_ID_0")[3..], [8.0, 8.0, 8.0]);
    assert_eq!(output.attribute(0, "_HEAT"), [1.0, 3.0, 5.0, 2.0, 4.0, 3.0]);
    assert_eq!(output.attribute(0, "_MATRIX")[12..16], [1.0, 2.0, 3.0, 4.0]);
    let accessor = &output.primitive(0, 0)["attributes"]["COLOR_0"];
    assert_eq!(output.accessor(accessor).get("normalized"), None);
    assert_eq!(output.accessor(accessor)["type"], "VEC4");
}

#[test]
fn corners_keep_their_bits() {
    let odd = [
        0.1f32,
        1e-40,
        3.3333333,
        -0.0,
        f32::MIN_POSITIVE,
        1e30,
        0.7,
        0.8,
        0.9,
    ];
    let document = triangle(|b| json!({"NORMAL": b.floats("VEC3", &odd)}));
    let output = export_split(&document);
    let written = output.attribute(0, "NORMAL");
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&written[..9]), bits(&odd));
}

#[test]
fn values_that_are_no_numbers_become_zero() {
    let document = triangle(
        |b| json!({"TEXCOORD_0": b.floats("VEC2", &[f32::NAN, 1.0, 1.0, 1.0, f32::INFINITY, 1.0])}),
    );
    let output = export_split(&document);
    assert!(
        output
            .attribute(0, "TEXCOORD_0")
            .iter()
            .all(|v| v.is_finite())
    );
    assert!(output.notes[0].contains("TEXCOORD_0"));
}

fn skinned(joints: [[u8; 4]; 3], weights: [[f32; 4]; 3]) -> (Vec<u16>, Vec<f32>) {
    let output = export_split(&triangle(|b| {
        let joints = b.raw("VEC4", 5121, false, 3, joints.as_flattened());
        json!({"JOINTS_0": joints, "WEIGHTS_0": b.floats("VEC4", weights.as_flattened())})
    }));
    let joints = output.shorts(&output.primitive(0, 0)["attributes"]["JOINTS_0"]);
    (joints, output.attribute(0, "WEIGHTS_0"))
}

#[test]
fn joints_are_merged() {
    let (joints, weights) = skinned(
        [[1, 2, 0, 0], [2, 3, 0, 0], [9, 0, 0, 0]],
        [
            [0.5, 0.5, 0.0, 0.0],
            [0.75, 0.25, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
        ],
    );
    assert_eq!(joints[..8], [1, 2, 0, 0, 2, 3, 0, 0]);
    assert_eq!(weights[4..8], [0.75, 0.25, 0.0, 0.0]);
    assert_eq!(joints[12..16], [2, 1, 3, 0]);
    assert_eq!(weights[12..16], [0.625, 0.25, 0.125, 0.0]);
    assert_eq!(joints[16..20], [9, 2, 3, 0]);
}

#[test]
fn only_the_heaviest_joints_are_kept() {
    let (joints, weights) = skinned(
        [[1, 2, 3, 4], [5, 6, 7, 8], [5, 6, 7, 8]],
        [
            [0.4, 0.3, 0.2, 0.1],
            [0.7, 0.1, 0.1, 0.1],
            [0.7, 0.1, 0.1, 0.1],
        ],
    );
    assert_eq!(joints[12..16], [5, 1, 2, 3]);
    let sum: f32 = weights[12..16].iter().sum();
    assert!((sum - 1.0).abs() < 1e-6);
    assert!((weights[12] - 0.35 / 0.8).abs() < 1e-6);
}

#[test]
fn several_sets_of_joints_are_one_list() {
    let output = export_split(&triangle(|b| {
        let first = b.raw(
            "VEC4",
            5121,
            false,
            3,
            &[1, 2, 3, 4, 5, 6, 7, 8, 5, 6, 7, 8],
        );
        let second = b.raw(
            "VEC4",
            5121,
            false,
            3,
            &[9, 0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0],
        );
        let weights = b.floats("VEC4", &[0.125; 12]);
        let half = [0.5, 0.0, 0.0, 0.0];
        let more = b.floats("VEC4", [half; 3].as_flattened());
        json!({"JOINTS_0": first, "WEIGHTS_0": weights, "JOINTS_1": second, "WEIGHTS_1": more})
    }));
    let attributes = &output.primitive(0, 0)["attributes"];
    assert_eq!(output.shorts(&attributes["JOINTS_0"])[12..16], [9, 1, 2, 3]);
    assert_eq!(output.shorts(&attributes["JOINTS_1"])[12..16], [4, 5, 6, 7]);
    assert_eq!(output.attribute(0, "WEIGHTS_0")[12], 0.5 / 0.9375);
}

#[test]
fn morph_targets_are_cut_too() {
    let mut document = triangle(|b| {
        let deltas = b.positions(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 4.0]]);
        let normals = b.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
        json!({"_D": deltas, "_N": normals})
    });
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    let attributes = primitive["attributes"].as_object_mut().unwrap();
    let (deltas, normals) = (attributes.shift_remove("_D"), attributes.shift_remove("_N"));
    primitive["targets"] = json!([{"POSITION": deltas, "NORMAL": normals}]);
    let output = export_split(&document);
    let target = &output.primitive(0, 0)["targets"][0];
    assert_eq!(
        output.floats(&target["POSITION"])[9..15],
        [1.0, 0.0, 0.0, 1.0, 0.0, 2.0]
    );
    assert_eq!(output.floats(&target["NORMAL"])[9..12], [0.0, 0.25, 0.0]);
    assert_eq!(
        output.accessor(&target["POSITION"])["max"],
        json!([2.0, 0.0, 4.0])
    );
}

#[test]
fn mirrored_triangles_are_turned_back() {
    let mut document = triangle(|_| json!({}));
    document.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let light = refined_light(split_in_four(0));
    let baked = BakedPrimitive {
        triangles: &[[0, 2, 1]],
        flipped: true,
        ..baked(key(0, 0, 0), &light)
    };
    let output = export(&document, &[baked]);
    let indices = output.shorts(&output.primitive(0, 0)["indices"]);
    let positions = output.attribute(0, "POSITION");
    let at = |index: u16| Vec2::from_slice(&positions[usize::from(index) * 3..]);
    for triangle in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| at(triangle[corner]));
        // Counter-clockwise as the source is, in the space of the mesh.
        assert!((b - a).perp_dot(c - a) > 0.0);
    }
}

/// Two triangles of a strip, each cut in four with vertices of its own.
#[test]
fn strips_become_triangles_and_shared_edges_agree() {
    let mut builder = Builder::new();
    let position = builder.positions(&[
        [0.1, 0.0, 0.3],
        [0.7, 0.1, 0.123],
        [0.0, 0.9, 0.77],
        [1.1, 1.0, 0.0],
    ]);
    let indices = builder.indices(&[0, 1, 2, 3]);
    builder.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": position}, "indices": indices,
                               "mode": 5}]}),
    );
    let mut mesh = split_in_four(0);
    // Not the middle: the rounding of a third is seen.
    let (third, rest) = (1.0 / 3.0, 1.0 - 1.0f32 / 3.0);
    mesh.vertices[4].barycentrics = Vec3::new(0.0, third, rest);
    let mut other = split_in_four(1);
    other.vertices[5].barycentrics = Vec3::new(rest, 0.0, third);
    mesh.vertices.extend(other.vertices);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + 6)));
    let light = refined_light(mesh);
    let baked = BakedPrimitive {
        // The second triangle has the edge 1-2 as its corners 2 and 0.
        triangles: &[[0, 1, 2], [2, 3, 1]],
        ..baked(key(0, 0, 0), &light)
    };
    let output = export(&builder.document(), &[baked]);
    assert_eq!(output.primitive(0, 0)["mode"], 4);
    assert_eq!(output.shorts(&output.primitive(0, 0)["indices"]).len(), 24);
    let positions = output.attribute(0, "POSITION");
    assert_eq!(positions[12..15], positions[33..36]);
}

#[test]
fn quantised_sources_become_floats() {
    let mut builder = Builder::new();
    let bytes = |values: &[i16]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<_>>()
    };
    // Padded to eight bytes a vertex.
    let position = bytes(&[0, 0, 0, 0, 100, 0, 0, 0, 0, -50, 7, 0]);
    let position = builder.raw("VEC3", 5122, false, 3, &position);
    builder.json["bufferViews"][position]["byteStride"] = 8.into();
    builder.json["accessors"][position]["min"] = json!([0, -50, 0]);
    builder.json["accessors"][position]["max"] = json!([100, 0, 7]);
    let normal = builder.raw(
        "VEC3",
        5120,
        true,
        3,
        &[127, 0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0],
    );
    builder.json["bufferViews"][normal]["byteStride"] = 4.into();
    builder.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    builder.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": position, "NORMAL": normal}}]}),
    );
    let output = export_split(&builder.document());
    let positions = output.attribute(0, "POSITION");
    assert_eq!(
        positions[3..15],
        [
            100.0, 0.0, 0.0, 0.0, -50.0, 7.0, 50.0, 0.0, 0.0, 50.0, -25.0, 3.5
        ]
    );
    let half = 0.5f32.sqrt();
    assert_eq!(output.attribute(0, "NORMAL")[9..12], [half, half, 0.0]);
}

#[test]
fn large_meshes_get_wide_indices() {
    let mut mesh = split_in_four(0);
    let extra = mesh.vertices[5];
    mesh.vertices.resize(65_535, extra);
    mesh.triangles[0][0] = 65_534;
    let document = triangle(|_| json!({}));
    let output = export(
        &document,
        &[baked(key(0, 0, 0), &refined_light(mesh.clone()))],
    );
    assert_eq!(output.shorts(&output.primitive(0, 0)["indices"])[0], 65_534);
    mesh.vertices.push(extra);
    let output = export(&document, &[baked(key(0, 0, 0), &refined_light(mesh))]);
    let indices = output.accessor(&output.primitive(0, 0)["indices"]);
    assert_eq!(indices["componentType"], 5125);
}

#[test]
fn an_empty_refined_mesh_changes_nothing() {
    let document = triangle(|_| json!({}));
    let light = refined_light(RefinedMesh::default());
    let output = export(&document, &[baked(key(0, 0, 0), &light)]);
    assert_eq!(output.json["meshes"], document.json["meshes"]);
}

#[test]
fn extensions_that_speak_of_vertices_get_a_note() {
    let mut document = triangle(|_| json!({}));
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    primitive["extensions"] = json!({"ACME_edges": {}, "KHR_materials_variants": Value::Null});
    let output = export_split(&document);
    assert_eq!(output.notes.len(), 1);
    assert!(output.notes[0].contains("ACME_edges"));
}
