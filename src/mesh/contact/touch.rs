use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::edge_points::Wants;
use super::frame::Frame;
use super::near;
use super::shape::{Edge, Shape};

/// An edge may rise above a face by this part of its length and still lie on it where it is near.
const SLOPE: f64 = 0.0625;

/// Where faces are touched or crossed.
#[derive(Default)]
pub(super) struct Contacts {
    /// By face: segments in its frame.
    pub(super) on_faces: BTreeMap<u32, Vec<[DVec2; 2]>>,
    /// By edge.
    pub(super) on_edges: BTreeMap<u32, Wants>,
}

/// Finds all contacts. `None` if `go_on` says no.
pub(super) fn find(shape: &Shape, go_on: &dyn Fn() -> bool) -> Option<Contacts> {
    let mut contacts = Contacts::default();
    near::pairs(shape, go_on, |f, g| contacts.between(shape, f, g))?;
    for (index, edge) in shape.edges.iter().enumerate() {
        if edge.is_junction {
            contacts.want(index as u32, [0.0, 1.0]);
        }
    }
    Some(contacts)
}

/// How far the corners of a triangle lie above a plane.
type Heights = [f64; 3];

impl Contacts {
    fn between(&mut self, shape: &Shape, f: usize, g: usize) {
        let [from, to] = [f, g].map(|face| &shape.faces[face]);
        if !(from.cuts && to.cut || to.cuts && from.cut) {
            return;
        }
        let shared = (from.classes.iter())
            .filter(|class| to.classes.contains(class))
            .count();
        let heights = [heights_over(shape, f, g), heights_over(shape, g, f)];
        let reach = shape.tolerance.max(shape.snap);
        let is_beside = |h: &Heights| h.iter().all(|&h| h > reach) || h.iter().all(|&h| h < -reach);
        if heights.iter().any(is_beside) {
            return;
        }
        self.edges_of_one_on_other(shape, f, g, heights[0]);
        self.edges_of_one_on_other(shape, g, f, heights[1]);
        if shared < 2 {
            let shortest = if shared == 0 { shape.snap } else { reach };
            self.crossing(shape, [f, g], heights, shortest);
        }
    }

    fn edges_of_one_on_other(&mut self, shape: &Shape, f: usize, g: usize, heights: Heights) {
        for (k, &index) in shape.edges_of[f].iter().enumerate() {
            let edge = &shape.edges[index as usize];
            let ends = [heights[k], heights[(k + 1) % 3]];
            let is_close = ends.iter().any(|h| h.abs() <= shape.tolerance)
                || (ends[0] > 0.0) != (ends[1] > 0.0);
            if edge.owner == Some(f as u32) && is_close {
                self.edge_on_face(shape, index, g);
            }
        }
    }

    /// A feature edge on a face cuts it. An edge of any kind where the surface passes through the
    /// face cuts it too, and is a contact of its own surface.
    fn edge_on_face(&mut self, shape: &Shape, index: u32, g: usize) {
        let edge = &shape.edges[index as usize];
        let Some(frame) = Frame::new(shape.corners(g)) else {
            return;
        };
        let ends = edge.ends.map(|end| shape.positions[end as usize]);
        let heights = ends.map(|end| frame.height(end) / frame.scale);
        let is_in_plane = heights.iter().all(|h| h.abs() <= shape.snap);
        let passes = is_in_plane && passes_through(shape, edge, &frame);
        if !edge.is_feature && !passes {
            return;
        }
        let Some(part) = part_on_face(shape, edge, g, &frame) else {
            return;
        };
        let face = &shape.faces[g];
        if face.cut {
            let segment = part.map(|t| frame.project(ends[0].lerp(ends[1], t)));
            self.on_faces.entry(g as u32).or_default().push(segment);
        }
        if face.cuts && passes {
            self.want(index, part);
        }
    }

    fn want(&mut self, edge: u32, part: [f64; 2]) {
        let wants = self.on_edges.entry(edge).or_default();
        wants.points.extend(part);
        wants.contacts.push(part);
    }

    /// The segment in which two triangles cross, if each has corners on both sides of the other.
    fn crossing(&mut self, shape: &Shape, faces: [usize; 2], heights: [Heights; 2], shortest: f64) {
        let lines = [0, 1].map(|i| line_in_plane(shape, faces[i], heights[i]));
        let [Some(first), Some(second)] = lines else {
            return;
        };
        let Some(segment) = overlap(first, second) else {
            return;
        };
        if segment[0].distance(segment[1]) <= shortest {
            return;
        }
        for [cut, by] in [faces, [faces[1], faces[0]]] {
            if !(shape.faces[cut].cut && shape.faces[by].cuts) {
                continue;
            }
            let Some(frame) = Frame::new(shape.corners(cut)) else {
                continue;
            };
            let ends = segment.map(|end| frame.project(end));
            if let Some(part) = frame.clip(ends, shape.snap * frame.scale) {
                let part = part.map(|t| ends[0].lerp(ends[1], t));
                self.on_faces.entry(cut as u32).or_default().push(part);
            }
        }
    }
}

