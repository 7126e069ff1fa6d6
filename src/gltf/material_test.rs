//! Materials, textures and their transforms.

use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use super::import::GltfScene;
use super::test_file::{File, data_uri, encode, noted, png};
use crate::radiosity::{AlphaMode, Material, Wrap};

const RED_GREEN: [[u8; 4]; 2] = [[255, 0, 0, 255], [0, 255, 0, 128]];

fn first(scene: &GltfScene) -> &Material {
    let object = &scene.scene.objects[0];
    &scene.scene.materials[object.material.0 as usize]
}

/// A triangle with texture coordinates, one texture, and a material.
fn textured(material: Value) -> File {
    let mut file = File::triangle();
    let uv = file.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    file.attribute("TEXCOORD_0", uv);
    file.texture(&RED_GREEN);
    file.material(material);
    file
}

#[test]
fn factors_and_defaults() {
    let mut file = File::triangle();
    file.material(json!({}));
    let scene = file.load();
    let material = first(&scene);
    assert_eq!(material.base_color, Vec4::ONE);
    assert_eq!(material.metallic, 1.0);
    assert_eq!(material.alpha, AlphaMode::Opaque);
    assert!(!material.double_sided && !material.unlit);
    assert_eq!(material.name, "material 0");

    let mut file = File::triangle();
    file.material(json!({
        "name": "paint", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5 },
        "emissiveFactor": [1, 0.5, 0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } }
    }));
    let scene = file.load();
    let material = first(&scene);
    assert_eq!(material.name, "paint");
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(material.metallic, 0.5);
    assert_eq!(material.emissive, Vec3::new(8., 4., 0.));
    assert_eq!(material.alpha, AlphaMode::Mask(0.25));
    assert!(material.double_sided);

    file.json["materials"][0]["alphaMode"] = json!("BLEND");
    assert_eq!(first(&file.load()).alpha, AlphaMode::Blend);
    file.json["materials"][0]["alphaMode"] = json!("MASK");
    file.json["materials"][0]
        .as_object_mut()
        .unwrap()
        .remove("alphaCutoff");
    assert_eq!(first(&file.load()).alpha, AlphaMode::Mask(0.5));
}

#[test]
fn textures_of_all_slots() {
    let slot = json!({ "index": 0 });
    let file = textured(json!({
        "pbrMetallicRoughness": { "baseColorTexture": slot, "metallicRoughnessTexture": slot },
        "emissiveTexture": slot, "emissiveFactor": [1, 1, 1]
    }));
    let scene = file.load();
    let material = first(&scene);
    assert!(material.base_color_texture.is_some());
    assert!(material.metallic_texture.is_some());
    assert!(material.emissive_texture.is_some());
    // One image, used three times.
    assert_eq!(scene.scene.textures.len(), 1);
    let texture = &scene.scene.textures[0];
    assert_eq!((texture.width, texture.height), (2, 1));
    assert_eq!(texture.texels, RED_GREEN);
    assert_eq!(texture.wrap, [Wrap::Repeat; 2]);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn textures_without_effect_are_not_decoded() {
    let slot = json!({ "index": 0 });
    let mut file = textured(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "metallicRoughnessTexture": slot },
        "emissiveTexture": slot, "normalTexture": slot, "occlusionTexture": slot
    }));
    assert!(file.load().scene.textures.is_empty());
    // Nor are those of materials that nothing wears.
    file.push(
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }),
    );
    let scene = file.load();
    assert!(scene.scene.textures.is_empty());
    assert_eq!(scene.scene.materials.len(), 1);
}

#[test]
fn unlit_materials_only_have_their_base() {
    let file = textured(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "emissiveFactor": [1, 1, 1],
        "extensions": { "KHR_materials_unlit": {} }
    }));
    let scene = file.load();
    let material = first(&scene);
    assert!(material.unlit && material.base_color_texture.is_some());
    assert_eq!((material.metallic, material.emissive), (0.0, Vec3::ZERO));
}

#[test]
fn specular_glossiness_gives_its_diffuse_part() {
    let file = textured(json!({
        "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 1, 1], "diffuseTexture": { "index": 0 }
        } }
    }));
    let scene = file.load();
    let material = first(&scene);
    assert_eq!(material.base_color, Vec4::new(0.5, 0.25, 1., 1.));
    assert_eq!(material.metallic, 0.0);
    assert!(material.base_color_texture.is_some());
}

#[test]
fn samplers_wrap() {
    let mut file = textured(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "emissiveTexture": { "index": 1 }, "emissiveFactor": [1, 1, 1]
    }));
    file.push("samplers", json!({ "wrapS": 33071, "wrapT": 33648 }));
    file.push("textures", json!({ "source": 0, "sampler": 0 }));
    let scene = file.load();
    assert_eq!(scene.scene.textures.len(), 2);
    let material = first(&scene);
    let wrap = |id: u32| scene.scene.textures[id as usize].wrap;
    assert_eq!(
        wrap(material.base_color_texture.unwrap().texture.0),
        [Wrap::Repeat; 2]
    );
    assert_eq!(
        wrap(material.emissive_texture.unwrap().texture.0),
        [Wrap::Clamp, Wrap::Mirror]
    );
    assert_eq!(
        scene.scene.textures[0].texels,
        scene.scene.textures[1].texels
    );
}

fn transform(extension: Value) -> glam::Affine2 {
    let slot = json!({ "index": 0, "extensions": { "KHR_texture_transform": extension } });
    let file = textured(json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }));
    first(&file.load()).base_color_texture.unwrap().transform
}

