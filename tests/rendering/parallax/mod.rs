//! Parallax as it is drawn, against rays through the same map on the CPU (`ParallaxMap`, which is held to a walk in
//! tiny steps by its own tests). The numbers of the tests are those of `docs/bump_mapping.md`.
//!
//! Not tested, because there is none yet: depth (37), outlines (38), shadows of the relief (40, in part).

mod hits;
mod holes;
mod passes;
mod textures;
mod views;

use bevy::camera::ScalingMode;
use bevy::math::Affine2;
use bevy::prelude::*;
use bevy_fresco::bump::{ParallaxMap, ParallaxRay};
use bevy_fresco::height_map::Kernel;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage, Parallax};

use crate::bumps::{sheet, show};
use crate::picture::Picture;
use crate::scenery::add;
use crate::stage::on_stage;

/// A camera that shows ±`half` m at 3 m.
#[derive(Clone, Copy)]
struct View {
    at: Transform,
    half: f32,
    is_orthographic: bool,
}

impl View {
    /// The camera of the stage.
    fn front(half: f32) -> Self {
        Self {
            at: Transform::from_xyz(0.0, 0.0, 3.0),
            half,
            is_orthographic: false,
        }
    }

    /// At 3 m from the origin, so far off the z axis and rolled.
    fn around(degrees: f32, half: f32) -> Self {
        let turn = Quat::from_rotation_z(0.7) * Quat::from_rotation_y(degrees.to_radians());
        let roll = Quat::from_rotation_z(0.3);
        Self {
            at: Transform::from_translation(turn * Vec3::new(0.0, 0.0, 3.0))
                .with_rotation(turn * roll),
            half,
            is_orthographic: false,
        }
    }

    fn orthographic(self) -> Self {
        Self {
            is_orthographic: true,
            ..self
        }
    }

    fn set(self, camera: &mut EntityWorldMut) {
        camera.insert(self.at);
        camera.insert(if self.is_orthographic {
            Projection::from(OrthographicProjection {
                scaling_mode: ScalingMode::Fixed {
                    width: 2.0 * self.half,
                    height: 2.0 * self.half,
                },
                ..OrthographicProjection::default_3d()
            })
        } else {
            Projection::from(PerspectiveProjection {
                fov: 2.0 * (self.half / 3.0).atan(),
                ..default()
            })
        });
    }

    /// Where the ray through a pixel begins, and where it goes.
    fn ray(self, picture: &Picture, pixel: usize) -> [Vec3; 2] {
        let n = picture.size;
        let at = |i: usize| 2.0 * (i as f32 + 0.5) / n as f32 - 1.0;
        let place = Vec3::new(self.half * at(pixel % n), -self.half * at(pixel / n), 0.0);
        let [from, towards] = if self.is_orthographic {
            [place, Vec3::NEG_Z]
        } else {
            [Vec3::ZERO, place - 3.0 * Vec3::Z]
        };
        [self.at * from, self.at.rotation * towards]
    }
}

/// A flat square, ±1 m in its own coordinates, with relief.
#[derive(Clone)]
struct Wall {
    map: HeightImage,
    height: BumpHeight,
    parallax: Parallax,
    /// Texture coordinates from `[0, 1]²`, which lies as pictures do: the first at the top left.
    uv: Affine2,
    /// How it lies in its own coordinates, before they are scaled.
    turn: Quat,
    at: Transform,
    base: StandardMaterial,
}

impl Wall {
    fn new(map: HeightImage, height: BumpHeight) -> Self {
        Self {
            map,
            height,
            parallax: default(),
            uv: Affine2::IDENTITY,
            turn: Quat::IDENTITY,
            at: default(),
            base: StandardMaterial {
                cull_mode: None,
                ..default()
            },
        }
    }

    fn mesh(&self) -> Mesh {
        let (uv, turn) = (self.uv, self.turn);
        sheet(8, move |p| {
            let at = Vec3::new(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, 0.0);
            (turn * at, turn * Vec3::Z, uv.transform_point2(p))
        })
    }

    fn bump(&self, world: &mut World) -> Bump {
        Bump {
            parallax: Some(self.parallax.clone()),
            ..Bump::new(add(world, self.map.clone()), self.height)
        }
    }

    fn show(&self, world: &mut World) -> Entity {
        let bump = self.bump(world);
        show(world, self.mesh(), self.base.clone(), Some(bump), self.at)
    }

    fn matrix(&self) -> Mat4 {
        self.at.to_matrix() * Mat4::from_quat(self.turn)
    }

