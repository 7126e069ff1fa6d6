//! Accessors, primitives, transforms, skins and morph targets.

use glam::{DVec3, Vec2, Vec3, Vec4};
use serde_json::json;

use super::import::GltfScene;
use super::test_file::{F32, File, I8, I16, U8, U16, U32, f32_bytes, noted, u16_bytes};
use crate::radiosity::Object;

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];

fn square(mode: u32) -> File {
    let mut file = File::new();
    let positions = file.floats("VEC3", &SQUARE);
    file.mesh(json!({ "attributes": { "POSITION": positions }, "mode": mode }));
    file.root_node(json!({ "mesh": 0 }));
    file
}

fn first(scene: &GltfScene) -> &Object {
    &scene.scene.objects[0]
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// Length: twice the triangle's area.
fn face_normal(object: &Object, triangle: usize) -> Vec3 {
    let [a, b, c] = object.triangles[triangle].map(|i| object.positions[i as usize]);
    (b - a).cross(c - a)
}

#[test]
fn plain_triangle() {
    let scene = File::triangle().load();
    let object = first(&scene);
    assert_eq!(object.name, "tri");
    assert_eq!(object.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(object.triangles, [[0, 1, 2]]);
    assert!(object.normals.is_empty() && object.uvs.is_empty() && object.colors.is_empty());
    assert_eq!(scene.scene.origin, DVec3::ZERO);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.objects[0].node, 0);
    assert!(noted(&scene, &["tri", "no material"]));
    assert_eq!(scene.scene.materials[0].metallic, 0.0);
}

#[test]
fn every_index_type() {
    let indices = [2_u16, 0, 1];
    let types = [
        (U8, indices.map(|i| i as u8).to_vec()),
        (U16, u16_bytes(&indices)),
        (
            U32,
            indices
                .iter()
                .flat_map(|&i| u32::from(i).to_le_bytes())
                .collect(),
        ),
    ];
    for (component, bytes) in types {
        let mut file = File::triangle();
        let accessor = file.accessor(component, "SCALAR", 3, &bytes);
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
        assert_eq!(first(&file.load()).triangles, [[2, 0, 1]]);
    }
    let mut file = File::triangle();
    let accessor = file.accessor(I16, "SCALAR", 3, &u16_bytes(&indices));
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
    assert!(file.reason().contains("no unsigned integers"));
}

#[test]
fn strips_and_fans_wind_one_way() {
    let strip = square(5).load();
    assert_eq!(first(&strip).triangles.len(), 2);
    for triangle in 0..2 {
        assert!(near(face_normal(first(&strip), triangle), Vec3::Z));
    }
    let mut file = square(6);
    let order = file.accessor(U8, "SCALAR", 4, &[0, 1, 3, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(order);
    let fan = file.load();
    assert_eq!(first(&fan).triangles.len(), 2);
    for triangle in 0..2 {
        assert!(near(face_normal(first(&fan), triangle), Vec3::Z));
    }
}

#[test]
fn points_and_lines_are_left_out() {
    for mode in 0..4 {
        let scene = square(mode).load();
        assert!(scene.scene.objects.is_empty());
        assert!(noted(&scene, &["node 0", "left out"]));
    }
    assert!(square(7).reason().contains("mode"));
}

#[test]
fn primitive_without_positions_is_left_out() {
    let mut file = File::triangle();
    file.json["meshes"][0]["primitives"][0]["attributes"] = json!({});
    let scene = file.load();
    assert!(scene.scene.objects.is_empty() && noted(&scene, &["tri", "no positions"]));
}

#[test]
fn leftover_indices_are_noted() {
    let mut file = square(4);
    file.json["accessors"][0]["count"] = json!(4);
    let scene = file.load();
    assert_eq!(first(&scene).triangles.len(), 1);
    assert!(noted(&scene, &["multiple of three"]));
}

#[test]
fn interleaved_attributes() {
    let mut file = File::triangle();
    let rows = [0., 0., 0., 9., 8., 1., 0., 0., 7., 6., 0., 1., 0., 5., 4.];
    let view = file.view(&f32_bytes(&rows));
    file.json["bufferViews"][view]["byteStride"] = json!(20);
    let base = json!({ "bufferView": view, "componentType": F32, "count": 3, "type": "VEC3" });
    let positions = file.push("accessors", base.clone());
    let mut uv = base;
    uv["type"] = json!("VEC2");
    uv["byteOffset"] = json!(12);
    let uv = file.push("accessors", uv);
    file.attribute("POSITION", positions);
    file.attribute("TEXCOORD_0", uv);
    let scene = file.load();
    assert_eq!(first(&scene).positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(
        first(&scene).uvs,
        [[Vec2::new(9., 8.), Vec2::new(7., 6.), Vec2::new(5., 4.)]]
    );
}

#[test]
fn sparse_values_with_and_without_base() {
    for with_base in [true, false] {
        let mut file = File::triangle();
        let indices = file.view(&u16_bytes(&[1, 2]));
        let values = file.view(&f32_bytes(&[5., 0., 0., 0., 7., 0.]));
        file.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": U16 },
            "values": { "bufferView": values }
        });
        if !with_base {
            file.json["accessors"][0]
                .as_object_mut()
                .unwrap()
                .remove("bufferView");
        }
        let scene = file.load();
        assert_eq!(
            first(&scene).positions,
            [Vec3::ZERO, Vec3::X * 5., Vec3::Y * 7.]
        );
    }
}

#[test]
fn quantized_positions_and_normals() {
    let cases: [(u32, bool, Vec<u8>, f32); 5] = [
        (
            I8,
            false,
            [0, 0, 0, 0, -100_i8 as u8, 0, 0, 0, 0, 100, 0, 0].to_vec(),
            100.0,
        ),
        (
            I8,
            true,
            [0, 0, 0, 0, -128_i8 as u8, 0, 0, 0, 0, 127, 0, 0].to_vec(),
            1.0,
        ),
        (
            U8,
            true,
            [0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0].to_vec(),
            1.0,
        ),
        (
            I16,
            true,
            u16_bytes(&[0, 0, 0, 0, 32768, 0, 0, 0, 0, 32767, 0, 0]),
            1.0,
        ),
        (
            U16,
            false,
            u16_bytes(&[0, 0, 0, 0, 50000, 0, 0, 0, 0, 50000, 0, 0]),
            50000.0,
        ),
    ];
    for (component, normalized, bytes, size) in cases {
        let mut file = File::triangle();
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let accessor = file.accessor(component, "VEC3", 3, &bytes);
        let view = file.json["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap() as usize;
        file.json["bufferViews"][view]["byteStride"] = json!(bytes.len() / 3);
        file.json["accessors"][accessor]["normalized"] = json!(normalized);
        file.attribute("POSITION", accessor);
        let scene = file.load();
        let positions = &first(&scene).positions;
        let sign = if matches!(component, I8 | I16) {
            -1.0
        } else {
            1.0
        };
        assert_eq!(positions[1], Vec3::X * size * sign, "{component}");
        assert_eq!(positions[2], Vec3::Y * size, "{component}");
    }
    let mut file = File::triangle();
    let normals = file.accessor(I8, "VEC3", 3, &[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0]);
    file.json["accessors"][normals]["normalized"] = json!(true);
    file.json["bufferViews"][1]["byteStride"] = json!(4);
    file.attribute("NORMAL", normals);
    assert_eq!(first(&file.load()).normals, [Vec3::Z; 3]);
}

#[test]
fn colors_of_all_kinds() {
    let white = [1.0_f32; 9];
    let mut file = File::triangle();
    let colors = file.floats("VEC3", &white);
    file.attribute("COLOR_0", colors);
    assert_eq!(first(&file.load()).colors, [Vec4::ONE; 3]);

    let mut file = File::triangle();
    let row = [255, 0, 51, 255];
    let colors = file.accessor(U8, "VEC4", 3, &[row, row, row].concat());
    file.json["accessors"][colors]["normalized"] = json!(true);
    file.attribute("COLOR_0", colors);
    let scene = file.load();
    assert_eq!(first(&scene).colors[2], Vec4::new(1.0, 0.0, 0.2, 1.0));

    let mut file = File::triangle();
    let colors = file.accessor(U16, "VEC4", 3, &u16_bytes(&[65535, 0, 0, 13107].repeat(3)));
    file.json["accessors"][colors]["normalized"] = json!(true);
    file.attribute("COLOR_0", colors);
    assert_eq!(first(&file.load()).colors[0], Vec4::new(1.0, 0.0, 0.0, 0.2));
}

#[test]
fn several_uv_sets() {
    let mut file = File::triangle();
    for set in 0..3_u8 {
        let uv = file.floats("VEC2", &[f32::from(set); 6]);
        file.attribute(&format!("TEXCOORD_{set}"), uv);
    }
    let scene = file.load();
    assert_eq!(first(&scene).uvs.len(), 3);
    assert_eq!(first(&scene).uvs[2][1], Vec2::splat(2.0));
}

#[test]
fn transforms_compose() {
    let mut file = File::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    file.json["nodes"][0] = json!({
        "mesh": 0, "translation": [1, 0, 0], "scale": [2, 3, 1],
        "rotation": [0, 0, half, half]
    });
    file.json["scenes"][0]["nodes"] = json!([1]);
    let columns = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 10, 20, 30, 1];
    file.push("nodes", json!({ "children": [0], "matrix": columns }));
    let scene = file.load();
    let object = first(&scene);
    // Inner: scale, a quarter turn about z, one to the right. Outer: (x, y, z) to (z, y, -x).
    let outer = |p: Vec3| Vec3::new(p.z, p.y, -p.x) + Vec3::new(10., 20., 30.);
    assert!(near(object.positions[0], outer(Vec3::new(1., 0., 0.))));
    assert!(near(object.positions[1], outer(Vec3::new(1., 2., 0.))));
    assert!(near(object.positions[2], outer(Vec3::new(-2., 0., 0.))));
    assert_eq!(object.name, "node 0");
}

#[test]
fn mirrored_node_keeps_its_front() {
    let mut file = File::triangle();
    let normals = file.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    file.attribute("NORMAL", normals);
    for scale in [[-1., 1., 1.], [-2., -3., -1.], [1., 1., -1.]] {
        file.json["nodes"][0]["scale"] = json!(scale);
        let scene = file.load();
        let object = first(&scene);
        assert_eq!(object.triangles, [[0, 2, 1]]);
        let up = if scale[2] < 0.0 { Vec3::NEG_Z } else { Vec3::Z };
        assert_eq!(object.normals, [up; 3]);
        assert!(face_normal(object, 0).dot(up) > 0.0);
    }
}

#[test]
fn normals_of_stretched_nodes_stay_upright() {
    let mut file = File::new();
    let positions = file.floats("VEC3", &[1., 0., 0., 0., 1., 0., 0., 1., 1.]);
    let s = std::f32::consts::FRAC_1_SQRT_2;
    let normals = file.floats("VEC3", &[s, s, 0., s, s, 0., s, s, 0.]);
    file.mesh(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    file.root_node(json!({ "mesh": 0, "scale": [4, 1, 1] }));
    let scene = file.load();
    let object = first(&scene);
    assert!(near(
        object.normals[0],
        face_normal(object, 0).normalize().abs()
    ));
    // Flattened to a plane: still the normal of that plane.
    file.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 1]);
    assert!(file.load().scene.objects[0].normals[0].is_normalized());
}

#[test]
fn missing_normals_come_from_faces() {
    let mut file = File::triangle();
    let normals = file.floats("VEC3", &[0., 0., 0., f32::NAN, 0., 1., 0., 0., 2.]);
    file.attribute("NORMAL", normals);
    let scene = file.load();
    assert_eq!(first(&scene).normals, [Vec3::Z; 3]);
    assert!(noted(&scene, &["tri", "normals", "(2)"]));
}

#[test]
fn instances_and_names() {
    let mut file = File::triangle();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(primitive);
    file.json["meshes"][0]["name"] = json!("shared");
    file.root_node(json!({ "mesh": 0, "translation": [0, 0, 5] }));
    let scene = file.load();
    let names: Vec<_> = scene
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["tri/0", "tri/1", "shared/0", "shared/1"]);
    let keys: Vec<_> = scene
        .objects
        .iter()
        .map(|k| (k.node, k.mesh, k.primitive))
        .collect();
    assert_eq!(keys, [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1)]);
    assert_eq!(scene.scene.objects[3].positions[1], Vec3::new(1., 0., 5.));
    assert_eq!(
        scene.scene.objects[0].material,
        scene.scene.objects[3].material
    );
}

