use super::{HeightMap, Wrap};

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
