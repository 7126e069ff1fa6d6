//! Baked light under a normal map, pixel by pixel against the Rust twin of the shader.

use bevy::image::ImageSampler;
use bevy::math::{DMat3, Mat3};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::plugin::ATTRIBUTE_BAKED_LIGHT_GRADIENT;
use bevy_fresco::radiosity::{local_gradients, reshade};

use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::scenery::{add, grid, grid_lit_unevenly, lit, show_fresco};
use crate::stage::{SIZE, exposure, on_stage};

const LIGHT: Vec3 = Vec3::new(900.0, 500.0, 1300.0);

/// Texels of a normal map: two by two, turned by up to 45°.
const TEXELS: [[u8; 4]; 4] = [
    [200, 150, 230, 255],
    [60, 110, 220, 255],
    [128, 215, 222, 255],
    [40, 60, 180, 255],
];

pub(crate) fn normal_map(texels: &[[u8; 4]]) -> Image {
    let side = if texels.len() == 1 { 1 } else { 2 };
    let size = Extent3d {
        width: side,
        height: side,
        depth_or_array_layers: 1,
    };
    let format = TextureFormat::Rgba8Unorm;
    let usage = bevy::asset::RenderAssetUsages::all();
    let mut image = Image::new(size, TextureDimension::D2, texels.concat(), format, usage);
    image.sampler = ImageSampler::nearest();
    image
}

/// The normal of a texel, in the frame of tangents.
fn decoded(texel: [u8; 4]) -> Vec3 {
    let [x, y, z, _] = texel.map(|byte| f32::from(byte) / 255.0 * 2.0 - 1.0);
    Vec3::new(x, y, z).normalize()
}

pub(crate) fn with_tangents(mesh: Mesh) -> Mesh {
    let count = mesh.count_vertices();
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; count])
}

pub(crate) fn with_gradient(mesh: Mesh, gradient: Vec3) -> Mesh {
    let count = mesh.count_vertices();
    mesh.with_inserted_attribute(
        ATTRIBUTE_BAKED_LIGHT_GRADIENT,
        vec![gradient.to_array(); count],
    )
}

/// Light and gradients that differ from vertex to vertex.
#[test]
fn pixels_are_what_the_twin_says() {
    for deferred in [false, true] {
        let picture = on_stage(move |stage| {
            stage.shoot(
                |camera| {
                    if deferred {
                        camera.insert(DEFERRED);
                    }
                },
                |world| {
                    let normal_map_texture = Some(add(world, normal_map(&TEXELS)));
                    let base = StandardMaterial {
                        normal_map_texture,
                        opaque_render_method: method(deferred),
                        ..default()
                    };
                    let mesh = with_tangents(grid_lit_unevenly());
                    let places = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
                    let places = places.as_float3().unwrap().to_vec();
                    let gradients: Vec<_> = places.iter().map(|p| gradient_at(*p)).collect();
                    let mesh =
                        mesh.with_inserted_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT, gradients);
                    show_fresco(world, mesh, base, default());
                },
            )
        });
        let (mut square, mut whole, mut turned) = (0.0, 0.0, 0.0);
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let [x, y] = [i as u32 % SIZE, i as u32 / SIZE];
            let [u, v] = [x, y].map(|p| (p as f32 + 0.5) / SIZE as f32);
            let place = [2.0 * u - 1.0, 1.0 - 2.0 * v, 0.0];
            let light = Vec3::new(
                200.0 + 1000.0 * u,
                100.0 + 900.0 * v,
                600.0 + 400.0 * (3.0 * (u - v)).sin(),
            );
            let texel = usize::from(u >= 0.5) + 2 * usize::from(v >= 0.5);
            let bumped = decoded(TEXELS[texel]);
            let expected = reshade(light, gradient_at(place).into(), Vec3::Z, bumped);
            let found = Vec3::from_slice(pixel) / exposure();
            square += (found - expected).length_squared();
            whole += expected.length_squared();
            turned += (expected - light).length_squared();
        }
        let (error, effect) = ((square / whole).sqrt(), (turned / whole).sqrt());
        println!("deferred {deferred}: {error:.5} of {effect:.3}");
        // Light is linear between vertices, and has nine bits in deferred.
        assert!(error < if deferred { 3e-3 } else { 1.5e-3 }, "{error}");
        assert!(effect > 0.2, "nothing is turned: {effect}");
    }
}

