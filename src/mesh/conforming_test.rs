use std::collections::{HashMap, HashSet};

use proptest::prelude::*;

use super::*;
use crate::mesh::part::Origin;
use crate::mesh::refined::blend;
use crate::mesh::test_meshes::{Mesh, cube, grid, random, soup, unshared};

const FREE: Limits = Limits {
    max_vertices: usize::MAX,
    max_faces: usize::MAX,
    min_edge: 0.0,
};

fn part(mesh: &Mesh) -> Part<'_> {
    Part {
        positions: &mesh.0,
        triangles: &mesh.1,
        refine: true,
    }
}

/// A face after refinement.
struct Piece {
    part: usize,
    source: [Vec3; 3],
    corners: [Vec3; 3],
    /// Places of the corners, as far as positions tell.
    places: [u32; 3],
}

/// Meshes under refinement, and what was told of it.
struct Trial<'a> {
    parts: Vec<Part<'a>>,
    tolerance: f32,
    mesh: Conforming,
    log: Vec<Bisection>,
}

impl<'a> Trial<'a> {
    fn new(parts: &[Part<'a>], tolerance: f32) -> Self {
        Self {
            parts: parts.to_vec(),
            tolerance,
            mesh: Conforming::new(parts, tolerance),
            log: Vec::new(),
        }
    }

    fn of(meshes: &'a [Mesh]) -> Self {
        Self::new(&meshes.iter().map(part).collect::<Vec<Part>>(), 0.0)
    }

    fn bisect(&mut self, face: u32, limits: &Limits) -> Bisected {
        let log = &mut self.log;
        self.mesh.bisect(face, limits, &mut |cut| log.push(cut))
    }

    /// Asks for faces at random.
    fn refine(&mut self, count: usize, seed: u32, limits: &Limits) {
        let mut random = random(seed);
        for _ in 0..count {
            let face = (random() * self.mesh.faces() as f32) as u32 % self.mesh.faces();
            self.bisect(face, limits);
            assert!(self.mesh.vertex_count() <= limits.max_vertices.max(self.given_vertices()));
        }
    }

    fn given_vertices(&self) -> usize {
        Conforming::new(&self.parts, self.tolerance).vertex_count()
    }

    fn positions(&self) -> Vec<Vec<Vec3>> {
        let refined = self.mesh.parts();
        (self.parts.iter().zip(&refined))
            .map(|(part, refined)| refined.mesh.positions(part.positions, part.triangles))
            .collect()
    }

    /// The place of each vertex, part by part: found from positions, not from nodes.
    fn places(&self) -> Vec<Vec<u32>> {
        let positions = self.positions();
        // Midpoints of ends that are a tolerance apart may be that and some rounding apart.
        let classes =
            PositionClasses::new(positions.iter().flatten().copied(), 2.0 * self.tolerance);
        let mut rest = classes.class.into_iter();
        (positions.iter())
            .map(|part| rest.by_ref().take(part.len()).collect())
            .collect()
    }

    /// All faces but those without area.
    fn pieces(&self) -> Vec<Piece> {
        let (positions, places) = (self.positions(), self.places());
        let mut pieces = Vec::new();
        for (part, refined) in self.mesh.parts().into_iter().enumerate() {
            let given = self.parts[part];
            for (corners, source) in refined.mesh.triangles.iter().zip(refined.mesh.sources) {
                let source = given.triangles[source as usize].map(|v| given.positions[v as usize]);
                let thin = f64::from(self.tolerance) * length(source[0], source[1]);
                if area(source).length() > thin {
                    pieces.push(Piece {
                        part,
                        source,
                        corners: corners.map(|v| positions[part][v as usize]),
                        places: corners.map(|v| places[part][v as usize]),
                    });
                }
            }
        }
        pieces
    }

    fn check(&self) {
        self.assert_no_t_junctions();
        self.assert_same_surface();
        self.assert_log_replays();
    }

    /// An edge that was cut for one face must not be left to another; and what was a border is
    /// one, and nothing else.
    fn assert_no_t_junctions(&self) {
        let places = self.places();
        let mut cut = HashSet::new();
        for (part, refined) in self.mesh.parts().iter().enumerate() {
            for origin in &refined.origins {
                if let Origin::Between(ends) = origin {
                    cut.insert(sorted(ends.map(|end| places[part][end as usize])));
                }
            }
        }
        for piece in self.pieces() {
            for i in 0..3 {
                let edge = sorted([piece.places[i], piece.places[(i + 1) % 3]]);
                assert!(!cut.contains(&edge), "T-junction: {:?}", piece.corners);
            }
        }
        let (before, after) = (
            Self::new(&self.parts, self.tolerance).border(),
            self.border(),
        );
        assert!((before - after).abs() <= 1e-5 * before, "{before} {after}");
    }

    /// How long the edges with one face are together.
    fn border(&self) -> f64 {
        let mut edges: HashMap<[u32; 2], (usize, f64)> = HashMap::new();
        for piece in self.pieces() {
            for i in 0..3 {
                let j = (i + 1) % 3;
                let edge = edges.entry(sorted([piece.places[i], piece.places[j]]));
                edge.or_insert((0, length(piece.corners[i], piece.corners[j])))
                    .0 += 1;
            }
        }
        let single = edges.values().filter(|edge| edge.0 == 1);
        single.map(|edge| edge.1).sum()
    }

    /// Areas, winding and half of the smallest angle stay.
    fn assert_same_surface(&self) {
        let mut areas = vec![0.0; self.parts.len()];
        for piece in self.pieces() {
            assert!(area(piece.corners).dot(area(piece.source)) > 0.0);
            let (angle, given) = (min_angle(piece.corners), min_angle(piece.source));
            assert!(angle >= 0.5 * given - 1e-3, "{angle} of {given}");
            areas[piece.part] += area(piece.corners).length();
        }
        for (part, after) in self.parts.iter().zip(areas) {
            let corners = |t: &[u32; 3]| t.map(|v| part.positions[v as usize]);
            let before = (part.triangles.iter()).map(|t| area(corners(t)).length());
            let before: f64 = before.sum();
            // What lies in faces lower than the tolerance is not counted.
            let slack = 1e-5 * before + 10.0 * f64::from(self.tolerance);
            assert!((before - after).abs() <= slack, "{before} {after}");
        }
    }

    /// What was told is all that happened.
    fn assert_log_replays(&self) {
        let fresh = Conforming::new(&self.parts, self.tolerance);
        let mut faces: Vec<(u32, [u32; 3])> = (0..fresh.faces())
            .map(|face| (fresh.part(face), fresh.vertices(face)))
            .collect();
        let mut midpoints = HashMap::new();
        for (part, refined) in (0..).zip(self.mesh.parts()) {
            for (vertex, origin) in (0..).zip(refined.origins) {
                if let Origin::Between(ends) = origin {
                    assert!(ends[0] < ends[1] && ends[1] < vertex);
                    assert_eq!(midpoints.insert((part, ends), vertex), None);
                }
            }
        }
        for cut in &self.log {
            let (part, mut face) = faces[cut.face as usize];
            let mut half = face;
            let (i, j) = (usize::from(cut.edge), usize::from(cut.edge + 1) % 3);
            let midpoint = midpoints[&(part, sorted([face[i], face[j]]))];
            (face[j], half[i]) = (midpoint, midpoint);
            faces[cut.face as usize].1 = face;
            assert_eq!(cut.half as usize, faces.len());
            faces.push((part, half));
        }
        let found = (0..self.mesh.faces()).map(|f| (self.mesh.part(f), self.mesh.vertices(f)));
        assert!(found.eq(faces));
    }

    /// How many different positions there are, to the last bit.
    fn distinct_positions(&self) -> usize {
        let positions = self.positions();
        PositionClasses::new(positions.into_iter().flatten(), 0.0)
            .representative
            .len()
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn length(a: Vec3, b: Vec3) -> f64 {
    a.as_dvec3().distance(b.as_dvec3())
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

fn moved(mesh: &Mesh, by: Vec3) -> Mesh {
    let positions = mesh.0.iter().map(|&p| p + by).collect();
    (positions, mesh.1.clone())
}

#[test]
fn hard_edges_and_seams_stay_closed() {
    for mesh in [cube(), unshared(&cube()), grid(7, 5), unshared(&grid(7, 5))] {
        let meshes = [moved(&mesh, Vec3::new(0.3, 0.1, 0.7))];
        let mut trial = Trial::of(&meshes);
        trial.refine(400, 1, &FREE);
        trial.check();
        // A vertex has one position to the bit on both sides of an edge: as many as there are nodes.
        assert_eq!(trial.distinct_positions(), trial.mesh.nodes.len());
    }
}

#[test]
fn edges_cut_anywhere_stay_closed() {
    for mesh in [cube(), unshared(&cube()), grid(7, 5), unshared(&grid(7, 5))] {
        let meshes = [moved(&mesh, Vec3::new(0.3, 0.1, 0.7))];
        let mut trial = Trial::of(&meshes);
        let (mut random, mut done) = (random(3), 0);
        for _ in 0..200 {
            let face = (random() * trial.mesh.faces() as f32) as u32 % trial.mesh.faces();
            let (edge, at) = ((3.0 * random()) as u8 % 3, 0.02 + 0.96 * random());
            let log = &mut trial.log;
            let told = &mut |cut| log.push(cut);
            let cut = trial.mesh.cut_edge((face, edge), at, &FREE, told);
            done += u32::from(cut == Bisected::Done);
            trial.bisect(face, &FREE);
        }
        // All but pieces too short to tell apart.
        assert!(done > 150, "{done}");
        trial.assert_no_t_junctions();
        trial.assert_log_replays();
        assert_eq!(trial.distinct_positions(), trial.mesh.nodes.len());
        // Where it was asked for: a cut at a quarter of the first edge of the first face.
        let mut whole = Trial::of(&meshes);
        let [a, b, _] = whole.mesh.corners(0);
        let mut cut = None;
        whole
            .mesh
            .cut_edge((0, 0), 0.25, &FREE, &mut |c| cut = cut.or(Some(c)));
        assert_eq!(cut.map(|c| (c.face, c.edge, c.at)), Some((0, 0, 0.25)));
        assert!(whole.mesh.corners(0)[1].distance(a.lerp(b, 0.25)) < 1e-6);
    }
}

#[test]
fn a_neighbour_with_its_own_vertices_follows() {
    let meshes = [grid(3, 3), moved(&unshared(&grid(2, 3)), Vec3::X * 3.0)];
    let mut trial = Trial::of(&meshes);
    let mut random = random(2);
    for _ in 0..300 {
        let face = (random() * trial.mesh.faces() as f32) as u32;
        if trial.mesh.part(face) == 0 {
            assert_eq!(trial.bisect(face, &FREE), Bisected::Done);
        }
    }
    trial.check();
    let refined = trial.mesh.clone().into_parts();
    assert!(refined[1].mesh.triangles.len() > meshes[1].1.len() + 10);
    assert_eq!(trial.distinct_positions(), trial.mesh.nodes.len());
}

#[test]
fn meshes_on_one_another_are_cut_alike() {
    let meshes = [cube(), unshared(&cube()), cube()];
    let mut trial = Trial::of(&meshes);
    trial.refine(200, 5, &FREE);
    trial.check();
    let refined = trial.mesh.parts();
    let count = refined[0].mesh.triangles.len();
    assert!(count > 100 && refined.iter().all(|r| r.mesh.triangles.len() == count));
}

#[test]
fn all_faces_of_a_fan_are_cut_together() {
    let mut positions = vec![Vec3::ZERO, Vec3::Z * 4.0];
    positions.extend((0..7).map(|i| {
        let (sin, cos) = (i as f32).sin_cos();
        Vec3::new(cos, sin, 2.0 + 0.1 * i as f32)
    }));
    let meshes = [(positions, (2..9).map(|i| [0, 1, i]).collect())];
    let mut trial = Trial::of(&meshes);
    assert_eq!(trial.bisect(3, &FREE), Bisected::Done);
    assert_eq!((trial.mesh.faces(), trial.mesh.vertex_count()), (14, 10));
    trial.refine(200, 3, &FREE);
    trial.check();
}

#[test]
fn faces_without_area_stay_and_hinder_nobody() {
    let mut mesh = grid(2, 2);
    let along = mesh.0.len() as u32;
    mesh.0.push(Vec3::new(0.5, 0.5, 0.0));
    mesh.1.insert(1, [0, 0, 1]);
    mesh.1.push([4, 4, 4]);
    mesh.1.push([0, 4, along]);
    let meshes = [mesh];
    let mut trial = Trial::of(&meshes);
    for face in [1, 9, 10] {
        assert_eq!(trial.bisect(face, &FREE), Bisected::Refused);
    }
    for face in 2..9 {
        assert_eq!(trial.bisect(face, &FREE), Bisected::Done);
    }
    trial.refine(100, 4, &FREE);
    trial.check();
    let refined = &trial.mesh.parts()[0].mesh;
    for source in [1, 9, 10] {
        assert_eq!(refined.sources.iter().filter(|&&s| s == source).count(), 1);
    }
}

#[test]
fn parts_that_may_not_be_cut_keep_their_edges() {
    let meshes = [grid(4, 4), moved(&grid(4, 4), Vec3::X * 4.0)];
    let parts = [0, 1].map(|i| Part {
        refine: i == 0,
        ..part(&meshes[i])
    });
    let mut trial = Trial::new(&parts, 0.0);
    trial.refine(500, 6, &FREE);
    trial.check();
    let refined = trial.mesh.parts();
    assert_eq!(refined[1].mesh.triangles, meshes[1].1);
    assert_eq!(refined[1].mesh.vertices.len(), meshes[1].0.len());
    assert!(refined[0].mesh.triangles.len() > 400);
}

#[test]
fn short_edges_are_not_cut() {
    let meshes = [soup(9, 30, 7)];
    let mut trial = Trial::of(&meshes);
    let limits = Limits {
        min_edge: 0.25,
        ..FREE
    };
    while (0..trial.mesh.faces()).any(|face| trial.bisect(face, &limits) == Bisected::Done) {}
    trial.check();
    for piece in trial.pieces() {
        let [a, b, c] = piece.corners;
        let longest = length(a, b).max(length(b, c)).max(length(c, a));
        assert!(longest < 0.5);
    }
    for (part, refined) in trial.positions().iter().zip(trial.mesh.parts()) {
        for origin in refined.origins {
            if let Origin::Between([a, b]) = origin {
                assert!(length(part[a as usize], part[b as usize]) >= 0.5 - 1e-6);
            }
        }
    }
}

#[test]
fn refinement_ends_where_floats_do() {
    // Neighbouring floats are 2 mm apart here, and sixteen of the largest coordinate 31 mm.
    let at = Vec3::splat(16_384.0);
    let meshes = [(vec![at, at + Vec3::X, at + Vec3::Y * 0.7], vec![[0, 1, 2]])];
    let mut trial = Trial::of(&meshes);
    while (0..trial.mesh.faces()).any(|face| trial.bisect(face, &FREE) == Bisected::Done) {
        assert!(trial.mesh.faces() < 100_000);
    }
    assert!(trial.mesh.faces() > 1000);
    assert_eq!(trial.distinct_positions(), trial.mesh.nodes.len());
    trial.assert_log_replays();
}

#[test]
fn requests_cut_few_faces() {
    let meshes = [grid(30, 30)];
    let mut trial = Trial::of(&meshes);
    trial.refine(20_000, 8, &FREE);
    // One face needs its neighbour, so two are the least. Asking for faces at random makes the
    // worst grading there is.
    let mean = trial.log.len() as f64 / 20_000.0;
    assert!((2.0..4.5).contains(&mean), "{mean}");
}

#[test]
fn refinements_compose() {
    let (positions, triangles) = cube();
    let flat = crate::mesh::split_flat_corners(&positions, &triangles);
    let meshes = [(
        flat.positions(&positions, &triangles),
        flat.triangles.clone(),
    )];
    let mut trial = Trial::of(&meshes);
    trial.refine(100, 9, &FREE);
    let refined = trial.mesh.parts().remove(0).mesh;
    let both = flat.then(&triangles, &refined);
    assert_eq!(both.positions(&positions, &triangles), trial.positions()[0]);

    let corners = refined.triangles.as_slice();
    let again_meshes = [(trial.positions().remove(0), corners.to_vec())];
    let mut again = Trial::of(&again_meshes);
    again.refine(100, 10, &FREE);
    let twice = refined.then(&meshes[0].1, &again.mesh.parts()[0].mesh);
    let found = twice.positions(&meshes[0].0, &meshes[0].1);
    for (a, b) in found.iter().zip(&again.positions()[0]) {
        assert!(length(*a, *b) < 1e-6);
    }
}

#[test]
fn faces_know_where_they_lie() {
    let meshes = [soup(9, 40, 3), unshared(&cube())];
    let mut trial = Trial::of(&meshes);
    trial.refine(200, 11, &FREE);
    for face in 0..trial.mesh.faces() {
        let (positions, triangles) = &meshes[trial.mesh.part(face) as usize];
        let source = triangles[trial.mesh.source(face) as usize];
        let [a, b, c] = source.map(|v| positions[v as usize]);
        let weights = trial.mesh.barycentrics(face);
        let corners = weights.map(|w| blend(a, b, c, w));
        assert_eq!(corners, trial.mesh.corners(face));
    }
}

#[test]
fn unused_vertices_go_and_given_ones_come_first() {
    let positions = vec![Vec3::X, Vec3::splat(9.0), Vec3::ZERO, Vec3::Y];
    let meshes = [(positions, vec![[3, 2, 0]])];
    let mut trial = Trial::of(&meshes);
    assert_eq!(trial.mesh.vertex_count(), 3);
    assert_eq!(trial.bisect(0, &FREE), Bisected::Done);
    let given = [0, 2, 3].map(Origin::Given);
    let refined = trial.mesh.clone().into_parts();
    assert_eq!(refined, trial.mesh.parts());
    assert_eq!(refined[0].origins[..3], given);
    assert_eq!(refined[0].origins[3..], [Origin::Between([0, 2])]);
    assert_eq!(refined[0].mesh.triangles, [[3, 1, 0], [2, 1, 3]]);
}

#[test]
fn a_million_bisections_take_seconds() {
    let meshes = [grid(100, 100)];
    let mut mesh = Conforming::new(&[part(&meshes[0])], 0.0);
    let mut random = random(3);
    let start = std::time::Instant::now();
    let mut cuts = 0;
    while cuts < 1_000_000 {
        let face = (f64::from(random()) * f64::from(mesh.faces())) as u32;
        mesh.bisect(face, &FREE, &mut |_| cuts += 1);
    }
    // Looking for neighbours among all faces would take hours.
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Meshes of all kinds, welded exactly or with some noise, refined in any order.
    #[test]
    fn nothing_tears(
        seed in any::<u32>(),
        points in 5_u32..30,
        triangles in 1_usize..10,
        noise in prop::sample::select(vec![0.0_f32, 2e-6]),
        refine in prop::collection::vec(prop::bool::weighted(0.8), 3),
        requests in 1_usize..150,
        room in prop::option::of(0_usize..200),
    ) {
        let base = soup(points, triangles, seed);
        let mut next = random(seed);
        let mut noisy = |mesh: &Mesh| -> Mesh {
            let shaken = |p: &Vec3| *p + noise * (Vec3::new(next(), next(), next()) - 0.5);
            (mesh.0.iter().map(shaken).collect(), mesh.1.clone())
        };
        let half = (base.0.clone(), base.1[..triangles / 2].to_vec());
        let meshes = [noisy(&base), noisy(&unshared(&half)), noisy(&soup(points, 2, seed))];
        let parts: Vec<Part> = (meshes.iter().zip(&refine))
            .map(|(mesh, &refine)| Part { refine, ..part(mesh) })
            .collect();
        let mut trial = Trial::new(&parts, 2.0 * noise);
        let limits = Limits {
            max_vertices: room.map_or(usize::MAX, |room| trial.given_vertices() + room),
            max_faces: usize::MAX,
            min_edge: 0.02,
        };
        trial.refine(requests, seed, &limits);
        trial.check();
        for (i, refined) in trial.mesh.parts().iter().enumerate() {
            if !refine[i] {
                prop_assert_eq!(refined.mesh.triangles.len(), meshes[i].1.len());
            }
        }
        let mut again = Trial::new(&parts, 2.0 * noise);
        again.refine(requests, seed, &limits);
        prop_assert_eq!(&again.log, &trial.log);
        prop_assert_eq!(again.mesh.into_parts(), trial.mesh.into_parts());
    }
}
