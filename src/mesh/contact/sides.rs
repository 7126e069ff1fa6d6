use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::cut::{Corner, Piece, Pieces, ordered};
use super::shape::Shape;
use super::weights;
use super::{CutMesh, Surface};
use crate::mesh::refined::{RefinedMesh, SurfacePoint};

/// Makes a mesh of an object's pieces, with vertices of their own on both sides of contacts.
/// `None` if that is the mesh it was.
///
/// Round a point of a contact the corners of triangles form fans, which contacts part:
///
/// ```text
///        \  0  /             \     /
///         \   /               \ 0 /
///   ═══════ · ═══════   ═══════ ·         the end of a contact has one fan only
///         /   \               /   \
///        /  1  \             /     \
/// ```
pub(super) fn part(
    shape: &Shape,
    object: usize,
    surface: &Surface,
    mut cut: Pieces,
    nodes: &mut u32,
) -> Option<CutMesh> {
    cut.drop_contacts_at_boundaries();
    if cut.contacts.is_empty() && cut.pieces.len() == surface.triangles.len() {
        return None;
    }
    let first_face = shape.objects[object].start;
    let classes = |source: u32| shape.faces[first_face + source as usize].classes;
    let fans = Fans::new(&cut);
    let lonely: Vec<[u32; 2]> = (cut.contacts.iter().copied())
        .filter(|&ends| fans.do_not_part(ends))
        .collect();
    let fans = if lonely.is_empty() {
        fans
    } else {
        cut.halve(&lonely, classes, nodes);
        Fans::new(&cut)
    };
    let mesh = Vertices::new(surface).mesh(surface, &cut, &fans);
    let is_changed =
        cut.pieces.len() != surface.triangles.len() || mesh.sides.iter().any(|&side| side != 0);
    is_changed.then_some(mesh)
}

impl Piece {
    /// The nodes of its edges, from its corners to the next ones.
    fn edges(&self) -> [[u32; 2]; 3] {
        [0, 1, 2].map(|k| ordered(self.corners[k].node, self.corners[(k + 1) % 3].node))
    }
}

impl Pieces {
    /// A contact with a surface on one side only parts nothing.
    fn drop_contacts_at_boundaries(&mut self) {
        let mut seen = BTreeSet::new();
        let mut inner = BTreeSet::new();
        if self.contacts.is_empty() {
            return;
        }
        for edge in self.pieces.iter().flat_map(Piece::edges) {
            if self.contacts.contains(&edge) && !seen.insert(edge) {
                inner.insert(edge);
            }
        }
        self.contacts = inner;
    }

    /// Puts points in the middle of contacts, so that there is one where their sides part.
    fn halve(&mut self, edges: &[[u32; 2]], classes: impl Fn(u32) -> [u32; 3], nodes: &mut u32) {
        let mut middles = HashMap::new();
        for &edge in edges {
            let middle = *nodes;
            *nodes += 1;
            middles.insert(edge, middle);
            self.contacts.remove(&edge);
            self.contacts.extend(edge.map(|end| ordered(end, middle)));
        }
        let mut stack = Vec::new();
        for piece in std::mem::take(&mut self.pieces) {
            stack.push(piece);
            while let Some(piece) = stack.pop() {
                let edges = piece.edges();
                let marked = (0..3).find_map(|k| Some((k, *middles.get(&edges[k])?)));
                match marked {
                    None => self.pieces.push(piece),
                    Some((k, middle)) => stack.extend(piece.halves(k, middle, &classes)),
                }
            }
        }
    }
}

impl Piece {
    fn halves(&self, k: usize, node: u32, classes: impl Fn(u32) -> [u32; 3]) -> [Self; 2] {
        let [a, b, c] = [0, 1, 2].map(|i| self.corners[(k + i) % 3]);
        let weights = weights::middle(a.weights, b.weights, classes(self.source));
        let middle = Corner { node, weights };
        [[middle, b, c], [a, middle, c]].map(|corners| Self {
            source: self.source,
            corners,
        })
    }
}

/// The corners of pieces round the ends of contacts, in fans that contacts part.
struct Fans {
    /// Of the corners of each piece: the number of its fan.
    sides: Vec<[u32; 3]>,
    /// How many fans there are round each end of a contact.
    counts: BTreeMap<u32, u32>,
}

impl Fans {
    fn new(cut: &Pieces) -> Self {
        let mut around: BTreeMap<u32, Vec<(usize, usize)>> = (cut.contacts.iter())
            .flat_map(|ends| ends.map(|end| (end, Vec::new())))
            .collect();
        for (index, piece) in cut.pieces.iter().enumerate() {
            for (k, corner) in piece.corners.iter().enumerate() {
                if let Some(corners) = around.get_mut(&corner.node) {
                    corners.push((index, k));
                }
            }
        }
        let mut fans = Self {
            sides: vec![[0; 3]; cut.pieces.len()],
            counts: BTreeMap::new(),
        };
        for (node, corners) in around {
            let numbers = number_fans(cut, node, &corners);
            let count = numbers.iter().max().map_or(0, |last| last + 1);
            fans.counts.insert(node, count);
            for ((piece, k), number) in corners.into_iter().zip(numbers) {
                fans.sides[piece][k] = number;
            }
        }
        fans
    }

