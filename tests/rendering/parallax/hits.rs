//! Parallax tests 32, 33 and 35: rays meet what they must, thin or not, and end where the view grazes.

use std::f32::consts::TAU;

use bevy::prelude::*;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{BumpHeight, HeightImage, Parallax};

use super::{View, Wall, look, shoot};
use crate::bumps::{bump, relief, show};
use crate::stage::on_stage;

const TEXELS: u32 = 256;

fn sine() -> HeightImage {
    relief([TEXELS; 2], Wrap::Repeat, |u, v| {
        0.5 + 0.25 * (8.0 * TAU * u).sin() + 0.25 * (8.0 * TAU * v).sin()
    })
}

fn pillars() -> HeightImage {
    relief([TEXELS; 2], Wrap::Repeat, |u, v| {
        let stands = |x: f32| ((x * TEXELS as f32 / 4.0) as u32).is_multiple_of(2);
        f32::from(u8::from(stands(u) && stands(v)))
    })
}

/// Walls of so many texels, 16 from one to the next.
fn walls(thick: u32) -> HeightImage {
    relief([TEXELS; 2], Wrap::Repeat, move |u, v| {
        let [x, y] = [u, v].map(|c| (c * TEXELS as f32) as u32);
        f32::from(u8::from(x % 16 < thick || (y + 7) % 16 < thick))
    })
}

/// A wall that parallel rays meet at this angle to its normal, aslant to its texture coordinates; near enough for
/// rays to go through its own texels.
fn slanted(map: HeightImage, degrees: f32) -> (Wall, View) {
    let mut wall = Wall::new(map, BumpHeight::Uv(0.1));
    wall.parallax = Parallax {
        max_slope: 20.0,
        ..default()
    };
    wall.at.rotation = Quat::from_rotation_x(-degrees.to_radians()) * Quat::from_rotation_z(0.5);
    let half = 0.9 * degrees.to_radians().cos();
    (wall, View::front(half).orthographic())
}

/// Parallax test 32: the map sizes, depth and angles at which Bevy's 16 layers miss by two texels for 3 to 55 % of
/// rays.
#[test]
fn rays_meet_the_relief() {
    type Make = fn() -> HeightImage;
    for (name, map) in [("sine", sine as Make), ("pillars", pillars)] {
        for degrees in [30.0, 60.0, 75.0, 85.0] {
            let (wall, view) = slanted(map(), degrees);
            let seen = look(&wall, view, 128);
            println!(
                "{name}, {degrees}°: {:.3} % of {} off, {:.3} texels in the mean, {:.1} reads",
                100.0 * seen.off,
                seen.pixels,
                seen.mean,
                seen.reads
            );
            // Rays that graze an edge may pass it by what f32 rounds: none in most pictures.
            assert!(seen.off < 0.0005, "{name}, {degrees}°: {}", seen.off);
        }
    }
}

/// Parallax test 33: walls of one and two texels are not missed.
#[test]
fn thin_walls_are_met() {
    for thick in [1, 2] {
        for degrees in [60.0, 75.0] {
            let (wall, view) = slanted(walls(thick), degrees);
            let seen = look(&wall, view, 128);
            println!(
                "{thick} texels, {degrees}°: {:.3} % missed, {:.1} reads",
                100.0 * seen.off,
                seen.reads
            );
            assert!(seen.off < 0.001, "{thick} texels, {degrees}°: {}", seen.off);
        }
    }
}

/// Parallax test 35: finite everywhere, and no shift longer than the slope cap allows, on a wall that is all but
/// parallel to the view and on a ball, whose normals turn away from the viewer at its outline.
#[test]
fn grazing_views_stay_within_the_slope() {
    for degrees in [80.0, 88.0, 89.5] {
        // A ridge, and ground that most rays reach.
        let ridge = relief([TEXELS; 2], Wrap::Repeat, |u, _| {
            f32::from(u8::from(u < 0.1))
        });
        let (mut wall, view) = slanted(ridge, degrees);
        wall.parallax.max_slope = 5.0;
        let picture = shoot(&wall, view, 64);
        let seen = picture.pixels.iter().filter(|p| p[3] > 0.0);
        let shifts: Vec<f32> = seen.map(|p| Vec2::new(p[0], p[1]).length()).collect();
        let most = shifts.iter().copied().fold(0.0, f32::max);
        println!(
            "{degrees}°: {} pixels, {most:.3} of the map at most",
            shifts.len()
        );
        assert!(shifts.len() > 500 && shifts.iter().all(|s| s.is_finite()));
        // Those on the ground are shifted as far as the cap lets them.
        assert!((0.4..0.502).contains(&most), "{degrees}°: {most}");
    }
    let picture = on_stage(|stage| {
        stage.show_parallax();
        stage.shoot(
            |camera| View::front(1.1).set(camera),
            |world| {
                let mut bumps = bump(world, pillars(), BumpHeight::World(0.05));
                bumps.parallax = Some(Parallax::default());
                let ball = Sphere::new(1.0).mesh().uv(64, 32);
                show(world, ball, default(), Some(bumps), default());
            },
        )
    });
    let seen: Vec<_> = picture.pixels.iter().filter(|p| p[3] > 0.0).collect();
    for p in &seen {
        assert!(p.iter().all(|x| x.is_finite()), "{p:?}");
        // v goes from pole to pole, π metres.
        let along = std::f32::consts::PI * p[1].abs();
        assert!(along <= 5.0 * 0.05 * 1.05, "{along} m");
        assert!((-0.01..=1.001).contains(&p[2]), "{}", p[2]);
    }
    assert!(seen.len() > 1000);
}
