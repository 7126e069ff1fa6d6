use std::collections::HashMap;

use glam::{DVec3, Quat, Vec3};
use proptest::prelude::*;

use super::shape::Shape;
use super::{ContactCuts, CutMesh, Surface, cut_at_contacts, split_at_contacts, touch};
use crate::mesh::test_meshes::{Mesh, cube, grid, random, soup, unshared};

const TOLERANCE: f32 = 0.005;

fn surface(mesh: &Mesh) -> Surface<'_> {
    Surface {
        positions: &mesh.0,
        triangles: &mesh.1,
        cut: true,
        cuts: true,
    }
}

fn split(meshes: &[&Mesh]) -> Vec<Option<CutMesh>> {
    let surfaces: Vec<Surface> = meshes.iter().map(|mesh| surface(mesh)).collect();
    let cuts = split_at_contacts(&surfaces, TOLERANCE, &|| true).expect("nobody says no");
    for (mesh, cut) in meshes.iter().zip(&cuts.meshes) {
        if let Some(cut) = cut {
            check(mesh, cut);
        }
    }
    cuts.meshes
}

/// A quad of two triangles from `corner` along `u` and `v`.
fn quad(corner: [f32; 3], u: [f32; 3], v: [f32; 3]) -> Mesh {
    let [corner, u, v] = [corner, u, v].map(Vec3::from);
    let positions = vec![corner, corner + u, corner + u + v, corner + v];
    (positions, vec![[0, 1, 2], [0, 2, 3]])
}

fn floor() -> Mesh {
    quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
}

fn moved(mesh: &Mesh, map: impl Fn(Vec3) -> Vec3) -> Mesh {
    (mesh.0.iter().map(|&p| map(p)).collect(), mesh.1.clone())
}

fn joined(meshes: &[&Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for (positions, triangles) in meshes {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

fn bits(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

fn positions(mesh: &Mesh, cut: &CutMesh) -> Vec<Vec3> {
    cut.mesh.positions(&mesh.0, &mesh.1)
}

fn normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a)
}

/// What holds for every cut mesh: the surface is what it was.
fn check(mesh: &Mesh, cut: &CutMesh) {
    let at = positions(mesh, cut);
    let refined = &cut.mesh;
    assert_eq!(cut.sides.len(), refined.vertices.len());
    assert_eq!(refined.sources.len(), refined.triangles.len());
    for point in &refined.vertices {
        let weights = point.barycentrics;
        assert!(weights.min_element() >= 0.0 && weights.max_element() <= 1.0);
        // Bisected and then cut, they may take more bits than there are.
        assert!((weights.element_sum() - 1.0).abs() <= f32::EPSILON);
    }
    let mut parts = vec![DVec3::ZERO; mesh.1.len()];
    for (corners, &source) in refined.triangles.iter().zip(&refined.sources) {
        parts[source as usize] += normal(corners.map(|v| at[v as usize]));
        for vertex in corners {
            let point = refined.vertices[*vertex as usize];
            assert!(point.barycentrics_on(source, &mesh.1).is_some());
        }
    }
    for (corners, part) in mesh.1.iter().zip(parts) {
        let corners = corners.map(|v| mesh.0[v as usize]);
        let whole = normal(corners);
        let extent = corners[0]
            .distance(corners[1])
            .max(corners[0].distance(corners[2]));
        let error = 1e-6 * (f64::from(extent) * f64::from(extent) + whole.length());
        assert!(part.distance(whole) <= error, "{part} of {whole}");
    }
    let before = boundary(&mesh.0, &mesh.1);
    let after = boundary(&at, &refined.triangles);
    assert!(
        after <= before * (1.0 + 1e-5) + 1e-5,
        "{after} instead of {before}"
    );
}

/// The length of all edges that one triangle only has, edges being told by the bits of their ends.
fn boundary(at: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let mut uses: HashMap<[[u32; 3]; 2], (u32, f64)> = HashMap::new();
    for corners in triangles {
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|v| at[v as usize]);
            let mut ends = [bits(a), bits(b)];
            ends.sort_unstable();
            let length = a.as_dvec3().distance(b.as_dvec3());
            uses.entry(ends).or_insert((0, length)).0 += 1;
        }
    }
    let single = uses.into_values().filter(|&(count, _)| count == 1);
    let mut lengths: Vec<f64> = single.map(|(_, length)| length).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.iter().sum()
}

