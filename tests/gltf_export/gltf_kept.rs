//! What the exporter does not know goes through as it came.

use bevy_fresco::{
    gltf::{Document, ExportOptions, to_glb},
    radiosity::DirectLight,
};
use serde_json::{Value, json};

use crate::build::*;

#[test]
fn unknown_things_survive() {
    let mut builder = Builder::new();
    let position = builder.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let times = builder.floats("SCALAR", &[0.0]);
    builder.json["accessors"][times]["min"] = json!([0.0]);
    builder.json["accessors"][times]["max"] = json!([0.0]);
    let moves = builder.floats("VEC3", &[1.0, 2.0, 3.0]);
    builder.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": position}, "extras": {"p": [1]}}]}),
    );
    builder.json["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    }]);
    builder.json["cameras"] = json!([{"type": "perspective", "perspective":
        {"yfov": 0.1234567890123456, "znear": 1e-3, "extras": {"z": null}}}]);
    builder.json["extensionsUsed"] = json!(["ACME_thing"]);
    builder.json["extensions"] =
        json!({"ACME_thing": {"bufferView": 2, "big": 9007199254740993u64}});
    builder.json["nodes"][0]["extensions"] = json!({"ACME_thing": {"b": 1, "a": 2}});
    builder.json["extras"] = json!("text");
    let document = builder.document();
    let light = light(3);
    let mut output = export(&document, &[baked(key(0, 0, 0), &light)]).json;

    let mut expected = document.json.clone();
    // Only these differ: lists that grew, the buffer, the new attribute and the mark.
    for list in ["accessors", "bufferViews"] {
        let count = expected[list].as_array().unwrap().len();
        let list = output[list].as_array_mut().unwrap();
        assert_eq!(list.len(), count + 1);
        list.truncate(count);
    }
    expected["buffers"] = output["buffers"].clone();
    let primitive = &mut output["meshes"][0]["primitives"][0];
    let attributes = primitive["attributes"].as_object_mut().unwrap();
    attributes.shift_remove("_BAKED_LIGHT").unwrap();
    let asset = output["asset"].as_object_mut().unwrap();
    asset.shift_remove("extras").unwrap();
    assert_eq!(output, expected);
    // The order of keys too.
    assert_eq!(output.to_string(), expected.to_string());
}

#[test]
fn buffers_are_joined() {
    let mut document = triangle(|b| {
        let texcoord = b.floats("VEC2", &[0.0, 0.25, 0.5, 0.75, 1.0, 1.25]);
        json!({"TEXCOORD_0": texcoord})
    });
    // The second attribute moves to a buffer of its own; the first buffer has an odd length.
    let second = document.buffers[0].split_off(36);
    document.buffers[0].extend([7, 7, 7, 7, 7]);
    document.buffers.push(second);
    document.json["buffers"] = json!([
        {"uri": "a.bin", "byteLength": 37, "name": "first"},
        {"uri": "data:application/octet-stream;base64,", "byteLength": 24},
    ]);
    document.json["bufferViews"][1] = json!({"buffer": 1, "byteLength": 24});
    let output = export(&document, &[baked(key(0, 0, 0), &light(3))]);
    assert_eq!(output.json["bufferViews"][1]["byteOffset"], 40);
    assert_eq!(output.json["buffers"][0]["name"], "first");
    assert_eq!(output.json["buffers"][0].get("uri"), None);
    assert_eq!(
        output.attribute(0, "TEXCOORD_0"),
        [0.0, 0.25, 0.5, 0.75, 1.0, 1.25]
    );
}

fn marked(document: &Document, direct: DirectLight, options: ExportOptions) -> Value {
    let options = ExportOptions { direct, ..options };
    let light = light(3);
    let baked = [baked(key(0, 0, 0), &light)];
    Output::new(to_glb(document, &baked, &[0], &options).unwrap()).json
}

#[test]
fn lights_and_asset_are_marked() {
    let mut document = triangle(|_| json!({}));
    document.json["asset"]["extras"] = json!({"author": "me", "fresco": {"exposure": 3}});
    document.json["nodes"][0]["extras"] = json!([1, 2]);
    let output = marked(&document, DirectLight::Baked, ExportOptions::default());
    assert_eq!(
        output["nodes"][0]["extras"],
        json!({"fresco_previous_extras": [1, 2], "fresco": {"direct": "baked"}})
    );
    assert_eq!(output["asset"]["generator"], "test");
    assert_eq!(
        output["asset"]["extras"],
        json!({"author": "me", "fresco": {
            "baked_light": "irradiance_over_pi",
            "version": env!("CARGO_PKG_VERSION"),
            "direct": "baked",
            "encoding": "attribute",
        }})
    );
    let output = marked(&document, DirectLight::Realtime, colors(0.5));
    assert_eq!(output["nodes"][0]["extras"]["fresco"]["direct"], "realtime");
    assert_eq!(
        output["asset"]["extras"]["fresco"]["encoding"],
        "vertex_colors"
    );
    assert_eq!(output["asset"]["extras"]["fresco"]["exposure"], 0.5);
    assert!(to_glb(&document, &[], &[1], &ExportOptions::default()).is_err());
}
