use std::collections::HashMap;

use glam::{DVec3, Mat3, Vec2, Vec3};

use super::corner::corners;
use super::surface::Sheet;
use crate::height_map::Relief;
use crate::mesh::SurfacePoint;

/// How texture coordinates and directions change along the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Gradients of `u` and `v`, by metre.
    gradients: [Vec3; 2],
    /// Change of the direction along a step: by metre.
    bend: Mat3,
}

/// Frames at the corners of triangles. Those of a vertex are means over its triangles by angle, so that what
/// is interpolated between them does not jump at edges. Triangles that show the map mirrored are kept apart
/// from those that do not: the mean of the two would be no gradient of either.
#[derive(Debug, Default)]
pub(super) struct Frames {
    frames: Vec<Frame>,
    /// Of the corners of each triangle.
    of: Vec<[u32; 3]>,
    pub(super) zero_area: u64,
}

/// What an inner product of unit vectors is at least for an eigenvalue to count.
const STRAIGHT: f32 = 1e-12;

/// How near to folding heights may come that are kept from it.
const LEFT: f32 = 0.05;

impl Frames {
    pub(super) fn new(sheet: &Sheet) -> Self {
        let mut sums: Vec<(Frame, f32)> = Vec::new();
        let mut known: HashMap<(u32, bool), u32> = HashMap::new();
        let mut of = vec![[u32::MAX; 3]; sheet.triangles.len()];
        let mut facet: Option<(usize, Frame, bool)> = None;
        for corner in corners(sheet) {
            let (frame, mirrored) = match facet {
                Some((triangle, frame, mirrored)) if triangle == corner.triangle => {
                    (frame, mirrored)
                }
                _ => of_triangle(sheet, corner.triangle, corner.facet),
            };
            facet = Some((corner.triangle, frame, mirrored));
            let index = *known.entry((corner.vertex, mirrored)).or_insert_with(|| {
                sums.push((Frame::STILL, 0.0));
                (sums.len() - 1) as u32
            });
            let (sum, weight) = &mut sums[index as usize];
            *sum = sum.plus(frame.times(corner.angle as f32));
            *weight += corner.angle as f32;
            of[corner.triangle][corner.index] = index;
        }
        let mut frames: Vec<Frame> = (sums.iter())
            .map(|(sum, weight)| sum.times(1.0 / weight.max(f32::MIN_POSITIVE)))
            .collect();
        let zero_area = of.iter().filter(|of| of[0] == u32::MAX).count() as u64;
        if zero_area > 0 {
            // Where there is no area nothing changes along it.
            let none = frames.len() as u32;
            frames.push(Frame::STILL);
            of.iter_mut().flatten().for_each(|f| *f = (*f).min(none));
        }
        Self {
            frames,
            of,
            zero_area,
        }
    }

    pub(super) fn at(&self, point: SurfacePoint) -> Frame {
        let [a, b, c] = self.of[point.triangle as usize].map(|f| self.frames[f as usize]);
        let w = point.barycentrics;
        a.times(w.x).plus(b.times(w.y)).plus(c.times(w.z))
    }
}

/// The frame of a triangle, and whether it shows the map mirrored. With the edges `e₁`, `e₂` and the normal
/// `n`, the weights of the second and third corner have the gradients
///
/// ```text
///          e₂ × n                  n × e₁
///   g₁ = ─────────────      g₂ = ─────────────
///        n · (e₁ × e₂)           n · (e₁ × e₂)
/// ```
///
/// and what is linear on the triangle has the gradient that its differences and these two make.
fn of_triangle(sheet: &Sheet, triangle: usize, normal: Vec3) -> (Frame, bool) {
    let [a, b, c] = sheet.triangles[triangle].map(|v| v as usize);
    let at = |v: usize| sheet.positions[v].as_dvec3();
    let (e1, e2, n) = (at(b) - at(a), at(c) - at(a), normal.as_dvec3());
    let area = n.dot(e1.cross(e2));
    let [g1, g2]: [DVec3; 2] = [e2.cross(n) / area, n.cross(e1) / area];
    let [uv1, uv2] = [b, c].map(|v| (sheet.uvs[v] - sheet.uvs[a]).as_dvec2());
    let [d1, d2] = [b, c].map(|v| (sheet.directions[v] - sheet.directions[a]).as_dvec3());
    let gradient = |first: f64, second: f64| (first * g1 + second * g2).as_vec3();
    let bend = |axis: usize| (d1 * g1[axis] + d2 * g2[axis]).as_vec3();
    let frame = Frame {
        gradients: [gradient(uv1.x, uv2.x), gradient(uv1.y, uv2.y)],
        bend: Mat3::from_cols(bend(0), bend(1), bend(2)),
    };
    (frame, uv1.perp_dot(uv2) < 0.0)
}

