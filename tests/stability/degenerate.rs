//! Triangles that are hardly any, objects of nothing, quads that are not flat.

use bevy_fresco::radiosity::{BakeSettings, Element, Material, MaterialId, Object, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene, values};
use crate::solved::{
    apart, baked, differences, furthest_from_one, lights, mean, of_object, range, solved, tight,
};

/// A room with a luminous ceiling.
fn lit_room(n: u32) -> Scene {
    let walls = room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]);
    scene(walls, vec![grey(0.7, 0.0), grey(0.7, 1.0)])
}

/// A unit floor with grid lines at the given shares of its sides.
fn floor_with_lines(lines: &[f32]) -> Object {
    let n = lines.len();
    let mut floor = quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X, n as u32 - 1, 0);
    for (i, p) in floor.positions.iter_mut().enumerate() {
        *p = Vec3::new(lines[i % n], 0.0, lines[i / n]);
    }
    floor
}

/// Every eighth of a floor is followed by a strip of 10⁻⁴: cells of 1 : 1000 and, where strips
/// cross, of an area of 10⁻⁸. Their vertices carry the light that the floor has there without them,
/// and so do all others; what differs is the noise of other samples, measured by another seed, and
/// strips have few of them. No element is dark or bright by its shape.
#[test]
fn slivers() {
    let plain: Vec<f32> = (0..=8).map(|i| i as f32 / 8.0).collect();
    let mut slivered = vec![0.0];
    slivered.extend(plain[1..8].iter().flat_map(|x| [*x, *x + 1e-4]));
    slivered.push(1.0);
    let floor = |lines: &[f32], seed| {
        let mut s = lit_room(4);
        s.objects[0] = floor_with_lines(lines);
        let settings = BakeSettings {
            seed,
            refine: false,
            adapt: false,
            ..BakeSettings::FINAL
        };
        lights(&baked(s, &settings), 0)
    };
    let clean = floor(&plain, 0);
    let noise = differences(&floor(&plain, 1), &clean);
    let truth: Vec<f32> = (0..256_usize)
        .map(|k| clean[(k / 16).div_ceil(2) * 9 + (k % 16).div_ceil(2)])
        .collect();
    let found = differences(&floor(&slivered, 0), &truth);
    for (found, noise) in [(found.0, noise.0), (found.1, noise.1)] {
        assert!(found < 2.5 * noise, "{found}, noise {noise}");
    }

    let mut s = lit_room(4);
    s.objects[0] = floor_with_lines(&slivered);
    let light = solved(
        s,
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
    );
    let (low, high) = range(of_object(&light, 0));
    assert!(0.3 < low && high < 0.8, "{low}..{high}");
}

/// Triangles without area among a tenth of the others: with a corner used twice, with corners on a
/// line, with one corner alone. Elements keep their light down to the bit, vertices but for the
/// order of a sum.
#[test]
fn triangles_without_area() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    let clean = lit_room(4);
    let mut flat = clean.clone();
    for object in &mut flat.objects {
        // 0, 1 and 2 lie on a line, and so do 0, 6 and 12.
        let kinds = [[3, 3, 8], [0, 1, 2], [0, 6, 12], [7, 7, 7]];
        object.triangles.extend(kinds);
    }
    let (a, b) = (
        solved(clean.clone(), &settings),
        solved(flat.clone(), &settings),
    );
    assert_eq!(a.elements, b.elements);
    let (a, b) = (baked(clean, &settings), baked(flat, &settings));
    let (_, largest) = differences(&values(&a), &values(&b));
    assert!(largest < 1e-5, "{largest}");
    let note = "4 triangles without area were left out";
    assert_eq!(
        b.report.notes.iter().filter(|n| n.contains(note)).count(),
        6
    );
}

