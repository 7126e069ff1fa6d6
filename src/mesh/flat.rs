use glam::{DVec3, Vec3};

use super::refined::{RefinedMesh, SurfacePoint};

/// The cosine of 1°, below which two faces get vertices of their own.
const MIN_COSINE: f64 = 0.999_847_695_156_391_2;

/// Gives the faces of a mesh without normals vertices of their own where they meet at an angle.
///
/// glTF asks for flat shading where normals are missing, so a vertex that a cube's faces share
/// stands for as many normals as there are faces. Each vertex becomes one for every direction
/// that its faces have, and faces within 1° of each other go on sharing it: going through the
/// triangles in order, a corner takes the first vertex made from its own whose first face is
/// within 1°. Triangles without area have no say.
///
/// The vertices that `triangles` use come first, in their order, with the added ones behind;
/// triangles stay as many and where they are.
///
/// # Panics
///
/// If a triangle has a vertex that does not exist.
pub fn split_flat_corners(positions: &[Vec3], triangles: &[[u32; 3]]) -> RefinedMesh {
    let (mut mesh, new_index) = RefinedMesh::with_used_vertices(positions.len(), triangles);
    // What each refined vertex faces, and the next vertex made from the same source vertex.
    let mut normals: Vec<Option<DVec3>> = vec![None; mesh.vertices.len()];
    let mut next: Vec<Option<u32>> = vec![None; mesh.vertices.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        let normal = face_normal(corners.map(|vertex| positions[vertex as usize]));
        let mut refined = corners.map(|vertex| new_index[vertex as usize].unwrap_or_default());
        for (corner, vertex) in refined.iter_mut().enumerate() {
            let Some(normal) = normal else { continue };
            while normals[*vertex as usize].is_some_and(|n| n.dot(normal) < MIN_COSINE) {
                *vertex = match next[*vertex as usize] {
                    Some(other) => other,
                    None => {
                        let point = SurfacePoint::corner(triangle as u32, corner);
                        let added = mesh.push_vertex(point);
                        normals.push(None);
                        next.push(None);
                        next[*vertex as usize] = Some(added);
                        added
                    }
                };
            }
            normals[*vertex as usize].get_or_insert(normal);
        }
        mesh.push_triangle(triangle as u32, refined);
    }
    mesh
}

fn face_normal(corners: [Vec3; 3]) -> Option<DVec3> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    (b - a).cross(c - a).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::split_long_edges;
    use crate::mesh::test_meshes::{cube, grid};

    #[test]
    fn a_cube_gets_three_vertices_a_corner() {
        let (positions, triangles) = cube();
        let flat = split_flat_corners(&positions, &triangles);
        assert_eq!(flat.vertices.len(), 24);
        assert_eq!(flat.sources, (0..12).collect::<Vec<u32>>());
        let refined = flat.positions(&positions, &triangles);
        for (before, after) in triangles.iter().zip(&flat.triangles) {
            assert_eq!(
                before.map(|v| positions[v as usize]),
                after.map(|v| refined[v as usize])
            );
        }
        // Two triangles a face, with four vertices between them.
        for face in flat.triangles.chunks(2) {
            let mut vertices = face.as_flattened().to_vec();
            vertices.sort_unstable();
            vertices.dedup();
            assert_eq!(vertices.len(), 4);
        }
    }

    #[test]
    fn a_plane_stays_as_it_is() {
        let (positions, triangles) = grid(5, 4);
        let flat = split_flat_corners(&positions, &triangles);
        assert_eq!(flat.triangles, triangles);
        assert_eq!(flat.positions(&positions, &triangles), positions);
    }

    #[test]
    fn small_angles_share_and_large_ones_do_not() {
        for (degrees, count) in [(0.9_f32, 4), (1.1, 6)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let positions = [Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::new(-cos, 0.0, sin)];
            let flat = split_flat_corners(&positions, &[[0, 2, 1], [0, 1, 3]]);
            assert_eq!(flat.vertices.len(), count, "{degrees}°");
        }
    }

    #[test]
    fn triangles_without_area_add_nothing() {
        let (positions, mut triangles) = cube();
        triangles.insert(0, [0, 0, 1]);
        triangles.push([2, 2, 2]);
        let flat = split_flat_corners(&positions, &triangles);
        assert_eq!(flat.vertices.len(), 24);
        assert_eq!(flat.triangles.len(), 14);
    }

    #[test]
    fn refinements_compose() {
        let (positions, triangles) = cube();
        let flat = split_flat_corners(&positions, &triangles);
        let flat_positions = flat.positions(&positions, &triangles);
        let split =
            split_long_edges(&flat_positions, &flat.triangles, 0.3, 10_000).expect("a small mesh");
        let both = flat.then(&triangles, &split);
        assert_eq!(
            both.positions(&positions, &triangles),
            split.positions(&flat_positions, &flat.triangles)
        );
        assert_eq!(both.triangles, split.triangles);
        for (triangle, &source) in both.triangles.iter().zip(&both.sources) {
            for &vertex in triangle {
                let point = both.vertices[vertex as usize];
                assert!(point.barycentrics_on(source, &triangles).is_some());
                assert_eq!(point.barycentrics.element_sum(), 1.0);
            }
        }
        // Splitting in two steps is splitting twice, with quarters of quarters as weights.
        let half = split_long_edges(&positions, &triangles, 0.8, 10_000).expect("small");
        let half_positions = half.positions(&positions, &triangles);
        let rest = split_long_edges(&half_positions, &half.triangles, 0.2, 10_000).expect("small");
        let composed = half.then(&triangles, &rest);
        assert_eq!(
            composed.positions(&positions, &triangles),
            rest.positions(&half_positions, &half.triangles)
        );
    }
}
