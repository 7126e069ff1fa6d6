//! Meshes of known shapes, and form factors summed over their elements.

use bevy_fresco::radiosity::{
    BakeSettings, ElementLight, FormFactors, Material, Object, ObjectId, Scene, solve_elements,
};
use glam::Vec3;

use crate::common::{grey, quad, scene};

/// A disk about the y axis at height `y`, facing up or down: a polygon of the same area.
pub(crate) fn disk(radius: f32, y: f32, up: bool, corners: u32) -> Object {
    let turn = std::f32::consts::TAU / corners as f32;
    // A triangle of the fan is as large as its sector.
    let reach = radius * (turn / turn.sin()).sqrt();
    let mut object = Object {
        name: "disk".into(),
        positions: vec![Vec3::Y * y],
        ..Object::default()
    };
    for i in 0..corners {
        let (sin, cos) = (turn * i as f32).sin_cos();
        object
            .positions
            .push(Vec3::new(cos * reach, y, sin * reach));
        let (a, b) = (1 + i, 1 + (i + 1) % corners);
        object
            .triangles
            .push(if up { [0, b, a] } else { [0, a, b] });
    }
    object
}

/// A convex body about the origin, given as seen from inside, seen from outside, of another size.
pub(crate) fn inside_out(mut object: Object, scale: f32) -> Object {
    object.positions.iter_mut().for_each(|p| *p *= scale);
    object.normals.iter_mut().for_each(|n| *n = -*n);
    object.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    object
}

/// Two opposed unit squares `gap` apart, and a square `blocker` × `blocker` midway, if any.
pub(crate) fn squares(gap: f32, blocker: Option<[f64; 2]>) -> Scene {
    let mut objects = vec![
        quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X, 1, 0),
        quad("ceiling", Vec3::Y * gap, Vec3::X, Vec3::Z, 1, 0),
    ];
    if let Some([low, high]) = blocker.map(|b| b.map(|x| x as f32)) {
        let (corner, side) = (Vec3::new(low, 0.5 * gap, low), high - low);
        objects.push(quad(
            "blocker",
            corner,
            Vec3::Z * side,
            Vec3::X * side,
            1,
            0,
        ));
    }
    scene(objects, vec![grey(0.5, 1.0)])
}

/// Two materials of known reflectance and emission.
pub(crate) fn greys(reflectance: [f64; 2], emission: [f64; 2]) -> Vec<Material> {
    [0, 1]
        .map(|i| grey(reflectance[i] as f32, emission[i] as f32))
        .into()
}

/// One element a triangle where triangles have the area `area`.
pub(crate) fn settings(scene: &Scene, area: f64, form_factors: FormFactors) -> BakeSettings {
    let triangles = scene.objects.iter().flat_map(|o| {
        o.triangles
            .iter()
            .map(|t| t.map(|v| o.positions[v as usize].as_dvec3()))
    });
    let total: f64 = triangles
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum();
    BakeSettings {
        elements: (total / area).round() as u32,
        form_factors,
        // All light by form factors.
        sample_emitters: false,
        solver_tolerance: 1e-7,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    }
}

pub(crate) fn solved(scene: Scene, settings: &BakeSettings) -> ElementLight {
    solve_elements(&scene.validate().unwrap(), settings, &()).unwrap()
}

/// Area-weighted mean of a value over the elements of an object.
pub(crate) fn mean(light: &ElementLight, object: u32, value: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (i, e) in light.elements.iter().enumerate() {
        if e.object == ObjectId(object) {
            sum += f64::from(e.area) * value(i);
            area += f64::from(e.area);
        }
    }
    sum / area
}

/// The form factor from one object to another.
pub(crate) fn between(light: &ElementLight, from: u32, to: u32) -> f64 {
    mean(light, from, |i| {
        let row = light.row(i).into_iter().zip(&light.elements);
        let onto = row.filter(|(_, e)| e.object == ObjectId(to));
        onto.map(|(f, _)| f).sum()
    })
}
