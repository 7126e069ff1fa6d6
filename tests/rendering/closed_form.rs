//! Constant light on simple surfaces: exposure × light × diffuse colour.

use bevy::color::ColorToComponents;
use bevy::prelude::*;

use crate::scenery::{add, checker, grid, lit, show_fresco};
use crate::stage::{exposure, on_stage};

const LIGHT: Vec3 = Vec3::new(900.0, 500.0, 1300.0);

/// The middle of what is seen of a grid with `base` at `at`, over what a white one would show.
fn middle(base: StandardMaterial, at: Transform) -> Vec3 {
    let picture = on_stage(move |stage| {
        stage.shoot(
            |_| (),
            |world| {
                show_fresco(world, lit(grid(), LIGHT), base, at);
            },
        )
    });
    Vec3::from(picture.at(0.5, 0.5)) / (LIGHT * exposure())
}

#[track_caller]
fn assert_close(found: Vec3, expected: Vec3) {
    println!("{found} for {expected}");
    let error = (found - expected).abs() / expected.max(Vec3::splat(1e-3));
    assert!(error.max_element() < 0.01, "{found} is not {expected}");
}

#[test]
fn white_floor() {
    assert_close(middle(default(), default()), Vec3::ONE);
}

#[test]
fn base_color_and_metallic() {
    let base = StandardMaterial {
        base_color: Color::linear_rgb(0.8, 0.4, 0.1),
        metallic: 0.25,
        ..default()
    };
    assert_close(middle(base, default()), Vec3::new(0.8, 0.4, 0.1) * 0.75);
}

#[test]
fn transmission_takes_from_the_diffuse_colour() {
    let base = StandardMaterial {
        diffuse_transmission: 0.25,
        ..default()
    };
    assert_close(middle(base, default()), Vec3::splat(0.75));
}

#[test]
fn tilted_mirrored_and_squeezed() {
    for at in [
        Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.7, -0.5, 0.3)),
        Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        Transform::from_scale(Vec3::new(0.5, 1.0, -2.0))
            .with_rotation(Quat::from_rotation_y(std::f32::consts::PI)),
        Transform::from_scale(Vec3::new(1.5, 0.7, 3.0)),
    ] {
        let base = StandardMaterial {
            double_sided: true,
            cull_mode: None,
            ..default()
        };
        assert_close(middle(base, at), Vec3::ONE);
    }
}

#[test]
fn seen_from_behind() {
    let base = StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    let at = Transform::from_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    assert_close(middle(base, at), Vec3::ONE);
}

#[test]
fn texture_and_vertex_colour_multiply() {
    let picture = on_stage(|stage| {
        stage.shoot(
            |_| (),
            |world| {
                let base_color_texture = Some(add(world, checker()));
                let base = StandardMaterial {
                    base_color_texture,
                    ..default()
                };
                let count = grid().count_vertices();
                let mesh = grid().with_inserted_attribute(
                    Mesh::ATTRIBUTE_COLOR,
                    vec![[0.5, 1.0, 0.25, 1.0]; count],
                );
                show_fresco(world, lit(mesh, LIGHT), base, default());
            },
        )
    });
    let texel = Color::srgb_u8(180, 128, 100).to_linear().to_vec3();
    let found = Vec3::from(picture.at(0.25, 0.75)) / (LIGHT * exposure());
    assert_close(found, texel * Vec3::new(0.5, 1.0, 0.25));
}

#[test]
fn unlit_stays_unlit() {
    for deferred in [false, true] {
        let picture = on_stage(move |stage| {
            stage.shoot(
                |camera| {
                    if deferred {
                        camera.insert(crate::like_bevys_lightmap::DEFERRED);
                    }
                },
                |world| {
                    let base = StandardMaterial {
                        base_color: Color::linear_rgb(0.5, 0.25, 0.125),
                        unlit: true,
                        opaque_render_method: crate::like_bevys_lightmap::method(deferred),
                        ..default()
                    };
                    show_fresco(world, lit(grid(), LIGHT), base, default());
                },
            )
        });
        assert_close(picture.at(0.5, 0.5).into(), Vec3::new(0.5, 0.25, 0.125));
    }
}

#[test]
fn gain_dims_it() {
    let picture = on_stage(|stage| {
        stage.shoot(
            |_| (),
            |world| {
                show_fresco(world, lit(grid(), LIGHT), default(), default());
                let mut materials =
                    world.resource_mut::<Assets<bevy_fresco::plugin::FrescoMaterial>>();
                for (_, material) in materials.iter_mut() {
                    material.extension.baked_light_gain = 0.25;
                }
            },
        )
    });
    let found = Vec3::from(picture.at(0.5, 0.5)) / (LIGHT * exposure());
    assert_close(found, Vec3::splat(0.25));
}

/// At the edges of triangles thinner than a pixel, samples lie outside the pixel's middle.
#[test]
fn multisampling_makes_no_light() {
    // A dark square with a rim of a twentieth of a pixel, bright at the very edge.
    let (inner, outer) = (0.6, 0.6015);
    let brightest = 1000.0;
    let around = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = |half: f32| around.map(|(x, y)| [half * x, half * y, 0.0]);
    let positions = [corners(inner), corners(outer)].concat();
    let rim = (0..4u32).flat_map(|i| {
        let j = (i + 1) % 4;
        [i, i + 4, j + 4, i, j + 4, j]
    });
    let indices: Vec<u32> = [0, 1, 2, 0, 2, 3].into_iter().chain(rim).collect();
    let light = [[0.0; 3]; 4].into_iter().chain([[brightest; 3]; 4]);
    let mesh = Mesh::new(
        bevy::mesh::PrimitiveTopology::TriangleList,
        bevy::asset::RenderAssetUsages::all(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; 8])
    .with_inserted_attribute(
        bevy_fresco::plugin::ATTRIBUTE_BAKED_LIGHT,
        light.collect::<Vec<_>>(),
    )
    .with_inserted_indices(bevy::mesh::Indices::U32(indices));
    let picture = on_stage(|stage| {
        stage.shoot(
            |camera| {
                camera.insert(Msaa::Sample4);
            },
            |world| {
                let base = StandardMaterial {
                    reflectance: 0.0,
                    ..default()
                };
                let at = Transform::from_rotation(Quat::from_rotation_z(0.2));
                show_fresco(world, mesh, base, at);
            },
        )
    });
    let seen = picture
        .pixels
        .iter()
        .map(|pixel| pixel[0])
        .fold(0.0, f32::max);
    let truth = brightest * exposure();
    assert!(seen > 0.0 && seen <= 1.001 * truth, "{seen} of {truth}");
}