    fn do_not_part(&self, ends: [u32; 2]) -> bool {
        ends.iter()
            .all(|end| self.counts.get(end).is_none_or(|&count| count < 2))
    }
}

/// The number of the fan of each of the corners round a node, 0 for that of the first.
fn number_fans(cut: &Pieces, node: u32, corners: &[(usize, usize)]) -> Vec<u32> {
    let mut spokes: Vec<(u32, usize)> = Vec::with_capacity(2 * corners.len());
    for (i, &(piece, k)) in corners.iter().enumerate() {
        for other in [1, 2] {
            let other = cut.pieces[piece].corners[(k + other) % 3].node;
            if !cut.contacts.contains(&ordered(node, other)) {
                spokes.push((other, i));
            }
        }
    }
    spokes.sort_unstable();
    let mut first: Vec<usize> = (0..corners.len()).collect();
    for spoke in spokes.chunk_by(|a, b| a.0 == b.0) {
        for pair in spoke.windows(2) {
            let [a, b] = [find(&mut first, pair[0].1), find(&mut first, pair[1].1)];
            first[a.max(b)] = a.min(b);
        }
    }
    let mut number = vec![0; corners.len()];
    let mut next = 0;
    for i in 0..corners.len() {
        let root = find(&mut first, i);
        if root == i {
            number[i] = next;
            next += 1;
        } else {
            number[i] = number[root];
        }
    }
    number
}

/// The lowest corner of the fan that corner `i` belongs to.
fn find(first: &mut [usize], mut i: usize) -> usize {
    while first[i] != i {
        first[i] = first[first[i]];
        i = first[i];
    }
    i
}

/// The vertices of the mesh that is made: the source's own first.
struct Vertices {
    mesh: RefinedMesh,
    /// The new index of each source vertex.
    new_index: Vec<Option<u32>>,
    /// The side of each vertex, once it is known.
    sides: Vec<Option<u32>>,
    /// By what is one vertex: the node, the source vertices it is blended of, the side.
    known: HashMap<(u32, [u32; 2], u32), u32>,
}

impl Vertices {
    fn new(surface: &Surface) -> Self {
        let (mesh, new_index) =
            RefinedMesh::with_used_vertices(surface.positions.len(), surface.triangles);
        Self {
            sides: vec![None; mesh.vertices.len()],
            mesh,
            new_index,
            known: HashMap::new(),
        }
    }

    fn mesh(mut self, surface: &Surface, cut: &Pieces, fans: &Fans) -> CutMesh {
        for (piece, sides) in cut.pieces.iter().zip(&fans.sides) {
            let source = surface.triangles[piece.source as usize];
            let corners =
                [0, 1, 2].map(|k| self.vertex(piece.source, source, piece.corners[k], sides[k]));
            self.mesh.push_triangle(piece.source, corners);
        }
        CutMesh {
            mesh: self.mesh,
            sides: self
                .sides
                .into_iter()
                .map(Option::unwrap_or_default)
                .collect(),
        }
    }

    fn vertex(&mut self, triangle: u32, source: [u32; 3], corner: Corner, side: u32) -> u32 {
        let used = || (0..3).filter(|&i| corner.weights[i] != 0);
        let point = SurfacePoint {
            triangle,
            barycentrics: weights::to_vec3(corner.weights),
        };
        if let (Some(only), 1) = (used().next(), used().count())
            && let Some(original) = self.new_index[source[only] as usize]
        {
            return self.original(original, side);
        }
        // Inside a triangle no other has the node.
        let ends = used().map(|i| source[i]);
        let (low, high) = (ends.clone().min(), ends.max());
        let key = (
            corner.node,
            [low, high].map(Option::unwrap_or_default),
            side,
        );
        if let Some(&vertex) = self.known.get(&key) {
            return vertex;
        }
        let vertex = self.push(point, side);
        self.known.insert(key, vertex);
        vertex
    }

    /// A source vertex, or a copy of it where it already is on another side.
    fn original(&mut self, vertex: u32, side: u32) -> u32 {
        let taken = self.sides[vertex as usize].get_or_insert(side);
        if *taken == side {
            return vertex;
        }
        let key = (u32::MAX, [vertex; 2], side);
        if let Some(&copy) = self.known.get(&key) {
            return copy;
        }
        let copy = self.push(self.mesh.vertices[vertex as usize], side);
        self.known.insert(key, copy);
        copy
    }

    fn push(&mut self, point: SurfacePoint, side: u32) -> u32 {
        self.sides.push(Some(side));
        self.mesh.push_vertex(point)
    }
}
