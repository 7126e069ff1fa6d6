use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec2;

use super::edge_points::Wants;
use super::frame::Frame;
use super::shape::Shape;
use super::touch::Contacts;

/// A triangle with more contacts than this is left alone: grass on a lawn.
pub(super) const MAX_SEGMENTS: usize = 4096;

/// Nor are there more points than this where contacts of one triangle meet.
const MAX_POINTS: usize = 4 * MAX_SEGMENTS;

/// How many triangles are arranged between two questions whether to go on.
const FACES_A_QUESTION: usize = 256;

/// What contacts ask of faces and edges.
pub(super) struct Arranged {
    /// By face.
    pub(super) on_faces: BTreeMap<u32, Lines>,
    /// By edge.
    pub(super) on_edges: BTreeMap<u32, Wants>,
    /// Faces with more contacts than there may be.
    pub(super) crowded: usize,
}

/// The contacts in a triangle, meeting at their ends only.
#[derive(Default)]
pub(super) struct Lines {
    /// Points inside, in the face's frame.
    pub(super) inside: Vec<DVec2>,
    /// Lines from one place to another, not along the triangle's edges.
    pub(super) links: Vec<[Place; 2]>,
}

/// A point of a triangle.
#[derive(Clone, Copy)]
pub(super) enum Place {
    Corner(usize),
    /// On the edge from `corner`; `t` is the weight of its second end.
    Edge {
        corner: usize,
        t: f64,
    },
    /// Which of the points inside.
    Inside(usize),
}

/// Arranges the contacts of each triangle. `None` if `go_on` says no.
pub(super) fn all(shape: &Shape, contacts: Contacts, go_on: &dyn Fn() -> bool) -> Option<Arranged> {
    let mut arranged = Arranged {
        on_faces: BTreeMap::new(),
        on_edges: contacts.on_edges,
        crowded: 0,
    };
    for (i, (face, segments)) in contacts.on_faces.into_iter().enumerate() {
        if i % FACES_A_QUESTION == 0 && !go_on() {
            return None;
        }
        let Some(frame) = Frame::new(shape.corners(face as usize)) else {
            continue;
        };
        match Points::of(&segments, &frame, shape.snap * frame.scale) {
            Some(points) => arranged.place(shape, face, &frame, &points),
            None => arranged.crowded += 1,
        }
    }
    Some(arranged)
}

impl Arranged {
    /// Tells edges what they get and the face what is left.
    fn place(&mut self, shape: &Shape, face: u32, frame: &Frame, points: &Points) {
        let mut lines = Lines::default();
        let places: Vec<Place> = (points.at.iter().enumerate())
            .map(|(i, &at)| lines.place(i, at, frame, points.snap))
            .collect();
        for place in &places {
            if let &Place::Edge { corner, t } = place {
                let (edge, t) = on_edge(shape, face, corner, t);
                self.on_edges.entry(edge).or_default().points.push(t);
            }
        }
        for &[a, b] in &points.links {
            let ends = [places[a as usize], places[b as usize]];
            let Some((corner, part)) = common_edge(ends) else {
                lines.links.push(ends);
                continue;
            };
            let [(edge, from), (_, to)] = part.map(|t| on_edge(shape, face, corner, t));
            let wants = self.on_edges.entry(edge).or_default();
            wants.contacts.push([from, to]);
        }
        if !lines.links.is_empty() {
            self.on_faces.insert(face, lines);
        }
    }
}

impl Lines {
    fn place(&mut self, index: usize, at: DVec2, frame: &Frame, snap: f64) -> Place {
        if index < 3 {
            return Place::Corner(index);
        }
        let depths = [0, 1, 2].map(|corner| frame.depth(corner, at));
        let shallowest = |&a: &usize, &b: &usize| depths[a].total_cmp(&depths[b]);
        let corner = (0..3).min_by(shallowest).unwrap_or_default();
        if depths[corner] <= snap {
            let t = frame.along(corner, at);
            return Place::Edge { corner, t };
        }
        self.inside.push(at);
        Place::Inside(self.inside.len() - 1)
    }
}

/// An edge's number and where on it a point is, told in the edge's own direction.
fn on_edge(shape: &Shape, face: u32, corner: usize, t: f64) -> (u32, f64) {
    let is_forward = shape.is_forward(face as usize, corner);
    let edge = shape.edges_of[face as usize][corner];
    (edge, if is_forward { t } else { 1.0 - t })
}

