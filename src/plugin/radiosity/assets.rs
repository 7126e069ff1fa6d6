use std::hash::{BuildHasher, Hash, Hasher};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::asset::{AssetServer, LoadState};
use bevy::ecs::system::SystemParam;
use bevy::mesh::VertexAttributeValues;
use bevy::platform::collections::HashMap;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;

use super::mesh_data::{self, MeshProblem};
use crate::plugin::FrescoMaterial;
use crate::plugin::attribute::is_baked;

/// What the main thread may spend a frame on copying assets for the bake; what is over waits for the next
/// frame. One asset a frame is always copied.
const COPY_BUDGET: Duration = Duration::from_micros(300);

/// Copies of the assets that static entities use, as the bake reads them, each with a version that
/// changes when its content does.
#[derive(Resource, Default)]
pub(super) struct Copies {
    meshes: HashMap<AssetId<Mesh>, Result<Copy<Mesh>, MeshProblem>>,
    images: HashMap<AssetId<Image>, Copy<Image>>,
    materials: HashMap<MaterialId, Copy<StandardMaterial>>,
    /// Counts changes of images, whose content is too large to compare.
    image_changes: u64,
}

/// A material by the asset that it is read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MaterialId {
    Standard(AssetId<StandardMaterial>),
    Fresco(AssetId<FrescoMaterial>),
}

/// An asset that is there.
pub(super) struct Copy<A> {
    pub(super) version: u64,
    pub(super) asset: Arc<A>,
}

impl<A> Clone for Copy<A> {
    fn clone(&self) -> Self {
        Self {
            version: self.version,
            asset: self.asset.clone(),
        }
    }
}

/// What asking for a copy of an asset gives.
pub(super) enum Look<A> {
    Here(Copy<A>),
    /// Being loaded, or the frame's budget is spent: ask again.
    Soon,
    /// Neither here nor being loaded.
    Missing,
    /// Here, but not to be baked.
    Unfit(MeshProblem),
}

impl Copies {
    /// Forgets copies of assets that changed.
    pub(super) fn follow(
        mut copies: ResMut<Self>,
        mut meshes: MessageReader<AssetEvent<Mesh>>,
        mut images: MessageReader<AssetEvent<Image>>,
        mut standard: MessageReader<AssetEvent<StandardMaterial>>,
        mut fresco: MessageReader<AssetEvent<FrescoMaterial>>,
    ) {
        for id in meshes.read().filter_map(changed) {
            copies.meshes.remove(&id);
        }
        for id in standard.read().filter_map(changed) {
            copies.materials.remove(&MaterialId::Standard(id));
        }
        for id in fresco.read().filter_map(changed) {
            copies.materials.remove(&MaterialId::Fresco(id));
        }
        for id in images.read().filter_map(changed) {
            if copies.images.remove(&id).is_some() {
                copies.image_changes += 1;
            }
        }
    }

    /// The version of a mesh that was looked at and is fit for baking.
    pub(super) fn mesh_version(&self, id: AssetId<Mesh>) -> Option<u64> {
        Some(self.meshes.get(&id)?.as_ref().ok()?.version)
    }

    pub(super) fn bytes(&self) -> u64 {
        let images = self
            .images
            .values()
            .map(|i| i.asset.data.as_ref().map_or(0, Vec::len));
        let meshes = self.meshes.values().flatten().map(|m| {
            let indices = m.asset.get_index_buffer_bytes().map_or(0, <[u8]>::len);
            m.asset.get_vertex_buffer_size() + indices
        });
        (images.sum::<usize>() + meshes.sum::<usize>()) as u64
    }
}

fn changed<A: Asset>(event: &AssetEvent<A>) -> Option<AssetId<A>> {
    match *event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
            Some(id)
        }
        AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => None,
    }
}

/// Where copies are made from.
#[derive(SystemParam)]
pub(super) struct Sources<'w> {
    copies: ResMut<'w, Copies>,
    meshes: Res<'w, Assets<Mesh>>,
    images: Option<Res<'w, Assets<Image>>>,
    standard: Option<Res<'w, Assets<StandardMaterial>>>,
    fresco: Option<Res<'w, Assets<FrescoMaterial>>>,
    server: Option<Res<'w, AssetServer>>,
}

/// The part of a frame in which copies may be made.
pub(super) struct Budget(Option<Instant>);

impl Budget {
    pub(super) fn new() -> Self {
        Self(None)
    }

    fn spent(&mut self) -> bool {
        let since = *self.0.get_or_insert_with(Instant::now);
        since.elapsed() > COPY_BUDGET
    }
}

