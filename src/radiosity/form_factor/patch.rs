use glam::{DVec3, Vec3};

use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::sampling::{frame, sobol};
use crate::radiosity::validate::{HALF_EXTENT, ValidScene};

use super::polygon::{QUICK, area_vector, exchange, kernel, lambert};

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
const POINTS: f64 = 24.0;

/// Off the larger by so many radii of the smaller, the smaller is a point: Lambert's formula.
const CENTER: f64 = 12.0;

/// Off the larger by so many radii of the smaller, the smaller is a [`FEW`] points.
const NEAR: f64 = 2.5;

/// Lower than this over a plane, in internal units, is in it: four times the rounding of a corner.
const FLAT: f64 = 4.0 * (HALF_EXTENT * f32::EPSILON) as f64;

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
    /// Each rule is used from where it is as good as the one before it:
    ///
    /// | distance | |
    /// |---|---|
    /// | very far | both are points |
    /// | far | the smaller is a point, Lambert's formula for the larger |
    /// | mid | the smaller is a few points |
    /// | near, touching | the contour integral, where points would be wrong by any amount |
    pub(super) fn exchange(&self, other: &Self) -> f64 {
        let (small, large) = by_size(self, other, |patch| &patch.whole);
        if large.faces.len() > 1 {
            let distance = small.whole.center.distance(large.whole.center);
            if distance > POINTS * large.whole.radius {
                return small.whole.as_points(&large.whole);
            }
            if distance > large.whole.radius + CENTER * small.whole.radius {
                return large.faces.iter().map(|f| small.whole.as_point(f)).sum();
            }
        }
        let onto = |a: &Face| large.faces.iter().map(|b| a.exchange(b)).sum::<f64>();
        small.faces.iter().map(onto).sum()
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
        if distance > POINTS * large.extent.radius {
            return small.extent.as_points(&large.extent);
        }
        let apart = distance - large.extent.radius;
        if apart > CENTER * small.extent.radius {
            small.extent.as_point(large)
        } else if apart > NEAR * small.extent.radius {
            small.as_few_points(large)
        } else {
            // One order, so that the result has no other.
            exchange(&self.corners, &other.corners, &QUICK).max(0.0)
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        (point - self.corners[0]).dot(self.unit)
    }

    fn as_few_points(&self, other: &Self) -> f64 {
        let [a, b, c] = self.corners;
        let at = |[u, v, w]: [f64; 3]| {
            lambert(a * u + b * v + c * w, self.extent.vector, &other.corners).max(0.0)
        };
        FEW.map(at).into_iter().sum::<f64>() / FEW.len() as f64
    }
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
