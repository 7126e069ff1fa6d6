use glam::{Vec2, Vec3};

use super::{HeightMap, Kernel};

/// Which way the green of a normal map points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Green {
    /// Up the image, against `v`: glTF, Bevy, OpenGL, Blender.
    #[default]
    Up,
    /// Down the image, along `v`: DirectX, Unreal. In Bevy, set `flip_normal_map_y`.
    Down,
}

/// What a normal map is made with: how high and wide the relief is, in one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMapSettings {
    /// How slopes are found.
    pub kernel: Kernel,
    /// How much higher 1 is than 0.
    pub height: f32,
    /// How much of the surface the whole map covers, along `u` and along `v`. Limits: above 0.
    pub extent: Vec2,
    /// Which way green points.
    pub green: Green,
}

/// `F_u` and `F_v` at the centres of texels, row after row: height by texture coordinate, the whole map
/// being 1 wide and 1 high, `v` pointing down.
pub fn derivative_map(map: &HeightMap, kernel: Kernel) -> Vec<Vec2> {
    let [width, height] = map.size().map(i64::from);
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    texels
        .map(|texel| map.between(texel, [0.0; 2], kernel).slopes)
        .collect()
}

/// Unit normals at the centres of texels in tangent space: x along `u`, y where green points, z outwards.
///
/// ```text
///         ┌──────────────────────────────────────────────────┐
///   n  ∝  │  (−F_u height / extent_u, ± F_v height / extent_v, 1) │     + where green points up, against v
///         └──────────────────────────────────────────────────┘
/// ```
pub fn normal_map(map: &HeightMap, settings: &NormalMapSettings) -> Vec<Vec3> {
    let by_length = settings.height / settings.extent;
    let green = match settings.green {
        Green::Up => 1.0,
        Green::Down => -1.0,
    };
    derivative_map(map, settings.kernel)
        .into_iter()
        .map(|slopes| {
            let slopes = slopes * by_length;
            Vec3::new(-slopes.x, green * slopes.y, 1.0)
                .try_normalize()
                .unwrap_or(Vec3::Z)
        })
        .collect()
}

/// A normal as three 8-bit channels: −1 is 0 or, where that has no whole number, as near as 1/255 allows.
/// Angles are off by up to 0.4°.
pub fn encode_normal(normal: Vec3) -> [u8; 3] {
    (127.5 * normal + 127.5).to_array().map(|c| c.round() as u8)
}

/// The unit normal of three 8-bit channels.
pub fn decode_normal(channels: [u8; 3]) -> Vec3 {
    let normal = Vec3::from(channels.map(f32::from)) / 127.5 - 1.0;
    normal.try_normalize().unwrap_or(Vec3::Z)
}
