use std::time::Duration;

use bevy::asset::LoadState;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::time::Real;

use super::asset::{BakedObject, LightBake, LightBakeLoader};
use super::identity::{Called, LightBakeId, MeshIdentity, called};
use crate::plugin::BakedScene;
use crate::plugin::displacement::Displacement;
use crate::plugin::radiosity::StaticMarks;
use crate::plugin::radiosity::mesh_data::{lit_mesh, read};

/// On the root of a scene: its meshes get the light that was saved of them. Nothing is baked for that.
///
/// ```no_run
/// use bevy::gltf::GltfAssetLabel;
/// use bevy::prelude::*;
/// use bevy::world_serialization::WorldAssetRoot;
/// use bevy_fresco::plugin::{BakedScenePlugin, LightBake, LitBy};
///
/// fn main() {
///     App::new()
///         .add_plugins((DefaultPlugins, BakedScenePlugin))
///         .add_systems(Startup, setup)
///         .run();
/// }
///
/// fn setup(mut commands: Commands, assets: Res<AssetServer>) {
///     let room = assets.load(GltfAssetLabel::Scene(0).from_asset("room.glb"));
///     commands.spawn((WorldAssetRoot(room), LitBy(assets.load("room.light_bake"))));
/// }
/// ```
///
/// Each mesh is found by the [`LightBakeId`] of its entity, else by names from the root down, and must be the mesh
/// that was lit. Materials and lights are treated as [`BakedScene`] does, which comes along with `direct: false`:
/// lights stay realtime but for those that are [`LightBaking::Full`](crate::plugin::radiosity::LightBaking::Full). What
/// came of it is told by [`LitByStatus`]. Entities with
/// [`StaticLighting`](crate::plugin::radiosity::StaticLighting) of their own or above are left to the bake.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq)]
#[require(BakedScene = only_indirect(), LitByStatus)]
#[reflect(Component, Debug, Clone, PartialEq)]
pub struct LitBy(pub Handle<LightBake>);

fn only_indirect() -> BakedScene {
    BakedScene {
        direct: false,
        ..default()
    }
}

/// How far the meshes below a [`LitBy`] have their light.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct LitByStatus {
    /// Meshes that have it.
    pub lit: usize,
    /// Meshes that are waited for: not spawned, not loaded, or not at all there.
    pub waiting: usize,
    /// Why others have none, one sentence each with the cause and the cure.
    pub problems: Vec<String>,
}

/// Meshes that are not there after so long are told of.
const PATIENCE: Duration = Duration::from_secs(10);

pub(in crate::plugin) fn plugin(app: &mut App) {
    app.init_asset::<LightBake>()
        .init_asset_loader::<LightBakeLoader>()
        .register_type::<LightBakeId>()
        .register_type::<LitBy>()
        .register_type::<LitByStatus>()
        .add_systems(Update, show.run_if(any_with_component::<LitBy>));
}

/// What a root has still to get.
struct Progress {
    bake: AssetId<LightBake>,
    /// Objects of the bake that are done with, well or not.
    done: HashSet<usize>,
    since: Duration,
    is_told: bool,
}

