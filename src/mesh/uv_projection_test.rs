use glam::{Quat, Vec2, Vec3};

use super::test_meshes::{Mesh, cube, grid, random, soup};
use super::*;

/// Metres of texture by metre of surface, in the directions where they are least and most: singular values
/// of the map from a triangle to its texture. Negative if it shows mirrored from outside.
fn densities(corners: [Vec3; 3], uvs: [Vec2; 3]) -> [f32; 2] {
    let [e, f] = [corners[1] - corners[0], corners[2] - corners[0]];
    // An orthonormal frame of the triangle: x along its first edge, y to the left of it as seen from outside.
    let x = e.normalize();
    let y = e.cross(f).normalize().cross(x);
    let (ex, fx, fy) = (e.dot(x), f.dot(x), f.dot(y));
    // v down becomes y up.
    let turn = |uv: Vec2| Vec2::new(uv.x, -uv.y);
    let [p, q] = [turn(uvs[1] - uvs[0]), turn(uvs[2] - uvs[0])];
    let across = p / ex;
    let up = (q - across * fx) / fy;
    // Singular values of a 2 × 2 matrix, without differences of squares.
    let sum = Vec2::new(across.x + up.y, across.y - up.x).length();
    let difference = Vec2::new(across.x - up.y, across.y + up.x).length();
    [0.5 * (sum - difference), 0.5 * (sum + difference)]
}

/// Checks that the result is the mesh it was made from, and gives corners and coordinates of its triangles.
fn checked(
    (positions, triangles): &Mesh,
    settings: &UvSettings,
) -> (UvMesh, Vec<([Vec3; 3], [Vec2; 3])>) {
    let mesh = project_uvs(positions, triangles, settings).unwrap();
    assert_eq!(mesh.triangles.len(), triangles.len());
    assert_eq!(mesh.uvs.len(), mesh.sources.len());
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
    for (before, after) in triangles.iter().zip(&mesh.triangles) {
        assert_eq!(*before, after.map(|v| mesh.sources[v as usize]));
    }
    let corners = mesh.triangles.iter().map(|t| {
        let position = |v: u32| positions[mesh.sources[v as usize] as usize];
        (t.map(position), t.map(|v| mesh.uvs[v as usize]))
    });
    let corners = corners.collect();
    (mesh, corners)
}

fn jump(uvs: [Vec2; 3]) -> f32 {
    let [a, b, c] = uvs.map(|uv| uv.x);
    a.max(b).max(c) - a.min(b).min(c)
}

fn faces_y([a, b, c]: [Vec3; 3]) -> bool {
    let normal = (b - a).cross(c - a).abs();
    normal.y >= 0.99 * normal.max_element()
}

/// A sphere of one vertex a point: `around` by `down` cells, triangles at the poles.
fn globe(around: u32, down: u32) -> Mesh {
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for j in 1..down {
        for i in 0..around {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / around as f32).sin_cos();
            let (r, y) = (std::f32::consts::PI * j as f32 / down as f32).sin_cos();
            positions.push(Vec3::new(r * sin, y, r * cos));
        }
    }
    let at = |i: u32, j: u32| 2 + (j - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(i, 1), at(i + 1, 1)]);
        triangles.push([1, at(i + 1, down - 1), at(i, down - 1)]);
        for j in 1..down - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    (positions, triangles)
}

/// A drum of radius 1 from y = 0 to 2, its ends fans round a vertex.
fn drum(around: u32) -> Mesh {
    let mut positions = vec![Vec3::ZERO, Vec3::Y * 2.0];
    for i in 0..around {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / around as f32).sin_cos();
        positions.extend([Vec3::new(sin, 0.0, cos), Vec3::new(sin, 2.0, cos)]);
    }
    let triangles = (0..around).flat_map(|i| {
        let [a, b] = [2 + 2 * i, 2 + 2 * ((i + 1) % around)];
        [
            [a, b, b + 1],
            [a, b + 1, a + 1],
            [0, b, a],
            [1, a + 1, b + 1],
        ]
    });
    (positions, triangles.collect())
}

#[test]
fn a_box_has_its_density_everywhere_and_nothing_mirrored() {
    let (positions, triangles) = cube();
    let moved = Vec3::new(7.0, -3.0, 2.0);
    let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.4);
    let placed: Vec<Vec3> = positions
        .iter()
        .map(|&p| rotation * (p * 3.0) + moved)
        .collect();
    for (positions, origin, rotation) in [
        (positions, Vec3::ZERO, Quat::IDENTITY),
        (placed, moved, rotation),
    ] {
        let settings = UvSettings {
            projection: UvProjection::Box { size: 1.0 },
            origin,
            rotation,
        };
        let (mesh, corners) = checked(&(positions, triangles.clone()), &settings);
        assert_eq!(mesh.uvs.len(), 24, "four vertices a side");
        for (corners, uvs) in corners {
            for density in densities(corners, uvs) {
                assert!((density - 1.0).abs() < 1e-5, "{density} by metre");
            }
        }
    }
    let half = UvSettings::new(UvProjection::Box { size: 2.0 });
    let (_, corners) = checked(&cube(), &half);
    assert!(
        corners
            .iter()
            .all(|(c, uvs)| (densities(*c, *uvs)[0] - 0.5).abs() < 1e-5)
    );
}

