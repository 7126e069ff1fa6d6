//! A small world to change: a room with a block in it, without a renderer.

use std::time::{Duration, Instant};

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshPlugin, PrimitiveTopology};
use bevy::prelude::*;
use bevy_fresco::plugin::radiosity::{
    BakeState, BakedLighting, RadiositySettings, RadiosityStatus, Rebake, StaticLighting,
};
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, FrescoMaterial, FrescoPlugins};
use bevy_fresco::radiosity::{BakeSettings, Report};

/// Longer than any of these bakes takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// The room and what is in it.
pub(crate) struct Room {
    pub(crate) app: App,
    pub(crate) root: Entity,
    pub(crate) walls: Entity,
    pub(crate) red_wall: Entity,
    pub(crate) block: Entity,
    pub(crate) lamp: Entity,
    pub(crate) point: Entity,
}

/// Enough rays to tell light from none, few enough to be quick in a debug build.
pub(crate) fn settings() -> RadiositySettings {
    RadiositySettings {
        bake: BakeSettings {
            elements: 600,
            element_rays: 128,
            gather_rays: 256,
            emitter_rays: 32,
            samples_per_vertex: 16.0,
            solver_tolerance: 1e-4,
            max_edge: Some(0.8),
            refine: false,
            ..BakeSettings::DRAFT
        },
        debounce: Duration::ZERO,
        max_delay: Duration::ZERO,
        apply_budget: Duration::from_secs(1),
        ..RadiositySettings::default()
    }
}

/// An app with assets, transforms and the plugins, and nothing that draws.
pub(crate) fn bare_app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        MeshPlugin,
        bevy::diagnostic::DiagnosticsPlugin,
    ))
    .init_asset::<Image>()
    .init_asset::<StandardMaterial>()
    .insert_resource(settings())
    .add_plugins(FrescoPlugins);
    app.finish();
    app.cleanup();
    app
}

impl Room {
    pub(crate) fn new() -> Self {
        let mut app = bare_app();
        let world = app.world_mut();
        let root = world
            .spawn((Transform::default(), StaticLighting::default()))
            .id();
        let white = material(world, Color::srgb(0.8, 0.8, 0.8));
        let red = material(world, Color::srgb(0.8, 0.1, 0.1));
        let glow = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: Color::BLACK,
                emissive: LinearRgba::rgb(4.0, 4.0, 3.0),
                ..default()
            });
        // Open towards +z, so that what moves out of it is seen to leave.
        let walls = mesh(
            world,
            quads(&[
                (Vec3::new(0.0, -1.0, 0.0), Vec3::X, Vec3::NEG_Z),
                (Vec3::new(0.0, 1.0, 0.0), Vec3::X, Vec3::Z),
                (Vec3::new(0.0, 0.0, -1.0), Vec3::X, Vec3::Y),
                (Vec3::new(1.0, 0.0, 0.0), Vec3::Z, Vec3::Y),
            ]),
        );
        let left = mesh(
            world,
            quads(&[(Vec3::new(-1.0, 0.0, 0.0), Vec3::NEG_Z, Vec3::Y)]),
        );
        let cube = mesh(world, Cuboid::new(0.6, 0.6, 0.6).into());
        let panel = mesh(
            world,
            quads(&[(Vec3::ZERO, Vec3::X * 0.25, Vec3::Z * 0.25)]),
        );
        let mut child = |name: &'static str, mesh, material, at| {
            world
                .spawn((
                    Name::new(name),
                    Mesh3d(mesh),
                    MeshMaterial3d(material),
                    at,
                    ChildOf(root),
                ))
                .id()
        };
        let here = Transform::default();
        let walls = child("walls", walls, white.clone(), here);
        let red_wall = child("red wall", left, red, here);
        let block = child("block", cube, white, Transform::from_xyz(0.3, -0.65, 0.1));
        let lamp = child("lamp", panel, glow, Transform::from_xyz(0.0, 0.98, 0.0));
        let point = world
            .spawn((
                Name::new("point"),
                PointLight {
                    intensity: 40_000.0,
                    affects_lightmapped_mesh_diffuse: false,
                    ..default()
                },
                Transform::from_xyz(-0.4, 0.5, 0.5),
            ))
            .id();
        Self {
            app,
            root,
            walls,
            red_wall,
            block,
            lamp,
            point,
        }
    }

    /// A room whose light is up to date.
    pub(crate) fn lit() -> Self {
        let mut room = Self::new();
        room.settle();
        room
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Runs until the light is that of the world.
    pub(crate) fn settle(&mut self) {
        settle(&mut self.app);
    }

    pub(crate) fn status(&self) -> &RadiosityStatus {
        self.app.world().resource()
    }

    pub(crate) fn report(&self) -> &Report {
        self.status().report.as_ref().unwrap()
    }

    /// Bakes all anew.
    pub(crate) fn bake_from_scratch(&mut self) {
        self.world().trigger(Rebake { from_scratch: true });
        self.settle();
    }

    pub(crate) fn edit<C: Component<Mutability = bevy::ecs::component::Mutable>>(
        &mut self,
        entity: Entity,
        edit: impl FnOnce(&mut C),
    ) {
        edit(&mut self.world().entity_mut(entity).get_mut::<C>().unwrap());
    }

    pub(crate) fn edit_material(
        &mut self,
        entity: Entity,
        edit: impl FnOnce(&mut StandardMaterial),
    ) {
        let original = self
            .app
            .world()
            .get::<bevy_fresco::plugin::radiosity::OriginalMaterial>(entity)
            .unwrap()
            .handle
            .clone();
        let mut materials = self.world().resource_mut::<Assets<StandardMaterial>>();
        edit(&mut materials.get_mut(&original).unwrap());
    }

    /// Light of an entity's vertices; empty if it has none.
    pub(crate) fn light(&self, entity: Entity) -> Vec<Vec3> {
        light(&self.app, entity)
    }

    /// Light of all entities that have some.
    pub(crate) fn all_light(&self) -> Vec<(Entity, Vec<Vec3>)> {
        let world = self.app.world();
        let mut all: Vec<(Entity, Vec<Vec3>)> = world
            .iter_entities()
            .filter(|e| e.contains::<BakedLighting>())
            .map(|e| (e.id(), self.light(e.id())))
            .collect();
        all.sort_by_key(|(e, _)| *e);
        all
    }
}

