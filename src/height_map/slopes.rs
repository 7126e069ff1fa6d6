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

/// A normal as three 8-bit channels, −1 being 0 and 1 being 255; 0 has no number of its own and becomes
/// 128. Angles are off by up to 0.4°.
pub fn encode_normal(normal: Vec3) -> [u8; 3] {
    (127.5 * normal + 127.5).to_array().map(|c| c.round() as u8)
}

/// The unit normal of three 8-bit channels.
pub fn decode_normal(channels: [u8; 3]) -> Vec3 {
    let normal = Vec3::from(channels.map(f32::from)) / 127.5 - 1.0;
    normal.try_normalize().unwrap_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::super::Wrap;
    use super::super::test_photos::map;
    use super::*;

    /// A plane that rises to the right by 2 and down the image by 3, over 4 × 2 metres.
    fn plane() -> (HeightMap, NormalMapSettings) {
        let plane = map([40, 20], Wrap::Clamp, |x, y| {
            2.0 * x / 40.0 + 3.0 * y / 20.0
        });
        let settings = NormalMapSettings {
            kernel: Kernel::CatmullRom,
            height: 0.5,
            extent: Vec2::new(4.0, 2.0),
            green: Green::Up,
        };
        (plane, settings)
    }

    #[test]
    fn derivatives_are_by_texture_coordinate() {
        let (plane, _) = plane();
        for kernel in Kernel::ALL {
            let found = derivative_map(&plane, kernel);
            for y in 3..17 {
                for x in 3..37 {
                    let slopes = found[y * 40 + x];
                    assert!(
                        slopes.distance(Vec2::new(2.0, 3.0)) < 1e-4,
                        "{kernel:?}: {slopes}"
                    );
                }
            }
        }
    }

    #[test]
    fn green_points_up_or_down() {
        let (plane, up) = plane();
        let down = NormalMapSettings {
            green: Green::Down,
            ..up
        };
        let middle = 10 * 40 + 20;
        // Half a metre a unit: slopes of 1/4 and 3/4. Leaning left and, as it rises downwards, up the image.
        let expected = Vec3::new(-0.25, 0.75, 1.0).normalize();
        assert!(normal_map(&plane, &up)[middle].distance(expected) < 1e-5);
        let expected = Vec3::new(-0.25, -0.75, 1.0).normalize();
        assert!(normal_map(&plane, &down)[middle].distance(expected) < 1e-5);
    }

    #[test]
    fn eight_bits_hold_a_normal_to_under_half_a_degree() {
        let mut worst = 0.0_f32;
        for i in 0..4000 {
            // Golden spiral over the upper half of a sphere.
            let z = (i as f32 + 0.5) / 4000.0;
            let (sin, cos) = (2.399_963 * i as f32).sin_cos();
            let normal = Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z;
            let back = decode_normal(encode_normal(normal));
            worst = worst.max(back.angle_between(normal).to_degrees());
        }
        assert!(worst < 0.4, "{worst}°");
        assert_eq!(encode_normal(Vec3::NEG_X), [0, 128, 128]);
        assert_eq!(encode_normal(Vec3::X), [255, 128, 128]);
    }

    #[test]
    fn flat_maps_have_upright_normals() {
        let flat = map([1, 1], Wrap::Repeat, |_, _| 0.3);
        let (_, settings) = plane();
        assert_eq!(normal_map(&flat, &settings), [Vec3::Z]);
    }
}
