//! How far the raised surface is from a face.

use glam::{Vec2, Vec3};

use super::heights::Heights;
use crate::height_map::{Block, Kernel, PlanePyramid, Wrap};

/// A face whose corners are raised, and what it stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Of the corners on the base.
    pub(super) base: [Vec3; 3],
    /// Of the corners.
    pub(super) directions: [Vec3; 3],
    /// Of the corners.
    pub(super) uvs: [Vec2; 3],
    /// To which the corners are raised.
    pub(super) heights: [f32; 3],
    /// How far these are from what the map says, because other charts say otherwise.
    pub(super) gaps: [f32; 3],
    /// Which sides lie on seams.
    pub(super) seams: [bool; 3],
}

/// Finds where the surface is farthest from a face.
pub(super) struct Deviation<'a> {
    heights: Heights<'a>,
    bounds: &'a PlanePyramid,
    /// Of the map.
    size: Vec2,
    wrap: [Wrap; 2],
}

/// Points at which every face is looked at. What is quadratic on a face is farthest from it at the middle of
/// an edge or of the face.
const POINTS: [Vec3; 4] = [
    Vec3::new(0.5, 0.5, 0.0),
    Vec3::new(0.0, 0.5, 0.5),
    Vec3::new(0.5, 0.0, 0.5),
    Vec3::new(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0),
];

/// What the surface may be off elsewhere, as a multiple of what it is at those points: a saddle, its axes
/// turned, has its largest distance between them.
const BETWEEN: f32 = 1.12;

/// In faces smaller than this, in texels, there is nothing that those points could miss.
const SMALL: f32 = 1.5;

/// In faces smaller than this, in texels, it is looked between them, too.
const BETWEEN_TEXELS: f32 = 8.0;

/// Faces with more repetitions of the map than this a side are not looked at in detail.
const MANY: i64 = 4;

/// The largest distance is looked for until no block can have more than so many times what was found.
const HALF: f32 = 2.0;

impl<'a> Deviation<'a> {
    pub(super) fn new(heights: Heights<'a>, bounds: &'a PlanePyramid) -> Self {
        let [width, height] = heights.map.size();
        Self {
            bounds,
            size: Vec2::new(width as f32, height as f32),
            wrap: heights.map.wrap(),
            heights,
        }
    }

    /// Texture coordinates as texels, 0 at the centre of the first.
    fn texel(&self, uv: Vec2) -> Vec2 {
        uv * self.size - 0.5
    }

    /// The longest side of a face on the map, in texels.
    pub(super) fn texels(&self, uvs: [Vec2; 3]) -> f32 {
        let [a, b, c] = uvs.map(|uv| self.texel(uv));
        let sides = [b - a, c - b, a - c];
        sides.map(Vec2::length).into_iter().fold(0.0, f32::max)
    }

    /// Whether the raised surface is further from a face than `limit`, and if so a distance that is; else the
    /// largest that was come by.
    pub(super) fn beyond(&self, face: &Face, limit: f32) -> f32 {
        self.search(face, limit, limit)
    }

    /// The largest distance from the raised surface to a face, in metres, or no less than half of it. Of what
    /// is no larger than `least` perhaps nothing.
    pub(super) fn largest(&self, face: &Face, least: f32) -> f32 {
        self.search(face, least, f32::INFINITY)
    }

    fn search(&self, face: &Face, least: f32, enough: f32) -> f32 {
        let mut search = Search::new(self, face, least, enough);
        for point in POINTS {
            if search.found * BETWEEN <= enough {
                search.look(point);
            }
        }
        search.found *= BETWEEN;
        if search.longest > SMALL && search.found <= enough {
            search.descend();
        }
        search.found
    }
}

