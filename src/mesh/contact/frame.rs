use glam::{DVec2, DVec3};

/// Triangles lower than this part of their longest edge have no plane to speak of.
const LOWEST: f64 = 1e-6;

/// A triangle with equal edges, to cut those in that have no plane.
pub(super) const EQUILATERAL: [DVec2; 3] = [
    DVec2::ZERO,
    DVec2::X,
    DVec2::new(0.5, 0.866_025_403_784_438_6),
];

/// A triangle's plane with coordinates in which its longest edge has length 1.
pub(super) struct Frame {
    origin: DVec3,
    /// What lengths are multiplied with.
    pub(super) scale: f64,
    x: DVec3,
    y: DVec3,
    normal: DVec3,
    /// Counter-clockwise, the first at the origin.
    pub(super) corners: [DVec2; 3],
    /// Unit normals of the edges from the corners to the next ones, inwards.
    inward: [DVec2; 3],
}

impl Frame {
    /// `None` for a triangle without area.
    pub(super) fn new([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let scale = 1.0 / a.distance(b).max(b.distance(c)).max(c.distance(a));
        let (to_b, to_c) = ((b - a) * scale, (c - a) * scale);
        let area = to_b.cross(to_c).length();
        if area.is_nan() || area < LOWEST {
            return None;
        }
        let normal = to_b.cross(to_c) / area;
        let x = to_b.normalize();
        let y = normal.cross(x);
        let corners = [DVec3::ZERO, to_b, to_c].map(|p| DVec2::new(p.dot(x), p.dot(y)));
        let inward = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).perp().normalize());
        Some(Self {
            origin: a,
            scale,
            x,
            y,
            normal,
            corners,
            inward,
        })
    }

    pub(super) fn project(&self, point: DVec3) -> DVec2 {
        let offset = (point - self.origin) * self.scale;
        DVec2::new(offset.dot(self.x), offset.dot(self.y))
    }

    pub(super) fn height(&self, point: DVec3) -> f64 {
        ((point - self.origin) * self.scale).dot(self.normal)
    }

    /// How far inside of the edge from `corner` a point is.
    pub(super) fn depth(&self, corner: usize, point: DVec2) -> f64 {
        (point - self.corners[corner]).dot(self.inward[corner])
    }

    pub(super) fn weights(&self, point: DVec2) -> [f64; 3] {
        [0, 1, 2].map(|corner| {
            let opposite = (corner + 1) % 3;
            self.depth(opposite, point) / self.depth(opposite, self.corners[corner])
        })
    }

    /// Where on the edge from `corner` a point is, as the weight of its second end.
    pub(super) fn along(&self, corner: usize, point: DVec2) -> f64 {
        let edge = self.corners[(corner + 1) % 3] - self.corners[corner];
        (point - self.corners[corner]).dot(edge) / edge.length_squared()
    }

    /// Which part of the segment lies in the triangle. A segment that runs along an edge, not
    /// further than `snap` away, is inside of it.
    pub(super) fn clip(&self, [a, b]: [DVec2; 2], snap: f64) -> Option<[f64; 2]> {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for corner in 0..3 {
            let (start, end) = (self.depth(corner, a), self.depth(corner, b));
            if start.abs().max(end.abs()) <= snap {
                continue;
            }
            match (start >= 0.0, end >= 0.0) {
                (true, true) => {}
                (false, true) => from = from.max(start / (start - end)),
                (true, false) => to = to.min(start / (start - end)),
                (false, false) => return None,
            }
        }
        (from < to).then_some([from, to])
    }
}
