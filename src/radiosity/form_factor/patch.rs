use glam::{DVec3, Vec3};

use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::sampling::{frame, sobol};
use crate::radiosity::validate::{HALF_EXTENT, ValidScene};

use super::polygon::{QUICK, area_vector, clip, exchange, kernel, lambert};

/// An element as flat triangles, and what it looks like from afar.
pub(super) struct Patch {
    faces: Vec<Face>,
    whole: Extent,
}

/// A triangle, anticlockwise from the side that counts.
struct Face {
    corners: [DVec3; 3],
    /// Unit normal.
    unit: DVec3,
    extent: Extent,
}

/// A piece of surface from afar.
#[derive(Clone, Copy)]
struct Extent {
    center: DVec3,
    radius: f64,
    /// Area times unit normal, added up.
    vector: DVec3,
}

/// An element of more triangles than this is stood in for by so many others, which bounds what a
/// pair of elements costs.
const MANY: usize = 16;

/// From so many radii of the larger, both are points: `cos cos / π r²`.
const POINTS: f64 = 32.0;

/// Off the larger by so many radii of the smaller, the smaller is a point: Lambert's formula.
const CENTER: f64 = 24.0;

/// Off the larger by so many radii of the smaller, the smaller is a [`FEW`] points.
const NEAR: f64 = 2.5;

/// Lower than this over a plane, in internal units, is in it: four times the rounding of a corner.
const FLAT: f64 = 4.0 * (HALF_EXTENT * f32::EPSILON) as f64;

/// From so many radii of the larger, both are [`FEW`] points.
const FEW_BY_FEW: f64 = 6.0;

/// Points of a rule for triangles of equal weights, exact for polynomials of degree 2 (Hammer and
/// Stroud 1956), in barycentrics.
const FEW: [[f64; 3]; 3] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];

impl Patch {
    pub(super) fn of(scene: &ValidScene, elements: &Elements, element: usize) -> Self {
        let id = ElementId(element as u32);
        let shape = || elements.shape(scene, id);
        let faces: Vec<Face> = if shape().count() > MANY {
            stand_ins(scene, elements, id).collect()
        } else {
            shape()
                .map(|(_, corners, side)| Face::new(corners.map(|p| p.as_dvec3()), side))
                .collect()
        };
        Self {
            whole: Extent::around(&faces),
            faces,
        }
    }

    /// `A F` of two elements, nothing between them.
    ///
    /// Each rule is used from where it differs from the one before it by less than 5e-4 of what
    /// the two exchange when they face each other:
    ///
    /// | distance | |
    /// |---|---|
    /// | very far | both are points |
    /// | far | both are a few points |
    /// | far for the smaller | it is a point, Lambert's formula for the larger |
    /// | mid | the smaller is a few points, Lambert's formula for the larger |
    /// | near, touching | the contour integral: points would be wrong by any amount |
    ///
    /// Of a triangle that reaches behind the other only the part before it has points.
    pub(super) fn exchange(&self, other: &Self) -> f64 {
        let (small, large) = by_size(self, other, |patch| &patch.whole);
        let several = large.faces.len() > 1;
        if several && large.sees_all_of(small) {
            let distance = small.whole.center.distance(large.whole.center);
            if distance > POINTS * large.whole.radius && small.sees_all_of(large) {
                return small.whole.as_points(&large.whole);
            }
            if distance > large.whole.radius + CENTER * small.whole.radius {
                return large.faces.iter().map(|f| small.whole.as_point(f)).sum();
            }
        }
        let onto = |a: &Face| large.faces.iter().map(|b| a.exchange(b)).sum::<f64>();
        small.faces.iter().map(onto).sum()
    }

    fn sees_all_of(&self, other: &Self) -> bool {
        let mut pairs = self
            .faces
            .iter()
            .flat_map(|a| other.faces.iter().map(move |b| (a, b)));
        pairs.all(|(a, b)| a.sees_all_of(b))
    }

    /// Whether any of either is before any of the other, by more than rounding.
    pub(super) fn may_see(&self, other: &Self) -> bool {
        self.reaches_before(other) && other.reaches_before(self)
    }

    /// Whether anything of `self` is before a triangle of `other`.
    fn reaches_before(&self, other: &Self) -> bool {
        let mut corners = self.faces.iter().flat_map(|f| f.corners);
        corners.any(|p| other.faces.iter().any(|face| face.height(p) > FLAT))
    }