/// A search for the largest distance on one face.
struct Search<'a> {
    of: &'a Deviation<'a>,
    face: &'a Face,
    raised: [Vec3; 3],
    /// Corners on the map.
    texels: [Vec2; 3],
    /// Height of each corner over the opposite side, in texels.
    altitudes: [f32; 3],
    /// Gradients of the weights of corners by texel; `None` where the face is nothing on the map.
    gradients: Option<[Vec2; 3]>,
    /// Longest side on the map, in texels.
    longest: f32,
    /// Longest direction, and what distances may be beyond differences of height.
    stretch: f32,
    slack: f32,
    /// What need not be found, what need not be exceeded, and what is found so far.
    least: f32,
    enough: f32,
    found: f32,
}

impl<'a> Search<'a> {
    fn new(of: &'a Deviation<'a>, face: &'a Face, least: f32, enough: f32) -> Self {
        let texels = face.uvs.map(|uv| of.texel(uv));
        let area = (texels[1] - texels[0]).perp_dot(texels[2] - texels[0]);
        let opposite = [0, 1, 2].map(|i| texels[(i + 2) % 3] - texels[(i + 1) % 3]);
        let range = |values: [f32; 3]| {
            let [a, b, c] = values;
            a.max(b).max(c) - a.min(b).min(c)
        };
        let [d, e, f] = face.directions;
        let spread = d.distance(e).max(e.distance(f)).max(f.distance(d));
        Self {
            of,
            face,
            raised: [0, 1, 2].map(|i| face.base[i] + face.heights[i] * face.directions[i]),
            texels,
            altitudes: opposite.map(|side| area.abs() / side.length().max(f32::MIN_POSITIVE)),
            gradients: (area != 0.0).then(|| opposite.map(|side| side.perp() / area)),
            longest: of.texels(face.uvs),
            stretch: d.length().max(e.length()).max(f.length()),
            // The covariance of two things over the weights is at most a quarter of their ranges' product.
            slack: 0.25 * range(face.heights) * spread,
            least,
            enough,
            found: 0.0,
        }
    }

    /// The distance at one point, if it may be more than what is known.
    fn look(&mut self, weights: Vec3) {
        let face = self.face;
        let uv = face.uvs[0] * weights.x + face.uvs[1] * weights.y + face.uvs[2] * weights.z;
        let height = self.of.heights.height(uv);
        if self.at_most(weights, height) <= self.found {
            return;
        }
        let mix = |values: &[Vec3; 3]| {
            values[0] * weights.x + values[1] * weights.y + values[2] * weights.z
        };
        let surface = mix(&face.base) + height * mix(&face.directions);
        let distance = distance_to_triangle(surface, self.raised);
        self.found = self
            .found
            .max(distance - self.allowance(weights.to_array()));
    }

    /// How far the surface at this height may be off: no farther than heights differ.
    fn at_most(&self, weights: Vec3, height: f32) -> f32 {
        let off = (height - weights.dot(Vec3::from(self.face.heights))).abs();
        off * self.stretch + self.slack
    }