impl Sources<'_> {
    pub(super) fn mesh(&mut self, id: AssetId<Mesh>, budget: &mut Budget) -> Look<Mesh> {
        if let Some(known) = self.copies.meshes.get(&id) {
            return look(known);
        }
        let Some(mesh) = self.meshes.get(id) else {
            return self.absent(id.untyped());
        };
        if budget.spent() {
            return Look::Soon;
        }
        let copy = mesh_data::check(mesh).map(|()| Copy {
            version: mesh_version(mesh),
            asset: Arc::new(mesh.clone()),
        });
        let found = look(&copy);
        self.copies.meshes.insert(id, copy);
        found
    }

    pub(super) fn image(&mut self, id: AssetId<Image>, budget: &mut Budget) -> Look<Image> {
        if let Some(copy) = self.copies.images.get(&id) {
            return Look::Here(copy.clone());
        }
        let Some(image) = self.images.as_ref().and_then(|i| i.get(id)) else {
            return self.absent(id.untyped());
        };
        if budget.spent() {
            return Look::Soon;
        }
        let copy = Copy {
            version: self.copies.image_changes,
            asset: Arc::new(image.clone()),
        };
        self.copies.images.insert(id, copy.clone());
        Look::Here(copy)
    }

    pub(super) fn material(&mut self, id: MaterialId) -> Look<StandardMaterial> {
        if let Some(copy) = self.copies.materials.get(&id) {
            return Look::Here(copy.clone());
        }
        let material = match id {
            MaterialId::Standard(id) => self.standard.as_ref().and_then(|m| m.get(id)),
            MaterialId::Fresco(id) => self
                .fresco
                .as_ref()
                .and_then(|m| m.get(id))
                .map(|m| &m.base),
        };
        let Some(material) = material else {
            return self.absent(match id {
                MaterialId::Standard(id) => id.untyped(),
                MaterialId::Fresco(id) => id.untyped(),
            });
        };
        let copy = Copy {
            version: material_version(material),
            asset: Arc::new(material.clone()),
        };
        self.copies.materials.insert(id, copy.clone());
        Look::Here(copy)
    }

    fn absent<A>(&self, id: bevy::asset::UntypedAssetId) -> Look<A> {
        let state = self.server.as_ref().and_then(|s| s.get_load_state(id));
        match state {
            Some(LoadState::Loading) => Look::Soon,
            _ => Look::Missing,
        }
    }
}

fn look(mesh: &Result<Copy<Mesh>, MeshProblem>) -> Look<Mesh> {
    match mesh {
        Ok(copy) => Look::Here(copy.clone()),
        Err(problem) => Look::Unfit(*problem),
    }
}

/// A hash of all that light depends on: everything but the light itself.
pub(in crate::plugin) fn mesh_version(mesh: &Mesh) -> u64 {
    let mut state = FixedHasher.build_hasher();
    mesh.primitive_topology().hash(&mut state);
    for (attribute, values) in mesh.try_attributes().into_iter().flatten() {
        if !is_baked(attribute) {
            attribute.id.hash(&mut state);
            std::mem::discriminant::<VertexAttributeValues>(values).hash(&mut state);
            state.write(values.get_bytes());
        }
    }
    state.write(mesh.get_index_buffer_bytes().unwrap_or_default());
    state.finish()
}

/// A hash of what the bake reads of a material.
fn material_version(material: &StandardMaterial) -> u64 {
    let mut state = FixedHasher.build_hasher();
    let mut floats = |values: &[f32]| {
        for value in values {
            value.to_bits().hash(&mut state);
        }
    };
    floats(&material.base_color.to_linear().to_f32_array());
    floats(&material.emissive.to_f32_array());
    floats(&[material.emissive_exposure_weight, material.metallic]);
    floats(&material.uv_transform.to_cols_array());
    let images = [
        &material.base_color_texture,
        &material.emissive_texture,
        &material.metallic_roughness_texture,
    ];
    for image in images {
        image.as_ref().map(Handle::id).hash(&mut state);
    }
    let channels = [
        &material.base_color_channel,
        &material.emissive_channel,
        &material.metallic_roughness_channel,
    ];
    for channel in channels {
        std::mem::discriminant(channel).hash(&mut state);
    }
    (material.double_sided, material.unlit).hash(&mut state);
    std::mem::discriminant(&material.alpha_mode).hash(&mut state);
    if let AlphaMode::Mask(cutoff) = material.alpha_mode {
        cutoff.to_bits().hash(&mut state);
    }
    state.finish()
}
