use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::light_bake;
use super::material::drawn_forward;
use super::radiosity::{LightBaking, StaticMarks};
use super::{ATTRIBUTE_BAKED_LIGHT, FrescoExtension, FrescoMaterial, FrescoMaterialPlugin};

/// On the root of a scene whose meshes were loaded with baked light: shows it. Nothing is baked for that.
///
/// ```no_run
/// use bevy::gltf::{GltfAssetLabel, GltfPlugin};
/// use bevy::prelude::*;
/// use bevy::world_serialization::WorldAssetRoot;
/// use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, BakedScene, BakedScenePlugin};
///
/// fn main() {
///     let gltf = GltfPlugin::default().add_custom_vertex_attribute("BAKED_LIGHT", ATTRIBUTE_BAKED_LIGHT);
///     App::new()
///         .add_plugins((DefaultPlugins.set(gltf), BakedScenePlugin))
///         .add_systems(Startup, setup)
///         .run();
/// }
///
/// fn setup(mut commands: Commands, assets: Res<AssetServer>) {
///     let room = assets.load(GltfAssetLabel::Scene(0).from_asset("room.baked.glb"));
///     commands.spawn((WorldAssetRoot(room), BakedScene::default()));
/// }
/// ```
///
/// Below it, each `MeshMaterial3d<StandardMaterial>` on a mesh with [`ATTRIBUTE_BAKED_LIGHT`] becomes a
/// [`FrescoMaterial`] of the same look, and lights keep their diffuse part off these meshes, which have it already:
/// those with a [`LightBaking`] if that is `Full`, others by [`direct`](Self::direct).
/// What the plugin for radiosity bakes ([`StaticLighting`](super::radiosity::StaticLighting)) is left to it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct BakedScene {
    /// What baked light is multiplied by to be in cd/m².
    ///
    /// 1 for light of lights. The command line takes `emissive` for cd/m² unless told otherwise, and Bevy shows it
    /// without the camera's exposure: for a scene lit by emissive surfaces alone, 1 / exposure makes the room as bright as
    /// they look, 998 for Bevy's default camera. For one with both, bake it with `--emissive-gain 998`.
    pub gain: f32,
    /// Whether direct light was baked with what bounces, as it is by default, or is left to the engine
    /// (`fresco bake --direct realtime`).
    pub direct: bool,
}

impl Default for BakedScene {
    fn default() -> Self {
        Self {
            gain: 1.0,
            direct: true,
        }
    }
}

/// Shows light that was baked elsewhere: see [`BakedScene`].
#[derive(Clone, Copy, Debug, Default)]
pub struct BakedScenePlugin;

impl Plugin for BakedScenePlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FrescoMaterialPlugin>() {
            app.add_plugins(FrescoMaterialPlugin);
        }
        light_bake::plugin(app);
        app.register_type::<BakedScene>().add_systems(
            Update,
            (show_light, keep_lights_off).run_if(any_with_component::<BakedScene>),
        );
    }
}

/// Whose meshes and lights are treated.
#[derive(SystemParam)]
struct Marks<'w, 's> {
    marks: Query<'w, 's, &'static BakedScene>,
    parents: Query<'w, 's, &'static ChildOf>,
    baked_here: StaticMarks<'w, 's>,
}

impl Marks<'_, '_> {
    /// The nearest mark above an entity or on it, unless it is baked here.
    fn of(&self, entity: Entity) -> Option<BakedScene> {
        if self.baked_here.in_effect(entity).is_some() {
            return None;
        }
        let mut above = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
        above.find_map(|entity| self.marks.get(entity).ok().copied())
    }
}

type Shown<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Mesh3d,
        &'static MeshMaterial3d<StandardMaterial>,
    ),
>;

/// Moves materials of meshes that have light. Those that are loading are moved when they are there.
fn show_light(
    mut commands: Commands,
    shown: Shown,
    marks: Marks,
    meshes: Res<Assets<Mesh>>,
    standard: Res<Assets<StandardMaterial>>,
    mut ours: ResMut<Assets<FrescoMaterial>>,
    mut made: Local<HashMap<(AssetId<StandardMaterial>, u32), AssetId<FrescoMaterial>>>,
) {
    for (entity, mesh, material) in &shown {
        let has_light = |mesh: &Mesh| mesh.contains_attribute(ATTRIBUTE_BAKED_LIGHT);
        if !meshes.get(&mesh.0).is_some_and(has_light) {
            continue;
        }
        let mark = marks.of(entity);
        let (Some(mark), Some(base)) = (mark, standard.get(&material.0)) else {
            continue;
        };
        let key = (material.id(), mark.gain.to_bits());
        let known = made.get(&key).and_then(|&id| ours.get_strong_handle(id));
        let handle = known.unwrap_or_else(|| {
            ours.add(FrescoMaterial {
                base: drawn_forward(base),
                extension: FrescoExtension {
                    baked_light_gain: mark.gain,
                    ..default()
                },
            })
        });
        made.insert(key, handle.id());
        commands
            .entity(entity)
            .try_remove::<MeshMaterial3d<StandardMaterial>>()
            .try_insert(MeshMaterial3d(handle));
    }
}

/// Sets Bevy's own switch on lights that are new, or of a scene that is.
fn keep_lights_off(
    mut points: Query<(Entity, &mut PointLight)>,
    mut spots: Query<(Entity, &mut SpotLight)>,
    mut suns: Query<(Entity, &mut DirectionalLight)>,
    told: Query<&LightBaking>,
    new_marks: Query<(), Added<BakedScene>>,
    marks: Marks,
) {
    let any_new = !new_marks.is_empty();
    let is_baked = |entity| {
        let mark = marks.of(entity);
        mark.is_some_and(|mark| match told.get(entity) {
            Ok(told) => *told == LightBaking::Full,
            Err(_) => mark.direct,
        })
    };
    for (entity, mut light) in &mut points {
        if (any_new || light.is_added()) && is_baked(entity) {
            light.affects_lightmapped_mesh_diffuse = false;
        }
    }
    for (entity, mut light) in &mut spots {
        if (any_new || light.is_added()) && is_baked(entity) {
            light.affects_lightmapped_mesh_diffuse = false;
        }
    }
    for (entity, mut light) in &mut suns {
        if (any_new || light.is_added()) && is_baked(entity) {
            light.affects_lightmapped_mesh_diffuse = false;
        }
    }
}
