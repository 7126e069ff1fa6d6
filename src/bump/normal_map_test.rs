//! Normal maps hold the normals that bump mapping makes of the same heights.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::{Steps, bumped_normal, uv_gradients};
use crate::height_map::{
    Green, HeightMap, Kernel, NormalMapSettings, Wrap, decode_normal, derivative_map,
    encode_normal, normal_map,
};

/// A wall of 3 × 2 metres that faces z, with `u` to the right and `v` down, as images are hung.
const EXTENT: Vec2 = Vec2::new(3.0, 2.0);

fn waves() -> HeightMap {
    let heights = (0..64 * 32).map(|i| {
        let (u, v) = ((i % 64) as f32 / 64.0, (i / 64) as f32 / 32.0);
        0.5 + 0.3 * (TAU * (u + v)).sin() * (TAU * 2.0 * v).cos() + 0.1 * (TAU * 3.0 * u).cos()
    });
    HeightMap::new([64, 32], heights.collect(), [Wrap::Repeat; 2]).unwrap()
}

#[test]
fn normal_maps_are_the_normals_of_bump_mapping() {
    let map = waves();
    let wall = Steps {
        normal: Vec3::Z,
        along: [Vec3::X * EXTENT.x, Vec3::NEG_Y * EXTENT.y],
    };
    let [by_u, by_v] = uv_gradients(wall, [Vec2::X, Vec2::Y]);
    for (green, bitangent) in [(Green::Up, Vec3::Y), (Green::Down, Vec3::NEG_Y)] {
        for (kernel, height) in [(Kernel::CatmullRom, 0.4), (Kernel::Central, 3.0)] {
            let settings = NormalMapSettings {
                kernel,
                height,
                extent: EXTENT,
                green,
            };
            let slopes = derivative_map(&map, kernel);
            for (n, slopes) in normal_map(&map, &settings).into_iter().zip(slopes) {
                let gradient = height * (slopes.x * by_u + slopes.y * by_v);
                let bumped = bumped_normal(Vec3::Z, gradient);
                let of = |n: Vec3| n.x * Vec3::X + n.y * bitangent + n.z * Vec3::Z;
                assert!(
                    of(n).distance(bumped) < 1e-5,
                    "{green:?}, {kernel:?}: {n} {bumped}"
                );
                let stored = decode_normal(encode_normal(n));
                assert!(of(stored).angle_between(bumped).to_degrees() < 0.4);
            }
        }
    }
}
