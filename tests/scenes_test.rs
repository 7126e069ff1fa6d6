//! The sample scenes are what their generator makes, and what they claim to be.

#[path = "../examples/scenes/baked.rs"]
mod baked;
#[path = "../examples/scenes/mod.rs"]
mod scenes;

use std::path::{Path, PathBuf};

use bevy_fresco::radiosity::BakeSettings;
use glam::{Mat4, Vec3, vec3};
use gltf::{Gltf, Node};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("assets/scenes")
        .join(name)
}

fn open(name: &str) -> Gltf {
    Gltf::open(path(name)).expect("the file is valid")
}

/// The bytes of an accessor; all of these files' are tightly packed.
fn bytes<'a>(scene: &'a Gltf, accessor: &gltf::Accessor<'_>) -> &'a [u8] {
    let view = accessor.view().expect("it has a buffer view");
    let blob = scene.blob.as_deref().expect("there is a binary chunk");
    assert_eq!(view.length(), accessor.count() * accessor.size());
    &blob[view.offset()..][..view.length()]
}

/// Triangles in world space with the sum of their corners' normals, by node.
fn triangles(scene: &Gltf, name: &str) -> Vec<([Vec3; 3], Vec3)> {
    let node = scene.nodes().find(|node| node.name() == Some(name));
    let node: Node = node.expect("the scene has this object");
    let matrix = Mat4::from_cols_array_2d(&node.transform().matrix());
    let mesh = node.mesh().expect("it is a mesh");
    let primitive = mesh.primitives().next().expect("it has a primitive");
    let read = |accessor: Option<gltf::Accessor<'_>>| bytes(scene, &accessor.expect("it is there"));
    let vectors = |semantic| -> Vec<Vec3> {
        let bytes = read(primitive.get(&semantic));
        let floats = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b));
        let floats: Vec<f32> = floats.collect();
        floats
            .as_chunks()
            .0
            .iter()
            .map(|v| Vec3::from(*v))
            .collect()
    };
    let positions = vectors(gltf::Semantic::Positions);
    let normals = vectors(gltf::Semantic::Normals);
    let indices = read(primitive.indices());
    let indices = indices.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b));
    let indices: Vec<u16> = indices.collect();
    let corners = indices.as_chunks::<3>().0.iter();
    corners
        .map(|corners| {
            let place = |v: u16| matrix.transform_point3(positions[v as usize]);
            let normal: Vec3 = corners.iter().map(|&v| normals[v as usize]).sum();
            (corners.map(place), matrix.transform_vector3(normal))
        })
        .collect()
}