#[test]
fn a_box_stretches_by_the_root_of_three_at_most() {
    let (mesh, corners) = checked(
        &globe(40, 20),
        &UvSettings::new(UvProjection::Box { size: 1.0 }),
    );
    for (corners, uvs) in corners {
        let [least, most] = densities(corners, uvs);
        assert!(
            least > 1.0 / 3.0_f32.sqrt() - 1e-3 && most < 1.0 + 1e-4,
            "{least} to {most}"
        );
    }
    // Six charts are cut apart along their borders and nowhere else.
    assert!(
        mesh.uvs.len() > 782 && mesh.uvs.len() < 1000,
        "{}",
        mesh.uvs.len()
    );
}

/// Faces at 45° go to one side, whatever rounding does to their normals.
#[test]
fn faces_that_lean_as_much_both_ways_stay_together() {
    let mut random = random(11);
    let (flat, triangles) = grid(12, 12);
    let leaning = Quat::from_rotation_y(std::f32::consts::FRAC_PI_4);
    let positions = flat
        .iter()
        .map(|&p| leaning * p + 1e-6 * random())
        .collect();
    let settings = UvSettings::new(UvProjection::Box { size: 1.0 });
    let (mesh, _) = checked(&(positions, triangles), &settings);
    assert_eq!(mesh.uvs.len(), flat.len());
}

