//! Surfaces inside others, and light behind walls.

use bevy_fresco::radiosity::{BakeSettings, Object, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene, values};
use crate::solved::{apart, baked, of_object, solved};

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

fn with_block(low: Vec3, high: Vec3, hole: bool, emission: f32, reflectance: f32, lamp: f32) -> Scene {
    let mut objects = room(Vec3::new(4.0, 3.0, 4.0), 16, [0; 6]);
    if hole {
        let floor = &mut objects[0];
        let p = floor.positions.clone();
        floor.triangles.retain(|t| {
            let c = t.iter().map(|&v| p[v as usize]).sum::<Vec3>() / 3.0;
            !(c.x > low.x && c.x < high.x && c.z > low.z && c.z < high.z)
        });
    }
    objects.extend(block(low, high));
    objects.push(quad("lamp", Vec3::new(0.7, 2.9, 1.0), Vec3::X * 0.8, Vec3::Z * 0.8, 1, 1));
    scene(objects, vec![grey(reflectance, emission), grey(reflectance, lamp)])
}

#[test]
fn floor_under_a_block() {
    let (low, high) = (Vec3::new(1.5, 0.0, 1.5), Vec3::new(2.5, 1.0, 2.5));
    let at = |hole, seed| {
        let settings = BakeSettings { seed, ..BakeSettings::FINAL };
        let b = baked(with_block(low, high, hole, 0.0, 0.7, 5.0), &settings);
        eprintln!("{:?} {:?}", b.report.counts.invalid_samples, b.report.notes);
        b.objects[0].light.iter().map(|l| l.x).collect::<Vec<_>>()
    };
    let (truth, truth2, found) = (at(true, 0), at(true, 1), at(false, 0));
    for i in 4..=12 {
        for j in 4..=12 {
            let k = i * 17 + j;
            if truth[k] > 0.0 {
                let (a, b) = (apart(found[k].into(), truth[k].into()), apart(truth2[k].into(), truth[k].into()));
                if a > 0.03 { eprintln!("vertex {i} {j}: {} for {} ({a:.3}, noise {b:.3})", found[k], truth[k]); }
            }
        }
    }
    let worst = (0..17 * 17).filter(|&k| truth[k] > 0.0).map(|k| apart(found[k].into(), truth[k].into())).fold(0.0, f64::max);
    let noise = (0..17 * 17).filter(|&k| truth[k] > 0.0).map(|k| apart(truth2[k].into(), truth[k].into())).fold(0.0, f64::max);
    eprintln!("aligned worst {worst} noise {noise}");
}

#[test]
fn block_across_the_cells_of_the_floor() {
    let (low, high) = (Vec3::new(1.4, 0.0, 1.57), Vec3::new(2.45, 1.0, 2.6));
    let b = baked(with_block(low, high, false, 0.3, 0.7, 0.3), &BakeSettings::BALANCED);
    let lo = b.objects.iter().map(|o| o.light.iter().map(|l| l.x).fold(f32::MAX, f32::min)).collect::<Vec<_>>();
    eprintln!("straddling: lowest vertex by object {lo:?}; invalid {} of {}, filled {}", b.report.counts.invalid_samples, b.report.counts.samples, b.report.counts.filled_vertices);
    let e = solved(with_block(low, high, false, 0.3, 0.7, 0.3), &BakeSettings::BALANCED);
    let lo = (0..12).map(|o| of_object(&e, o).map(|e| e.irradiance.x).fold(f32::MAX, f32::min)).collect::<Vec<_>>();
    eprintln!("elements lowest {lo:?}");
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
    for thickness in [0.0, 0.01, 0.1] {
        let mut lines: Vec<f32> = (0..=4).map(|i| i as f32 / 4.0).collect();
        let dark = (0..=4).map(|i| 1.0 + thickness + i as f32 / 4.0);
        lines.extend(dark.skip(usize::from(thickness == 0.0)));
        let e = solved(two_rooms(thickness, &lines), &BakeSettings::BALANCED);
        let bright = e.elements.iter().map(|e| e.irradiance.x).fold(0.0, f32::max);
        let worst = e.elements.iter().filter(|e| e.center.x > 1.0 + thickness).map(|e| e.irradiance.x).fold(0.0, f32::max);
        eprintln!("thickness {thickness}: elements {} of {bright}", worst);
        let s = two_rooms(thickness, &lines);
        let shapes = s.objects.clone();
        let b = baked(s, &BakeSettings::BALANCED);
        let mut by_x = std::collections::BTreeMap::new();
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
    let _ = values;
}