#[test]
fn far_scenes_keep_their_precision() {
    let mut file = File::triangle();
    file.json["nodes"][0]["translation"] = json!([1_000_000.03125, 0, -2_000_000.015_625]);
    let scene = file.load();
    let origin = scene.scene.origin;
    assert!((origin - DVec3::new(1e6, 0., -2e6)).length() < 2.0);
    assert_eq!((origin * 16.0).fract(), DVec3::ZERO);
    let world = first(&scene).positions[1].as_dvec3() + origin;
    assert!((world - DVec3::new(1_000_001.03125, 0., -2_000_000.015_625)).length() < 1e-6);
    // A mesh off to one side, but large: left where it is.
    file.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    assert_eq!(file.load().scene.origin, DVec3::ZERO);
}

#[test]
fn only_the_default_scene() {
    let mut file = File::triangle();
    file.push("nodes", json!({ "mesh": 0, "name": "other" }));
    file.push("scenes", json!({ "nodes": [1] }));
    assert_eq!(file.load().scene.objects[0].name, "tri");
    file.json["scene"] = json!(1);
    assert_eq!(file.load().scene.objects[0].name, "other");
    file.json.as_object_mut().unwrap().remove("scene");
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 1);
    assert!(noted(&scene, &["first of its 2 scenes"]));
    file.json.as_object_mut().unwrap().remove("scenes");
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 2);
    assert!(noted(&scene, &["no scene"]));
}