    /// `A F` of an element with itself, if it is hollow.
    pub(super) fn exchange_within(&self) -> f64 {
        let pairs = self.faces.iter().enumerate();
        let once = pairs.map(|(i, a)| self.faces[..i].iter().map(|b| a.exchange(b)).sum::<f64>());
        2.0 * once.sum::<f64>()
    }
}

/// Equal triangles spread over an element, together as large.
fn stand_ins(
    scene: &ValidScene,
    elements: &Elements,
    element: ElementId,
) -> impl Iterator<Item = Face> {
    let area: f64 = elements
        .shape(scene, element)
        .map(|(_, corners, _)| area_vector(&corners.map(|p| p.as_dvec3())).length())
        .sum();
    // The corners of a triangle of equal sides lie 2 / 27^¼ √A from its centre.
    let reach = 2.0 / 27.0_f64.powf(0.25) * (area / MANY as f64).sqrt();
    (0..MANY as u32).map(move |i| {
        let [u, v, ..] = sobol(i, 0, 0);
        let point = elements.point(scene, element, u, v);
        let axes = frame(point.normal).as_dmat3();
        let corner = |k: f64| {
            let (sin, cos) = (std::f64::consts::TAU / 3.0 * k).sin_cos();
            point.position.as_dvec3() + axes * DVec3::new(cos, sin, 0.0) * reach
        };
        Face::new([0.0, 1.0, 2.0].map(corner), point.normal)
    })
}

fn by_size<'a, T>(a: &'a T, b: &'a T, extent: impl Fn(&T) -> &Extent) -> (&'a T, &'a T) {
    if extent(a).radius <= extent(b).radius {
        (a, b)
    } else {
        (b, a)
    }
}

impl Face {
    fn new([a, b, c]: [DVec3; 3], side: Vec3) -> Self {
        let front = (b - a).cross(c - a).dot(side.as_dvec3()) >= 0.0;
        let corners = if front { [a, b, c] } else { [a, c, b] };
        let center = (a + b + c) / 3.0;
        let vector = area_vector(&corners);
        Self {
            corners,
            unit: vector.normalize_or_zero(),
            extent: Extent {
                center,
                radius: corners
                    .map(|p| p.distance(center))
                    .into_iter()
                    .fold(0.0, f64::max),
                vector,
            },
        }
    }

    fn exchange(&self, other: &Self) -> f64 {
        let (small, large) = by_size(self, other, |face| &face.extent);
        let distance = small.extent.center.distance(large.extent.center);
        let apart = (distance - large.extent.radius) / small.extent.radius;
        if apart < NEAR {
            // Degenerate triangles may have no number.
            exchange(&small.corners, &large.corners, &QUICK).max(0.0)
        } else if !large.sees_all_of(small) {
            small.part_before(large)
        } else if distance > FEW_BY_FEW * large.extent.radius && small.sees_all_of(large) {
            if distance > POINTS * large.extent.radius {
                small.extent.as_points(&large.extent)
            } else {
                small.few_by_few(large)
            }
        } else if apart > CENTER {
            small.extent.as_point(large)
        } else {
            as_few_points(small.corners, small.extent.vector, large)
        }
    }

    /// `A F` by a few points on both.
    fn few_by_few(&self, other: &Self) -> f64 {
        let there = few_points(other.corners);
        let from = |p: DVec3| {
            let each = there.map(|q| kernel(q - p, self.extent.vector, other.extent.vector));
            each.into_iter().sum::<f64>()
        };
        few_points(self.corners).map(from).into_iter().sum::<f64>() / (FEW.len() * FEW.len()) as f64
    }

    /// `A F` by a few points on that part of a triangle that the other sees.
    fn part_before(&self, other: &Self) -> f64 {
        let (mut sum, mut first, mut last) = (0.0, None, None);
        clip(
            &self.corners,
            |p| other.height(p),
            |p| {
                if let Some((a, b)) = first.zip(last).filter(|(a, b)| a != b) {
                    let part = [a, b, p];
                    sum += as_few_points(part, area_vector(&part), other);
                }
                first = first.or(Some(p));
                last = Some(p);
            },
        );
        sum
    }

    fn sees_all_of(&self, other: &Self) -> bool {
        other.corners.iter().all(|&p| self.height(p) > -FLAT)
    }

    fn height(&self, point: DVec3) -> f64 {
        (point - self.corners[0]).dot(self.unit)
    }
}

/// `A F` from a triangle of the area vector `vector`.
fn as_few_points(corners: [DVec3; 3], vector: DVec3, to: &Face) -> f64 {
    let from = |p: DVec3| lambert(p, vector, &to.corners).max(0.0);
    few_points(corners).map(from).into_iter().sum::<f64>() / FEW.len() as f64
}

