use std::collections::HashSet;

use glam::{DVec3, Vec3};

use super::light::LightKind;
use super::scene::Object;
use super::validate::{HALF_EXTENT, TriangleKey, ValidScene, usable};

/// Reflectance above this is taken for a mistake in the material, not for snow.
const BRIGHTEST: f32 = 1.0;

pub(super) fn mend_materials(scene: &mut ValidScene, notes: &mut Vec<String>) {
    for m in &mut scene.materials {
        let color = m
            .base_color
            .clamp(glam::Vec4::ZERO, glam::Vec4::splat(BRIGHTEST));
        if color != m.base_color {
            notes.push(format!(
                "material \"{}\": base colour {} lies outside 0..1 and was clamped",
                m.name, m.base_color
            ));
            m.base_color = color;
        }
        m.metallic = m.metallic.clamp(0.0, 1.0);
        if m.emissive.min_element() < 0.0 {
            notes.push(format!(
                "material \"{}\": negative emission was set to 0",
                m.name
            ));
            m.emissive = m.emissive.max(Vec3::ZERO);
        }
    }
}

pub(super) fn mend_lights(scene: &mut ValidScene, notes: &mut Vec<String>) {
    if scene.sky.min_element() < 0.0 {
        notes.push("the sky: negative radiance was set to 0".into());
        scene.sky = scene.sky.max(Vec3::ZERO);
    }
    for light in &mut scene.lights {
        if light.power.min_element() < 0.0 {
            notes.push(format!(
                "light \"{}\": negative power was set to 0",
                light.name
            ));
            light.power = light.power.max(Vec3::ZERO);
        }
        match &mut light.kind {
            LightKind::Spot { direction, .. } | LightKind::Directional { direction } => {
                *direction = direction.as_dvec3().normalize().as_vec3();
            }
            LightKind::Rect {
                direction,
                right,
                width,
                height,
                ..
            } => {
                let forward = direction.as_dvec3().normalize();
                let across = right.as_dvec3().normalize();
                let across = (across - forward * across.dot(forward)).try_normalize();
                *direction = forward.as_vec3();
                *right = across
                    .unwrap_or_else(|| forward.any_orthonormal_vector())
                    .as_vec3();
                (*width, *height) = (width.abs(), height.abs());
            }
            LightKind::Point { .. } => {}
        }
    }
}

/// Makes normals unit length; unusable ones become those of the triangles around.
pub(super) fn mend_normals(scene: &mut ValidScene, notes: &mut Vec<String>) {
    for object in &mut scene.objects {
        let mut bad = 0;
        let mut around: Option<Vec<DVec3>> = None;
        for v in 0..object.normals.len() {
            if usable(object.normals[v]) {
                object.normals[v] = object.normals[v].as_dvec3().normalize().as_vec3();
                continue;
            }
            bad += 1;
            let around = around.get_or_insert_with(|| area_weighted_normals(object));
            object.normals[v] = around[v].try_normalize().unwrap_or(DVec3::Y).as_vec3();
        }
        if bad > 0 {
            notes.push(format!(
                "object \"{}\": {bad} normals of no direction were replaced by those of the triangles around",
                object.name
            ));
        }
    }
}

fn area_weighted_normals(object: &Object) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; object.positions.len()];
    for t in &object.triangles {
        let [a, b, c] = t.map(|v| object.positions[v as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        for &v in t {
            sums[v as usize] += normal;
        }
    }
    sums
}

/// The triangles that have an area and occur once.
pub(super) fn live_triangles(scene: &ValidScene, notes: &mut Vec<String>) -> Vec<TriangleKey> {
    let mut live = Vec::new();
    let mut seen = HashSet::new();
    for (o, object) in scene.objects.iter().enumerate() {
        let (mut flat, mut twice) = (0, 0);
        for (t, corners) in object.triangles.iter().enumerate() {
            let p = corners.map(|v| object.positions[v as usize]);
            if !has_area(p) {
                flat += 1;
            } else if object.casts && !seen.insert(position_key(p)) {
                twice += 1;
            } else {
                live.push(TriangleKey {
                    object: o as u32,
                    triangle: t as u32,
                });
            }
        }
        if flat > 0 {
            notes.push(format!(
                "object \"{}\": {flat} triangles without area were left out",
                object.name
            ));
        }
        if twice > 0 {
            notes.push(format!(
                "object \"{}\": {twice} triangles that occur twice at the same place were counted once",
                object.name
            ));
        }
    }
    live
}

/// Whether a triangle's area stands above the rounding of its own corners.
fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    let double_area = (b - a).cross(c - a).length();
    // A height below 1e-7 of the scene is what the rounding of a straight line leaves.
    double_area > 1e-7 * f64::from(HALF_EXTENT) * longest.sqrt() && double_area > 1e-9 * longest
}

/// Equal for triangles of equal corners and equal winding.
fn position_key(p: [Vec3; 3]) -> [[u32; 3]; 3] {
    let bits = p.map(|v| (v + Vec3::ZERO).to_array().map(f32::to_bits));
    let first = (0..3).min_by_key(|&i| bits[i]).unwrap_or(0);
    [bits[first], bits[(first + 1) % 3], bits[(first + 2) % 3]]
}
