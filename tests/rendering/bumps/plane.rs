//! Bumps of a plane: signs, mirrors, other texture coordinates, other triangles.

use bevy::math::{Affine2, Mat2};
use bevy::mesh::UvChannel;
use bevy::prelude::*;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::FrescoMaterial;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, insert_uv_gradients};

use super::{
    bump, error, normal, on_plane, relief, seen_from_everywhere, sheet, show, waves_map,
    waves_on_grid,
};
use crate::picture::Picture;
use crate::scenery::grid;
use crate::stage::on_stage;

const HEIGHT: f32 = 0.15;

/// Normals of a mesh in waves, changed as it may be.
fn shoot(
    mesh: Mesh,
    at: Transform,
    base: StandardMaterial,
    change: impl FnOnce(&mut Bump) + Send + 'static,
) -> Picture {
    on_stage(move |stage| {
        stage.show_normals(true);
        stage.shoot(
            |_| (),
            |world| {
                let mut waves = bump(world, waves_map([256; 2]), BumpHeight::World(HEIGHT));
                change(&mut waves);
                show(world, mesh, base, Some(waves), at);
            },
        )
    })
}

fn exact(mut mesh: Mesh) -> Mesh {
    insert_uv_gradients(&mut mesh).unwrap();
    mesh
}

#[track_caller]
fn assert_waves(name: &str, picture: &Picture, limit: f32) {
    let (most, mean) = error(picture, |i| {
        Some(waves_on_grid(on_plane(picture, i), HEIGHT))
    });
    println!("{name}: {most:.3}° at most, {mean:.3}° RMS");
    if most >= limit {
        picture.save(name);
    }
    assert!(most < limit, "{name}: {most}°");
}

/// Bump test 1: `n' = normalize(−hx, −hy, 1)`, by derivatives on the screen and by those of the mesh.
#[test]
fn a_plane_has_the_normals_of_the_relief() {
    let picture = shoot(grid(), default(), default(), |_| ());
    assert_waves("screen", &picture, 0.1);
    let picture = shoot(exact(grid()), default(), default(), |_| ());
    assert_waves("mesh", &picture, 0.1);
}

/// Bump test 4: a mirrored mesh, and the mesh under a negative scale, have the mirrored relief.
#[test]
fn what_is_mirrored_has_mirrored_relief() {
    let mirrored_mesh = || {
        sheet(8, |p| {
            let at = Vec3::new(1.0 - 2.0 * p.x, 1.0 - 2.0 * p.y, 0.0);
            (at, Vec3::Z, p)
        })
    };
    let mirror = Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let truth = shoot(grid(), default(), default(), |_| ());
    for (name, mesh, at) in [
        ("scale", grid(), mirror),
        ("scale, mesh's", exact(grid()), mirror),
        ("mesh", mirrored_mesh(), default()),
        ("mesh, mesh's", exact(mirrored_mesh()), default()),
    ] {
        let picture = shoot(mesh, at, seen_from_everywhere(), |_| ());
        let n = picture.size;
        let reflected = |i: usize| {
            let found = normal(&truth, i / n * n + (n - 1 - i % n));
            Some(found * Vec3::new(-1.0, 1.0, 1.0))
        };
        let (most, _) = error(&picture, reflected);
        println!("{name}: {most:.4}°");
        assert!(most < 0.05, "{name}: {most}°");
    }
    // Texture coordinates the other way round, and a map that was turned round with them.
    let mut mesh = grid();
    if let Some(bevy::mesh::VertexAttributeValues::Float32x2(uvs)) =
        mesh.attribute_mut(Mesh::ATTRIBUTE_UV_0)
    {
        uvs.iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
    }
    for mesh in [mesh.clone(), exact(mesh)] {
        let picture = shoot(mesh, default(), default(), |bump| {
            bump.uv_transform =
                Affine2::from_mat2_translation(Mat2::from_diagonal(Vec2::new(-1.0, 1.0)), Vec2::X);
        });
        // Against the closed form, not against a picture of the same: so it has the error of the map as well,
        // as in test 1.
        assert_waves("mirrored texture coordinates", &picture, 0.1);
    }
}