fn few_points([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    FEW.map(|[u, v, w]| a * u + b * v + c * w)
}

impl Extent {
    fn around(faces: &[Face]) -> Self {
        let (mut center, mut vector, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for face in faces {
            let part = face.extent.vector.length();
            center += face.extent.center * part;
            vector += face.extent.vector;
            area += part;
        }
        center /= area.max(f64::MIN_POSITIVE);
        let corners = faces.iter().flat_map(|f| f.corners);
        Self {
            center,
            radius: corners.map(|p| p.distance(center)).fold(0.0, f64::max),
            vector,
        }
    }

    fn as_points(&self, other: &Self) -> f64 {
        kernel(other.center - self.center, self.vector, other.vector)
    }

    fn as_point(&self, other: &Face) -> f64 {
        lambert(self.center, self.vector, &other.corners).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::form_factor::polygon::polygon_to_polygon;

    /// A random triangle, not too thin for its radius to tell of its size.
    fn triangle(seed: u32, size: f64) -> Option<Face> {
        let corner = |k| {
            let [x, y, z, _] = sobol(seed, k, 11);
            Vec3::new(x, y, z).as_dvec3() * size
        };
        let face = Face::new([0, 1, 2].map(corner), Vec3::ZERO);
        (face.extent.vector.length() > 0.3 * face.extent.radius.powi(2)).then_some(face)
    }

    /// Largest difference of a rule from the truth among pairs that are all before each other, as
    /// a share of what they would exchange face to face. A share of what they do exchange would
    /// have no bound: it may be next to nothing.
    fn worst(
        ratio: f64,
        distance: impl Fn(&Face, &Face) -> f64,
        rule: impl Fn(&Face, &Face) -> f64,
    ) -> f64 {
        let (mut worst, mut pairs) = (0.0_f64, 0);
        for seed in 0..8000 {
            let Some((a, b)) = triangle(2 * seed, 1.0).zip(triangle(2 * seed + 1, ratio)) else {
                continue;
            };
            let (small, large) = by_size(&a, &b, |f| &f.extent);
            let [u, v, w, _] = sobol(seed, 9, 5).map(|x| 2.0 * f64::from(x) - 1.0);
            let distance = distance(small, large);
            let to = small.extent.center + DVec3::new(u, v, w).normalize() * distance;
            let moved = large.corners.map(|p| p - large.extent.center + to);
            let large = Face::new(moved, large.unit.as_vec3());
            let exact = polygon_to_polygon(&small.corners, &large.corners);
            if exact > 0.0 && small.sees_all_of(&large) && large.sees_all_of(small) {
                let (area, there) = (small.extent.vector.length(), large.extent.vector.length());
                let face_to_face = area * there / (std::f64::consts::PI * distance * distance);
                worst = worst.max((rule(small, &large) - exact * area).abs() / face_to_face);
                pairs += 1;
            }
        }
        assert!(pairs > 50, "{pairs}");
        worst
    }

    /// At 5e-4 a hand-over is not seen: the shadow rays of a pair are far noisier.
    #[test]
    fn rules_hand_over_without_a_jump() {
        for ratio in [1.0, 3.0] {
            let off = |radii: f64| {
                move |small: &Face, large: &Face| large.extent.radius + radii * small.extent.radius
            };
            let contour = worst(ratio, off(1.0), |a, b| {
                exchange(&a.corners, &b.corners, &QUICK)
            });
            let few = worst(ratio, off(NEAR), |a, b| {
                as_few_points(a.corners, a.extent.vector, b)
            });
            let center = worst(ratio, off(CENTER), |a, b| a.extent.as_point(b));
            let far = |_: &Face, large: &Face| POINTS * large.extent.radius;
            let points = worst(ratio, far, |a, b| a.extent.as_points(&b.extent));
            let radii = |_: &Face, large: &Face| FEW_BY_FEW * large.extent.radius;
            let few_by_few = worst(ratio, radii, Face::few_by_few);
            assert!(few_by_few < 5e-4, "{ratio}: {few_by_few:.1e}");
            assert!(contour < 1e-4, "{ratio}: {contour:.1e}");
            assert!(few < 5e-4, "{ratio}: {few:.1e}");
            assert!(center < 5e-4, "{ratio}: {center:.1e}");
            assert!(points < 5e-4, "{ratio}: {points:.1e}");
        }
    }
}
