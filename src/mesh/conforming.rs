use glam::Vec3;

use super::refined::{RefinedMesh, SurfacePoint, blend};
use super::weld::PositionClasses;

/// How often a face may be halved. Positions run out of bits at about the same depth; that this
/// one is a number proves that a request ends, however positions are rounded.
const MAX_DEPTH: u8 = 40;

/// Sides of faces are numbered with 32 bits, three a face.
const MAX_FACES: usize = (u32::MAX / 3) as usize;

/// A mesh that is refined together with others.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Of its vertices; finite.
    pub positions: &'a [Vec3],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// Whether its triangles may be cut at all.
    ///
    /// If not, nobody cuts the edges they have either. A mesh that others need not match is
    /// better left out: a face waits for ever if its longest edge may not be cut, and so do the
    /// neighbours that wait for that face.
    pub refine: bool,
}

/// How far [`Conforming::bisect`] may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of all parts together, as [`Conforming::vertex_count`] counts them.
    pub max_vertices: usize,
    /// No edge is cut into halves shorter than this.
    pub min_edge: f32,
}

/// One bisection that was done: `face` keeps its number and became the half with the corners
/// before the cut; `half` is the new face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bisection {
    /// The face that was cut.
    pub face: u32,
    /// The new face: always the next number.
    pub half: u32,
    /// Which edge was cut, by its corners in `face` as it was: `edge` and `(edge + 1) % 3`.
    /// In `face` the corner `(edge + 1) % 3` is replaced by the midpoint, in `half` the corner `edge`.
    pub edge: u8,
}

/// What became of a request to bisect a face.
///
/// If it was not done, the face is as it was. Neighbours with longer edges may have been cut on
/// the way to it, and were told of: each of them with all faces at its edge, so the mesh is as
/// conforming as ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bisected {
    /// It was cut, with what conformity asks for.
    Done,
    /// It, or a neighbour that would have to be cut with it, may not be cut, or its longest edge
    /// is below the limit.
    Refused,
    /// There would be too many vertices.
    Full,
}

/// Where a vertex of a refined part comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A vertex of the part as given.
    Given(u32),
    /// The midpoint of two vertices of the refined part, the lower number first. Both are lower
    /// than the number of the midpoint.
    Midpoint([u32; 2]),
}

/// One part, refined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Used vertices of the part as given come first, in their order, then midpoints in order of
    /// making. Triangles are in the order of their sources.
    pub mesh: RefinedMesh,
    /// Of each vertex.
    pub origins: Vec<Origin>,
}

/// Several meshes refined together by longest-edge bisection: see the [module](super) for why.
///
/// Vertices of all parts at one place are one node, and an edge is a pair of nodes. Whatever
/// faces have an edge, two or one or many, of one part or of several, are cut together when it
/// is cut, each into two. So there are no T-junctions but those given.
///
/// Faces are numbered through all parts, in the order given, and keep their numbers; halves are
/// added behind.
#[derive(Clone, Debug)]
pub struct Conforming {
    sheets: Vec<Sheet>,
    faces: Vec<Face>,
    /// Where they are; lengths are measured between these, so that all faces agree.
    nodes: Vec<Vec3>,
    vertex_count: usize,
    /// Rounded positions do not tell the halves of shorter edges well.
    shortest: f64,
}

/// A part.
#[derive(Clone, Debug)]
struct Sheet {
    /// The triangles as given, in numbers of used vertices.
    triangles: Vec<[u32; 3]>,
    vertices: Vec<SurfacePoint>,
    origins: Vec<Origin>,
    positions: Vec<Vec3>,
    nodes: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Face {
    part: u32,
    source: u32,
    vertices: [u32; 3],
    /// Of the corners, on the source triangle.
    barycentrics: [Vec3; 3],
    /// Of each side, the next side at the same edge. Sides at an edge form a ring (K. Weiler,
    /// "Edge-based data structures for solid modeling in curved-surface environments", 1985).
    /// Side `i` goes from corner `i` to the next, and has the number `3 · face + i`.
    next: [u32; 3],
    /// The side to be cut; `None` for a face that is never cut.
    longest: Option<u8>,
    depth: u8,
}

/// A side of the edge that is being cut.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Wing {
    part: u32,
    /// Vertices, the lower one first.
    ends: [u32; 2],
    side: u32,
}

