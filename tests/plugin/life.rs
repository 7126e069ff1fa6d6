//! What happens to entities, materials and running bakes.

use std::time::Duration;

use bevy::diagnostic::{Diagnostic, DiagnosticsStore};
use bevy::prelude::*;
use bevy_fresco::plugin::radiosity::{
    BakeFailed, BakeFinished, BakeStarted, BakeState, BakedLighting, CancelBake, NoStaticLighting,
    NotBaked, RadiosityDiagnostics, RadiositySettings, StaticLighting,
};
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT_GRADIENT, FrescoMaterial};
use bevy_fresco::radiosity::{BakeSettings, Stage};

use crate::world::{Room, bare_app, difference, is_moved, light, material, mesh, quads, settle};

#[test]
fn five_hundred_frames_without_a_scene() {
    let mut app = bare_app();
    for _ in 0..500 {
        app.update();
    }
}

/// Asked for, meshes say where their light comes from, in their own space; else they do not.
#[test]
fn gradients_come_and_go_with_the_setting() {
    let mut room = Room::new();
    let turned = Quat::from_rotation_y(0.5);
    room.edit::<Transform>(room.block, |at| at.rotation = turned);
    room.world()
        .resource_mut::<RadiositySettings>()
        .bake
        .directional = true;
    room.settle();
    let gradients = |room: &Room, entity| -> Option<Vec<[f32; 3]>> {
        let world = room.app.world();
        let mesh = world
            .resource::<Assets<Mesh>>()
            .get(&world.get::<Mesh3d>(entity)?.0)?;
        Some(
            mesh.attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT)?
                .as_float3()?
                .to_vec(),
        )
    };
    let light = room.light(room.block);
    let found = gradients(&room, room.block).unwrap();
    assert_eq!(found.len(), light.len());
    // On top of the block light comes from the middle of the room, towards its −x and from above.
    let world = room.app.world();
    let mesh = &world.get::<Mesh3d>(room.block).unwrap().0;
    let mesh = world.resource::<Assets<Mesh>>().get(mesh).unwrap();
    let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).unwrap();
    let normals = normals.as_float3().unwrap();
    let on_top = (normals.iter().zip(&found)).filter(|(n, _)| n[1] > 0.9);
    let sum: Vec3 = on_top.map(|(_, g)| turned * Vec3::from(*g)).sum();
    assert!(sum.y > 0.0 && sum.x < -0.1 * sum.y, "{sum}");
    room.world()
        .resource_mut::<RadiositySettings>()
        .bake
        .directional = false;
    room.settle();
    assert!(gradients(&room, room.block).is_none());
    assert!(!room.light(room.block).is_empty());
}

#[test]
fn light_bleeds_and_goes_per_entity() {
    let room = Room::lit();
    // Two blocks of one mesh handle would still have light of their own: so has each mesh here.
    let world = room.app.world();
    for entity in [room.walls, room.red_wall, room.block] {
        let baked = world.get::<BakedLighting>(entity).unwrap();
        assert_eq!(world.get::<Mesh3d>(entity).unwrap().0, baked.lit);
        assert_ne!(baked.lit, baked.source);
        let light = room.light(entity);
        assert!(
            light
                .iter()
                .all(|l| l.is_finite() && l.min_element() >= 0.0)
        );
        assert!(light.iter().any(|l| l.max_element() > 1.0));
    }
    // The white side of the block that faces the red wall is reddish beside the other.
    let mesh = world
        .resource::<Assets<Mesh>>()
        .get(&world.get::<Mesh3d>(room.block).unwrap().0)
        .unwrap();
    let normals = mesh
        .attribute(Mesh::ATTRIBUTE_NORMAL)
        .unwrap()
        .as_float3()
        .unwrap();
    let redness = |side: f32| {
        let on_side = normals
            .iter()
            .zip(room.light(room.block))
            .filter(|(n, _)| n[0] == side);
        let sum: Vec3 = on_side.map(|(_, l)| l).sum();
        sum.x / sum.z
    };
    assert!(
        redness(-1.0) > 1.1 * redness(1.0),
        "{} {}",
        redness(-1.0),
        redness(1.0)
    );
}

