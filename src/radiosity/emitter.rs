use std::ops::Range;

use glam::{Vec3, Vec3A};

use super::element::Elements;
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
    tree: &'a EmitterTree,
    light: Light<'a>,
    pub(crate) samples: u32,
    rays: u32,
}

/// What shines in a tree.
#[derive(Clone, Copy)]
enum Light<'a> {
    /// Emission of triangles.
    Emission,
    /// Reflected light of elements.
    Reflected(&'a [Vec3A]),
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
            rays: settings.element_rays,
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
    pub(crate) fn bright_at_samples(
        tree: &'a EmitterTree,
        reflected: &'a [Vec3A],
        settings: &BakeSettings,
    ) -> Self {
        Self {
            tree,
            light: Light::Reflected(reflected),
            // They are a smaller part of the light than lamps are.
            samples: settings.emitter_rays.div_ceil(2),
            rays: settings.gather_rays,
        }
    }

    /// Direct light of sampled emitters at a receiver (irradiance / π): the mean over the samples
    /// `indices` of the sequence `seed`.
    pub(crate) fn sample(
        &self,
        elements: &Elements,
        occluders: &Occluders,
        receiver: &Receiver,
        seed: u32,
        indices: Range<u32>,
    ) -> Vec3 {
        if self.tree.leaves.is_empty() {
            return Vec3::ZERO;
        }
        let choices = Choices::new(self.tree, receiver);
        if choices.is_empty() {
            return Vec3::ZERO;
        }
        let mut sum = Vec3::ZERO;
        let count = indices.len() as f32;
        for i in indices {
            let [choice, u, v, _] = sobol(i, 1, seed);
            let Some((leaf, probability)) = choices.choose(self.tree, receiver, choice) else {
                continue;
            };
            let leaf = &self.tree.leaves[leaf as usize];
            let barycentrics = triangle_point(u, v);
            sum += self.sample_point(
                elements,
                occluders,
                receiver,
                leaf,
                barycentrics,
                probability,
            );
        }
        sum / count
    }

    /// One sample's estimate of irradiance / π: `L cos cos' / (π d²) / (probability / area)`,
    /// times the weight of sampling against rays.
    fn sample_point(
        &self,
        elements: &Elements,
        occluders: &Occluders,
        receiver: &Receiver,
        leaf: &Leaf,
        b: Vec3,
        probability: f32,
    ) -> Vec3 {
        let [p, q, r] = leaf.corners;
        let point = p * b.x + q * b.y + r * b.z;
        let to = point - receiver.position;
        let distance = to.length();
        let direction = to / distance;
        let cosine = receiver.normal.dot(direction);
        let facing = -leaf.normal.dot(direction);
        if !(cosine > 0.0 && (facing > 0.0 || leaf.two_sided)) || leaf.triangle == receiver.triangle
        {
            return Vec3::ZERO;
        }
        let emission = match self.light {
            Light::Emission => {
                elements.covered_emission_at(leaf.triangle, [b.y, b.z], facing < 0.0)
            }
            Light::Reflected(light) => {
                Vec3::from(light[leaf.source as usize]) * elements.coverage[leaf.source as usize]
            }
        };
        let density = probability / leaf.area * distance * distance / facing.abs();
        if emission == Vec3::ZERO || !density.is_finite() || density <= 0.0 {
            return Vec3::ZERO;
        }
        let passing = occluders.transmittance(
            receiver.position,
            direction,
            distance - OFFSET,
            [receiver.triangle, leaf.triangle],
        );
        let weight = self.sampling_weight(density, cosine);
        emission * (passing * cosine / std::f32::consts::PI / density * weight)
    }

    /// Light that a ray of density cos/π came upon, times the weight of rays against samples.
    pub(crate) fn found_by_ray(
        &self,
        elements: &Elements,
        receiver: &Receiver,
        direction: Vec3,
        hit: &Hit,
    ) -> Vec3 {
        let (light, source) = match self.light {
            Light::Emission => (
                elements.emission_at(hit.triangle, hit.uv, hit.back),
                hit.triangle,
            ),
            Light::Reflected(light) => match elements.at(hit) {
                Some(e) => (Vec3::from(light[e.0 as usize]), e.0),
                None => return Vec3::ZERO,
            },
        };
        if light == Vec3::ZERO {
            return light;
        }
        let Some(leaf) = self.tree.leaf(source, hit.triangle) else {
            return light;
        };
        let probability = self.tree.probability(receiver, leaf);
        let leaf = &self.tree.leaves[leaf as usize];
        let facing = leaf.normal.dot(direction).abs();
        let density = probability / leaf.area * hit.distance * hit.distance / facing;
        light * (1.0 - self.sampling_weight(density, receiver.normal.dot(direction)))
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
