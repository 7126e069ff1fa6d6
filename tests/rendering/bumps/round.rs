//! Bump test 2: round surfaces, against Blinn's formula and against the displaced surface itself.

use std::f32::consts::TAU;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_fresco::bump::blinn_normal;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{BumpHeight, insert_uv_gradients};

use super::{bump, error, ray, relief, sheet, show, zoom};
use crate::picture::Picture;
use crate::stage::on_stage;

const RADIUS: f32 = 0.8;
/// Waves around the whole circle, and their height: slopes up to 1, heights of 2 % of the radius.
const WAVES: f32 = 50.0;
const HEIGHT: f32 = RADIUS / WAVES;
/// What is seen: ±5 cm, some 60 pixels a wave.
const HALF: f32 = 0.05;
const DISTANCE: f32 = 3.0 - RADIUS;

#[derive(Clone, Copy)]
enum Shape {
    Cylinder,
    Sphere,
}

impl Shape {
    /// A point of the surface raised by `height`; `u` goes around, `v` up, both in radians.
    fn point(self, u: f64, v: f64, height: f64) -> DVec3 {
        let r = f64::from(RADIUS) + height;
        match self {
            Self::Cylinder => DVec3::new(r * u.sin(), f64::from(RADIUS) * v, r * u.cos()),
            Self::Sphere => r * DVec3::new(v.cos() * u.sin(), v.sin(), v.cos() * u.cos()),
        }
    }

    fn normal(self, u: f64, v: f64) -> DVec3 {
        match self {
            Self::Cylinder => DVec3::new(u.sin(), 0.0, u.cos()),
            Self::Sphere => self.point(u, v, 0.0).normalize(),
        }
    }

    /// Where the ray of a pixel meets the surface.
    fn hit(self, picture: &Picture, pixel: usize) -> [f64; 2] {
        let d = DVec3::from(ray(picture, pixel, HALF, DISTANCE));
        let o = DVec3::new(0.0, 0.0, 3.0);
        let flat = match self {
            Self::Cylinder => DVec3::new(1.0, 0.0, 1.0),
            Self::Sphere => DVec3::ONE,
        };
        let (a, b) = ((d * flat).length_squared(), (o * flat).dot(d * flat));
        let c = (o * flat).length_squared() - f64::from(RADIUS * RADIUS);
        let t = (-b - (b * b - a * c).sqrt()) / a;
        let p = o + t * d;
        match self {
            Self::Cylinder => [p.x.atan2(p.z), p.y / f64::from(RADIUS)],
            Self::Sphere => [p.x.atan2(p.z), (p.y / f64::from(RADIUS)).asin()],
        }
    }
}

/// Waves around, and weaker ones upwards. `u`, `v` in radians.
fn height(u: f64, v: f64) -> f64 {
    let w = f64::from(WAVES);
    f64::from(HEIGHT) * ((w * u).sin() + 0.3 * (w * v + 1.0).sin())
}

fn shoot(shape: Shape, has_gradients: bool, curvature: bool) -> Picture {
    on_stage(move |stage| {
        stage.show_normals(true);
        stage.shoot(
            |camera| zoom(camera, HALF, DISTANCE),
            |world| {
                // A patch of ±0.1 rad, with one wave of the map over one wave of the surface.
                let mut patch = sheet(128, |p| {
                    let [u, v] = [p.x - 0.5, 0.5 - p.y].map(|x| 0.2 * f64::from(x));
                    let uv = Vec2::new(u as f32, v as f32) * WAVES / TAU;
                    let [at, normal] = [shape.point(u, v, 0.0), shape.normal(u, v)];
                    (at.as_vec3(), normal.as_vec3(), uv)
                });
                if has_gradients {
                    insert_uv_gradients(&mut patch).unwrap();
                }
                let map = relief([128; 2], Wrap::Repeat, |u, v| {
                    let w = f64::from(TAU / WAVES);
                    height(f64::from(u) * w, f64::from(v) * w) as f32 / HEIGHT
                });
                let mut waves = bump(world, map, BumpHeight::World(HEIGHT));
                waves.curvature = curvature;
                show(world, patch, default(), Some(waves), default());
            },
        )
    })
}

/// Blinn's normal, by the letter of his formula.
fn blinn(shape: Shape, [u, v]: [f64; 2]) -> Vec3 {
    let e = 1e-5;
    let by_u = (shape.point(u + e, v, 0.0) - shape.point(u - e, v, 0.0)) / (2.0 * e);
    let by_v = (shape.point(u, v + e, 0.0) - shape.point(u, v - e, 0.0)) / (2.0 * e);
    let slopes = DVec3::new(
        (height(u + e, v) - height(u - e, v)) / (2.0 * e),
        (height(u, v + e) - height(u, v - e)) / (2.0 * e),
        0.0,
    );
    blinn_normal(by_u.as_vec3(), by_v.as_vec3(), slopes.as_vec3().xy()).unwrap()
}

/// The normal of the raised surface.
fn truth(shape: Shape, [u, v]: [f64; 2]) -> Vec3 {
    let e = 1e-5;
    let point = |u, v| shape.point(u, v, height(u, v));
    let by_u = point(u + e, v) - point(u - e, v);
    let by_v = point(u, v + e) - point(u, v - e);
    by_u.cross(by_v).normalize().as_vec3()
}

#[test]
fn round_surfaces_have_blinns_normal() {
    for (name, shape) in [("cylinder", Shape::Cylinder), ("sphere", Shape::Sphere)] {
        for has_gradients in [false, true] {
            let picture = shoot(shape, has_gradients, false);
            let (most, mean) = error(&picture, |i| Some(blinn(shape, shape.hit(&picture, i))));
            println!("{name}, Blinn, {has_gradients}: {most:.3}° at most, {mean:.3}° RMS");
            assert!(most < 0.1, "{name}: {most}°");
        }
    }
}

#[test]
fn with_curvature_they_have_the_true_one() {
    for (name, shape) in [("cylinder", Shape::Cylinder), ("sphere", Shape::Sphere)] {
        for has_gradients in [false, true] {
            let of_truth = |picture: &Picture| {
                let truth = |i| Some(truth(shape, shape.hit(picture, i)));
                error(picture, truth)
            };
            let (most, mean) = of_truth(&shoot(shape, has_gradients, true));
            let (blinns, _) = of_truth(&shoot(shape, has_gradients, false));
            println!(
                "{name}, {has_gradients}: {most:.3}° at most, {mean:.3}° RMS; Blinn {blinns:.3}°"
            );
            assert!(most < 0.1, "{name}: {most}°");
            // Slopes off by 1 + h/R.
            assert!(blinns > 3.0 * most);
        }
    }
}
