//! The saved light among the assets is that of a bake as it is now, and fits its scene.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::gltf::GltfAssetLabel;
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;

use super::{LightBake, LitBy, LitByStatus};
use crate::plugin::radiosity::two_doors_test::app;
use crate::plugin::radiosity::{RadiositySettings, RadiosityStatus, StaticLighting};

const PATIENCE: Duration = Duration::from_secs(120);

/// What gives the box its light.
enum Root {
    Baked,
    Lit(LitBy),
}

/// An app with the Cornell box.
fn box_with(root: impl FnOnce(&AssetServer) -> Root) -> (App, Entity) {
    let mut app = app();
    app.insert_resource(RadiositySettings::default());
    let assets = app.world().resource::<AssetServer>().clone();
    let scene = assets.load(GltfAssetLabel::Scene(0).from_asset("scenes/cornell_box.glb"));
    let entity = app.world_mut().spawn(WorldAssetRoot(scene)).id();
    match root(&assets) {
        Root::Baked => app
            .world_mut()
            .entity_mut(entity)
            .insert(StaticLighting::default()),
        Root::Lit(by) => app.world_mut().entity_mut(entity).insert(by),
    };
    (app, entity)
}

fn update_until(app: &mut App, is_done: impl Fn(&World) -> bool) {
    let since = Instant::now();
    while !is_done(app.world()) {
        app.update();
        std::thread::sleep(Duration::from_millis(2));
        assert!(since.elapsed() < PATIENCE, "it takes too long");
    }
}

fn mean_of(light: &[[f32; 3]]) -> Vec3 {
    light.iter().map(|&l| Vec3::from(l)).sum::<Vec3>() / light.len() as f32
}

#[test]
fn saved_light_is_that_of_a_bake() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/cornell_box.light_bake");
    let saved = LightBake::from_bytes(&std::fs::read(file).unwrap()).unwrap();
    let (mut app, root) = box_with(|_| Root::Baked);
    update_until(&mut app, |world| {
        world.resource::<RadiosityStatus>().is_up_to_date()
    });
    let now = LightBake::of(app.world_mut(), root).unwrap();
    assert_eq!(now.len(), saved.len());
    for (a, b) in now.objects.iter().zip(&saved.objects) {
        assert_eq!(a.identity, b.identity);
        // Which rays are drawn depends on the numbers of entities: meshes are not the same to the vertex.
        let [count, old] = [a, b].map(|object| object.light.len() as f32);
        assert!(
            (count / old - 1.0).abs() < 0.2,
            "{count} for {old} vertices"
        );
        let [mean, old] = [a, b].map(|object| mean_of(&object.light));
        let apart = (mean - old).length() / old.length();
        assert!(apart < 0.08, "{}: {mean} for {old}", a.identity.called);
    }
}

#[test]
fn saved_light_fits_its_scene() {
    let (mut app, root) =
        box_with(|assets| Root::Lit(LitBy(assets.load("scenes/cornell_box.light_bake"))));
    let status = move |world: &World| world.get::<LitByStatus>(root).cloned().unwrap();
    update_until(&mut app, |world| {
        let LitByStatus { lit, waiting, .. } = status(world);
        lit > 0 && waiting == 0
    });
    let status = status(app.world());
    assert_eq!(status.problems, Vec::<String>::new());
    assert!(status.lit >= 3, "{status:?}");
}
