//! Bump test 15: what a bump needs and does not have. Surfaces are smooth, and it is told, once.

use bevy::prelude::*;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage, Parallax};

use super::{bump, error, on_plane, relief, show, waves_map, waves_on_grid};
use crate::scenery::{add, checker, grid};
use crate::stage::on_stage;

type Make = fn(&mut World) -> (Mesh, Bump);

fn without_uvs(world: &mut World) -> (Mesh, Bump) {
    let mut mesh = grid();
    mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
    mesh.remove_attribute(Mesh::ATTRIBUTE_UV_1);
    (
        mesh,
        bump(world, waves_map([64; 2]), BumpHeight::World(0.2)),
    )
}

fn without_map(_: &mut World) -> (Mesh, Bump) {
    (grid(), Bump::new(default(), BumpHeight::World(0.2)))
}

fn constant(world: &mut World) -> (Mesh, Bump) {
    let map = relief([8, 4], Wrap::Repeat, |_, _| 0.7);
    (grid(), bump(world, map, BumpHeight::World(0.2)))
}

fn single(world: &mut World) -> (Mesh, Bump) {
    let map = relief([1, 1], Wrap::Clamp, |_, _| 0.7);
    (grid(), bump(world, map, BumpHeight::World(0.2)))
}

/// No such file.
fn no_file(world: &mut World) -> (Mesh, Bump) {
    let map = world
        .resource::<AssetServer>()
        .load("textures/there_is_none.png");
    (grid(), Bump::new(map, BumpHeight::World(0.2)))
}

/// A file that is no image.
fn no_image(world: &mut World) -> (Mesh, Bump) {
    let map = world.resource::<AssetServer>().load("scenes/furnace.glb");
    (grid(), Bump::new(map, BumpHeight::World(0.2)))
}

#[test]
fn what_is_missing_leaves_surfaces_smooth() {
    let cases: [(&str, Make, &str); 6] = [
        ("no texture coordinates", without_uvs, "UV_0"),
        ("no map", without_map, "does not exist"),
        ("a constant map", constant, "as high everywhere"),
        ("a map of one texel", single, "as high everywhere"),
        ("no file", no_file, "could not be loaded"),
        ("no image", no_image, "could not be loaded"),
    ];
    for (name, make, told) in cases {
        for parallax in [None, Some(Parallax::default())] {
            assert_smooth(name, make, told, parallax);
        }
    }
}

/// The mesh with the bump shows the same light as without, and it is told once why.
fn assert_smooth(name: &'static str, make: Make, told: &'static str, parallax: Option<Parallax>) {
    on_stage(move |stage| {
        // Bevy tells of files that cannot be loaded, too.
        stage.expected_errors = &["there_is_none.png", "furnace.glb"];
        // Without any bump Bevy's own shader draws, which shows light: so light is compared.
        let mut shoot = |has_bump: bool| {
            stage.shoot(
                // Aslant, so that parallax would show.
                |camera| {
                    let aside = Transform::from_xyz(1.5, 0.5, 2.5);
                    camera.insert(aside.looking_at(Vec3::ZERO, Vec3::Y));
                },
                |world| {
                    world.insert_resource(GlobalAmbientLight {
                        brightness: 1000.0,
                        ..default()
                    });
                    let light = Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
                    world.spawn((DirectionalLight::default(), light));
                    let (mesh, mut bump) = make(world);
                    bump.parallax = parallax.clone();
                    let base = StandardMaterial {
                        base_color_texture: Some(add(world, checker())),
                        ..default()
                    };
                    let entity = show(world, mesh, base, has_bump.then_some(bump), default());
                    world.entity_mut(entity).insert(Name::new("the wall"));
                },
            )
        };
        let smooth = shoot(false);
        let found = shoot(true);
        let apart = found.distance(&smooth);
        println!("{name}: {apart:.6}");
        assert!(apart < 1e-3, "{name}: {apart}");
        let mut about = Vec::new();
        // Files come when they come.
        for _ in 0..20 {
            let warnings = stage.warnings();
            about = warnings
                .into_iter()
                .filter(|w| w.contains("the wall"))
                .collect();
            if !about.is_empty() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(50));
            stage.change(|_| ());
        }
        assert_eq!(about.len(), 1, "{name}: {:?}", stage.warnings());
        assert!(about[0].contains(told), "{name}: {about:?}");
    });
}

/// A map that comes after the material was first drawn, and then another in its place.
#[test]
fn maps_may_come_late_and_change() {
    on_stage(|stage| {
        stage.show_normals(true);
        let mut map: Handle<HeightImage> = default();
        let smooth = stage.shoot(
            |_| (),
            |world| {
                map = world.resource::<Assets<HeightImage>>().reserve_handle();
                let late = Bump::new(map.clone(), BumpHeight::World(0.15));
                show(world, grid(), default(), Some(late), default());
            },
        );
        let (most, _) = error(&smooth, |_| Some(Vec3::Z));
        assert!(most < 0.01, "{most}°");
        for height in [1.0_f32, -0.5] {
            let id = map.id();
            let picture = stage.change(move |world| {
                let waves = relief([256; 2], Wrap::Repeat, |u, v| {
                    height * super::waves(Vec2::new(u, v)).0
                });
                world
                    .resource_mut::<Assets<HeightImage>>()
                    .insert(id, waves)
                    .unwrap();
            });
            let truth = |i: usize| Some(waves_on_grid(on_plane(&picture, i), 0.15 * height));
            let (most, _) = error(&picture, truth);
            println!("waves of {height}: {most:.3}°");
            assert!(most < 0.1, "{most}°");
        }
    });
}

/// Maps that are no squares, and of sizes that are no powers of two.
#[test]
fn maps_of_any_size_are_right() {
    // Waves of 40 to 50 texels, where slopes lie half-way between cubic and straight. And minified: filters blur
    // waves of 32 pixels, the more the less square texels are. A wrong side would be off by tens of degrees.
    let cases = [
        ([48, 80], 0.4),
        ([96, 64], 0.4),
        ([256, 128], 0.5),
        ([200, 333], 1.0),
        ([97, 512], 1.5),
    ];
    for (size, limit) in cases {
        let picture = on_stage(move |stage| {
            stage.show_normals(true);
            stage.shoot(
                |_| (),
                |world| {
                    let waves = bump(world, waves_map(size), BumpHeight::World(0.15));
                    show(world, grid(), default(), Some(waves), default());
                },
            )
        });
        let truth = |i: usize| Some(waves_on_grid(on_plane(&picture, i), 0.15));
        let (most, mean) = error(&picture, truth);
        println!("{size:?}: {most:.3}° at most, {mean:.3}° RMS");
        assert!(most < limit, "{size:?}: {most}°");
    }
}