/// Objects of nothing beside the others (no vertices, no triangles, one vertex used thrice,
/// vertices that are not numbers in no triangle), first, among and last: the others keep the light
/// of their elements down to the bit, and that of their vertices but for the order of a sum.
#[test]
fn objects_of_nothing() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    let mut clean = lit_room(4);
    for (key, object) in (1..).zip(&mut clean.objects) {
        object.key = key;
    }
    let light = |s: &Scene| -> Vec<Vec3> {
        let irradiance = |e: &Element| e.irradiance;
        solved(s.clone(), &settings)
            .elements
            .iter()
            .map(irradiance)
            .collect()
    };
    let (elements, vertices) = (light(&clean), values(&baked(clean.clone(), &settings)));
    let nothing = |positions: &[Vec3], triangles: &[[u32; 3]]| Object {
        name: "nothing".into(),
        positions: positions.to_vec(),
        triangles: triangles.to_vec(),
        material: MaterialId(0),
        key: 99,
        ..Object::default()
    };
    for kind in [
        nothing(&[], &[]),
        nothing(&[Vec3::splat(0.5)], &[]),
        nothing(&[Vec3::splat(0.5)], &[[0, 0, 0]]),
        nothing(&[Vec3::NAN, Vec3::INFINITY, Vec3::ONE], &[]),
    ] {
        for place in [0, 3, 6] {
            let mut s = clean.clone();
            s.objects.insert(place, kind.clone());
            assert_eq!(light(&s), elements, "{kind:?} at {place}");
            let mut bake = baked(s, &settings);
            bake.objects.remove(place);
            let (_, largest) = differences(&values(&bake), &vertices);
            assert!(largest < 1e-5, "{kind:?} at {place}: {largest}");
        }
    }
}

/// The Cornell box as it was measured (Cornell University's published data), its front closed, its
/// walls cut along one diagonal or the other.
fn measured_cornell_box(cut: usize, materials: Vec<Material>) -> Scene {
    let corners = [
        [552.8, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 559.2],
        [549.6, 0.0, 559.2],
        [556.0, 548.8, 0.0],
        [0.0, 548.8, 0.0],
        [0.0, 548.8, 559.2],
        [556.0, 548.8, 559.2],
    ];
    let walls: [[usize; 4]; 6] = [
        [0, 1, 2, 3],
        [4, 7, 6, 5],
        [0, 3, 7, 4],
        [3, 2, 6, 7],
        [2, 1, 5, 6],
        [1, 0, 4, 5],
    ];
    let cuts = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]];
    let last = materials.len() as u32 - 1;
    let wall = |(i, wall): (usize, &[usize; 4])| Object {
        name: "wall".into(),
        positions: wall.map(|v| Vec3::from(corners[v])).to_vec(),
        triangles: cuts[cut].to_vec(),
        material: MaterialId(if i == 1 { last } else { 0 }),
        ..Object::default()
    };
    scene(walls.iter().enumerate().map(wall).collect(), materials)
}

/// The red wall of the Cornell box has a corner 3 units off the plane of the other three. Whichever
/// way its quads are cut, the box is closed to every ray, rays, elements and vertices have the same
/// triangles (a furnace is 1 everywhere), and the light of each wall is the same within the noise.
#[test]
fn quads_that_are_not_flat() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    let walls = [0, 1].map(|cut| {
        let furnace = measured_cornell_box(cut, vec![grey(0.8, 0.2)]);
        let light = solved(furnace.clone(), &settings);
        assert!(tight(&light, &settings));
        assert!(furthest_from_one(&light) < 1e-4);
        for v in values(&baked(furnace, &settings)) {
            assert!((v - 1.0).abs() < 1e-4, "{v}");
        }
        let lit = measured_cornell_box(cut, vec![grey(0.8, 0.0), grey(0.0, 1.0)]);
        let light = solved(lit, &settings);
        [0, 2, 3, 4, 5].map(|wall| mean(of_object(&light, wall), |e| e.irradiance.x))
    });
    for (a, b) in walls[0].iter().zip(walls[1]) {
        assert!(apart(*a, b) < 3e-3, "{a}, {b}");
    }
}