#[test]
fn texture_transforms_follow_the_extension() {
    assert_eq!(transform(json!({})), glam::Affine2::IDENTITY);
    let near = |a: Vec2, b: Vec2| assert!((a - b).length() < 1e-6, "{a} {b}");
    // The extension's first example: the lower left quadrant, turned clockwise.
    let quadrant = transform(json!({
        "offset": [0, 1], "rotation": FRAC_PI_2, "scale": [0.5, 0.5]
    }));
    near(quadrant.transform_point2(Vec2::ZERO), Vec2::new(0., 1.));
    near(quadrant.transform_point2(Vec2::X), Vec2::new(0., 0.5));
    near(quadrant.transform_point2(Vec2::Y), Vec2::new(0.5, 1.));
    near(quadrant.transform_point2(Vec2::ONE), Vec2::new(0.5, 0.5));
    // Its second: the origin at the bottom left.
    let flip = transform(json!({ "offset": [0, 1], "scale": [1, -1] }));
    near(
        flip.transform_point2(Vec2::new(0.25, 0.1)),
        Vec2::new(0.25, 0.9),
    );
    // Scale comes before rotation.
    let both = transform(json!({ "rotation": FRAC_PI_2, "scale": [2, 3] }));
    near(both.transform_point2(Vec2::X), Vec2::new(0., -2.));
    near(both.transform_point2(Vec2::Y), Vec2::new(3., 0.));
}

#[test]
fn texture_transform_overrides_the_uv_set() {
    let extension = json!({ "KHR_texture_transform": { "texCoord": 1 } });
    let slot = json!({ "index": 0, "texCoord": 0, "extensions": extension });
    let mut file = textured(json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }));
    let scene = file.load();
    assert!(first(&scene).base_color_texture.is_none());
    assert!(noted(&scene, &["material 0", "TEXCOORD_1"]));
    let uv = file.floats("VEC2", &[0.; 6]);
    file.attribute("TEXCOORD_1", uv);
    assert_eq!(first(&file.load()).base_color_texture.unwrap().uv_set, 1);
}

#[test]
fn one_material_on_meshes_with_and_without_uvs() {
    let slot = json!({ "index": 0 });
    let mut file = textured(json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }));
    let bare = json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(bare);
    let scene = file.load();
    let texture = |object: usize| {
        let id = scene.scene.objects[object].material;
        scene.scene.materials[id.0 as usize].base_color_texture
    };
    assert!(texture(0).is_some() && texture(1).is_none());
}

#[test]
fn unusable_images_are_noted() {
    let slot = json!({ "index": 0 });
    let file = textured(json!({ "name": "wood", "pbrMetallicRoughness":
        { "baseColorTexture": slot, "baseColorFactor": [0.5, 0.5, 0.5, 1] } }));
    let images = [
        json!({ "uri": "no/such%20file.png" }),
        json!({ "uri": data_uri("image/png", b"not an image") }),
        json!({ "uri": "https://example.com/a.png" }),
        json!({ "uri": "data:image/png;base64,%%%" }),
        json!({ "name": "hollow" }),
        json!({ "uri": data_uri("image/png", &png(&RED_GREEN)[..40]) }),
    ];
    for image in images {
        let mut file = file.clone();
        file.json["images"][0] = image.clone();
        let scene = file.load();
        assert!(first(&scene).base_color_texture.is_none());
        assert_eq!(first(&scene).base_color.x, 0.5);
        assert!(
            noted(&scene, &["cannot be used", "put a PNG"]),
            "{:?}",
            scene.notes
        );
        assert!(noted(&scene, &["wood", "base colour texture"]));
        assert!(scene.scene.textures.is_empty());
    }
    let mut file = file;
    file.json["textures"][0] = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let scene = file.load();
    assert!(noted(&scene, &["wood", "KHR_texture_basisu"]));
}

#[test]
fn images_of_other_depths_become_rgba8() {
    let grey16 = image::ImageBuffer::from_raw(2, 1, vec![0_u16, 65535]).unwrap();
    let bytes = encode(&image::DynamicImage::ImageLuma16(grey16));
    let slot = json!({ "index": 0 });
    let mut file = textured(json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }));
    // The type in the URI is wrong, the content is right.
    file.json["images"][0] = json!({ "uri": data_uri("image/jpeg", &bytes) });
    let scene = file.load();
    assert_eq!(
        scene.scene.textures[0].texels,
        [[0, 0, 0, 255], [255, 255, 255, 255]]
    );
}

#[test]
fn rows_come_from_the_top() {
    let raw = vec![255, 0, 0, 255, 0, 0, 255, 255];
    let image = image::RgbaImage::from_raw(1, 2, raw).unwrap();
    let slot = json!({ "index": 0 });
    let mut file = textured(json!({ "pbrMetallicRoughness": { "baseColorTexture": slot } }));
    file.json["images"][0] = json!({ "uri": data_uri("image/png", &encode(&image.into())) });
    assert_eq!(file.load().scene.textures[0].texels[0], [255, 0, 0, 255]);
}

#[test]
fn odd_factors_are_noted() {
    let mut file = File::triangle();
    file.material(json!({
        "name": "odd",
        "pbrMetallicRoughness": { "baseColorFactor": [2, -1, 0.5, 1], "metallicFactor": 0 },
        "emissiveFactor": [-1, 0, 0],
        "extensions": { "KHR_materials_transmission": {} }
    }));
    let scene = file.load();
    assert_eq!(first(&scene).base_color, Vec4::new(1., 0., 0.5, 1.));
    assert_eq!(first(&scene).emissive, Vec3::ZERO);
    assert!(noted(&scene, &["odd", "0..1"]));
    assert!(noted(&scene, &["odd", "emission"]));
    assert!(noted(&scene, &["odd", "KHR_materials_transmission"]));
}
