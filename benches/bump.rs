//! What a bump costs to draw, beside Bevy's standard material with a normal map of the same relief: one
//! wall that fills the picture, one material after the other, many times over in one run.
//!
//! ```text
//! cargo bench --all-features --profile test --bench bump
//! ```
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a benchmark prints, and may stop"
)]

use std::f32::consts::TAU;
use std::time::Instant;

use bevy::asset::RenderAssetUsages;
use bevy::camera::{Hdr, RenderTarget};
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{
    Extent3d, PollType, TextureDimension, TextureFormat, TextureUsages,
};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice};
use bevy::render::view::Msaa;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::{
    Bump, BumpFilter, BumpHeight, HeightImage, Parallax, insert_uv_gradients,
};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoMaterialPlugin};

/// Pixels and texels on a side.
const PIXELS: u32 = 512;
const TEXELS: u32 = 512;
const ROUNDS: usize = 40;

fn main() {
    let mut app = app();
    let walls = walls(app.world_mut());
    // Shaders are made and textures sent.
    for _ in 0..3 {
        for (_, wall) in &walls {
            for _ in 0..3 {
                frame(&mut app, &walls, *wall);
            }
        }
    }
    let mut times = vec![Vec::new(); walls.len()];
    for _ in 0..ROUNDS {
        for (i, (_, wall)) in walls.iter().enumerate() {
            times[i].push(frame(&mut app, &walls, *wall));
        }
    }
    let adapter = app
        .sub_app(RenderApp)
        .world()
        .resource::<RenderAdapterInfo>();
    println!(
        "{}, {PIXELS} × {PIXELS} pixels, {ROUNDS} rounds",
        adapter.name
    );
    println!("ms a frame                     median   to the normal map");
    let base = &times[1];
    for ((name, _), times) in walls.iter().zip(&times) {
        let ratios = times.iter().zip(base).map(|(t, b)| t / b);
        println!(
            "{name:28} {:8.2} {:10.3}",
            median(times),
            median(&ratios.collect::<Vec<_>>())
        );
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
        FrescoMaterialPlugin,
    ));
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    let mut image = Image::new_target_texture(PIXELS, PIXELS, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = world.resource_mut::<Assets<Image>>().add(image);
    world.spawn((
        Camera3d::default(),
        RenderTarget::from(target),
        Transform::from_xyz(0.0, 0.0, 2.0),
        Msaa::Off,
        Hdr,
    ));
    let above = Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((DirectionalLight::default(), above));
    app
}

/// Milliseconds of a frame with one of the walls, to its last pixel.
fn frame(app: &mut App, walls: &[(&str, Entity)], shown: Entity) -> f64 {
    for (_, wall) in walls {
        let seen = if *wall == shown {
            Visibility::Visible
        } else {
            Visibility::Hidden
        };
        app.world_mut().entity_mut(*wall).insert(seen);
    }
    let start = Instant::now();
    app.update();
    let device = app.sub_app(RenderApp).world().resource::<RenderDevice>();
    device.poll(PollType::wait_indefinitely()).unwrap();
    start.elapsed().as_secs_f64() * 1e3
}

fn height(u: f32, v: f32) -> f32 {
    (TAU * 8.0 * u).sin() * (TAU * 8.0 * v).cos()
}

