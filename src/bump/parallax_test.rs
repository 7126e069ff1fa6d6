//! Rays through maps against a walk in tiny steps in f64. Numbers of tests are those of `docs/bump_mapping.md`.

use std::f32::consts::TAU;

use glam::{DVec2, Vec2, Vec3};

use super::{ParallaxMap, ParallaxRay, parallax_slide};
use crate::height_map::{HeightMap, Wrap};

/// A map whose lowest texel is 0 and whose highest is 1, if they differ: its heights are shares of its range.
fn map(size: [u32; 2], wrap: Wrap, height: impl Fn(f32, f32) -> f32) -> HeightMap {
    let [w, h] = size;
    let heights = (0..w * h).map(|i| {
        let (x, y) = ((i % w) as f32 + 0.5, (i / w) as f32 + 0.5);
        height(x / w as f32, y / h as f32)
    });
    let heights: Vec<f32> = heights.collect();
    let low = heights.iter().copied().fold(f32::INFINITY, f32::min);
    let high = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let range = if high > low { high - low } else { 1.0 };
    let shares = heights.iter().map(|h| (h - low) / range);
    HeightMap::new(size, shares.collect(), [wrap; 2]).unwrap()
}

/// A pattern of the same numbers each time.
fn noise(i: u32) -> f32 {
    let word = i.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((word >> ((word >> 28) + 4)) ^ word).wrapping_mul(277_803_737);
    ((word >> 22) ^ word) as f32 / u32::MAX as f32
}

/// Height of what is straight between texels, in f64: 0 to 1.
fn surface(map: &HeightMap, uv: DVec2) -> f64 {
    let [w, h] = map.size().map(f64::from);
    let (x, y) = (uv.x * w - 0.5, uv.y * h - 0.5);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (s, t) = (x - x.floor(), y - y.floor());
    let texel = |x, y| f64::from(map.texel(x, y));
    (1.0 - t) * ((1.0 - s) * texel(i, j) + s * texel(i + 1, j))
        + t * ((1.0 - s) * texel(i, j + 1) + s * texel(i + 1, j + 1))
}

/// How far a ray is above the surface at a depth.
fn above(map: &HeightMap, ray: ParallaxRay, depth: f64) -> f64 {
    let (uv, slide): (DVec2, DVec2) = (ray.uv.into(), ray.slide.into());
    let height = surface(map, uv + slide * depth);
    let height = if ray.is_inverted {
        1.0 - height
    } else {
        height
    };
    f64::from(ray.level) - depth - height
}

