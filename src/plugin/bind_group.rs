//! What of the extension is bound beside the standard material.
//!
//! By hand, because height maps are no images of Bevy's. Where the device can, bindless, as the standard material
//! is: the textures of all materials stand in Bevy's arrays, and one bind group serves many materials.

use std::borrow::Cow;
use std::sync::LazyLock;

use bevy::ecs::system::{SystemParamItem, lifetimeless::SRes};
use bevy::prelude::*;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::encase::UniformBuffer;
use bevy::render::render_resource::{
    AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingNumber,
    BindingResources, BindingType, BindlessBufferDescriptor, BindlessDescriptor, BindlessIndex,
    BindlessIndexTableDescriptor, BindlessResourceType, BindlessSlabResourceLimit,
    BufferBindingType, OwnedBindingResource, OwnedData, SamplerBindingType, ShaderStages,
    ShaderType, TextureSampleType, TextureViewDimension, UnpreparedBindGroup,
    create_bindless_bind_group_layout_entries,
};
use bevy::render::renderer::RenderDevice;

use super::bump::{Bump, BumpKey, BumpUniform, FlatHeightImage, GpuHeightImage};
use super::material::{FrescoExtension, FrescoKey};

/// [`FrescoExtension`] as the shader reads it: `Fresco` in `bindings.wgsl`. WebGL2 wants multiples of 16
/// bytes.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
struct FrescoUniform {
    params: Vec4,
    main_bump: BumpUniform,
    detail_bump: BumpUniform,
}

/// Numbers of what is bound; with arrays, of what the table of indices has, as `Indices` in `bindings.wgsl`.
/// Beyond those of the standard material.
const UNIFORM: u32 = 100;
const SLOPES: u32 = 101;
const SAMPLER: u32 = 102;
const HEIGHTS: u32 = 103;
const DETAIL_SLOPES: u32 = 104;
const DETAIL_SAMPLER: u32 = 105;
const BOUNDS: u32 = 106;

/// What each of these is, from [`UNIFORM`] on.
const TYPES: [BindlessResourceType; 7] = {
    use BindlessResourceType::{DataBuffer, SamplerFiltering, Texture2d};
    [
        DataBuffer,
        Texture2d,
        SamplerFiltering,
        Texture2d,
        Texture2d,
        SamplerFiltering,
        Texture2d,
    ]
};

/// Where the table of indices is bound, and the uniforms of all materials.
///
/// The table begins at 0, with all that the standard material has in a table of its own: of two tables `bevy_pbr`
/// 0.19.1 finds only the second when a material goes (`get_bindless_index_table` orders them the wrong way round),
/// and what the first alone has it would never free.
const TABLE: BindingNumber = BindingNumber(100);
const UNIFORMS: BindingNumber = BindingNumber(101);
const TABLE_LENGTH: u32 = BOUNDS + 1;

impl AsBindGroup for FrescoExtension {
    type Data = FrescoKey;
    type Param = (SRes<RenderAssets<GpuHeightImage>>, SRes<FlatHeightImage>);

    fn bindless_slot_count() -> Option<BindlessSlabResourceLimit> {
        Some(BindlessSlabResourceLimit::Auto)
    }

    /// As the standard material is or is not: both are bound in one group.
    fn bindless_supported(device: &RenderDevice) -> bool {
        StandardMaterial::bindless_supported(device)
    }

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
        _: &RenderDevice,
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
        use OwnedBindingResource as R;
        let texture = |view: &_| R::TextureView(TextureViewDimension::D2, Clone::clone(view));
        let sampler =
            |s: &GpuHeightImage| R::Sampler(SamplerBindingType::Filtering, s.sampler.clone());
        Ok(UnpreparedBindGroup {
            bindings: BindingResources(vec![
                (UNIFORM, R::Data(OwnedData(bytes.into_inner()))),
                (SLOPES, texture(&main.slopes)),
                (SAMPLER, sampler(main)),
                (HEIGHTS, texture(&main.heights)),
                (DETAIL_SLOPES, texture(&detail.slopes)),
                (DETAIL_SAMPLER, sampler(detail)),
                (BOUNDS, texture(&main.bounds)),
            ]),
        })
    }

    fn bind_group_layout_entries(
        device: &RenderDevice,
        force_no_bindless: bool,
    ) -> Vec<BindGroupLayoutEntry> {
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let buffer = |ty| BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: Some(FrescoUniform::min_size()),
        };
        if Self::bindless_supported(device) && !force_no_bindless {
            let mut entries = create_bindless_bind_group_layout_entries(
                TABLE_LENGTH,
                BindlessSlabResourceLimit::Auto.resolve(),
                TABLE,
                &TYPES,
            );
            let uniforms = buffer(BufferBindingType::Storage { read_only: true });
            entries.push(entry(*UNIFORMS, uniforms));
            return entries;
        }
        let texture = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: true },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = BindingType::Sampler(SamplerBindingType::Filtering);
        vec![
            entry(UNIFORM, buffer(BufferBindingType::Uniform)),
            entry(SLOPES, texture),
            entry(SAMPLER, sampler),
            entry(HEIGHTS, texture),
            entry(DETAIL_SLOPES, texture),
            entry(DETAIL_SAMPLER, sampler),
            entry(BOUNDS, texture),
        ]
    }

    fn bindless_descriptor() -> Option<BindlessDescriptor> {
        static RESOURCES: LazyLock<Vec<BindlessResourceType>> = LazyLock::new(|| {
            let others = [BindlessResourceType::None; UNIFORM as usize];
            others.into_iter().chain(TYPES).collect()
        });
        let table = BindlessIndexTableDescriptor {
            indices: BindlessIndex(0)..BindlessIndex(TABLE_LENGTH),
            binding_number: TABLE,
        };
        let uniforms = BindlessBufferDescriptor {
            binding_number: UNIFORMS,
            bindless_index: BindlessIndex(UNIFORM),
            size: Some(FrescoUniform::min_size().get() as usize),
        };
        Some(BindlessDescriptor {
            resources: Cow::Borrowed(&RESOURCES),
            buffers: Cow::Owned(vec![uniforms]),
            index_tables: Cow::Owned(vec![table]),
        })
    }
}
