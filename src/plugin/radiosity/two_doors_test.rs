//! One glTF file read by Bevy's loader and by this crate's own gives the same scene and the same light.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::mem::discriminant;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::gltf::GltfAssetLabel;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy::world_serialization::WorldAssetRoot;

use super::assets::Sources;
use super::components::StaticLighting;
use super::scene::{Names, extract};
use super::settings::RadiositySettings;
use super::survey::StaticWorld;
use super::textures::Textures;
use crate::gltf;
use crate::plugin::FrescoPlugins;
use crate::radiosity::{Bake, BakeSettings, Light, LightKind, Object, Scene, bake};

/// All of Bevy but a window and a graphics card.
pub(in crate::plugin) fn app() -> App {
    let mut app = App::new();
    let no_gpu = WgpuSettings {
        backends: None,
        ..default()
    };
    app.add_plugins(
        DefaultPlugins
            .set(RenderPlugin {
                render_creation: RenderCreation::Automatic(Box::new(no_gpu)),
                ..default()
            })
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(AssetPlugin {
                file_path: Path::new(env!("CARGO_MANIFEST_DIR"))
                    .join("assets")
                    .display()
                    .to_string(),
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<bevy::log::LogPlugin>(),
    )
    .add_plugins(FrescoPlugins)
    // glTF's emissive is in cd/m².
    .insert_resource(RadiositySettings {
        emissive_gain: 1.0,
        automatic: false,
        ..default()
    });
    app.finish();
    app.cleanup();
    app
}

/// The scene as the plugin extracts it from what Bevy's loader spawned.
fn by_bevy(path: &'static str) -> Scene {
    let mut app = app();
    let scene = app
        .world()
        .resource::<AssetServer>()
        .load(GltfAssetLabel::Scene(0).from_asset(path));
    app.world_mut()
        .spawn((WorldAssetRoot(scene), StaticLighting::default()));
    let since = Instant::now();
    loop {
        app.update();
        assert!(
            since.elapsed() < Duration::from_secs(60),
            "{path} does not load"
        );
        let found = app
            .world_mut()
            .run_system_cached(
                |world: StaticWorld, mut sources: Sources, settings: Res<RadiositySettings>| {
                    let view = crate::plugin::FrescoView::Shaded;
                    let survey = world.survey(&mut sources, &settings, view);
                    assert!(survey.to_tell.is_empty(), "{:?}", survey.to_tell);
                    if survey.loading || survey.objects.is_empty() {
                        return None;
                    }
                    let names = Names {
                        objects: survey
                            .objects
                            .iter()
                            .map(|o| world.name(o.entity))
                            .collect(),
                        lights: survey.lights.iter().map(|l| world.name(l.entity)).collect(),
                    };
                    let gain = settings.emissive_gain;
                    let extracted = extract(&survey, &names, gain, &mut Textures::default());
                    let extracted = extracted.unwrap();
                    assert!(extracted.notes.is_empty(), "{:?}", extracted.notes);
                    Some(extracted.scene)
                },
            )
            .unwrap();
        if let Some(scene) = found {
            return scene;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn by_file(path: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("assets")
        .join(path);
    gltf::load(&path).unwrap().scene
}

/// Gives the plugin's objects the file's order and keys: rays are drawn by them.
fn in_order_of(file: &Scene, mut bevy: Scene) -> Scene {
    let mut left = std::mem::take(&mut bevy.objects);
    for wanted in &file.objects {
        let found = left
            .iter()
            .position(|o| same_geometry(o, wanted))
            .unwrap_or_else(|| panic!("{} is not among {:?}", wanted.name, names(&left)));
        bevy.objects.push(Object {
            key: wanted.key,
            ..left.remove(found)
        });
    }
    assert!(left.is_empty(), "{:?}", names(&left));
    bevy
}

fn names(objects: &[Object]) -> Vec<&str> {
    objects.iter().map(|o| o.name.as_str()).collect()
}

fn same_geometry(a: &Object, b: &Object) -> bool {
    let near = |a: &[Vec3], b: &[Vec3]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.abs_diff_eq(*b, 2e-5))
    };
    a.triangles == b.triangles && near(&a.positions, &b.positions)
}

fn check_objects(file: &Scene, bevy: &Scene) {
    for (a, b) in file.objects.iter().zip(&bevy.objects) {
        let name = &a.name;
        for (m, n) in a.normals.iter().zip(&b.normals) {
            assert!(m.abs_diff_eq(*n, 1e-4), "{name}: {m} {n}");
        }
        assert_eq!(a.normals.len(), b.normals.len(), "{name}");
        assert_eq!(a.colors.len(), b.colors.len(), "{name}");
        for (m, n) in a.colors.iter().zip(&b.colors) {
            assert!(m.abs_diff_eq(*n, 1e-3), "{name}: {m} {n}");
        }
        for (set, uvs) in a.uvs.iter().enumerate() {
            for (m, n) in uvs.iter().zip(&b.uvs[set]) {
                assert!(m.abs_diff_eq(*n, 1e-5), "{name}: {m} {n}");
            }
        }
        let (m, n) = (
            &file.materials[a.material.0 as usize],
            &bevy.materials[b.material.0 as usize],
        );
        assert!(
            m.base_color.abs_diff_eq(n.base_color, 1e-5),
            "{name}: {m:?} {n:?}"
        );
        assert!(
            m.emissive.abs_diff_eq(n.emissive, 1e-3),
            "{name}: {m:?} {n:?}"
        );
        assert!((m.metallic - n.metallic).abs() < 1e-6, "{name}");
        assert_eq!(
            (m.double_sided, m.alpha, m.unlit),
            (n.double_sided, n.alpha, n.unlit),
            "{name}"
        );
        assert_eq!(
            m.base_color_texture.map(|t| texels(file, t.texture.0)),
            n.base_color_texture.map(|t| texels(bevy, t.texture.0)),
            "{name}"
        );
    }
}

fn texels(scene: &Scene, texture: u32) -> (&[[u8; 4]], [crate::radiosity::Wrap; 2]) {
    let texture = &scene.textures[texture as usize];
    (&texture.texels, texture.wrap)
}

/// What Bevy takes where the file gives no range.
fn by_default(range: f32) -> f32 {
    if range.is_finite() { range } else { 20.0 }
}

/// Bevy's loader reads a light's linear colour as if it were sRGB.
fn check_lights(file: &[Light], bevy: &[Light]) {
    assert_eq!(file.len(), bevy.len());
    for a in file {
        let same = |b: &&Light| discriminant(&a.kind) == discriminant(&b.kind);
        let b = bevy.iter().find(same).unwrap();
        match (a.kind, b.kind) {
            (LightKind::Directional { direction: d }, LightKind::Directional { direction: e }) => {
                assert!(d.normalize().abs_diff_eq(e, 1e-5), "{d} {e}");
            }
            (
                LightKind::Point { position: p, range },
                LightKind::Point {
                    position: q,
                    range: s,
                },
            ) => {
                assert!(p.abs_diff_eq(q, 1e-5), "{p} {q}");
                assert_eq!(s, by_default(range));
            }
            (
                LightKind::Spot {
                    position: p,
                    direction: d,
                    inner_angle: i,
                    outer_angle: o,
                    range,
                },
                LightKind::Spot {
                    position: q,
                    direction: e,
                    inner_angle: j,
                    outer_angle: u,
                    range: s,
                },
            ) => {
                assert!(p.abs_diff_eq(q, 1e-5), "{p} {q}");
                assert!(d.normalize().abs_diff_eq(e, 1e-5), "{d} {e}");
                assert_eq!((i, o, by_default(range)), (j, u, s));
            }
            other => panic!("{other:?}"),
        }
        let strongest = a.power.max_element();
        let as_srgb = |c: f32| Color::srgb(c / strongest, 0.0, 0.0).to_linear().red * strongest;
        let wanted = Vec3::new(as_srgb(a.power.x), as_srgb(a.power.y), as_srgb(a.power.z));
        assert!(
            b.power.abs_diff_eq(wanted, 1e-3 * strongest),
            "{wanted} {}",
            b.power
        );
    }
}

fn light(bake: &Bake) -> Vec<Vec3> {
    bake.objects.iter().flat_map(|o| o.light.clone()).collect()
}

fn check(path: &'static str) {
    let file = by_file(path);
    let mut bevy = in_order_of(&file, by_bevy(path));
    check_objects(&file, &bevy);
    check_lights(&file.lights, &bevy.lights);
    // The difference that is Bevy's, and known, out of the way.
    bevy.lights.clone_from(&file.lights);
    let settings = BakeSettings {
        refine: false,
        ..BakeSettings::BALANCED
    };
    let a = light(&bake(&file.validate().unwrap(), &settings, &()).unwrap());
    let b = light(&bake(&bevy.validate().unwrap(), &settings, &()).unwrap());
    assert_eq!(a.len(), b.len());
    let gap: f32 = a.iter().zip(&b).map(|(a, b)| a.distance_squared(*b)).sum();
    let level: f32 = a.iter().map(|a| a.length_squared()).sum();
    let relative = (gap / level).sqrt();
    assert!(relative < 0.005, "{path}: light differs by {relative}");
}

#[test]
fn a_box_with_a_lamp() {
    check("scenes/cornell_box.glb");
}

#[test]
fn a_courtyard_with_sun_textures_and_mirrored_benches() {
    check("scenes/courtyard.glb");
}
