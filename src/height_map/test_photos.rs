use std::f32::consts::TAU;

use glam::Vec3;

use super::{Encoding, HeightMap, Photo, Raster, Texels, Wrap};

/// A number in `0..1` for a texel, the same on every run.
pub(super) fn noise(x: u32, y: u32, seed: u32) -> f32 {
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    for shift in [15, 13, 16] {
        h = (h ^ (h >> shift)).wrapping_mul(0x2c1b_3c6d);
    }
    (h >> 8) as f32 / (1 << 24) as f32
}

/// A map of heights by column and row.
pub(super) fn map(size: [u32; 2], wrap: Wrap, height: impl Fn(f32, f32) -> f32) -> HeightMap {
    let [w, h] = size;
    let heights = (0..w * h).map(|i| height((i % w) as f32, (i / w) as f32));
    HeightMap::new(size, heights.collect(), [wrap; 2]).unwrap()
}

/// A photo of a made-up surface, rendered: what it shows is known.
pub(super) struct Shot {
    pub(super) size: [u32; 2],
    /// Height in texels by column and row.
    pub(super) relief: fn(f32, f32) -> f32,
    /// Reflectance of red, green and blue by column and row.
    pub(super) albedo: fn(u32, u32) -> [f32; 3],
    /// Towards the lamp.
    pub(super) lamp: Vec3,
    /// What the mirror image of the lamp adds, and how narrow it is: `strength (r · v)^exponent`.
    pub(super) gloss: [f32; 2],
    /// Brightness by column and row: shading.
    pub(super) light: fn(f32, f32) -> f32,
}

impl Default for Shot {
    fn default() -> Self {
        Self {
            size: [256; 2],
            relief: |_, _| 0.0,
            albedo: |_, _| [0.4; 3],
            lamp: Vec3::new(-1.0, -1.0, 1.6),
            gloss: [0.0, 1.0],
            light: |_, _| 1.0,
        }
    }
}

impl Shot {
    /// The photo in 8-bit sRGB, as a camera makes it, and where the lobe adds half of the matte light or
    /// more (B. T. Phong, "Illumination for computer generated pictures", 1975; the viewer is above).
    pub(super) fn take(&self) -> (Photo, Vec<bool>) {
        let [width, height] = self.size;
        let lamp = self.lamp.normalize();
        let (mut texels, mut mask) = (Vec::new(), Vec::new());
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let (px, py) = (x as f32, y as f32);
            let slope =
                |dx, dy| 0.5 * ((self.relief)(px + dx, py + dy) - (self.relief)(px - dx, py - dy));
            let normal = Vec3::new(-slope(1.0, 0.0), -slope(0.0, 1.0), 1.0).normalize();
            let mirrored = 2.0 * normal.dot(lamp) * normal - lamp;
            let lambert = (0.15 + 0.85 * normal.dot(lamp).max(0.0)) * (self.light)(px, py);
            let lobe = self.gloss[0] * mirrored.z.max(0.0).powf(self.gloss[1]);
            let matte = Vec3::from((self.albedo)(x, y)) * lambert;
            mask.push(lobe > 0.5 * matte.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
            texels.push((matte + lobe).to_array().map(srgb));
        }
        let raster = Raster::new(self.size, Texels::Rgb8(texels)).unwrap();
        (Photo::new(raster, Encoding::Srgb), mask)
    }
}

/// What a camera writes for linear light.
pub(super) fn srgb(light: f32) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value).round() as u8
}

/// Rounded bumps, 48 texels wide.
pub(super) fn bumps(x: f32, y: f32) -> f32 {
    8.0 * (TAU * x / 96.0).sin() * (TAU * y / 96.0).sin()
}

/// Waves of many lengths, as of hammered metal.
pub(super) fn waves(x: f32, y: f32) -> f32 {
    (1..9)
        .map(|k| {
            let k = k as f32;
            let (sin, cos) = (2.4 * k).sin_cos();
            let length = 30.0 + 16.0 * k;
            0.03 * length * (TAU * (x * cos + y * sin) / length + k).sin()
        })
        .sum()
}

/// Bricks of 64 × 32 texels that stand out 4, with grooves of 8 and rounded edges.
pub(super) fn bricks(x: f32, y: f32) -> f32 {
    let row = (y / 32.0).floor();
    let x = (x + 32.0 * (row.rem_euclid(2.0))).rem_euclid(64.0);
    let from_edge = x
        .min(64.0 - x)
        .min(y.rem_euclid(32.0))
        .min(32.0 - y.rem_euclid(32.0));
    let t = ((from_edge - 2.0) / 6.0).clamp(0.0, 1.0);
    4.0 * t * t * (3.0 - 2.0 * t)
}

/// An image of 8 bits and one channel by column and row.
pub(super) fn grey8(size: [u32; 2], value: impl Fn(u32, u32) -> u8) -> Raster {
    let texels = (0..size[0] * size[1]).map(|i| value(i % size[0], i / size[0]));
    Raster::new(size, Texels::Grey8(texels.collect())).unwrap()
}
