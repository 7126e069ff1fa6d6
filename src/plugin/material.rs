//! The material that shows relief and baked light: Bevy's standard material and one extension.

use bevy::material::OpaqueRendererMethod;
use bevy::mesh::{MeshVertexBufferLayout, MeshVertexBufferLayoutRef, VertexAttributeDescriptor};
use bevy::pbr::{
    ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
    MeshPipelineKey,
};
use bevy::prelude::*;
use bevy::render::render_resource::{RenderPipelineDescriptor, SpecializedMeshPipelineError};
use bevy::shader::ShaderDefVal;

use super::bump::{self, ATTRIBUTE_U_GRADIENT, ATTRIBUTE_V_GRADIENT, Bump, BumpKey};
use super::view::{self, FrescoView, ShownInstead};
use super::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT, shaders};

/// [`StandardMaterial`] that shows what this crate makes of a surface: relief ([`Bump`]) and baked light.
///
/// On a mesh with [`ATTRIBUTE_BAKED_LIGHT`] the light is added where Bevy adds that of a
/// [`Lightmap`](bevy::pbr::Lightmap), and the same rules hold: lights, ambient light and probes
/// that say they do not affect lightmapped meshes keep only their specular part. An entity that
/// has a `Lightmap` shows that instead. With [`ATTRIBUTE_BAKED_LIGHT_GRADIENT`] beside it the light answers to
/// bumps and normal maps. On any other mesh and without bumps it *is* the standard material: Bevy's own shaders
/// draw it.
///
/// In the deferred renderer Bevy adds lights' diffuse part to lightmapped meshes whatever the
/// lights say. Materials under baked lights must be drawn forward:
/// `base.opaque_render_method = OpaqueRendererMethod::Forward`.
pub type FrescoMaterial = ExtendedMaterial<StandardMaterial, FrescoExtension>;

/// What [`FrescoMaterial`] has beyond the standard material.
#[derive(Asset, Reflect, Debug, Clone)]
#[reflect(Default, Debug, Clone)]
pub struct FrescoExtension {
    /// Multiplies baked light, from 0 (dark) on; 1 shows it as it was baked.
    pub baked_light_gain: f32,
    /// Relief of the surface.
    pub bump: Option<Bump>,
    /// Finer relief on top of it: slopes of both add up.
    pub detail: Option<Bump>,
    /// Set by [`FrescoView`] on all materials.
    #[doc(hidden)]
    #[reflect(ignore)]
    pub instead: ShownInstead,
}

/// What pipelines of [`FrescoMaterial`] differ by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FrescoKey {
    pub(super) bumps: BumpKey,
    pub(super) instead: ShownInstead,
}

impl Default for FrescoExtension {
    fn default() -> Self {
        Self {
            baked_light_gain: 1.0,
            bump: None,
            detail: None,
            instead: ShownInstead::Nothing,
        }
    }
}

/// Where Bevy may choose, lit surfaces are drawn forward: its deferred lighting would add the diffuse
/// part of lights that are wholly baked a second time.
pub(super) fn drawn_forward(original: &StandardMaterial) -> StandardMaterial {
    let mut material = original.clone();
    if material.opaque_render_method == OpaqueRendererMethod::Auto {
        material.opaque_render_method = OpaqueRendererMethod::Forward;
    }
    material
}

/// Where attributes enter the vertex shader: Bevy's own end at 7.
const BAKED_LIGHT_LOCATION: u32 = 8;
const GRADIENT_LOCATION: u32 = 9;
const U_GRADIENT_LOCATION: u32 = 12;
const V_GRADIENT_LOCATION: u32 = 13;

/// Where Bevy's prepasses have the normal.
const PREPASS_NORMAL_LOCATION: u32 = 3;

/// The pass that a pipeline is for.
#[derive(Clone, Copy, PartialEq)]
enum Pass {
    Forward,
    Deferred,
    /// The prepass that writes normals, and nothing for the deferred renderer.
    Normals,
    /// Depth alone, shadows, motion vectors: of surfaces that may be cut out.
    Cut,
    /// The same of others.
    Other,
}

