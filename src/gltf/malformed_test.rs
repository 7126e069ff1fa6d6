//! Broken files: an error that says what.

use serde_json::{Value, json};

use super::error::GltfError;
use super::fuzz_test::{load, rich};
use super::test_file::{F32, File, U8, U16, f32_bytes, glb_of, u16_bytes};

#[test]
fn headers_that_lie() {
    let glb = rich().glb();
    for (at, value) in [(4, 1), (4, 3), (8, 0), (8, 11), (8, 13), (8, u32::MAX)] {
        let mut bytes = glb.clone();
        bytes[at..at + 4].copy_from_slice(&u32::to_le_bytes(value));
        assert!(load(&bytes).is_err(), "{at} {value}");
    }
    for value in [0, 1, 1 << 20, u32::MAX - 3, u32::MAX] {
        let mut bytes = glb.clone();
        bytes[12..16].copy_from_slice(&u32::to_le_bytes(value));
        assert!(load(&bytes).is_err(), "{value}");
    }
    assert!(load(b"").is_err());
    assert!(load(b"PK\x03\x04").is_err());
    assert!(load(b"[]").is_err());
    assert!(load(&glb_of(b"{}  ", &[])).is_err());
    let deep = [vec![b'['; 100_000], vec![b']'; 100_000]].concat();
    assert!(load(&deep).is_err());
}

#[test]
fn unsupported_extensions_are_named() {
    for name in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "EXT_mesh_gpu_instancing",
        "ACME_anything",
    ] {
        let mut file = rich();
        file.json["extensionsRequired"] = json!(["KHR_texture_transform", name]);
        let Err(GltfError::UnsupportedExtension { extension, .. }) = file.try_load() else {
            panic!("{name}")
        };
        assert_eq!(extension, name);
        // Used, but not required: no obstacle.
        file.json["extensionsUsed"] = json!([name]);
        file.json
            .as_object_mut()
            .unwrap()
            .remove("extensionsRequired");
        assert!(file.try_load().is_ok());
    }
    let mut file = rich();
    file.json["extensionsRequired"] = json!([
        "KHR_mesh_quantization",
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_texture_transform",
        "KHR_materials_unlit",
        "KHR_materials_clearcoat",
        "KHR_materials_sheen",
        "KHR_materials_specular",
        "KHR_materials_ior",
        "KHR_materials_iridescence",
        "KHR_materials_anisotropy",
        "KHR_materials_variants",
        "KHR_animation_pointer",
        "KHR_xmp_json_ld"
    ]);
    assert!(file.try_load().is_ok());
}

#[test]
fn compressed_without_a_copy() {
    let mut file = File::triangle();
    file.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    file.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    assert!(file.reason().contains("uncompressed"));
}

/// Changes a member of the plain triangle and says what the error must contain.
fn assert_reason(change: impl Fn(&mut Value), words: &str) {
    let mut file = File::triangle();
    let indices = file.accessor(U8, "SCALAR", 3, &[0, 1, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    change(&mut file.json);
    let reason = file.reason();
    assert!(reason.contains(words), "{reason} / {words}");
}

#[test]
fn wild_indices() {
    let beyond = "does not exist";
    for wild in [
        json!(99),
        json!(4_294_967_295_u64),
        json!(4_294_967_296_u64),
    ] {
        assert_reason(|j| j["scene"] = wild.clone(), "scene");
        assert_reason(|j| j["scenes"][0]["nodes"][0] = wild.clone(), beyond);
        assert_reason(|j| j["nodes"][0]["mesh"] = wild.clone(), beyond);
        assert_reason(|j| j["nodes"][0]["children"] = json!([wild]), beyond);
        assert_reason(|j| j["nodes"][0]["skin"] = wild.clone(), beyond);
        assert_reason(|j| j["nodes"][0]["camera"] = wild.clone(), beyond);
        assert_reason(|j| j["accessors"][0]["bufferView"] = wild.clone(), beyond);
        assert_reason(|j| j["bufferViews"][0]["buffer"] = wild.clone(), beyond);
        assert_reason(
            |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = wild.clone(),
            beyond,
        );
        assert_reason(
            |j| j["meshes"][0]["primitives"][0]["indices"] = wild.clone(),
            beyond,
        );
        assert_reason(
            |j| j["meshes"][0]["primitives"][0]["material"] = wild.clone(),
            beyond,
        );
    }
}

#[test]
fn accessors_that_reach_too_far() {
    let accessor = |key: &'static str, value: Value, words: &str| {
        assert_reason(|j| j["accessors"][0][key] = value.clone(), words);
    };
    accessor("count", json!(4), "accessors[0] says 4 elements");
    accessor("count", json!(u64::MAX), "elements");
    accessor("count", json!(u64::MAX / 12), "elements");
    accessor("byteOffset", json!(4), "from byte 4");
    accessor("byteOffset", json!(u64::MAX), "elements");
    accessor("type", json!("VEC4"), "not of type VEC3");
    accessor("type", json!("VEC9"), "accessors[0].type");
    accessor("componentType", json!(5124), "accessors[0].componentType");
    let view = |key: &'static str, value: Value, words: &str| {
        assert_reason(|j| j["bufferViews"][0][key] = value.clone(), words);
    };
    view("byteLength", json!(35), "accessors[0]");
    view("byteLength", json!(1000), "bufferViews[0]");
    view("byteOffset", json!(u64::MAX), "bufferViews[0]");
    view("byteStride", json!(0), "byteStride");
    view("byteStride", json!(3), "byteStride");
    view("byteStride", json!(8), "byteStride");
    view("byteStride", json!(16), "accessors[0]");
    view("byteStride", json!(100_000), "byteStride");
    assert_reason(
        |j| j["buffers"][0]["byteLength"] = json!(1_000_000),
        "buffers[0]",
    );
    // A billion zeros from a file of a few bytes.
    assert_reason(
        |j| {
            j["accessors"][0] = json!({ "count": 1_000_000_000, "type": "VEC3",
                "componentType": F32 });
        },
        "without saying where",
    );
}

