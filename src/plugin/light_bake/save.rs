use bevy::ecs::system::SystemState;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::asset::{BakedObject, LightBake};
use super::identity::{Called, Identity, LightBakeId, MeshIdentity, called};
use crate::plugin::displacement::Displacement;
use crate::plugin::radiosity::mesh_data::{MeshProblem, read};
use crate::plugin::radiosity::{BakedLighting, RadiosityStatus};
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT, FrescoView};

/// Why the light of a world cannot be saved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightBakeError {
    /// A bake is running or due.
    #[error("the light is not that of the world: wait until RadiosityStatus::is_up_to_date")]
    NotUpToDate,
    /// Meshes carry something else than all of their light.
    #[error(
        "surfaces show a part of their light or something else: set FrescoView to Shaded first"
    )]
    View,
    /// There is nothing to save.
    #[error("no mesh below the root has baked light: put StaticLighting on it, and bake")]
    Nothing,
    /// Two entities cannot be told apart.
    #[error("two are called {0} and have the same mesh: give each a LightBakeId of its own")]
    Ambiguous(String),
    /// A mesh is moved by a height map in each run anew.
    #[error(
        "{0} has a Displacement, whose mesh is made anew in each run: displace the file itself with `fresco displace`, \
         or take StaticLighting off the entity"
    )]
    Displaced(String),
    /// A mesh cannot be read.
    #[error("{0}: {1}")]
    Mesh(String, MeshProblem),
}

type Lit = (Entity, &'static Mesh3d, &'static BakedLighting);
type Looked<'w, 's> = (
    Query<'w, 's, Lit>,
    Query<'w, 's, (), With<Displacement>>,
    (
        Query<'w, 's, &'static LightBakeId>,
        Query<'w, 's, &'static Name>,
    ),
    Query<'w, 's, &'static ChildOf>,
    Res<'w, Assets<Mesh>>,
);

impl LightBake {
    /// The light that [`RadiosityPlugin`](crate::plugin::RadiosityPlugin) put onto the meshes of `root` and below.
    ///
    /// # Errors
    ///
    /// There is no such light or it is not up to date, or an entity could not be found again.
    pub fn of(world: &mut World, root: Entity) -> Result<Self, LightBakeError> {
        let status = world.get_resource::<RadiosityStatus>();
        if !status.is_some_and(RadiosityStatus::is_up_to_date) {
            return Err(LightBakeError::NotUpToDate);
        }
        let view = world.get_resource::<FrescoView>();
        if view.is_some_and(|view| !view.keeps_light()) {
            return Err(LightBakeError::View);
        }
        let mut state = SystemState::<Looked>::new(world);
        let looked = state
            .get(world)
            .expect("assets of meshes are there where light is");
        collect(root, &looked)
    }
}

fn collect(root: Entity, looked: &Looked) -> Result<LightBake, LightBakeError> {
    let (lit, displaced, names, parents, meshes) = looked;
    let mut objects = Vec::new();
    let mut known: HashSet<Identity> = HashSet::default();
    for (entity, shown, baked) in lit {
        let is_below = entity == root || parents.iter_ancestors(entity).any(|above| above == root);
        if !is_below || shown.0 != baked.lit {
            continue;
        }
        let called = called(entity, root, (&names.0, &names.1), parents);
        if displaced.contains(entity) {
            return Err(LightBakeError::Displaced(called.to_string()));
        }
        let (Some(source), Some(mesh)) = (meshes.get(&baked.source), meshes.get(&baked.lit)) else {
            continue;
        };
        let identity = identity(called, source)?;
        if !known.insert(identity.clone()) {
            return Err(LightBakeError::Ambiguous(identity.called.to_string()));
        }
        let values = |attribute| {
            let values = mesh.try_attribute(attribute).ok()?;
            Some(values.as_float3()?.to_vec())
        };
        if let Some(light) = values(ATTRIBUTE_BAKED_LIGHT) {
            let gradient = values(ATTRIBUTE_BAKED_LIGHT_GRADIENT).unwrap_or_default();
            let refinement = baked.refinement.as_deref();
            objects.push(BakedObject::new(identity, refinement, light, gradient));
        }
    }
    if objects.is_empty() {
        return Err(LightBakeError::Nothing);
    }
    // The order of a query is no one's.
    objects.sort_by_cached_key(|object| object.identity.called.to_string());
    Ok(LightBake { objects })
}

fn identity(called: Called, source: &Mesh) -> Result<Identity, LightBakeError> {
    match read(source) {
        Ok(data) => Ok(Identity {
            mesh: MeshIdentity::of(&data),
            called,
        }),
        Err(problem) => Err(LightBakeError::Mesh(called.to_string(), problem)),
    }
}
