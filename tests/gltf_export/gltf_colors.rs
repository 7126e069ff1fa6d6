//! Light as vertex colours on unlit materials.

use bevy_fresco::{gltf::Document, radiosity::ObjectLight};
use glam::Vec3;
use serde_json::{Value, json};

use crate::build::*;

const UNLIT: &str = "KHR_materials_unlit";

fn with_material(material: Value, add: impl FnOnce(&mut Builder) -> Value) -> Document {
    let mut document = triangle(add);
    document.json["materials"] = json!([material]);
    document.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    document
}

fn painted(document: &Document, light: &ObjectLight, exposure: f32) -> Output {
    try_export(document, &[baked(key(0, 0, 0), light)], &colors(exposure)).unwrap()
}

fn even(light: [f32; 3]) -> ObjectLight {
    ObjectLight {
        mesh: None,
        light: vec![light.into(); 3],
        gradient: Vec::new(),
        quality: Vec::new(),
    }
}

#[test]
fn light_becomes_colors() {
    let document = with_material(
        json!({"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}),
        |b| json!({"_BAKED_LIGHT": b.floats("VEC3", &[1.0; 9])}),
    );
    let output = painted(&document, &even([1.0, 2.0, 4.0]), 0.25);
    assert_eq!(output.attribute(0, "COLOR_0")[..3], [0.25, 0.5, 1.0]);
    let attributes = &output.primitive(0, 0)["attributes"];
    assert_eq!(output.accessor(&attributes["COLOR_0"])["type"], "VEC3");
    assert_eq!(attributes.get("_BAKED_LIGHT"), None);
    let mut expected = document.json["materials"][0].clone();
    expected["extensions"] = json!({UNLIT: {}});
    assert_eq!(output.json["materials"], json!([expected]));
    assert_eq!(output.json["extensionsUsed"], json!([UNLIT]));
    assert!(output.notes.is_empty());
}

#[test]
fn old_colors_multiply_and_alpha_stays() {
    let document = with_material(json!({}), |b| {
        let color = b.raw("VEC4", 5121, true, 3, &[255, 51, 0, 102].repeat(3));
        json!({"COLOR_0": color})
    });
    let output = painted(&document, &even([0.5; 3]), 1.0);
    assert_eq!(output.attribute(0, "COLOR_0")[..4], [0.5, 0.1, 0.0, 0.4]);
    // The same through a refined mesh.
    let mut light = refined_light(split_in_four(0));
    light.light.fill(Vec3::splat(0.5));
    let output = painted(&document, &light, 1.0);
    assert_eq!(output.attribute(0, "COLOR_0").len(), 24);
    assert_eq!(output.attribute(0, "COLOR_0")[12..16], [0.5, 0.1, 0.0, 0.4]);
}

#[test]
fn what_is_too_bright_is_cut_off_and_counted() {
    let document = with_material(json!({}), |_| json!({}));
    let mut light = even([0.5; 3]);
    light.light[1].y = 3.0;
    light.light[2].x = -1.0;
    let output = painted(&document, &light, 1.0);
    let colors = output.attribute(0, "COLOR_0");
    assert_eq!(colors[3..], [0.5, 1.0, 0.5, 0.0, 0.5, 0.5]);
    assert!(
        output.notes[0].starts_with("1 of 3 vertices"),
        "{:?}",
        output.notes
    );
}

#[test]
fn materials_of_unbaked_primitives_stay() {
    let mut document = with_material(json!({"name": "m"}), |_| json!({}));
    document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
    document.json["scenes"][0]["nodes"] = json!([0, 1]);
    let output = painted(&document, &even([0.5; 3]), 1.0);
    assert_eq!(output.json["materials"][0], json!({"name": "m"}));
    assert_eq!(
        output.json["materials"][1],
        json!({"name": "m_baked", "extensions": {UNLIT: {}}})
    );
    assert_eq!(output.primitive(0, 0)["material"], 0);
    assert_eq!(output.primitive(1, 0)["material"], 1);
}

#[test]
fn primitives_without_a_material_get_an_unlit_one() {
    let document = triangle(|_| json!({}));
    let output = painted(&document, &even([0.5; 3]), 1.0);
    assert_eq!(
        output.json["materials"],
        json!([{"extensions": {UNLIT: {}}}])
    );
    assert_eq!(output.primitive(0, 0)["material"], 0);
}

#[test]
fn unlit_materials_are_left_alone() {
    let document = with_material(json!({"extensions": {UNLIT: {}}}), |_| json!({}));
    let output = painted(&document, &even([0.5; 3]), 1.0);
    assert_eq!(output.json["meshes"], document.json["meshes"]);
    assert_eq!(output.json["materials"], document.json["materials"]);
}

#[test]
fn emission_goes_into_the_colors() {
    let document = with_material(
        json!({
            "emissiveFactor": [1, 0.5, 0],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}},
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.25, 0.75]},
        }),
        |_| json!({}),
    );
    let output = painted(&document, &even([1.0; 3]), 0.25);
    assert_eq!(output.attribute(0, "COLOR_0")[..3], [0.625, 0.375, 0.0625]);
    let factor = &output.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
    assert_eq!(factor, &json!([1, 1, 1, 0.75]));
    assert!(output.notes.is_empty());
}

#[test]
fn emission_with_textures_gets_a_note() {
    let material = json!({"name": "lamp", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness":
        {"baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}}});
    let mut document = with_material(material.clone(), |_| json!({}));
    document.json["textures"] = json!([{"source": 0}]);
    document.json["images"] = json!([{"uri": "data:image/png;base64,AAAA"}]);
    let output = painted(&document, &even([0.5; 3]), 1.0);
    assert_eq!(output.attribute(0, "COLOR_0")[..3], [0.5, 0.5, 0.5]);
    assert_eq!(
        output.json["materials"][0]["pbrMetallicRoughness"],
        material["pbrMetallicRoughness"]
    );
    assert!(output.notes[0].contains("lamp"));
}

#[test]
fn variants_become_unlit_too() {
    let mut document = with_material(json!({"name": "a"}), |_| json!({}));
    document.json["materials"] = json!([{"name": "a"}, {"name": "b"}]);
    document.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    document.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_materials_variants": {"mappings": [
            {"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]}});
    let output = painted(&document, &even([0.5; 3]), 1.0);
    for material in [0, 1] {
        assert_eq!(
            output.json["materials"][material]["extensions"],
            json!({UNLIT: {}})
        );
    }
    assert_eq!(
        output.primitive(0, 0)["extensions"],
        document.json["meshes"][0]["primitives"][0]["extensions"]
    );
}

#[test]
fn the_exposure_must_be_positive() {
    let document = triangle(|_| json!({}));
    let light = even([0.5; 3]);
    for exposure in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let baked = [baked(key(0, 0, 0), &light)];
        assert!(try_export(&document, &baked, &colors(exposure)).is_err());
    }
}
