use std::time::Duration;

use glam::{DVec4, Vec3, Vec3A, Vec4};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::triangle::Triangle;

use super::validate::HALF_EXTENT;

/// Triangles in a hierarchy of boxes, four children a node, four triangles a leaf.
///
/// The tree is built by `obvhs` (PLOC with parallel reinsertion) and collapsed to four children,
/// so that boxes and triangles are tested four at a time in the lanes of a `Vec4`. This is the
/// only file that knows the library.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

/// Boxes of four children: lanes are children, rows `min x, min y, min z, max x, max y, max z`.
struct Node {
    bounds: [Vec4; 6],
    children: [Child; 4],
}

/// Up to four triangles; unused lanes hold NaN, which nothing meets.
struct Leaf {
    /// `corners[corner][axis]`, lanes are triangles.
    corners: [[Vec4; 3]; 3],
    triangles: [u32; 4],
}

/// Index of a node, or of a leaf with the top bit set.
#[derive(Clone, Copy)]
struct Child(u32);

const LEAF: u32 = 1 << 31;
const EMPTY: Child = Child(u32::MAX);

/// How much time to spend on building: rays find the same either way, sooner with the best.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BvhQuality {
    Best,
    Quick,
}

/// A triangle that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) triangle: u32,
    pub(crate) distance: f32,
    /// Weights of the second and third corner.
    pub(crate) uv: [f32; 2],
    /// The ray meets the side that the winding does not face.
    pub(crate) back: bool,
}

/// Entries of a traversal's stack, few because each ray clears them; deeper trees continue on a second one.
const STACK: usize = 24;

/// Grows a box's far distance by the rounding of the slab test (Ize 2013, "Robust BVH Ray
/// Traversal", JCGT 2(2): 1 + 2γ₃), so that no ray slips past a box its triangle touches.
const ROBUST: f32 = 1.0 + 2.0 * 3.0 * f32::EPSILON;

/// Boxes are so much larger than what they hold, in internal units: a ray that runs in the face of a box must meet
/// it, or who shares the box would decide whether an edge there is met.
const ROOM: f32 = HALF_EXTENT * f32::EPSILON;

/// Roundings of a distance's numerator, in units of the largest product in it: three products of edge functions, each
/// a difference of two, and their sum.
const ROUNDINGS: f32 = 6.0 * f32::EPSILON;

