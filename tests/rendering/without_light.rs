//! Meshes without baked light look as they do in Bevy's material.

use bevy::core_pipeline::prepass::{DepthPrepass, NormalPrepass};
use bevy::prelude::*;
use bevy::render::view::Msaa;

use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::scenery::{add, checker, grid, show_bevy, show_fresco};
use crate::stage::on_stage;

#[test]
fn like_the_standard_material() {
    for mode in [
        "forward",
        "prepass",
        "multisampled",
        "deferred",
        "mask",
        "blend",
    ] {
        let shoot = |ours: bool| {
            on_stage(move |stage| {
                let deferred = mode == "deferred";
                stage.shoot(
                    |camera| {
                        match mode {
                            "prepass" => camera.insert((DepthPrepass, NormalPrepass)),
                            "multisampled" => camera.insert(Msaa::Sample4),
                            "deferred" => camera.insert(DEFERRED),
                            _ => camera,
                        };
                    },
                    |world| {
                        world.insert_resource(GlobalAmbientLight {
                            brightness: 300.0,
                            affects_lightmapped_meshes: false,
                            ..default()
                        });
                        world.spawn((
                            PointLight {
                                shadow_maps_enabled: true,
                                affects_lightmapped_mesh_diffuse: false,
                                ..default()
                            },
                            Transform::from_xyz(0.5, 1.0, 2.0),
                        ));
                        let base = StandardMaterial {
                            base_color_texture: Some(add(world, checker())),
                            opaque_render_method: method(deferred),
                            alpha_mode: match mode {
                                "mask" => AlphaMode::Mask(0.5),
                                "blend" => AlphaMode::Blend,
                                _ => AlphaMode::Opaque,
                            },
                            ..default()
                        };
                        let at = Transform::from_rotation(Quat::from_rotation_x(-0.6));
                        if ours {
                            show_fresco(world, grid(), base, at);
                        } else {
                            show_bevy(world, grid(), base, at);
                        }
                    },
                )
            })
        };
        let difference = shoot(true).greatest_difference(&shoot(false));
        println!("{mode}: {difference}");
        assert!(difference == 0.0, "{mode}: {difference}");
    }
}
