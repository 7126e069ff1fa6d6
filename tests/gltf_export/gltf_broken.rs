//! Whatever stands in a document, the exporter answers with a file or an error.

use bevy_fresco::gltf::{Document, ExportOptions, to_glb};
use serde_json::{Value, json};

use crate::build::*;

fn rich() -> Document {
    let mut document = triangle(|b| {
        let joints = b.raw("VEC4", 5121, false, 3, &[0; 12]);
        let weights = b.floats("VEC4", &[0.25; 12]);
        let colors = b.floats("VEC4", &[0.25; 12]);
        let light = b.floats("VEC3", &[0.5; 9]);
        let normals = b.floats("VEC3", &[0.5; 9]);
        json!({"JOINTS_0": joints, "WEIGHTS_0": weights, "COLOR_0": colors,
               "_BAKED_LIGHT": light, "NORMAL": normals})
    });
    document.json["nodes"] = json!([{"mesh": 0, "extras": 1}, {"mesh": 0}]);
    document.json["images"] = json!([{"uri": "missing.png"}]);
    document.json["extensionsUsed"] = json!([]);
    document.json["materials"] = json!([
        {"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]},
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}}]);
    let primitive = &mut document.json["meshes"][0]["primitives"][0];
    let variants = json!({"mappings": [{"material": 0, "variants": [0]}]});
    primitive["extensions"] = json!({"KHR_materials_variants": variants});
    primitive["material"] = 0.into();
    primitive["mode"] = 4.into();
    primitive["targets"] = json!([{"POSITION": primitive["attributes"]["POSITION"]}]);
    document.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": 1, "byteOffset": 0, "componentType": 5121},
        "values": {"bufferView": 0, "byteOffset": 0}});
    document
}

/// The pointers of all values in a document.
fn pointers(json: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match json {
        Value::Array(list) => {
            for (index, item) in list.iter().enumerate() {
                pointers(item, &format!("{at}/{index}"), all);
            }
        }
        Value::Object(map) => {
            for (key, item) in map {
                pointers(item, &format!("{at}/{key}"), all);
            }
        }
        _ => {}
    }
}

#[test]
fn no_value_makes_the_exporter_panic() {
    let good = rich();
    let (plain, refined) = (light(3), refined_light(split_in_four(0)));
    let mut all = Vec::new();
    pointers(&good.json, "", &mut all);
    let (mut written, mut refused) = (0, 0);
    let bad = [
        json!(null),
        json!(-1),
        json!(1),
        json!(1e300),
        json!(u64::MAX),
        json!("x"),
        json!([]),
        json!({}),
        json!([[], 1]),
    ];
    for pointer in &all {
        for bad in &bad {
            let mut document = good.clone();
            *document.json.pointer_mut(pointer).unwrap() = bad.clone();
            for options in [ExportOptions::default(), colors(0.5)] {
                for light in [&plain, &refined] {
                    let baked = [0, 1].map(|node| baked(key(node, 0, 0), light));
                    match to_glb(&document, &baked, &[0, 1], &options) {
                        Ok(_) => written += 1,
                        Err(_) => refused += 1,
                    }
                }
            }
        }
    }
    assert!(written > 100 && refused > 100, "{written} {refused}");
}