impl Bvh {
    /// A hierarchy over triangles, which crossings name by `ids`.
    pub(crate) fn new(corners: &[[Vec3; 3]], ids: &[u32], quality: BvhQuality) -> Self {
        let triangles: Vec<Triangle> = corners
            .iter()
            .map(|&[a, b, c]| Triangle {
                v0: a.into(),
                v1: b.into(),
                v2: c.into(),
            })
            .collect();
        let params = BvhBuildParams {
            max_prims_per_leaf: 4,
            // Four triangles are tested in the time of one: as few leaves as there may be.
            collapse_traversal_cost: 4.0,
            ..match quality {
                BvhQuality::Best => BvhBuildParams::very_slow_build(),
                BvhQuality::Quick => BvhBuildParams::medium_build(),
            }
        };
        let binary = build_bvh2(&triangles, params, &mut Duration::default());
        let mut bvh = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
        };
        if !binary.nodes.is_empty() {
            bvh.collapse(&binary, corners, ids, 0);
        }
        bvh
    }

    pub(crate) fn bytes(&self) -> u64 {
        (self.nodes.len() * size_of::<Node>() + self.leaves.len() * size_of::<Leaf>()) as u64
    }

    /// Makes a node of up to four descendants of a binary node, opening the largest first.
    fn collapse(&mut self, binary: &Bvh2, corners: &[[Vec3; 3]], ids: &[u32], root: u32) -> u32 {
        let mut members = vec![root];
        while members.len() < 4 {
            let area = |&i: &u32| binary.nodes[i as usize].aabb().half_area();
            let widest = (0..members.len())
                .filter(|&k| !binary.nodes[members[k] as usize].is_leaf())
                .max_by(|&a, &b| area(&members[a]).total_cmp(&area(&members[b])));
            let Some(widest) = widest else { break };
            let first = binary.nodes[members[widest] as usize].first_index;
            members[widest] = first;
            members.push(first + 1);
        }
        let index = self.nodes.len();
        self.nodes.push(Node::empty());
        for (lane, &member) in members.iter().enumerate() {
            let node = &binary.nodes[member as usize];
            let child = if node.is_leaf() {
                let range =
                    node.first_index as usize..(node.first_index + node.prim_count) as usize;
                self.leaves
                    .push(Leaf::new(&binary.primitive_indices[range], corners, ids));
                Child((self.leaves.len() - 1) as u32 | LEAF)
            } else {
                Child(self.collapse(binary, corners, ids, member))
            };
            self.nodes[index].set(lane, node.aabb(), child);
        }
        index as u32
    }

    /// Calls `visit` for triangles that the ray meets nearer than `limit`, nearer ones mostly first.
    ///
    /// `visit` returns the new limit; 0 ends the search.
    pub(crate) fn traverse(&self, ray: &Ray, limit: f32, mut visit: impl FnMut(Crossing) -> f32) {
        if !self.nodes.is_empty() {
            self.traverse_from(ray, Child(0), limit, &mut visit);
        }
    }

    fn traverse_from(
        &self,
        ray: &Ray,
        start: Child,
        mut limit: f32,
        visit: &mut impl FnMut(Crossing) -> f32,
    ) -> f32 {
        let mut stack = [(EMPTY, 0.0_f32); STACK];
        stack[0].0 = start;
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (child, near) = stack[height];
            if near >= limit {
                continue;
            }
            if child.0 & LEAF != 0 {
                limit = self.leaves[(child.0 & !LEAF) as usize].visit(ray, limit, visit);
                continue;
            }
            let node = &self.nodes[child.0 as usize];
            let (near, mut hits) = node.intersect(ray, limit);
            let near = near.to_array();
            let bottom = height;
            while hits != 0 {
                let lane = (hits.trailing_zeros() & 3) as usize;
                hits &= hits - 1;
                if height >= STACK {
                    limit = self.traverse_from(ray, node.children[lane], limit, visit);
                    continue;
                }
                // Farthest at the bottom, so that the nearest is taken next.
                let mut slot = height;
                while slot > bottom && stack[slot - 1].1 < near[lane] {
                    stack[slot] = stack[slot - 1];
                    slot -= 1;
                }
                stack[slot] = (node.children[lane], near[lane]);
                height += 1;
            }
        }
        limit
    }
}

impl Node {
    /// Boxes that no ray meets.
    fn empty() -> Self {
        let (low, high) = (Vec4::splat(f32::MAX), Vec4::splat(f32::MIN));
        Self {
            bounds: [low, low, low, high, high, high],
            children: [EMPTY; 4],
        }
    }

    fn set(&mut self, lane: usize, aabb: &Aabb, child: Child) {
        for axis in 0..3 {
            self.bounds[axis][lane] = aabb.min[axis] - ROOM;
            self.bounds[axis + 3][lane] = aabb.max[axis] + ROOM;
        }
        self.children[lane] = child;
    }

    /// Where the ray enters each box, and which boxes it meets, as bits.
    #[inline]
    fn intersect(&self, ray: &Ray, limit: f32) -> (Vec4, u32) {
        let mut near = Vec4::ZERO;
        let mut far = Vec4::splat(limit);
        for axis in 0..3 {
            let [entry, exit] = ray.slabs[axis];
            near = near.max((self.bounds[entry] - ray.origin4[axis]) * ray.inverse4[axis]);
            far = far.min((self.bounds[exit] - ray.origin4[axis]) * ray.inverse4[axis] * ROBUST);
        }
        (near, near.cmple(far).bitmask())
    }
}