#[test]
fn what_stops_being_static_gets_its_own_back() {
    let mut room = Room::lit();
    let (block, red_wall) = (room.block, room.red_wall);
    assert!(is_moved(&room.app, block));
    let source = room
        .app
        .world()
        .get::<BakedLighting>(block)
        .unwrap()
        .source
        .clone();
    room.world().entity_mut(block).insert(NoStaticLighting);
    room.settle();
    assert!(!is_moved(&room.app, block) && is_moved(&room.app, red_wall));
    let world = room.app.world();
    assert_eq!(world.get::<Mesh3d>(block).unwrap().0, source);
    assert!(
        world
            .get::<MeshMaterial3d<StandardMaterial>>(block)
            .is_some()
    );
    assert!(world.get::<BakedLighting>(block).is_none());
    let root = room.root;
    room.world().entity_mut(root).remove::<StaticLighting>();
    room.settle_idle();
    assert!(!is_moved(&room.app, red_wall));
    room.world()
        .entity_mut(root)
        .insert(StaticLighting::default());
    room.settle();
    assert!(is_moved(&room.app, red_wall) && !is_moved(&room.app, block));
}

impl Room {
    /// Some frames in which nothing is baked.
    fn settle_idle(&mut self) {
        for _ in 0..5 {
            self.app.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// A change that takes long to bake, under way.
    fn bake_slowly(&mut self) {
        self.world().resource_mut::<RadiositySettings>().bake = BakeSettings {
            elements: 20_000,
            element_rays: 1024,
            gather_rays: 1024,
            refine: false,
            ..BakeSettings::FINAL
        };
        while !matches!(self.status().state, BakeState::Baking { .. }) {
            self.app.update();
        }
    }

    fn wait_for_failure(&mut self) {
        let failed = self.status().failed;
        for _ in 0..2000 {
            self.app.update();
            if self.status().failed > failed {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("{:?}", self.status());
    }
}

#[test]
fn a_cancelled_bake_leaves_the_old_light() {
    let mut room = Room::lit();
    let before = room.all_light();
    room.bake_slowly();
    room.world().trigger(CancelBake);
    room.wait_for_failure();
    assert_eq!(difference(&room.all_light(), &before), 0.0);
    assert_eq!(room.status().state, BakeState::Stopped);
    room.settle_idle();
    assert_eq!(
        room.status().state,
        BakeState::Stopped,
        "it starts again by itself"
    );
    // A change starts another.
    room.world().resource_mut::<RadiositySettings>().bake = crate::world::settings().bake;
    room.settle();
    assert!(difference(&room.all_light(), &before) < 2e-3);
}

#[test]
fn a_bake_over_its_time_budget_leaves_the_old_light() {
    let mut room = Room::lit();
    let before = room.all_light();
    room.world().resource_mut::<RadiositySettings>().time_budget = Some(Duration::from_millis(50));
    room.bake_slowly();
    room.wait_for_failure();
    let error = room.status().error.clone().unwrap();
    assert!(error.contains("time_budget"), "{error}");
    assert_eq!(difference(&room.all_light(), &before), 0.0);
}

#[test]
fn a_bake_that_fails_leaves_the_old_light_and_says_why() {
    let mut room = Room::lit();
    let before = room.all_light();
    room.world()
        .resource_mut::<RadiositySettings>()
        .bake
        .element_rays = 0;
    room.wait_for_failure();
    assert!(
        room.status()
            .error
            .as_ref()
            .unwrap()
            .contains("element_rays")
    );
    assert_eq!(difference(&room.all_light(), &before), 0.0);
}

#[test]
fn despawning_while_baking_does_no_harm() {
    let mut room = Room::lit();
    room.bake_slowly();
    let root = room.root;
    room.world().despawn(root);
    room.world().resource_mut::<RadiositySettings>().bake = crate::world::settings().bake;
    room.world().trigger(CancelBake);
    room.settle_idle();
    room.wait_until_quiet();
}

impl Room {
    fn wait_until_quiet(&mut self) {
        for _ in 0..2000 {
            self.app.update();
            if !matches!(
                self.status().state,
                BakeState::Baking { .. } | BakeState::Changed
            ) {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("{:?}", self.status());
    }
}

#[test]
fn closing_the_app_while_baking_returns_at_once() {
    let mut room = Room::lit();
    room.bake_slowly();
    let since = std::time::Instant::now();
    drop(room);
    assert!(since.elapsed() < Duration::from_secs(1));
}

#[test]
fn without_settings_nothing_runs_and_light_stays() {
    let mut room = Room::lit();
    let before = room.all_light();
    room.bake_slowly();
    room.world().remove_resource::<RadiositySettings>();
    room.settle_idle();
    assert_eq!(difference(&room.all_light(), &before), 0.0);
    room.world().insert_resource(crate::world::settings());
    room.edit::<PointLight>(room.point, |l| l.intensity *= 2.0);
    room.settle();
    assert!(difference(&room.all_light(), &before) > 0.1);
}

#[test]
fn what_cannot_be_baked_says_why() {
    let mut room = Room::new();
    let lines = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 2]);
    let lines = mesh(room.world(), lines);
    let white = material(room.world(), Color::WHITE);
    let root = room.root;
    let wires = room
        .world()
        .spawn((Mesh3d(lines), MeshMaterial3d(white.clone()), ChildOf(root)))
        .id();
    let plain = mesh(room.world(), Cuboid::default().into());
    let bare = room
        .world()
        .spawn((Mesh3d(plain.clone()), Transform::default(), ChildOf(root)))
        .id();
    let lost = room
        .world()
        .spawn((Mesh3d::default(), MeshMaterial3d(white), ChildOf(root)))
        .id();
    room.settle();
    let reason = |room: &Room, e| room.app.world().get::<NotBaked>(e).unwrap().reason.clone();
    assert!(reason(&room, wires).contains("lines"));
    assert!(reason(&room, bare).contains("StandardMaterial"));
    assert!(reason(&room, lost).contains("not loaded"));
    // What is mended is taken in.
    let white = material(room.world(), Color::WHITE);
    room.world()
        .entity_mut(bare)
        .insert((MeshMaterial3d(white), Transform::from_xyz(0.0, 0.0, 0.5)));
    room.settle();
    assert!(room.app.world().get::<NotBaked>(bare).is_none());
    assert!(room.app.world().get::<BakedLighting>(bare).is_some());
}

#[test]
fn a_material_of_its_own_is_left_alone() {
    let mut room = Room::lit();
    let block = room.block;
    let own = FrescoMaterial {
        base: StandardMaterial::from_color(Color::BLACK),
        ..default()
    };
    let own = room
        .world()
        .resource_mut::<Assets<FrescoMaterial>>()
        .add(own);
    let before = room.all_light();
    room.world()
        .entity_mut(block)
        .insert(MeshMaterial3d(own.clone()));
    room.settle();
    // It is the one that is baked,
    assert!(difference(&room.all_light(), &before) > 0.005);
    // and the one that stays.
    room.world().entity_mut(block).insert(NoStaticLighting);
    room.settle();
    let shown = room
        .app
        .world()
        .get::<MeshMaterial3d<FrescoMaterial>>(block);
    assert_eq!(shown.unwrap().0, own);
}

#[test]
fn a_transform_without_a_direction_is_named() {
    let mut room = Room::lit();
    let before = room.all_light();
    let sun = DirectionalLight::default();
    let flat = Transform::from_scale(Vec3::ZERO);
    room.world().spawn((Name::new("flat sun"), sun, flat));
    room.wait_for_failure();
    let error = room.status().error.clone().unwrap();
    assert!(
        error.contains("flat sun") && error.contains("direction"),
        "{error}"
    );
    assert_eq!(difference(&room.all_light(), &before), 0.0);
}

#[test]
fn a_position_that_is_no_number_is_named() {
    let mut room = Room::lit();
    let before = room.all_light();
    room.edit::<Transform>(room.block, |t| t.translation.y = f32::NAN);
    room.wait_for_failure();
    assert!(room.status().error.as_ref().unwrap().contains("block"));
    assert_eq!(difference(&room.all_light(), &before), 0.0);
    room.edit::<Transform>(room.block, |t| t.translation.y = -0.65);
    room.settle();
    assert!(difference(&room.all_light(), &before) < 0.01);
}

#[test]
fn light_that_looks_black_is_told_of() {
    let mut room = Room::lit();
    assert_eq!(room.report().notes, [""; 0]);
    room.edit_material(room.lamp, |m| m.emissive = LinearRgba::BLACK);
    room.edit::<PointLight>(room.point, |l| l.intensity = 1.0);
    room.settle();
    assert!(room.report().notes.iter().any(|n| n.contains("ev100")));
}

#[test]
fn a_lightmap_is_kept() {
    let mut room = Room::lit();
    let block = room.block;
    room.world()
        .entity_mut(block)
        .insert(bevy::pbr::Lightmap::default());
    room.settle();
    room.bake_from_scratch();
    // It goes on lighting others and is not lit itself: what it has is not renewed.
    let stale = room.light(block);
    room.edit::<PointLight>(room.point, |l| l.intensity *= 2.0);
    room.settle();
    assert_eq!(room.light(block), stale);
}

#[test]
fn a_mesh_for_the_renderer_alone_says_so() {
    let mut room = Room::new();
    let root = room.root;
    let mut gone = Mesh::from(Cuboid::default());
    gone.asset_usage = bevy::asset::RenderAssetUsages::RENDER_WORLD;
    let gone = mesh(room.world(), gone);
    let white = material(room.world(), Color::WHITE);
    let entity = (Mesh3d(gone), MeshMaterial3d(white), ChildOf(root));
    let entity = room.world().spawn(entity).id();
    room.settle();
    let reason = &room.app.world().get::<NotBaked>(entity).unwrap().reason;
    assert!(reason.contains("MAIN_WORLD"), "{reason}");
}

#[test]
fn a_clone_has_light_of_its_own() {
    let mut room = Room::lit();
    let block = room.block;
    let twin = room.world().entity_mut(block).clone_and_spawn();
    room.edit::<Transform>(twin, |t| t.translation = Vec3::new(-0.6, -0.65, 0.5));
    room.settle();
    let lit = |e| {
        let baked = room.app.world().get::<BakedLighting>(e).unwrap();
        baked.lit.clone()
    };
    assert_ne!(lit(block), lit(twin));
    assert_eq!(room.light(block).len(), room.light(twin).len());
    assert_ne!(room.light(block), room.light(twin));
}

#[test]
fn an_emissive_surface_lights_as_brightly_as_it_looks() {
    for weight in [0.0, 0.25, 1.0] {
        let mut app = bare_app();
        let world = app.world_mut();
        let glow = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: Color::BLACK,
                emissive: LinearRgba::rgb(1.0, 0.5, 0.25),
                emissive_exposure_weight: weight,
                ..default()
            });
        let white = material(world, Color::WHITE);
        // A ceiling so wide that a tile on the floor sees nothing else.
        let above = mesh(world, quads(&[(Vec3::Y, Vec3::X * 200.0, Vec3::Z * 200.0)]));
        let tile = mesh(world, quads(&[(Vec3::ZERO, Vec3::X, Vec3::NEG_Z)]));
        world.spawn((
            Mesh3d(above),
            MeshMaterial3d(glow),
            StaticLighting::default(),
        ));
        let tile = (
            Mesh3d(tile),
            MeshMaterial3d(white),
            StaticLighting::default(),
        );
        let tile = world.spawn(tile).id();
        world.resource_mut::<RadiositySettings>().bake.max_edge = None;
        settle(&mut app);
        // Bevy shows emissive light times this, and baked light times the exposure.
        let exposure = bevy::camera::Exposure::default().exposure();
        let shown = Vec3::new(1.0, 0.5, 0.25) * (1.0 + (exposure - 1.0) * weight);
        for light in light(&app, tile) {
            let gap = (light * exposure - shown).length();
            assert!(
                gap < 0.01 * shown.length(),
                "{weight}: {} {shown}",
                light * exposure
            );
        }
    }
}

#[test]
fn a_bake_is_measured() {
    let mut room = Room::lit();
    room.edit::<Transform>(room.block, |t| t.translation.x = -0.4);
    room.settle();
    room.app.update();
    let measured = room.app.world().resource::<DiagnosticsStore>();
    let value = |path| measured.get(&path).and_then(Diagnostic::value).unwrap();
    let gather = value(RadiosityDiagnostics::stage(Stage::Gather));
    assert!(gather > 0.0 && value(RadiosityDiagnostics::TOTAL) >= gather);
    assert!(value(RadiosityDiagnostics::RAYS) > 0.0);
    let vertices = room.report().counts.vertices;
    assert_eq!(value(RadiosityDiagnostics::VERTICES), vertices as f64);
    assert!(value(RadiosityDiagnostics::MAIN_THREAD) >= 0.0);
}

#[test]
fn a_scene_may_come_first_or_last() {
    // Static meshes that are there before the plugin looks, and a mark that comes after the meshes.
    let mut room = Room::new();
    let root = room.root;
    room.world().entity_mut(root).remove::<StaticLighting>();
    room.settle_idle();
    assert!(room.light(room.walls).is_empty());
    room.world()
        .entity_mut(root)
        .insert(StaticLighting::default());
    room.settle();
    assert!(!room.light(room.walls).is_empty());
}

#[derive(Resource, Default)]
struct Heard(Vec<&'static str>);

#[test]
fn a_bake_is_heard_of() {
    let mut room = Room::new();
    room.app
        .init_resource::<Heard>()
        .add_observer(|_: On<BakeStarted>, mut heard: ResMut<Heard>| heard.0.push("started"))
        .add_observer(|_: On<BakeFinished>, mut heard: ResMut<Heard>| heard.0.push("finished"))
        .add_observer(|_: On<BakeFailed>, mut heard: ResMut<Heard>| heard.0.push("failed"))
        .add_systems(
            Last,
            |mut read: MessageReader<BakeFinished>, mut heard: ResMut<Heard>| {
                heard.0.extend(read.read().map(|_| "message"));
            },
        );
    room.settle();
    room.app.update();
    assert_eq!(
        room.app.world().resource::<Heard>().0,
        ["started", "finished", "message"]
    );
}

#[test]
fn bakes_go_on_while_changes_do() {
    let mut room = Room::lit();
    room.world().resource_mut::<RadiositySettings>().debounce = Duration::from_secs(3600);
    room.world().resource_mut::<RadiositySettings>().max_delay = Duration::from_millis(20);
    let finished = room.status().finished;
    for i in 0..1000 {
        room.edit::<PointLight>(room.point, |l| l.intensity = 1000.0 + i as f32);
        room.app.update();
        std::thread::sleep(Duration::from_millis(2));
        if room.status().finished > finished + 1 {
            return;
        }
    }
    panic!("{:?}", room.status());
}

#[test]
fn on_request_only() {
    let mut room = Room::lit();
    room.world().resource_mut::<RadiositySettings>().automatic = false;
    let before = room.all_light();
    room.edit::<PointLight>(room.point, |l| l.intensity *= 2.0);
    room.settle_idle();
    assert_eq!(difference(&room.all_light(), &before), 0.0);
    room.world()
        .trigger(bevy_fresco::plugin::radiosity::Rebake::default());
    settle(&mut room.app);
    assert!(difference(&room.all_light(), &before) > 0.1);
}
