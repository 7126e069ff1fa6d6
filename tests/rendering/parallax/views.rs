//! Parallax tests 34, 39 and 40: relief stands still in the world, however it is looked at and however its mesh and
//! texture coordinates are stretched, mirrored and turned.

use bevy::math::{Affine2, Mat2};
use bevy::prelude::*;
use bevy_fresco::plugin::bump::{BumpHeight, Parallax};

use super::{View, Wall, look};
use crate::bumps::waves_map;

const HEIGHT: f32 = 0.06;

fn wall(height: BumpHeight) -> Wall {
    Wall::new(waves_map([256; 2]), height)
}

#[track_caller]
fn assert_still(name: &str, wall: &Wall, view: View) {
    let seen = look(wall, view, 64);
    println!(
        "{name}: {:.3} texels of drift, {:.4} of the relief beside it, {:.3} % off, {:.1} reads",
        seen.drift,
        seen.floating,
        100.0 * seen.off,
        seen.reads
    );
    assert!(seen.drift < 1.0, "{name}: {seen:?}");
    // Half floats of pictures, and the derivatives of a perspective.
    assert!(seen.floating < 0.02, "{name}: {seen:?}");
    assert!(seen.off < 0.001, "{name}: {seen:?}");
}

/// Parallax test 34: a point of the relief keeps its texture coordinates as the camera goes round it.
#[test]
fn relief_does_not_swim() {
    for degrees in [0.0_f32, 20.0, 40.0, 60.0, 75.0] {
        let half = 0.4 * degrees.to_radians().cos();
        let view = View::around(degrees, half);
        assert_still(
            &format!("{degrees}°"),
            &wall(BumpHeight::World(HEIGHT)),
            view,
        );
    }
}

/// Parallax test 40: under parallel rays too. (Shadows are those of the mesh: relief casts none.)
#[test]
fn orthographic_views_have_parallel_rays() {
    // Straight on, nothing is moved.
    for degrees in [15.0, 30.0, 60.0] {
        let view = View::around(degrees, 0.4).orthographic();
        assert_still(
            &format!("{degrees}°"),
            &wall(BumpHeight::World(HEIGHT)),
            view,
        );
    }
}

/// Parallax test 39: heights of the world stay, however often the map is repeated; the others have their units.
#[test]
fn heights_have_the_unit_they_are_given_in() {
    let view = View::around(50.0, 0.25);
    for times in [1.0, 2.0, 3.0] {
        let mut wall = wall(BumpHeight::World(HEIGHT));
        wall.uv = Affine2::from_scale(Vec2::splat(times));
        assert_still(&format!("{times} times"), &wall, view);
    }
    for scale in [0.7, 1.5] {
        for (name, height) in [
            ("mesh", BumpHeight::Mesh(HEIGHT)),
            ("world", BumpHeight::World(HEIGHT)),
            ("map", BumpHeight::Uv(0.5 * HEIGHT)),
        ] {
            let mut wall = wall(height);
            wall.at.scale = Vec3::splat(scale);
            assert_still(&format!("{name}, scale {scale}"), &wall, view);
        }
    }
}

/// Parallax test 39: texture coordinates that are stretched, sheared and mirrored, and scales that are uneven and
/// negative.
#[test]
fn stretched_and_mirrored_walls_are_right() {
    let view = View::around(50.0, 0.25);
    let of_uv = [
        ("stretched", Mat2::from_diagonal(Vec2::new(1.7, 0.6))),
        (
            "sheared",
            Mat2::from_cols(Vec2::new(1.1, -0.4), Vec2::new(0.3, 0.8)),
        ),
        ("mirrored", Mat2::from_diagonal(Vec2::new(-1.0, 1.0))),
    ];
    for (name, matrix) in of_uv {
        let mut wall = wall(BumpHeight::World(HEIGHT));
        wall.uv = Affine2::from_mat2_translation(matrix, Vec2::new(0.3, 0.1));
        assert_still(name, &wall, view);
    }
    for (name, scale) in [
        ("uneven", Vec3::new(1.3, 0.8, 1.0)),
        ("low", Vec3::new(1.2, 1.2, 0.5)),
        ("negative", Vec3::new(-1.0, 1.0, 1.0)),
        ("negative and uneven", Vec3::new(1.3, -0.9, 0.8)),
    ] {
        for height in [BumpHeight::Mesh(HEIGHT), BumpHeight::World(HEIGHT)] {
            let mut wall = wall(height);
            wall.at.scale = scale;
            assert_still(&format!("{name} scale, {height:?}"), &wall, view);
        }
    }
}

/// Parallax test 39: under an uneven scale that is aslant to it, relief of the mesh stands aslant.
#[test]
fn relief_may_stand_aslant() {
    for height in [BumpHeight::Mesh(HEIGHT), BumpHeight::World(HEIGHT)] {
        let mut wall = wall(height);
        wall.turn = Quat::from_euler(EulerRot::XYZ, 0.5, 0.4, 0.2);
        wall.at.scale = Vec3::new(1.4, 0.7, 0.9);
        for degrees in [0.0, 30.0] {
            let view = View::around(degrees, 0.25);
            assert_still(&format!("{height:?} aslant, {degrees}°"), &wall, view);
        }
    }
}

/// From behind relief is that of the front seen through the mesh; negative heights are depths; and the mesh may lie
/// at any height.
#[test]
fn either_side_and_any_level_are_right() {
    for (name, degrees, double_sided) in [
        ("front", 40.0, false),
        ("behind", 140.0, false),
        ("behind, double-sided", 140.0, true),
    ] {
        for height in [HEIGHT, -HEIGHT] {
            for level in [None, Some(0.2)] {
                let mut wall = wall(BumpHeight::World(height));
                wall.base.double_sided = double_sided;
                wall.parallax = Parallax { level, ..default() };
                let view = View::around(degrees, 0.25);
                assert_still(&format!("{name}, {height} m, {level:?}"), &wall, view);
            }
        }
    }
}
