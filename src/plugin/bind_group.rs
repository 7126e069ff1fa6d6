//! What of the extension is bound beside the standard material.
//!
//! By hand, because height maps are no images of Bevy's. Not bindless, and with it the whole material: Bevy
//! then gives each material its own bind group, and shaders read the standard material without slots.

use bevy::ecs::system::{SystemParamItem, lifetimeless::SRes};
use bevy::prelude::*;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::encase::UniformBuffer;
use bevy::render::render_resource::{
    AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingResources,
    BindingType, BufferBindingType, BufferInitDescriptor, BufferUsages, OwnedBindingResource,
    SamplerBindingType, ShaderStages, ShaderType, TextureSampleType, TextureViewDimension,
    UnpreparedBindGroup,
};
use bevy::render::renderer::RenderDevice;

use super::bump::{Bump, BumpKey, BumpUniform, FlatHeightImage, GpuHeightImage};
use super::material::{FrescoExtension, FrescoKey};

/// [`FrescoExtension`] as the shader reads it: `Fresco` in `bump/surface.wgsl`. WebGL2 wants multiples of 16
/// bytes.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
struct FrescoUniform {
    params: Vec4,
    main_bump: BumpUniform,
    detail_bump: BumpUniform,
}

const UNIFORM: u32 = 100;
const SLOPES: u32 = 101;
const SAMPLER: u32 = 102;
const HEIGHTS: u32 = 103;
const DETAIL_SLOPES: u32 = 104;
const DETAIL_SAMPLER: u32 = 105;
const BOUNDS: u32 = 106;

impl AsBindGroup for FrescoExtension {
    type Data = FrescoKey;
    type Param = (SRes<RenderAssets<GpuHeightImage>>, SRes<FlatHeightImage>);

    fn label() -> &'static str {
        "fresco_extension"
    }

    fn bind_group_data(&self) -> FrescoKey {
        FrescoKey {
            bumps: BumpKey::new(self.bump.as_ref(), self.detail.as_ref()),
            instead: self.instead,
        }
    }

    fn unprepared_bind_group(
        &self,
        _: &BindGroupLayout,
        device: &RenderDevice,
        (maps, flat): &mut SystemParamItem<'_, '_, Self::Param>,
        _: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        let map_of = |bump: Option<&Bump>| bump.and_then(|b| maps.get(&b.map)).unwrap_or(flat);
        let [main, detail] = [self.bump.as_ref(), self.detail.as_ref()].map(map_of);
        let uniform = FrescoUniform {
            params: Vec4::new(self.baked_light_gain, 0.0, 0.0, 0.0),
            main_bump: BumpUniform::new(self.bump.as_ref(), main),
            detail_bump: BumpUniform::new(self.detail.as_ref(), detail),
        };
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes
            .write(&uniform)
            .map_err(|_| AsBindGroupError::CreateBindGroupDirectly)?;
        let buffer = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("fresco_extension"),
            usage: BufferUsages::COPY_DST | BufferUsages::UNIFORM,
            contents: bytes.as_ref(),
        });
        use OwnedBindingResource as R;
        let texture = |view: &_| R::TextureView(TextureViewDimension::D2, Clone::clone(view));
        let sampler =
            |s: &GpuHeightImage| R::Sampler(SamplerBindingType::Filtering, s.sampler.clone());
        Ok(UnpreparedBindGroup {
            bindings: BindingResources(vec![
                (UNIFORM, R::Buffer(buffer)),
                (SLOPES, texture(&main.slopes)),
                (SAMPLER, sampler(main)),
                (HEIGHTS, texture(&main.heights)),
                (DETAIL_SLOPES, texture(&detail.slopes)),
                (DETAIL_SAMPLER, sampler(detail)),
                (BOUNDS, texture(&main.bounds)),
            ]),
        })
    }

    fn bind_group_layout_entries(_: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let texture = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: true },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = BindingType::Sampler(SamplerBindingType::Filtering);
        let uniform = BindingType::Buffer {
            ty: BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: Some(FrescoUniform::min_size()),
        };
        vec![
            entry(UNIFORM, uniform),
            entry(SLOPES, texture),
            entry(SAMPLER, sampler),
            entry(HEIGHTS, texture),
            entry(DETAIL_SLOPES, texture),
            entry(DETAIL_SAMPLER, sampler),
            entry(BOUNDS, texture),
        ]
    }
}
