//! Normals of bumps as they are drawn, against those of surfaces that are known in closed form. The numbers
//! of the tests are those of `docs/bump_mapping.md`.

mod filtering;
mod formulas;
mod missing;
mod passes;
mod plane;
mod round;
mod views;

use std::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::math::DVec3;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial};

pub(crate) use passes::{PrepassNormals, show_prepass};

use crate::picture::Picture;
use crate::scenery::add;

/// The angle between two directions in degrees.
pub(crate) fn degrees(a: Vec3, b: Vec3) -> f32 {
    // By the cross product: the cosine of small angles says nothing in f32.
    let [a, b] = [a, b].map(DVec3::from);
    a.cross(b).length().atan2(a.dot(b)).to_degrees() as f32
}

/// A map of heights over texture coordinates.
pub(crate) fn relief(size: [u32; 2], wrap: Wrap, height: impl Fn(f32, f32) -> f32) -> HeightImage {
    let [width, rows] = size;
    let heights = (0..width * rows).map(|i| {
        let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        height(x / width as f32, y / rows as f32)
    });
    HeightImage::new(HeightMap::new(size, heights.collect(), [wrap; 2]).unwrap())
}

/// Drawn whichever way it is turned, without a side that Bevy would turn normals for.
fn seen_from_everywhere() -> StandardMaterial {
    StandardMaterial {
        cull_mode: None,
        ..default()
    }
}

pub(crate) fn show(
    world: &mut World,
    mesh: Mesh,
    base: StandardMaterial,
    bump: Option<Bump>,
    at: Transform,
) -> Entity {
    let material = FrescoMaterial {
        base,
        extension: FrescoExtension { bump, ..default() },
    };
    let material = MeshMaterial3d(add(world, material));
    let mesh = Mesh3d(add(world, mesh));
    world.spawn((mesh, material, at)).id()
}

/// A bump by a map that is added to the world.
pub(crate) fn bump(world: &mut World, map: HeightImage, height: BumpHeight) -> Bump {
    Bump::new(add(world, map), height)
}

/// The camera at (0, 0, 3), showing ±`half` at `distance` in front of it.
fn zoom(camera: &mut EntityWorldMut, half: f32, distance: f32) {
    camera.insert(Projection::from(PerspectiveProjection {
        fov: 2.0 * (half / distance).atan(),
        ..default()
    }));
}

/// Direction from the camera through the middle of a pixel, `half` at `distance` being the border.
fn ray(picture: &Picture, pixel: usize, half: f32, distance: f32) -> Vec3 {
    let n = picture.size;
    let at = |i: usize| 2.0 * (i as f32 + 0.5) / n as f32 - 1.0;
    Vec3::new(half * at(pixel % n), -half * at(pixel / n), -distance)
}

/// Where a pixel of the usual camera meets the plane `z = 0`: ±1 m.
fn on_plane(picture: &Picture, pixel: usize) -> Vec2 {
    ray(picture, pixel, 1.0, 3.0).xy()
}

pub(crate) fn normal(picture: &Picture, pixel: usize) -> Vec3 {
    let [x, y, z, _] = picture.pixels[pixel];
    Vec3::new(x, y, z)
}

/// The greatest and the mean square error of a picture of normals, in degrees, where `truth` says something.
fn error(picture: &Picture, truth: impl Fn(usize) -> Option<Vec3>) -> (f32, f32) {
    let (mut most, mut squares, mut count) = (0.0_f32, 0.0_f64, 0);
    for pixel in 0..picture.pixels.len() {
        let Some(truth) = truth(pixel) else {
            continue;
        };
        let found = normal(picture, pixel);
        assert!((found.length() - 1.0).abs() < 2e-3, "{found} is no normal");
        let off = degrees(found, truth);
        most = most.max(off);
        squares += f64::from(off * off);
        count += 1;
    }
    assert!(count > 100, "only {count} pixels show anything");
    (most, (squares / f64::from(count)).sqrt() as f32)
}

/// A sheet of `n × n` quads over the unit square, by any function of it.
pub(crate) fn sheet(n: u32, at: impl Fn(Vec2) -> (Vec3, Vec3, Vec2)) -> Mesh {
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec2::new(x as f32, y as f32)));
    let points: Vec<_> = points.map(|p| at(p / n as f32)).collect();
    let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    let corners = quads.flat_map(|i| [i, i + n + 1, i + 1, i + 1, i + n + 1, i + n + 2]);
    let part =
        |of: fn(&(Vec3, Vec3, Vec2)) -> Vec3| -> Vec<Vec3> { points.iter().map(of).collect() };
    let uvs: Vec<Vec2> = points.iter().map(|p| p.2).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, part(|p| p.0))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, part(|p| p.1))
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(corners.collect()))
}

/// Waves that are alike in no direction and have no symmetry, over texture coordinates that repeat; and their
/// slopes.
fn waves(uv: Vec2) -> (f32, Vec2) {
    let (a, b) = (TAU * uv.x, TAU * (uv.x + 2.0 * uv.y) + 0.7);
    let height = 0.6 * a.sin() + 0.4 * b.cos();
    let slopes = Vec2::new(0.6 * a.cos() - 0.4 * b.sin(), -0.8 * b.sin());
    (height, TAU * slopes)
}

/// [`waves`] as a map.
pub(crate) fn waves_map(size: [u32; 2]) -> HeightImage {
    relief(size, Wrap::Repeat, |u, v| waves(Vec2::new(u, v)).0)
}

/// Normal of the plane `z = 0` with [`waves`] of this height on the texture coordinates of
/// [`grid`](crate::scenery::grid).
fn waves_on_grid(at: Vec2, height: f32) -> Vec3 {
    let uv = Vec2::new(0.5 * (1.0 + at.x), 0.5 * (1.0 - at.y));
    let slopes = height * waves(uv).1;
    Vec3::new(-0.5 * slopes.x, 0.5 * slopes.y, 1.0).normalize()
}
