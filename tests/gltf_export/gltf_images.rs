//! Image files go into the output.

use std::fs;

use serde_json::json;

use crate::build::*;

#[test]
fn image_files_are_embedded() {
    let folder = tempfile::tempdir().unwrap();
    let png = b"\x89PNG\r\n\x1a\nrest";
    let jpeg = b"\xff\xd8\xffrest";
    fs::create_dir(folder.path().join("t")).unwrap();
    fs::write(folder.path().join("t/a b.png"), png).unwrap();
    fs::write(folder.path().join("c.jpg"), jpeg).unwrap();
    fs::write(folder.path().join("d.txt"), "no image").unwrap();
    let mut document = triangle(|_| json!({}));
    document.path = folder.path().join("scene.gltf");
    let data = json!({"uri": "data:image/png;base64,AAAA"});
    let web = json!({"uri": "https://example.org/a.png"});
    document.json["images"] = json!([
        {"uri": "t/a%20b.png", "name": "first", "extras": 1},
        {"uri": "c.jpg", "mimeType": "image/png"},
        {"uri": "t/a%20b.png"},
        {"uri": "missing.png"},
        {"uri": "d.txt"},
        data,
        web,
    ]);
    let output = export(&document, &[baked(key(0, 0, 0), &light(3))]);
    let image = |index: usize| &output.json["images"][index];
    assert_eq!(image(0)["mimeType"], "image/png");
    assert_eq!(
        (&image(0)["name"], image(0).get("uri")),
        (&json!("first"), None)
    );
    assert_eq!(image(1)["mimeType"], "image/jpeg");
    assert_eq!(image(2)["bufferView"], image(0)["bufferView"]);
    assert_eq!(image(3), &json!({"uri": "missing.png"}));
    assert_eq!(image(4), &json!({"uri": "d.txt"}));
    assert_eq!((image(5), image(6)), (&data, &web));
    let view = &output.json["bufferViews"][image(0)["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(view["byteLength"], png.len());
    assert_eq!(&output.bin[start..start + png.len()], png);
    assert_eq!(output.notes.len(), 3);
    for (note, name) in output
        .notes
        .iter()
        .zip(["missing.png", "d.txt", "example.org"])
    {
        assert!(note.contains(name), "{note}");
    }
}