/// The standard material plain and with a normal map, and ours in all ways to bump.
fn walls(world: &mut World) -> Vec<(&'static str, Entity)> {
    let mut images = world.resource_mut::<Assets<Image>>();
    let (normals, depths) = (images.add(normal_map()), images.add(depth_map()));
    let texels = (0..TEXELS * TEXELS).map(|i| {
        let [x, y] = [i % TEXELS, i / TEXELS].map(|x| (x as f32 + 0.5) / TEXELS as f32);
        height(x, y)
    });
    let map = HeightMap::new([TEXELS; 2], texels.collect(), [Wrap::Repeat; 2]).unwrap();
    let map = world
        .resource_mut::<Assets<HeightImage>>()
        .add(HeightImage::new(map));
    let plane = Mesh::from(Rectangle::new(3.0, 3.0))
        .with_generated_tangents()
        .unwrap();
    let mut exact = plane.clone();
    insert_uv_gradients(&mut exact).unwrap();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let [plane, exact] = [plane, exact].map(|mesh| meshes.add(mesh));

    // The map lies on the wall several times, so that texels are about as large as pixels, or is magnified.
    let repeated = |times: f32| StandardMaterial {
        uv_transform: Affine2::from_scale(Vec2::splat(times)),
        ..default()
    };
    let mut standard = |mesh: &Handle<Mesh>, normal_map_texture| {
        let material = StandardMaterial {
            normal_map_texture,
            ..repeated(3.0)
        };
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(material);
        world
            .spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material)))
            .id()
    };
    let mut walls = vec![
        ("standard", standard(&plane, None)),
        (
            "standard, normal map",
            standard(&plane, Some(normals.clone())),
        ),
    ];
    let cubic = Bump::new(map, BumpHeight::Uv(0.005));
    let bump = Bump {
        filter: BumpFilter::Linear,
        ..cubic.clone()
    };
    let curved = Bump {
        curvature: true,
        ..bump.clone()
    };
    let mut ours =
        |name, mesh: &Handle<Mesh>, times, bump: Option<&Bump>, detail: Option<&Bump>| {
            let material = FrescoMaterial {
                base: repeated(times),
                extension: FrescoExtension {
                    bump: bump.cloned(),
                    detail: detail.cloned(),
                    ..default()
                },
            };
            let material = world.resource_mut::<Assets<FrescoMaterial>>().add(material);
            let wall = world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material)));
            walls.push((name, wall.id()));
        };
    ours("without bump", &plane, 3.0, None, None);
    ours("bump", &plane, 3.0, Some(&bump), None);
    ours(
        "bump, gradients of the mesh",
        &exact,
        3.0,
        Some(&bump),
        None,
    );
    ours("bump, with detail", &plane, 3.0, Some(&bump), Some(&bump));
    ours("bump, with curvature", &plane, 3.0, Some(&curved), None);
    ours("bump, cubic", &plane, 3.0, Some(&cubic), None);
    ours("bump, cubic, magnified", &plane, 0.3, Some(&cubic), None);
    // Deep relief at 60° (heights are −1 to 1), beside Bevy's own parallax with its 16 layers.
    let deep = Bump {
        height: BumpHeight::Uv(0.05),
        ..bump
    };
    let seen = Bump {
        parallax: Some(Parallax::default()),
        ..deep.clone()
    };
    ours("aslant, bump", &plane, 3.0, Some(&deep), None);
    ours("aslant, bump with parallax", &plane, 3.0, Some(&seen), None);
    let bevys = StandardMaterial {
        normal_map_texture: Some(normals),
        depth_map: Some(depths),
        parallax_depth_scale: 0.1,
        ..repeated(3.0)
    };
    let bevys = world.resource_mut::<Assets<StandardMaterial>>().add(bevys);
    let wall = world.spawn((Mesh3d(plane), MeshMaterial3d(bevys)));
    walls.push(("aslant, Bevy's parallax", wall.id()));
    let aslant = Transform::from_rotation(Quat::from_rotation_x(-TAU / 6.0));
    for (name, wall) in &walls {
        if name.starts_with("aslant") {
            // Large enough to fill the picture all the same.
            let at = aslant.with_scale(Vec3::splat(3.0));
            world.entity_mut(*wall).insert(at);
        }
    }
    walls
}

/// Depths of the same relief, for Bevy's parallax.
fn depth_map() -> Image {
    let texel = |i: u32| {
        let [x, y] = [i % TEXELS, i / TEXELS].map(|x| (x as f32 + 0.5) / TEXELS as f32);
        let depth = (127.5 - 127.5 * height(x, y)) as u8;
        [depth, depth, depth, 255]
    };
    repeated_image((0..TEXELS * TEXELS).flat_map(texel).collect())
}

fn normal_map() -> Image {
    let texel = |i: u32| {
        let at = |dx: f32, dy: f32| {
            let x = ((i % TEXELS) as f32 + 0.5 + dx) / TEXELS as f32;
            let y = ((i / TEXELS) as f32 + 0.5 + dy) / TEXELS as f32;
            0.005 * height(x, y) * TEXELS as f32
        };
        let n = Vec3::new(
            at(-0.5, 0.0) - at(0.5, 0.0),
            at(0.0, 0.5) - at(0.0, -0.5),
            1.0,
        );
        let [x, y, z] = (n.normalize() * 0.5 + 0.5)
            .to_array()
            .map(|c| (c * 255.0).round() as u8);
        [x, y, z, 255]
    };
    repeated_image((0..TEXELS * TEXELS).flat_map(texel).collect())
}

fn repeated_image(texels: Vec<u8>) -> Image {
    let size = Extent3d {
        width: TEXELS,
        height: TEXELS,
        depth_or_array_layers: 1,
    };
    let format = TextureFormat::Rgba8Unorm;
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new(size, TextureDimension::D2, texels, format, usage);
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}