impl Conforming {
    /// Welds vertices at most `tolerance` apart, which should be a few units in the last place.
    ///
    /// Faces that have two corners in one node or are no higher than `tolerance` are never cut,
    /// and keep nobody from cutting their edges.
    ///
    /// # Panics
    ///
    /// If a triangle has a vertex that does not exist, or there are 2³² / 3 triangles or more.
    pub fn new(parts: &[Part], tolerance: f32) -> Self {
        let mut sheets: Vec<Sheet> = parts.iter().map(Sheet::new).collect();
        let positions = sheets.iter().flat_map(|sheet| sheet.positions.iter());
        let classes = PositionClasses::new(positions.copied(), tolerance);
        let mut rest = classes.class.as_slice();
        for sheet in &mut sheets {
            let (nodes, others) = rest.split_at(sheet.positions.len());
            sheet.nodes = nodes.to_vec();
            rest = others;
        }
        let largest = (classes.representative.iter())
            .map(|p| p.abs().max_element())
            .fold(0.0, f32::max);
        let mut conforming = Self {
            sheets,
            faces: Vec::new(),
            nodes: classes.representative,
            vertex_count: classes.class.len(),
            // `blend` rounds by up to three units of 2⁻²⁴ of the largest coordinate.
            shortest: 16.0 * f64::from(f32::EPSILON) * f64::from(largest),
        };
        conforming.add_faces(parts, f64::from(tolerance));
        conforming
    }

    fn add_faces(&mut self, parts: &[Part], tolerance: f64) {
        let count: usize = parts.iter().map(|part| part.triangles.len()).sum();
        assert!(count <= MAX_FACES, "too many triangles for 32-bit sides");
        self.faces.reserve_exact(count);
        let mut sides = Vec::with_capacity(3 * count);
        for (part, given) in parts.iter().enumerate() {
            for source in 0..given.triangles.len() {
                let first = 3 * self.faces.len() as u32;
                let mut face = Face {
                    part: part as u32,
                    source: source as u32,
                    vertices: self.sheets[part].triangles[source],
                    barycentrics: Vec3::AXES,
                    next: [first, first + 1, first + 2],
                    longest: None,
                    depth: 0,
                };
                if self.is_proper(&face, tolerance) {
                    let nodes = self.nodes_of(&face);
                    sides.extend((0..3).map(|i| {
                        let [a, b] = [nodes[i], nodes[(i + 1) % 3]];
                        ([a.min(b), a.max(b)], first + i as u32)
                    }));
                    if given.refine {
                        face.longest = Some(self.longest(&face));
                    }
                }
                self.faces.push(face);
            }
        }
        self.link(&mut sides);
    }

    /// How many faces there are.
    pub fn faces(&self) -> u32 {
        self.faces.len() as u32
    }

    /// Which part a face is of.
    pub fn part(&self, face: u32) -> u32 {
        self.faces[face as usize].part
    }

