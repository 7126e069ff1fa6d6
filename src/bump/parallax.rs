//! Where a ray of sight that meets a mesh meets the relief on it, the mesh staying as it is (T. Kaneko et al.,
//! "Detailed shape representation with parallax mapping", ICAT 2001; here exactly, by stepping through the map).
//!
//! # From the view to the map
//!
//! At `P` of a mesh with the unit normal `N`, seen from the direction `V`, relief stands along `D`: `N` itself, or
//! what the mesh's own normal becomes under an uneven scale. What is seen lies on the ray, and a depth `d` below
//! the place `P + Δ` of the mesh:
//!
//! ```text
//!   P − t V = P + Δ − d D                            Δ in the surface: times N,  t = d (D · N)/(V · N)
//!
//!        ┌────────────────────────────────────┐
//!   Δ =  │  d (D_∥ − (D · N) V_∥ / (V · N))    │      _∥: the part in the surface
//!        └────────────────────────────────────┘
//! ```
//!
//! Texture coordinates change along it by `∇u · Δ`, `∇v · Δ`: by the surface gradients that bumps use, without
//! tangents and without dividing by the area of a triangle in texture coordinates. All coordinates of the surface
//! move by the same `Δ`, whichever of them the map lies on. As `V · N` vanishes `Δ` grows without bound, and the
//! picture would slide on the surface: `|V_∥| / (V · N)` is cut at a slope that the material gives.
//!
//! # Through the map
//!
//! In texels, the ray sinks over a line while `s` goes from the highest point of the map (0) to the lowest (1).
//! The surface between four texels is bilinear, so on the line through such a *patch* it is a parabola, and where
//! the ray meets it is a square root:
//!
//! ```text
//!   f(s) = surface − (1 − s) = A s² + B s + C,  C < 0      ┌──────────────────────────────┐
//!                                                          │  s = −2C / (B + √(B² − 4AC))  │
//!   the first zero, if there is one:                       └──────────────────────────────┘
//! ```
//!
//! No step can miss what lies between two of them, however thin. Patches that lie wholly below the ray are passed
//! over in blocks ([`Bounds`]): one read each.

use glam::{BVec2, IVec2, Vec2, Vec3};

use crate::height_map::{Bounds, HeightMap, Pyramid, Wrap};

/// Reads of bounds at most. Rays over the roughest maps take less than half of it.
const MOST_STEPS: u32 = 512;
/// Cosines and slopes below this are none.
const LEAST: f32 = 1e-6;

/// A ray of sight over a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallaxRay {
    /// Texture coordinates where it meets the mesh.
    pub uv: Vec2,
    /// What they change by while it sinks from the map's highest point to its lowest.
    pub slide: Vec2,
    /// How high the mesh lies between the map's lowest point (0) and its highest (1).
    pub level: f32,
    /// The map is seen from behind, or its heights are depths.
    pub is_inverted: bool,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallaxHit {
    /// Depth below the mesh, the map's range being 1; negative above it.
    pub depth: f32,
    /// Texels that were read.
    pub reads: u32,
}

impl ParallaxHit {
    /// Texture coordinates of what is seen.
    pub fn uv(self, ray: ParallaxRay) -> Vec2 {
        ray.uv + self.depth * ray.slide
    }
}

/// How far what is seen moves along the surface by depth: `Δ/d` above. `steepest` is the greatest
/// `|V_∥| / (V · N)` that is followed.
///
/// Finite for all unit vectors, also where the view lies in the surface or behind it.
pub fn parallax_slide(normal: Vec3, view: Vec3, up: Vec3, steepest: f32) -> Vec3 {
    let towards = view.dot(normal);
    let upright = up.dot(normal);
    let along = view - towards * normal;
    let cosine = towards.max(along.length() / steepest).max(LEAST);
    up - upright * normal - along * (upright / cosine)
}

