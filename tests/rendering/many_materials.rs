//! Many materials of one mesh: drawn in one batch where the device can bind all materials at once, and each by
//! itself where it cannot. Each must show what is its own, also after some went and others came.

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::{AsBindGroup, Extent3d, TextureDimension, TextureFormat};
use bevy::render::renderer::RenderDevice;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, Parallax};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial};

use crate::bumps::{degrees, normal, relief};
use crate::picture::Picture;
use crate::scenery::{add, grid, lit};
use crate::stage::{Stage, exposure, on_stage};

const LIGHT: Vec3 = Vec3::new(900.0, 500.0, 1300.0);
/// Materials on a side of the picture.
const SIDE: usize = 4;

/// What the material in a cell is, and different from all others of it. `generation`: of materials that came.
#[derive(Clone, Copy)]
struct Cell {
    x: usize,
    y: usize,
    generation: usize,
}

impl Cell {
    fn number(self) -> f32 {
        (self.x + SIDE * (self.y + SIDE * self.generation)) as f32
    }

    fn colour(self) -> Vec3 {
        let n = self.number();
        Vec3::new(0.3 + 0.01 * n, 0.9 - 0.015 * n, 0.5)
    }

    fn gain(self) -> f32 {
        0.5 + 0.02 * self.number()
    }

    /// Of the relief along u, metres a metre.
    fn slope(self) -> f32 {
        0.1 + 0.03 * self.number()
    }

    /// The base colour is half in the material and half in its texture.
    fn texture(self) -> Image {
        let texel = self.colour().sqrt().extend(1.0).to_array();
        Image::new(
            Extent3d::default(),
            TextureDimension::D2,
            texel.iter().flat_map(|v| v.to_le_bytes()).collect(),
            TextureFormat::Rgba32Float,
            RenderAssetUsages::all(),
        )
    }

    /// Adds a square of the mesh in a material of its own.
    fn show(self, world: &mut World, mesh: &Handle<Mesh>, look: Look) {
        let half = self.colour().sqrt();
        let base_color_texture = Some(add(world, self.texture()));
        // 1 m of texture is 2 m of mesh, of which a cell is a part.
        let size = 2.0 / SIDE as f32;
        let map = relief([8; 2], Wrap::Clamp, |u, _| u);
        let material = FrescoMaterial {
            base: StandardMaterial {
                base_color: Color::linear_rgb(half.x, half.y, half.z),
                base_color_texture,
                reflectance: 0.0,
                specular_transmission: look.transmission,
                ..default()
            },
            extension: FrescoExtension {
                bump: Some(Bump {
                    parallax: look.has_parallax.then(Parallax::default),
                    ..Bump::new(add(world, map), BumpHeight::World(self.slope() * size))
                }),
                baked_light_gain: self.gain(),
                ..default()
            },
        };
        let at = |i: usize| (2 * i + 1) as f32 / SIDE as f32 - 1.0;
        let material = MeshMaterial3d(add(world, material));
        let at = Transform::from_xyz(at(self.x), -at(self.y), 0.0);
        let at = at.with_scale(Vec3::splat(1.0 / SIDE as f32));
        world.spawn((Mesh3d(mesh.clone()), material, at, Shown(self)));
    }
}

/// What all materials of a picture have, and what it shows.
#[derive(Clone, Copy, Default)]
struct Look {
    shows_normals: bool,
    has_parallax: bool,
    transmission: f32,
}

#[derive(Component, Clone, Copy)]
struct Shown(Cell);

fn cells(generation: usize) -> impl Iterator<Item = Cell> {
    (0..SIDE * SIDE).map(move |i| Cell {
        x: i % SIDE,
        y: i / SIDE,
        generation,
    })
}

/// Each cell shows the material it has.
fn assert_own(stage: &mut Stage, name: &str, picture: &Picture, look: Look) {
    let mut shown = 0;
    for Shown(cell) in stage.world().query::<&Shown>().iter(stage.app().world()) {
        let cell = *cell;
        shown += 1;
        let pixels = picture.size / SIDE;
        let middle = (cell.y * pixels + pixels / 2) * picture.size + cell.x * pixels + pixels / 2;
        let found = normal(picture, middle);
        if look.shows_normals {
            let expected = Vec3::new(-cell.slope(), 0.0, 1.0);
            let off = degrees(found, expected);
            assert!(off < 0.1, "{name}, {}: {found}, {off}°", cell.number());
        } else {
            let colour = cell.colour() * (1.0 - look.transmission);
            let expected = colour * cell.gain() * LIGHT * exposure();
            let off = (found / expected - 1.0).abs().max_element();
            assert!(
                off < 0.01,
                "{name}, {}: {found} for {expected}",
                cell.number()
            );
        }
    }
    assert_eq!(shown, SIDE * SIDE);
}

/// Both pictures, of materials as they came, after half of them were exchanged, and after all were changed.
fn draw(look: Look) {
    on_stage(move |stage| {
        stage.show_normals(look.shows_normals);
        let mut mesh = Handle::default();
        let picture = stage.shoot(
            |_| (),
            |world| {
                mesh = add(world, lit(grid(), LIGHT));
                for cell in cells(0) {
                    cell.show(world, &mesh, look);
                }
            },
        );
        assert_own(stage, "as they came", &picture, look);
        let picture = stage.change(|world| {
            let old: Vec<_> = (world.query::<(Entity, &Shown)>().iter(world))
                .filter(|(_, Shown(cell))| (cell.x + cell.y) % 2 == 0)
                .map(|(entity, _)| entity)
                .collect();
            for entity in old {
                world.despawn(entity);
            }
            for cell in cells(1).filter(|cell| (cell.x + cell.y) % 2 == 0) {
                cell.show(world, &mesh, look);
            }
        });
        assert_own(stage, "half exchanged", &picture, look);
        let picture = stage.change(|world| {
            let mut materials = world.resource_mut::<Assets<FrescoMaterial>>();
            for (_, material) in materials.iter_mut() {
                material.base.double_sided ^= true;
            }
        });
        assert_own(stage, "changed", &picture, look);
        let device = stage
            .app()
            .sub_app(RenderApp)
            .world()
            .resource::<RenderDevice>();
        let at_once = FrescoMaterial::bindless_slot_count().is_some()
            && FrescoMaterial::bindless_supported(device);
        println!("bindless: {at_once}");
        // As Bevy's own material: else each of ours would cost a draw.
        assert_eq!(at_once, StandardMaterial::bindless_supported(device));
    });
}

#[test]
fn each_shows_its_colour() {
    draw(Look::default());
}

#[test]
fn each_shows_its_colour_where_light_goes_through() {
    draw(Look {
        transmission: 0.4,
        ..default()
    });
}

#[test]
fn each_shows_its_relief() {
    draw(Look {
        shows_normals: true,
        ..default()
    });
}

#[test]
fn each_shows_its_relief_from_the_side() {
    draw(Look {
        shows_normals: true,
        has_parallax: true,
        ..default()
    });
}
