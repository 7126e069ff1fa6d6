//! The whole way from an image to a map: bump tests 16, 17 and 18.

#![expect(clippy::print_stdout, reason = "figures beside their limits")]

use super::test_photos::{Shot, bumps, grey8, map, noise, srgb, waves};
use super::*;
use std::f32::consts::TAU;

fn ends(map: &HeightMap) -> [f32; 2] {
    let heights = map.heights().iter().copied();
    [
        heights.clone().fold(f32::INFINITY, f32::min),
        heights.fold(f32::NEG_INFINITY, f32::max),
    ]
}

/// Bump test 16: heights are not decoded, whatever their depth and channels; light is.
#[test]
fn heights_are_never_decoded() {
    let ramp: Vec<u8> = (0..=255).collect();
    let as_is = PrepareSettings {
        stretch: Stretch::AsIs,
        ..PrepareSettings::default()
    };
    let colour = ramp.iter().map(|&c| [c; 3]).collect();
    let fine: Vec<u16> = ramp.iter().map(|&c| u16::from(c) * 257).collect();
    for texels in [
        Texels::Grey8(ramp.clone()),
        Texels::Rgb8(colour),
        Texels::Grey16(fine),
        Texels::GreyF32(ramp.iter().map(|&c| f32::from(c) / 255.0).collect()),
    ] {
        let raster = Raster::new([256, 1], texels).unwrap();
        let data = prepare_data(&raster, &as_is).unwrap().map;
        for (i, h) in (0..).zip(data.heights()) {
            assert!((h - i as f32 / 255.0).abs() < 1e-6);
        }
        // The same numbers as a photo in sRGB are something else.
        let photo = prepare(&Photo::new(raster, Encoding::Srgb), &as_is)
            .unwrap()
            .map;
        assert!((photo.heights()[128] - 0.2159).abs() < 1e-3);
    }
}

/// Bump test 17: stretched to the bit through the whole way, constant images without NaN.
#[test]
fn contrast_is_stretched_and_constant_images_are_told() {
    let (photo, _) = Shot {
        relief: waves,
        ..Shot::default()
    }
    .take();
    for invert in [false, true] {
        for flatten in [None, Some(20.0)] {
            let settings = PrepareSettings {
                invert,
                flatten,
                ..PrepareSettings::default()
            };
            assert_eq!(ends(&prepare(&photo, &settings).unwrap().map), [0.0, 1.0]);
        }
    }
    for level in [0, 77, 255] {
        let flat = grey8([9, 7], |_, _| level);
        let everything = PrepareSettings {
            dequantize: true,
            flatten: Some(3.0),
            smooth: Some(1.0),
            invert: true,
            ..PrepareSettings::default()
        };
        for settings in [PrepareSettings::default(), everything] {
            for prepared in [
                prepare(&Photo::new(flat.clone(), Encoding::Srgb), &settings).unwrap(),
                prepare_data(&flat, &settings).unwrap(),
            ] {
                assert!(prepared.map.heights().iter().all(|&h| h == 0.5));
                assert!(prepared.warnings.contains(&Warning::Constant));
            }
        }
    }
    let spot = grey8([20, 20], |x, y| if x + y == 0 { 200 } else { 100 });
    let settings = PrepareSettings {
        stretch: Stretch::Percentile(1.0),
        ..PrepareSettings::default()
    };
    let prepared = prepare_data(&spot, &settings).unwrap();
    assert!(
        prepared
            .warnings
            .contains(&Warning::ConstantWithin { percent: 1.0 })
    );
    assert!(prepared.map.heights().iter().all(|&h| h == 0.5));
}

/// Bump test 17: where a map tiles, nothing shows where it begins. Whatever is done to it, moving the
/// image moves the map.
#[test]
fn tiles_have_no_border() {
    let height = |x: u32, y: u32| {
        (120.0 + 60.0 * noise(x % 48 / 3, y % 40 / 3, 4) + 9.0 * noise(x % 48, y % 40, 9)) as u8
    };
    let settings = PrepareSettings {
        wrap: [Wrap::Repeat; 2],
        dequantize: true,
        flatten: Some(9.0),
        smooth: Some(0.8),
        ..PrepareSettings::default()
    };
    let [whole, moved] = [[0, 0], [17, 29]].map(|[dx, dy]| {
        let raster = grey8([48, 40], |x, y| height(x + dx, y + dy));
        prepare(&Photo::new(raster, Encoding::Srgb), &settings)
            .unwrap()
            .map
    });
    for (y, x) in (0..40).flat_map(|y| (0..48).map(move |x| (y, x))) {
        let off = moved.texel(x, y) - whole.texel(x + 17, y + 29);
        assert!(off.abs() < 2e-4, "({x}, {y}): {off}");
    }
    // So the slope at the border is what it is inside: from the right and from the left.
    for v in [0.1, 0.6] {
        let [left, right] = [0.0, 1.0].map(|u| whole.at(glam::Vec2::new(u, v), Kernel::CatmullRom));
        assert!(left.slopes.distance(right.slopes) < 1e-3 * left.slopes.length().max(1.0));
    }
}