/// Bump test 5: the same relief of the world through texture coordinates that are sheared and squeezed.
#[test]
fn other_texture_coordinates_give_the_same_relief() {
    let hill = |at: Vec2| 0.3 * (-3.0 * (at - Vec2::new(0.1, -0.2)).length_squared()).exp();
    let truth = move |at: Vec2| {
        let slope = -6.0 * hill(at) * (at - Vec2::new(0.1, -0.2));
        Vec3::new(-slope.x, -slope.y, 1.0).normalize()
    };
    let straight = Affine2::from_scale_angle_translation(Vec2::splat(0.4), 0.0, Vec2::splat(0.5));
    let sheared = Affine2::from_mat2_translation(
        Mat2::from_cols(Vec2::new(0.35, -0.1), Vec2::new(-0.12, -0.2)),
        Vec2::splat(0.5),
    );
    for (name, unwrap) in [("straight", straight), ("sheared", sheared)] {
        for has_gradients in [false, true] {
            let picture = on_stage(move |stage| {
                stage.show_normals(true);
                stage.shoot(
                    |_| (),
                    |world| {
                        let back = unwrap.inverse();
                        let map = relief([1024; 2], Wrap::Clamp, |u, v| {
                            hill(back.transform_point2(Vec2::new(u, v)))
                        });
                        let hill = bump(world, map, BumpHeight::World(1.0));
                        let mut mesh = sheet(4, |p| {
                            let at = Vec2::new(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y);
                            (at.extend(0.0), Vec3::Z, unwrap.transform_point2(at))
                        });
                        if has_gradients {
                            mesh = exact(mesh);
                        }
                        show(world, mesh, default(), Some(hill), default());
                    },
                )
            });
            let (most, mean) = error(&picture, |i| Some(truth(on_plane(&picture, i))));
            println!("{name}: {most:.3}° at most, {mean:.3}° RMS");
            assert!(most < 0.2, "{name}: {most}°");
        }
    }
}

/// Bump test 7: one quad and 64 × 64 pairs of triangles that share no lines of pixels, pixel by pixel.
#[test]
fn edges_of_triangles_do_not_show() {
    let one = sheet(1, |p| {
        (Vec3::new(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, 0.0), Vec3::Z, p)
    });
    let jittered = sheet(64, |p| {
        let inside = p.cmpgt(Vec2::ZERO) & p.cmplt(Vec2::ONE);
        let noise = (p * Vec2::new(913.7, 457.3) + p.yx() * 311.9).fract() - 0.5;
        let p = p + Vec2::select(inside, noise * 0.8 / 64.0, Vec2::ZERO);
        (Vec3::new(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, 0.0), Vec3::Z, p)
    });
    let truth = shoot(one, default(), default(), |_| ());
    for mesh in [jittered.clone(), exact(jittered)] {
        let picture = shoot(mesh, default(), default(), |_| ());
        let (most, _) = error(&picture, |i| Some(normal(&truth, i)));
        println!("{most:.4}°");
        assert!(most < 0.1, "{most}°");
    }
}

/// Transforms of the standard material and of the bump, one after the other.
#[test]
fn transforms_of_texture_coordinates_are_followed() {
    let of_base =
        Affine2::from_scale_angle_translation(Vec2::new(0.5, 0.25), 0.4, Vec2::new(0.3, 0.1));
    let base = StandardMaterial {
        uv_transform: of_base,
        ..default()
    };
    for mesh in [grid(), exact(grid())] {
        let picture = shoot(mesh, default(), base.clone(), move |bump| {
            bump.uv_transform = of_base.inverse();
        });
        assert_waves("there and back", &picture, 0.1);
    }
}

