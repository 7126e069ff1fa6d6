//! Triangles that are hardly any, and quads that are not flat.

use bevy_fresco::radiosity::{BakeSettings, MaterialId, Object, Scene, bake};
use glam::Vec3;

use crate::common::{grey, quad, room, scene, values};
use crate::solved::{apart, baked, differences, solved};

fn lit_room(n: u32) -> Scene {
    scene(
        room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]),
        vec![grey(0.7, 0.0), grey(0.7, 1.0)],
    )
}

/// A floor like `quad`'s with grid lines at the given shares of its sides.
fn floor_with_lines(lines: &[f32]) -> Object {
    let n = lines.len() as u32 - 1;
    let mut floor = quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X, n, 0);
    for (i, z) in lines.iter().enumerate() {
        for (j, x) in lines.iter().enumerate() {
            floor.positions[i * lines.len() + j] = Vec3::new(*x, 0.0, *z);
        }
    }
    floor
}

/// Every eighth of a floor followed by a strip of 10⁻⁴: cells of 1 : 1000 and, where strips
/// cross, of 10⁻⁸. Their vertices carry the light of their neighbours, and the rest what it
/// carries without them.
#[test]
fn slivers() {
    let plain: Vec<f32> = (0..=8).map(|i| i as f32 / 8.0).collect();
    let mut slivered = vec![0.0];
    for x in &plain[1..8] {
        slivered.extend([*x, *x + 1e-4]);
    }
    slivered.push(1.0);
    let settings = BakeSettings::BALANCED;
    let with = |lines: &[f32]| {
        let mut s = lit_room(8);
        s.objects[0] = floor_with_lines(lines);
        let count = solved(s.clone(), &settings).elements.len();
        (baked(s, &settings), count)
    };
    let (clean, _) = with(&plain);
    let (found, n) = with(&slivered);
    let mut sliver = Vec::new();
    let mut truth = Vec::new();
    for i in 0..16 {
        for j in 0..16 {
            sliver.push(found.objects[0].light[i * 16 + j].x);
            let at = |k: usize| (k + 1) / 2;
            truth.push(clean.objects[0].light[at(i) * 9 + at(j)].x);
        }
    }
    eprintln!("slivers floor {:?} elements {n}", differences(&sliver, &truth));
    let rest = |b: &bevy_fresco::radiosity::Bake| b.objects[1..].iter().flat_map(|o| o.light.iter().map(|l| l.x)).collect::<Vec<_>>();
    eprintln!("rest {:?}", differences(&rest(&found), &rest(&clean)));
    // Elements
    let mut s = lit_room(8);
    s.objects[0] = floor_with_lines(&slivered);
    let e = solved(s, &settings);
    let (lo, hi, a) = e.elements.iter().filter(|e| e.object.0 == 0).fold((f32::MAX, 0.0_f32, f32::MAX), |x, e| (x.0.min(e.irradiance.x), x.1.max(e.irradiance.x), x.2.min(e.area)));
    eprintln!("elements {lo} {hi} smallest {a}");
}

/// Triangles without area, with corners that coincide or lie on a line, with corners in one place
/// as bits but not as numbers (0 and −0), and normals of no direction: nothing else changes, down
/// to the bit.
#[test]
fn triangles_without_area() {
    let settings = BakeSettings::DRAFT;
    let clean = values(&baked(lit_room(4), &settings));
    let mut s = lit_room(4);
    for object in &mut s.objects {
        let count = object.triangles.len();
        let n = object.positions.len() as u32;
        let [a, b] = [object.positions[0], object.positions[6]];
        object.positions.extend([a, a.lerp(b, 0.5), -a * 0.0]);
        object.normals.extend([Vec3::ZERO, Vec3::NAN, Vec3::INFINITY]);
        for i in 0..count as u32 / 10 {
            let corner = object.triangles[i as usize][0];
            object.triangles.extend([
                [corner, corner, n],
                [0, 6, n + 1],
                [n, n, n],
                [0, n, n + 2],
            ]);
        }
    }
    let shapes = lit_room(4).objects;
    let with = baked(s, &settings);
    let light: Vec<f32> = with.objects.iter().zip(&shapes).flat_map(|(o, shape)| o.light[..shape.positions.len()].iter().map(|l| l.x)).collect();
    eprintln!("bits {:?} {}", differences(&light, &clean), light == clean);
    eprintln!("{:?}", with.report.notes);
    assert!(values(&with).iter().all(|v| v.is_finite()));
}

