//! Baked light at turned normals, against light gathered by rays about them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]
#![allow(clippy::print_stdout, reason = "how close it came")]
#![cfg(feature = "gltf")]

use std::f32::consts::{FRAC_1_PI, TAU};
use std::path::Path;

use bevy_fresco::gltf::load;
use bevy_fresco::radiosity::{Bake, BakeSettings, Object, ObjectLight, Scene, bake, reshade};
use glam::{Mat3, Vec3};
use rayon::prelude::*;

/// A point on a mesh, with the unit normal there.
struct Point {
    object: usize,
    triangle: usize,
    weights: Vec3,
    position: Vec3,
    normal: Vec3,
}

/// Rays by brute force over all triangles, boxes of objects first.
struct Room<'a> {
    scene: &'a Scene,
    bake: &'a Bake,
    boxes: Vec<(Vec3, Vec3)>,
}

/// Gathering rays of a point, and shadow rays to each emissive triangle.
const RAYS: u32 = 1024;
const SHADOW_RAYS: u32 = 64;

/// Rays start this far off the surface, in metres.
const OFFSET: f32 = 1e-4;

impl<'a> Room<'a> {
    fn new(scene: &'a Scene, bake: &'a Bake) -> Self {
        let around = |o: &Object| {
            let low = o.positions.iter().copied().reduce(Vec3::min).unwrap();
            let high = o.positions.iter().copied().reduce(Vec3::max).unwrap();
            (low - OFFSET, high + OFFSET)
        };
        Self {
            scene,
            bake,
            boxes: scene.objects.iter().map(around).collect(),
        }
    }

    fn corners(&self, o: usize, t: usize) -> [Vec3; 3] {
        let object = &self.scene.objects[o];
        object.triangles[t].map(|v| object.positions[v as usize])
    }

    /// The nearest hit: object, triangle, weights of its corners, distance.
    fn hit(&self, from: Vec3, way: Vec3) -> Option<(usize, usize, Vec3, f32)> {
        let mut nearest: Option<(usize, usize, Vec3, f32)> = None;
        for (o, (low, high)) in self.boxes.iter().enumerate() {
            let (a, b) = ((low - from) / way, (high - from) / way);
            let enters = a.min(b).max_element();
            let end = nearest.map_or(f32::INFINITY, |n| n.3);
            if enters > a.max(b).min_element().min(end) {
                continue;
            }
            for t in 0..self.scene.objects[o].triangles.len() {
                if let Some((weights, distance)) = meets(self.corners(o, t), from, way)
                    && distance < nearest.map_or(f32::INFINITY, |n| n.3)
                {
                    nearest = Some((o, t, weights, distance));
                }
            }
        }
        nearest
    }

    fn at(&self, values: &[Vec3], o: usize, t: usize, weights: Vec3) -> Vec3 {
        let [a, b, c] = self.scene.objects[o].triangles[t].map(|v| values[v as usize]);
        a * weights.x + b * weights.y + c * weights.z
    }

    /// Radiance that a surface reflects.
    fn reflected(&self, (o, t, weights, _): (usize, usize, Vec3, f32), way: Vec3) -> Vec3 {
        let [a, b, c] = self.corners(o, t);
        if (b - a).cross(c - a).dot(way) > 0.0 {
            return Vec3::ZERO;
        }
        let material = &self.scene.materials[self.scene.objects[o].material.0 as usize];
        let light = self.at(&self.bake.objects[o].light, o, t, weights);
        material.base_color.truncate() * (1.0 - material.metallic) * light
    }

    /// Irradiance / π of the `bumped` normal, from above the surface.
    fn gathered(&self, point: &Point, bumped: Vec3, seed: u32) -> Vec3 {
        let from = point.position + point.normal * OFFSET;
        let around = Mat3::from_quat(glam::Quat::from_rotation_arc(Vec3::Z, bumped));
        let mut sum = Vec3::ZERO;
        for i in 0..RAYS {
            let [u, v] = plastic(i, seed);
            let way = around
                * Vec3::new(
                    (TAU * v).cos() * u.sqrt(),
                    (TAU * v).sin() * u.sqrt(),
                    (1.0 - u).sqrt(),
                );
            if way.dot(point.normal) > 0.0
                && let Some(hit) = self.hit(from, way)
            {
                sum += self.reflected(hit, way) / RAYS as f32;
            }
        }
        sum + self.direct(point, bumped, from, seed)
    }

