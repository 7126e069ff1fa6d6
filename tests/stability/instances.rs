//! One mesh in several places.

use bevy_fresco::gltf::load;
use bevy_fresco::radiosity::{BakeSettings, MaterialId, Object, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use serde_json::json;

use crate::common::{grey, room, values};
use crate::solved::{baked, differences};

/// A unit cube around the origin, its faces apart.
fn cube() -> Object {
    let mut walls = room(Vec3::ONE, 2, [0; 6]);
    let mut cube = Object::default();
    for wall in &mut walls {
        let first = cube.positions.len() as u32;
        cube.positions
            .extend(wall.positions.iter().map(|p| *p - 0.5));
        cube.normals.extend(wall.normals.iter().map(|n| -*n));
        cube.triangles.extend(
            wall.triangles
                .iter()
                .map(|&[a, b, c]| [a, c, b].map(|v| v + first)),
        );
    }
    cube
}

/// A file with the mesh in a node of that transform.
fn file(mesh: &Object, world: DAffine3) -> Scene {
    let mut bytes = Vec::new();
    for v in mesh.positions.iter().chain(&mesh.normals) {
        bytes.extend(v.to_array().iter().flat_map(|c| c.to_le_bytes()));
    }
    let vertices = mesh.positions.len();
    for i in mesh.triangles.as_flattened() {
        bytes.extend(i.to_le_bytes());
    }
    let indices = 3 * mesh.triangles.len();
    let column = |c: DVec3, w: f64| [c.x, c.y, c.z, w];
    let m = world.matrix3;
    let matrix = [
        column(m.x_axis, 0.0),
        column(m.y_axis, 0.0),
        column(m.z_axis, 0.0),
        column(world.translation, 1.0),
    ];
    let json = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "matrix": matrix.as_flattened()}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
             "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5]},
            {"bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": indices, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 12 * vertices},
            {"buffer": 0, "byteOffset": 12 * vertices, "byteLength": 12 * vertices},
            {"buffer": 0, "byteOffset": 24 * vertices, "byteLength": 4 * indices},
        ],
        "buffers": [{"uri": "mesh.bin", "byteLength": bytes.len()}],
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mesh.bin"), bytes).unwrap();
    let path = folder.path().join("mesh.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    load(&path).unwrap().scene
}

/// The same in a scene without nodes.
fn placed(mesh: &Object, world: DAffine3) -> Object {
    let normals = world.matrix3.inverse().transpose();
    let mut object = mesh.clone();
    for p in &mut object.positions {
        *p = world.transform_point3(p.as_dvec3()).as_vec3();
    }
    for n in &mut object.normals {
        *n = (normals * n.as_dvec3()).normalize().as_vec3();
    }
    if world.matrix3.determinant() < 0.0 {
        object.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    object
}

/// A block that a node mirrors, stretches and turns is lit as the block modelled so, within 10⁻⁶:
/// front stays front, normals stay upright, elements go by the area in the world.
#[test]
fn mirrored_and_stretched_nodes() {
    let at = DVec3::new(0.5, 0.5, 0.5);
    for (scale, turn) in [
        (DVec3::new(-0.3, 0.3, 0.3), 0.0),
        (DVec3::new(0.1, 0.5, 0.02), 0.0),
        (DVec3::new(-0.1, 0.5, 0.02), 0.7),
        (DVec3::new(-0.2, -0.3, -0.1), 0.4),
    ] {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), turn);
        let world = DAffine3::from_scale_rotation_translation(scale, turn, at);
        let from_node = file(&cube(), world);
        let mut modelled = from_node.clone();
        modelled.objects[0] = placed(&cube(), world);
        let [a, b] = [from_node, modelled].map(|mut s| {
            s.objects[0].material = MaterialId(0);
            s.objects.extend(room(Vec3::ONE, 3, [0, 1, 0, 0, 0, 0]));
            s.materials = vec![grey(0.5, 0.0), grey(0.5, 1.0)];
            baked(
                s,
                &BakeSettings {
                    refine: false,
                    adapt: false,
                    ..BakeSettings::DRAFT
                },
            )
        });
        let (_, largest) = differences(&values(&a), &values(&b));
        assert!(largest < 1e-6, "{scale}: {largest}");
        let block = a.objects[0].light.iter();
        assert!(
            block.fold(f32::MAX, |low, l| low.min(l.x)) > 0.1,
            "{scale}: inside out"
        );
    }
}