/// How many sides there are at `point`; 0 without a vertex there.
fn sides_at(mesh: &Mesh, cut: &CutMesh, point: [f32; 3]) -> usize {
    let at = positions(mesh, cut);
    let mut sides: Vec<u32> = (at.iter().zip(&cut.sides))
        .filter(|(at, _)| at.distance(Vec3::from(point)) < 1e-4)
        .map(|(_, &side)| side)
        .collect();
    sides.sort_unstable();
    sides.dedup();
    sides.len()
}

/// Whether edges of triangles run along the whole line.
fn has_line(mesh: &Mesh, cut: &CutMesh, ends: [[f32; 3]; 2]) -> bool {
    let [a, b] = ends.map(Vec3::from);
    let at = positions(mesh, cut);
    let along = (b - a).normalize();
    let mut covered = 0.0;
    let mut seen = std::collections::HashSet::new();
    for corners in &cut.mesh.triangles {
        for k in 0..3 {
            let [p, q] = [corners[k], corners[(k + 1) % 3]].map(|v| at[v as usize]);
            let is_on = |p: Vec3| {
                let t = (p - a).dot(along);
                t > -1e-4 && t < a.distance(b) + 1e-4 && (p - a).distance(along * t) < 1e-4
            };
            let mut key = [bits(p), bits(q)];
            key.sort_unstable();
            if is_on(p) && is_on(q) && seen.insert(key) {
                covered += p.distance(q);
            }
        }
    }
    (covered - a.distance(b)).abs() < 1e-3
}

#[test]
fn a_box_stands_on_a_floor() {
    let (floor, block) = (floor(), cube());
    for lift in [0.0, 0.001] {
        let block = moved(&block, |p| p + Vec3::new(-0.3, -0.4, lift));
        let cuts = split(&[&floor, &block]);
        let cut = cuts[0].as_ref().expect("the floor is cut");
        let corners = [
            [-0.3, -0.4, 0.0],
            [0.7, -0.4, 0.0],
            [0.7, 0.6, 0.0],
            [-0.3, 0.6, 0.0],
        ];
        for k in 0..4 {
            assert!(has_line(&floor, cut, [corners[k], corners[(k + 1) % 4]]));
            assert_eq!(sides_at(&floor, cut, corners[k]), 2, "{k} at {lift}");
        }
        let on_line = positions(&floor, cut)
            .into_iter()
            .zip(&cut.sides)
            .filter(|(p, _)| p.abs().max_element() < 1.0);
        assert!(on_line.count() >= 8);
        assert_eq!(sides_at(&floor, cut, [-2.0, -2.0, 0.0]), 1);
        assert!(cuts[1].is_none());
    }
}

#[test]
fn a_box_sunk_into_a_floor_cuts_both() {
    let (floor, block) = (
        floor(),
        moved(&cube(), |p| p + Vec3::new(-0.3, -0.4, -0.25)),
    );
    let cuts = split(&[&floor, &block]);
    let corners = [
        [-0.3, -0.4, 0.0],
        [0.7, -0.4, 0.0],
        [0.7, 0.6, 0.0],
        [-0.3, 0.6, 0.0],
    ];
    for (mesh, cut) in [(&floor, &cuts[0]), (&block, &cuts[1])] {
        let cut = cut.as_ref().expect("both are cut");
        for k in 0..4 {
            assert!(has_line(mesh, cut, [corners[k], corners[(k + 1) % 4]]));
        }
        assert_eq!(sides_at(mesh, cut, corners[0]), 2);
    }
}