#[test]
fn scene_without_nodes() {
    let mut file = File::triangle();
    file.json["scenes"] = json!([{ "name": "empty", "extras": { "a": [1, 2] } }]);
    assert!(file.load().scene.objects.is_empty());
}

#[test]
fn hidden_nodes_are_left_out() {
    let mut file = File::triangle();
    file.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    file.json["nodes"][0]["children"] = json!([1]);
    file.push("nodes", json!({ "mesh": 0 }));
    let scene = file.load();
    assert!(scene.scene.objects.is_empty() && noted(&scene, &["tri", "hidden"]));
}

#[test]
fn skins_stand_in_their_rest_pose() {
    let mut file = File::triangle();
    let joints = file.accessor(U8, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = [1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 0., 0.];
    let weights = file.floats("VEC4", &weights);
    file.attribute("JOINTS_0", joints);
    file.attribute("WEIGHTS_0", weights);
    let mut binds = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    binds.extend(glam::Mat4::from_translation(Vec3::X).to_cols_array());
    let binds = file.floats("MAT4", &binds);
    let a = file.root_node(json!({ "translation": [0, 0, 2] }));
    let b = file.root_node(json!({ "translation": [0, 0, 4] }));
    file.push(
        "skins",
        json!({ "joints": [a, b], "inverseBindMatrices": binds }),
    );
    file.json["nodes"][0]["skin"] = json!(0);
    // The node's own transform does not matter.
    file.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    let scene = file.load();
    let expected = [
        Vec3::new(0., 0., 2.),
        Vec3::new(2., 0., 4.),
        // Half of each, though the weights add to two.
        Vec3::new(0.5, 1., 3.),
    ];
    assert_eq!(first(&scene).positions, expected);
    assert!(noted(&scene, &["tri", "rest pose"]));
    file.json["skins"][0]["joints"] = json!([a]);
    assert!(file.reason().contains("joint 1"));
    file.json["skins"][0]["joints"] = json!([a, b, a]);
    assert!(file.reason().contains("inverse bind"));
}

#[test]
fn morph_targets_use_default_weights() {
    let mut file = File::triangle();
    let up = file.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let right = file.floats("VEC3", &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": up }, { "POSITION": right }]);
    assert_eq!(first(&file.load()).positions[0], Vec3::ZERO);
    file.json["meshes"][0]["weights"] = json!([0.5, 2]);
    let scene = file.load();
    assert_eq!(first(&scene).positions[0], Vec3::new(2., 0., 0.5));
    assert!(noted(&scene, &["tri", "morph"]));
    file.json["nodes"][0]["weights"] = json!([3, 0]);
    assert_eq!(first(&file.load()).positions[0], Vec3::new(0., 0., 3.));
}

#[test]
fn unknown_attributes_and_bounds_do_no_harm() {
    let mut file = File::triangle();
    file.attribute("_CUSTOM", 0);
    file.attribute("ODD", 0);
    file.json["accessors"][0]["min"] = json!([0, 0]);
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 1);
    assert!(noted(&scene, &["meshes[0].primitives[0]", "name"]));
}
