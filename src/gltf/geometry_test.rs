//! Accessors, primitives and morph targets.

use glam::{DVec3, Vec2, Vec3, Vec4};
use serde_json::json;

use super::test_file::{
    F32, File, I8, I16, U8, U16, U32, f32_bytes, face_normal, first, near, noted, u16_bytes,
};

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];

fn square(mode: u32) -> File {
    let mut file = File::new();
    let positions = file.floats("VEC3", &SQUARE);
    file.mesh(json!({ "attributes": { "POSITION": positions }, "mode": mode }));
    file.root_node(json!({ "mesh": 0 }));
    file
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
