use bevy_fresco::radiosity::{Bake, Scene};
use glam::DVec3;
use rayon::prelude::*;

use super::layout::Layout;
use super::shown::{Lit, lit};
use super::truth::Truth;

/// How far a bake is from the truth, over all surfaces that are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Off {
    /// Root of the mean square of the error, beside the mean light.
    pub(crate) rmse: f64,
    /// Mean of the error, beside the mean light: light gained or lost.
    pub(crate) gain: f64,
    /// The mean light.
    pub(crate) mean: f64,
}

/// A point where a bake is compared.
pub(crate) struct Sample {
    /// Of the layout.
    pub(crate) face: usize,
    pub(crate) position: DVec3,
    /// The area it stands for.
    pub(crate) area: f64,
    pub(crate) found: f64,
}

/// What the eye makes of linear sRGB.
pub(crate) fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Compares a bake of a layout's scene at about so many points.
pub(crate) fn measure(layout: &Layout, truth: &Truth, baked: &Bake, points: usize) -> Off {
    judge(truth, &samples(layout, &layout.scene(), baked, points))
}

/// Compares at given samples.
pub(crate) fn judge(truth: &Truth, samples: &[Sample]) -> Off {
    let compare = |s: &Sample| {
        let known = luminance(truth.at(s.face, s.position)?);
        Some([
            s.area,
            s.area * known,
            s.area * (s.found - known),
            s.area * (s.found - known).powi(2),
        ])
    };
    let each: Vec<[f64; 4]> = samples.par_iter().filter_map(compare).collect();
    let sum = |k: usize| each.iter().map(|e| e[k]).sum::<f64>();
    let area = sum(0).max(f64::MIN_POSITIVE);
    let mean = (sum(1) / area).max(f64::MIN_POSITIVE);
    Off {
        rmse: (sum(3) / area).sqrt() / mean,
        gain: sum(2) / area / mean,
        mean,
    }
}

/// Points on the triangles of a result: half of them spread evenly over the area, half evenly over
/// the triangles, for a mesh is fine where light changes and there errors are; each stands for as
/// much area as it is rare.
///
/// With the share `q_t` of all points that is due to triangle `t`,
///
/// ```text
///   ┌─────────────────────────────────────────┐
///   │  q_t = A_t / 2A + 1 / 2T,  a = A_t / N q_t │
///   └─────────────────────────────────────────┘
/// ```
pub(crate) fn samples(layout: &Layout, scene: &Scene, baked: &Bake, points: usize) -> Vec<Sample> {
    let mut triangles: Vec<(usize, Lit)> = Vec::new();
    for (part, (object, light)) in scene.objects.iter().zip(&baked.objects).enumerate() {
        let first = layout.first_face(part);
        triangles.extend((lit(object, light).into_iter()).map(|t| (first + t.source / 2, t)));
    }
    let whole: f64 = triangles.iter().map(|(_, t)| t.area()).sum();
    let even = 1.0 / triangles.len() as f64;
    let mut samples = Vec::with_capacity(points);
    let mut reached = 0.0;
    for (face, triangle) in triangles {
        let due = points as f64 * 0.5 * (triangle.area() / whole + even);
        let first = samples.len();
        reached += due;
        while (samples.len() as f64 + 0.5) < reached {
            let n = samples.len() as u32;
            let (position, light) = triangle.at(corner_weights(golden(n)));
            samples.push(Sample {
                face,
                position,
                area: triangle.area() / due,
                found: luminance(light),
            });
        }
        debug_assert!(samples.len() - first <= due.ceil() as usize);
    }
    samples
}

/// Points spread evenly over the unit square (Roberts 2018, the generalised golden ratio).
fn golden(n: u32) -> [f64; 2] {
    const RATIO: f64 = 1.324_717_957_244_746;
    [1.0 / RATIO, 1.0 / (RATIO * RATIO)].map(|step| (0.5 + f64::from(n) * step).fract())
}

/// A point of the square as one of a triangle, evenly (Turk 1990).
fn corner_weights([u, v]: [f64; 2]) -> DVec3 {
    let root = u.sqrt();
    DVec3::new(1.0 - root, root * (1.0 - v), root * v)
}
