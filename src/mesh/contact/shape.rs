use std::ops::Range;

use glam::DVec3;

use super::Surface;
use crate::mesh::PositionClasses;

/// Directions within this angle are one: cos 5°.
const SAME_DIRECTION: f64 = 0.996_2;

/// The triangles of all surfaces, and their edges by position.
pub(super) struct Shape {
    pub(super) tolerance: f64,
    /// Points nearer than this become one.
    pub(super) snap: f64,
    /// By position class.
    pub(super) positions: Vec<DVec3>,
    /// Of all surfaces, one after the other.
    pub(super) faces: Vec<Face>,
    /// The faces of each surface.
    pub(super) objects: Vec<Range<usize>>,
    /// Sorted by their ends.
    pub(super) edges: Vec<Edge>,
    /// `3 face + corner` of the edges, sorted by edge.
    uses: Vec<u32>,
    /// Of each face: the edges from its corners to the next ones.
    pub(super) edges_of: Vec<[u32; 3]>,
}

pub(super) struct Face {
    /// Position classes of the corners.
    pub(super) classes: [u32; 3],
    pub(super) cut: bool,
    pub(super) cuts: bool,
    /// Whether it is large enough, and thick enough, to cut and be cut.
    pub(super) is_live: bool,
    /// Zero if it has no area.
    pub(super) normal: DVec3,
}

/// A line between two positions, the lower class first.
pub(super) struct Edge {
    pub(super) ends: [u32; 2],
    uses: Range<u32>,
    /// The live face that looks for contacts of the edge.
    pub(super) owner: Option<u32>,
    /// A boundary, or where faces meet at an angle.
    pub(super) is_feature: bool,
    /// Surfaces in more than two directions: a wall stands on a floor.
    pub(super) is_junction: bool,
}

impl Shape {
    pub(super) fn new(surfaces: &[Surface], tolerance: f32) -> Self {
        let all = surfaces.iter().flat_map(|s| s.positions.iter().copied());
        let PositionClasses {
            class,
            representative,
        } = PositionClasses::new(all, 0.0);
        let tolerance = f64::from(tolerance.max(0.0));
        let extent = (representative.iter())
            .map(|p| f64::from(p.abs().max_element()))
            .filter(|extent| extent.is_finite())
            .fold(0.0, f64::max);
        let mut shape = Self {
            tolerance,
            // A hundredth of the tolerance; never so near that rounding could part what is one.
            snap: (0.015625 * tolerance).max(8.0 * extent * f64::from(f32::EPSILON)),
            positions: representative.iter().map(|p| p.as_dvec3()).collect(),
            faces: Vec::new(),
            objects: Vec::new(),
            edges: Vec::new(),
            uses: Vec::new(),
            edges_of: Vec::new(),
        };
        let mut first_vertex = 0;
        for surface in surfaces {
            let first_face = shape.faces.len();
            for corners in surface.triangles {
                let classes = corners.map(|vertex| class[first_vertex + vertex as usize]);
                shape.push_face(classes, surface);
            }
            shape.objects.push(first_face..shape.faces.len());
            first_vertex += surface.positions.len();
        }
        shape.find_edges();
        shape
    }

    fn push_face(&mut self, classes: [u32; 3], surface: &Surface) {
        let [a, b, c] = classes.map(|class| self.positions[class as usize]);
        let length = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let cross = (b - a).cross(c - a);
        let height = cross.length() / length;
        self.faces.push(Face {
            classes,
            cut: surface.cut,
            cuts: surface.cuts,
            is_live: length.is_finite() && length >= 2.0 * self.tolerance && height > self.snap,
            normal: cross.normalize_or_zero(),
        });
    }

    fn find_edges(&mut self) {
        let mut sides: Vec<([u32; 2], u32)> = (self.faces.iter().enumerate())
            .flat_map(|(face, f)| {
                [0, 1, 2].map(|k| {
                    let [a, b] = [f.classes[k], f.classes[(k + 1) % 3]];
                    ([a.min(b), a.max(b)], (3 * face + k) as u32)
                })
            })
            .collect();
        sides.sort_unstable();
        self.uses = sides.iter().map(|&(_, side)| side).collect();
        self.edges_of = vec![[0; 3]; self.faces.len()];
        let mut start = 0;
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            let uses = start..start + group.len() as u32;
            start = uses.end;
            for &(_, side) in group {
                self.edges_of[side as usize / 3][side as usize % 3] = self.edges.len() as u32;
            }
            let edge = self.new_edge(group[0].0, uses);
            self.edges.push(edge);
        }
    }

    fn new_edge(&self, ends: [u32; 2], uses: Range<u32>) -> Edge {
        let mut edge = Edge {
            ends,
            uses,
            owner: None,
            is_feature: false,
            is_junction: false,
        };
        if ends[0] == ends[1] {
            return edge;
        }
        let mut faces = self.faces_at(&edge).map(|(face, _)| face);
        let owner = faces.find(|&face| {
            let face = &self.faces[face as usize];
            face.is_live && face.cuts
        });
        drop(faces);
        edge.owner = owner;
        if owner.is_some() {
            let directions = self.directions(&edge, |face| face.cuts);
            let is_flat = matches!(directions[..], [a, b] if a.dot(b) < -SAME_DIRECTION);
            edge.is_feature = !is_flat;
            edge.is_junction =
                directions.len() > 2 && self.directions(&edge, |f| f.cuts && f.is_live).len() > 2;
        }
        edge
    }

    /// In which directions the surface goes on from an edge. The two faces of a thin sheet, front
    /// and back, go in one.
    fn directions(&self, edge: &Edge, counts: impl Fn(&Face) -> bool) -> Vec<DVec3> {
        let [a, b] = edge.ends.map(|end| self.positions[end as usize]);
        let along = (b - a).normalize_or_zero();
        let mut directions: Vec<DVec3> = Vec::with_capacity(4);
        for (face, third) in self.faces_at(edge) {
            let face = &self.faces[face as usize];
            if face.normal == DVec3::ZERO || !counts(face) {
                continue;
            }
            let to_third = self.positions[third as usize] - a;
            let direction = (to_third - along * along.dot(to_third)).normalize_or_zero();
            if !(directions.iter()).any(|d| d.dot(direction) > SAME_DIRECTION) {
                directions.push(direction);
            }
        }
        directions
    }

    /// The faces of an edge, with the position class opposite.
    pub(super) fn faces_at(&self, edge: &Edge) -> impl Iterator<Item = (u32, u32)> {
        let uses = &self.uses[edge.uses.start as usize..edge.uses.end as usize];
        uses.iter().map(|&side| {
            let (face, corner) = (side / 3, side as usize % 3);
            let third = self.faces[face as usize].classes[(corner + 2) % 3];
            (face, third)
        })
    }

    pub(super) fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face]
            .classes
            .map(|class| self.positions[class as usize])
    }

    /// Whether two positions are the ends of an edge.
    pub(super) fn are_joined(&self, a: u32, b: u32) -> bool {
        let ends = [a.min(b), a.max(b)];
        (self.edges)
            .binary_search_by_key(&ends, |edge| edge.ends)
            .is_ok()
    }

    /// Whether the edge of `face` from `corner` runs from the lower class to the higher, as edges do.
    pub(super) fn is_forward(&self, face: usize, corner: usize) -> bool {
        let classes = self.faces[face].classes;
        classes[corner] <= classes[(corner + 1) % 3]
    }
}
