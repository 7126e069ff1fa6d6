use glam::Vec3;

use super::edge_rings::EdgeRings;
use super::part::{Part, Refined, Sheet};
use super::refined::SurfacePoint;
use super::weld::PositionClasses;

/// How often a face may be halved. Positions run out of bits at about the same depth; that this
/// one is a number proves that a request ends, however positions are rounded.
const MAX_DEPTH: u8 = 40;

/// Of an edge.
const MIDDLE: f32 = 0.5;

/// Sides of faces are numbered with 32 bits, three a face.
const MAX_FACES: usize = (u32::MAX / 3) as usize;

/// How far [`Conforming::bisect`] may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of all parts together, as [`Conforming::vertex_count`] counts them.
    pub max_vertices: usize,
    /// Of all parts together, as [`Conforming::faces`] counts them.
    pub max_faces: usize,
    /// No edge is cut into halves shorter than this.
    pub min_edge: f32,
}

/// One face cut in two: `face` keeps its number and became the piece with the corners before the cut;
/// `half` is the new face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bisection {
    /// The face that was cut.
    pub face: u32,
    /// The new face: always the next number.
    pub half: u32,
    /// Which edge was cut, by its corners in `face` as it was: `edge` and `(edge + 1) % 3`.
    /// In `face` the corner `(edge + 1) % 3` is replaced by the new vertex, in `half` the corner `edge`.
    pub edge: u8,
    /// Where it was cut, as a share of its length from the corner `edge` on.
    pub at: f32,
}

impl Bisection {
    /// Which of the two pieces a point of the face is on, the new one or not, and its weights of that piece's
    /// corners.
    ///
    /// With the edge from corner `i` to corner `j` cut at the share `a` of its length, a point `b` lies
    /// on the side of `i` if `b_j (1 − a) ≤ b_i a`, and there
    ///
    /// ```text
    ///   ┌───────────────────────────────────────────────────┐
    ///   │  b_i' = b_i − b_j (1 − a) / a    b_cut' = b_j / a │
    ///   └───────────────────────────────────────────────────┘
    /// ```
    ///
    /// On the other side `i` and `j` change places, and `a` and `1 − a`.
    pub fn hand_on(&self, mut b: Vec3) -> (bool, Vec3) {
        let (i, j) = (usize::from(self.edge), (usize::from(self.edge) + 1) % 3);
        let (a, rest) = (self.at, 1.0 - self.at);
        let is_in_half = b[j] * rest > b[i] * a;
        if is_in_half {
            (b[i], b[j]) = (b[i] / rest, (b[j] - b[i] * (a / rest)).max(0.0));
        } else {
            (b[i], b[j]) = ((b[i] - b[j] * (rest / a)).max(0.0), b[j] / a);
        }
        (is_in_half, b)
    }
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
    /// There would be too many vertices or faces.
    Full,
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
    edges: EdgeRings,
    /// Where each is; lengths are measured between these, so that all faces agree.
    nodes: Vec<Vec3>,
    vertex_count: usize,
    /// Rounded positions do not tell the halves of shorter edges well.
    shortest: f64,
}

