//! Scenes with known answers, built in code.

#![allow(dead_code, reason = "each test binary uses some of these")]

use bevy_fresco::radiosity::{Bake, Material, MaterialId, Object, Scene};
use glam::{Vec3, Vec4};

/// A grey diffuse material.
pub(crate) fn grey(reflectance: f32, emission: f32) -> Material {
    Material {
        name: format!("grey {reflectance}"),
        base_color: Vec4::new(reflectance, reflectance, reflectance, 1.0),
        emissive: Vec3::splat(emission),
        ..Material::default()
    }
}

/// The quad `a`, `a + u`, `a + u + v`, `a + v` in `n × n` cells, facing `u × v`.
pub(crate) fn quad(name: &str, a: Vec3, u: Vec3, v: Vec3, n: u32, material: u32) -> Object {
    let mut object = Object {
        name: name.into(),
        material: MaterialId(material),
        ..Object::default()
    };
    for i in 0..=n {
        for j in 0..=n {
            object
                .positions
                .push(a + u * (i as f32 / n as f32) + v * (j as f32 / n as f32));
            object.normals.push(u.cross(v).normalize());
        }
    }
    for i in 0..n {
        for j in 0..n {
            let k = i * (n + 1) + j;
            object.triangles.push([k, k + n + 1, k + n + 2]);
            object.triangles.push([k, k + n + 2, k + 1]);
        }
    }
    object
}

/// The six walls of a box with a corner at the origin, facing inwards: floor, ceiling, then the
/// walls at low x, high x, low z, high z. One material each.
pub(crate) fn room(size: Vec3, n: u32, materials: [u32; 6]) -> Vec<Object> {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let [floor, ceiling, low_x, high_x, low_z, high_z] = materials;
    vec![
        quad("floor", Vec3::ZERO, z, x, n, floor),
        quad("ceiling", y, x, z, n, ceiling),
        quad("low x", Vec3::ZERO, y, z, n, low_x),
        quad("high x", x, z, y, n, high_x),
        quad("low z", Vec3::ZERO, x, y, n, low_z),
        quad("high z", z, y, x, n, high_z),
    ]
}

/// Five faces of a block that stands on the floor, its lowest corner at `low`.
pub(crate) fn block(low: Vec3, size: Vec3, n: u32, material: u32) -> Vec<Object> {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    vec![
        quad("top", low + y, z, x, n, material),
        quad("left", low, z, y, n, material),
        quad("right", low + x, y, z, n, material),
        quad("front", low, y, x, n, material),
        quad("back", low + z, x, y, n, material),
    ]
}

/// The unit sphere seen from inside: an octahedron's faces cut into `n²`, moved onto the sphere.
pub(crate) fn inward_sphere(n: u32, material: u32) -> Object {
    let mut object = Object {
        name: "sphere".into(),
        material: MaterialId(material),
        ..Object::default()
    };
    for sign in 0..8 {
        let s = |bit: u32| if sign & (1 << bit) == 0 { 1.0 } else { -1.0 };
        let corners = [Vec3::X * s(0), Vec3::Y * s(1), Vec3::Z * s(2)];
        let base = object.positions.len() as u32;
        let index = |i: u32, j: u32| base + i * (2 * n + 3 - i) / 2 + j;
        for i in 0..=n {
            for j in 0..=n - i {
                let (b, c) = (i as f32 / n as f32, j as f32 / n as f32);
                let p = corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c;
                object.positions.push(p.normalize());
                object.normals.push(-p.normalize());
            }
        }
        let inward = s(0) * s(1) * s(2) < 0.0;
        let mut push = |t: [u32; 3]| {
            object
                .triangles
                .push(if inward { t } else { [t[0], t[2], t[1]] });
        };
        for i in 0..n {
            for j in 0..n - i {
                push([index(i, j), index(i + 1, j), index(i, j + 1)]);
                if j + 1 < n - i {
                    push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
                }
            }
        }
    }
    object
}

/// All vertex light of a bake, one channel.
pub(crate) fn values(bake: &Bake) -> Vec<f32> {
    bake.objects
        .iter()
        .flat_map(|o| o.light.iter().map(|l| l.x))
        .collect()
}

/// Area-weighted mean of an object's vertex light, one channel.
pub(crate) fn mean_over(object: &Object, light: &[Vec3]) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for t in &object.triangles {
        let [a, b, c] = t.map(|v| object.positions[v as usize].as_dvec3());
        let area = (b - a).cross(c - a).length();
        let mean = t
            .iter()
            .map(|&v| f64::from(light[v as usize].x))
            .sum::<f64>()
            / 3.0;
        sum += area * mean;
        total += area;
    }
    sum / total
}

/// A scene of objects and materials, nothing else.
pub(crate) fn scene(objects: Vec<Object>, materials: Vec<Material>) -> Scene {
    Scene {
        objects,
        materials,
        ..Scene::default()
    }
}