    /// The corners of a face, as vertices of its refined part.
    pub fn vertices(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize].vertices
    }

    /// Where the corners of a face are.
    pub fn corners(&self, face: u32) -> [Vec3; 3] {
        let face = &self.faces[face as usize];
        let sheet = &self.sheets[face.part as usize];
        face.vertices.map(|vertex| sheet.positions[vertex as usize])
    }

    /// The triangle of its part that a face was cut out of.
    pub fn source(&self, face: u32) -> u32 {
        self.faces[face as usize].source
    }

    /// The weights of the corners of a face on its source triangle.
    pub fn barycentrics(&self, face: u32) -> [Vec3; 3] {
        self.faces[face as usize].barycentrics
    }

    /// How many vertices the refined parts have, all together.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// The parts as refined so far.
    pub fn parts(&self) -> Vec<Refined> {
        let vertices = |sheet: &Sheet| (sheet.vertices.clone(), sheet.origins.clone());
        with_triangles(self.sheets.iter().map(vertices).collect(), &self.faces)
    }

    /// The refined parts.
    pub fn into_parts(self) -> Vec<Refined> {
        let vertices = |sheet: Sheet| (sheet.vertices, sheet.origins);
        with_triangles(self.sheets.into_iter().map(vertices).collect(), &self.faces)
    }

    /// Cuts a face at the midpoint of its longest edge, and all others that have that edge. One
    /// of these that has a longer edge is bisected first.
    ///
    /// `told` is called for every face that is cut, in this order. A face that a request before
    /// this one has cut is cut once more.
    ///
    /// # Panics
    ///
    /// If there is no such face.
    pub fn bisect(
        &mut self,
        face: u32,
        limits: &Limits,
        told: &mut dyn FnMut(Bisection),
    ) -> Bisected {
        let asked = &self.faces[face as usize];
        let Some(longest) = asked.longest else {
            return Bisected::Refused;
        };
        // All edges on the path are longer.
        let least = (2.0 * f64::from(limits.min_edge)).max(self.shortest);
        if self.length_squared(asked, longest.into()) < least * least {
            return Bisected::Refused;
        }
        // A longest-edge propagation path (M.-C. Rivara, 1997). Each edge of it is longer than
        // the one before, so it has an end, and no cut touches a face further up the path.
        let mut path = vec![3 * face + u32::from(longest)];
        while let Some(&side) = path.last() {
            let mut longer = None;
            for other in self.ring(side) {
                let Some(longest) = self.faces[other as usize / 3].longest else {
                    return Bisected::Refused;
                };
                let longest = other / 3 * 3 + u32::from(longest);
                if longest != other {
                    longer = Some(longest);
                }
            }
            if let Some(longer) = longer {
                path.push(longer);
            } else if self.cut(side, limits.max_vertices, told) {
                path.pop();
            } else {
                return Bisected::Full;
            }
        }
        Bisected::Done
    }

    /// Cuts an edge that is the longest of all its faces; `false` if there is no room.
    fn cut(&mut self, side: u32, max_vertices: usize, told: &mut dyn FnMut(Bisection)) -> bool {
        let mut wings: Vec<Wing> = self.ring(side).map(|side| self.wing(side)).collect();
        wings.sort_unstable();
        let same_vertex = |a: &Wing, b: &Wing| (a.part, a.ends) == (b.part, b.ends);
        let count = self.vertex_count + wings.chunk_by(same_vertex).count();
        if count > max_vertices.min(u32::MAX as usize) || self.faces.len() + wings.len() > MAX_FACES
        {
            return false;
        }
        let mut sides = Vec::with_capacity(4 * wings.len());
        let node = self.nodes.len() as u32;
        self.nodes.push(self.midpoint(wings[0]).1);
        for group in wings.chunk_by(same_vertex) {
            let vertex = self.add_midpoint(group[0], node);
            for wing in group {
                told(self.halve(wing.side, vertex, &mut sides));
            }
        }
        self.link(&mut sides);
        true
    }

    fn wing(&self, side: u32) -> Wing {
        let face = &self.faces[side as usize / 3];
        let i = side as usize % 3;
        let [a, b] = [face.vertices[i], face.vertices[(i + 1) % 3]];
        Wing {
            part: face.part,
            ends: [a.min(b), a.max(b)],
            side,
        }
    }

    fn midpoint(&self, wing: Wing) -> (SurfacePoint, Vec3) {
        let face = &self.faces[wing.side as usize / 3];
        let sheet = &self.sheets[wing.part as usize];
        let barycentrics = face.halfway(wing.side as usize % 3);
        let source = sheet.triangles[face.source as usize];
        let [a, b, c] = source.map(|vertex| sheet.positions[vertex as usize]);
        let point = SurfacePoint {
            triangle: face.source,
            barycentrics,
        };
        (point, blend(a, b, c, barycentrics))
    }

    fn add_midpoint(&mut self, wing: Wing, node: u32) -> u32 {
        let (point, position) = self.midpoint(wing);
        let sheet = &mut self.sheets[wing.part as usize];
        sheet.vertices.push(point);
        sheet.origins.push(Origin::Midpoint(wing.ends));
        sheet.positions.push(position);
        sheet.nodes.push(node);
        self.vertex_count += 1;
        (sheet.vertices.len() - 1) as u32
    }

    /// Cuts one face, and adds the sides that have new edges to `sides`, with the node at the
    /// edge's other end. The outer sides stay with their edges.
    fn halve(&mut self, side: u32, vertex: u32, sides: &mut Vec<(u32, u32)>) -> Bisection {
        let (f, i) = (side as usize / 3, side as usize % 3);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let first = 3 * f as u32;
        let first_of_half = 3 * self.faces.len() as u32;
        let nodes = self.nodes_of(&self.faces[f]);

        let mut face = self.faces[f].clone();
        let barycentrics = face.halfway(i);
        face.depth += 1;
        let mut half = face.clone();
        (face.vertices[j], face.barycentrics[j]) = (vertex, barycentrics);
        (half.vertices[i], half.barycentrics[i]) = (vertex, barycentrics);
        face.longest = (face.depth < MAX_DEPTH).then(|| self.longest(&face));
        half.longest = (half.depth < MAX_DEPTH).then(|| self.longest(&half));
        self.faces[f] = face;
        self.faces.push(half);
        self.hand_on(first + j as u32, first_of_half + j as u32);
        sides.extend([
            (nodes[i], first + i as u32),
            (nodes[k], first + j as u32),
            (nodes[j], first_of_half + i as u32),
            (nodes[k], first_of_half + k as u32),
        ]);
        Bisection {
            face: f as u32,
            half: first_of_half / 3,
            edge: i as u8,
        }
    }

    /// Puts one side in the place of another in its ring.
    fn hand_on(&mut self, from: u32, to: u32) {
        let before = self.ring(from).last().unwrap_or(from);
        let after = self.next(from);
        *self.next_mut(before) = to;
        *self.next_mut(to) = if after == from { to } else { after };
    }

    /// Makes rings of the sides with the same edge.
    fn link<Edge: Ord>(&mut self, sides: &mut [(Edge, u32)]) {
        sides.sort_unstable();
        for ring in sides.chunk_by(|a, b| a.0 == b.0) {
            let mut before = ring[ring.len() - 1].1;
            for &(_, side) in ring {
                *self.next_mut(before) = side;
                before = side;
            }
        }
    }

    /// The sides at the same edge, from `side` on.
    fn ring(&self, side: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(side), move |&at| {
            Some(self.next(at)).filter(|&next| next != side)
        })
    }

    fn next(&self, side: u32) -> u32 {
        self.faces[side as usize / 3].next[side as usize % 3]
    }

    fn next_mut(&mut self, side: u32) -> &mut u32 {
        &mut self.faces[side as usize / 3].next[side as usize % 3]
    }

    fn nodes_of(&self, face: &Face) -> [u32; 3] {
        let nodes = &self.sheets[face.part as usize].nodes;
        face.vertices.map(|vertex| nodes[vertex as usize])
    }

    fn is_proper(&self, face: &Face, tolerance: f64) -> bool {
        let [a, b, c] = self.nodes_of(face);
        let [p, q, r] = [a, b, c].map(|node| self.nodes[node as usize].as_dvec3());
        let longest = self.length_squared(face, self.longest(face).into()).sqrt();
        a != b && b != c && c != a && (q - p).cross(r - p).length() > tolerance * longest
    }

    /// The longest side; of those as long as each other the one with the highest nodes, so that
    /// edges are in the same order for all faces.
    fn longest(&self, face: &Face) -> u8 {
        let nodes = self.nodes_of(face);
        let order = |i: usize| {
            let [a, b] = [nodes[i], nodes[(i + 1) % 3]];
            (self.length_squared(face, i), a.min(b), a.max(b))
        };
        let longer = |i: usize, j: usize| {
            let (a, b) = (order(i), order(j));
            a.0.total_cmp(&b.0)
                .then((a.1, a.2).cmp(&(b.1, b.2)))
                .is_gt()
        };
        let longest = usize::from(longer(1, 0));
        if longer(2, longest) { 2 } else { longest as u8 }
    }

    fn length_squared(&self, face: &Face, side: usize) -> f64 {
        let nodes = self.nodes_of(face);
        let [a, b] = [nodes[side], nodes[(side + 1) % 3]];
        let [a, b] = [a, b].map(|node| self.nodes[node as usize].as_dvec3());
        a.distance_squared(b)
    }
}

