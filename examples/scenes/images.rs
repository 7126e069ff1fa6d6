use std::io::Cursor;

use image::{ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, Rgba, RgbaImage};

/// Random bits for a place, the same on every run.
fn hash(x: u32, y: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// Paving: four by four stones of two colours in turn, with dark joints. A PNG, 128 by 128.
pub(super) fn paving() -> Vec<u8> {
    const STONE: u32 = 32;
    let image = RgbImage::from_fn(128, 128, |x, y| {
        let stone = [x / STONE, y / STONE];
        let is_joint = x % STONE == 0 || y % STONE == 0;
        let base = match (is_joint, (stone[0] + stone[1]) % 2) {
            (true, _) => [96, 88, 80],
            (false, 0) => [206, 196, 180],
            (false, _) => [168, 128, 104],
        };
        // Each stone has its own tone, and the surface a little grain.
        let tone = (hash(stone[0] + 100, stone[1]) % 25) as i32 - 12;
        let grain = (hash(x, y) % 9) as i32 - 4;
        Rgb(base.map(|channel: i32| (channel + tone + grain).clamp(0, 255) as u8))
    });
    let mut png = Cursor::new(Vec::new());
    image
        .write_to(&mut png, ImageFormat::Png)
        .expect("writing to memory does not fail");
    png.into_inner()
}

/// A painted sheet with four by four round holes, alpha 0 in them. A PNG, 64 by 64.
pub(super) fn holes() -> Vec<u8> {
    const PITCH: i32 = 16;
    let image = RgbaImage::from_fn(64, 64, |x, y| {
        // Distance to the middle of the cell, in half texels.
        let off = [x, y].map(|i| 2 * (i as i32 % PITCH) + 1 - PITCH);
        let is_hole = off[0] * off[0] + off[1] * off[1] < 10 * 10;
        Rgba([40, 92, 96, if is_hole { 0 } else { 255 }])
    });
    let mut png = Cursor::new(Vec::new());
    image
        .write_to(&mut png, ImageFormat::Png)
        .expect("writing to memory does not fail");
    png.into_inner()
}

/// Heights of six courses of three bricks with worn edges, joints at 0. Tiles. A grey PNG of 16 bits, 512 by
/// 512.
pub(super) fn bricks() -> Vec<u8> {
    const SIDE: u32 = 512;
    // Widths of half a joint and of an edge, as shares of the map.
    const JOINT: f32 = 0.008;
    const EDGE: f32 = 0.016;
    let image = ImageBuffer::from_fn(SIDE, SIDE, |x, y| {
        let [u, v] = [x, y].map(|i| (i as f32 + 0.5) / SIDE as f32);
        let course = (6.0 * v) as u32;
        let along = 3.0 * u + 0.5 * (course % 2) as f32;
        let to_end = |t: f32| t.fract().min(1.0 - t.fract());
        let to_joint = (to_end(along) / 3.0).min(to_end(6.0 * v) / 6.0);
        let t = ((to_joint - JOINT) / EDGE).clamp(0.0, 1.0);
        let brick = (hash(along as u32 % 3, course) % 16) as f32 / 15.0;
        let height = t * t * (3.0 - 2.0 * t) * (0.85 + 0.15 * brick);
        Luma([(height * 65_535.0) as u16])
    });
    let mut png = Cursor::new(Vec::new());
    image
        .write_to(&mut png, ImageFormat::Png)
        .expect("writing to memory does not fail");
    png.into_inner()
}
