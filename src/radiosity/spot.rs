use glam::{Vec2, Vec3, Vec3A};

use super::cells::{Part, cell_of, in_cell};
use super::element::{ElementId, Elements};
use super::gathered::NOT_CAST;
use super::occlusion::Hit;

/// Spots along an edge of an element, and in all of it.
pub(super) const ALONG: u16 = 2;
pub(super) const SPOTS: u32 = (ALONG * ALONG) as u32;

/// A place on an element: one of as many equal parts as tell the light on it from end to end.
///
/// Radiosity is solved for one number an element. What is gathered from the solution need not see
/// steps between elements: between their middles light is linear, as far as their neighbours know
/// (as M. F. Cohen and D. P. Greenberg did with patches, "The hemi-cube", SIGGRAPH 1985, section 6). That
/// makes elements twice as coarse as good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spot(pub(crate) u32);

impl Spot {
    /// The spot of an element at a point given in it.
    #[inline]
    pub(crate) fn new(element: u32, within: [f32; 2]) -> Self {
        Self(element * SPOTS + cell_of(within, ALONG).0)
    }

    /// The same of another element.
    pub(crate) fn of(self, element: u32) -> Self {
        Self(element * SPOTS + self.0 % SPOTS)
    }

    /// Whether it is one, and none of the marks that rays have in its place.
    pub(crate) fn is_one(self) -> bool {
        self.0 < NOT_CAST
    }

    pub(crate) fn element(self) -> ElementId {
        ElementId(self.0 / SPOTS)
    }
}

/// Where the neighbours of an element are looked for, in its own barycentrics: the middles of those across
/// its edges, and of those across its corners, if they are as large.
const AROUND: [Vec3; 6] = [
    Vec3::new(-THIRD, 2.0 * THIRD, 2.0 * THIRD),
    Vec3::new(2.0 * THIRD, -THIRD, 2.0 * THIRD),
    Vec3::new(2.0 * THIRD, 2.0 * THIRD, -THIRD),
    Vec3::new(5.0 * THIRD, -THIRD, -THIRD),
    Vec3::new(-THIRD, 5.0 * THIRD, -THIRD),
    Vec3::new(-THIRD, -THIRD, 5.0 * THIRD),
];

const THIRD: f32 = 1.0 / 3.0;

pub(super) const MIDDLE: Vec3 = Vec3::splat(THIRD);

/// Gradients of elements whose neighbours lie on a line say nothing across it.
const FLAT: f32 = 1e-3;

impl Elements {
    /// Light at the spots of all elements, from that of each element as a whole.
    ///
    /// On an element with the value `x` and the middle `c` it is
    ///
    /// ```text
    ///   ┌──────────────────────────┐
    ///   │  x + φ g · (p − c)         │   g = argmin Σ_k (x_k − x − g · (c_k − c))²
    ///   └──────────────────────────┘
    /// ```
    ///
    /// over its neighbours `k` on the same triangle, with the largest `φ ≤ 1` that keeps it between the
    /// smallest and the largest of these values and its own (T. J. Barth and D. C. Jespersen, "The design
    /// and application of upwind schemes on unstructured meshes", AIAA 1989). The mean of an element stays
    /// what it is, and what is dark beside a bright one stays dark. Elements made of several triangles, or
    /// of a whole one, have the same light everywhere.
    pub(crate) fn spread(&self, light: &[Vec3A]) -> Vec<Vec3A> {
        let mut spots = Vec::with_capacity(light.len() * SPOTS as usize);
        for e in 0..light.len() {
            spots.extend(self.sloped(e, light));
        }
        spots
    }

    /// Light at the spots of an element.
    fn sloped(&self, e: usize, light: &[Vec3A]) -> [Vec3A; SPOTS as usize] {
        let x = light[e];
        let none = [x; SPOTS as usize];
        let [piece] = self.pieces_of(e) else {
            return none;
        };
        let part = self.part(piece);
        if part.n * part.m <= 1 {
            return none;
        }
        let place = |p: &Part, b: Vec3| {
            let b = p.point(b);
            Vec2::new(b.y, b.z)
        };
        let middle = place(&part, MIDDLE);
        let (mut low, mut high) = (x, x);
        // Normal equations of the fit.
        let (mut xx, mut xy, mut yy) = (0.0_f32, 0.0_f32, 0.0_f32);
        let mut right = [Vec3A::ZERO; 2];
        for around in AROUND {
            let at = place(&part, around);
            if at.min_element() < 0.0 || at.x + at.y > 1.0 {
                continue;
            }
            let hit = Hit {
                triangle: piece.triangle,
                distance: 0.0,
                uv: at.to_array(),
                back: piece.back,
            };
            let Some(k) = self.at(&hit).map(|k| k.0 as usize).filter(|&k| k != e) else {
                continue;
            };
            let [other] = self.pieces_of(k) else {
                continue;
            };
            let step = place(&self.part(other), MIDDLE) - middle;
            let more = light[k] - x;
            (low, high) = (low.min(light[k]), high.max(light[k]));
            xx += step.x * step.x;
            xy += step.x * step.y;
            yy += step.y * step.y;
            right[0] += more * step.x;
            right[1] += more * step.y;
        }
        let det = xx * yy - xy * xy;
        if det <= FLAT * xx * yy {
            return none;
        }
        let by_x = (right[0] * yy - right[1] * xy) / det;
        let by_y = (right[1] * xx - right[0] * xy) / det;
        let offsets = std::array::from_fn(|spot| {
            let off = place(&part, in_cell(MIDDLE, spot as u32, ALONG)) - middle;
            by_x * off.x + by_y * off.y
        });
        // Roundings must not make dark places darker than that: below 0 there is no light.
        limited(offsets, low - x, high - x).map(|off| (x + off).clamp(low, high))
    }
}

/// Offsets cut down together so that none is beyond the limits, channel by channel.
fn limited<const N: usize>(offsets: [Vec3A; N], low: Vec3A, high: Vec3A) -> [Vec3A; N] {
    let mut share = Vec3A::ONE;
    for off in offsets {
        for channel in 0..3 {
            let (off, limit) = (off[channel], if off[channel] < 0.0 { low } else { high });
            if off.abs() > limit[channel].abs() {
                share[channel] = share[channel].min(limit[channel] / off);
            }
        }
    }
    offsets.map(|off| off * share)
}
