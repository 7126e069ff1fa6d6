use std::collections::HashMap;

use super::*;
use crate::mesh::test_meshes::{Mesh, cube, grid, random, soup, unshared};

type Key = [[u32; 3]; 2];

/// An edge as the positions of its ends, in either direction.
fn key(a: Vec3, b: Vec3) -> Key {
    let mut ends = [a, b].map(|p| (p + Vec3::ZERO).to_array().map(f32::to_bits));
    ends.sort_unstable();
    ends
}

fn split(mesh: &Mesh, max_edge: f32) -> RefinedMesh {
    split_long_edges(&mesh.0, &mesh.1, max_edge, 1_000_000).expect("a small mesh")
}

/// The corners of the triangles of the refined mesh, and how they lie on their sources.
fn pieces(mesh: &Mesh, refined: &RefinedMesh) -> Vec<(u32, [Vec3; 3], [Vec3; 3])> {
    let positions = refined.positions(&mesh.0, &mesh.1);
    let piece = |(corners, &source): (&[u32; 3], &u32)| {
        let on_source = corners.map(|vertex| {
            let point = refined.vertices[vertex as usize];
            point
                .barycentrics_on(source, &mesh.1)
                .expect("corners lie on their source triangle")
        });
        (source, corners.map(|v| positions[v as usize]), on_source)
    };
    refined
        .triangles
        .iter()
        .zip(&refined.sources)
        .map(piece)
        .collect()
}

/// Every piece of a source edge has to appear once for each source triangle at that edge, and
/// every edge inside a source triangle twice.
fn assert_no_t_junctions(mesh: &Mesh, max_edge: f32) {
    let refined = split(mesh, max_edge);
    let mut expected: HashMap<Key, usize> = HashMap::new();
    for corners in &mesh.1 {
        let p = corners.map(|v| mesh.0[v as usize]);
        for i in 0..3 {
            *expected.entry(key(p[i], p[(i + 1) % 3])).or_default() += 1;
        }
    }
    let mut found: HashMap<Key, (usize, usize)> = HashMap::new();
    for (source, p, weights) in pieces(mesh, &refined) {
        let ends = mesh.1[source as usize].map(|v| mesh.0[v as usize]);
        for i in 0..3 {
            let j = (i + 1) % 3;
            let opposite = (0..3).find(|&k| weights[i][k] == 0.0 && weights[j][k] == 0.0);
            let count =
                opposite.map_or(2, |k| expected[&key(ends[(k + 1) % 3], ends[(k + 2) % 3])]);
            let entry = found.entry(key(p[i], p[j])).or_insert((0, count));
            entry.0 += 1;
            assert_eq!(entry.1, count);
        }
    }
    assert!(found.len() > expected.len(), "nothing was split");
    for (edge, (count, expected)) in found {
        assert_eq!(count, expected, "{:?}", edge.map(|p| p.map(f32::from_bits)));
    }
}

fn area(corners: [Vec3; 3]) -> glam::DVec3 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    0.5 * (b - a).cross(c - a)
}

/// In radians.
fn min_angle(corners: [Vec3; 3]) -> f64 {
    let p = corners.map(|corner| corner.as_dvec3());
    (0..3)
        .map(|i| (p[(i + 1) % 3] - p[i]).angle_between(p[(i + 2) % 3] - p[i]))
        .fold(f64::INFINITY, f64::min)
}

/// Two quads that have two positions in common and no vertex, the second told from elsewhere.
fn abutting_quads() -> Mesh {
    let quad = |from: f32, to: f32| [[from, 0.0], [to, 0.0], [to, 1.7], [from, 1.7]];
    let positions = [quad(0.1, 1.3), quad(1.3, 4.9)]
        .as_flattened()
        .iter()
        .map(|[x, y]| Vec3::new(*x, *y, x * 0.3))
        .collect();
    (positions, vec![[0, 1, 2], [0, 2, 3], [5, 6, 4], [7, 4, 6]])
}

fn samples() -> Vec<Mesh> {
    vec![
        grid(5, 3),
        abutting_quads(),
        cube(),
        unshared(&cube()),
        soup(9, 40, 1),
        unshared(&soup(12, 60, 2)),
    ]
}

#[test]
fn triangles_agree_on_common_edges() {
    for mesh in samples() {
        for max_edge in [0.9, 0.37, 0.11] {
            assert_no_t_junctions(&mesh, max_edge);
        }
    }
}

#[test]
fn no_edge_is_longer_than_allowed() {
    for mesh in samples() {
        for (_, p, _) in pieces(&mesh, &split(&mesh, 0.2)) {
            for i in 0..3 {
                assert!(p[i].as_dvec3().distance(p[(i + 1) % 3].as_dvec3()) <= 0.2_f32.into());
            }
        }
    }
}