impl Frame {
    /// Nothing changes.
    const STILL: Self = Self {
        gradients: [Vec3::ZERO; 2],
        bend: Mat3::ZERO,
    };

    fn plus(self, other: Self) -> Self {
        Self {
            gradients: [0, 1].map(|i| self.gradients[i] + other.gradients[i]),
            bend: self.bend + other.bend,
        }
    }

    fn times(self, weight: f32) -> Self {
        Self {
            gradients: self.gradients.map(|g| weight * g),
            bend: weight * self.bend,
        }
    }

    /// The surface gradient of the height.
    fn gradient(&self, slopes: Vec2) -> Vec3 {
        slopes.x * self.gradients[0] + slopes.y * self.gradients[1]
    }

    /// Unit normal of the raised surface, where the base has the normal `normal` and is raised along
    /// `direction`: see the [module](super) for the formula. That of the base where there is none.
    pub(super) fn raised_normal(&self, normal: Vec3, direction: Vec3, relief: Relief) -> Vec3 {
        let [a, b] = tangents(normal);
        let gradient = self.gradient(relief.slopes);
        let [a, b] = [a, b].map(|step| self.raised_step(step, direction, relief.height, gradient));
        // Slopes may be a thousand: products stay near 1.
        let raised = a.normalize_or_zero().cross(b.normalize_or_zero());
        match raised.try_normalize() {
            Some(n) if n.is_finite() => n,
            _ => normal,
        }
    }

    /// What a step along the base becomes on the raised surface.
    fn raised_step(&self, step: Vec3, direction: Vec3, height: f32, gradient: Vec3) -> Vec3 {
        step + height * (self.bend * step) + gradient.dot(step) * direction
    }

    /// The smallest and the largest curvature κ: by how much directions open, by metre. A surface that is
    /// raised by `h` is `1 + hκ` times as long there, and folds through itself where that is not above 0.
    pub(super) fn curvatures(&self, normal: Vec3) -> [f32; 2] {
        let [a, b] = tangents(normal);
        let (along_a, along_b) = (self.bend * a, self.bend * b);
        let (p, q) = (a.dot(along_a), b.dot(along_b));
        let mixed = 0.5 * (a.dot(along_b) + b.dot(along_a));
        let mean = 0.5 * (p + q);
        let spread = (0.25 * (p - q) * (p - q) + mixed * mixed).sqrt();
        [mean - spread, mean + spread]
    }

    /// The height itself, or as much of it as does not fold.
    pub(super) fn unfolded(&self, normal: Vec3, height: f32) -> f32 {
        let [smallest, largest] = self.curvatures(normal);
        let most = match smallest < -STRAIGHT {
            true => (1.0 - LEFT) / -smallest,
            false => f32::INFINITY,
        };
        let least = match largest > STRAIGHT {
            true => -(1.0 - LEFT) / largest,
            false => f32::NEG_INFINITY,
        };
        height.clamp(least, most)
    }
}

/// Whether a surface of these curvatures folds through itself if it is raised by so much.
pub(super) fn folds([smallest, largest]: [f32; 2], height: f32) -> bool {
    1.0 + height * smallest <= 0.0 || 1.0 + height * largest <= 0.0
}

/// Two unit vectors along a surface, the first turned left being the second as seen from outside.
fn tangents(normal: Vec3) -> [Vec3; 2] {
    let (a, b) = normal.any_orthonormal_pair();
    match normal.dot(a.cross(b)) < 0.0 {
        true => [b, a],
        false => [a, b],
    }
}