    /// What texture coordinates a point of its plane has, wherever it lies.
    fn uv_at(&self, place: Vec3) -> Vec2 {
        let local = self.matrix().inverse().transform_point3(place);
        let square = Vec2::new(0.5 + 0.5 * local.x, 0.5 - 0.5 * local.y);
        self.uv.transform_point2(square)
    }

    /// The ray of sight as the map has it, by the geometry of the displaced wall: what lies `d` below the plane
    /// along `up` has the texture coordinates of the point of the plane above it.
    fn ray(&self, [from, towards]: [Vec3; 2]) -> ParallaxRay {
        let matrix = self.matrix();
        let up = matrix.transform_vector3(Vec3::Z);
        let normal = matrix
            .inverse()
            .transpose()
            .transform_vector3(Vec3::Z)
            .normalize();
        let (height, up) = match self.height {
            BumpHeight::Mesh(height) => (height, up),
            BumpHeight::World(height) => (height, normal),
            // Walls of these tests are stretched evenly then.
            BumpHeight::Uv(height) => (height * 2.0 * self.at.scale.x, normal),
        };
        let [low, high] = self.map.pyramid().range();
        let is_behind = towards.dot(normal) > 0.0;
        let is_inverted = is_behind != (height < 0.0);
        let up = if is_behind { -up } else { up } * (height.abs() * (high - low));
        let at_depth = |depth: f32| {
            let t = (self.at.translation - depth * up - from).dot(normal) / towards.dot(normal);
            self.uv_at(from + t * towards + depth * up)
        };
        let top = if height < 0.0 { low } else { high };
        let level = (self.parallax.level.unwrap_or(top) - low) / (high - low);
        ParallaxRay {
            uv: at_depth(0.0),
            slide: at_depth(1.0) - at_depth(0.0),
            level: if is_inverted { 1.0 - level } else { level },
            is_inverted,
        }
    }
}

/// What came of a picture of shifts.
#[derive(Debug, Default)]
struct Seen {
    pixels: usize,
    /// Share of rays that are off by more than two texels.
    off: f32,
    /// How far, in texels, texture coordinates are from those of the point that lies so deep on the ray of sight.
    drift: f32,
    /// The same in the mean, from the point that the ray meets on the CPU.
    mean: f32,
    /// How far points are off the relief that they are seen on, in shares of its range, where all of it is shown.
    floating: f32,
    /// Texels read by a ray.
    reads: f32,
}

/// Shows shifts of texture coordinates, depths and reads of a wall.
fn shoot(wall: &Wall, view: View, size: u32) -> Picture {
    let wall = wall.clone();
    on_stage(move |stage| {
        stage.show_parallax();
        stage.size = size;
        stage.shoot(
            |camera| view.set(camera),
            |world| {
                wall.show(world);
            },
        )
    })
}

/// Compares what is seen of a wall with what rays meet.
fn look(wall: &Wall, view: View, size: u32) -> Seen {
    let picture = shoot(wall, view, size);
    let marched = ParallaxMap::new(wall.map.map());
    let texels = Vec2::from(wall.map.map().size().map(|n| n as f32));
    let [low, high] = wall.map.pyramid().range();
    let mut seen = Seen::default();
    for (pixel, &[u, v, depth, reads]) in picture.pixels.iter().enumerate() {
        if reads == 0.0 {
            continue;
        }
        let shift = Vec2::new(u, v);
        assert!(shift.is_finite() && depth.is_finite(), "{shift}, {depth}");
        let ray = wall.ray(view.ray(&picture, pixel));
        let truth = marched.march(ray, 0);
        let apart = ((shift - truth.depth * ray.slide) * texels).length();
        seen.pixels += 1;
        seen.off += f32::from(u8::from(apart > 2.0));
        seen.mean += apart;
        seen.reads += reads;
        let drift = ((shift - depth * ray.slide) * texels).length();
        seen.drift = seen.drift.max(drift);
        // Shorter ways come in by and by: relief is lower there.
        if (ray.slide * texels).length() < 1.0 {
            continue;
        }
        let relief = (wall.map.map()).at(ray.uv + shift, Kernel::Bilinear);
        let share = (relief.height - low) / (high - low);
        let share = if ray.is_inverted { 1.0 - share } else { share };
        seen.floating = seen.floating.max((share - (ray.level - depth)).abs());
    }
    assert!(
        seen.pixels > 500,
        "only {} pixels show anything",
        seen.pixels
    );
    let count = seen.pixels as f32;
    seen.off /= count;
    seen.mean /= count;
    seen.reads /= count;
    seen
}