/// Bump test 18: a lamp at the side makes a photo brighter there; less than 2 % of the range is left.
#[test]
fn shading_is_taken_out() {
    let tilt = |map: &HeightMap| {
        let n = map.size()[0] as usize;
        let mean = |half: fn(usize, usize) -> bool| {
            let all = map.heights().iter().enumerate();
            let some: Vec<f64> = (all.filter(|(i, _)| half(i % n, n)))
                .map(|(_, &h)| f64::from(h))
                .collect();
            some.iter().sum::<f64>() / some.len() as f64
        };
        // Between the middles of the halves is half of it.
        2.0 * (mean(|x, n| 2 * x >= n) - mean(|x, n| 2 * x < n))
    };
    for relief in [bumps, waves] {
        let shot = |light| {
            Shot {
                size: [384; 2],
                relief,
                light,
                ..Shot::default()
            }
            .take()
            .0
        };
        let uneven = shot(|x, y| 0.4 + 1.2 * x / 384.0 + 0.3 * y / 384.0);
        let flat = PrepareSettings {
            flatten: Some(64.0),
            ..PrepareSettings::default()
        };
        let before = tilt(&prepare(&uneven, &PrepareSettings::default()).unwrap().map);
        // The relief itself may be a little higher on one side.
        let even = prepare(&shot(|_, _| 1.0), &flat).unwrap().map;
        let found = prepare(&uneven, &flat).unwrap().map;
        let after = tilt(&found) - tilt(&even);
        println!("tilt {before:.3} before, {after:.4} after");
        assert!(before > 0.25, "{before}");
        assert!(after.abs() < 0.02, "{after}");
        // What it does to an even photo is the same, so the light is what was taken out.
        let pairs = even.heights().iter().zip(found.heights());
        let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let off = (squares / even.heights().len() as f64).sqrt();
        println!("off the even photo by {off:.4}");
        assert!(off < 0.03, "{off}");
    }
}

#[test]
fn waves_are_taken_out_of_heights() {
    let tilted = map([64, 48], Wrap::Clamp, |x, y| {
        3.0 * x - 2.0 * y + (TAU * x / 8.0).sin()
    });
    let raster = Raster::new([64, 48], Texels::GreyF32(tilted.heights().to_vec())).unwrap();
    let settings = PrepareSettings {
        flatten: Some(12.0),
        stretch: Stretch::AsIs,
        ..PrepareSettings::default()
    };
    let found = prepare_data(&raster, &settings).unwrap().map;
    let level = tilted.heights().iter().sum::<f32>() / (64.0 * 48.0);
    for (i, h) in found.heights().iter().enumerate() {
        let expected = level + (TAU * (i % 64) as f32 / 8.0).sin();
        // At the border the plane leans on half a wave.
        assert!((h - expected).abs() < 0.25, "{i}: {h}, not {expected}");
    }
}

#[test]
fn settings_outside_their_limits_are_told() {
    let flat = grey8([4, 4], |x, _| x as u8);
    let with = |flatten, smooth, stretch| {
        let settings = PrepareSettings {
            flatten,
            smooth,
            stretch,
            ..PrepareSettings::default()
        };
        prepare_data(&flat, &settings).map(|p| p.map.size())
    };
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(
            with(Some(bad), None, Stretch::Full),
            Err(PrepareError::Width { .. })
        ));
        assert!(matches!(
            with(None, Some(bad), Stretch::Full),
            Err(PrepareError::Width { .. })
        ));
    }
    for bad in [0.0, 50.0, -3.0, f32::NAN] {
        let error = with(None, None, Stretch::Percentile(bad)).unwrap_err();
        assert!(matches!(error, PrepareError::Percentile(_)));
    }
    let colour = Raster::new([1, 1], Texels::Rgb8(vec![[1, 2, 3]])).unwrap();
    assert!(prepare_data(&colour, &PrepareSettings::default()).is_err());
}

#[test]
fn eight_bits_and_clipping_are_told() {
    let (photo, _) = Shot {
        relief: bumps,
        ..Shot::default()
    }
    .take();
    let warnings = prepare(&photo, &PrepareSettings::default())
        .unwrap()
        .warnings;
    assert_eq!(warnings, [Warning::EightBits]);
    assert_eq!(
        prepare(
            &photo,
            &PrepareSettings {
                dequantize: true,
                ..PrepareSettings::default()
            }
        )
        .unwrap()
        .warnings,
        []
    );
    let dark = grey8([50, 50], |x, y| {
        srgb((0.02 * x as f32 - 0.1 + 0.001 * y as f32).clamp(0.0, 1.0) * 1.2)
    });
    let warnings = prepare(
        &Photo::new(dark, Encoding::Srgb),
        &PrepareSettings::default(),
    )
    .unwrap()
    .warnings;
    assert!(
        warnings
            .iter()
            .any(|w| matches!(w, Warning::ClippedBlacks { share } if (0.05..0.15).contains(share))),
        "{warnings:?}"
    );
    assert!(
        warnings
            .iter()
            .any(|w| matches!(w, Warning::ClippedWhites { .. })),
        "{warnings:?}"
    );
}