impl Sheet {
    fn new(part: &Part) -> Self {
        let (mesh, new_index) =
            RefinedMesh::with_used_vertices(part.positions.len(), part.triangles);
        let used = (0..).zip(&new_index).filter(|(_, new)| new.is_some());
        let corners = |corners: &[u32; 3]| {
            corners.map(|vertex| new_index[vertex as usize].unwrap_or_default())
        };
        Self {
            triangles: part.triangles.iter().map(corners).collect(),
            origins: used.map(|(given, _)| Origin::Given(given)).collect(),
            positions: mesh.positions(part.positions, part.triangles),
            vertices: mesh.vertices,
            nodes: Vec::new(),
        }
    }
}

impl Face {
    fn halfway(&self, side: usize) -> Vec3 {
        0.5 * (self.barycentrics[side] + self.barycentrics[(side + 1) % 3])
    }
}

/// Vertices of parts and the faces of all, in the order of their sources.
fn with_triangles(vertices: Vec<(Vec<SurfacePoint>, Vec<Origin>)>, faces: &[Face]) -> Vec<Refined> {
    let mut parts: Vec<Refined> = (vertices.into_iter())
        .map(|(vertices, origins)| Refined {
            mesh: RefinedMesh {
                vertices,
                ..RefinedMesh::default()
            },
            origins,
        })
        .collect();
    let mut order: Vec<u32> = (0..faces.len() as u32).collect();
    order.sort_unstable_by_key(|&face| {
        let Face { part, source, .. } = faces[face as usize];
        (part, source, face)
    });
    for face in order {
        let face = &faces[face as usize];
        let mesh = &mut parts[face.part as usize].mesh;
        mesh.push_triangle(face.source, face.vertices);
    }
    parts
}

#[cfg(test)]
#[path = "conforming_test.rs"]
mod tests;
