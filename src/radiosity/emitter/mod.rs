//! The light of emissive surfaces.
//!
//! | file | what it does |
//! |---|---|
//! | `closed` | few emitters: each in closed form, but for what stands between |
//! | `drawn` | many: points drawn on them, combined with rays that meet them by chance |

mod closed;
#[cfg(test)]
mod closed_test;
mod drawn;

use closed::Closed;
use glam::Vec3;

use super::element::{ElementId, Elements};
use super::emitter_tree::EmitterTree;
use super::gradient::Arrived;
use super::occlusion::{Hit, Occluders};
use super::settings::BakeSettings;

/// How the light of emissive triangles is found, by receivers that take so many shadow rays and so
/// many rays each: the ratio sets how the two are combined where there are many emitters.
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

/// Receivers that belong together: what some of their shadow rays say of an emitter is taken to hold
/// for all.
pub(crate) struct Group<'g> {
    /// Each with the block of the sequence that its rays take.
    pub(crate) receivers: &'g [(u32, Receiver)],
    /// Blocks there are in all.
    pub(crate) blocks: u32,
    /// Shadow rays of a receiver.
    pub(crate) rays: u32,
    pub(crate) seed: u32,
    /// Whether gradients are asked for.
    pub(crate) gradients: bool,
}

/// What shadow rays to emitters found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ShadowsOfEmitters {
    pub(crate) rays: u64,
    /// The same share of each lamp's light passes to all receivers, as far as rays tell: there is no
    /// edge of a shadow. Where points are drawn, nobody knows.
    pub(crate) calm: bool,
}

impl ShadowsOfEmitters {
    /// Without emitters.
    pub(crate) const NONE: Self = Self {
        rays: 0,
        calm: true,
    };
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

    /// For the samples inside the triangles of a bake, of elements that glare.
    pub(crate) fn glaring_at_samples(tree: &'a EmitterTree, settings: &BakeSettings) -> Self {
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

    /// The light of emitters at a group of receivers: `found` is told of receivers, elements and how
    /// much of their light arrives (of unit radiance). Returns what shadow rays that took.
    pub(crate) fn light(
        &self,
        elements: &Elements,
        occluders: &Occluders,
        group: &Group,
        mut found: impl FnMut(usize, u32, Arrived),
    ) -> ShadowsOfEmitters {
        if self.tree.few() {
            let closed = Closed {
                emitters: self,
                elements,
                occluders,
                group,
            };
            return closed.light(&mut found);
        }
        let mut shadows = ShadowsOfEmitters::default();
        for (k, &(block, ref receiver)) in group.receivers.iter().enumerate() {
            let samples = block * group.rays..(block + 1) * group.rays;
            shadows.rays += self.sample(
                elements,
                occluders,
                receiver,
                group.seed,
                samples,
                |e, light, direction| {
                    let asked = group.gradients;
                    let normal = receiver.normal;
                    found(
                        k,
                        e,
                        Arrived::from_direction(light, normal, direction, asked),
                    );
                },
            );
        }
        shadows
    }

    /// How much of the light counts that a ray of density cos/π came upon: none of what is known in
    /// closed form.
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
        match self.tree.leaf(source, hit.triangle) {
            None => 1.0,
            Some(_) if self.tree.few() => 0.0,
            Some(leaf) => self.weight_of_ray(leaf, receiver, direction, hit.distance),
        }
    }
}
