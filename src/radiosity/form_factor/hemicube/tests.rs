//! Hemicubes against exact form factors and against rays.

use glam::{DVec3, Vec3};

use super::*;
use crate::radiosity::element::Elements;
use crate::radiosity::emitter::Emitters;
use crate::radiosity::emitter_tree::EmitterTree;
use crate::radiosity::occlusion::{Hierarchy, Holds, Occluders};
use crate::radiosity::bvh::BvhQuality;
use crate::radiosity::sampling::unit_float;
use crate::radiosity::scene::{Material, Object, Scene};
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::surface::{Pyramids, Surfaces};

/// Looks at a scene under a white sky.
fn look<T>(scene: &Scene, settings: &BakeSettings, at: impl FnOnce(View) -> T) -> T {
    let mut scene = scene.clone();
    scene.sky = Vec3::ONE;
    let scene = scene.validate().expect("the scene is sound");
    let pyramids = Pyramids::new(&scene, None);
    let surfaces = Surfaces::new(&scene, &pyramids);
    let target = Elements::target(&scene, settings.elements);
    let elements = Elements::new(&scene, &surfaces, target, settings.max_reflectance);
    let hierarchy = Hierarchy::new(&scene, &surfaces, Holds::Casting, BvhQuality::Best);
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let tree = EmitterTree::new(&scene, &elements, &occluders, settings, &())
        .expect("nobody cancels");
    at(View {
        scene: &scene,
        occluders,
        elements: &elements,
        emitters: Emitters::at_elements(&tree, settings),
        marks: &vec![false; elements.len()],
        settings,
        remember: false,
    })
}

fn settings(elements: u32, seed: u32) -> BakeSettings {
    BakeSettings {
        elements,
        seed,
        ..BakeSettings::BALANCED
    }
}

/// The quad `a`, `a + u`, `a + u + v`, `a + v`, facing `u × v`.
fn quad(a: Vec3, u: Vec3, v: Vec3) -> Object {
    Object {
        positions: vec![a, a + u, a + u + v, a + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Object::default()
    }
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene {
        objects,
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

/// Pseudo-random numbers in 0..1, one after the other.
struct Dice(u32);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 += 1;
        unit_float(hash(self.0, 0xD1CE))
    }

    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.roll() - 1.0, std::f32::consts::TAU * self.roll());
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// The form factor from a point to a polygon above its horizon, by Lambert's formula.
fn point_to_polygon(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = corners.iter().map(|&c| c - point).collect();
    let above = clipped(&seen, normal);
    let edge = |i: usize| {
        let (a, b) = (above[i], above[(i + 1) % above.len()]);
        let cross = a.cross(b);
        let angle = cross.length().atan2(a.dot(b));
        angle * normal.dot(cross.normalize_or_zero())
    };
    let sum: f64 = (0..above.len()).map(edge).sum();
    sum.abs() / std::f64::consts::TAU
}

/// What of a polygon is above the horizon.
fn clipped(corners: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut above = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (high_a, high_b) = (normal.dot(a), normal.dot(b));
        if high_a >= 0.0 {
            above.push(a);
        }
        if high_a * high_b < 0.0 {
            above.push(a + (b - a) * (high_a / (high_a - high_b)));
        }
    }
    above
}

/// A square of about the form factor `wanted` in a random place over a small one at the origin, and
/// the small one.
fn random_square(wanted: f32, dice: &mut Dice) -> Scene {
    loop {
        let (place, normal) = (dice.direction(), dice.direction());
        let facing = -normal.dot(place);
        if place.y < 0.2 || facing < 0.2 {
            continue;
        }
        let size = (wanted * std::f32::consts::PI / (place.y * facing)).sqrt();
        let u = normal.any_orthonormal_vector() * size;
        let v = normal.cross(u);
        let corner = place - 0.5 * (u + v);
        // Wholly above the horizon, and not upon the small one.
        if [corner, corner + u, corner + v, corner + u + v].iter().any(|c| c.y < 0.02) {
            continue;
        }
        let (x, z) = (Vec3::X * 1e-3, Vec3::Z * 1e-3);
        let floor = quad(-0.5 * (x + z), z, x);
        return scene(vec![floor, quad(corner, u, v)]);
    }
}

/// Relative error of the form factor to the square, and how many squares were missed.
fn errors(wanted: f32, resolution: u32) -> (f64, f64, u32) {
    let mut dice = Dice(wanted.to_bits());
    let (mut squares, mut worst, mut missed) = (0.0, 0.0_f64, 0);
    for i in 0..60 {
        let scene = random_square(wanted, &mut dice);
        let (found, exact) = look(&scene, &settings(2, i), |view| {
            let cube = Hemicube::new(view, resolution);
            let row = cube.point_row(0, &mut cube.buffers());
            let of_square = view.elements.of_object(1);
            let found = row.entries.iter().filter(|e| of_square.contains(&(e.0 as usize)));
            let (position, normal) = Eye::new(&view, ElementId(0)).place();
            let positions = &view.scene.objects[1].positions;
            let corners: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
            let exact = point_to_polygon(position.as_dvec3(), normal.as_dvec3(), &corners);
            (found.map(|e| f64::from(e.1)).sum::<f64>(), exact)
        });
        let error = found / exact - 1.0;
        squares += error * error / 60.0;
        worst = worst.max(error.abs());
        missed += u32::from(found == 0.0);
    }
    (squares.sqrt(), worst, missed)
}

#[test]
fn table() {
    for resolution in [32, 64, 128, 256, 512] {
        let row: Vec<String> = [0.2, 0.02, 2e-3, 2e-4, 2e-5]
            .iter()
            .map(|&f| {
                let (rms, worst, missed) = errors(f, resolution);
                format!("{:.3}/{:.2}% ({missed})", 100.0 * rms, 100.0 * worst)
            })
            .collect();
        eprintln!("{resolution}: {}", row.join("  "));
    }
}