#[test]
fn a_wall_without_thickness_parts_a_floor() {
    let wall = quad([0.3, -2.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 1.0]);
    for (name, meshes) in [
        ("two", vec![floor(), wall.clone()]),
        ("one", vec![joined(&[&floor(), &wall])]),
    ] {
        let cuts = split(&meshes.iter().collect::<Vec<_>>());
        let cut = cuts[0].as_ref().expect("the floor is cut");
        let line = [[0.3, -2.0, 0.0], [0.3, 2.0, 0.0]];
        // The wall's own edge would count as well.
        assert!(name == "one" || has_line(&meshes[0], cut, line));
        for y in [-2.0, 2.0] {
            assert!(sides_at(&meshes[0], cut, [0.3, y, 0.0]) >= 2, "{name} {y}");
        }
    }
}

#[test]
fn the_ends_of_a_partition_are_not_parted_and_its_middle_is() {
    let (floor, wall) = (
        floor(),
        quad([0.3, -0.5, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]),
    );
    let cuts = split(&[&floor, &wall]);
    let cut = cuts[0].as_ref().expect("the floor is cut");
    let ends = [[0.3, -0.5, 0.0], [0.3, 0.4, 0.0]];
    assert!(has_line(&floor, cut, ends));
    assert_eq!(ends.map(|end| sides_at(&floor, cut, end)), [1, 1]);
    let at = positions(&floor, cut);
    let inside = |p: &Vec3| (p.x - 0.3).abs() < 1e-4 && p.y > -0.49 && p.y < 0.39;
    let on_line: Vec<Vec3> = at.into_iter().filter(inside).collect();
    assert!(!on_line.is_empty());
    for p in on_line {
        assert_eq!(sides_at(&floor, cut, p.to_array()), 2, "{p}");
    }
}

#[test]
fn what_is_apart_is_left_alone() {
    let floor = floor();
    let far = moved(&cube(), |p| p + Vec3::Z * 4.0 * TOLERANCE);
    assert_eq!(split(&[&floor, &far]), [None, None]);
    assert_eq!(split(&[&cube()]), [None]);
    assert_eq!(split(&[&grid(6, 5)]), [None]);
}

#[test]
fn what_passes_light_cuts_nothing_and_what_is_to_stay_is_not_cut() {
    let (floor, block) = (
        floor(),
        moved(&cube(), |p| p + Vec3::new(-0.3, -0.4, -0.25)),
    );
    let glass = Surface {
        cuts: false,
        ..surface(&block)
    };
    let fixed = Surface {
        cut: false,
        ..surface(&floor)
    };
    let of = |surfaces: [Surface; 2]| {
        let ContactCuts { meshes, crowded } =
            split_at_contacts(&surfaces, TOLERANCE, &|| true).expect("nobody says no");
        assert_eq!(crowded, 0);
        [meshes[0].is_some(), meshes[1].is_some()]
    };
    assert_eq!(of([surface(&floor), glass]), [false, true]);
    assert_eq!(of([fixed, surface(&block)]), [false, true]);
    assert_eq!(
        split_at_contacts(&[fixed, glass], TOLERANCE, &|| false),
        None
    );
}

/// A wall that goes round, `n` faces of it, from 0.5 below the floor to 0.5 above.
fn rough_stone(n: u32) -> Mesh {
    let point = |i: u32, z: f32| {
        let angle = i as f32 / n as f32 * std::f32::consts::TAU;
        let radius = 0.8 + 0.1 * (7.0 * angle).sin() + 0.02 * (61.0 * angle).sin();
        Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let positions = (0..n).flat_map(|i| [point(i, -0.5), point(i, 0.5)]);
    let triangles = (0..n).flat_map(|i| {
        let (a, b) = (2 * i, 2 * ((i + 1) % n));
        [[a, b, b + 1], [a, b + 1, a + 1]]
    });
    (positions.collect(), triangles.collect())
}

/// The share of a floor that is cut into pieces more than ten times as long as they are high.
fn in_needles(floor: &Mesh, cut: &CutMesh) -> f64 {
    let at = positions(floor, cut);
    let (mut all, mut needles) = (0.0, 0.0);
    for corners in &cut.mesh.triangles {
        let corners = corners.map(|v| at[v as usize]);
        let area = normal(corners).length();
        let length = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3]));
        let length = f64::from(length.fold(0.0, f32::max));
        all += area;
        if length * length > 10.0 * 2.0 * area {
            needles += area;
        }
    }
    needles / all
}