    /// Within a texel of a seam the charts of both sides are joined, and what they differ by is no error.
    fn allowance(&self, weights: [f32; 3]) -> f32 {
        let gaps = self.face.gaps.map(f32::abs);
        if gaps == [0.0; 3] {
            return 0.0;
        }
        let mut allowance = 0.0_f32;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            if (1.0 - weights[i]) * self.altitudes[i] < 1.0 {
                allowance = allowance.max(gaps[i]);
            }
            if self.face.seams[i] && weights[k] * self.altitudes[k] < 1.0 {
                allowance = allowance.max(gaps[i]).max(gaps[j]);
            }
        }
        allowance * self.stretch
    }

    /// Looks at the texels of the face, block by block, the largest first.
    fn descend(&mut self) {
        let [a, b, c] = self.texels;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let tiles = [0, 1].map(|axis| match self.of.wrap[axis] {
            Wrap::Repeat => {
                let n = self.of.size[axis];
                (low[axis] / n).floor() as i64..=(high[axis] / n).floor() as i64
            }
            Wrap::Clamp => 0..=0,
        });
        let count = |axis: usize| tiles[axis].end() - tiles[axis].start() + 1;
        let top = self.of.bounds.top();
        if count(0) > MANY || count(1) > MANY || self.gradients.is_none() {
            self.take_whole_map(top);
            return;
        }
        // Blocks as large as the face: it has at most four of them in each repetition.
        let extent = (high - low).max_element();
        let level = (0..top).find(|&l| PlanePyramid::side(l) as f32 >= extent);
        let level = level.unwrap_or(top);
        for row in tiles[1].clone() {
            for column in tiles[0].clone() {
                let offset = Vec2::new(column as f32, row as f32) * self.of.size;
                let side = PlanePyramid::side(level) as f32;
                let block = |p: Vec2, axis: usize| {
                    let block = ((p - offset) / side)[axis].max(0.0) as u32;
                    block.min(self.of.bounds.size(level)[axis] - 1)
                };
                for y in block(low, 1)..=block(high, 1) {
                    for x in block(low, 0)..=block(high, 0) {
                        self.visit(offset, level, [x, y]);
                    }
                }
            }
        }
    }

    /// Such a face has all of the map in it, or all of a line of it: it is as far off as heights differ.
    fn take_whole_map(&mut self, top: usize) {
        let Some(block) = self.of.bounds.block(top, [0, 0]) else {
            return;
        };
        let half = 0.5 * self.of.size;
        let corners = [
            half,
            -half,
            half * Vec2::new(1.0, -1.0),
            half * Vec2::new(-1.0, 1.0),
        ];
        let planes = corners.map(|p| block.slopes.dot(p));
        let low = planes.into_iter().fold(0.0, f32::min) + block.below;
        let high = planes.into_iter().fold(0.0, f32::max) + block.above;
        let range = (high - low) * self.of.heights.scale.abs();
        self.found = self.found.max(0.5 * range * self.stretch);
    }

    fn visit(&mut self, offset: Vec2, level: usize, at: [u32; 2]) {
        let Some(block) = self.of.bounds.block(level, at) else {
            return;
        };
        let [low, high] = self.of.bounds.extent(level, at).map(|p| p + offset);
        let Some([low, high]) = self.shared(low, high) else {
            return;
        };
        let middle = PlanePyramid::middle(level, at) + offset;
        let most = self.most(&block, middle, [low, high]);
        let worth_it = match self.found > self.least {
            true => HALF * self.found,
            false => self.least,
        };
        if self.found > self.enough || most * self.stretch + self.slack <= worth_it {
            return;
        }
        if level == 0 {
            self.look_at_texels([low, high]);
            return;
        }
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            self.visit(offset, level - 1, [2 * at[0] + dx, 2 * at[1] + dy]);
        }
    }

    /// What of a rectangle may lie in the face, as a rectangle.
    fn shared(&self, low: Vec2, high: Vec2) -> Option<[Vec2; 2]> {
        let [a, b, c] = self.texels;
        let (low, high) = (low.max(a.min(b).min(c)), high.min(a.max(b).max(c)));
        if low.x > high.x || low.y > high.y {
            return None;
        }
        // Outside if one weight is negative at all corners.
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let weights = self.weights(middle).to_array();
        let gradients = self.gradients?;
        let outside = |i: usize| weights[i] + gradients[i].abs().dot(half) < 0.0;
        (!(0..3).any(outside)).then_some([low, high])
    }

    /// The most that heights may differ from the face's in a rectangle, in metres.
    fn most(&self, block: &Block, middle: Vec2, [low, high]: [Vec2; 2]) -> f32 {
        let heights = &self.of.heights;
        let scale = heights.scale;
        let off = |p: Vec2| {
            let plane = scale * (block.plane(p - middle) - heights.mid_level);
            plane - self.weights(p).dot(Vec3::from(self.face.heights))
        };
        let corners = [
            low,
            high,
            Vec2::new(low.x, high.y),
            Vec2::new(high.x, low.y),
        ]
        .map(off);
        let (below, above) = match scale < 0.0 {
            true => (scale * block.above, scale * block.below),
            false => (scale * block.below, scale * block.above),
        };
        let lowest = corners.into_iter().fold(f32::INFINITY, f32::min) + below;
        let highest = corners.into_iter().fold(f32::NEG_INFINITY, f32::max) + above;
        lowest.abs().max(highest.abs())
    }

    /// Looks at the texels in a rectangle; in smaller faces between them, too.
    fn look_at_texels(&mut self, [low, high]: [Vec2; 2]) {
        let whole = |axis: usize| low[axis].ceil() as i64..=high[axis].floor() as i64;
        for y in whole(1) {
            for x in whole(0) {
                let weights = self.weights(Vec2::new(x as f32, y as f32));
                // Most texels are done with here.
                if weights.min_element() >= 0.0 && self.is_worth_it(weights, [x, y]) {
                    self.look(weights);
                    if self.found > self.enough {
                        return;
                    }
                }
            }
        }
        if self.longest > BETWEEN_TEXELS {
            return;
        }
        let half =
            |axis: usize| (low[axis] - 0.5).ceil() as i64..=(high[axis] - 0.5).floor() as i64;
        for y in half(1) {
            for x in half(0) {
                let weights = self.weights(Vec2::new(x as f32, y as f32) + 0.5);
                if weights.min_element() >= 0.0 && self.found <= self.enough {
                    self.look(weights);
                }
            }
        }
    }

    /// Whether the surface at a texel may be further off than what is known.
    fn is_worth_it(&self, weights: Vec3, [x, y]: [i64; 2]) -> bool {
        let heights = &self.of.heights;
        if heights.kernel == Kernel::BSpline {
            // Passes by the texels.
            return true;
        }
        let height = heights.scale * (heights.map.texel(x, y) - heights.mid_level);
        self.at_most(weights, height) > self.found.max(self.least)
    }

    /// Weights of the corners at a place on the map.
    fn weights(&self, p: Vec2) -> Vec3 {
        let gradients = self.gradients.unwrap_or_default();
        // From the corner opposite: what rounding takes stays small on small faces far out.
        let [_, b, c] = [0, 1, 2].map(|i| gradients[i].dot(p - self.texels[0]));
        Vec3::new(1.0 - b - c, b, c)
    }
}

