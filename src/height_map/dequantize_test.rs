//! Bump test 10: what 8 bits leave of a relief, and what dequantisation makes of it.

#![expect(clippy::print_stdout, reason = "figures of docs/height_maps.md")]

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::test_photos::{grey8, noise};
use super::*;

/// Root mean square angle in degrees between the normals of a map, at texels and between them, and the true
/// ones of a relief that is `scale` texels high from 0 to 1; texels near the border are left out.
fn normal_noise(map: &HeightMap, kernel: Kernel, scale: f32, slope: impl Fn(f32) -> f32) -> f64 {
    let size = Vec2::new(map.size()[0] as f32, map.size()[1] as f32);
    let normal = |x: f32, y: f32| Vec3::new(-x, -y, 1.0).normalize();
    let steps = |n: f32| (16..(4.0 * n) as u32 - 16).map(|i| i as f32 / 4.0);
    let (mut sum, mut count) = (0.0, 0.0);
    for (y, x) in steps(size.y).flat_map(|y| steps(size.x).map(move |x| (y, x))) {
        let found = map.at(Vec2::new(x + 0.5, y + 0.5) / size, kernel).slopes * scale / size;
        let off = normal(found.x, found.y).angle_between(normal(slope(x), 0.0));
        sum += f64::from(off.to_degrees()).powi(2);
        count += 1.0;
    }
    (sum / count).sqrt()
}

/// Nothing but dequantisation.
fn dequantize() -> PrepareSettings {
    PrepareSettings {
        dequantize: true,
        stretch: Stretch::AsIs,
        ..PrepareSettings::default()
    }
}

/// Bump test 10: a ramp of a step of 8 bits in 20 texels, a step being a tenth of a texel high.
#[test]
fn steps_of_eight_bits_become_a_slope() {
    let ramp = grey8([320, 24], |x, _| (100.0 + x as f32 / 20.0).round() as u8);
    // 25.5 texels from 0 to 1.
    let noise = |settings, kernel| {
        let map = prepare_data(&ramp, &settings).unwrap().map;
        normal_noise(&map, kernel, 25.5, |_| 0.1 / 20.0)
    };
    let raw = PrepareSettings {
        dequantize: false,
        ..dequantize()
    };
    for kernel in [Kernel::CatmullRom, Kernel::BSpline] {
        let (before, after) = (noise(raw, kernel), noise(dequantize(), kernel));
        println!("{kernel:?}: {before:.3}° before, {after:.4}° after");
        assert!(after < 0.03, "{kernel:?}: {after}°");
        assert!(before > 0.8, "{kernel:?}: {before}°");
    }
}

/// The research table's wave: 512 texels long, 64 texels high, in 8 bits.
#[test]
fn steps_of_eight_bits_come_off_a_wave() {
    for (height, most) in [(8.0, 0.1), (32.0, 0.4), (64.0, 0.8)] {
        let wave = |x: f32| 0.5 + 0.5 * (TAU * x / 512.0).sin();
        let image = grey8([512, 16], |x, _| (255.0 * wave(x as f32)).round() as u8);
        let slope = |x: f32| height * 0.5 * TAU / 512.0 * (TAU * x / 512.0).cos();
        let noise = |on| {
            let settings = PrepareSettings {
                wrap: [Wrap::Repeat; 2],
                dequantize: on,
                ..dequantize()
            };
            let map = prepare_data(&image, &settings).unwrap().map;
            normal_noise(&map, Kernel::BSpline, height, slope)
        };
        let (before, after) = (noise(false), noise(true));
        println!("{height} texels high: {before:.3}° before, {after:.4}° after");
        assert!(
            after < most && after < 0.3 * before,
            "{before}° to {after}°"
        );
    }
}

/// Where a map does not repeat, its two ends have nothing to do with each other, though they be as high.
#[test]
fn ends_of_a_map_that_does_not_repeat_stay_apart() {
    let bowl = |x: u32| 100.0 + 40.0 * ((x as f32 - 127.5) / 127.5).powi(2);
    let image = grey8([256, 3], |x, _| bowl(x).round() as u8);
    let worst = |wrap| {
        let settings = PrepareSettings {
            wrap: [wrap; 2],
            ..dequantize()
        };
        let map = prepare_data(&image, &settings).unwrap().map;
        let ends = (0..6).chain(250..256);
        ends.map(|x| (255.0 * map.texel(i64::from(x), 1) - bowl(x)).abs())
            .fold(0.0, f32::max)
    };
    let [apart, joined] = [Wrap::Clamp, Wrap::Repeat].map(worst);
    println!("off by {apart:.3} steps, {joined:.3} if it repeats");
    assert!(apart < 0.2 && joined > 1.5 * apart, "{apart} {joined}");
}

/// Nothing moves by more than half a step, so rounding gives the image back; edges stay where they are.
#[test]
fn dequantised_heights_round_to_the_image() {
    let images = [
        grey8([64, 48], |x, y| (255.0 * noise(x, y, 1)) as u8),
        grey8([64, 48], |x, y| {
            (90.0 + 30.0 * (x as f32 / 9.0).sin() + y as f32 / 7.0) as u8
        }),
        grey8([64, 48], |x, _| if x < 32 { 40 } else { 200 }),
        grey8([1, 1], |_, _| 7),
        grey8([2, 1], |x, _| 255 * x as u8),
    ];
    for (image, wrap) in images
        .iter()
        .flat_map(|i| [(i, Wrap::Clamp), (i, Wrap::Repeat)])
    {
        let settings = PrepareSettings {
            wrap: [wrap; 2],
            ..dequantize()
        };
        let prepared = prepare_data(image, &settings).unwrap();
        let before = image.one_channel(0.0).unwrap();
        for (before, after) in before.iter().zip(prepared.map.heights()) {
            assert!(
                (before - after).abs() <= 0.5 / 255.0 + 1e-6,
                "{before} {after}"
            );
        }
        assert_eq!(
            prepared.warnings.iter().find(|w| **w == Warning::EightBits),
            None
        );
    }
    let edge = prepare_data(&images[2], &dequantize()).unwrap().map;
    assert_eq!(edge.heights(), images[2].one_channel(0.0).unwrap());
}

/// Bump test 10: 16 bits are as good as floating point, and nothing is dequantised there.
#[test]
fn sixteen_bits_are_floating_point() {
    let height = |i: u32| 0.5 + 0.4 * (TAU * (i % 64) as f32 / 64.0).sin() * (i / 64) as f32 / 64.0;
    let fine = (0..64 * 64).map(|i| (65_535.0 * height(i)).round() as u16);
    let fine = Raster::new([64; 2], Texels::Grey16(fine.collect())).unwrap();
    let float = Raster::new([64; 2], Texels::GreyF32((0..64 * 64).map(height).collect())).unwrap();
    let [fine, float] = [fine, float].map(|r| prepare_data(&r, &dequantize()).unwrap());
    for (a, b) in fine.map.heights().iter().zip(float.map.heights()) {
        assert!((a - b).abs() < 1e-5);
    }
    for (i, b) in (0..).zip(float.map.heights()) {
        assert_eq!(*b, height(i));
    }
}
