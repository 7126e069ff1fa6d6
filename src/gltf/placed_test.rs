//! Nodes, scenes, transforms and skins.

use glam::{DVec3, Vec3};
use serde_json::json;

use super::test_file::{File, U8, face_normal, first, near, noted};

#[test]
fn transforms_compose() {
    let mut file = File::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    file.json["nodes"][0] = json!({
        "mesh": 0, "translation": [1, 0, 0], "scale": [2, 3, 1],
        "rotation": [0, 0, half, half]
    });
    file.json["scenes"][0]["nodes"] = json!([1]);
    let columns = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 10, 20, 30, 1];
    file.push("nodes", json!({ "children": [0], "matrix": columns }));
    let scene = file.load();
    let object = first(&scene);
    // Inner: scale, a quarter turn about z, one to the right. Outer: (x, y, z) to (z, y, -x).
    let outer = |p: Vec3| Vec3::new(p.z, p.y, -p.x) + Vec3::new(10., 20., 30.);
    assert!(near(object.positions[0], outer(Vec3::new(1., 0., 0.))));
    assert!(near(object.positions[1], outer(Vec3::new(1., 2., 0.))));
    assert!(near(object.positions[2], outer(Vec3::new(-2., 0., 0.))));
    assert_eq!(object.name, "node 0");
}

#[test]
fn mirrored_node_keeps_its_front() {
    let mut file = File::triangle();
    let normals = file.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    file.attribute("NORMAL", normals);
    for scale in [[-1., 1., 1.], [-2., -3., -1.], [1., 1., -1.]] {
        file.json["nodes"][0]["scale"] = json!(scale);
        let scene = file.load();
        let object = first(&scene);
        assert_eq!(object.triangles, [[0, 2, 1]]);
        let up = if scale[2] < 0.0 { Vec3::NEG_Z } else { Vec3::Z };
        assert_eq!(object.normals, [up; 3]);
        assert!(face_normal(object, 0).dot(up) > 0.0);
    }
}

#[test]
fn normals_of_stretched_nodes_stay_upright() {
    let mut file = File::new();
    let positions = file.floats("VEC3", &[1., 0., 0., 0., 1., 0., 0., 1., 1.]);
    let s = std::f32::consts::FRAC_1_SQRT_2;
    let normals = file.floats("VEC3", &[s, s, 0., s, s, 0., s, s, 0.]);
    file.mesh(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    file.root_node(json!({ "mesh": 0, "scale": [4, 1, 1] }));
    let scene = file.load();
    let object = first(&scene);
    assert!(near(
        object.normals[0],
        face_normal(object, 0).normalize().abs()
    ));
    // Flattened to a plane: still the normal of that plane.
    file.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 1]);
    assert!(file.load().scene.objects[0].normals[0].is_normalized());
}

#[test]
fn missing_normals_come_from_faces() {
    let mut file = File::triangle();
    let normals = file.floats("VEC3", &[0., 0., 0., f32::NAN, 0., 1., 0., 0., 2.]);
    file.attribute("NORMAL", normals);
    let scene = file.load();
    assert_eq!(first(&scene).normals, [Vec3::Z; 3]);
    assert!(noted(&scene, &["tri", "normals", "(2)"]));
}

#[test]
fn instances_and_names() {
    let mut file = File::triangle();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(primitive);
    file.json["meshes"][0]["name"] = json!("shared");
    file.root_node(json!({ "mesh": 0, "translation": [0, 0, 5] }));
    let scene = file.load();
    let names: Vec<_> = scene
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["tri/0", "tri/1", "shared/0", "shared/1"]);
    let keys: Vec<_> = scene
        .objects
        .iter()
        .map(|k| (k.node, k.mesh, k.primitive))
        .collect();
    assert_eq!(keys, [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1)]);
    assert_eq!(scene.scene.objects[3].positions[1], Vec3::new(1., 0., 5.));
    assert_eq!(
        scene.scene.objects[0].material,
        scene.scene.objects[3].material
    );
}

