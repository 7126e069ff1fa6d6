//! Where bytes come from: GLB chunks, files, data URIs; and what the document keeps.

use std::path::Path;

use serde_json::json;

use super::error::GltfError;
use super::import::{import, load};
use super::test_file::{File, data_uri, glb_of, png};
use crate::radiosity::Scene;

/// A triangle with an image.
fn sample() -> File {
    let mut file = File::triangle();
    let uv = file.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    file.attribute("TEXCOORD_0", uv);
    file.texture(&[[1, 2, 3, 4]]);
    file.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    file
}

fn assert_same(a: &Scene, b: &Scene) {
    assert_eq!(a.objects[0].positions, b.objects[0].positions);
    assert_eq!(a.objects[0].uvs, b.objects[0].uvs);
    assert_eq!(a.textures[0].texels, b.textures[0].texels);
}

#[test]
fn all_containers_give_the_same_scene() {
    let file = sample();
    let glb = file.load();
    assert_eq!(glb.scene.textures[0].texels, [[1, 2, 3, 4]]);
    let folder = tempfile::tempdir().unwrap();
    let embedded = folder.path().join("embedded.gltf");
    std::fs::write(&embedded, file.gltf_embedded()).unwrap();
    let embedded = load(&embedded).unwrap();
    assert_same(&glb.scene, &embedded.scene);

    // External, in a folder and with characters that need encoding.
    std::fs::create_dir(folder.path().join("my data")).unwrap();
    std::fs::write(folder.path().join("my data/größe 1.bin"), &file.bin).unwrap();
    std::fs::write(folder.path().join("my data/100%.png"), png(&[[1, 2, 3, 4]])).unwrap();
    let mut external = file.clone();
    external.json["images"][0] = json!({ "uri": "my%20data/100%25.png" });
    let path = folder.path().join("external.gltf");
    std::fs::write(&path, external.gltf("my%20data/gr%C3%B6%C3%9Fe%201.bin")).unwrap();
    let external_scene = load(&path).unwrap();
    assert_same(&glb.scene, &external_scene.scene);
    // The same without any encoding, which is not allowed but common.
    external.json["images"][0] = json!({ "uri": "my data/100%.png" });
    std::fs::write(&path, external.gltf("my data/größe 1.bin")).unwrap();
    assert_same(&glb.scene, &load(&path).unwrap().scene);
}

#[test]
fn the_document_is_kept() {
    let mut file = sample();
    file.json["extras"] = json!({ "z": 1, "a": [0.1, 1e-7, 123_456_789.123_456_79], "n": null });
    file.json["nodes"][0]["extensions"] = json!({ "EXT_unheard_of": { "x": [1, 2.5] } });
    let scene = file.load();
    assert_eq!(scene.document.json, file.json);
    // Members in their order, too.
    assert_eq!(scene.document.json.to_string(), file.json.to_string());
    assert_eq!(scene.document.buffers.len(), 1);
    assert_eq!(&scene.document.buffers[0][..file.bin.len()], &file.bin[..]);
    assert_eq!(scene.document.path, Path::new("test.glb"));
}

#[test]
fn data_uris() {
    let file = File::triangle();
    let plain = data_uri("application/octet-stream", &file.bin);
    let unpadded = plain.trim_end_matches('=').to_owned();
    let encoded = plain
        .replace('+', "%2B")
        .replace('/', "%2F")
        .replace('=', "%3D");
    let encoded = encoded.replace("application%2Foctet-stream", "application/gltf-buffer");
    for uri in [plain, unpadded, encoded] {
        let scene = import(Path::new("x.gltf"), &file.gltf(&uri)).unwrap();
        assert_eq!(scene.document.buffers[0], file.bin);
    }
    // Not base64: percent-encoded bytes.
    let percent: String = file.bin.iter().map(|b| format!("%{b:02x}")).collect();
    let uri = format!("data:application/octet-stream,{percent}");
    let scene = import(Path::new("x.gltf"), &file.gltf(&uri)).unwrap();
    assert_eq!(scene.document.buffers[0], file.bin);
}

#[test]
fn byte_order_mark_and_unknown_chunks() {
    let file = File::triangle();
    let mut text = b"\xEF\xBB\xBF".to_vec();
    text.extend(file.gltf_embedded());
    assert!(import(Path::new("x.gltf"), &text).is_ok());
    // A chunk of a kind to come, after the known ones.
    let mut glb = file.glb();
    glb.extend(4_u32.to_le_bytes());
    glb.extend(b"NEW!data");
    let length = glb.len() as u32;
    glb[8..12].copy_from_slice(&length.to_le_bytes());
    assert!(import(Path::new("x.glb"), &glb).is_ok());
}

#[test]
fn missing_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let Err(GltfError::Read { path: named, .. }) = load(&path) else {
        panic!()
    };
    assert_eq!(named, path);
    std::fs::write(&path, File::triangle().gltf("gone%20away.bin")).unwrap();
    let Err(GltfError::Read { path: named, .. }) = load(&path) else {
        panic!()
    };
    assert!(named.ends_with("gone away.bin"));
    for uri in ["", ".", "/dev/zero"] {
        std::fs::write(&path, File::triangle().gltf(uri)).unwrap();
        assert!(matches!(load(&path), Err(GltfError::Read { .. })), "{uri}");
    }
}

#[test]
fn bad_buffers_are_named() {
    let file = File::triangle();
    let reason = |uri: &str| match import(Path::new("x.gltf"), &file.gltf(uri)) {
        Err(GltfError::Invalid { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    let short = data_uri("application/octet-stream", &file.bin[..8]);
    assert!(reason(&short).contains("buffers[0] has 8 bytes where byteLength says 36"));
    assert!(reason("https://example.com/a.bin").contains("https://example.com/a.bin"));
    assert!(reason("data:;base64,@@@@").contains("base64"));
    assert!(reason("data:application/octet-stream").contains("comma"));
    let text = serde_json::to_vec(&file.json).unwrap();
    let Err(GltfError::Invalid { reason, .. }) = import(Path::new("x.gltf"), &text) else {
        panic!()
    };
    assert!(reason.contains("buffers[0] has no uri"));
    let Err(GltfError::Invalid { reason, .. }) = import(Path::new("x.glb"), &glb_of(&text, &[]))
    else {
        panic!()
    };
    assert!(reason.contains("0 bytes"));
}
