use std::collections::BTreeMap;

use super::shape::Shape;
use super::weights::ONE;

/// What triangles want on an edge, as weights of its second end.
#[derive(Default)]
pub(super) struct Wants {
    /// Points on it.
    pub(super) points: Vec<f64>,
    /// Parts that are contacts. Their ends are among `points`.
    pub(super) contacts: Vec<[f64; 2]>,
}

/// The points on edges, each computed from its edge alone.
pub(super) struct EdgePoints {
    by_edge: BTreeMap<u32, Points>,
    nodes_end: u32,
}

/// The points on an edge, ends included.
pub(super) struct Points {
    /// Of each point: the weight of the edge's second end, rising from 0 to [`ONE`].
    pub(super) at: Vec<u32>,
    /// Of each point: its number among all points of the surfaces.
    pub(super) nodes: Vec<u32>,
    /// Of each piece, from a point to the next.
    pub(super) is_contact: Vec<bool>,
}

impl EdgePoints {
    /// Merges what is wanted within the snapping distance.
    pub(super) fn new(shape: &Shape, wants: BTreeMap<u32, Wants>) -> Self {
        let mut next = shape.positions.len() as u32;
        let mut by_edge = BTreeMap::new();
        for (index, wants) in wants {
            let ends = shape.edges[index as usize].ends;
            let [a, b] = ends.map(|end| shape.positions[end as usize]);
            let mut points = Points::merged(wants.points, shape.snap / a.distance(b));
            let inner = points.at.len() as u32 - 2;
            points.nodes.push(ends[0]);
            points.nodes.extend(next..next + inner);
            points.nodes.push(ends[1]);
            next += inner;
            for contact in wants.contacts {
                let [from, to] = contact.map(|t| points.nearest(t));
                points.is_contact[from.min(to)..from.max(to)].fill(true);
            }
            by_edge.insert(index, points);
        }
        Self {
            by_edge,
            nodes_end: next,
        }
    }

    /// The points on an edge, if there are any but its ends or it is a contact.
    pub(super) fn of(&self, edge: u32) -> Option<&Points> {
        self.by_edge.get(&edge)
    }

    /// The first number that no position and no point on an edge has.
    pub(super) fn nodes_end(&self) -> u32 {
        self.nodes_end
    }
}

impl Points {
    fn merged(mut wanted: Vec<f64>, snap: f64) -> Self {
        wanted.sort_by(f64::total_cmp);
        let mut at = vec![0];
        let mut last = 0.0;
        for t in wanted {
            let rounded = (t.clamp(0.0, 1.0) * f64::from(ONE)).round() as u32;
            let is_new = at.last().is_some_and(|&last| last < rounded) && rounded < ONE;
            if t - last > snap && 1.0 - t > snap && is_new {
                last = t;
                at.push(rounded);
            }
        }
        at.push(ONE);
        Self {
            is_contact: vec![false; at.len() - 1],
            nodes: Vec::with_capacity(at.len()),
            at,
        }
    }

    /// The index of the point nearest to `t`.
    pub(super) fn nearest(&self, t: f64) -> usize {
        let t = t * f64::from(ONE);
        let after = self.at.partition_point(|&at| f64::from(at) < t);
        let before = after.saturating_sub(1);
        let after = after.min(self.at.len() - 1);
        let is_before_nearer = t - f64::from(self.at[before]) <= f64::from(self.at[after]) - t;
        if is_before_nearer { before } else { after }
    }
}
