use std::ops::Range;

use glam::Vec3;

use super::element::{ElementId, Elements};
use super::emitter_tree::{Choices, EmitterTree, Leaf};
use super::occlusion::{Hit, OFFSET, Occluders};
use super::sampling::{sobol, triangle as triangle_point};
use super::settings::BakeSettings;

/// How light is drawn from emissive triangles, by receivers that take so many samples and so many
/// rays each: the ratio sets how the two are combined.
///
/// Small emitters are sampled: an [`EmitterTree`] picks one by what it may send to the receiver, and
/// a shadow ray asks whether it does. Rays that gather bounced light also meet emitters by
/// chance; both estimates are combined by Veach's power heuristic, so that near an emitter, where
/// 1/d² is wild, the rays take over, and far from it the samples.
///
/// Emissive materials that fill the view (a luminous ceiling, a furnace) are left to the rays
/// alone, which find them without noise.
#[derive(Clone, Copy)]
pub(crate) struct Emitters<'a> {
    pub(crate) tree: &'a EmitterTree,
    light: Light,
    pub(crate) samples: u32,
    rays: u32,
}

/// What shines in a tree.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Light {
    /// Emission of triangles.
    Emission,
    /// Reflected light of elements.
    Reflected,
}

/// A point that receives light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// Where rays start: lifted off its own surface.
    pub(crate) position: Vec3,
    /// Unit normal of the side that receives.
    pub(crate) normal: Vec3,
    /// The live triangle it lies on.
    pub(crate) triangle: u32,
}

impl<'a> Emitters<'a> {
    /// For the elements of a bake.
    pub(crate) fn at_elements(tree: &'a EmitterTree, settings: &BakeSettings) -> Self {
        Self {
            tree,
            light: Light::Emission,
            samples: settings.emitter_rays,
            rays: settings.rays_of_element(),
        }
    }

    /// For the samples inside the triangles of a bake.
    pub(crate) fn at_samples(tree: &'a EmitterTree, settings: &BakeSettings) -> Self {
        Self {
            tree,
            light: Light::Emission,
            samples: settings.emitter_rays,
            rays: settings.gather_rays,
        }
    }

    /// For the samples inside the triangles of a bake, of elements that reflect much light.
    pub(crate) fn bright_at_samples(tree: &'a EmitterTree, settings: &BakeSettings) -> Self {
        Self {
            tree,
            light: Light::Reflected,
            // They are a smaller part of the light than lamps are.
            samples: settings.emitter_rays.div_ceil(2),
            rays: settings.gather_rays,
        }
    }

    /// Whether what is sampled is reflected light.
    pub(crate) fn are_reflectors(&self) -> bool {
        self.light == Light::Reflected
    }

    /// Which elements' light is sampled: rays that meet them count in part.
    pub(crate) fn marks(&self, elements: &Elements) -> Vec<bool> {
        let mut marks = vec![false; elements.len()];
        for leaf in &self.tree.leaves {
            match self.light {
                Light::Emission => {
                    for e in elements.of_triangle(leaf.triangle) {
                        marks[e as usize] = true;
                    }
                }
                Light::Reflected => marks[leaf.source as usize] = true,
            }
        }
        marks
    }

    /// Samples the light of emitters at a receiver, with the samples `indices` of the sequence
    /// `seed`: `found` is told of elements and how much of their light arrives (irradiance / π of
    /// unit radiance, the mean over the samples). Returns how many shadow rays that took.
    pub(crate) fn sample(
        &self,
        elements: &Elements,
        occluders: &Occluders,
        receiver: &Receiver,
        seed: u32,
        indices: Range<u32>,
        mut found: impl FnMut(u32, f32),
    ) -> u64 {
        if self.tree.leaves.is_empty() {
            return 0;
        }
        let choices = Choices::new(self.tree, receiver);
        if choices.is_empty() {
            return 0;
        }
        let (count, mut traced) = (indices.len() as f32, 0);
        for i in indices {
            let [choice, u, v, _] = sobol(i, 1, seed);
            let Some((leaf, probability)) = choices.choose(self.tree, receiver, choice) else {
                continue;
            };
            let leaf = &self.tree.leaves[leaf as usize];
            let b = triangle_point(u, v);
            let Some(sent) = self.sent(elements, receiver, leaf, b, probability) else {
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
                found(sent.element, sent.light * passing / count);
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

    /// How much of the light counts that a ray of density cos/π came upon: the weight of rays
    /// against samples.
    pub(crate) fn ray_weight(
        &self,
        element: ElementId,
        receiver: &Receiver,
        direction: Vec3,
        hit: &Hit,
    ) -> f32 {
        let source = match self.light {
            Light::Emission => hit.triangle,
            Light::Reflected => element.0,
        };
        let Some(leaf) = self.tree.leaf(source, hit.triangle) else {
            return 1.0;
        };
        let probability = self.tree.probability(receiver, leaf);
        let leaf = &self.tree.leaves[leaf as usize];
        let facing = leaf.normal.dot(direction).abs();
        let density = probability / leaf.area * hit.distance * hit.distance / facing;
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
