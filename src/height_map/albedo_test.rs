//! Bump test 19: what is colour is told, and what is relief is not.

use super::albedo::albedo_edges;
use super::test_photos::{Shot, bricks, bumps, noise, waves};
use super::{Encoding, HeightMap, Photo, Raster, Texels, Warning, Wrap};
use glam::Vec3;

type Albedo = fn(u32, u32) -> [f32; 3];
type Height = fn(f32, f32) -> f32;

const LAMPS: [Vec3; 2] = [Vec3::new(-1.0, -1.0, 1.6), Vec3::new(-2.0, -0.2, 1.0)];

fn edges(relief: Height, albedo: Albedo, lamp: Vec3) -> Option<Warning> {
    let shot = Shot {
        size: [320, 256],
        relief,
        albedo,
        lamp,
        ..Shot::default()
    };
    edges_of(&shot.take().0)
}

fn edges_of(photo: &Photo) -> Option<Warning> {
    let grey = HeightMap::new(photo.size(), photo.luminance(), [Wrap::Clamp; 2]).unwrap();
    albedo_edges(&grey, Some(&photo.linear()), None)
}

fn checker(x: u32, y: u32, side: u32) -> f32 {
    ((x / side + y / side) % 2) as f32
}

#[test]
fn colours_are_told() {
    let painted: [(&str, Albedo); 5] = [
        ("checkerboard", |x, y| [0.2 + 0.4 * checker(x, y, 32); 3]),
        ("noisy checkerboard", |x, y| {
            [0.2 + 0.4 * checker(x, y, 32) + 0.1 * noise(x, y, 2); 3]
        }),
        ("faint checkerboard", |x, y| {
            [0.2 + 0.1 * checker(x, y, 12) + 0.02 * noise(x, y, 2); 3]
        }),
        ("pebbles", |x, y| match noise(x / 10, y / 10, 5) {
            n if n < 0.04 => [0.8; 3],
            _ => [0.2 + 0.05 * noise(x, y, 1); 3],
        }),
        ("mortar", |x, y| match bricks(x as f32, y as f32) {
            h if h < 1.0 => [0.55; 3],
            _ => [0.45, 0.2, 0.12].map(|c| c * (0.8 + 0.4 * noise(x, y, 1))),
        }),
    ];
    for (name, albedo) in painted {
        for lamp in LAMPS {
            let Some(Warning::AlbedoEdges { share, .. }) = edges(|_, _| 0.0, albedo, lamp) else {
                panic!("{name} is not told");
            };
            assert!((0.45..=1.0).contains(&share), "{name}: {share}");
        }
    }
    // The sharpest step is where a side of the checkerboard is.
    let found = edges(|_, _| 0.0, painted[0].1, LAMPS[0]).unwrap();
    let Warning::AlbedoEdges { at: [x, y], .. } = found else {
        panic!("{found}");
    };
    assert!(x % 32 == 31 || y % 32 == 31, "{x} {y}");
}

/// On uneven ground luminance alone does not tell paint from slopes; chromaticity does.
#[test]
fn colours_of_like_brightness_are_told_by_their_colour() {
    let texel = |x: u32, y: u32| {
        let painted = checker(x, y, 32);
        // A slope of 0.0025 by texel, up and down, and steps of 0.016.
        let light = 0.3 + 0.0025 * (((x + y) % 128) as f32 - 64.0).abs() + 0.016 * painted;
        let colour = if painted > 0.0 {
            [0.4, 0.9, 0.9]
        } else {
            [1.0, 0.7, 0.7]
        };
        let luminance = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
        colour.map(|c| c / luminance * light)
    };
    let texels = (0..256 * 256).map(|i| texel(i % 256, i / 256));
    let raster = Raster::new([256; 2], Texels::RgbF32(texels.collect())).unwrap();
    let photo = Photo::new(raster, Encoding::Linear);
    let grey = HeightMap::new(photo.size(), photo.luminance(), [Wrap::Clamp; 2]).unwrap();
    assert_eq!(albedo_edges(&grey, None, None), None);
    let found = edges_of(&photo);
    assert!(
        matches!(found, Some(Warning::AlbedoEdges { share, .. }) if share > 0.45),
        "{found:?}"
    );
}

#[test]
fn relief_of_one_colour_is_not_told() {
    let plain: [Albedo; 3] = [
        |_, _| [0.3; 3],
        |x, y| [0.2 + 0.2 * noise(x, y, 1); 3],
        |x, y| [0.45, 0.2, 0.12].map(|c| c * (0.7 + 0.6 * noise(x, y, 1))),
    ];
    for relief in [bumps, waves, bricks, |_, _| 0.0] {
        for albedo in plain {
            for lamp in LAMPS {
                assert_eq!(edges(relief, albedo, lamp), None);
            }
        }
    }
}

#[test]
fn highlights_do_not_count() {
    let shot = Shot {
        albedo: |x, y| [0.2 + 0.4 * checker(x, y, 32); 3],
        ..Shot::default()
    };
    let (photo, _) = shot.take();
    let grey = HeightMap::new(photo.size(), photo.luminance(), [Wrap::Clamp; 2]).unwrap();
    let all = vec![true; 256 * 256];
    assert_eq!(albedo_edges(&grey, None, Some(&all)), None);
    // One texel hides its neighbourhood and no more.
    let sharpest = |mask: &[bool]| match albedo_edges(&grey, None, Some(mask)) {
        Some(Warning::AlbedoEdges { at, .. }) => at,
        other => panic!("{other:?}"),
    };
    let mut one = vec![false; 256 * 256];
    assert_eq!(sharpest(&one), [31, 0]);
    one[28] = true;
    assert_eq!(sharpest(&one), [63, 0]);
}

#[test]
fn small_images_have_no_sides_to_compare() {
    for size in [[1, 1], [7, 3], [9, 200]] {
        let map = super::test_photos::map(size, Wrap::Clamp, |x, y| x + y);
        assert_eq!(albedo_edges(&map, None, None), None);
    }
}