#[test]
fn far_scenes_keep_their_precision() {
    let mut file = File::triangle();
    file.json["nodes"][0]["translation"] = json!([1_000_000.031_25, 0, -2_000_000.015_625]);
    let scene = file.load();
    let origin = scene.scene.origin;
    assert!((origin - DVec3::new(1e6, 0., -2e6)).length() < 2.0);
    assert_eq!((origin * 16.0).fract(), DVec3::ZERO);
    let world = first(&scene).positions[1].as_dvec3() + origin;
    assert!((world - DVec3::new(1_000_001.031_25, 0., -2_000_000.015_625)).length() < 1e-6);
    // A mesh off to one side, but large: left where it is.
    file.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    assert_eq!(file.load().scene.origin, DVec3::ZERO);
}

#[test]
fn only_the_default_scene() {
    let mut file = File::triangle();
    file.push("nodes", json!({ "mesh": 0, "name": "other" }));
    file.push("scenes", json!({ "nodes": [1] }));
    assert_eq!(file.load().scene.objects[0].name, "tri");
    file.json["scene"] = json!(1);
    assert_eq!(file.load().scene.objects[0].name, "other");
    file.json.as_object_mut().unwrap().remove("scene");
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 1);
    assert!(noted(&scene, &["first of its 2 scenes"]));
    file.json.as_object_mut().unwrap().remove("scenes");
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 2);
    assert!(noted(&scene, &["no scene"]));
}

#[test]
fn scene_without_nodes() {
    let mut file = File::triangle();
    file.json["scenes"] = json!([{ "name": "empty", "extras": { "a": [1, 2] } }]);
    assert!(file.load().scene.objects.is_empty());
}

#[test]
fn hidden_nodes_are_left_out() {
    let mut file = File::triangle();
    file.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    file.json["nodes"][0]["children"] = json!([1]);
    file.push("nodes", json!({ "mesh": 0 }));
    let scene = file.load();
    assert!(scene.scene.objects.is_empty() && noted(&scene, &["tri", "hidden"]));
}

#[test]
fn skins_stand_in_their_rest_pose() {
    let mut file = File::triangle();
    let joints = file.accessor(U8, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = [1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 0., 0.];
    let weights = file.floats("VEC4", &weights);
    file.attribute("JOINTS_0", joints);
    file.attribute("WEIGHTS_0", weights);
    let mut binds = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    binds.extend(glam::Mat4::from_translation(Vec3::X).to_cols_array());
    let binds = file.floats("MAT4", &binds);
    let a = file.root_node(json!({ "translation": [0, 0, 2] }));
    let b = file.root_node(json!({ "translation": [0, 0, 4] }));
    file.push(
        "skins",
        json!({ "joints": [a, b], "inverseBindMatrices": binds }),
    );
    file.json["nodes"][0]["skin"] = json!(0);
    // The node's own transform does not matter.
    file.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    let scene = file.load();
    let expected = [
        Vec3::new(0., 0., 2.),
        Vec3::new(2., 0., 4.),
        // Half of each, though the weights add to two.
        Vec3::new(0.5, 1., 3.),
    ];
    assert_eq!(first(&scene).positions, expected);
    assert!(noted(&scene, &["tri", "rest pose"]));
    file.json["skins"][0]["joints"] = json!([a]);
    assert!(file.reason().contains("joint 1"));
    file.json["skins"][0]["joints"] = json!([a, b, a]);
    assert!(file.reason().contains("inverse bind"));
}

#[test]
fn gpu_instances_are_noted() {
    let mut file = File::triangle();
    file.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": {} });
    let scene = file.load();
    assert_eq!(scene.scene.objects.len(), 1);
    assert!(noted(&scene, &["tri", "EXT_mesh_gpu_instancing"]));
}