pub(crate) fn settle(app: &mut App) {
    // The change is noticed in this frame.
    app.update();
    let since = Instant::now();
    loop {
        let status = app.world().resource::<RadiosityStatus>();
        if status.is_up_to_date() {
            return;
        }
        assert!(status.state != BakeState::Stopped, "{status:?}");
        assert!(since.elapsed() < PATIENCE, "{status:?}");
        std::thread::sleep(Duration::from_millis(1));
        app.update();
    }
}

pub(crate) fn light(app: &App, entity: Entity) -> Vec<Vec3> {
    let world = app.world();
    let mesh = world.get::<Mesh3d>(entity).unwrap();
    let mesh = world.resource::<Assets<Mesh>>().get(mesh).unwrap();
    mesh.attribute(ATTRIBUTE_BAKED_LIGHT)
        .and_then(|v| v.as_float3())
        .map_or_else(Vec::new, |v| v.iter().map(|&l| l.into()).collect())
}

/// Relative root mean square difference over all entities, which must be the same ones.
pub(crate) fn difference(a: &[(Entity, Vec<Vec3>)], b: &[(Entity, Vec<Vec3>)]) -> f32 {
    assert_eq!(
        a.iter().map(|(e, l)| (*e, l.len())).collect::<Vec<_>>(),
        b.iter().map(|(e, l)| (*e, l.len())).collect::<Vec<_>>(),
    );
    let pairs = || a.iter().zip(b).flat_map(|((_, a), (_, b))| a.iter().zip(b));
    let gap: f32 = pairs().map(|(a, b)| a.distance_squared(*b)).sum();
    let level: f32 = pairs().map(|(_, b)| b.length_squared()).sum();
    (gap / level.max(1e-20)).sqrt()
}

pub(crate) fn material(world: &mut World, color: Color) -> Handle<StandardMaterial> {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    materials.add(StandardMaterial::from_color(color))
}

pub(crate) fn mesh(world: &mut World, mesh: Mesh) -> Handle<Mesh> {
    world.resource_mut::<Assets<Mesh>>().add(mesh)
}

/// Squares given by centre and two half edges; the front is towards their cross product.
pub(crate) fn quads(quads: &[(Vec3, Vec3, Vec3)]) -> Mesh {
    let (mut positions, mut normals, mut uvs, mut indices) = (vec![], vec![], vec![], vec![]);
    for &(center, u, v) in quads {
        let first = positions.len() as u32;
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            positions.push((center + u * s + v * t).to_array());
            normals.push(u.cross(v).normalize().to_array());
            uvs.push([0.5 + 0.5 * s, 0.5 - 0.5 * t]);
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
    .with_inserted_indices(Indices::U32(indices))
}

/// The extended material of an entity, if it was moved to it.
pub(crate) fn is_moved(app: &App, entity: Entity) -> bool {
    app.world()
        .get::<MeshMaterial3d<FrescoMaterial>>(entity)
        .is_some()
}
