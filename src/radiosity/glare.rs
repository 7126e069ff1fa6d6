use glam::Vec3A;

use super::color::luminance;
use super::element::{ElementId, Elements};
use super::form_factor::Traced;
use super::importance::Importance;
use super::solve::Solution;

/// What sends more than so many times the light where it arrives glares. With less, shadow rays go to elements that
/// rays find well enough; with more, a lamp's surroundings make specks (1.5 to 12 tried on the Cornell box).
pub(crate) const GLARING: f32 = 2.0;

/// Elements that reflect so much light that rays which come upon them by chance would make bright specks: the patch
/// of sun on the floor of a dark room, the ceiling around a lamp. Their light is sampled in the gather.
///
/// Their [`Importance`] decides: what a ray brings that meets one by chance is an error of all the element sends.
pub(crate) struct Glare {
    /// What each element sends beside what is too much, in units of that.
    excess: Vec<f32>,
}

impl Glare {
    pub(crate) fn new(elements: &Elements, traced: &Traced, solution: &Solution) -> Self {
        let importance = Importance::new(elements, traced, &solution.arriving);
        let limit = GLARING * importance.level;
        let excess = |(e, &sent): (usize, &Vec3A)| {
            let sent = luminance(sent.into());
            // Most elements are below the limit wherever their light goes.
            match sent > limit {
                true => (sent / limit * importance.of(e) - 1.0).max(0.0),
                false => 0.0,
            }
        };
        Self {
            excess: (solution.reflected.iter().enumerate())
                .map(excess)
                .collect(),
        }
    }

    /// What an element sends beyond what is too much; 0 if it does not glare.
    pub(crate) fn excess(&self, element: ElementId) -> f32 {
        self.excess[element.0 as usize]
    }
}