/// The distance of a point from a triangle (C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5).
pub(super) fn distance_to_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac) = (b - a, c - a);
    let of = |corner: Vec3| (ab.dot(p - corner), ac.dot(p - corner));
    let ((d1, d2), (d3, d4), (d5, d6)) = (of(a), of(b), of(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return p.distance(a);
    }
    if d3 >= 0.0 && d4 <= d3 {
        return p.distance(b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return p.distance(a + ab * (d1 / (d1 - d3)));
    }
    if d6 >= 0.0 && d5 <= d6 {
        return p.distance(c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return p.distance(a + ac * (d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return p.distance(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    let sum = va + vb + vc;
    p.distance(a + ab * (vb / sum) + ac * (vc / sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside each side, at each corner, and over the middle; against the nearest of many points.
    #[test]
    fn distances_are_to_the_nearest_point() {
        let triangle = [
            Vec3::ZERO,
            Vec3::new(2.0, 0.0, 0.0),
            Vec3::new(0.5, 1.5, 0.5),
        ];
        let n = 200;
        for i in 0..9 {
            for j in 0..9 {
                for z in [-0.7, 0.3] {
                    let p = Vec3::new(i as f32 * 0.5 - 1.0, j as f32 * 0.5 - 1.0, z);
                    let mut nearest = f32::INFINITY;
                    for a in 0..=n {
                        for b in 0..=n - a {
                            let w = Vec3::new(a as f32, b as f32, (n - a - b) as f32) / n as f32;
                            let q = triangle[0] * w.x + triangle[1] * w.y + triangle[2] * w.z;
                            nearest = nearest.min(p.distance(q));
                        }
                    }
                    let found = distance_to_triangle(p, triangle);
                    assert!((found - nearest).abs() < 0.01, "{p}: {found}, {nearest}");
                }
            }
        }
    }
}
