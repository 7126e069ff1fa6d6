//! Lights and cameras.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use serde_json::{Value, json};

use super::camera::GltfProjection;
use super::test_file::{File, noted};
use crate::radiosity::LightKind;

fn lit(light: Value) -> File {
    let mut file = File::triangle();
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    file.root_node(json!({
        "name": "lamp", "translation": [1, 2, 3], "rotation": [0, 1, 0, 0], "scale": [5, 5, 5],
        "extensions": { "KHR_lights_punctual": { "light": 0 } }
    }));
    file
}

#[test]
fn point_light() {
    let scene = lit(json!({ "type": "point", "color": [1, 0.5, 0], "intensity": 10, "range": 7 }));
    let scene = scene.load();
    assert_eq!(scene.light_nodes, [1]);
    let light = &scene.scene.lights[0];
    assert_eq!(light.name, "lamp");
    let lumens = 10.0 * 4.0 * PI;
    assert!((light.power - Vec3::new(lumens, lumens / 2.0, 0.0)).length() < 1e-3);
    let LightKind::Point { position, range } = light.kind else {
        panic!("{:?}", light.kind)
    };
    assert_eq!((position, range), (Vec3::new(1., 2., 3.), 7.0));
}

#[test]
fn spot_light() {
    let scene = lit(json!({ "type": "spot", "spot": { "innerConeAngle": 0.25 } })).load();
    let light = &scene.scene.lights[0];
    assert!((light.power - Vec3::splat(4.0 * PI)).length() < 1e-5);
    let LightKind::Spot {
        direction,
        inner_angle,
        outer_angle,
        range,
        ..
    } = light.kind
    else {
        panic!("{:?}", light.kind)
    };
    assert!((direction - Vec3::Z).length() < 1e-6);
    assert_eq!((inner_angle, outer_angle), (0.25, PI / 4.0));
    assert_eq!(range, f32::INFINITY);
    assert!(!noted(&scene, &["lamp"]));
}

#[test]
fn odd_cones() {
    let spot = |inner: f32, outer: f32| {
        let cone = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        lit(json!({ "type": "spot", "spot": cone })).load()
    };
    for (inner, outer) in [(0.5, 0.5), (0.1, 3.0), (-1.0, 0.5), (2.0, 1.0)] {
        let scene = spot(inner, outer);
        let LightKind::Spot {
            inner_angle,
            outer_angle,
            ..
        } = scene.scene.lights[0].kind
        else {
            panic!()
        };
        assert!(0.0 <= inner_angle && inner_angle < outer_angle && outer_angle <= FRAC_PI_2);
        assert!(noted(&scene, &["lamp", "cone"]));
    }
    let scene = spot(0.0, 0.0);
    assert!(scene.scene.lights.is_empty() && noted(&scene, &["lamp", "left out"]));
}

#[test]
fn directional_light() {
    let scene = lit(json!({ "type": "directional", "intensity": 1000 })).load();
    let light = &scene.scene.lights[0];
    assert_eq!(light.power, Vec3::splat(1000.0));
    let LightKind::Directional { direction } = light.kind else {
        panic!("{:?}", light.kind)
    };
    assert!((direction - Vec3::Z).length() < 1e-6);
}

#[test]
fn broken_lights_are_left_out() {
    for light in [
        json!({ "type": "point", "intensity": -1 }),
        json!({ "type": "point", "intensity": 3e38 }),
        json!({ "type": "directional", "color": [1, -1, 1] }),
    ] {
        let scene = lit(light).load();
        assert!(scene.scene.lights.is_empty() && scene.light_nodes.is_empty());
        assert!(noted(&scene, &["lamp", "left out"]));
    }
    let mut file = lit(json!({ "type": "directional" }));
    file.json["nodes"][1]["scale"] = json!([1, 1, 0]);
    assert!(noted(&file.load(), &["lamp", "no direction"]));
    let scene = lit(json!({ "type": "point", "range": 0 })).load();
    assert!(noted(&scene, &["lamp", "range"]) && scene.scene.lights.len() == 1);
    assert!(lit(json!({ "type": "area" })).reason().contains("type"));
    assert!(lit(json!({ "type": "spot" })).reason().contains("spot"));
}

#[test]
fn lights_are_relative_to_the_origin() {
    let mut file = lit(json!({ "type": "point" }));
    file.json["nodes"][0]["translation"] = json!([1e6, 0, 0]);
    file.json["nodes"][1]["translation"] = json!([1e6, 2, 0]);
    let scene = file.load();
    let LightKind::Point { position, .. } = scene.scene.lights[0].kind else {
        panic!()
    };
    let world = position.as_dvec3() + scene.scene.origin;
    assert_eq!(world, glam::DVec3::new(1e6, 2., 0.));
}

#[test]
fn hidden_lights_are_left_out() {
    let mut file = lit(json!({ "type": "point" }));
    let hidden = json!({ "visible": false });
    file.json["nodes"][1]["extensions"]["KHR_node_visibility"] = hidden;
    assert!(file.load().scene.lights.is_empty());
}

#[test]
fn first_camera() {
    let mut file = File::triangle();
    file.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }),
    );
    file.push(
        "cameras",
        json!({ "type": "orthographic",
            "orthographic": { "xmag": 2, "ymag": 1, "znear": 0, "zfar": 10 } }),
    );
    file.root_node(
        json!({ "name": "eye", "camera": 0, "translation": [0, 1, 5],
        "rotation": [0, 1, 0, 0], "scale": [1, 3, 2] }),
    );
    file.root_node(json!({ "camera": 1 }));
    let camera = file.load().camera.unwrap();
    assert_eq!((camera.name.as_str(), camera.node), ("eye", 1));
    assert_eq!(camera.position, Vec3::new(0., 1., 5.));
    assert!((camera.forward - Vec3::Z).length() < 1e-6);
    assert!((camera.up - Vec3::Y).length() < 1e-6);
    let expected = GltfProjection::Perspective {
        yfov: 0.8,
        aspect: None,
        near: 0.1,
        far: None,
    };
    assert_eq!(camera.projection, expected);
    // A broken one is passed over.
    file.json["cameras"][0]["perspective"]["yfov"] = json!(-1);
    let scene = file.load();
    assert!(noted(&scene, &["eye", "ignored"]));
    let projection = scene.camera.unwrap().projection;
    assert!(matches!(
        projection,
        GltfProjection::Orthographic {
            xmag: 2.0,
            ymag: 1.0,
            ..
        }
    ));
    assert!(File::triangle().load().camera.is_none());
}