impl Leaf {
    fn new(triangles: &[u32], corners: &[[Vec3; 3]], ids: &[u32]) -> Self {
        let corner_of = |lane: usize, corner: usize, axis: usize| {
            let triangle = triangles.get(lane);
            triangle.map_or(f32::NAN, |&t| corners[t as usize][corner][axis])
        };
        Self {
            corners: std::array::from_fn(|corner| {
                std::array::from_fn(|axis| {
                    Vec4::from_array(std::array::from_fn(|lane| corner_of(lane, corner, axis)))
                })
            }),
            triangles: std::array::from_fn(|lane| {
                triangles.get(lane).map_or(u32::MAX, |&t| ids[t as usize])
            }),
        }
    }

    /// The watertight test of Woop, Benthin and Wald 2013 ("Watertight Ray/Triangle Intersection",
    /// JCGT 2(1)): space is sheared so that the ray runs along +Z, where an edge shared by two
    /// triangles gives both the same edge function, so no ray passes between them.
    #[inline]
    fn visit(&self, ray: &Ray, mut limit: f32, visit: &mut impl FnMut(Crossing) -> f32) -> f32 {
        let [kx, ky, kz] = ray.axes;
        let mut x = [Vec4::ZERO; 3];
        let mut y = [Vec4::ZERO; 3];
        let mut z = [Vec4::ZERO; 3];
        for k in 0..3 {
            z[k] = self.corners[k][kz] - ray.origin4[kz];
            x[k] = self.corners[k][kx] - ray.origin4[kx] - z[k] * ray.shear.x;
            y[k] = self.corners[k][ky] - ray.origin4[ky] - z[k] * ray.shear.y;
        }
        let mut u = x[2] * y[1] - y[2] * x[1];
        let mut v = x[0] * y[2] - y[0] * x[2];
        let mut w = x[1] * y[0] - y[1] * x[0];
        let on_edge = u.cmpeq(Vec4::ZERO) | v.cmpeq(Vec4::ZERO) | w.cmpeq(Vec4::ZERO);
        if on_edge.any() {
            // On an edge the products must be exact to agree in sign from both sides.
            // Only in the lanes that need it: a triangle's answer must not depend on who shares
            // its leaf.
            u = Vec4::select(on_edge, exact_cross(x[2], y[1], y[2], x[1]), u);
            v = Vec4::select(on_edge, exact_cross(x[0], y[2], y[0], x[2]), v);
            w = Vec4::select(on_edge, exact_cross(x[1], y[0], y[1], x[0]), w);
        }
        let lowest = u.min(v).min(w);
        let highest = u.max(v).max(w);
        let inside = lowest.cmpge(Vec4::ZERO) | highest.cmple(Vec4::ZERO);
        if !inside.any() {
            return limit;
        }
        let det = u + v + w;
        let inverse = Vec4::ONE / det;
        let mut distance = (u * z[0] + v * z[1] + w * z[2]) * inverse * ray.shear.z;
        // Of a needle little is left of the products in `det`: where their rounding may have moved the triangle to
        // the other side of the ray's start, it is found again without.
        let largest = |of: &[Vec4; 3]| of[0].abs().max(of[1].abs()).max(of[2].abs());
        let products = largest(&x) * largest(&y) * largest(&z);
        let rounding = ROUNDINGS * products * inverse.abs() * ray.shear.z.abs();
        let doubtful = inside & distance.abs().cmple(rounding);
        if doubtful.any() {
            let exact = exact_distance(&x, &y, &z) * ray.shear.z;
            distance = Vec4::select(doubtful, exact, distance);
        }
        let meets = inside & distance.cmpgt(Vec4::ZERO) & distance.cmplt(Vec4::splat(limit));
        let mut hits = meets.bitmask();
        if hits == 0 {
            return limit;
        }
        let (distance, det) = (distance.to_array(), det.to_array());
        let (v, w) = ((v * inverse).to_array(), (w * inverse).to_array());
        while hits != 0 {
            let lane = (hits.trailing_zeros() & 3) as usize;
            hits &= hits - 1;
            if distance[lane] < limit {
                limit = visit(Crossing {
                    triangle: self.triangles[lane],
                    distance: distance[lane],
                    uv: [v[lane], w[lane]],
                    back: det[lane] < 0.0,
                });
            }
        }
        limit
    }
}

