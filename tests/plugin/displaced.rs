//! Meshes raised by height maps, without light.

use std::time::{Duration, Instant};

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::calculate_bounds;
use bevy::mesh::UvChannel;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::prelude::*;
use bevy_fresco::displacement::{DisplacementError, Spacing, Tessellation};
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::HeightImage;
use bevy_fresco::plugin::displacement::{
    DisplacedMesh, Displacement, DisplacementProblem, DisplacementStatus, MeshProblem,
};

use crate::world::bare_app;

/// Longer than any of this takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
/// Texels of maps along a side.
pub(crate) const TEXELS: u32 = 16;
/// Triangles of a square with a vertex for each texel.
pub(crate) const TRIANGLES: usize = 2 * (TEXELS * TEXELS) as usize;

/// Writes of `Mesh3d` that have been seen.
#[derive(Resource, Default)]
pub(crate) struct Writes(pub(crate) usize);

pub(crate) fn count_writes(
    written: Query<(), (Changed<Mesh3d>, With<Displacement>)>,
    mut writes: ResMut<Writes>,
) {
    writes.0 += written.iter().count();
}

/// A hill in the middle of the map, 1 high.
pub(crate) fn hill() -> HeightMap {
    let height = |i: u32| {
        let at = UVec2::new(i % TEXELS, i / TEXELS).as_vec2() + 0.5;
        let from_middle = (at / TEXELS as f32 - 0.5).length();
        0.5 + 0.5 * (std::f32::consts::TAU * from_middle.min(0.5)).cos()
    };
    let heights = (0..TEXELS * TEXELS).map(height).collect();
    HeightMap::new([TEXELS; 2], heights, [Wrap::Clamp; 2]).unwrap()
}

/// By the hill, with a vertex for each texel.
pub(crate) fn by_texels(world: &mut World, scale: f32) -> Displacement {
    let mut maps = world.resource_mut::<Assets<HeightImage>>();
    let mut displacement = Displacement::new(maps.add(HeightImage::new(hill())), scale);
    displacement.settings.tessellation = Tessellation::Uniform(Spacing::Texels(1.0));
    displacement
}

/// A square of 2 m in the plane z = 0.
fn square() -> Mesh {
    Plane3d::new(Vec3::Z, Vec2::splat(1.0)).into()
}

fn app() -> App {
    let mut app = bare_app();
    app.init_resource::<Writes>()
        .add_systems(PostUpdate, calculate_bounds)
        .add_systems(Last, count_writes);
    app
}