/// The edge two places are both on, and where.
fn common_edge(ends: [Place; 2]) -> Option<(usize, [f64; 2])> {
    let on = |place: Place, edge: usize| match place {
        Place::Corner(corner) if corner == edge => Some(0.0),
        Place::Corner(corner) if corner == (edge + 1) % 3 => Some(1.0),
        Place::Edge { corner, t } if corner == edge => Some(t),
        _ => None,
    };
    (0..3).find_map(|edge| Some((edge, [on(ends[0], edge)?, on(ends[1], edge)?])))
}

/// The points where segments end, cross and meet, none within `snap` of another, and the links
/// between them that make up the segments.
///
/// A segment is bent, by no more than `snap`, to go through all points that near to it. So
/// segments on top of each other become one.
struct Points {
    snap: f64,
    /// The first three are the triangle's corners.
    at: Vec<DVec2>,
    links: BTreeSet<[u32; 2]>,
    /// The points of each cell of a grid as wide as `snap`.
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl Points {
    /// `None` if there are too many.
    fn of(segments: &[[DVec2; 2]], frame: &Frame, snap: f64) -> Option<Self> {
        if segments.len() > MAX_SEGMENTS {
            return None;
        }
        let mut points = Self {
            snap,
            at: Vec::new(),
            links: BTreeSet::new(),
            cells: HashMap::new(),
        };
        for &at in frame.corners.iter().chain(segments.as_flattened()) {
            points.add(at);
        }
        points.add_crossings(segments)?;
        points.link(segments);
        Some(points)
    }

    fn add(&mut self, at: DVec2) {
        let [x, y] = (at / self.snap).floor().to_array().map(|c| c as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        let is_known = (around.filter_map(|cell| self.cells.get(&cell)).flatten())
            .any(|&i| self.at[i as usize].distance(at) <= self.snap);
        if !is_known {
            let cell = self.cells.entry([x, y]).or_default();
            cell.push(self.at.len() as u32);
            self.at.push(at);
        }
    }

    /// Segments sorted by where they begin, each against those that begin before it ends.
    fn add_crossings(&mut self, segments: &[[DVec2; 2]]) -> Option<()> {
        let mut sorted: Vec<[DVec2; 2]> = (segments.iter())
            .map(|&[a, b]| if a.x <= b.x { [a, b] } else { [b, a] })
            .collect();
        sorted.sort_by(|a, b| a[0].x.total_cmp(&b[0].x));
        for (i, &first) in sorted.iter().enumerate() {
            let rest = sorted[i + 1..].iter();
            for &second in rest.take_while(|second| second[0].x <= first[1].x) {
                if let Some(at) = crossing(first, second) {
                    self.add(at);
                }
            }
            if self.at.len() > MAX_POINTS {
                return None;
            }
        }
        Some(())
    }

    fn link(&mut self, segments: &[[DVec2; 2]]) {
        let mut by_x: Vec<u32> = (0..self.at.len() as u32).collect();
        let x = |i: u32| self.at[i as usize].x;
        by_x.sort_by(|&i, &j| x(i).total_cmp(&x(j)).then(i.cmp(&j)));
        let mut links = BTreeSet::new();
        for &[a, b] in segments {
            let start = by_x.partition_point(|&i| x(i) < a.x.min(b.x) - self.snap);
            let end = by_x.partition_point(|&i| x(i) <= a.x.max(b.x) + self.snap);
            let mut passed: Vec<(f64, u32)> = (by_x[start..end].iter())
                .filter_map(|&i| Some((self.passes([a, b], self.at[i as usize])?, i)))
                .collect();
            passed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for pair in passed.windows(2) {
                let [i, j] = [pair[0].1, pair[1].1];
                links.insert([i.min(j), i.max(j)]);
            }
        }
        self.links = links;
    }

    /// Where along a segment it passes a point.
    fn passes(&self, [a, b]: [DVec2; 2], point: DVec2) -> Option<f64> {
        let along = b - a;
        let t = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (a.lerp(b, t).distance(point) <= self.snap).then(|| (point - a).dot(along))
    }
}

/// Where two segments cross.
fn crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<DVec2> {
    let (first, second) = (b - a, d - c);
    let area = first.perp_dot(second);
    let s = (c - a).perp_dot(second) / area;
    let t = (c - a).perp_dot(first) / area;
    // Parallel segments divide by zero, and what is not a number is not in the range.
    let on = 0.0..=1.0;
    (on.contains(&s) && on.contains(&t)).then(|| a.lerp(b, s))
}