/// `a b − c d` rounded once.
#[cold]
fn exact_cross(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> Vec4 {
    cross(a, b, c, d).as_vec4()
}

/// The `z` at which triangles meet the axis x = y = 0, rounded once.
#[cold]
fn exact_distance(x: &[Vec4; 3], y: &[Vec4; 3], z: &[Vec4; 3]) -> Vec4 {
    let u = cross(x[2], y[1], y[2], x[1]);
    let v = cross(x[0], y[2], y[0], x[2]);
    let w = cross(x[1], y[0], y[1], x[0]);
    let sum = u * z[0].as_dvec4() + v * z[1].as_dvec4() + w * z[2].as_dvec4();
    (sum / (u + v + w)).as_vec4()
}

/// `a b − c d`, whose products are exact.
fn cross(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> DVec4 {
    a.as_dvec4() * b.as_dvec4() - c.as_dvec4() * d.as_dvec4()
}

/// A ray prepared for boxes and triangles.
pub(crate) struct Ray {
    origin4: [Vec4; 3],
    inverse4: [Vec4; 3],
    /// Rows of [`Node::bounds`] where the ray enters and leaves, by axis.
    slabs: [[usize; 2]; 3],
    axes: [usize; 3],
    shear: Vec3A,
}

impl Ray {
    /// `direction` has unit length: distances are counted in it.
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        // A finite stand-in for 1/0 keeps 0 × ∞ out of the slab test.
        let inverse = direction.to_array().map(|d| {
            1.0 / if d.abs() < 1e-20 {
                1e-20_f32.copysign(d)
            } else {
                d
            }
        });
        Self {
            origin4: origin.to_array().map(Vec4::splat),
            inverse4: inverse.map(Vec4::splat),
            slabs: std::array::from_fn(|axis| {
                if inverse[axis] < 0.0 {
                    [axis + 3, axis]
                } else {
                    [axis, axis + 3]
                }
            }),
            axes: [x, y, z],
            shear: Vec3A::new(direction[x], direction[y], 1.0) / direction[z],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::sampling::{cosine_hemisphere, frame, sobol};

    fn bvh_of(corners: &[[Vec3; 3]]) -> Bvh {
        let ids: Vec<u32> = (0..corners.len() as u32).collect();
        Bvh::new(corners, &ids, BvhQuality::Best)
    }

    fn nearest(bvh: &Bvh, origin: Vec3, direction: Vec3) -> Option<Crossing> {
        let mut best: Option<Crossing> = None;
        bvh.traverse(&Ray::new(origin, direction), f32::INFINITY, |c| {
            best = Some(c);
            c.distance
        });
        best
    }

    /// A direction of any way from two numbers in 0..1.
    fn anywhere(u: f32, v: f32, flip: bool) -> Vec3 {
        let d = frame(Vec3::new(0.3, -0.5, 0.8).normalize()) * cosine_hemisphere(u, v);
        if flip { -d } else { d }
    }

    /// A sphere of flat triangles, wound to face outwards.
    fn sphere(n: u32, radius: f32) -> Vec<[Vec3; 3]> {
        let point = |i: u32, j: u32| {
            let (theta, phi) = (
                std::f32::consts::PI * i as f32 / n as f32,
                std::f32::consts::TAU * (j % (2 * n)) as f32 / (2 * n) as f32,
            );
            // Poles in one point each, the seam in one line.
            let ring = if i == 0 || i == n { 0.0 } else { theta.sin() };
            Vec3::new(ring * phi.cos(), theta.cos(), ring * phi.sin()) * radius
        };
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..2 * n {
                let (a, b, c, d) = (
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                );
                if i > 0 {
                    triangles.push([a, c, d]);
                }
                if i + 1 < n {
                    triangles.push([a, b, c]);
                }
            }
        }
        triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()
    }

    #[test]
    fn front_and_back_follow_the_winding() {
        let bvh = bvh_of(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
        for (from, way, back) in [(1.0, -1.0, false), (-1.0, 1.0, true)] {
            let hit = nearest(&bvh, Vec3::new(0.2, 0.3, from), Vec3::Z * way).unwrap();
            assert_eq!(hit.back, back);
            assert!((hit.distance - 1.0).abs() < 1e-6);
            assert!((hit.uv[0] - 0.2).abs() < 1e-6 && (hit.uv[1] - 0.3).abs() < 1e-6);
        }
        assert!(nearest(&bvh, Vec3::new(0.6, 0.6, 1.0), -Vec3::Z).is_none());
        assert!(nearest(&bvh, Vec3::new(0.2, 0.2, 1.0), Vec3::Z).is_none());
    }

    #[test]
    fn every_ray_agrees_with_trying_all_triangles() {
        let mut corners = sphere(12, 700.0);
        corners.extend(
            sphere(9, 300.0)
                .into_iter()
                .map(|t| t.map(|p| p + Vec3::new(100.0, 50.0, -80.0))),
        );
        let bvh = bvh_of(&corners);
        let singles: Vec<Bvh> = corners.iter().map(|t| bvh_of(&[*t])).collect();
        for i in 0..2_000 {
            let [u, v, s, t] = sobol(i, 0, 1);
            let origin = Vec3::new(u - 0.5, v - 0.5, s - 0.5) * 1200.0;
            let direction = anywhere(t, u, i % 2 == 0);
            let expected = singles
                .iter()
                .filter_map(|one| nearest(one, origin, direction))
                .map(|c| c.distance)
                .fold(f32::INFINITY, f32::min);
            let found = nearest(&bvh, origin, direction).map_or(f32::INFINITY, |c| c.distance);
            assert_eq!(found, expected, "ray {i}");
        }
    }

    /// A cube of 12 triangles, whose diagonals and edges are lines along axes and between them.
    fn cube(half: f32) -> Vec<[Vec3; 3]> {
        let face = |axis: usize, side: f32| {
            let (n, u) = (Vec3::AXES[axis] * side, Vec3::AXES[(axis + 1) % 3]);
            let v = Vec3::AXES[axis].cross(u);
            let corner = |a: f32, b: f32| (n + u * a + v * b) * half;
            let [p, q, r, s] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let [p, q, r, s] = [p, q, r, s].map(|(a, b)| corner(a, b));
            [[p, q, r], [p, r, s]]
        };
        (0..6)
            .flat_map(|f| face(f / 2, 1.0 - 2.0 * (f % 2) as f32))
            .collect()
    }

    /// How many rays from inside a closed surface get out. Every third aims at a corner and every
    /// third at an edge, where cracks would be.
    fn leaks(corners: &[[Vec3; 3]], reach: f32, rays: u32) -> u32 {
        let bvh = bvh_of(corners);
        let leaks = |i: &u32| {
            let [u, v, s, t] = sobol(*i, 0, 5);
            let origin = (Vec3::new(u, v, s) - 0.5) * 2.0 * reach;
            let triangle = corners[(i / 3) as usize % corners.len()];
            let direction = match i % 3 {
                0 => (triangle[0] - origin).normalize(),
                1 => (triangle[0].lerp(triangle[1], t) - origin).normalize(),
                _ => anywhere(t, u, i.is_multiple_of(2)),
            };
            nearest(&bvh, origin, direction).is_none()
        };
        (0..rays).filter(leaks).count() as u32
    }

    #[test]
    fn closed_surfaces_are_watertight() {
        assert_eq!(leaks(&sphere(24, 1000.0), 450.0, 1_000_000), 0);
        assert_eq!(leaks(&cube(1000.0), 999.0, 1_000_000), 0);
    }

    /// None of 10⁸ rays gets out of either.
    #[test]
    #[ignore = "takes most of a minute"]
    fn closed_surfaces_are_watertight_to_many_rays() {
        assert_eq!(leaks(&sphere(24, 1000.0), 450.0, 100_000_000), 0);
        assert_eq!(leaks(&cube(1000.0), 999.0, 100_000_000), 0);
    }

    /// A strip 50,000 times as long as it is high: rays that start close to it meet it, and those that leave it, to
    /// either side, do not.
    #[test]
    fn strips_are_on_the_right_side_of_rays() {
        let corner = |y: f32, z: f32| Vec3::new(-1000.0, y, z);
        let (a, b) = (corner(0.0, -1024.0), corner(0.0, -512.0));
        let (c, d) = (corner(0.01, -512.0), corner(0.01, -1024.0));
        let bvh = bvh_of(&[[a, b, c], [a, c, d]]);
        let mut tried = 0;
        for i in 0..3_000_000 {
            let [u, v, s, _] = sobol(i, 0, 3);
            let [gap, rise, ..] = sobol(i, 1, 3);
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let above = side * 6.2e-5 * 16_000_f32.powf(gap);
            let origin = Vec3::new(-1000.0 + above, 0.01 * rise, -1000.0 + 470.0 * s);
            let way = frame(Vec3::X * -side) * cosine_hemisphere(u, v * 0.999);
            let distance = (-1000.0 - origin.x) / way.x;
            let [y, z] = [1, 2].map(|axis| origin[axis] + distance * way[axis]);
            // Not within the rounding of an edge.
            if (0.001..0.009).contains(&y) && (-1020.0..-516.0).contains(&z) {
                tried += 1;
                let found = nearest(&bvh, origin, way).map_or(f32::NAN, |hit| hit.distance);
                assert!((found - distance).abs() < 0.3, "{i}: {found}, {distance}");
                assert!(nearest(&bvh, origin, -way).is_none(), "{i}: {distance}");
            }
        }
        assert!(tried > 100_000, "{tried}");
    }

    #[test]
    fn axis_aligned_rays_meet_flat_boxes() {
        let wall = |z: f32| {
            [[
                Vec3::new(-9.0, -9.0, z),
                Vec3::new(9.0, -9.0, z),
                Vec3::new(0.0, 9.0, z),
            ]; 1]
        };
        let corners: Vec<[Vec3; 3]> = (0..40).flat_map(|i| wall(i as f32)).collect();
        let bvh = bvh_of(&corners);
        for i in 0..39 {
            let hit = nearest(&bvh, Vec3::new(0.0, 0.0, i as f32 + 0.5), Vec3::Z).unwrap();
            assert_eq!(hit.triangle, i + 1);
            let hit = nearest(&bvh, Vec3::new(0.0, 0.0, i as f32 + 0.5), -Vec3::Z).unwrap();
            assert_eq!(hit.triangle, i);
        }
    }

    /// Boxes end where neighbours begin: at lines of a lattice, in the last face of one and the first of the next.
    #[test]
    fn rays_in_the_faces_of_boxes_meet_what_is_there() {
        let at = |x: u32, y: u32| Vec3::new(x as f32, y as f32, 0.0);
        let quads = (0..16).flat_map(|y| (0..16).map(move |x| (x, y)));
        let corners: Vec<_> = quads
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let bvh = bvh_of(&corners);
        for (x, y) in (0..=64).flat_map(|y| (0..=64).map(move |x| (x, y))) {
            let from = Vec3::new(0.25 * x as f32, 0.25 * y as f32, 1.0);
            assert!(nearest(&bvh, from, -Vec3::Z).is_some(), "{from}");
        }
    }

    #[test]
    fn thousands_of_triangles_at_one_place_do_not_exhaust_the_stack() {
        let corners = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 5000];
        let hit = nearest(&bvh_of(&corners), Vec3::new(0.2, 0.2, 1.0), -Vec3::Z);
        assert!(hit.is_some());
    }
}
