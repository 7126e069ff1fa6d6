use std::sync::{Arc, Mutex, PoisonError};

use bevy::asset::AssetId;
use bevy::ecs::system::{SystemParamItem, lifetimeless::SRes};
use bevy::prelude::*;
use bevy::render::render_asset::{PrepareAssetError, RenderAsset, RenderAssetPlugin};
use bevy::render::render_resource::{
    AddressMode, Extent3d, FilterMode, MipmapFilterMode, Sampler, SamplerDescriptor,
    TextureDataOrder, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
    TextureView, TextureViewDescriptor,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;
use bevy::render::{RenderApp, RenderStartup};
use half::f16;

use super::HeightImage;
use super::atlas::Atlas;
use crate::height_map::{Bounds, HeightMap, Level, Moments, Wrap};
use crate::plugin::FrescoMaterial;

/// A [`HeightImage`] where the shader can read it.
#[derive(Debug, Clone)]
pub struct GpuHeightImage {
    /// Slopes and their squares, in units of [`steepest`](Self::steepest).
    pub(in crate::plugin) slopes: TextureView,
    /// Heights from 0 to 1 as the sum of two halves: one has steps that show, and floats cannot be filtered
    /// everywhere.
    pub(in crate::plugin) heights: TextureView,
    /// How high and how low blocks of it go.
    pub(in crate::plugin) bounds: TextureView,
    pub(in crate::plugin) sampler: Sampler,
    pub(super) size: UVec2,
    pub(super) steepest: f32,
    /// The lowest height, and how much higher the highest is.
    pub(super) range: Vec2,
    pub(super) wrap: [Wrap; 2],
}

/// A map without relief, in the place of those that are not there.
#[derive(Resource, Debug, Deref)]
pub struct FlatHeightImage(GpuHeightImage);

/// Maps that have come to the graphics card since materials were last told.
#[derive(Resource, Clone, Debug, Default)]
pub struct ArrivedHeightImages(Arc<Mutex<Vec<AssetId<HeightImage>>>>);

pub(super) fn plugin(app: &mut App) {
    let arrived = ArrivedHeightImages::default();
    let Some(renderer) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    renderer
        .insert_resource(arrived.clone())
        .add_systems(RenderStartup, make_flat);
    app.insert_resource(arrived)
        .add_plugins(RenderAssetPlugin::<GpuHeightImage, GpuImage>::default())
        .add_systems(PreUpdate, rebind);
}

fn make_flat(mut commands: Commands, device: Res<RenderDevice>, queue: Res<RenderQueue>) {
    let map = HeightMap::new([1, 1], vec![0.0], [Wrap::Repeat; 2]);
    match map {
        Ok(map) => {
            let flat = upload(&HeightImage::new(map), &device, &queue);
            commands.insert_resource(FlatHeightImage(flat));
        }
        Err(error) => error!("a flat height map could not be made: {error}"),
    }
}

/// Materials were drawn without the maps that they waited for: has them bound again.
fn rebind(arrived: Res<ArrivedHeightImages>, materials: Option<ResMut<Assets<FrescoMaterial>>>) {
    let Some(mut materials) = materials else {
        return;
    };
    let mut ids = arrived.0.lock().unwrap_or_else(PoisonError::into_inner);
    let ids = std::mem::take(&mut *ids);
    if ids.is_empty() {
        return;
    }
    let waited = |material: &FrescoMaterial| {
        let extension = &material.extension;
        let bumps = [&extension.bump, &extension.detail];
        (bumps.into_iter().flatten()).any(|bump| ids.contains(&bump.map.id()))
    };
    let waiting = materials.iter().filter(|(_, material)| waited(material));
    let waiting: Vec<_> = waiting.map(|(id, _)| id).collect();
    for id in waiting {
        if let Some(material) = materials.get_mut(id) {
            // This alone says that it has changed.
            material.into_inner();
        }
    }
}

impl RenderAsset for GpuHeightImage {
    type SourceAsset = HeightImage;
    type Param = (
        SRes<RenderDevice>,
        SRes<RenderQueue>,
        SRes<ArrivedHeightImages>,
    );

    fn byte_len(map: &HeightImage) -> Option<usize> {
        let texels = map.pyramid().levels().iter().map(|l| l.texels().len());
        Some(texels.sum::<usize>() * (SLOPE_BYTES + HEIGHT_BYTES + BOUNDS_BYTES))
    }

    fn prepare_asset(
        map: HeightImage,
        id: AssetId<HeightImage>,
        (device, queue, arrived): &mut SystemParamItem<Self::Param>,
        _: Option<&Self>,
    ) -> Result<Self, PrepareAssetError<HeightImage>> {
        let uploaded = upload(&map, device, queue);
        if uploaded.size.to_array() != map.map().size() {
            warn!(
                "height map {id}: {:?} texels are more than the graphics card takes; shown with {}",
                map.map().size(),
                uploaded.size
            );
        }
        let mut arrived = arrived.0.lock().unwrap_or_else(PoisonError::into_inner);
        arrived.push(id);
        Ok(uploaded)
    }
}

const SLOPE_BYTES: usize = 8;
const HEIGHT_BYTES: usize = 4;
const BOUNDS_BYTES: usize = 2;

fn upload(map: &HeightImage, device: &RenderDevice, queue: &RenderQueue) -> GpuHeightImage {
    let most = device.limits().max_texture_dimension_2d;
    let pyramid = map.pyramid();
    let levels = pyramid.levels();
    let too_large = |level: &&Level| level.size().iter().any(|&n| n > most);
    let levels = &levels[levels.iter().take_while(too_large).count()..];
    let steepest = pyramid.steepest();
    let [low, high] = pyramid.range();
    let range = Vec2::new(low, high - low);
    let of_texels = |format, texel: &dyn Fn(&Moments, &mut Vec<u8>)| {
        let mut data = Vec::new();
        for moments in levels.iter().flat_map(Level::texels) {
            texel(moments, &mut data);
        }
        let size = levels.first().map_or([1, 1], Level::size);
        create(device, queue, size, levels.len() as u32, format, &data)
    };
    let slopes = of_texels(TextureFormat::Rgba16Float, &|m, data| {
        let unit = if steepest > 0.0 { 1.0 / steepest } else { 0.0 };
        let [a, b] = [m.slopes * unit, m.squares * unit * unit];
        put(data, [a.x, a.y, b.x, b.y]);
    });
    let heights = of_texels(TextureFormat::Rg16Float, &|m, data| {
        let height = if range.y > 0.0 {
            (m.height - range.x) / range.y
        } else {
            0.0
        };
        let most = f16::from_f32(height).to_f32();
        put(data, [most, height - most]);
    });
    let bounds = Bounds::new(map.map(), pyramid);
    let bounds = Atlas::new(&bounds.levels()[pyramid.levels().len() - levels.len()..]);
    GpuHeightImage {
        slopes,
        heights,
        bounds: create(
            device,
            queue,
            bounds.size,
            1,
            TextureFormat::Rgba8Unorm,
            &bounds.texels,
        ),
        sampler: device.create_sampler(&sampler(map)),
        size: levels.first().map_or(UVec2::ONE, |l| l.size().into()),
        steepest,
        range,
        wrap: map.map().wrap(),
    }
}

fn put<const N: usize>(data: &mut Vec<u8>, numbers: [f32; N]) {
    for number in numbers {
        data.extend(f16::from_f32(number).to_le_bytes());
    }
}

fn create(
    device: &RenderDevice,
    queue: &RenderQueue,
    [width, height]: [u32; 2],
    mip_level_count: u32,
    format: TextureFormat,
    data: &[u8],
) -> TextureView {
    let descriptor = TextureDescriptor {
        label: Some("height_map"),
        size: Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = TextureDataOrder::MipMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, data);
    texture.create_view(&TextureViewDescriptor::default())
}

fn sampler(map: &HeightImage) -> SamplerDescriptor<'static> {
    let [u, v] = map.map().wrap().map(|wrap| match wrap {
        Wrap::Repeat => AddressMode::Repeat,
        Wrap::Clamp => AddressMode::ClampToEdge,
    });
    SamplerDescriptor {
        label: Some("height_map"),
        address_mode_u: u,
        address_mode_v: v,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: MipmapFilterMode::Linear,
        anisotropy_clamp: map.anisotropy(),
        ..default()
    }
}