fn gradient_at([x, y, _]: [f32; 3]) -> [f32; 3] {
    [700.0 * y, 500.0 - 300.0 * x, 400.0 + 100.0 * x * 2.0]
}

/// Wherever the mesh stands, and from whichever side it is seen.
#[test]
fn turned_mirrored_stretched_and_from_behind() {
    let half_turn = Quat::from_rotation_y(std::f32::consts::PI);
    for at in [
        Transform::IDENTITY,
        Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.7, -0.5, 0.3)),
        Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        Transform::from_scale(Vec3::new(0.5, 1.3, -2.0)).with_rotation(half_turn),
        Transform::from_rotation(half_turn),
        Transform::from_scale(Vec3::new(1.5, 0.7, 3.0))
            .with_rotation(Quat::from_rotation_x(0.4) * Quat::from_rotation_z(1.0)),
    ] {
        let world = Mat3::from_quat(at.rotation) * Mat3::from_diagonal(at.scale);
        let normal = (world.inverse().transpose() * Vec3::Z).normalize();
        let tangent = (world * Vec3::X).normalize();
        let bitangent = normal.cross(tangent) * world.determinant().signum();
        let gradient = tangent * 1500.0 - bitangent * 900.0 + normal * 600.0;
        let local = local_gradients(
            DMat3::from_cols_array(&world.to_cols_array().map(f64::from)),
            &[gradient],
        );
        let local = local.unwrap()[0];
        let texel = TEXELS[0];
        let picture = on_stage(move |stage| {
            stage.shoot(
                |_| (),
                |world| {
                    let normal_map_texture = Some(add(world, normal_map(&[texel])));
                    let base = StandardMaterial {
                        normal_map_texture,
                        double_sided: true,
                        cull_mode: None,
                        ..default()
                    };
                    let mesh = with_gradient(with_tangents(lit(grid(), LIGHT)), local);
                    show_fresco(world, mesh, base, at);
                },
            )
        });
        let [x, y, z] = decoded(texel).to_array();
        let bumped = (tangent * x + bitangent * y + normal * z).normalize();
        let expected = reshade(LIGHT, gradient, normal, bumped);
        let found = Vec3::from(picture.at(0.5, 0.5)) / exposure();
        println!("{found} for {expected}");
        assert!((expected / LIGHT - 1.0).min_element() > 0.5);
        assert!(((found - expected) / expected).abs().max_element() < 5e-3);
    }
}

/// Without a normal map, or without tangents for it, gradients change nothing at all.
#[test]
fn what_turns_no_normals_is_as_before() {
    let picture = |map: bool, tangents: bool, gradient: bool| {
        on_stage(move |stage| {
            stage.shoot(
                |_| (),
                |world| {
                    let normal_map_texture = map.then(|| add(world, normal_map(&TEXELS)));
                    let base = StandardMaterial {
                        normal_map_texture,
                        ..default()
                    };
                    let mut mesh = grid_lit_unevenly();
                    if tangents {
                        mesh = with_tangents(mesh);
                    }
                    if gradient {
                        mesh = with_gradient(mesh, Vec3::splat(400.0));
                    }
                    show_fresco(world, mesh, base, default());
                },
            )
        })
    };
    for (map, tangents) in [(false, true), (true, false)] {
        let apart = picture(map, tangents, true);
        let apart = apart.greatest_difference(&picture(map, tangents, false));
        assert_eq!(apart, 0.0, "map {map}, tangents {tangents}");
    }
    let with = picture(true, true, true);
    assert!(with.distance(&picture(true, true, false)) > 0.1);
}