    /// The part of it that comes from emissive triangles, by points on these.
    fn direct(&self, point: &Point, bumped: Vec3, from: Vec3, seed: u32) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (o, object) in self.scene.objects.iter().enumerate() {
            let emission = self.scene.materials[object.material.0 as usize].emissive;
            let triangles = if emission == Vec3::ZERO {
                0
            } else {
                object.triangles.len()
            };
            for t in 0..triangles {
                let [a, b, c] = self.corners(o, t);
                let across = (b - a).cross(c - a);
                for i in 0..SHADOW_RAYS {
                    let [u, v] = plastic(i, seed ^ (t as u32 * 977));
                    let root = u.sqrt();
                    let to = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v) - from;
                    let way = to.normalize();
                    let (cosine, facing) = (bumped.dot(way), -across.dot(way) * 0.5);
                    if cosine <= 0.0 || facing <= 0.0 || point.normal.dot(way) <= 0.0 {
                        continue;
                    }
                    let seen = self
                        .hit(from, way)
                        .is_none_or(|h| h.3 > to.length() - 2.0 * OFFSET);
                    if seen {
                        let brings = cosine * facing * FRAC_1_PI / to.length_squared();
                        sum += emission * brings / SHADOW_RAYS as f32;
                    }
                }
            }
        }
        sum
    }
}

/// Möller and Trumbore 1997.
fn meets([a, b, c]: [Vec3; 3], from: Vec3, way: Vec3) -> Option<(Vec3, f32)> {
    let (ab, ac) = (b - a, c - a);
    let p = way.cross(ac);
    let determinant = ab.dot(p);
    let to = from - a;
    let u = to.dot(p) / determinant;
    let q = to.cross(ab);
    let v = way.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > OFFSET * 0.1;
    (inside && distance.is_finite()).then_some((Vec3::new(1.0 - u - v, u, v), distance))
}

/// Points spread evenly over the unit square: Roberts' sequence, started elsewhere for each seed.
fn plastic(i: u32, seed: u32) -> [f32; 2] {
    let start = [random(seed, 0), random(seed, 1)];
    let step = [0.754_877_666_246_692_8_f64, 0.569_840_290_998_053_2];
    [0, 1].map(|k| ((f64::from(start[k]) + step[k] * f64::from(i)).fract() as f32).min(0.999_999))
}

/// A number in 0..1.
fn random(seed: u32, salt: u32) -> f32 {
    let mut h = seed.wrapping_mul(0x9E37_79B9) ^ salt.wrapping_mul(0x85EB_CA6B);
    for m in [0x85EB_CA6B_u32, 0xC2B2_AE35] {
        h = (h ^ (h >> 15)).wrapping_mul(m);
    }
    (h >> 8) as f32 / 16_777_216.0
}

/// `count` of the points at which the reference of the Cornell box was made, evenly picked.
fn points(scene: &Scene, count: usize) -> Vec<Point> {
    let lines: Vec<&str> = include_str!("data/cornell_box_mitsuba.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    let point = |i: usize| {
        let fields: Vec<&str> = lines[i * lines.len() / count].split(',').collect();
        let object = (scene.objects.iter())
            .position(|o| o.name == fields[0])
            .unwrap();
        let triangle: usize = fields[1].parse().unwrap();
        let [u, v]: [f32; 2] = [2, 3].map(|k: usize| fields[k].parse().unwrap());
        let o = &scene.objects[object];
        let [a, b, c] = o.triangles[triangle].map(|v| o.positions[v as usize]);
        let weights = Vec3::new(1.0 - u - v, u, v);
        Point {
            object,
            triangle,
            weights,
            position: a * weights.x + b * weights.y + c * weights.z,
            normal: (b - a).cross(c - a).normalize(),
        }
    };
    (0..count).map(point).collect()
}

/// A normal turned by up to `slope`, evenly over that cap.
fn turned(normal: Vec3, slope: f32, seed: u32) -> Vec3 {
    let z = 1.0 - random(seed, 7) * (1.0 - slope.cos());
    let phi = TAU * random(seed, 8);
    let s = (1.0 - z * z).sqrt();
    glam::Quat::from_rotation_arc(Vec3::Z, normal) * Vec3::new(s * phi.cos(), s * phi.sin(), z)
}

