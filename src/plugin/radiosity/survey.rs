use std::borrow::Cow;

use bevy::ecs::system::SystemParam;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use glam::Affine3A;

use super::assets::{Budget, Copy, Look, MaterialId, Sources};
use super::components::{BakedLighting, InEffect, NotBaked, OriginalMaterial, StaticLighting};
use super::key::key;
use super::lights::{FoundLight, Lights};
use super::settings::RadiositySettings;
use crate::plugin::displacement::DisplacementStatus;
use crate::plugin::{FrescoMaterial, FrescoView};

/// All that the bake reads of the world.
#[derive(SystemParam)]
pub(super) struct StaticWorld<'w, 's> {
    objects: Query<'w, 's, ObjectQuery>,
    lights: Lights<'w, 's>,
    ambient: Option<Res<'w, GlobalAmbientLight>>,
    visibility: Res<'w, VisibilityRule>,
    names: Query<'w, 's, &'static Name>,
}

type ObjectQuery = (
    Entity,
    &'static InEffect,
    &'static Mesh3d,
    &'static GlobalTransform,
    Shown,
    (
        Option<&'static OriginalMaterial>,
        Option<&'static MeshMaterial3d<FrescoMaterial>>,
        Option<&'static MeshMaterial3d<StandardMaterial>>,
    ),
    Option<&'static BakedLighting>,
    Option<&'static NotBaked>,
    (Has<SkinnedMesh>, Has<MeshMorphWeights>, Has<Lightmap>),
    Option<&'static DisplacementStatus>,
);

/// What tells whether an entity is shown.
pub(super) type Shown = (
    Option<&'static Visibility>,
    Option<&'static InheritedVisibility>,
);

/// How to tell whether an entity is shown.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VisibilityRule {
    /// Bevy's visibility systems run.
    Inherited,
    /// They do not, as in an app without cameras: an entity's own `Visibility` decides.
    Own,
}

impl VisibilityRule {
    pub(super) fn shown(
        self,
        (own, inherited): (Option<&Visibility>, Option<&InheritedVisibility>),
    ) -> bool {
        match self {
            Self::Inherited => inherited.is_none_or(|v| v.get()),
            Self::Own => own.is_none_or(|v| *v != Visibility::Hidden),
        }
    }
}

/// The static part of the world as it is now.
#[derive(Default)]
pub(super) struct Survey {
    pub(super) objects: Vec<FoundObject>,
    pub(super) lights: Vec<FoundLight>,
    /// cd/m².
    pub(super) sky: Vec3,
    /// Tells this state of the world from others.
    pub(super) key: u64,
    /// Something is still being loaded or copied.
    pub(super) loading: bool,
    /// Entities of which another reason than they carry keeps them out, or none any more.
    pub(super) to_tell: Vec<(Entity, Option<Cow<'static, str>>)>,
}

/// A static mesh.
pub(super) struct FoundObject {
    pub(super) entity: Entity,
    pub(super) transform: Affine3A,
    pub(super) mesh_id: AssetId<Mesh>,
    pub(super) mesh: Copy<Mesh>,
    pub(super) material: Copy<StandardMaterial>,
    pub(super) images: Images,
    pub(super) effect: StaticLighting,
    /// Of the light that it carries.
    pub(super) fingerprint: Option<u64>,
}

/// The images of a material that the bake reads.
#[derive(Clone, Default)]
pub(super) struct Images {
    pub(super) base_color: Option<Copy<Image>>,
    pub(super) emissive: Option<Copy<Image>>,
    pub(super) metallic: Option<Copy<Image>>,
}

impl StaticWorld<'_, '_> {
    /// Looks at everything static. Cheap enough for every frame: nothing is copied that is known.
    pub(super) fn survey(
        &self,
        sources: &mut Sources,
        settings: &RadiositySettings,
        view: FrescoView,
    ) -> Survey {
        let mut survey = Survey {
            lights: self.lights.find(*self.visibility),
            sky: self.sky(settings),
            ..Survey::default()
        };
        let mut budget = Budget::new();
        for object in &self.objects {
            let (entity, told) = (object.0, object.7);
            let reason = match self.object(object, sources, &mut budget) {
                Found::Object(found) => {
                    survey.objects.push(found);
                    None
                }
                Found::Hidden => None,
                Found::Soon => {
                    survey.loading = true;
                    None
                }
                Found::Unfit(reason) => Some(reason),
            };
            if told.map(|t| t.reason.as_str()) != reason.as_deref() {
                survey.to_tell.push((entity, reason));
            }
        }
        // The order of a query changes when entities get components.
        survey.objects.sort_unstable_by_key(|o| o.entity);
        survey.lights.sort_unstable_by_key(|l| l.entity);
        survey.key = key(&survey, settings, view);
        survey
    }