impl Pass {
    fn of(shader_defs: &[ShaderDefVal]) -> Self {
        let has = |name: &str| {
            let is_it =
                |def: &ShaderDefVal| matches!(def, ShaderDefVal::Bool(n, true) if n == name);
            shader_defs.iter().any(is_it)
        };
        if !has("PREPASS_PIPELINE") {
            Self::Forward
        } else if has("DEFERRED_PREPASS") {
            Self::Deferred
        } else if has("NORMAL_PREPASS") {
            Self::Normals
        } else if has("MAY_DISCARD") {
            Self::Cut
        } else {
            Self::Other
        }
    }
}

/// What is shown of a mesh in a pass.
struct Shown {
    bumps: BumpKey,
    /// Gradients of texture coordinates come from the mesh.
    has_uv_gradients: bool,
    has_baked_light: bool,
    /// Normals are mapped by Bevy.
    has_normal_map: bool,
    /// Baked light answers to what turns normals.
    has_light_gradient: bool,
}

impl Shown {
    fn new(
        pass: Pass,
        layout: &MeshVertexBufferLayout,
        lightmapped: bool,
        bumps: BumpKey,
        shader_defs: &[ShaderDefVal],
    ) -> Self {
        let has_uv = [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1].map(|uv| layout.contains(uv));
        let is_drawn = match pass {
            Pass::Forward | Pass::Deferred | Pass::Normals => true,
            Pass::Cut => bumps.on_mesh(has_uv).has_parallax(),
            Pass::Other => false,
        };
        let bumps = if is_drawn && layout.contains(Mesh::ATTRIBUTE_NORMAL) {
            bumps.on_mesh(has_uv)
        } else {
            BumpKey::default()
        };
        let has_baked_light = matches!(pass, Pass::Forward | Pass::Deferred)
            && !lightmapped
            && layout.contains(ATTRIBUTE_BAKED_LIGHT);
        // Bevy maps normals by tangents, and ignores the map where there are none.
        let has_normal_map = layout.contains(Mesh::ATTRIBUTE_TANGENT)
            && shader_defs.contains(&"STANDARD_MATERIAL_NORMAL_MAP".into());
        Self {
            bumps,
            // Bevy's vertex shader draws what is only cut out.
            has_uv_gradients: pass != Pass::Cut
                && bumps.uses_uv_a()
                && layout.contains(ATTRIBUTE_U_GRADIENT)
                && layout.contains(ATTRIBUTE_V_GRADIENT),
            has_baked_light,
            has_normal_map,
            has_light_gradient: has_baked_light
                && (has_normal_map || bumps.is_any())
                && layout.contains(ATTRIBUTE_BAKED_LIGHT_GRADIENT),
        }
    }

    fn vertex_attributes(&self) -> Vec<VertexAttributeDescriptor> {
        let light = ATTRIBUTE_BAKED_LIGHT.at_shader_location(BAKED_LIGHT_LOCATION);
        let of_light = ATTRIBUTE_BAKED_LIGHT_GRADIENT.at_shader_location(GRADIENT_LOCATION);
        let gradients = [
            ATTRIBUTE_U_GRADIENT.at_shader_location(U_GRADIENT_LOCATION),
            ATTRIBUTE_V_GRADIENT.at_shader_location(V_GRADIENT_LOCATION),
        ];
        let light = self.has_baked_light.then_some(light);
        let of_light = self.has_light_gradient.then_some(of_light);
        let gradients = self.has_uv_gradients.then_some(gradients);
        light
            .into_iter()
            .chain(of_light)
            .chain(gradients.into_iter().flatten())
            .collect()
    }

