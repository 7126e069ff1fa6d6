use glam::DVec3;

/// A flat convex polygon, its corners anticlockwise seen from the front.
#[derive(Clone)]
pub(crate) struct Polygon {
    pub(crate) corners: Vec<DVec3>,
    pub(crate) normal: DVec3,
    /// Planes through the edges, inside where `normal · p >= offset`.
    edges: Vec<(DVec3, f64)>,
}

/// Nearer than this is on a plane, in metres: rounding of `f32` corners, far below all geometry.
pub(crate) const ON_PLANE: f64 = 1e-6;

impl Polygon {
    pub(crate) fn new(corners: Vec<DVec3>) -> Self {
        let fan = corners.windows(2).skip(1);
        let normal = fan.map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
        let normal = normal.sum::<DVec3>().normalize_or_zero();
        let next = corners.iter().cycle().skip(1);
        let edges = corners.iter().zip(next).map(|(&a, &b)| {
            let inward = normal.cross(b - a).normalize_or_zero();
            (inward, inward.dot(a))
        });
        Self {
            edges: edges.collect(),
            corners,
            normal,
        }
    }

    /// How far before its plane a point is.
    pub(crate) fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.corners[0])
    }

    /// How far a point of its plane is inside.
    pub(crate) fn depth(&self, p: DVec3) -> f64 {
        let depths = self.edges.iter().map(|(inward, at)| inward.dot(p) - at);
        depths.fold(f64::INFINITY, f64::min)
    }

    /// The share of the way between two points at which it is met, from either side.
    pub(crate) fn met(&self, from: DVec3, to: DVec3) -> Option<f64> {
        let (before, after) = (self.height(from), self.height(to));
        if before * after >= 0.0 {
            return None;
        }
        let t = before / (before - after);
        (self.depth(from.lerp(to, t)) >= 0.0).then_some(t)
    }

    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        let corners = self.corners.iter();
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &c| {
            [low.min(c), high.max(c)]
        })
    }

    pub(crate) fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    /// Whether another one comes nearer than `margin`, going by boxes around both.
    pub(crate) fn near(&self, other: &Self, margin: f64) -> bool {
        let ([a, b], [c, d]) = (self.bounds(), other.bounds());
        (a - margin).cmple(d).all() && (c - margin).cmple(b).all()
    }

    /// Its parts in a grid of cells of about a size, along the axes.
    pub(crate) fn cells(&self, size: f64) -> Vec<Self> {
        let [low, high] = self.bounds();
        let lines = DVec3::AXES.into_iter().flat_map(|axis| {
            let (from, along) = (axis.dot(low), axis.dot(high - low));
            let count = (along / size).ceil() as u32;
            (1..count).map(move |i| (axis, from + along * f64::from(i) / f64::from(count)))
        });
        lines.fold(vec![self.clone()], |cells, (axis, at)| {
            let cut = |cell: Self| cell.cut_by(|p| axis.dot(p) - at);
            cells.into_iter().flat_map(cut).collect()
        })
    }

    /// Its parts on the two sides of another's plane; one part if the plane does not cross it.
    pub(crate) fn cut(&self, plane: &Self) -> Vec<Self> {
        self.cut_by(|p| plane.height(p))
    }

    fn cut_by(&self, height: impl Fn(DVec3) -> f64) -> Vec<Self> {
        let heights: Vec<f64> = self.corners.iter().map(|&c| height(c)).collect();
        let side = |sign: f64| heights.iter().any(|h| h * sign > ON_PLANE);
        if !side(1.0) || !side(-1.0) {
            return vec![self.clone()];
        }
        let half = |sign: f64| {
            let mut kept = Vec::new();
            for (i, &here) in self.corners.iter().enumerate() {
                let j = (i + 1) % self.corners.len();
                let (h, g) = (heights[i] * sign, heights[j] * sign);
                if h >= 0.0 {
                    kept.push(here);
                }
                if h * g < 0.0 {
                    kept.push(here.lerp(self.corners[j], h / (h - g)));
                }
            }
            Self::new(kept)
        };
        vec![half(1.0), half(-1.0)]
    }
}
