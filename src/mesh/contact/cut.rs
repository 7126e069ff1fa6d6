use std::collections::{BTreeMap, BTreeSet};

use super::arrange::{Lines, Place};
use super::edge_points::EdgePoints;
use super::frame::{EQUILATERAL, Frame};
use super::shape::Shape;
use super::triangulate::{Vertex, triangulate};
use super::weights::{self, ONE, Weights};

/// An object's triangles, cut.
pub(super) struct Pieces {
    pub(super) pieces: Vec<Piece>,
    /// Edges that are contacts, by the nodes of their ends, the lower first.
    pub(super) contacts: BTreeSet<[u32; 2]>,
}

#[derive(Clone, Copy)]
pub(super) struct Piece {
    /// The object's triangle it was cut out of.
    pub(super) source: u32,
    pub(super) corners: [Corner; 3],
}

/// A corner of a piece.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// Corners at one place have one node.
    pub(super) node: u32,
    /// On the piece's source.
    pub(super) weights: Weights,
}

/// Cuts the triangles of an object. New nodes are numbered from `nodes` on.
pub(super) fn object(
    shape: &Shape,
    object: usize,
    edge_points: &EdgePoints,
    lines: &BTreeMap<u32, Lines>,
    nodes: &mut u32,
) -> Pieces {
    let faces = shape.objects[object].clone();
    let mut cut = Pieces {
        pieces: Vec::with_capacity(faces.len()),
        contacts: BTreeSet::new(),
    };
    for (source, face) in faces.enumerate() {
        let outline = Outline::new(shape, face, edge_points);
        let lines = lines.get(&(face as u32));
        cut.contacts.extend(outline.contacts());
        if outline.corners.len() == 3 && lines.is_none() {
            let corners = [outline.corners[0], outline.corners[1], outline.corners[2]];
            let source = source as u32;
            cut.pieces.push(Piece { source, corners });
        } else {
            cut.face(shape, face, source as u32, &outline, lines, nodes);
        }
    }
    cut
}

/// The points on the edges of a triangle, all round from its first corner.
struct Outline {
    corners: Vec<Corner>,
    /// Of each: which of the triangle's edges it is on, a bit each.
    edges: Vec<u8>,
    /// Of each: whether the line to the next is a contact.
    is_contact: Vec<bool>,
    /// Of each edge: its first point.
    starts: [usize; 3],
}

impl Outline {
    fn new(shape: &Shape, face: usize, edge_points: &EdgePoints) -> Self {
        let mut outline = Self {
            corners: Vec::with_capacity(3),
            edges: Vec::with_capacity(3),
            is_contact: Vec::with_capacity(3),
            starts: [0; 3],
        };
        for corner in 0..3 {
            outline.starts[corner] = outline.corners.len();
            let start = Corner {
                node: shape.faces[face].classes[corner],
                weights: weights::corner(corner),
            };
            outline.push(start, 1 << corner | 1 << ((corner + 2) % 3));
            let Some(points) = edge_points.of(shape.edges_of[face][corner]) else {
                outline.is_contact.push(false);
                continue;
            };
            let is_forward = shape.is_forward(face, corner);
            let pieces = points.is_contact.len();
            for i in 0..pieces {
                let i = if is_forward { i } else { pieces - 1 - i };
                outline.is_contact.push(points.is_contact[i]);
            }
            for i in 1..pieces {
                let i = if is_forward { i } else { pieces - i };
                let t = if is_forward {
                    points.at[i]
                } else {
                    ONE - points.at[i]
                };
                let weights = weights::on_edge(corner, t);
                let node = points.nodes[i];
                outline.push(Corner { node, weights }, 1 << corner);
            }
        }
        outline
    }

    fn push(&mut self, corner: Corner, edges: u8) {
        self.corners.push(corner);
        self.edges.push(edges);
    }

    fn contacts(&self) -> impl Iterator<Item = [u32; 2]> {
        let next = self.corners.iter().cycle().skip(1);
        (self.corners.iter().zip(next).zip(&self.is_contact))
            .filter(|&(_, &is_contact)| is_contact)
            .map(|((a, b), _)| ordered(a.node, b.node))
    }

    /// The point that stands for one that was wanted on the edge from `corner`.
    fn nearest(&self, corner: usize, t: f64) -> u32 {
        let end = self
            .starts
            .get(corner + 1)
            .copied()
            .unwrap_or(self.corners.len());
        let second = (corner + 1) % 3;
        let wanted = t * f64::from(ONE);
        let distance = |i: usize| match i {
            _ if i == end => (f64::from(ONE) - wanted).abs(),
            _ => (f64::from(self.corners[i].weights[second]) - wanted).abs(),
        };
        let nearest =
            (self.starts[corner]..=end).min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
        (nearest.unwrap_or_default() % self.corners.len()) as u32
    }
}

impl Pieces {
    fn face(
        &mut self,
        shape: &Shape,
        face: usize,
        source: u32,
        outline: &Outline,
        lines: Option<&Lines>,
        nodes: &mut u32,
    ) {
        let frame = Frame::new(shape.corners(face));
        let triangle = frame.as_ref().map_or(EQUILATERAL, |frame| frame.corners);
        let mut corners = outline.corners.clone();
        let mut vertices: Vec<Vertex> = (corners.iter().zip(&outline.edges))
            .map(|(corner, &edges)| {
                let weights = corner.weights.map(|w| f64::from(w) / f64::from(ONE));
                let at = (0..3).map(|i| triangle[i] * weights[i]).sum();
                Vertex { at, edges }
            })
            .collect();
        let mut links = Vec::new();
        if let (Some(lines), Some(frame)) = (lines, &frame) {
            let first_inside = corners.len() as u32;
            for &at in &lines.inside {
                let weights = weights::nearest(frame.weights(at));
                corners.push(Corner {
                    node: *nodes,
                    weights,
                });
                vertices.push(Vertex { at, edges: 0 });
                *nodes += 1;
            }
            let vertex = |place: Place| match place {
                Place::Corner(corner) => outline.starts[corner] as u32,
                Place::Edge { corner, t } => outline.nearest(corner, t),
                Place::Inside(index) => first_inside + index as u32,
            };
            links.extend(lines.links.iter().map(|ends| ends.map(vertex)));
        }
        // Moved to the points of their edges, lines may have come to lie along them.
        links.retain(|[a, b]| vertices[*a as usize].edges & vertices[*b as usize].edges == 0);
        let round: Vec<u32> = (0..outline.corners.len() as u32).collect();
        let parts = triangulate(&vertices, &round, &links);
        let corner = |i: u32| corners[i as usize];
        self.pieces.extend(parts.triangles.iter().map(|part| Piece {
            source,
            corners: part.map(corner),
        }));
        let node = |i: u32| corners[i as usize].node;
        (self.contacts).extend(
            parts
                .contacts
                .iter()
                .map(|&[a, b]| ordered(node(a), node(b))),
        );
    }
}

/// An edge by its ends, whichever way it is told.
pub(super) fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