/// A map as rays go through it.
#[derive(Clone, Debug)]
pub struct ParallaxMap {
    pyramid: Pyramid,
    bounds: Bounds,
    repeats: BVec2,
    /// The lowest height, and what makes heights above it shares of the range.
    shares: [f32; 2],
}

/// Patches of a block: those from the first to the last before `end`, along both axes.
#[derive(Clone, Copy)]
struct Block {
    /// Where the map begins there, if it repeats.
    period: IVec2,
    first: IVec2,
    end: IVec2,
}

/// The line of a ray through a level of the map, in texels: at `start + s slope`, the ray's height is `1 − s`.
struct Line {
    start: Vec2,
    slope: Vec2,
}

impl Line {
    fn at(&self, s: f32) -> Vec2 {
        self.start + s * self.slope
    }

    /// Where it leaves a block, axis by axis.
    fn leaves(&self, block: Block) -> Vec2 {
        let rises = self.slope.cmpgt(Vec2::ZERO);
        let border = Vec2::select(rises, block.end.as_vec2(), block.first.as_vec2());
        let moves = self.slope.abs().cmpgt(Vec2::splat(LEAST));
        let slope = Vec2::select(moves, self.slope, Vec2::ONE);
        Vec2::select(moves, (border - self.start) / slope, Vec2::splat(2.0))
    }

    /// The patch at a place within a block. Never back from one that it was in: at borders rounding would let it
    /// go to and fro.
    fn onward(&self, s: f32, patch: IVec2, block: Block) -> IVec2 {
        let at = self.at(s).floor().as_ivec2();
        let rises = self.slope.cmpgt(Vec2::ZERO);
        let onward = IVec2::select(rises, at.max(patch), at.min(patch));
        onward.clamp(block.first, block.end - 1)
    }

    /// The patch that it goes into from a block.
    fn beyond(&self, s: f32, patch: IVec2, block: Block, leaves: Vec2) -> IVec2 {
        let rises = self.slope.cmpgt(Vec2::ZERO);
        let beyond = IVec2::select(rises, block.end, block.first - 1);
        let crosses = BVec2::new(leaves.x <= leaves.y, leaves.x > leaves.y);
        IVec2::select(crosses, beyond, self.onward(s, patch, block))
    }
}

impl ParallaxMap {
    /// Of a map.
    pub fn new(map: &HeightMap) -> Self {
        let pyramid = Pyramid::new(map);
        let [u, v] = map.wrap().map(|wrap| wrap == Wrap::Repeat);
        let [low, high] = pyramid.range();
        Self {
            shares: [low, if high > low { 1.0 / (high - low) } else { 0.0 }],
            bounds: Bounds::new(map, &pyramid),
            pyramid,
            repeats: BVec2::new(u, v),
        }
    }

    /// The first point of the surface on a ray, on the `mip`th level of the map's [`Pyramid`].
    ///
    /// # Panics
    ///
    /// If there is no such level.
    pub fn march(&self, ray: ParallaxRay, mip: usize) -> ParallaxHit {
        let size = IVec2::from(self.pyramid.levels()[mip].size().map(|n| n as i32));
        let slope = ray.slide * size.as_vec2();
        let uv = Vec2::select(self.repeats, ray.uv - ray.uv.floor(), ray.uv);
        let line = Line {
            start: uv * size.as_vec2() - 0.5 - slope * (1.0 - ray.level),
            slope,
        };
        let coarsest = (self.bounds.levels().len() - 1 - mip) as i32;
        let mut level = (slope.length().max(1.0).log2() as i32 - 3).clamp(0, coarsest);
        let (mut s, mut reads) = (0.0_f32, 0);
        let mut patch = line.at(s).floor().as_ivec2();
        for _ in 0..MOST_STEPS {
            let block = self.block(patch, size, level);
            let leaves = line.leaves(block);
            let out = leaves.min_element().min(1.0).max(s);
            let inside = (patch - block.period).clamp(IVec2::ZERO, size - 1);
            let ceiling = self.ceiling(inside, mip, level, ray.is_inverted);
            reads += 1;
            if 1.0 - out <= ceiling {
                if level > 0 {
                    // Down to where the ray is as low as the block's highest point.
                    s = s.max(1.0 - ceiling).min(out);
                    patch = line.onward(s, patch, block);
                    level -= 1;
                    continue;
                }
                reads += 4;
                let corners = self.corners(patch - block.period, mip, ray.is_inverted);
                if let Some(hit) = meets(&line, patch, corners, [s, out]) {
                    s = hit;
                    break;
                }
            }
            s = out;
            if out >= 1.0 {
                break;
            }
            let next = line.beyond(s, patch, block, leaves);
            // Larger blocks again where one of them begins.
            if (next >> (level + 1)) != (patch >> (level + 1)) {
                level = (level + 1).min(coarsest);
            }
            patch = next;
        }
        ParallaxHit {
            depth: s - (1.0 - ray.level),
            reads,
        }
    }

