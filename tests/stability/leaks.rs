//! Surfaces inside others, and light behind walls.

use bevy_fresco::radiosity::{BakeSettings, Element, Object, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene};
use crate::solved::{baked, lights, range, solved};

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

/// Whether a point of the floor is under a block.
fn under(p: Vec3, low: Vec3, high: Vec3) -> bool {
    p.x > low.x && p.x < high.x && p.z > low.z && p.z < high.z
}

/// A block on cells of the floor, beside a lamp: vertices along its base, and all others, carry the
/// light they carry where there is no floor under the block, within 5 %, which is twice the noise
/// of another seed.
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
        !under(middle, low, high)
    });
    let truth = lights(
        &baked(
            with_lamp(hole),
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::FINAL
            },
        ),
        0,
    );
    let bake = baked(
        with_lamp(room_with_block(low, high)),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::FINAL
        },
    );
    let vertices = corners.iter().zip(lights(&bake, 0)).zip(truth);
    for ((p, found), truth) in vertices.filter(|v| !under(*v.0.0, low, high)) {
        let ok = (found - truth).abs() <= 0.05 * truth;
        assert!(ok, "at {p}: {found}, {truth}");
    }
    assert!(bake.report.counts.invalid_samples > 0);
}

/// A block across the cells of the floor, in a furnace: light is 1 wherever it can be seen. Samples
/// under the block are left out, so that vertices around it have 1, however little of their cells
/// is free. Elements are not split along the base of the block: those across it are too dark by
/// their buried part (a matter of refinement), which lowers what the block sees of them by a tenth.
#[test]
fn block_across_the_cells_of_the_floor() {
    let (low, high) = (Vec3::new(1.4, 0.0, 1.57), Vec3::new(2.45, 1.0, 2.6));
    let s = scene(room_with_block(low, high), vec![grey(0.7, 0.3)]);
    let shape = s.objects[0].clone();
    let bake = baked(
        s.clone(),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
    );
    let vertices = shape.positions.iter().zip(lights(&bake, 0));
    for (p, light) in vertices.filter(|v| !under(*v.0, low, high)) {
        assert!((light - 1.0).abs() < 0.02, "at {p}: {light}");
    }
    let light = solved(
        s,
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
    );
    let free = |e: &&Element| !(under(e.center, low - 0.1, high + 0.1) && e.center.y == 0.0);
    let (dark, bright) = range(light.elements.iter().filter(free));
    assert!(dark > 0.88 && bright < 1.0 + 1e-4, "{dark}..{bright}");
}

/// Two rooms side by side, the ceiling of the left one luminous, and one floor under both with rows
/// of vertices at `lines`.
fn two_rooms(thickness: f32, lines: &[f32]) -> Scene {
    let mut floor = quad(
        "floor",
        Vec3::ZERO,
        Vec3::X,
        Vec3::Z,
        lines.len() as u32 - 1,
        0,
    );
    let n = lines.len();
    for (i, p) in floor.positions.iter_mut().enumerate() {
        p.x = lines[i / n];
        floor.normals[i] = Vec3::Y;
    }
    floor.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let far = Vec3::X * (1.0 + thickness);
    let mut dark = room(Vec3::ONE, 4, [0; 6]);
    dark.iter_mut()
        .flat_map(|o| &mut o.positions)
        .for_each(|p| *p += far);
    let mut objects = vec![floor];
    objects.extend(room(Vec3::ONE, 4, [0, 1, 0, 0, 0, 0]).into_iter().skip(1));
    objects.extend(dark.into_iter().skip(1));
    scene(objects, vec![grey(0.7, 0.0), grey(0.5, 1.0)])
}

/// Light behind a wall, of one sheet for each room, that stands on one floor: in the dark room there
/// is none, where the mesh of the floor has edges along the wall. Not one ray of an element there
/// finds a bright one; what the solver leaves is far below its tolerance.
///
/// Left for refinement by light: at thickness 0 the row of vertices under the wall belongs to both
/// rooms and carries light of both, which shows in the dark room across one cell; and a floor
/// without edges along the wall does so across the cells under it.
#[test]
fn light_leak_through_thin_wall() {
    let settings = BakeSettings {
        solver_tolerance: 1e-5,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    for thickness in [0.0, 0.01, 0.1] {
        let mut lines: Vec<f32> = (0..=4).map(|i| i as f32 / 4.0).collect();
        let beyond = (0..=4).map(|i| 1.0 + thickness + i as f32 / 4.0);
        lines.extend(beyond.skip(usize::from(thickness == 0.0)));
        let s = two_rooms(thickness, &lines);
        let shapes = s.objects.clone();

        let light = solved(s.clone(), &settings);
        let (_, bright) = range(light.elements.iter());
        let dark = |e: &Element| e.center.x > 1.0 + thickness || e.object.0 >= 6;
        for (i, e) in light.elements.iter().enumerate().filter(|e| dark(e.1)) {
            assert_eq!(e.direct, Vec3::ZERO, "{thickness}: {e:?}");
            assert!(e.irradiance.x <= 1e-5 * bright, "{thickness}: {e:?}");
            let row = light.row(i).into_iter().zip(&light.elements);
            let found: f64 = row.filter(|r| !dark(r.1)).map(|r| r.0).sum();
            assert_eq!(found, 0.0, "{thickness}: {e:?}");
        }

        let bake = baked(s, &settings);
        for (o, shape) in shapes.iter().enumerate() {
            let vertices = shape.positions.iter().zip(lights(&bake, o));
            let dark = |p: &Vec3| p.x > 1.0 + 0.5 * thickness || o >= 6;
            for (p, v) in vertices.filter(|v| dark(v.0)) {
                assert!(v <= 1e-4 * bright, "{thickness}: {v} at {p}");
            }
        }
    }
}