    /// An entity's name, or its number.
    pub(super) fn name(&self, entity: Entity) -> String {
        self.names
            .get(entity)
            .map_or_else(|_| format!("entity {entity}"), |name| name.to_string())
    }

    fn object(
        &self,
        (entity, effect, mesh, transform, shown, material, baked, _, unfit, displacement): <ObjectQuery as bevy::ecs::query::QueryData>::Item<'_, '_>,
        sources: &mut Sources,
        budget: &mut Budget,
    ) -> Found {
        if !self.visibility.shown(shown) {
            return Found::Hidden;
        }
        let (skinned, morphed, lightmapped) = unfit;
        if skinned || morphed {
            return Found::Unfit(
                "it is skinned or morphed: light baked for one pose is wrong for the next; mark it \
                 `NoStaticLighting`"
                    .into(),
            );
        }
        // Light on a mesh that is about to become another would be baked for nothing.
        if displacement.is_some_and(DisplacementStatus::is_pending) {
            return Found::Soon;
        }
        let material_id = match material {
            (Some(original), Some(fresco), _) if original.moved_to == fresco.id() => {
                MaterialId::Standard(original.handle.id())
            }
            (_, Some(fresco), _) => MaterialId::Fresco(fresco.id()),
            (_, _, Some(standard)) => MaterialId::Standard(standard.id()),
            _ => {
                return Found::Unfit(
                    "it has no `MeshMaterial3d` of `StandardMaterial` or `FrescoMaterial`, so how much \
                     light it reflects is not known: give it one"
                        .into(),
                );
            }
        };
        let mesh_id = match baked {
            Some(baked) if baked.lit == mesh.0 => baked.source.id(),
            _ => mesh.id(),
        };
        let mesh = match sources.mesh(mesh_id, budget) {
            Look::Here(mesh) => mesh,
            Look::Soon => return Found::Soon,
            Look::Missing => return Found::Unfit(missing("mesh").into()),
            Look::Unfit(problem) => return Found::Unfit(problem.to_string().into()),
        };
        let material = match sources.material(material_id) {
            Look::Here(material) => material,
            Look::Soon => return Found::Soon,
            Look::Missing | Look::Unfit(_) => return Found::Unfit(missing("material").into()),
        };
        let Some(images) = images(&material.asset, sources, budget) else {
            return Found::Soon;
        };
        Found::Object(FoundObject {
            entity,
            transform: transform.affine(),
            mesh_id,
            mesh,
            material,
            images,
            effect: StaticLighting {
                // It shows its lightmap, whatever is baked.
                receives: effect.0.receives && !lightmapped,
                ..effect.0
            },
            fingerprint: baked.map(|b| b.fingerprint),
        })
    }

    fn sky(&self, settings: &RadiositySettings) -> Vec3 {
        let ambient = (self.ambient.as_ref())
            .filter(|a| !a.affects_lightmapped_meshes)
            .map_or(Vec3::ZERO, |a| a.color.to_linear().to_vec3() * a.brightness);
        settings.sky.to_vec3() + ambient
    }
}

enum Found {
    Object(FoundObject),
    Hidden,
    Soon,
    Unfit(Cow<'static, str>),
}

fn missing(what: &str) -> String {
    format!("its {what} is not loaded: check that the asset exists and that its handle is kept")
}

/// `None` while one is being loaded; a texture that is missing counts as white, as Bevy draws it.
fn images(
    material: &StandardMaterial,
    sources: &mut Sources,
    budget: &mut Budget,
) -> Option<Images> {
    let mut get = |handle: &Option<Handle<Image>>| {
        let Some(handle) = handle else {
            return Some(None);
        };
        match sources.image(handle.id(), budget) {
            Look::Here(image) => Some(Some(image)),
            Look::Soon => None,
            Look::Missing | Look::Unfit(_) => Some(None),
        }
    };
    Some(Images {
        base_color: get(&material.base_color_texture)?,
        emissive: get(&material.emissive_texture)?,
        metallic: get(&material.metallic_roughness_texture)?,
    })
}