/// Depth at which a ray meets the surface, by steps of 1/64 texel and halving. May step over crests that it grazes.
fn walked(map: &HeightMap, ray: ParallaxRay) -> f64 {
    let top = f64::from(ray.level) - 1.0;
    let steps = (64.0 * texels(map, ray)).ceil().max(64.0);
    let mut before = top;
    for i in 0..=steps as u32 {
        let depth = top + f64::from(i) / steps;
        if above(map, ray, depth) <= 0.0 {
            let (mut low, mut high) = (before, depth);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if above(map, ray, middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            return high;
        }
        before = depth;
    }
    ray.level.into()
}

/// Texels that a ray goes over.
fn texels(map: &HeightMap, ray: ParallaxRay) -> f64 {
    (ray.slide.as_dvec2() * DVec2::from(map.size().map(f64::from))).length()
}

/// How many texels a depth is off: later than the walk, or earlier and not on the surface.
fn texels_off(map: &HeightMap, ray: ParallaxRay, depth: f64) -> f64 {
    let late = depth - walked(map, ray);
    if late < 0.0 && above(map, ray, depth).abs() < 1e-4 {
        return 0.0;
    }
    late.abs() * texels(map, ray)
}

fn sine(u: f32, v: f32) -> f32 {
    0.5 + 0.5 * (8.0 * TAU * u).sin() * (8.0 * TAU * v).sin()
}

fn pillars(u: f32, v: f32) -> f32 {
    let stands = |x: f32| ((x * 256.0 / 4.0) as u32).is_multiple_of(2);
    f32::from(u8::from(stands(u) && stands(v)))
}

/// Walls of one texel, 16 apart.
fn walls(u: f32, v: f32) -> f32 {
    let [x, y] = [u, v].map(|c| (c * 256.0) as u32);
    f32::from(u8::from(x % 16 == 3 || y % 16 == 9))
}

/// Bevy 0.19's parallax occlusion mapping with 16 layers, from `parallax_mapping.wgsl`: the depth that it finds.
fn layered(map: &HeightMap, ray: ParallaxRay, cosine: f64) -> f64 {
    let (uv, slide): (DVec2, DVec2) = (ray.uv.into(), ray.slide.into());
    let depth_at = |s: f64| 1.0 - surface(map, uv + slide * s);
    let layers = 16.0 + (1.0 - 16.0) * cosine;
    let layer = 1.0 / layers;
    let (mut s, mut steps) = (0.0, 0);
    while depth_at(s) > s && steps <= layers as i32 {
        s += layer;
        steps += 1;
    }
    let next = depth_at(s) - s;
    let before = depth_at(s - layer) - s + layer;
    s - layer * next / (next - before)
}

/// Share of rays that are off by more than two texels, texels read by a ray, and the share that Bevy's layers have
/// off.
fn missed(map: &HeightMap, degrees: f32, rays: u32) -> [f32; 3] {
    let marched = ParallaxMap::new(map);
    let (mut off, mut reads, mut control) = (0, 0, 0);
    for i in 0..rays {
        let (y, x) = (TAU * noise(3 * i)).sin_cos();
        let ray = ParallaxRay {
            uv: Vec2::new(noise(3 * i + 1), noise(3 * i + 2)),
            slide: 0.1 * degrees.to_radians().tan() * Vec2::new(x, y),
            level: 1.0,
            is_inverted: false,
        };
        let hit = marched.march(ray, 0);
        let is_off = |depth: f64| u32::from(texels_off(map, ray, depth) > 2.0);
        off += is_off(hit.depth.into());
        control += is_off(layered(map, ray, f64::from(degrees.to_radians().cos())));
        reads += hit.reads;
    }
    [off, reads, control].map(|n| n as f32 / rays as f32)
}

/// Parallax test 32: the maps, depth and angles that Bevy's 16 layers miss by two texels for 32 and 55 % of rays
/// at 75°.
#[test]
fn rays_meet_the_surface() {
    for (name, height) in [
        ("sine", sine as fn(f32, f32) -> f32),
        ("pillars", pillars),
        ("walls", walls),
    ] {
        let map = map([256; 2], Wrap::Repeat, height);
        for degrees in [0.0, 30.0, 60.0, 75.0, 85.0] {
            let [off, reads, control] = missed(&map, degrees, 4000);
            // Rays that graze an edge may pass it by what is rounded.
            assert!(off <= 0.0005, "{name}, {degrees}°: {off}");
            assert!(
                degrees > 75.0 || reads < 40.0,
                "{name}, {degrees}°: {reads}"
            );
            // Layers are off where they are known to be: the measure sees it.
            assert!(
                degrees < 75.0 || control > 0.1,
                "{name}, {degrees}°: {control}"
            );
        }
    }
}

/// Maps of all sizes, borders and sides, where everything is rough.
#[test]
fn any_map_is_marched_through() {
    let cases = [
        ([64, 64], Wrap::Repeat),
        ([37, 21], Wrap::Repeat),
        ([37, 21], Wrap::Clamp),
        ([128, 1], Wrap::Clamp),
        ([3, 5], Wrap::Repeat),
        ([1, 1], Wrap::Repeat),
    ];
    for (size, wrap) in cases {
        let map = map(size, wrap, |u, v| {
            let i = (u * size[0] as f32) as u32 + 1000 * (v * size[1] as f32) as u32;
            noise(i)
        });
        let marched = ParallaxMap::new(&map);
        let mut worst = 0.0_f64;
        for i in 0..2000 {
            let of = |k: u32| noise(7 * i + k);
            let ray = ParallaxRay {
                uv: 3.0 * Vec2::new(of(0), of(1)) - 1.0,
                slide: Vec2::new(of(2) - 0.5, of(3) - 0.5) * of(4),
                level: of(5),
                is_inverted: of(6) > 0.5,
            };
            let hit = marched.march(ray, 0);
            let apart = texels_off(&map, ray, hit.depth.into());
            worst = worst.max(apart);
            assert!(hit.depth.is_finite() && hit.reads < 400, "{ray:?}: {hit:?}");
        }
        assert!(worst < 0.1, "{size:?}, {wrap:?}: {worst}");
    }
}

/// Smaller means of a map are marched through as maps of their own.
#[test]
fn every_level_has_its_own_surface() {
    use crate::height_map::Pyramid;
    let whole = map([64, 48], Wrap::Repeat, |u, v| {
        0.5 * (sine(u, v) + noise((u * 64.0) as u32))
    });
    let pyramid = Pyramid::new(&whole);
    let [low, high] = pyramid.range();
    let marched = ParallaxMap::new(&whole);
    for mip in 1..4 {
        let level = &pyramid.levels()[mip];
        let heights = level
            .texels()
            .iter()
            .map(|t| (t.height - low) / (high - low));
        let means = HeightMap::new(level.size(), heights.collect(), [Wrap::Repeat; 2]).unwrap();
        for i in 0..500 {
            let ray = ParallaxRay {
                uv: Vec2::new(noise(3 * i), noise(3 * i + 1)),
                slide: Vec2::new(0.3, 0.4 * noise(3 * i + 2)),
                level: 1.0,
                is_inverted: i % 2 == 0,
            };
            let hit = marched.march(ray, mip);
            let apart = texels_off(&means, ray, hit.depth.into());
            assert!(apart < 0.05, "level {mip}, {ray:?}: {apart}");
        }
    }
}

/// Parallax test 35: what slides is finite and no longer than the slope that is followed, from straight above to
/// behind the surface.
#[test]
fn slides_are_cut_at_grazing_views() {
    for i in 0..=200 {
        let (towards, along) = (i as f32 * TAU / 200.0).sin_cos();
        let view = Vec3::new(along, 0.0, towards);
        let slide = parallax_slide(Vec3::Z, view, Vec3::Z, 5.0);
        assert!(
            slide.is_finite() && slide.length() <= 5.0 + 1e-4,
            "{view}: {slide}"
        );
        // Away from the viewer, as what lies deeper does.
        assert!(slide.x * along <= 0.0 && slide.z == 0.0);
        if towards > 0.2 {
            assert!((slide.x + along / towards).abs() < 1e-4);
        }
    }
    // Relief that stands aslant.
    let slide = parallax_slide(Vec3::Z, Vec3::Z, Vec3::new(0.3, -0.1, 0.8), 5.0);
    assert!(slide.distance(Vec3::new(0.3, -0.1, 0.0)) < 1e-6);
}
