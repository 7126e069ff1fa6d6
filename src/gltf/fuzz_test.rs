//! Files broken at random: an error or a sound scene, never a panic.

use std::path::Path;

use serde_json::{Value, json};

use super::error::GltfError;
use super::import::{GltfScene, import};
use super::test_file::{File, I8, U8, U16, data_uri, f32_bytes, png, u16_bytes};

/// Something of everything that is read.
pub(super) fn rich() -> File {
    let mut file = File::triangle();
    let normals = file.accessor(I8, "VEC3", 3, &[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0]);
    file.json["accessors"][normals]["normalized"] = json!(true);
    file.json["bufferViews"][1]["byteStride"] = json!(4);
    let uv = file.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let colors = file.floats("VEC3", &[0.5; 9]);
    let joints = file.accessor(U8, "VEC4", 3, &[0, 1, 0, 0].repeat(3));
    let weights = file.floats("VEC4", &[0.5, 0.5, 0., 0.].repeat(3));
    let binds = file.floats("MAT4", &glam::Mat4::IDENTITY.to_cols_array().repeat(2));
    let indices = file.accessor(U16, "SCALAR", 3, &u16_bytes(&[0, 1, 2]));
    let morph = file.floats("VEC3", &[0.1; 9]);
    let at = file.view(&u16_bytes(&[1, 2]));
    let values = file.view(&f32_bytes(&[1.; 6]));
    file.json["accessors"][morph]["sparse"] = json!({
        "count": 2, "indices": { "bufferView": at, "componentType": U16 },
        "values": { "bufferView": values, "byteOffset": 0 }
    });
    let slot = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform":
        { "offset": [0.5, 0], "rotation": 1, "scale": [2, 2], "texCoord": 0 } } });
    file.texture(&[[1, 2, 3, 4], [5, 6, 7, 8]]);
    file.push("samplers", json!({ "wrapS": 33071 }));
    file.json["textures"][0]["sampler"] = json!(0);
    file.push(
        "materials",
        json!({
            "pbrMetallicRoughness": { "baseColorTexture": slot, "metallicRoughnessTexture": slot },
            "emissiveTexture": slot, "emissiveFactor": [1, 1, 1], "alphaMode": "BLEND",
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 2 } }
        }),
    );
    file.push(
        "materials",
        json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness":
        { "diffuseFactor": [1, 1, 1, 1], "diffuseTexture": { "index": 0 } } } }),
    );
    let attributes = json!({ "POSITION": 0, "NORMAL": normals, "TEXCOORD_0": uv,
        "COLOR_0": colors, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.json["meshes"][0] = json!({ "weights": [0.5], "primitives": [
        { "attributes": attributes, "indices": indices, "material": 0,
          "targets": [{ "POSITION": morph, "NORMAL": morph }] },
        { "attributes": attributes, "indices": indices, "material": 1, "mode": 5 }
    ] });
    let a = file.root_node(json!({ "children": [2], "translation": [1, 2, 3] }));
    let b = file.push(
        "nodes",
        json!({ "rotation": [0, 0, 0, 1], "scale": [1, -1, 1], "mesh": 0 }),
    );
    file.push(
        "skins",
        json!({ "joints": [a, b], "inverseBindMatrices": binds }),
    );
    file.json["nodes"][0]["skin"] = json!(0);
    file.push(
        "cameras",
        json!({ "type": "perspective",
        "perspective": { "yfov": 1, "znear": 0.1, "aspectRatio": 1.5 } }),
    );
    file.root_node(
        json!({ "camera": 0, "matrix": glam::Mat4::IDENTITY.to_cols_array(),
        "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.5 },
          "range": 5, "intensity": 3, "color": [1, 1, 1] } ] } });
    file.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
    file
}

/// What every imported scene keeps to.
fn assert_sound(loaded: &GltfScene) {
    let scene = &loaded.scene;
    assert_eq!(scene.objects.len(), loaded.objects.len());
    assert_eq!(scene.lights.len(), loaded.light_nodes.len());
    assert!(scene.origin.is_finite());
    for object in &scene.objects {
        let count = object.positions.len();
        assert!(object.positions.iter().all(|p| p.is_finite()));
        assert!(object.normals.is_empty() || object.normals.len() == count);
        assert!(
            object
                .normals
                .iter()
                .all(|n| n.is_finite() && n.length() > 0.9)
        );
        assert!(object.colors.is_empty() || object.colors.len() == count);
        assert!(object.uvs.iter().all(|uvs| uvs.len() == count));
        assert!(object.uvs.iter().flatten().all(|uv| uv.is_finite()));
        assert!(object.colors.iter().all(|color| color.is_finite()));
        assert!(
            object
                .triangles
                .iter()
                .flatten()
                .all(|&i| (i as usize) < count)
        );
        let material = &scene.materials[object.material.0 as usize];
        assert!(material.base_color.is_finite() && material.emissive.is_finite());
        let slots = [
            material.base_color_texture,
            material.metallic_texture,
            material.emissive_texture,
        ];
        for slot in slots.into_iter().flatten() {
            assert!((slot.uv_set as usize) < object.uvs.len());
            assert!(slot.transform.is_finite());
            let texture = &scene.textures[slot.texture.0 as usize];
            assert_eq!(texture.texels.len() as u32, texture.width * texture.height);
        }
    }
    for light in &scene.lights {
        assert!(light.power.is_finite() && light.power.min_element() >= 0.0);
    }
    for (buffer, file) in loaded.document.buffers.iter().enumerate() {
        let length = loaded.document.json["buffers"][buffer]["byteLength"].as_u64();
        assert!(file.len() as u64 >= length.unwrap_or(0));
    }
}