fn add(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// A displaced square whose mesh is there, and its source.
fn raised() -> (App, Entity, Handle<Mesh>) {
    let mut app = app();
    let source = add(&mut app, square());
    let displacement = by_texels(app.world_mut(), 0.25);
    let entity = app
        .world_mut()
        .spawn((Mesh3d(source.clone()), displacement))
        .id();
    settle(&mut app, entity);
    assert!(matches!(status(&app, entity), DisplacementStatus::Done(_)));
    (app, entity, source)
}

fn settle(app: &mut App, entity: Entity) {
    let since = Instant::now();
    loop {
        app.update();
        let status = status(app, entity);
        if !status.is_pending() && *status != DisplacementStatus::Idle {
            return;
        }
        assert!(since.elapsed() < PATIENCE, "{status:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn status(app: &App, entity: Entity) -> &DisplacementStatus {
    app.world().get(entity).unwrap()
}

fn problem(app: &App, entity: Entity) -> DisplacementProblem {
    status(app, entity).problem().unwrap().clone()
}

fn shown(app: &App, entity: Entity) -> Handle<Mesh> {
    app.world().get::<Mesh3d>(entity).unwrap().0.clone()
}

fn triangles(app: &App, mesh: &Handle<Mesh>) -> usize {
    let mesh = app.world().resource::<Assets<Mesh>>().get(mesh).unwrap();
    mesh.indices().unwrap().len() / 3
}

/// The highest vertex of what an entity shows.
fn height(app: &App, entity: Entity) -> f32 {
    let meshes = app.world().resource::<Assets<Mesh>>();
    let mesh = meshes.get(&shown(app, entity)).unwrap();
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let positions = positions.as_float3().unwrap().iter();
    positions.map(|p| p[2]).fold(f32::NEG_INFINITY, f32::max)
}

fn edit(app: &mut App, entity: Entity, edit: impl FnOnce(&mut Displacement)) {
    let mut entity = app.world_mut().entity_mut(entity);
    edit(&mut entity.get_mut::<Displacement>().unwrap());
}

#[test]
fn the_raised_mesh_appears_and_other_entities_keep_theirs() {
    let mut app = app();
    let source = add(&mut app, square());
    let displacement = by_texels(app.world_mut(), 0.25);
    let world = app.world_mut();
    let other = world.spawn(Mesh3d(source.clone())).id();
    let entity = world.spawn((Mesh3d(source.clone()), displacement)).id();
    app.update();
    assert!(status(&app, entity).is_pending());
    settle(&mut app, entity);
    let made = app.world().get::<DisplacedMesh>(entity).unwrap();
    assert_eq!(made.source, source);
    assert_eq!(made.displaced, shown(&app, entity));
    assert_eq!(triangles(&app, &made.displaced), TRIANGLES);
    let report = status(&app, entity).report().unwrap();
    assert_eq!(report.triangles as usize, TRIANGLES);
    assert!((height(&app, entity) - 0.25).abs() < 0.01);
    assert_eq!(shown(&app, other), source);
    assert_eq!(triangles(&app, &source), 2);
}

/// In the frame in which the mesh is swapped, and before it is drawn.
#[test]
fn bounds_follow() {
    let (mut app, entity, _) = raised();
    let check = |app: &App| {
        let bounds = app.world().get::<Aabb>(entity).unwrap();
        let truth = status(app, entity).report().unwrap().bounds;
        assert!(Vec3::from(bounds.min()).distance(truth.min) < 1e-6);
        assert!(Vec3::from(bounds.max()).distance(truth.max) < 1e-6);
        truth.max.z
    };
    assert!((check(&app) - 0.25).abs() < 0.01);
    edit(&mut app, entity, |d| d.settings.scale = 1.0);
    settle(&mut app, entity);
    assert!((check(&app) - 1.0).abs() < 0.04);
}

/// How high a ray from above meets what an entity shows: what Bevy's picking of meshes reads, its triangles where its
/// bounds are met.
fn picked(app: &App, entity: Entity, [x, y]: [f32; 2]) -> Option<f32> {
    let bounds = app.world().get::<Aabb>(entity).unwrap();
    let apart = (Vec2::new(x, y) - bounds.center.xy()).abs() - bounds.half_extents.xy();
    if apart.max_element() > 0.0 {
        return None;
    }
    let meshes = app.world().resource::<Assets<Mesh>>();
    let mesh = meshes.get(&shown(app, entity)).unwrap();
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let positions = positions.as_float3().unwrap();
    let corners: Vec<Vec3> = (mesh.indices().unwrap().iter())
        .map(|i| positions[i].into())
        .collect();
    let met = corners.as_chunks::<3>().0.iter().filter_map(|[a, b, c]| {
        let matrix = Mat3::from_cols(*b - *a, *c - *a, Vec3::Z);
        let at = matrix.inverse() * (Vec3::new(x, y, 0.0) - *a);
        let is_inside = at.x >= -1e-5 && at.y >= -1e-5 && at.x + at.y <= 1.0 + 1e-5;
        is_inside.then_some(-at.z)
    });
    met.max_by(f32::total_cmp)
}

#[test]
fn picking_meets_the_raised_surface() {
    let (mut app, entity, _) = raised();
    for i in 0..100 {
        let at = [i % 10, i / 10].map(|i| 0.19 * i as f32 - 0.85);
        let from_middle = Vec2::from(at).length() / 2.0;
        let truth = 0.125 + 0.125 * (std::f32::consts::TAU * from_middle.min(0.5)).cos();
        let height = picked(&app, entity, at).unwrap();
        // Bilinear between 16 texels.
        assert!(
            (height - truth).abs() < 0.01,
            "{height} for {truth} at {at:?}"
        );
    }
    assert_eq!(picked(&app, entity, [1.2, 0.0]), None);
    app.world_mut().entity_mut(entity).remove::<Displacement>();
    app.update();
    app.update();
    assert_eq!(picked(&app, entity, [0.1, 0.1]), Some(0.0));
}

#[test]
fn changes_of_settings_and_map_are_followed() {
    let (mut app, entity, source) = raised();
    edit(&mut app, entity, |d| d.settings.scale = 0.5);
    settle(&mut app, entity);
    assert!((height(&app, entity) - 0.5).abs() < 0.02);
    // Twice as many along each side.
    edit(&mut app, entity, |d| {
        d.uv_transform = bevy::math::Affine2::from_scale(Vec2::splat(2.0));
    });
    settle(&mut app, entity);
    assert_eq!(triangles(&app, &shown(&app, entity)), 4 * TRIANGLES);
    let map = app.world().get::<Displacement>(entity).unwrap().map.clone();
    let flat = HeightMap::new([1, 1], vec![0.2], [Wrap::Repeat; 2]).unwrap();
    let mut maps = app.world_mut().resource_mut::<Assets<HeightImage>>();
    maps.insert(map.id(), HeightImage::new(flat)).unwrap();
    settle(&mut app, entity);
    assert!((height(&app, entity) - 0.1).abs() < 1e-6);
    assert_eq!(
        app.world().get::<DisplacedMesh>(entity).unwrap().source,
        source
    );
}

#[test]
fn edits_of_the_source_and_other_meshes_are_followed() {
    let (mut app, entity, source) = raised();
    let lifted = square().translated_by(Vec3::Z);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    *meshes.get_mut(&source).unwrap() = lifted;
    settle(&mut app, entity);
    assert!((height(&app, entity) - 1.25).abs() < 0.01);
    // Somebody else's mesh is a new source.
    let other = add(&mut app, square().translated_by(3.0 * Vec3::Z));
    app.world_mut().get_mut::<Mesh3d>(entity).unwrap().0 = other.clone();
    settle(&mut app, entity);
    assert!((height(&app, entity) - 3.25).abs() < 0.01);
    let made = app.world().get::<DisplacedMesh>(entity).unwrap();
    assert_eq!(made.source, other);
    // So is the source itself, put back: it is raised again.
    app.world_mut().get_mut::<Mesh3d>(entity).unwrap().0 = other.clone();
    settle(&mut app, entity);
    assert!((height(&app, entity) - 3.25).abs() < 0.01);
}

#[test]
fn nothing_is_made_twice() {
    let (mut app, entity, source) = raised();
    app.update();
    let (before, mesh) = (app.world().resource::<Writes>().0, shown(&app, entity));
    for _ in 0..200 {
        app.update();
    }
    // Values written over themselves.
    edit(&mut app, entity, |d| d.settings.scale = 0.25);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    *meshes.get_mut(&source).unwrap() = square();
    for _ in 0..50 {
        app.update();
        assert!(!status(&app, entity).is_pending());
    }
    assert_eq!(app.world().resource::<Writes>().0, before);
    assert_eq!(shown(&app, entity), mesh);
}

#[test]
fn removal_puts_the_source_back() {
    let (mut app, entity, source) = raised();
    app.world_mut().entity_mut(entity).remove::<Displacement>();
    assert_eq!(shown(&app, entity), source);
    let world = app.world();
    assert!(world.get::<DisplacedMesh>(entity).is_none());
    assert!(world.get::<DisplacementStatus>(entity).is_none());
    // What is being made is given up.
    let mut displacement = by_texels(app.world_mut(), 0.25);
    displacement.settings.tessellation = Tessellation::Uniform(Spacing::Texels(0.02));
    app.world_mut().entity_mut(entity).insert(displacement);
    app.update();
    assert!(status(&app, entity).is_pending());
    app.world_mut().entity_mut(entity).remove::<Displacement>();
    for _ in 0..50 {
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(shown(&app, entity), source);
    app.world_mut().entity_mut(entity).despawn();
    app.update();
}

#[test]
fn a_map_that_fails_to_load_is_named_and_the_mesh_stays() {
    let mut app = app();
    let source = add(&mut app, square());
    let map = app.world().resource::<AssetServer>().load("nowhere.png");
    let entity = app
        .world_mut()
        .spawn((Mesh3d(source.clone()), Displacement::new(map, 0.1)))
        .id();
    settle(&mut app, entity);
    let problem = problem(&app, entity);
    assert!(matches!(problem, DisplacementProblem::MapNotLoaded(_)));
    assert!(problem.to_string().contains("nowhere.png"), "{problem}");
    assert_eq!(shown(&app, entity), source);
    // Mended, it goes on.
    let good = by_texels(app.world_mut(), 0.1);
    app.world_mut().entity_mut(entity).insert(good);
    settle(&mut app, entity);
    assert_eq!(triangles(&app, &shown(&app, entity)), TRIANGLES);
}

#[test]
fn what_stands_against_it_is_named_and_the_mesh_stays() {
    let mut app = app();
    let mut bare = square();
    bare.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
    let mut gone = square();
    gone.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let mut broken = square();
    broken.insert_attribute(Mesh::ATTRIBUTE_POSITION, vec![[f32::NAN; 3]; 4]);
    let good = by_texels(app.world_mut(), 0.1);
    let on_uv_1 = Displacement {
        uv_channel: UvChannel::Uv1,
        ..good.clone()
    };
    let mut no_scale = good.clone();
    no_scale.settings.scale = f32::NAN;
    let no_map = Displacement::default();
    type Is = fn(&DisplacementProblem) -> bool;
    let cases: [(Mesh, Displacement, Is); 6] = [
        (bare, good.clone(), |p| *p == DisplacementProblem::NoNormals),
        (gone, good.clone(), |p| {
            *p == DisplacementProblem::Mesh(MeshProblem::NotInMainWorld)
        }),
        (broken, good, |p| {
            let DisplacementProblem::Displacement(error) = p else {
                return false;
            };
            matches!(error, DisplacementError::NotFinite { .. })
        }),
        (square(), on_uv_1, |p| {
            *p == DisplacementProblem::NoUvs("UV_1")
        }),
        (square(), no_scale, |p| {
            let DisplacementProblem::Displacement(error) = p else {
                return false;
            };
            matches!(error, DisplacementError::Setting { what: "scale", .. })
        }),
        (square(), no_map, |p| *p == DisplacementProblem::NoMap),
    ];
    for (mesh, displacement, is) in cases {
        let source = add(&mut app, mesh);
        let entity = app
            .world_mut()
            .spawn((Mesh3d(source.clone()), displacement))
            .id();
        settle(&mut app, entity);
        let found = problem(&app, entity);
        assert!(is(&found), "{found:?}");
        for _ in 0..20 {
            app.update();
            assert!(!status(&app, entity).is_pending(), "{found:?} for ever");
        }
        assert_eq!(shown(&app, entity), source);
    }
}

/// Whoever waits for a mesh is told, and served when it comes; morph targets do not fit.
#[test]
fn meshes_that_come_later_are_raised_and_morphed_ones_are_not() {
    let mut app = app();
    let displacement = by_texels(app.world_mut(), 0.25);
    let source = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let entity = app
        .world_mut()
        .spawn((Mesh3d(source.clone()), displacement))
        .id();
    settle(&mut app, entity);
    assert_eq!(problem(&app, entity), DisplacementProblem::NoMesh);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(source.id(), square()).unwrap();
    settle(&mut app, entity);
    assert_eq!(triangles(&app, &shown(&app, entity)), TRIANGLES);
    let weights = MeshMorphWeights::Value {
        weights: Vec::new(),
    };
    app.world_mut().entity_mut(entity).insert(weights);
    settle(&mut app, entity);
    assert_eq!(problem(&app, entity), DisplacementProblem::Morphed);
}

#[test]
fn clones_are_raised_from_the_same_source() {
    let (mut app, entity, source) = raised();
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    settle(&mut app, clone);
    let made = app.world().get::<DisplacedMesh>(clone).unwrap();
    assert_eq!(made.source, source);
    assert!((height(&app, clone) - 0.25).abs() < 0.01);
    assert_ne!(shown(&app, clone), shown(&app, entity));
}
