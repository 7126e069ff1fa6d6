//! Parallax test 36: textures are read by the gradients of the mesh, not by those of what is seen, which jumps at
//! edges of the relief.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{BumpHeight, HeightImage};

use super::{View, Wall};
use crate::bumps::relief;
use crate::picture::Picture;
use crate::scenery::{add, show_bevy};
use crate::stage::on_stage;

const TEXELS: u32 = 64;

/// Each size of it has its own grey, so that a picture tells which one was read: 1, ½, ¼, …
fn sizes() -> Image {
    let count = TEXELS.ilog2() + 1;
    let level = |i: u32| {
        let texels = (TEXELS >> i) * (TEXELS >> i);
        let grey = 0.5_f32.powi(i as i32);
        std::iter::repeat_n([grey, grey, grey, 1.0], texels as usize)
    };
    let bytes = (0..count)
        .flat_map(level)
        .flatten()
        .flat_map(f32::to_le_bytes);
    let extent = Extent3d {
        width: TEXELS,
        height: TEXELS,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new_uninit(
        extent,
        TextureDimension::D2,
        TextureFormat::Rgba32Float,
        RenderAssetUsages::all(),
    );
    image.data = Some(bytes.collect());
    image.texture_descriptor.mip_level_count = count;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::nearest()
    });
    image
}

fn blocks(texels: u32) -> HeightImage {
    relief([texels; 2], Wrap::Repeat, |u, v| {
        f32::from(u8::from(
            ((8.0 * u) as u32).is_multiple_of(2) && ((8.0 * v) as u32).is_multiple_of(2),
        ))
    })
}

/// Depths for Bevy's own parallax: the same blocks.
fn depth_map() -> Image {
    let map = blocks(TEXELS);
    let bytes = map.map().heights().iter().flat_map(|h| {
        let depth = ((1.0 - h) * 255.0) as u8;
        [depth, depth, depth, 255]
    });
    let extent = Extent3d {
        width: TEXELS,
        height: TEXELS,
        depth_or_array_layers: 1,
    };
    let bytes = bytes.collect();
    let format = TextureFormat::Rgba8Unorm;
    let usage = RenderAssetUsages::all();
    Image::new(extent, TextureDimension::D2, bytes, format, usage)
}

/// Pixels at which another size than the finest was read.
fn seams(picture: &Picture) -> usize {
    let coarse = |p: &&[f32; 4]| p[3] > 0.0 && p[0] < 0.9;
    picture.pixels.iter().filter(coarse).count()
}

#[test]
fn edges_of_relief_show_no_other_sizes_of_textures() {
    let view = View::around(55.0, 0.25);
    let shoot = |is_ours: bool| {
        on_stage(move |stage| {
            stage.size = 128;
            stage.shoot(
                |camera| view.set(camera),
                |world| {
                    let base = StandardMaterial {
                        unlit: true,
                        base_color_texture: Some(add(world, sizes())),
                        cull_mode: None,
                        ..default()
                    };
                    let mut wall = Wall::new(blocks(TEXELS), BumpHeight::Uv(0.1));
                    if is_ours {
                        wall.base = base;
                        wall.show(world);
                    } else {
                        let base = StandardMaterial {
                            depth_map: Some(add(world, depth_map())),
                            ..base
                        };
                        let mesh = wall.mesh().with_generated_tangents().unwrap();
                        show_bevy(world, mesh, base, default());
                    }
                },
            )
        })
    };
    let [ours, bevys] = [true, false].map(|is_ours| seams(&shoot(is_ours)));
    println!("pixels of coarser sizes: {ours}, with Bevy's parallax {bevys}");
    assert_eq!(ours, 0);
    // The picture would show it.
    assert!(bevys > 100, "{bevys}");
}
