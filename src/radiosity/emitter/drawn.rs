use std::ops::Range;

use glam::Vec3;

use super::{Emitters, Light, Receiver};
use crate::radiosity::element::Elements;
use crate::radiosity::emitter_tree::{Choices, Leaf};
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::sampling::{hash, sobol_2d, triangle as triangle_point};

/// Sets points on emitters apart from directions.
const DRAWN: u32 = 0xD6A3;

/// Many emitters: points drawn on them.
///
/// The tree picks an emitter by what it may send to the receiver, and a shadow ray asks whether it
/// does. Rays that gather bounced light also meet emitters by chance; both estimates are combined
/// by Veach's power heuristic, so that near an emitter, where 1/d² is wild, the rays take over, and
/// far from it the samples.
impl Emitters<'_> {
    /// Samples the light of emitters at a receiver, with the samples `indices` of the sequence
    /// `seed`: `found` is told of elements, how much of their light arrives (irradiance / π of unit
    /// radiance, the mean over the samples) and from where. Returns how many shadow rays that took.
    pub(super) fn sample(
        &self,
        elements: &Elements,
        occluders: &Occluders,
        receiver: &Receiver,
        seed: u32,
        indices: Range<u32>,
        mut found: impl FnMut(u32, f32, Vec3),
    ) -> u64 {
        let choices = Choices::new(self.tree, receiver);
        if choices.is_empty() {
            return 0;
        }
        // Gathering rays take points of the seed itself.
        let seed = hash(seed, DRAWN);
        let (count, mut traced) = (indices.len() as f32, 0);
        for i in indices {
            let [choice, v] = sobol_2d(i, seed);
            let Some(chosen) = choices.choose(self.tree, receiver, choice) else {
                continue;
            };
            let leaf = &self.tree.leaves[chosen.leaf as usize];
            let b = triangle_point(chosen.u.clamp(0.0, 1.0), v);
            let Some(sent) = self.sent(elements, receiver, leaf, b, chosen.probability) else {
                continue;
            };
            traced += 1;
            let passing = occluders.transmittance(
                receiver.position,
                sent.direction,
                sent.distance - OFFSET,
                [receiver.triangle, leaf.triangle],
            );
            if passing > 0.0 {
                found(sent.element, sent.light * passing / count, sent.direction);
            }
        }
        traced
    }

    /// One sample's estimate of irradiance / π, unshadowed and for unit radiance:
    /// `cos cos' / (π d²) / (probability / area)`, times the weight of sampling against rays.
    fn sent(
        &self,
        elements: &Elements,
        receiver: &Receiver,
        leaf: &Leaf,
        b: Vec3,
        probability: f32,
    ) -> Option<Sent> {
        let [p, q, r] = leaf.corners;
        let point = p * b.x + q * b.y + r * b.z;
        let to = point - receiver.position;
        let distance = to.length();
        let direction = to / distance;
        let cosine = receiver.normal.dot(direction);
        let facing = -leaf.normal.dot(direction);
        if !(cosine > 0.0 && (facing > 0.0 || leaf.two_sided)) || leaf.triangle == receiver.triangle
        {
            return None;
        }
        let element = match self.light {
            Light::Emission => {
                let e = elements.side_at(leaf.triangle, [b.y, b.z], facing < 0.0)?.0;
                // Whether an element emits is known as long as a tree is kept.
                (elements.emission[e as usize] != Vec3::ZERO).then_some(e)?
            }
            Light::Reflected => leaf.source,
        };
        let density = probability / leaf.area * distance * distance / facing.abs();
        if !density.is_finite() || density <= 0.0 {
            return None;
        }
        let weight = self.sampling_weight(density, cosine) * elements.coverage[element as usize];
        Some(Sent {
            element,
            direction,
            distance,
            light: cosine / std::f32::consts::PI / density * weight,
        })
    }

    /// The weight of a ray of density cos/π that came upon an emitter, against samples.
    pub(super) fn weight_of_ray(
        &self,
        leaf: u32,
        receiver: &Receiver,
        direction: Vec3,
        distance: f32,
    ) -> f32 {
        let probability = self.tree.probability(receiver, leaf);
        let leaf = &self.tree.leaves[leaf as usize];
        let facing = leaf.normal.dot(direction).abs();
        let density = probability / leaf.area * distance * distance / facing;
        1.0 - self.sampling_weight(density, receiver.normal.dot(direction))
    }

    /// Veach and Guibas 1995: the power heuristic with exponent 2.
    fn sampling_weight(&self, density: f32, cosine: f32) -> f32 {
        let sampled = self.samples as f32 * density;
        let traced = self.rays as f32 * cosine / std::f32::consts::PI;
        if sampled.is_infinite() {
            return 1.0;
        }
        let ratio = traced / sampled.max(f32::MIN_POSITIVE);
        1.0 / (1.0 + ratio * ratio)
    }
}

/// Light that an emitter may send to a receiver.
struct Sent {
    element: u32,
    direction: Vec3,
    distance: f32,
    light: f32,
}
