//! Small faces, told by a few of them.
//!
//! A scan has far more faces than light has detail: to ask for light at eight points of each of them takes as many
//! rays as to gather it. So small faces that lie side by side and look the same way are taken together; some of them
//! are judged, and where these leave far less than meshes may, the others are taken to do the same.

use std::collections::BTreeMap;

use glam::Vec3;

use super::face::FaceLight;
use crate::mesh::Conforming;
use crate::radiosity::kind::Kind;
use crate::radiosity::level::Level;
use crate::radiosity::triangle::{area, face_normal};
use crate::radiosity::validate::HALF_EXTENT;

/// Faces that are taken together lie in one cube of a grid this wide, in internal units: a sixteenth of the
/// scene.
const CELL: f32 = HALF_EXTENT / 8.0;

/// Faces this large or larger, in squared internal units, are judged in any case.
const SMALL: f32 = CELL * CELL / 32.0;

/// Faces of a cluster that are judged first: so many, or one of so many others.
const SCOUTS: usize = 8;
const OTHERS: usize = 64;

/// Clusters of fewer faces are not worth it.
const LEAST: usize = 3 * SCOUTS;

/// What scouts may leave of the mean square error that meshes may, for the others to be left alone: so much for
/// sure, and so much with what chance adds.
const LITTLE: f64 = 0.1;
const LITTLE_BY_CHANCE: f64 = 0.5;

/// Light with sharp edges: scouts that differ by more than this share of the brightest have an edge between them.
const EVEN: f64 = 0.3;

/// Small faces side by side.
pub(super) struct Cluster {
    pub(super) faces: Vec<u32>,
}

/// What the faces of a cluster are taken for that were not judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    misfit: f64,
    mean: f64,
}

/// The clusters of all faces that are small enough, and enough in one place.
pub(super) fn clusters(conforming: &Conforming) -> Vec<Cluster> {
    let mut cells: BTreeMap<(u32, [i32; 3], u8), Vec<u32>> = BTreeMap::new();
    for face in 0..conforming.faces() {
        let corners = conforming.corners(face);
        if area(corners) < SMALL {
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let cell = (middle / CELL).floor().to_array().map(|c| c as i32);
            let place = (conforming.part(face), cell, facing(face_normal(corners)));
            cells.entry(place).or_default().push(face);
        }
    }
    let enough = cells.into_values().filter(|faces| faces.len() >= LEAST);
    enough.map(|faces| Cluster { faces }).collect()
}

/// Which of the six sides of a cube a normal points to most.
fn facing(normal: Vec3) -> u8 {
    let axis = normal.abs().max_position();
    (2 * axis + usize::from(normal[axis] < 0.0)) as u8
}

impl Cluster {
    fn count(&self) -> usize {
        SCOUTS.max(self.faces.len() / OTHERS)
    }

    /// Those to be judged first, evenly among the others.
    pub(super) fn scouts(&self) -> impl Iterator<Item = u32> {
        let (count, all) = (self.count(), self.faces.len());
        (0..count).map(move |i| self.faces[(2 * i + 1) * all / (2 * count)])
    }

    /// What the others are taken for; nothing, if they have to be judged themselves.
    pub(super) fn verdict(
        &self,
        lights: &[FaceLight],
        (kind, level, asked): (Kind, &Level, f64),
    ) -> Option<Verdict> {
        let scouts = || self.scouts().map(|face| &lights[face as usize]);
        let mean =
            |of: &dyn Fn(&FaceLight) -> f64| scouts().map(of).sum::<f64>() / self.count() as f64;
        let verdict = Verdict {
            misfit: mean(&|light| light.misfit),
            mean: mean(&|light| light.mean),
        };
        let (darkest, brightest) = scouts().fold((f64::INFINITY, 0.0_f64), |(low, high), light| {
            (low.min(light.mean), high.max(light.mean))
        });
        let is_even = match kind {
            Kind::Smooth => true,
            Kind::Sharp => brightest - darkest <= EVEN * brightest,
        };
        let leaves = |light: &FaceLight| level.relative(light.misfit, light.mean);
        let left = mean(&leaves);
        let variance = mean(&|light| (leaves(light) - left).powi(2));
        let by_chance = (variance / (self.count() - 1) as f64).sqrt();
        let may = asked * asked;
        let is_little = left - by_chance <= LITTLE * may && left <= LITTLE_BY_CHANCE * may;
        (is_even && is_little).then_some(verdict)
    }
}

impl Verdict {
    /// The light of a face that is taken for it.
    pub(super) fn of(self, area: f32) -> FaceLight {
        FaceLight {
            misfit: self.misfit,
            mean: self.mean,
            area: area.into(),
            ..FaceLight::default()
        }
    }
}