/// Light and gradient of a bake at a point, on the refined mesh if there is one.
fn at(scene: &Scene, lit: &ObjectLight, point: &Point) -> (Vec3, Vec3) {
    let object = &scene.objects[point.object];
    let blend = |corners: [u32; 3], w: Vec3| {
        let of = |values: &[Vec3]| {
            let [a, b, c] = corners.map(|v| values[v as usize]);
            a * w.x + b * w.y + c * w.z
        };
        (of(&lit.light), of(&lit.gradient))
    };
    let Some(mesh) = &lit.mesh else {
        return blend(object.triangles[point.triangle], point.weights);
    };
    let positions = mesh.positions(&object.positions, &object.triangles);
    let from = point.position + point.normal;
    let found = (mesh.triangles.iter().zip(&mesh.sources))
        .filter(|(_, source)| **source as usize == point.triangle)
        .find_map(|(corners, _)| {
            let places = corners.map(|v| positions[v as usize]);
            let (weights, _) = meets(places, from, -point.normal)?;
            Some(blend(*corners, weights))
        });
    found.unwrap()
}

/// RMS errors over all points and channels, beside the mean light: for each bake that of light as it was
/// baked, and that of light that answers to the normal.
fn errors(room: &Room, slope: f32, bakes: &[&Bake]) -> Vec<[f64; 2]> {
    let points = points(room.scene, 200);
    let (mut squares, mut mean) = (vec![[0.0; 2]; bakes.len()], 0.0);
    let bumped = |i: usize| turned(points[i].normal, slope, i as u32);
    let truths: Vec<Vec3> = (0..points.len())
        .into_par_iter()
        .map(|i| room.gathered(&points[i], bumped(i), i as u32))
        .collect();
    for (i, (point, truth)) in points.iter().zip(truths).enumerate() {
        let bumped = bumped(i);
        mean += f64::from(truth.element_sum());
        for (bake, squares) in bakes.iter().zip(&mut squares) {
            let (light, gradient) = at(room.scene, &bake.objects[point.object], point);
            assert_eq!(reshade(light, gradient, point.normal, point.normal), light);
            let told = [light, reshade(light, gradient, point.normal, bumped)];
            for (square, told) in squares.iter_mut().zip(told) {
                *square += (told - truth).as_dvec3().length_squared();
            }
        }
    }
    let n = 3.0 * points.len() as f64;
    let relative = |square: f64| (square / n).sqrt() / (mean / n);
    squares.into_iter().map(|s| s.map(relative)).collect()
}

/// At slopes up to 15°, 30° and 45°, on the vertices given and on those that the light placed.
#[test]
fn the_cornell_box_answers_to_bumps() {
    let scene = load(Path::new("assets/scenes/cornell_box.glb"));
    let scene = scene.unwrap().scene;
    let baked = |refine| {
        let settings = BakeSettings {
            refine,
            directional: true,
            ..BakeSettings::BALANCED
        };
        bake(&scene.clone().validate().unwrap(), &settings, &()).unwrap()
    };
    let (given, placed) = (baked(false), baked(true));
    let room = Room::new(&scene, &given);
    let mut ratios = Vec::new();
    for degrees in [15.0_f32, 30.0, 45.0] {
        let errors = errors(&room, degrees.to_radians(), &[&given, &placed]);
        for (what, [ignored, answered]) in ["given", "placed"].iter().zip(errors) {
            let ratio = answered / ignored;
            println!("{degrees}°, vertices {what}: {ignored:.4}, {answered:.4}, ratio {ratio:.3}");
            ratios.push((degrees, what, ratio));
        }
    }
    assert!(ratios.iter().all(|r| r.2 <= 1.0 / 3.0), "{ratios:?}");
}

/// Gradients are the same bytes for any number of threads, and light is the same with and without them.
#[test]
fn nothing_depends_on_threads_and_light_not_on_gradients() {
    let file = load(Path::new("assets/scenes/cornell_box.glb")).unwrap();
    let scene = file.scene.validate().unwrap();
    let baked = |threads: usize, directional: bool| {
        let settings = BakeSettings {
            directional,
            error: 0.2,
            ..BakeSettings::DRAFT
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| bake(&scene, &settings, &()).unwrap().objects)
    };
    let (one, three, without) = (baked(1, true), baked(3, true), baked(2, false));
    let bits = |values: &[Vec3]| -> Vec<[u32; 3]> {
        values
            .iter()
            .map(|v| v.to_array().map(f32::to_bits))
            .collect()
    };
    for ((one, three), without) in one.iter().zip(&three).zip(&without) {
        assert_eq!(one.gradient.len(), one.light.len());
        assert!(one.gradient.iter().all(|g| g.is_finite()));
        assert_eq!(bits(&one.gradient), bits(&three.gradient));
        assert_eq!(bits(&one.light), bits(&without.light));
        assert!(without.gradient.is_empty());
    }
}
