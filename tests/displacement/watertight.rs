//! Failure modes 20, 21 and 22: cracks, T-junctions, smeared texture coordinates.

use std::collections::HashMap;

use bevy_fresco::displacement::{
    Base, Direction, Displaced, DisplacementSettings, Spacing, Tessellation, displace,
};
use glam::{Vec2, Vec3, vec2, vec3};

use crate::meshes::{Mesh, SQUARE, cube, cylinder, noise, plane, sphere};

type Place = [u32; 3];

fn place(p: Vec3) -> Place {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

fn edge<T: Ord>(a: T, b: T) -> (T, T) {
    if a < b { (a, b) } else { (b, a) }
}

/// Every edge of the result has as many faces as the base has there: two inside of its triangles, and along
/// its edges those that the base has. All by positions to the bit, those of the base welded by `tolerance`.
pub(crate) fn assert_watertight(what: &str, bases: &[Base], displaced: &Displaced, tolerance: f32) {
    let weld = |p: Vec3| match tolerance > 0.0 {
        true => place((p / tolerance).round()),
        false => place(p),
    };
    let mut expected: HashMap<(Place, Place), u32> = HashMap::new();
    for base in bases {
        for t in base.triangles {
            for i in 0..3 {
                let [a, b] = [t[i], t[(i + 1) % 3]].map(|v| weld(base.positions[v as usize]));
                *expected.entry(edge(a, b)).or_default() += 1;
            }
        }
    }
    // By edge of the result: how many faces it has, how many it is to have.
    let mut found: HashMap<(Place, Place), (u32, u32)> = HashMap::new();
    for (base, part) in bases.iter().zip(&displaced.parts) {
        for (t, &source) in part.mesh.triangles.iter().zip(&part.mesh.sources) {
            let corners = base.triangles[source as usize];
            let on = t.map(|v| {
                let point = part.mesh.vertices[v as usize];
                let on = point.barycentrics_on(source, base.triangles);
                on.expect("corners lie on the source of their triangle")
            });
            for i in 0..3 {
                let j = (i + 1) % 3;
                let [a, b] = [t[i], t[j]].map(|v| place(part.positions[v as usize]));
                let along = (0..3).find(|&k| on[i][k] == 0.0 && on[j][k] == 0.0);
                let faces = along.map_or(2, |k| {
                    let ends = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                    let [a, b] = ends.map(|v| weld(base.positions[v as usize]));
                    expected[&edge(a, b)]
                });
                let known = found.entry(edge(a, b)).or_insert((0, faces));
                known.0 += 1;
                assert_eq!(known.1, faces, "{what}");
            }
        }
    }
    let torn = found.values().filter(|(is, to_be)| is != to_be).count();
    assert_eq!(torn, 0, "{what}: {torn} of {} edges are torn", found.len());
    assert_eq!(
        characteristic(displaced),
        base_characteristic(bases, weld),
        "{what}"
    );
}

/// Vertices − edges + faces, by place.
fn characteristic(displaced: &Displaced) -> i64 {
    let corners = displaced.parts.iter().flat_map(|part| {
        let corners = |t: &[u32; 3]| t.map(|v| place(part.positions[v as usize]));
        part.mesh.triangles.iter().map(corners)
    });
    count(corners.collect())
}

fn base_characteristic(bases: &[Base], weld: impl Fn(Vec3) -> Place) -> i64 {
    let corners = bases.iter().flat_map(|base| {
        let corners = |t: &[u32; 3]| t.map(|v| weld(base.positions[v as usize]));
        base.triangles.iter().map(corners)
    });
    count(corners.collect())
}

fn count(triangles: Vec<[Place; 3]>) -> i64 {
    let mut places: Vec<Place> = triangles.iter().flatten().copied().collect();
    let mut edges: Vec<(Place, Place)> = (triangles.iter())
        .flat_map(|t| [0, 1, 2].map(|i| edge(t[i], t[(i + 1) % 3])))
        .collect();
    places.sort_unstable();
    places.dedup();
    edges.sort_unstable();
    edges.dedup();
    places.len() as i64 - edges.len() as i64 + triangles.len() as i64
}

/// Two squares that meet at x = 0, the right one showing the map mirrored; one vertex for both at the seam, or
/// two.
fn mirrored(shared: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |mesh: &mut Mesh, x: f32, y: f32| {
        mesh.vertex(vec3(x, y, 0.0), Vec3::Z, vec2(x.abs(), 1.0 - y))
    };
    let [a, b, c, d] =
        [(-1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (-1.0, 1.0)].map(|(x, y)| at(&mut mesh, x, y));
    let [e, f] = [(1.0, 0.0), (1.0, 1.0)].map(|(x, y)| at(&mut mesh, x, y));
    let [g, h] = match shared {
        true => [b, c],
        false => [(0.0, 0.0), (-0.0, 1.0)].map(|(x, y)| at(&mut mesh, x, y)),
    };
    mesh.triangles = vec![[a, b, c], [a, c, d], [g, e, f], [g, f, h]];
    mesh
}

/// Three pages of a book, which have their back in common.
fn book() -> Mesh {
    let mut mesh = Mesh::default();
    for angle in [0.0_f32, 2.0, 4.0] {
        let out = vec3(angle.cos(), 0.0, angle.sin());
        mesh.quad([Vec3::ZERO, out, out + Vec3::Y, Vec3::Y], SQUARE);
    }
    mesh
}

/// A cube whose corners are moved by a rounding, each side's in another way.
fn shaken_cube() -> Mesh {
    let mut mesh = cube();
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        let axis = i % 3;
        let bits = p[axis].to_bits();
        p[axis] = f32::from_bits(bits + (i as u32 / 3) % 2);
    }
    mesh
}

pub(crate) fn cases() -> Vec<(&'static str, Mesh, f32)> {
    vec![
        ("cube with hard edges", cube(), 0.0),
        ("sphere with a seam", sphere(12, 6), 0.0),
        ("cylinder with a seam", cylinder(9, 2, false), 0.0),
        ("mirrored, split", mirrored(false), 0.0),
        ("mirrored, shared", mirrored(true), 0.0),
        ("three pages at an edge", book(), 0.0),
        ("open square", plane(1.0), 0.0),
        ("cube moved by roundings", shaken_cube(), 1e-4),
    ]
}

fn settings(tessellation: Tessellation, direction: Direction) -> DisplacementSettings {
    DisplacementSettings {
        scale: 0.1,
        mid_level: 0.3,
        direction,
        tessellation,
        ..DisplacementSettings::default()
    }
}

#[test]
fn mode_20_nothing_is_torn_where_vertices_are_many() {
    let map = noise(16, 1);
    for (what, mesh, tolerance) in cases() {
        for direction in [Direction::Smooth, Direction::FaceNormal] {
            for tessellation in [
                Tessellation::Base,
                Tessellation::Uniform(Spacing::Texels(1.0)),
                Tessellation::Uniform(Spacing::Metres(0.13)),
            ] {
                let settings = settings(tessellation, direction);
                let bases = [mesh.base()];
                let displaced = displace(&bases, &map, &settings, &()).unwrap();
                let what = format!("{what}, {tessellation:?}, {direction:?}");
                assert_watertight(&what, &bases, &displaced, tolerance);
                assert!(displaced.report.undirected == 0);
            }
        }
    }
}

/// Sides of a cube as meshes of their own.
#[test]
fn mode_20_meshes_that_meet_stay_together() {
    let cube = cube();
    let sides: Vec<Mesh> = (0..6)
        .map(|side| Mesh {
            positions: cube.positions[4 * side..][..4].to_vec(),
            normals: cube.normals[4 * side..][..4].to_vec(),
            uvs: cube.uvs[4 * side..][..4].to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        })
        .collect();
    let bases: Vec<Base> = sides.iter().map(Mesh::base).collect();
    let map = noise(16, 2);
    let uniform = Tessellation::Uniform(Spacing::Texels(1.0));
    let displaced = displace(&bases, &map, &settings(uniform, Direction::Smooth), &()).unwrap();
    assert_eq!(displaced.parts.len(), 6);
    assert_watertight("sides of a cube", &bases, &displaced, 0.0);
}

/// Charts of different density ask for different numbers of pieces along one edge.
#[test]
fn mode_21_random_levels_leave_no_t_junction() {
    for seed in 0..20_u32 {
        let mut mesh = sphere(8, 5);
        // Every triangle of its own, and its map of its own size.
        let corners: Vec<u32> = mesh.triangles.as_flattened().to_vec();
        let of = |v: &u32| *v as usize;
        mesh.positions = corners.iter().map(|v| mesh.positions[of(v)]).collect();
        mesh.normals = corners.iter().map(|v| mesh.normals[of(v)]).collect();
        mesh.uvs = (corners.iter().enumerate())
            .map(|(i, v)| {
                let level = (i as u32 / 3 * 7919 + seed * 104_729) % 9;
                mesh.uvs[of(v)] * level as f32
            })
            .collect();
        mesh.triangles = (0..corners.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let uniform = Tessellation::Uniform(Spacing::Texels(1.0));
        let bases = [mesh.base()];
        let settings = settings(uniform, Direction::Smooth);
        let displaced = displace(&bases, &noise(32, seed), &settings, &()).unwrap();
        assert_watertight(&format!("levels {seed}"), &bases, &displaced, 0.0);
    }
}

#[test]
fn mode_22_texture_coordinates_are_not_smeared() {
    for mesh in [cube(), sphere(12, 6), mirrored(false)] {
        let uniform = Tessellation::Uniform(Spacing::Texels(1.0));
        let settings = settings(uniform, Direction::Smooth);
        let displaced = displace(&[mesh.base()], &noise(32, 3), &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let uvs: Vec<Vec2> = part.mesh.interpolate(&mesh.triangles, |corners, w| {
            let [a, b, c] = corners.map(|v| mesh.uvs[v as usize]);
            a * w.x + b * w.y + c * w.z
        });
        let area = |uvs: [Vec2; 3]| (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]);
        let mut sums = vec![0.0; mesh.triangles.len()];
        for (t, &source) in part.mesh.triangles.iter().zip(&part.mesh.sources) {
            let whole = area(mesh.triangles[source as usize].map(|v| mesh.uvs[v as usize]));
            let piece = area(t.map(|v| uvs[v as usize]));
            assert!(piece * whole > 0.0, "{piece} of {whole}");
            sums[source as usize] += piece / whole;
        }
        assert!(sums.iter().all(|sum| (sum - 1.0_f32).abs() < 1e-3));
    }
}