    /// The block of a level that a patch is in: cut off where a map begins again.
    fn block(&self, patch: IVec2, size: IVec2, level: i32) -> Block {
        let period = patch - IVec2::select(self.repeats, patch.rem_euclid(size), patch);
        let first = (((patch - period) >> level) << level) + period;
        let end = first + (1 << level);
        Block {
            period,
            first,
            end: IVec2::select(self.repeats, end.min(period + size), end),
        }
    }

    /// Height that nothing in the block with this patch goes beyond.
    fn ceiling(&self, patch: IVec2, mip: usize, level: i32, is_inverted: bool) -> f32 {
        let blocks = &self.bounds.levels()[mip + level as usize];
        let size = IVec2::from(blocks.size().map(|n| n as i32));
        // The last block takes what is left over.
        let at = (patch >> level).min(size - 1);
        let block = blocks.blocks()[(at.y * size.x + at.x) as usize];
        f32::from(block[usize::from(is_inverted)]) / 255.0
    }

    /// Heights 0 to 1 of the corners of a patch: (0, 0), (1, 0), (0, 1), (1, 1).
    fn corners(&self, patch: IVec2, mip: usize, is_inverted: bool) -> [f32; 4] {
        let level = &self.pyramid.levels()[mip];
        let [low, scale] = self.shares;
        let size = IVec2::from(level.size().map(|n| n as i32));
        let corners = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE].map(|corner| patch + corner);
        corners.map(|at| {
            let at = IVec2::select(self.repeats, at.rem_euclid(size), at);
            let at = at.clamp(IVec2::ZERO, size - 1);
            let texel = level.texels()[(at.y * size.x + at.x) as usize];
            let share = (texel.height - low) * scale;
            if is_inverted { 1.0 - share } else { share }
        })
    }
}

/// Where between two points of a line the ray meets a patch with these corners, if it does.
fn meets(line: &Line, patch: IVec2, corners: [f32; 4], [s, out]: [f32; 2]) -> Option<f32> {
    let [h00, h10, h01, h11] = corners;
    let at = line.at(s) - patch.as_vec2();
    // h00 + x across + y down + x y twist.
    let (across, down, twist) = (h10 - h00, h01 - h00, h11 - h10 - h01 + h00);
    let c = h00 + at.x * across + at.y * down + at.x * at.y * twist - (1.0 - s);
    if c >= 0.0 {
        return Some(s);
    }
    let k = line.slope;
    let b = k.x * across + k.y * down + (at.x * k.y + at.y * k.x) * twist + 1.0;
    let a = k.x * k.y * twist;
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let further = -2.0 * c / (b + root).max(f32::MIN_POSITIVE);
    let is_real = b * b >= 4.0 * a * c && b + root > 0.0;
    (is_real && s + further <= out).then_some(s + further)
}