#[derive(SystemParam)]
struct Below<'w, 's> {
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    meshes: Query<'w, 's, (&'static Mesh3d, Has<Displacement>)>,
    baked_here: StaticMarks<'w, 's>,
    ids: Query<'w, 's, &'static LightBakeId>,
    names: Query<'w, 's, &'static Name>,
}

impl Below<'_, '_> {
    /// Meshes below a root, by how they are called.
    fn by_call(&self, root: Entity) -> HashMap<Called, Vec<Entity>> {
        let mut by_call: HashMap<Called, Vec<Entity>> = HashMap::default();
        for entity in std::iter::once(root).chain(self.children.iter_descendants(root)) {
            if self.meshes.contains(entity) {
                let called = called(entity, root, (&self.ids, &self.names), &self.parents);
                by_call.entry(called).or_default().push(entity);
            }
        }
        by_call
    }
}

/// What can bring a mesh that is waited for.
#[derive(SystemParam)]
struct News<'w, 's> {
    entities: Query<
        'w,
        's,
        (),
        Or<(
            Changed<Mesh3d>,
            Changed<Name>,
            Changed<LightBakeId>,
            Changed<ChildOf>,
        )>,
    >,
    meshes: MessageReader<'w, 's, AssetEvent<Mesh>>,
}

impl News<'_, '_> {
    /// Whether there are any since the last time.
    fn read(&mut self) -> bool {
        let any_mesh = self.meshes.read().count() > 0;
        any_mesh || !self.entities.is_empty()
    }
}

fn show(
    mut commands: Commands,
    mut roots: Query<(Entity, &LitBy, &mut LitByStatus)>,
    mut news: News,
    below: Below,
    (bakes, server): (Res<Assets<LightBake>>, Option<Res<AssetServer>>),
    mut meshes: ResMut<Assets<Mesh>>,
    time: Res<Time<Real>>,
    mut progress: Local<HashMap<Entity, Progress>>,
) {
    progress.retain(|root, _| roots.contains(*root));
    let any_news = news.read();
    for (root, LitBy(handle), mut status) in &mut roots {
        let Some(bake) = bakes.get(handle) else {
            let state = server.as_ref().map(|server| server.load_state(handle));
            if let (Some(LoadState::Failed(error)), true) = (state, status.problems.is_empty()) {
                status.problems.push(error.to_string());
            }
            continue;
        };
        let is_first_look = !progress.contains_key(&root);
        let entry = progress.entry(root).or_insert_with(|| Progress {
            bake: handle.id(),
            done: HashSet::default(),
            since: time.elapsed(),
            is_told: false,
        });
        if entry.bake != handle.id() {
            // Meshes that have light are no longer those that were lit: only a new root can get other light.
            let problem = "LitBy cannot be given another bake: spawn the scene anew".to_owned();
            if !status.problems.contains(&problem) {
                error!("{problem}");
                status.problems.push(problem);
            }
            continue;
        }
        if entry.done.len() == bake.objects.len() {
            continue;
        }
        let by_call = if is_first_look || any_news {
            below.by_call(root)
        } else {
            HashMap::default()
        };
        for (o, object) in bake.objects.iter().enumerate() {
            if entry.done.contains(&o) {
                continue;
            }
            match find(object, &by_call, &below, &meshes) {
                Found::Later => continue,
                Found::Never(problem) => {
                    error!("{problem}");
                    status.problems.push(problem);
                }
                Found::Mesh(entity, lit) => {
                    commands.entity(entity).try_insert(Mesh3d(meshes.add(*lit)));
                    status.lit += 1;
                }
            }
            entry.done.insert(o);
        }
        let waiting = bake.objects.len() - entry.done.len();
        if status.waiting != waiting {
            status.waiting = waiting;
        }
        if !entry.is_told && time.elapsed() - entry.since > PATIENCE && waiting > 0 {
            entry.is_told = true;
            tell_missing(bake, &entry.done);
        }
    }
}

fn tell_missing(bake: &LightBake, done: &HashSet<usize>) {
    let missing = (0..bake.objects.len()).filter(|o| !done.contains(o));
    let names: Vec<String> = missing
        .map(|o| bake.objects[o].identity.called.to_string())
        .collect();
    warn!(
        "light is there for {} meshes that are not: {}; were they renamed, or did they fail to load?",
        names.len(),
        names.join(", ")
    );
}

enum Found {
    /// It is not there, or its mesh is not.
    Later,
    Never(String),
    Mesh(Entity, Box<Mesh>),
}

/// The one entity that an object's light is for, and its mesh with light.
fn find(
    object: &BakedObject,
    by_call: &HashMap<Called, Vec<Entity>>,
    below: &Below,
    meshes: &Assets<Mesh>,
) -> Found {
    let name = &object.identity.called;
    let Some(entities) = by_call.get(name) else {
        return Found::Later;
    };
    let mut own = None;
    for &entity in entities {
        let Ok((mesh, is_displaced)) = below.meshes.get(entity) else {
            return Found::Later;
        };
        let Some(mesh) = meshes.get(mesh) else {
            return Found::Later;
        };
        if is_displaced || below.baked_here.in_effect(entity).is_some() {
            return Found::Never(format!(
                "{name} is baked or displaced in this run: take StaticLighting and Displacement off it, or LitBy off \
                 its root"
            ));
        }
        let data = match read(mesh) {
            Ok(data) => data,
            Err(problem) => return Found::Never(format!("{name} gets no light: {problem}")),
        };
        if MeshIdentity::of(&data) != object.identity.mesh {
            continue;
        }
        if own.replace((entity, mesh, data)).is_some() {
            return Found::Never(format!(
                "two are called {name} and have the same mesh: give each a LightBakeId of its own, and bake again"
            ));
        }
    }
    let Some((entity, mesh, data)) = own else {
        return Found::Never(format!(
            "{name} has another mesh than the one that was lit: bake again"
        ));
    };
    let vectors = |values: &[[f32; 3]]| -> Vec<Vec3> { values.iter().map(|&v| v.into()).collect() };
    let refinement = object.refinement();
    if refinement.is_none() && object.light.len() != data.positions.len() {
        return Found::Never(format!(
            "the light of {name} is damaged: bake and save it again"
        ));
    }
    let lit = lit_mesh(
        mesh,
        &data.triangles,
        refinement.as_ref(),
        &vectors(&object.light),
        &vectors(&object.gradient),
    );
    Found::Mesh(entity, lit.into())
}
