//! Renders a photo of glazed cobbles for `docs/height_maps.md`:
//!
//! ```text
//! cargo run --no-default-features --features gltf --example make_photo -- assets/textures/cobbles.png
//! ```
//!
//! It has what photos of surfaces have: relief in the shading, light that falls off to one side, and gloss.

use std::process::ExitCode;

use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};

/// Texels along each side.
const SIDE: u32 = 256;

/// Stones along each side.
const STONES: i32 = 5;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1) else {
        return failed("name the PNG to write");
    };
    let photo = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / SIDE as f32;
        Rgb(light(place).to_array().map(srgb))
    });
    match photo.save(&path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(&error.to_string()),
    }
}

#[allow(clippy::print_stderr, reason = "a program that cannot go on says why")]
fn failed(reason: &str) -> ExitCode {
    eprintln!("error: {reason}");
    ExitCode::FAILURE
}

/// What the camera sees from above, the lamp at the upper left.
fn light(place: Vec2) -> Vec3 {
    let step = 0.5 / SIDE as f32;
    let slope = |d: Vec2| 0.07 * (height(place + d) - height(place - d)) / (2.0 * step);
    let normal = Vec3::new(-slope(Vec2::X * step), slope(Vec2::Y * step), 1.0).normalize();
    let lamp = Vec3::new(-1.0, 1.0, 2.2).normalize();
    let mirrored = 2.0 * normal.dot(lamp) * normal - lamp;
    // Less of the sky reaches into joints.
    let sky = 0.35 * height(place).clamp(0.15, 1.0);
    let clay = Vec3::new(0.42, 0.24, 0.16);
    let matte = clay * (sky + 0.65 * normal.dot(lamp).max(0.0));
    let gloss = 0.9 * mirrored.z.max(0.0).powi(90);
    // The lamp is nearer to the left.
    (matte + gloss) * (1.25 - 0.75 * place.x)
}

/// Height from 0 to 1: stones are round where the distance to the nearest differs much from that to the
/// second nearest (S. Worley, "A cellular texture basis function", SIGGRAPH 1996).
fn height(place: Vec2) -> f32 {
    let place = place * STONES as f32;
    let cell = place.floor();
    let (mut first, mut second) = (f32::MAX, f32::MAX);
    for (dx, dy) in (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy))) {
        let [x, y] = [cell.x as i32 + dx, cell.y as i32 + dy];
        let off = Vec2::new(random(x, y, 1), random(x, y, 2)) * 0.6 + 0.2;
        let distance = place.distance(Vec2::new(x as f32, y as f32) + off);
        (first, second) = match distance {
            d if d < first => (d, first),
            d => (first, second.min(d)),
        };
    }
    let round = ((second - first) / 0.6).clamp(0.0, 1.0);
    (1.0 - (1.0 - round).powi(2)).sqrt() * (1.0 - 0.3 * first)
}

/// In 0..1, the same for all stones that are one when the photo tiles.
fn random(x: i32, y: i32, seed: u32) -> f32 {
    let [x, y] = [x, y].map(|i| i.rem_euclid(STONES) as u32);
    let mut hash = (x * 31 + y * 131 + seed * 1_009).wrapping_mul(0x9e37_79b1);
    hash ^= hash >> 15;
    hash = hash.wrapping_mul(0x85eb_ca77);
    (hash >> 8) as f32 / (1 << 24) as f32
}

fn srgb(light: f32) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value).round() as u8
}