#[derive(Clone, Debug)]
struct Face {
    part: u32,
    source: u32,
    vertices: [u32; 3],
    /// Of the corners, on the source triangle.
    barycentrics: [Vec3; 3],
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
            edges: EdgeRings::default(),
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
                self.edges.push_face();
            }
        }
        self.edges.link(&mut sides);
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

    /// Where the vertices of a refined part lie on it. A vertex keeps its place in the list; new ones come
    /// behind.
    pub fn points(&self, part: u32) -> &[SurfacePoint] {
        self.sheets[part as usize].points()
    }

    /// Which node each vertex of a refined part is at. Nodes are numbered through all parts: those given by
    /// [`PositionClasses`] of the used vertices, then those of cut edges.
    pub fn nodes(&self, part: u32) -> &[u32] {
        &self.sheets[part as usize].nodes
    }

    /// How many vertices the parts before each have, all together.
    pub fn first_vertices(&self) -> Vec<usize> {
        let mut next = 0;
        let first = |sheet: &Sheet| {
            let first = next;
            next += sheet.positions.len();
            first
        };
        self.sheets.iter().map(first).collect()
    }

    /// The parts as refined so far.
    pub fn parts(&self) -> Vec<Refined> {
        let mut parts: Vec<Refined> = self.sheets.iter().map(Sheet::refined).collect();
        self.add_triangles(&mut parts);
        parts
    }

    /// The refined parts.
    pub fn into_parts(mut self) -> Vec<Refined> {
        let sheets = std::mem::take(&mut self.sheets);
        let mut parts: Vec<Refined> = sheets.into_iter().map(Sheet::into_refined).collect();
        self.add_triangles(&mut parts);
        parts
    }

    fn add_triangles(&self, parts: &mut [Refined]) {
        let mut order: Vec<u32> = (0..self.faces()).collect();
        order.sort_unstable_by_key(|&face| (self.part(face), self.source(face), face));
        for face in order {
            let mesh = &mut parts[self.part(face) as usize].mesh;
            mesh.push_triangle(self.source(face), self.vertices(face));
        }
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
            for other in self.edges.ring(side) {
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
            } else if self.cut(side, MIDDLE, limits, told) {
                path.pop();
            } else {
                return Bisected::Full;
            }
        }
        Bisected::Done
    }

    /// Cuts an edge of a face where it is asked for, at a share of its length from the corner `edge` on,
    /// and all faces that have that edge.
    ///
    /// Angles get as small as they may: this is for a line that edges are to follow. No piece of the
    /// edge is shorter than the limit.
    ///
    /// # Panics
    ///
    /// If there is no such face.
    pub fn cut_edge(
        &mut self,
        (face, edge): (u32, u8),
        at: f32,
        limits: &Limits,
        told: &mut dyn FnMut(Bisection),
    ) -> Bisected {
        let side = 3 * face + u32::from(edge);
        let shorter = f64::from(at.min(1.0 - at));
        let length = shorter
            * self
                .length_squared(&self.faces[face as usize], edge.into())
                .sqrt();
        let may = |side: u32| self.faces[side as usize / 3].longest.is_some();
        let least = f64::from(limits.min_edge).max(self.shortest);
        if length < least || !self.edges.ring(side).all(may) {
            return Bisected::Refused;
        }
        match self.cut(side, at, limits, told) {
            true => Bisected::Done,
            false => Bisected::Full,
        }
    }

    /// Cuts an edge, at a share of its length as `side` goes; `false` if there is no room.
    fn cut(
        &mut self,
        side: u32,
        at: f32,
        limits: &Limits,
        told: &mut dyn FnMut(Bisection),
    ) -> bool {
        let mut wings: Vec<Wing> = self.edges.ring(side).map(|side| self.wing(side)).collect();
        wings.sort_unstable();
        let same_vertex = |a: &Wing, b: &Wing| (a.part, a.ends) == (b.part, b.ends);
        let count = self.vertex_count + wings.chunk_by(same_vertex).count();
        let faces = self.faces.len() + wings.len();
        if count > limits.max_vertices.min(u32::MAX as usize)
            || faces > limits.max_faces.min(MAX_FACES)
        {
            return false;
        }
        // All faces go by the same direction, so that they find the same bits.
        let from_lower = if self.goes_up(side) { at } else { 1.0 - at };
        let mut sides = Vec::with_capacity(4 * wings.len());
        let node = self.nodes.len() as u32;
        let sheet = &self.sheets[wings[0].part as usize];
        self.nodes
            .push(sheet.position(self.point(wings[0], from_lower)));
        for group in wings.chunk_by(same_vertex) {
            let vertex = self.add_vertex(group[0], from_lower, node);
            for wing in group {
                told(self.halve(wing.side, from_lower, vertex, &mut sides));
            }
        }
        self.edges.link(&mut sides);
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

    /// Whether a side goes from the lower node to the higher one.
    fn goes_up(&self, side: u32) -> bool {
        let nodes = self.nodes_of(&self.faces[side as usize / 3]);
        nodes[side as usize % 3] < nodes[(side as usize + 1) % 3]
    }

    /// A point of an edge, at a share of its length from its lower node on.
    fn point(&self, wing: Wing, from_lower: f32) -> SurfacePoint {
        let face = &self.faces[wing.side as usize / 3];
        let i = wing.side as usize % 3;
        let [first, second] = [i, (i + 1) % 3].map(|corner| face.barycentrics[corner]);
        let [lower, higher] = match self.goes_up(wing.side) {
            true => [first, second],
            false => [second, first],
        };
        SurfacePoint {
            triangle: face.source,
            barycentrics: lower * (1.0 - from_lower) + higher * from_lower,
        }
    }

    fn add_vertex(&mut self, wing: Wing, from_lower: f32, node: u32) -> u32 {
        let point = self.point(wing, from_lower);
        self.vertex_count += 1;
        self.sheets[wing.part as usize].push_between(wing.ends, point, node)
    }

    /// Cuts one face, and adds the sides that have new edges to `sides`, with the node at the
    /// edge's other end. The outer sides stay with their edges.
    fn halve(
        &mut self,
        side: u32,
        from_lower: f32,
        vertex: u32,
        sides: &mut Vec<(u32, u32)>,
    ) -> Bisection {
        let (f, i) = (side as usize / 3, side as usize % 3);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let first = 3 * f as u32;
        let first_of_half = 3 * self.faces.len() as u32;
        let nodes = self.nodes_of(&self.faces[f]);
        let at = if self.goes_up(side) {
            from_lower
        } else {
            1.0 - from_lower
        };
        let barycentrics = self.point(self.wing(side), from_lower).barycentrics;

        let mut face = self.faces[f].clone();
        face.depth += 1;
        let mut half = face.clone();
        (face.vertices[j], face.barycentrics[j]) = (vertex, barycentrics);
        (half.vertices[i], half.barycentrics[i]) = (vertex, barycentrics);
        face.longest = (face.depth < MAX_DEPTH).then(|| self.longest(&face));
        half.longest = (half.depth < MAX_DEPTH).then(|| self.longest(&half));
        self.faces[f] = face;
        self.faces.push(half);
        self.edges.push_face();
        self.edges
            .replace(first + j as u32, first_of_half + j as u32);
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
            at,
        }
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

#[cfg(test)]
#[path = "conforming_test.rs"]
mod tests;
