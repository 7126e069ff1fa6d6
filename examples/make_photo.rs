//! Renders a photo of glazed cobbles for `docs/height_maps.md`:
//!
//! ```text
//! cargo run --release --no-default-features --features cli --example make_photo -- assets/textures/cobbles.png
//! ```
//!
//! It has what photos of surfaces have: relief in the shading, light that falls off to one side, and gloss.

use std::process::ExitCode;

use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};

/// Texels along each side.
const SIDE: u32 = 208;

/// Stones along each side.
const STONES: i32 = 5;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1) else {
        return failed("name the PNG to write");
    };
    let photo = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / SIDE as f32;
        // As much noise as a camera has by day.
        let noise = |seed| 1.0 + 0.04 * (random(x as i32, y as i32, seed) - 0.5);
        let light = light(place) * Vec3::new(noise(4), noise(5), noise(6));
        Rgb(light.to_array().map(srgb))
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
    let slope = |d: Vec2| 0.05 * (height(place + d) - height(place - d)) / (2.0 * step);
    let normal = Vec3::new(-slope(Vec2::X * step), slope(Vec2::Y * step), 1.0).normalize();
    let lamp = Vec3::new(-1.0, 1.0, 2.0).normalize();
    let mirrored = 2.0 * normal.dot(lamp) * normal - lamp;
    // Less of the sky reaches into joints.
    let sky = 0.5 * height(place).powi(2);
    let clay = Vec3::new(0.36, 0.2, 0.14);
    let matte = clay * (sky + 0.5 * normal.dot(lamp).max(0.0));
    let gloss = 0.4 * mirrored.z.max(0.0).powi(60);
    // The lamp is nearer to the left.
    (matte + gloss) * (1.3 - 0.7 * place.x)
}

/// Height from 0 to 1: stones are balls, and what is seen is the highest.
fn height(place: Vec2) -> f32 {
    let place = place * STONES as f32;
    let cell = place.floor();
    let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
    let ball = |(dx, dy): (i32, i32)| {
        let [x, y] = [cell.x as i32 + dx, cell.y as i32 + dy];
        let off = Vec2::new(stone(x, y, 1), stone(x, y, 2)) * 0.4 + 0.3;
        let radius = 0.55 + 0.15 * stone(x, y, 3);
        let share = place.distance(Vec2::new(x as f32, y as f32) + off) / radius;
        (1.0 - share * share).max(0.0).sqrt()
    };
    around.map(ball).fold(0.0, f32::max)
}

/// Whatever a stone is made with: the same for all stones that are one when the photo tiles.
fn stone(x: i32, y: i32, seed: u32) -> f32 {
    random(x.rem_euclid(STONES), y.rem_euclid(STONES), seed)
}

/// In 0..1, the same on every run.
fn random(x: i32, y: i32, seed: u32) -> f32 {
    let mut hash = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77)
        ^ seed.wrapping_mul(0xc2b2_ae3d);
    for shift in [15, 13, 16] {
        hash = (hash ^ (hash >> shift)).wrapping_mul(0x2c1b_3c6d);
    }
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