#[test]
fn area_and_winding_stay() {
    for mesh in samples() {
        let corners = |i: u32| mesh.1[i as usize].map(|v| mesh.0[v as usize]);
        let mut sums = vec![glam::DVec3::ZERO; mesh.1.len()];
        let mut total = 0.0;
        for (source, p, _) in pieces(&mesh, &split(&mesh, 0.2)) {
            assert!(area(p).dot(area(corners(source))) > 0.0);
            sums[source as usize] += area(p);
            total += area(p).length();
        }
        let before: f64 = (0..sums.len() as u32)
            .map(|i| area(corners(i)).length())
            .sum();
        assert!((total / before - 1.0).abs() < 1e-6, "{total} {before}");
        for (i, sum) in sums.into_iter().enumerate() {
            let source = area(corners(i as u32));
            assert!(sum.distance(source) <= 1e-6 * source.length().max(0.1));
        }
    }
}

#[test]
fn weights_are_dyadic_and_exact_on_edges() {
    let mesh = soup(9, 40, 3);
    let refined = split(&mesh, 0.05);
    let mut on_edges = 0;
    for point in &refined.vertices {
        assert_eq!(point.barycentrics.element_sum(), 1.0);
        for weight in point.barycentrics.to_array() {
            assert!((0.0..=1.0).contains(&weight));
            assert_eq!((weight * 1024.0).fract(), 0.0, "{weight}");
            on_edges += usize::from(weight == 0.0);
        }
    }
    assert!(on_edges > 3 * mesh.0.len());
}

#[test]
fn thin_triangles_keep_half_their_smallest_angle() {
    let mut random = random(5);
    let mut worst = f64::INFINITY;
    for case in 0..300 {
        let thin = 0.02 + random();
        let apex = Vec3::new(3.0 * random() - 0.5, thin, random() * thin);
        let mut positions = vec![Vec3::ZERO, Vec3::X * (2.0 + random()), apex];
        if case == 0 {
            // All but equilateral, with one edge just longer than the limits below.
            positions = vec![Vec3::ZERO, Vec3::X * 1.501, Vec3::new(0.75, 1.299, 0.0)];
        }
        let mesh = (positions, vec![[0, 1, 2]]);
        let before = min_angle([mesh.0[0], mesh.0[1], mesh.0[2]]);
        for max_edge in [1.5, 0.4, 0.17, 0.05] {
            for (_, p, _) in pieces(&mesh, &split(&mesh, max_edge)) {
                let ratio = min_angle(p) / before;
                assert!(ratio >= 0.5 - 1e-3, "case {case}, {max_edge}: {ratio}");
                worst = worst.min(ratio);
            }
        }
    }
    // The bound is all but met, so worse shapes would have been noticed.
    assert!(worst < 0.51, "{worst}");
}

#[test]
fn short_edges_leave_the_mesh_alone() {
    let mesh = grid(3, 2);
    let refined = split_long_edges(&mesh.0, &mesh.1, 1.5, 0).expect("nothing to add");
    assert_eq!(refined.triangles, mesh.1);
    assert_eq!(refined.positions(&mesh.0, &mesh.1), mesh.0);
    assert_eq!(split(&(vec![], vec![]), 1.0), RefinedMesh::default());
}

#[test]
fn used_vertices_come_first_and_others_go() {
    let positions = [Vec3::X, Vec3::ZERO, Vec3::splat(9.0), Vec3::Y].to_vec();
    let mesh = (positions, vec![[3, 1, 0]]);
    let refined = split(&mesh, 1.2);
    let expected = [Vec3::X, Vec3::ZERO, Vec3::Y, Vec3::new(0.5, 0.5, 0.0)];
    assert_eq!(refined.positions(&mesh.0, &mesh.1), expected);
    assert_eq!(refined.triangles.len(), 2);
}

#[test]
fn limits_are_kept() {
    let (positions, triangles) = cube();
    let fine = split_long_edges(&positions, &triangles, 1e-6, 1000);
    let limit = SplitError::TooManyVertices {
        limit: 1000,
        max_edge: 1e-6,
    };
    assert_eq!(fine, Err(limit));
    assert!(limit.to_string().contains("1000") && limit.to_string().contains("larger"));
    let count = split(&cube(), 0.3).vertices.len();
    assert!(split_long_edges(&positions, &triangles, 0.3, count).is_ok());
    assert!(split_long_edges(&positions, &triangles, 0.3, count - 1).is_err());
    for max_edge in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let refused = split_long_edges(&positions, &triangles, max_edge, 1000);
        assert!(matches!(refused, Err(SplitError::InvalidMaxEdge(_))));
    }
}

#[test]
fn splitting_ends_where_floats_do() {
    // Neighbouring floats at 16 km are 2 mm apart.
    let at = Vec3::splat(16_384.0);
    let positions = [at, at + Vec3::X * 0.01, at + Vec3::Y * 0.01];
    let refused = split_long_edges(&positions, &[[0, 1, 2]], 1e-5, usize::MAX);
    assert_eq!(refused, Err(SplitError::TooFine { max_edge: 1e-5 }));
}
