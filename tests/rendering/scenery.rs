//! Meshes, lightmaps and materials the pictures are of.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageSampler, ImageSamplerDescriptor};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, FrescoExtension, FrescoMaterial};

/// Vertices on a side of [`grid`], and texels on a side of [`lightmap`].
pub(crate) const SIDE: u32 = 33;

/// A square of ±1 m that faces +Z, with both UV sets; a vertex lies on each texel of a lightmap.
pub(crate) fn grid() -> Mesh {
    let n = SIDE;
    let at = |i: u32| i as f32 / (n - 1) as f32;
    let texel = |i: u32| (i as f32 + 0.5) / n as f32;
    let corners = || (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
    let quads = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| y * n + x));
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            corners()
                .map(|(x, y)| [2.0 * at(x) - 1.0, 1.0 - 2.0 * at(y), 0.0])
                .collect::<Vec<_>>(),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_NORMAL,
            vec![[0.0, 0.0, 1.0]; (n * n) as usize],
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            corners().map(|(x, y)| [at(x), at(y)]).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_1,
            corners()
                .map(|(x, y)| [texel(x), texel(y)])
                .collect::<Vec<_>>(),
        )
        .with_inserted_indices(Indices::U32(
            quads
                .flat_map(|i| [i, i + n, i + 1, i + 1, i + n, i + n + 1])
                .collect(),
        ))
}

/// Light of vertex or texel (x, y): smooth, different in each channel, about 1000 cd/m².
fn light_at(x: u32, y: u32) -> [f32; 3] {
    let [u, v] = [x, y].map(|i| i as f32 / (SIDE - 1) as f32);
    [
        200.0 + 1000.0 * u,
        100.0 + 900.0 * v,
        600.0 + 400.0 * (3.0 * (u - v)).sin(),
    ]
}

/// `mesh` with the same light on every vertex.
pub(crate) fn lit(mesh: Mesh, light: Vec3) -> Mesh {
    let count = mesh.count_vertices();
    mesh.with_inserted_attribute(ATTRIBUTE_BAKED_LIGHT, vec![light.to_array(); count])
}

/// The grid with [`light_at`] on its vertices.
pub(crate) fn grid_lit_unevenly() -> Mesh {
    let light: Vec<_> = (0..SIDE)
        .flat_map(|y| (0..SIDE).map(move |x| light_at(x, y)))
        .collect();
    grid().with_inserted_attribute(ATTRIBUTE_BAKED_LIGHT, light)
}

/// The same light as [`grid_lit_unevenly`], in a texture for `UV_1`.
pub(crate) fn lightmap() -> Image {
    let texels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| light_at(x, y)));
    let bytes = texels
        .flat_map(|[r, g, b]| [r, g, b, 1.0])
        .flat_map(|v| half(v).to_le_bytes())
        .collect();
    let mut image = Image::new(
        Extent3d {
            width: SIDE,
            height: SIDE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        bytes,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::all(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor::linear());
    image
}

/// A finite, normal, positive number as the nearest half.
fn half(value: f32) -> u16 {
    let bits = value.to_bits() + 0x1000;
    let exponent = ((bits >> 23) & 0xFF) as i32 - 127 + 15;
    assert!((1..31).contains(&exponent), "{value} is no half");
    ((exponent as u16) << 10) | ((bits >> 13) & 0x3FF) as u16
}

/// 2×2 texels, in sRGB bytes; alpha is 255, 64, 255, 64.
pub(crate) fn checker() -> Image {
    let texels: [[u8; 4]; 4] = [
        [255, 255, 255, 255],
        [128, 64, 32, 64],
        [180, 128, 100, 255],
        [200, 200, 0, 64],
    ];
    let mut image = Image::new(
        Extent3d {
            width: 2,
            height: 2,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.concat(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::all(),
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// Adds an asset to its collection.
pub(crate) fn add<A: Asset>(world: &mut World, asset: A) -> Handle<A> {
    world.resource_mut::<Assets<A>>().add(asset)
}

/// The standard material in ours.
pub(crate) fn fresco(base: StandardMaterial) -> FrescoMaterial {
    FrescoMaterial {
        base,
        extension: FrescoExtension::default(),
    }
}

/// Shows `mesh` in our material.
pub(crate) fn show_fresco(
    world: &mut World,
    mesh: Mesh,
    base: StandardMaterial,
    at: Transform,
) -> Entity {
    let mesh = Mesh3d(add(world, mesh));
    let material = MeshMaterial3d(add(world, fresco(base)));
    world.spawn((mesh, material, at)).id()
}

/// Shows `mesh` in Bevy's material.
pub(crate) fn show_bevy(
    world: &mut World,
    mesh: Mesh,
    base: StandardMaterial,
    at: Transform,
) -> Entity {
    let mesh = Mesh3d(add(world, mesh));
    let material = MeshMaterial3d(add(world, base));
    world.spawn((mesh, material, at)).id()
}

/// Two joints, half the weight on each, so that moving one moves the mesh by half of it.
pub(crate) fn skinned(mesh: Mesh) -> Mesh {
    let count = mesh.count_vertices();
    mesh.with_inserted_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; count]),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        vec![[0.5, 0.5, 0.0, 0.0]; count],
    )
}