fn heights_over(shape: &Shape, face: usize, plane: usize) -> Heights {
    let origin = shape.positions[shape.faces[plane].classes[0] as usize];
    let normal = shape.faces[plane].normal;
    shape.corners(face).map(|p| (p - origin).dot(normal))
}

/// Whether the surface goes on from the edge on both sides of the plane.
fn passes_through(shape: &Shape, edge: &Edge, plane: &Frame) -> bool {
    let heights = (shape.faces_at(edge))
        .filter(|&(face, _)| shape.faces[face as usize].cuts)
        .map(|(_, third)| plane.height(shape.positions[third as usize]) / plane.scale);
    let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    low < -shape.snap && high > shape.snap
}

/// Which part of an edge lies on a face.
///
/// The surface's own neighbours are always near: what shares a corner with the face, or is joined
/// to one by an edge, has to touch it, and for longer than the tolerance.
fn part_on_face(shape: &Shape, edge: &Edge, g: usize, frame: &Frame) -> Option<[f64; 2]> {
    let corners = shape.faces[g].classes;
    if edge.ends.iter().all(|end| corners.contains(end)) {
        return None;
    }
    let near = part_within(
        shape,
        edge,
        frame,
        shape.tolerance.max(shape.snap),
        shape.snap,
    )?;
    let is_neighbour =
        |end: u32| (corners.iter()).any(|&corner| corner == end || shape.are_joined(corner, end));
    if edge.ends.into_iter().any(is_neighbour) {
        part_within(shape, edge, frame, shape.snap, shape.tolerance)
    } else {
        Some(near)
    }
}

/// The part not further than `reach` from a face, if it is longer than `shortest`.
fn part_within(
    shape: &Shape,
    edge: &Edge,
    frame: &Frame,
    reach: f64,
    shortest: f64,
) -> Option<[f64; 2]> {
    let ends = edge.ends.map(|end| shape.positions[end as usize]);
    let heights = ends.map(|end| frame.height(end) / frame.scale);
    let rise = heights[1] - heights[0];
    let is_low = heights.iter().all(|h| h.abs() <= reach);
    if !is_low && rise.abs() > SLOPE * ends[0].distance(ends[1]) {
        return None;
    }
    let mut part = [0.0_f64, 1.0_f64];
    if !is_low {
        let crossings = [-reach, reach].map(|level| (level - heights[0]) / rise);
        part[0] = part[0].max(crossings[0].min(crossings[1]));
        part[1] = part[1].min(crossings[0].max(crossings[1]));
        if part[0].is_nan() || part[1].is_nan() || part[0] >= part[1] {
            return None;
        }
    }
    let points = part.map(|t| frame.project(ends[0].lerp(ends[1], t)));
    let clipped = frame.clip(points, shape.snap * frame.scale)?;
    let length = (clipped[1] - clipped[0]) * points[0].distance(points[1]);
    (length > shortest * frame.scale).then(|| clipped.map(|t| part[0] + t * (part[1] - part[0])))
}

/// Where a triangle meets a plane that it has corners on both sides of.
fn line_in_plane(shape: &Shape, face: usize, heights: Heights) -> Option<[DVec3; 2]> {
    let corners = shape.corners(face);
    // A corner next to the plane is on it, or rounding would decide which edges are crossed.
    let heights = heights.map(|h| if h.abs() <= shape.snap { 0.0 } else { h });
    let lone = (0..3).find(|&i| {
        let others = [heights[(i + 1) % 3], heights[(i + 2) % 3]];
        heights[i] != 0.0 && others.iter().all(|h| h * heights[i] <= 0.0)
    })?;
    let others = [(lone + 1) % 3, (lone + 2) % 3];
    if others.iter().all(|&i| heights[i] == 0.0) {
        return None;
    }
    Some(
        others
            .map(|i| corners[lone].lerp(corners[i], heights[lone] / (heights[lone] - heights[i]))),
    )
}

/// What two segments of one line have in common.
fn overlap(first: [DVec3; 2], second: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let along = (first[1] - first[0]).normalize_or_zero();
    let sorted = |mut segment: [DVec3; 2]| {
        if segment[0].dot(along) > segment[1].dot(along) {
            segment.swap(0, 1);
        }
        segment
    };
    let (first, second) = (sorted(first), sorted(second));
    let later = |a: DVec3, b: DVec3| if a.dot(along) >= b.dot(along) { a } else { b };
    let earlier = |a: DVec3, b: DVec3| if a.dot(along) <= b.dot(along) { a } else { b };
    let (start, end) = (later(first[0], second[0]), earlier(first[1], second[1]));
    (start.dot(along) < end.dot(along)).then_some([start, end])
}