fn cross([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

fn middle([a, b, c]: [Vec3; 3]) -> Vec3 {
    (a + b + c) / 3.0
}

fn names(scene: &Gltf) -> Vec<String> {
    let with_mesh = scene.nodes().filter(|node| node.mesh().is_some());
    with_mesh
        .filter_map(|node| Some(node.name()?.to_string()))
        .collect()
}

#[test]
fn files_are_what_the_generator_makes() {
    for (name, bytes) in scenes::all() {
        let file = std::fs::read(path(name)).expect("the file is there");
        assert!(
            file == bytes,
            "{name} differs: cargo run --example make_scenes"
        );
        assert!(bytes.len() < 400_000, "{name}: {} bytes", bytes.len());
    }
    for (name, bytes) in scenes::maps() {
        let path = path(name).with_file_name("../textures").join(name);
        let file = std::fs::read(path).expect("the file is there");
        assert!(
            file == bytes,
            "{name} differs: cargo run --example make_scenes"
        );
    }
}

#[test]
fn normals_agree_with_windings() {
    for (file, _) in scenes::all() {
        let scene = open(file);
        for name in names(&scene) {
            // Mirrored nodes turn windings round, which engines undo.
            let mirror = if name.contains("mirrored") { -1.0 } else { 1.0 };
            for (corners, normal) in triangles(&scene, &name) {
                let cosine = cross(corners).normalize().dot(normal.normalize());
                assert!(cosine * mirror > 0.99, "{file}, {name}: {cosine}");
            }
        }
    }
}

#[test]
fn the_cornell_box_faces_its_light() {
    let scene = open("cornell_box.glb");
    let size = vec3(5.528, 5.488, 5.592);
    let mut area = 0.0;
    for name in ["Floor", "Ceiling", "Back wall", "Red wall", "Green wall"] {
        let wall = triangles(&scene, name);
        assert_eq!(wall.len(), 24 * 24 * 2);
        for (corners, _) in wall {
            let to_centre = size / 2.0 - middle(corners);
            assert!(cross(corners).dot(to_centre) > 0.0, "{name}");
            area += cross(corners).length() / 2.0;
        }
    }
    let [x, y, z] = size.to_array();
    assert!((area - (2.0 * (x * z + y * z) + x * y)).abs() < 1e-2);
    for (name, centre, count) in [
        ("Short block", vec3(1.85, 0.8, 1.69), 5 * 128),
        ("Tall block", vec3(3.69, 1.6, 3.51), 5 * 128),
        ("Lamp", vec3(2.78, 5.338, 2.795), 8),
        ("Lamp casing", vec3(2.78, 5.338, 2.795), 8 + 4 * 4),
    ] {
        let block = triangles(&scene, name);
        assert_eq!(block.len(), count, "{name}");
        for (corners, _) in block {
            let out = middle(corners) - centre;
            assert!(cross(corners).dot(out) > 0.0, "{name}");
        }
    }
    let lamp = scene.materials().find(|m| m.name() == Some("Lamp"));
    let lamp = lamp.expect("there is a lamp");
    let strength = lamp.emissive_strength().expect("it is bright");
    let radiance = Vec3::from(lamp.emissive_factor()) * strength;
    assert!(radiance.distance(vec3(17.0, 12.0, 4.0)) < 1e-5);
    for (corners, _) in triangles(&scene, "Lamp") {
        assert!(cross(corners).normalize().distance(Vec3::NEG_Y) < 1e-6);
    }
    let camera = scene.nodes().find(|node| node.camera().is_some());
    let matrix = camera.expect("there is a camera").transform().matrix();
    let matrix = Mat4::from_cols_array_2d(&matrix);
    assert_eq!(matrix.transform_vector3(Vec3::NEG_Z), Vec3::Z);
    assert_eq!(matrix.transform_point3(Vec3::ZERO), vec3(2.78, 2.73, -8.0));
}

#[test]
fn walls_meet_vertex_by_vertex() {
    let scene = open("cornell_box.glb");
    let points = |name| -> std::collections::HashSet<[u32; 3]> {
        let corners = triangles(&scene, name).into_iter();
        corners
            .flat_map(|(corners, _)| corners)
            .map(|p| (p + Vec3::ZERO).to_array().map(f32::to_bits))
            .collect()
    };
    let back = points("Back wall");
    for wall in ["Floor", "Ceiling", "Red wall", "Green wall"] {
        assert_eq!(back.intersection(&points(wall)).count(), 25, "{wall}");
    }
}

#[test]
fn the_furnace_is_closed_and_faces_inwards() {
    let scene = open("furnace.glb");
    let mut area = 0.0;
    for (corners, _) in triangles(&scene, "Furnace") {
        let to_centre = vec3(1.0, 0.5, 1.5) - middle(corners);
        assert!(cross(corners).dot(to_centre) > 0.0);
        area += cross(corners).length() / 2.0;
    }
    assert!((area - 22.0).abs() < 1e-4, "{area}");
}

#[test]
fn the_courtyard_has_some_of_everything() {
    use gltf::khr_lights_punctual::Kind;
    use gltf::material::AlphaMode;

    let scene = open("courtyard.glb");
    let names = names(&scene);
    let count: usize = names.iter().map(|n| triangles(&scene, n).len()).sum();
    assert!((4_000..12_000).contains(&count), "{count} triangles");
    let lights: Vec<_> = scene.lights().expect("lights").collect();
    assert!(lights.iter().any(|l| matches!(l.kind(), Kind::Directional)));
    assert!(lights.iter().any(|l| matches!(l.kind(), Kind::Point)));
    assert!(lights.iter().any(|l| matches!(l.kind(), Kind::Spot { .. })));
    for mode in [AlphaMode::Opaque, AlphaMode::Mask, AlphaMode::Blend] {
        assert!(scene.materials().any(|m| m.alpha_mode() == mode));
    }
    let mesh_of = |name: &str| {
        let node = scene.nodes().find(|node| node.name() == Some(name));
        node.and_then(|node| Some(node.mesh()?.index()))
    };
    assert!(mesh_of("Bench").is_some());
    assert_eq!(mesh_of("Bench"), mesh_of("Bench mirrored"));
    for image in scene.images() {
        let gltf::image::Source::View { view, .. } = image.source() else {
            panic!("images are embedded");
        };
        let blob = scene.blob.as_deref().expect("there is a binary chunk");
        let png = &blob[view.offset()..view.offset() + view.length()];
        assert!(image::load_from_memory(png).is_ok());
    }
}

/// Light of each primitive's vertices, of a file's bytes.
fn light(file: &[u8]) -> Vec<Vec<f32>> {
    let scene = Gltf::from_slice(file).expect("the file is valid");
    let primitives = scene.meshes().flat_map(|mesh| mesh.primitives());
    let semantic = gltf::Semantic::Extras("BAKED_LIGHT".into());
    primitives
        .filter_map(|primitive| primitive.get(&semantic))
        .map(|accessor| {
            let bytes = bytes(&scene, &accessor).as_chunks().0;
            bytes.iter().map(|b| f32::from_le_bytes(*b)).collect()
        })
        .collect()
}

/// The file with light is what a bake makes of the one without. Machines whose sines differ in the last bit may
/// differ a little more in the light.
#[test]
fn baked_light_is_that_of_a_bake() {
    let (made, report) = baked::baked(&path("cornell_box.glb"), &BakeSettings::BALANCED)
        .expect("the scene can be baked");
    let kept = std::fs::read(path("cornell_box_baked.glb")).expect("it is there");
    let [made, kept] = [&made.bytes, &kept].map(|file| light(file));
    assert!(!kept.is_empty());
    let counts = |light: &[Vec<f32>]| light.iter().map(Vec::len).collect::<Vec<_>>();
    assert_eq!(counts(&made), counts(&kept), "make_scenes was not run");
    let pairs = || made.iter().flatten().zip(kept.iter().flatten());
    let squares: f64 = pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let off = (squares / pairs().count() as f64).sqrt();
    assert!(off < 1e-3 * f64::from(report.mean_light), "{off}");
}
