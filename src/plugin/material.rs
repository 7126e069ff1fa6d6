//! The material that shows baked light: Bevy's standard material and one extension.

use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{
    ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
    MeshPipelineKey,
};
use bevy::prelude::*;
use bevy::render::render_resource::{
    AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
};
use bevy::shader::ShaderDefVal;

use super::shaders;
use super::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};

/// [`StandardMaterial`] that shows what this crate makes of a surface.
///
/// On a mesh with [`ATTRIBUTE_BAKED_LIGHT`] the light is added where Bevy adds that of a
/// [`Lightmap`](bevy::pbr::Lightmap), and the same rules hold: lights, ambient light and probes
/// that say they do not affect lightmapped meshes keep only their specular part. An entity that
/// has a `Lightmap` shows that instead. With [`ATTRIBUTE_BAKED_LIGHT_GRADIENT`] beside it the light answers to
/// normal maps. On any other mesh it *is* the standard material: Bevy's
/// own shaders draw it.
///
/// In the deferred renderer Bevy adds lights' diffuse part to lightmapped meshes whatever the
/// lights say. Materials under baked lights must be drawn forward:
/// `base.opaque_render_method = OpaqueRendererMethod::Forward`.
pub type FrescoMaterial = ExtendedMaterial<StandardMaterial, FrescoExtension>;

/// What [`FrescoMaterial`] has beyond the standard material.
#[derive(Asset, AsBindGroup, Reflect, Debug, Clone)]
#[reflect(Default, Debug, Clone)]
#[uniform(100, FrescoUniform)]
pub struct FrescoExtension {
    /// Multiplies baked light, from 0 (dark) on; 1 shows it as it was baked.
    pub baked_light_gain: f32,
}

impl Default for FrescoExtension {
    fn default() -> Self {
        Self {
            baked_light_gain: 1.0,
        }
    }
}

/// [`FrescoExtension`] as the shader reads it; WebGL2 wants multiples of 16 bytes.
#[derive(ShaderType, Clone, Copy, Debug)]
struct FrescoUniform {
    params: Vec4,
}

impl From<&FrescoExtension> for FrescoUniform {
    fn from(extension: &FrescoExtension) -> Self {
        Self {
            params: Vec4::new(extension.baked_light_gain, 0.0, 0.0, 0.0),
        }
    }
}

/// Where the attribute enters the vertex shader: Bevy's own end at 7.
const BAKED_LIGHT_LOCATION: u32 = 8;
const GRADIENT_LOCATION: u32 = 9;

impl MaterialExtension for FrescoExtension {
    /// Puts our shaders in the place of Bevy's where there is baked light to show, and nowhere
    /// else: shadows, depth and normals are drawn by Bevy's own, as cheaply as ever.
    fn specialize(
        _pipeline: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let has_lightmap = key.mesh_key.contains(MeshPipelineKey::LIGHTMAPPED);
        if has_lightmap || !layout.0.contains(ATTRIBUTE_BAKED_LIGHT) {
            return Ok(());
        }
        let (Some(fragment), Some(buffer)) = (
            descriptor.fragment.as_mut(),
            descriptor.vertex.buffers.first_mut(),
        ) else {
            return Ok(());
        };
        let is_defined = |name: &str| {
            let is_it =
                |def: &ShaderDefVal| matches!(def, ShaderDefVal::Bool(n, true) if n == name);
            fragment.shader_defs.iter().any(is_it)
        };
        let forward = !is_defined("PREPASS_PIPELINE");
        if !forward && !is_defined("DEFERRED_PREPASS") {
            return Ok(());
        }
        // Nothing turns normals but a normal map, which Bevy ignores where there are no tangents.
        let has_gradient = is_defined("STANDARD_MATERIAL_NORMAL_MAP")
            && (layout.0).contains(Mesh::ATTRIBUTE_TANGENT)
            && (layout.0).contains(ATTRIBUTE_BAKED_LIGHT_GRADIENT);
        let light = ATTRIBUTE_BAKED_LIGHT.at_shader_location(BAKED_LIGHT_LOCATION);
        let gradient = ATTRIBUTE_BAKED_LIGHT_GRADIENT.at_shader_location(GRADIENT_LOCATION);
        let attributes = &[light, gradient][..if has_gradient { 2 } else { 1 }];
        let attributes = layout.0.get_layout(attributes)?.attributes;
        buffer.attributes.extend(attributes);
        if has_gradient {
            descriptor.vertex.shader_defs.push(shaders::GRADIENT.into());
            fragment.shader_defs.push(shaders::GRADIENT.into());
        }
        descriptor.vertex.shader = shaders::VERTEX_SHADER;
        fragment.shader = shaders::FRAGMENT_SHADER;
        // In the deferred pass Bevy adds the light without being told.
        if forward {
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
        app.add_plugins((MaterialPlugin::<FrescoMaterial>::default(), shaders::plugin))
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
