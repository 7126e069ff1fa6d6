use glam::{Vec2, Vec3};

use super::{Steps, uv_gradients};

/// Gradients of the texture coordinates `u` and `v` at vertices, by metre: what a shader needs for bumps that
/// depend on no derivatives on the screen.
///
/// `triangles` are corners by vertex; what they name must be there. At a vertex of one triangle the result is
/// [`uv_gradients`] of that triangle, with the vertex's own normal. Where triangles share a vertex it is the
/// mean by area: on round surfaces nearer to the truth than each, and no step at edges. Where texture
/// coordinates are mirrored or cut, meshes have several vertices, and nothing is averaged across.
/// A vertex whose triangles have no area, or that has none, has zeros.
pub fn vertex_uv_gradients(
    positions: &[Vec3],
    normals: &[Vec3],
    uvs: &[Vec2],
    triangles: impl IntoIterator<Item = [u32; 3]>,
) -> Vec<[Vec3; 2]> {
    let mut sums = vec![([Vec3::ZERO; 2], 0.0_f32); positions.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|i| i as usize);
        let along = [positions[b] - positions[a], positions[c] - positions[a]];
        let uv_edges = [uvs[b] - uvs[a], uvs[c] - uvs[a]];
        let area = along[0].cross(along[1]).length();
        if !(area > 0.0 && area.is_finite()) {
            continue;
        }
        for i in [a, b, c] {
            let normal = normals[i].normalize_or_zero();
            let found = uv_gradients(Steps { normal, along }, uv_edges);
            if found.iter().all(|g| g.is_finite()) {
                sums[i].0[0] += area * found[0];
                sums[i].0[1] += area * found[1];
                sums[i].1 += area;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, area)| sum.map(|g| if area > 0.0 { g / area } else { Vec3::ZERO }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bump::bumped_normal;
    use std::f32::consts::{PI, TAU};

    /// A unit sphere of `n × 2n` quads; vertices on the seam are there twice.
    struct Ball {
        positions: Vec<Vec3>,
        uvs: Vec<Vec2>,
        triangles: Vec<[u32; 3]>,
    }

    fn ball(n: u32) -> Ball {
        let (columns, rows) = (2 * n + 1, n + 1);
        let uv = |i: u32| Vec2::new((i % columns) as f32, (i / columns) as f32);
        let uvs: Vec<Vec2> = (0..columns * rows)
            .map(|i| uv(i) / Vec2::new(2.0 * n as f32, n as f32))
            .collect();
        let quads = (0..n).flat_map(|y| (0..2 * n).map(move |x| y * columns + x));
        Ball {
            positions: uvs.iter().map(|uv| on_ball(*uv)).collect(),
            uvs,
            triangles: quads
                .flat_map(|i| {
                    [
                        [i, i + columns, i + 1],
                        [i + 1, i + columns, i + columns + 1],
                    ]
                })
                .collect(),
        }
    }

    fn on_ball(uv: Vec2) -> Vec3 {
        let (a, b) = (TAU * uv.x, PI * uv.y);
        Vec3::new(b.sin() * a.cos(), b.cos(), -b.sin() * a.sin())
    }

    /// `∇u`, `∇v` of the sphere itself.
    fn truth(uv: Vec2) -> [Vec3; 2] {
        let (a, b) = (TAU * uv.x, PI * uv.y);
        let by_u = Vec3::new(-a.sin(), 0.0, -a.cos());
        let by_v = Vec3::new(b.cos() * a.cos(), -b.sin(), -b.cos() * a.sin());
        [by_u / (TAU * b.sin()), by_v / PI]
    }

    #[test]
    fn gradients_of_a_ball_are_those_of_the_sphere() {
        let error = |n: u32| {
            let ball = ball(n);
            let found = vertex_uv_gradients(
                &ball.positions,
                &ball.positions,
                &ball.uvs,
                ball.triangles.iter().copied(),
            );
            let inside = |uv: &Vec2| uv.x > 0.0 && uv.x < 1.0 && uv.y > 0.2 && uv.y < 0.8;
            let off = |(uv, found): (&Vec2, [Vec3; 2])| {
                let truth = truth(*uv);
                (0..2)
                    .map(|i| found[i].distance(truth[i]) / truth[i].length())
                    .fold(0.0, f32::max)
            };
            let pairs = ball.uvs.iter().zip(found);
            pairs
                .filter(|(uv, _)| inside(uv))
                .map(off)
                .fold(0.0, f32::max)
        };
        let (coarse, fine) = (error(16), error(64));
        assert!(coarse < 0.05, "{coarse}");
        // Of second order where triangles around a vertex are alike.
        assert!(fine < coarse / 8.0, "{fine} of {coarse}");
    }

    /// At the poles triangles have no area in space, or none in texture coordinates.
    #[test]
    fn poles_do_no_harm() {
        let ball = ball(8);
        let found = vertex_uv_gradients(
            &ball.positions,
            &ball.positions,
            &ball.uvs,
            ball.triangles.iter().copied(),
        );
        for ([by_u, by_v], n) in found.into_iter().zip(&ball.positions) {
            assert!(by_u.is_finite() && by_v.is_finite());
            let n = bumped_normal(*n, by_u + by_v);
            assert!((n.length() - 1.0).abs() < 1e-5);
        }
    }

    /// Bump test 6: at an edge normals of two triangles differ; averages at shared vertices have no step
    /// there, and are nearer to the truth than either.
    #[test]
    fn averages_at_shared_vertices_are_nearer_to_the_truth() {
        let ball = ball(12);
        let gradients = |triangles: &[[u32; 3]]| {
            let triangles = triangles.iter().copied();
            vertex_uv_gradients(&ball.positions, &ball.positions, &ball.uvs, triangles)
        };
        let bump = |i: u32, [by_u, by_v]: [Vec3; 2]| {
            bumped_normal(ball.positions[i as usize], 3.0 * by_u + 2.0 * by_v)
        };
        let middle = |uv: Vec2| uv.y > 0.3 && uv.y < 0.7 && uv.x > 0.1 && uv.x < 0.9;
        let shared = gradients(&ball.triangles);
        let (mut step, mut alone_off, mut shared_off) = (0.0_f32, 0.0_f32, 0.0_f32);
        for pair in ball.triangles.chunks_exact(2) {
            // The ends of the edge that the two triangles of a quad share.
            for i in [pair[0][1], pair[0][2]] {
                let uv = ball.uvs[i as usize];
                if !middle(uv) {
                    continue;
                }
                let truth = bump(i, truth(uv));
                let [a, b] = [0, 1].map(|side| bump(i, gradients(&pair[side..=side])[i as usize]));
                step = step.max(a.angle_between(b));
                alone_off = alone_off.max(a.angle_between(truth));
                shared_off = shared_off.max(bump(i, shared[i as usize]).angle_between(truth));
            }
        }
        assert!(step > 0.02, "{step}");
        assert!(shared_off < 0.25 * alone_off, "{shared_off} of {alone_off}");
    }

    #[test]
    fn what_no_triangle_has_is_zero() {
        let found = vertex_uv_gradients(&[Vec3::ONE; 3], &[Vec3::Z; 3], &[Vec2::X; 3], [[0, 1, 2]]);
        assert_eq!(found, [[Vec3::ZERO; 2]; 3]);
    }
}
