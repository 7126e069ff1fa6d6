//! Bump test 18: photos of made-up surfaces with gloss, whose highlights are known.

#![expect(clippy::print_stdout, reason = "figures of docs/height_maps.md")]

use super::highlights::highlights;
use super::test_photos::{Shot, bricks, bumps, noise, waves};
use super::{HeightMap, Photo, Warning, Wrap};
use glam::Vec3;

type Albedo = fn(u32, u32) -> [f32; 3];
type Height = fn(f32, f32) -> f32;

const GREY: Albedo = |_, _| [0.3; 3];
const ROUGH: Albedo = |x, y| [0.2 + 0.2 * noise(x, y, 1); 3];
const CLAY: Albedo = |x, y| [0.45, 0.2, 0.12].map(|c| c * (0.7 + 0.6 * noise(x, y, 1)));
/// White pebbles in dark ground.
const PEBBLES: Albedo = |x, y| match noise(x / 10, y / 10, 5) {
    n if n < 0.04 => [0.8; 3],
    _ => [0.2 + 0.05 * noise(x, y, 1); 3],
};
/// Grey mortar between red bricks.
const MORTAR: Albedo = |x, y| match bricks(x as f32, y as f32) {
    h if h < 1.0 => [0.55; 3],
    _ => [0.45, 0.2, 0.12].map(|c| c * (0.8 + 0.4 * noise(x, y, 1))),
};
const LAMPS: [Vec3; 2] = [Vec3::new(-1.0, -1.0, 1.6), Vec3::new(-0.4, -0.2, 1.0)];

fn found(photo: &Photo) -> Option<(Vec<bool>, Warning)> {
    let grey = HeightMap::new(photo.size(), photo.luminance(), [Wrap::Clamp; 2]).unwrap();
    let found = highlights(&grey, Some(&photo.linear()))?;
    Some((found.mask, found.warning))
}

/// Intersection over union.
fn agreement(a: &[bool], b: &[bool]) -> f64 {
    let count = |holds: fn(bool, bool) -> bool| {
        a.iter().zip(b).filter(|&(&a, &b)| holds(a, b)).count() as f64
    };
    count(|a, b| a && b) / count(|a, b| a || b)
}

#[test]
fn highlights_are_found_where_they_are() {
    let glossy: [(&str, Height, Albedo, &[[f32; 2]]); 6] = [
        (
            "bumps, grey",
            bumps,
            GREY,
            &[[0.6, 20.0], [0.6, 60.0], [1.0, 60.0]],
        ),
        (
            "waves, grey",
            waves,
            GREY,
            &[[0.6, 20.0], [0.6, 60.0], [1.0, 20.0]],
        ),
        ("bumps, rough", bumps, ROUGH, &[[0.6, 20.0], [1.0, 60.0]]),
        ("waves, rough", waves, ROUGH, &[[1.0, 60.0]]),
        (
            "bumps, clay",
            bumps,
            CLAY,
            &[[0.3, 20.0], [0.6, 20.0], [1.0, 60.0]],
        ),
        (
            "waves, clay",
            waves,
            CLAY,
            &[[0.3, 20.0], [0.6, 60.0], [1.0, 20.0]],
        ),
    ];
    for (name, relief, albedo, lobes) in glossy {
        for (&gloss, lamp) in lobes.iter().flat_map(|lobe| LAMPS.map(|lamp| (lobe, lamp))) {
            let shot = Shot {
                size: [384, 320],
                relief,
                albedo,
                gloss,
                lamp,
                ..Shot::default()
            };
            let (photo, known) = shot.take();
            let (mask, warning) = found(&photo).unwrap();
            let agreement = agreement(&mask, &known);
            println!("{name}, {gloss:?}: IoU {agreement:.3}");
            assert!(agreement > 0.8, "{name}, {gloss:?}, {lamp}: {agreement}");
            let Warning::Highlights { share, at } = warning else {
                panic!("{warning:?}");
            };
            let known = known.iter().filter(|&&k| k).count() as f64 / known.len() as f64;
            assert!((share - known).abs() < 0.25 * known);
            assert!(mask[(at[1] * 384 + at[0]) as usize], "{at:?} is in none");
        }
    }
}

#[test]
fn matte_surfaces_have_none() {
    for relief in [bumps, waves, bricks, |_, _| 0.0] {
        for albedo in [GREY, ROUGH, CLAY, PEBBLES, MORTAR] {
            for lamp in LAMPS {
                let shot = Shot {
                    size: [384, 320],
                    relief,
                    albedo,
                    lamp,
                    ..Shot::default()
                };
                let found = found(&shot.take().0).map(|(_, warning)| warning);
                assert_eq!(found, None);
            }
        }
    }
}

#[test]
fn small_and_even_images_have_none() {
    for size in [[1, 1], [3, 2], [40, 1]] {
        for level in [0.0, 0.3, 1.0] {
            let map = super::test_photos::map(size, Wrap::Clamp, |_, _| level);
            assert_eq!(highlights(&map, None), None);
        }
    }
}