/// The second texture coordinates, which lie a little off the first.
#[test]
fn the_other_texture_coordinates_can_be_chosen() {
    let mut mesh = grid();
    let swapped = mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0).unwrap();
    let count = mesh.count_vertices();
    let mesh = mesh
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, swapped)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; count]);
    let picture = shoot(mesh, default(), default(), |bump| {
        bump.uv_channel = UvChannel::Uv1;
    });
    assert_waves("UV_1", &picture, 0.1);
}

/// Two bumps add up, and a negative height is the positive one upside down.
#[test]
fn bumps_add_up() {
    let both = |main: f32, detail: f32| {
        on_stage(move |stage| {
            stage.show_normals(true);
            stage.shoot(
                |_| (),
                |world| {
                    let bumps = [main, detail].map(|share| {
                        bump(
                            world,
                            waves_map([256; 2]),
                            BumpHeight::World(HEIGHT * share),
                        )
                    });
                    show(world, grid(), default(), None, default());
                    let mut materials = world.resource_mut::<Assets<FrescoMaterial>>();
                    for (_, material) in materials.iter_mut() {
                        material.extension.bump = Some(bumps[0].clone());
                        material.extension.detail = Some(bumps[1].clone());
                    }
                },
            )
        })
    };
    assert_waves("both", &both(0.7, 0.3), 0.1);
    assert_waves("more and less", &both(1.8, -0.8), 0.1);
}

/// Bump test 12: seen from behind, a double-sided surface has the front's normal turned round, with tangents
/// and without.
#[test]
fn backs_have_the_normals_of_fronts_turned_round() {
    let around = Transform::from_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    let base = || StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    let with_tangents = grid().with_generated_tangents().unwrap();
    for (name, mesh) in [
        ("without tangents", grid()),
        ("with tangents", with_tangents),
    ] {
        let picture = shoot(mesh, around, base(), |_| ());
        // From behind one sees the plane mirrored; turning takes x and z the other way, the side both back.
        let truth = |i: usize| {
            let at = on_plane(&picture, i) * Vec2::new(-1.0, 1.0);
            Some(-(around.rotation * waves_on_grid(at, HEIGHT)))
        };
        let (most, _) = error(&picture, truth);
        println!("{name}: {most:.3}°");
        assert!(most < 0.1, "{name}: {most}°");
    }
}

/// Bevy's normal map and a bump: gradients of both add up. The map's own slopes are known, as it is of one
/// colour.
#[test]
fn normal_maps_add_to_bumps() {
    use bevy::asset::RenderAssetUsages;
    use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
    let tilt: Vec3 = Vec3::new(0.3, -0.2, 1.0).normalize();
    for height in [0.0, HEIGHT] {
        let picture = on_stage(move |stage| {
            stage.show_normals(true);
            stage.shoot(
                |_| (),
                |world| {
                    let texel = tilt.extend(1.0) * Vec4::new(0.5, 0.5, 0.5, 0.5) + 0.5;
                    let bytes = texel.to_array().map(f32::to_le_bytes).concat();
                    let map = crate::scenery::add(
                        world,
                        Image::new(
                            Extent3d::default(),
                            TextureDimension::D2,
                            bytes,
                            TextureFormat::Rgba32Float,
                            RenderAssetUsages::all(),
                        ),
                    );
                    let base = StandardMaterial {
                        normal_map_texture: Some(map),
                        ..default()
                    };
                    let waves = bump(world, waves_map([256; 2]), BumpHeight::World(height));
                    let mesh = grid().with_generated_tangents().unwrap();
                    show(world, mesh, base, Some(waves), default());
                },
            )
        });
        let truth = |i: usize| {
            let waves = waves_on_grid(on_plane(&picture, i), height);
            // Bevy's bitangent points up where v points down: along −v, +y.
            let both = waves.xy() / waves.z + tilt.xy() / tilt.z * Vec2::new(1.0, 1.0);
            Some(both.extend(1.0).normalize())
        };
        let (most, _) = error(&picture, truth);
        println!("normal map under a bump of {height} m: {most:.3}°");
        assert!(most < 0.1, "{most}°");
    }
}