#[test]
fn attributes_of_different_lengths() {
    for (name, ty, width) in [
        ("NORMAL", "VEC3", 3),
        ("TEXCOORD_0", "VEC2", 2),
        ("COLOR_0", "VEC4", 4),
    ] {
        let mut file = File::triangle();
        let accessor = file.floats(ty, &vec![0.5; 2 * width]);
        file.attribute(name, accessor);
        assert!(file.reason().contains("has 3 positions but 2"), "{name}");
    }
}

#[test]
fn indices_beyond_the_vertices() {
    let mut file = File::triangle();
    let indices = file.accessor(U8, "SCALAR", 3, &[0, 1, 3]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(
        file.reason()
            .contains("meshes[0].primitives[0] has index 3, but only 3 vertices")
    );
}

#[test]
fn sparse_with_bad_indices() {
    for (indices, words) in [
        ([1, 3], "index 3"),
        ([2, 1], "increase"),
        ([1, 1], "increase"),
    ] {
        let mut file = File::triangle();
        let at = file.view(&u16_bytes(&indices));
        let values = file.view(&f32_bytes(&[0.; 6]));
        file.json["accessors"][0]["sparse"] = json!({
            "count": 2, "indices": { "bufferView": at, "componentType": U16 },
            "values": { "bufferView": values }
        });
        assert!(file.reason().contains(words));
        file.json["accessors"][0]["sparse"]["count"] = json!(u64::MAX);
        assert!(file.reason().contains("sparse"));
    }
}

#[test]
fn cycles_and_shared_children() {
    assert_reason(|j| j["nodes"][0]["children"] = json!([0]), "ancestors");
    assert_reason(
        |j| {
            j["nodes"] = json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }]);
        },
        "ancestors",
    );
    assert_reason(
        |j| j["nodes"] = json!([{ "children": [2] }, { "children": [2] }, {}]),
        "nodes[2] has two parents, nodes[0] and nodes[1]",
    );
    assert_reason(
        |j| j["nodes"] = json!([{ "children": [1, 1] }, {}]),
        "two parents",
    );
}

#[test]
fn deep_trees_are_no_problem() {
    let mut file = File::triangle();
    for node in 0..50_000 {
        file.json["nodes"][node]["children"] = json!([node + 1]);
        file.push("nodes", json!({}));
    }
    assert_eq!(load(&file.glb()).unwrap().scene.objects.len(), 1);
}

#[test]
fn numbers_that_are_none() {
    let mut file = File::triangle();
    file.bin[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(file.reason().contains("vertex 0"));
    let mut file = File::triangle();
    file.json["nodes"][0]["scale"] = json!([3e38, 1, 1]);
    file.json["scenes"][0]["nodes"] = json!([1]);
    file.push("nodes", json!({ "children": [0], "scale": [3e38, 1, 1] }));
    assert!(file.reason().contains("tri"));
    file.json["nodes"][0]["scale"] = json!([1e300, 1, 1]);
    assert!(file.reason().contains("out of range"));
    assert!(load(br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[NaN,1,1]}]}"#).is_err());
    assert!(load(br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[1e999,1,1]}]}"#).is_err());
}

#[test]
fn versions() {
    assert_reason(
        |j| j["asset"] = json!({ "version": "1.0" }),
        "asset.version is 1.0",
    );
    assert_reason(|j| j["asset"] = json!({}), "asset.version");
    assert_reason(
        |j| j["asset"] = json!({ "version": "2.1", "minVersion": "2.1" }),
        "asset.minVersion",
    );
}