    /// Shader definitions of both stages.
    fn shader_defs(&self) -> Vec<ShaderDefVal> {
        let of_vertices = [
            (self.has_baked_light, "VERTEX_BAKED_LIGHT"),
            (self.has_uv_gradients, "VERTEX_UV_GRADIENTS"),
            (self.has_light_gradient, shaders::GRADIENT),
            (self.has_normal_map, "FRESCO_NORMAL_MAP"),
        ];
        let of_vertices = of_vertices
            .into_iter()
            .filter_map(|(is, name)| is.then_some(name));
        of_vertices
            .chain(self.bumps.shader_defs())
            .map(Into::into)
            .collect()
    }
}

impl MaterialExtension for FrescoExtension {
    /// Puts our shaders in the place of Bevy's where there is relief or baked light to show, and nowhere
    /// else: shadows and depth are drawn by Bevy's own, as cheaply as ever, but for holes seen by parallax.
    fn specialize(
        _pipeline: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let (Some(fragment), Some(buffer)) = (
            descriptor.fragment.as_mut(),
            descriptor.vertex.buffers.first_mut(),
        ) else {
            return Ok(());
        };
        let pass = Pass::of(&fragment.shader_defs);
        let lightmapped = key.mesh_key.contains(MeshPipelineKey::LIGHTMAPPED);
        let FrescoKey { bumps, instead } = key.bind_group_data;
        let shown = Shown::new(pass, &layout.0, lightmapped, bumps, &fragment.shader_defs);
        if !shown.bumps.is_any() && !shown.has_baked_light {
            return Ok(());
        }
        let attributes = shown.vertex_attributes();
        let has_attributes = !attributes.is_empty();
        let attributes = layout.0.get_layout(&attributes)?.attributes;
        buffer.attributes.extend(attributes);
        let mut defs = shown.shader_defs();
        if pass == Pass::Cut {
            // Bevy's vertex shader passes normals on under these names.
            let normal = Mesh::ATTRIBUTE_NORMAL.at_shader_location(PREPASS_NORMAL_LOCATION);
            (buffer.attributes).extend(layout.0.get_layout(&[normal])?.attributes);
            let names = ["NORMAL_PREPASS_OR_DEFERRED_PREPASS", "VERTEX_NORMALS"].map(Into::into);
            descriptor.vertex.shader_defs.extend(names.iter().cloned());
            defs.extend(names);
        }
        if has_attributes {
            descriptor.vertex.shader = shaders::VERTEX_SHADER;
            descriptor.vertex.shader_defs.extend(defs.iter().cloned());
        }
        fragment.shader_defs.extend(defs);
        (fragment.shader_defs).extend(instead.shader_def().map(Into::into));
        fragment.shader = match pass {
            Pass::Normals => shaders::PREPASS_SHADER,
            Pass::Cut => shaders::CUT_SHADER,
            Pass::Forward | Pass::Deferred | Pass::Other => shaders::FRAGMENT_SHADER,
        };
        // In the deferred pass Bevy adds the light without being told.
        if pass == Pass::Forward && shown.has_baked_light {
            fragment.shader_defs.push(shaders::BAKED_LIGHT.into());
        }
        Ok(())
    }
}

/// Lets [`FrescoMaterial`] be used.
///
/// Part of the crate's other plugins, and safe to add where nothing is drawn.
#[derive(Debug, Default, Clone, Copy)]
pub struct FrescoMaterialPlugin;

impl Plugin for FrescoMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<FrescoMaterial>::default(),
            shaders::plugin,
            bump::plugin,
        ))
        .init_resource::<FrescoView>()
        .add_systems(
            PostUpdate,
            view::show.run_if(resource_exists::<FrescoView>.and_then(view::may_differ)),
        )
        .register_type::<FrescoView>()
        .register_type::<FrescoExtension>()
        .register_asset_reflect::<FrescoMaterial>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn can_be_added_where_nothing_is_drawn() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), FrescoMaterialPlugin));
        app.finish();
        for _ in 0..10 {
            app.update();
        }
        let mut materials = app.world_mut().resource_mut::<Assets<FrescoMaterial>>();
        let handle = materials.add(FrescoMaterial::default());
        let gain = materials.get(&handle).map(|m| m.extension.baked_light_gain);
        assert_eq!(gain, Some(1.0));
    }
}