#[test]
fn no_triangle_runs_back_round_a_drum() {
    for around in [3, 4, 5, 16, 61] {
        let settings = UvSettings::new(UvProjection::Cylinder {
            repeats: 3.0,
            height: 0.5,
        });
        let (mesh, corners) = checked(&drum(around), &settings);
        assert!(mesh.over_poles.is_empty());
        // The side has one more vertex all the way round, ends have their own.
        assert_eq!(
            mesh.uvs.len() as u32,
            2 * (around + 1) + 2 * (around + 1),
            "{around}"
        );
        for (corners, uvs) in corners {
            let [least, most] = densities(corners, uvs);
            assert!(least > 0.0, "mirrored or smeared: {least}");
            let outwards = corners.iter().map(|c| c.y).sum::<f32>() % 6.0 != 0.0;
            if outwards {
                // A third of the way round is the most that a step can be.
                assert!(jump(uvs) <= 3.0 / around as f32 + 1e-5, "{}", jump(uvs));
                // By height, and by girth; the polygon's is less than the circle's.
                let girth = 2.0 * (std::f32::consts::PI / around as f32).sin() * around as f32;
                let expected = [3.0 / girth, 2.0];
                assert!((least - expected[0]).abs() < 1e-4 && (most - 2.0).abs() < 1e-4);
            } else {
                assert!((least - 2.0).abs() < 1e-4 && (most - 2.0).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn no_triangle_runs_back_round_a_sphere_and_poles_are_finite() {
    let settings = UvSettings::new(UvProjection::Sphere { repeats: Vec2::ONE });
    let (mesh, corners) = checked(&globe(24, 12), &settings);
    assert!(mesh.over_poles.is_empty());
    // One more vertex down the seam, and one a triangle at each pole.
    assert_eq!(mesh.uvs.len(), 11 * 25 + 2 * 24);
    for (corners, uvs) in corners {
        assert!(jump(uvs) <= 1.0 / 24.0 + 1e-5, "{}", jump(uvs));
        assert!(densities(corners, uvs)[0] > 0.0, "mirrored");
        for (corner, uv) in corners.into_iter().zip(uvs) {
            assert!((uv.y - corner.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI).abs() < 1e-3);
            if corner.y.abs() == 1.0 {
                let others = uvs.iter().map(|uv| uv.x).sum::<f32>() / 3.0;
                assert!(
                    (uv.x - others).abs() < 1e-5,
                    "a pole is between the other two"
                );
            } else {
                let angle = corner.x.atan2(corner.z) / std::f32::consts::TAU;
                let off = uv.x - angle;
                assert!((off - off.round()).abs() < 1e-5 && uv.x.abs() <= 0.55);
            }
        }
    }
}

/// An octahedron lying on a face has a triangle over each pole.
#[test]
fn triangles_over_poles_are_told() {
    let tilt = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::Y);
    let tips = [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let positions = tips.map(|p| tilt * p).to_vec();
    let mut triangles = Vec::new();
    for octant in 0..8_u32 {
        let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2)];
        let flipped = octant.count_ones() % 2 == 1;
        triangles.push(if flipped { [x, z, y] } else { [x, y, z] });
    }
    let settings = UvSettings::new(UvProjection::Sphere { repeats: Vec2::ONE });
    let (mesh, corners) = checked(&(positions, triangles), &settings);
    assert_eq!(mesh.over_poles, [0, 7]);
    for (i, (corners, uvs)) in corners.into_iter().enumerate() {
        if i != 0 && i != 7 {
            assert!(jump(uvs) <= 0.5 && densities(corners, uvs)[0] > 0.0, "{i}");
        }
    }
}

#[test]
fn a_plane_is_hung_like_a_picture() {
    let (positions, triangles) = grid(4, 3);
    let settings = UvSettings {
        origin: Vec3::new(0.0, 3.0, 0.0),
        ..UvSettings::new(UvProjection::Planar {
            size: Vec2::new(4.0, 3.0),
        })
    };
    let (mesh, corners) = checked(&(positions, triangles), &settings);
    assert_eq!(mesh.uvs.len(), 20);
    for (corners, uvs) in corners {
        assert!(densities(corners, uvs)[0] > 0.0);
        for (p, uv) in corners.into_iter().zip(uvs) {
            assert!(uv.distance(Vec2::new(p.x / 4.0, 1.0 - p.y / 3.0)) < 1e-6);
        }
    }
}

const ALL: [UvProjection; 4] = [
    UvProjection::Planar { size: Vec2::ONE },
    UvProjection::Box { size: 1.0 },
    UvProjection::Cylinder {
        repeats: 2.0,
        height: 1.0,
    },
    UvProjection::Sphere { repeats: Vec2::ONE },
];

#[test]
fn whatever_the_mesh_coordinates_are_finite_and_go_the_short_way() {
    for projection in ALL {
        let (mut positions, mut triangles) = soup(60, 400, 5);
        // At the centre, on the axis, and triangles without area.
        positions.extend([Vec3::ZERO, Vec3::Y, Vec3::NEG_Y * 3.0]);
        triangles.extend([
            [60, 60, 60],
            [60, 61, 62],
            [0, 0, 1],
            [60, 3, 4],
            [61, 62, 5],
            [7, 8, 61],
        ]);
        for scale in [1e-20, 1.0, 1e15] {
            let scaled = positions.iter().map(|&p| p * scale).collect();
            let (mesh, corners) =
                checked(&(scaled, triangles.clone()), &UvSettings::new(projection));
            let round = match projection {
                UvProjection::Cylinder { .. } | UvProjection::Sphere { .. } => scale == 1.0,
                _ => false,
            };
            for (i, (corners, uvs)) in (0..).zip(&corners) {
                if !round || mesh.over_poles.contains(&i) {
                    continue;
                }
                // Twice round, so half a turn is 1; ends are flat.
                let most = match projection {
                    UvProjection::Cylinder { .. } if faces_y(*corners) => f32::INFINITY,
                    UvProjection::Cylinder { .. } => 1.0,
                    _ => 0.5,
                };
                assert!(
                    jump(*uvs) <= most + 1e-5,
                    "{projection:?}: triangle {i}: {uvs:?}"
                );
            }
        }
    }
    assert_eq!(
        project_uvs(&[], &[], &UvSettings::new(ALL[1])),
        Ok(UvMesh::default())
    );
}

#[test]
fn what_makes_no_sense_is_told() {
    let (mut positions, triangles) = cube();
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        for projection in [
            UvProjection::Planar {
                size: Vec2::new(1.0, bad),
            },
            UvProjection::Box { size: bad },
            UvProjection::Cylinder {
                repeats: bad,
                height: 1.0,
            },
            UvProjection::Cylinder {
                repeats: 1.0,
                height: bad,
            },
            UvProjection::Sphere {
                repeats: Vec2::new(bad, 1.0),
            },
        ] {
            let found = project_uvs(&positions, &triangles, &UvSettings::new(projection));
            assert_eq!(found, Err(UvError::Settings));
        }
    }
    let settings = UvSettings::new(ALL[1]);
    for bad in [
        UvSettings {
            origin: Vec3::NAN,
            ..settings
        },
        UvSettings {
            rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
            ..settings
        },
    ] {
        assert_eq!(
            project_uvs(&positions, &triangles, &bad),
            Err(UvError::Settings)
        );
    }
    let error = project_uvs(&positions, &[[0, 1, 2], [0, 8, 1]], &settings).unwrap_err();
    assert_eq!(
        error.to_string(),
        "triangle 1 has vertex 8, and there are 8: the mesh is broken"
    );
    positions[3] = Vec3::NAN;
    assert_eq!(
        project_uvs(&positions, &triangles, &settings),
        Err(UvError::Position(3))
    );
}