/// Objects of nothing beside the others (no vertices, no triangles, one vertex used thrice,
/// vertices in no triangle that are not numbers): all others keep their light down to the bit.
#[test]
fn objects_of_nothing() {
    let mut keyed = lit_room(4);
    for (k, object) in keyed.objects.iter_mut().enumerate() {
        object.key = k as u64 + 1;
    }
    let clean = values(&baked(keyed.clone(), &BakeSettings::DRAFT));
    let nothing = |positions: Vec<Vec3>, triangles: Vec<[u32; 3]>| Object {
        name: "nothing".into(),
        positions,
        triangles,
        material: MaterialId(0),
        key: 99,
        ..Object::default()
    };
    let kinds = [
        nothing(Vec::new(), Vec::new()),
        nothing(vec![Vec3::splat(0.5)], Vec::new()),
        nothing(vec![Vec3::splat(0.5)], vec![[0, 0, 0]]),
        nothing(vec![Vec3::NAN, Vec3::INFINITY, Vec3::ONE], Vec::new()),
    ];
    for (k, kind) in kinds.into_iter().enumerate() {
        for place in [0, 3, 6] {
            let mut s = keyed.clone();
            s.objects.insert(place, kind.clone());
            let mut with = baked(s, &BakeSettings::DRAFT);
            with.objects.remove(place);
            assert_eq!(values(&with), clean, "kind {k} at {place}");
        }
    }
}

/// The Cornell box as it was measured, with its front closed: the red wall, and the walls beside
/// it, have a corner up to 3 units off the plane of the other three. Whichever way they are cut,
/// the box is closed: no ray gets out, and light of uniform emission is E / (1 − ρ).
#[test]
fn quads_that_are_not_flat() {
    let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let corners = [
        p(552.8, 0.0, 0.0),
        p(0.0, 0.0, 0.0),
        p(0.0, 0.0, 559.2),
        p(549.6, 0.0, 559.2),
        p(556.0, 548.8, 0.0),
        p(0.0, 548.8, 0.0),
        p(0.0, 548.8, 559.2),
        p(556.0, 548.8, 559.2),
    ];
    let walls = [[0_u32, 1, 2, 3], [4, 7, 6, 5], [0, 3, 7, 4], [3, 2, 6, 7], [2, 1, 5, 6], [1, 0, 4, 5]];
    let mut means = Vec::new();
    for cut in [0, 1] {
        let wall = |w: &[u32; 4]| {
            let q: Vec<Vec3> = w.iter().map(|&v| corners[v as usize]).collect();
            Object {
                name: "wall".into(),
                positions: q,
                triangles: if cut == 0 { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 1, 3], [1, 2, 3]] },
                ..Object::default()
            }
        };
        let s = scene(walls.iter().map(wall).collect(), vec![grey(0.8, 1.0)]);
        let e = solved(s.clone(), &BakeSettings::BALANCED);
        let leaks = (0..e.elements.len()).filter(|&i| e.row_sum(i) < 1.0).count();
        let worst = e.elements.iter().map(|e| apart(e.radiosity.x.into(), 5.0)).fold(0.0, f64::max);
        let area: f64 = e.elements.iter().map(|e| f64::from(e.area)).sum();
        eprintln!("cut {cut}: leaks {leaks} of {} worst {worst} area {area}", e.elements.len());
        // facing
        let b = baked(s, &BakeSettings::BALANCED);
        let worst = values(&b).iter().map(|&v| apart(v.into(), 5.0)).fold(0.0, f64::max);
        eprintln!("vertices {worst}");
        let mut s = scene(walls.iter().map(wall).collect(), vec![grey(0.8, 0.0), grey(0.0, 1.0)]);
        s.objects[1].material = MaterialId(1);
        let e = solved(s, &BakeSettings::FINAL);
        means.push((0..6).map(|o| crate::solved::mean(crate::solved::of_object(&e, o), |e| e.irradiance.x)).collect::<Vec<_>>());
    }
    eprintln!("{means:?}");
    let _ = bake;
}