/// A small generator, so that a failure comes again.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % end
    }
}

/// Imports a file and checks the result.
pub(super) fn load(bytes: &[u8]) -> Result<GltfScene, GltfError> {
    let result = import(Path::new("test.glb"), bytes);
    match &result {
        Ok(scene) => assert_sound(scene),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    result
}

#[test]
fn the_rich_file_is_fine() {
    let scene = load(&rich().glb()).unwrap();
    assert_eq!(scene.scene.objects.len(), 4);
    assert_eq!(scene.scene.lights.len(), 1);
    assert!(scene.camera.is_some());
}

#[test]
fn every_truncation_is_an_error() {
    let glb = rich().glb();
    for length in 0..glb.len() {
        let Err(GltfError::Invalid { reason, .. }) = load(&glb[..length]) else {
            panic!("cut to {length}")
        };
        assert!(!reason.is_empty());
    }
    let text = rich().gltf_embedded();
    let end = text.iter().rposition(|b| !b.is_ascii_whitespace()).unwrap();
    for length in (0..end).step_by(37) {
        assert!(load(&text[..length]).is_err(), "cut to {length}");
    }
}

#[test]
fn bytes_flipped_at_random() {
    let glb = rich().glb();
    let mut random = Random(0x5EED);
    let mut fine = 0;
    for _ in 0..4000 {
        let mut bytes = glb.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            bytes[at] = match random.below(3) {
                0 => bytes[at] ^ 1 << random.below(8),
                1 => [0, 0xFF, 0x7F, 0x80][random.below(4)],
                _ => random.below(256) as u8,
            };
        }
        fine += usize::from(load(&bytes).is_ok());
    }
    assert!(fine > 100, "{fine}");
}

#[test]
fn json_changed_at_random() {
    let file = rich();
    let mut random = Random(0xF00D);
    let mut fine = 0;
    for _ in 0..6000 {
        let mut changed = file.clone();
        for _ in 0..=random.below(3) {
            mutate(&mut changed.json, &mut random);
        }
        fine += usize::from(load(&changed.glb()).is_ok());
    }
    assert!(fine > 100, "{fine}");
}

/// Goes down to some member and replaces, removes or doubles it.
fn mutate(value: &mut Value, random: &mut Random) {
    let length = match &*value {
        Value::Object(members) => members.len(),
        Value::Array(entries) => entries.len(),
        _ => 0,
    };
    if length == 0 || random.below(12) == 0 {
        *value = odd_value(random);
        return;
    }
    let chosen = random.below(length);
    let act = random.below(16);
    match value {
        Value::Object(members) => {
            let key = members.keys().nth(chosen).unwrap().clone();
            if act == 0 {
                members.remove(&key);
            } else {
                mutate(&mut members[&key], random);
            }
        }
        Value::Array(entries) => match act {
            0 => drop(entries.remove(chosen)),
            1 => entries.push(entries[chosen].clone()),
            _ => mutate(&mut entries[chosen], random),
        },
        _ => {}
    }
}

fn odd_value(random: &mut Random) -> Value {
    let values = [
        json!(null),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(-1),
        json!(0.5),
        json!(1e30),
        json!(1e300),
        json!(-1e300),
        json!(255),
        json!(65536),
        json!(16_777_217),
        json!(2_147_483_647),
        json!(4_294_967_295_u32),
        json!(4_294_967_296_u64),
        json!(u64::MAX),
        json!(u64::MAX / 12),
        json!(true),
        json!(""),
        json!("VEC4"),
        json!("data:,"),
        json!("x"),
        json!([]),
        json!({}),
        json!([0]),
        json!([1e300, 1, 1]),
        json!(5120),
        json!(5123),
        json!(5126),
        json!([0, 0, 0, 0]),
    ];
    values[random.below(values.len())].clone()
}

#[test]
fn images_flipped_at_random() {
    let pixels = image::RgbImage::from_fn(16, 16, |x, y| image::Rgb([x as u8 * 16, y as u8, 9]));
    let mut jpeg = std::io::Cursor::new(Vec::new());
    pixels
        .write_to(&mut jpeg, image::ImageFormat::Jpeg)
        .unwrap();
    let mut random = Random(0xCAFE);
    for image in [png(&[[1, 2, 3, 4]; 8]), jpeg.into_inner()] {
        let mut file = rich();
        file.json["images"][0] = json!({ "uri": data_uri("image/png", &image) });
        assert!(!load(&file.glb()).unwrap().scene.textures.is_empty());
        for _ in 0..300 {
            let mut bytes = image.clone();
            for _ in 0..3 {
                let at = random.below(bytes.len());
                bytes[at] = random.below(256) as u8;
            }
            file.json["images"][0] = json!({ "uri": data_uri("image/png", &bytes) });
            load(&file.glb()).unwrap();
        }
    }
}