#[test]
fn many_contacts_on_a_face_make_no_needles() {
    let (floor, stone) = (floor(), rough_stone(500));
    let cuts = split(&[&floor, &stone]);
    let cut = cuts[0].as_ref().expect("the floor is cut");
    let share = in_needles(&floor, cut);
    assert!(share < 0.15, "{share}");
    // What would have come of it without bisection.
    let surfaces = [&floor, &stone].map(surface);
    let shape = Shape::new(&surfaces, TOLERANCE);
    let contacts = touch::find(&shape, &|| true).expect("nobody says no");
    let at_once = cut_at_contacts(&surfaces, &shape, contacts, &|| true).expect("nor here");
    let at_once = at_once.meshes[0].as_ref().expect("the floor is cut");
    let without = in_needles(&floor, at_once);
    assert!(without > 5.0 * share, "{without}, {share} bisected");
    // No more than the contacts ask for.
    let pieces = cut.mesh.triangles.len();
    assert!(pieces < 3000, "{pieces}");
    for i in 0..500 {
        let p = stone.0[2 * i].with_z(0.0);
        assert_eq!(sides_at(&floor, cut, p.to_array()), 2, "{i}");
    }
}

/// What shares an edge with a face that is bisected is bisected with it, or cracks would open.
#[test]
fn neighbours_of_crowded_faces_have_their_vertices() {
    let floor = floor();
    let room = [
        floor.clone(),
        quad([2.0, -2.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]),
        moved(&rough_stone(300), |p| p + Vec3::new(1.2, 0.3, 0.0)),
    ];
    let cuts = split(&room.iter().collect::<Vec<_>>());
    let on_edge = |mesh: usize| -> Vec<[u32; 3]> {
        let cut = cuts[mesh].as_ref().expect("both are bisected");
        let at = positions(&room[mesh], cut).into_iter();
        let mut on: Vec<_> = at.filter(|p| p.x == 2.0 && p.z == 0.0).map(bits).collect();
        on.sort_unstable();
        on.dedup();
        on
    };
    assert!(on_edge(0).len() > 2);
    assert_eq!(on_edge(0), on_edge(1));
}

/// Turned by odd angles nothing lies along an axis any more.
#[test]
fn turned_scenes_are_cut_alike() {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -2.2);
    let (floor, block) = (floor(), moved(&cube(), |p| p + Vec3::new(-0.3, -0.4, 0.0)));
    let straight = split(&[&floor, &block]);
    let turned = [&floor, &block].map(|mesh| moved(mesh, |p| turn * p));
    let cuts = split(&[&turned[0], &turned[1]]);
    let cut = cuts[0].as_ref().expect("the floor is cut");
    let corner = (turn * Vec3::new(0.7, 0.6, 0.0)).to_array();
    assert_eq!(sides_at(&turned[0], cut, corner), 2);
    let count = |cut: &Option<CutMesh>| cut.as_ref().map_or(0, |c| c.mesh.triangles.len());
    // The triangulation may differ where four points lie on a circle, the line may not.
    assert!(count(&cuts[0]).abs_diff(count(&straight[0])) <= 2);
}

#[test]
fn texture_seams_do_not_matter() {
    let seamed = unshared(&floor());
    let block = moved(&cube(), |p| p + Vec3::new(-0.3, -0.4, 0.0));
    let cuts = split(&[&seamed, &block]);
    let cut = cuts[0].as_ref().expect("the floor is cut");
    assert_eq!(sides_at(&seamed, cut, [0.7, 0.6, 0.0]), 2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, max_shrink_iters: 0, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever comes: the surface stays what it was, and nothing hangs.
    #[test]
    fn soups_of_triangles_keep_their_surface(seed in any::<u32>(), points in 8_u32..40) {
        let mesh = soup(points, 24, seed);
        let mut random = random(seed);
        let by = Vec3::from([0; 3].map(|_| 0.1 * random()));
        let other = moved(&mesh, |p| p + by);
        split(&[&mesh, &other]);
    }
}
