use glam::Vec3;
use image::{Rgb, RgbImage};

use super::command::Made;
use crate::height_map::{Encoding, NormalMapSettings, normal_map};

/// Larger sides are made smaller, so that the picture fits a screen.
const SIDE: u32 = 512;

/// Between panels.
const GAP: u32 = 8;

/// Highlights.
const MAGENTA: [f32; 3] = [1.0, 0.0, 1.0];

/// Photo with highlights marked, heights, and the relief lit from the upper left. Images of heights have no
/// photo.
pub(super) fn draw(made: &Made, normals: &NormalMapSettings) -> RgbImage {
    let map = &made.prepared.map;
    let photo = made.photo.as_ref().map(|photo| {
        let mut colours = photo.linear();
        if let Some(mask) = &made.prepared.highlights {
            let marked = colours.iter_mut().zip(mask).filter(|(_, marked)| **marked);
            marked.for_each(|(colour, _)| *colour = MAGENTA);
        }
        colours
    });
    // Heights are numbers, and shown as such: half the height is half the way to white.
    let heights = map.heights().iter().map(|&h| [decoded(h); 3]).collect();
    let relief = shaded(&normal_map(map, normals));
    let panels: Vec<_> = photo.into_iter().chain([heights, relief]).collect();
    side_by_side(&panels, map.size())
}

/// A matte white surface under a lamp at the upper left and some light from all around.
fn shaded(normals: &[Vec3]) -> Vec<[f32; 3]> {
    let lamp = Vec3::new(-1.0, 1.0, 1.2).normalize();
    let light = |n: &Vec3| [0.1 + 0.7 * n.dot(lamp).max(0.0); 3];
    normals.iter().map(light).collect()
}

/// Panels of linear light in one sRGB picture.
fn side_by_side(panels: &[Vec<[f32; 3]>], size: [u32; 2]) -> RgbImage {
    let shrink = size[0].max(size[1]).div_ceil(SIDE).max(1);
    let shown = size.map(|n| n.div_ceil(shrink));
    let width = panels.len() as u32 * (shown[0] + GAP) - GAP;
    let mut picture = RgbImage::from_pixel(width, shown[1], Rgb([255; 3]));
    for (panel, left) in panels.iter().zip((0..).step_by((shown[0] + GAP) as usize)) {
        for y in 0..shown[1] {
            for x in 0..shown[0] {
                let mean = mean(panel, size, [x * shrink, y * shrink], shrink);
                picture.put_pixel(left + x, y, Rgb(mean.map(encoded)));
            }
        }
    }
    picture
}

/// Mean light of a square of texels, of those that there are.
fn mean(panel: &[[f32; 3]], size: [u32; 2], from: [u32; 2], side: u32) -> [f32; 3] {
    let mut sum = [0.0; 3];
    let mut count = 0.0;
    for y in from[1]..(from[1] + side).min(size[1]) {
        for x in from[0]..(from[0] + side).min(size[0]) {
            let colour = panel[(y * size[0] + x) as usize];
            sum = [0, 1, 2].map(|i| sum[i] + colour[i].clamp(0.0, 1.0));
            count += 1.0;
        }
    }
    sum.map(|s| s / count)
}

/// sRGB of linear light (IEC 61966-2-1).
fn encoded(light: f32) -> u8 {
    let value = match light {
        l if l <= 0.003_130_8 => 12.92 * l,
        l => 1.055 * l.powf(1.0 / 2.4) - 0.055,
    };
    (255.0 * value.clamp(0.0, 1.0)).round() as u8
}

/// Linear light that shows as a share of white on the screen.
fn decoded(value: f32) -> f32 {
    Encoding::Srgb.decode(f64::from(value.clamp(0.0, 1.0))) as f32
}
