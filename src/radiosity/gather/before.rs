use std::sync::Arc;

use super::Gather;
use super::shadows::{Shares, wanted};
use crate::radiosity::bounds::Sphere;
use crate::radiosity::change::Change;
use crate::radiosity::direct::crosses;
use crate::radiosity::gathered::{Bundle, Gathered, GradientShare, Share, SharpLight};
use crate::radiosity::light::Light;

/// What an earlier bake gathered, of which much is still true.
pub(crate) struct GatherBefore<'a> {
    pub(crate) gathered: &'a Gathered,
    pub(crate) change: &'a Change,
    /// For each object, which one of then has the same samples.
    pub(crate) object_before: &'a [Option<usize>],
    pub(crate) new_emitters: bool,
    pub(crate) new_reflectors: bool,
}

impl<'a> GatherBefore<'a> {
    pub(super) fn bundle(&self, object: usize, triangle: usize) -> Option<&'a Arc<Bundle>> {
        let before = self.object_before[object]?;
        Some(self.gathered.bundles.at(before, triangle))
    }

    pub(super) fn sharp(&self, object: usize, triangle: usize) -> Option<&'a SharpLight> {
        let before = self.object_before[object]?;
        Some(self.gathered.sharp.at(before, triangle))
    }

    pub(super) fn rays_stay(&self) -> bool {
        self.change.disturbed.is_empty()
            && self.change.same_elements
            && !self.new_emitters
            && !self.new_reflectors
    }

    /// What a light that is still as it was brought to a triangle.
    pub(super) fn light(
        &self,
        l: usize,
        light: &Light,
        old: &SharpLight,
        sphere: Sphere,
    ) -> Option<(Share, GradientShare)> {
        let before = self.change.light_before[l]?;
        let still = !crosses(&self.change.disturbed, light, sphere);
        let share = old.lights[before].filter(|_| still)?;
        let gradients = old.gradients.as_ref();
        let gradient = gradients.and_then(|g| g.lights[before]);
        Some((share, gradient.unwrap_or_default()))
    }

    pub(super) fn sharp_stays(&self, gather: &Gather, old: &SharpLight, sphere: Sphere) -> bool {
        let mut lights = gather.scene.lights.iter().enumerate();
        lights.all(|(l, light)| !wanted(light) || self.light(l, light, old, sphere).is_some())
            && self.emitters_stay(gather, sphere)
            && self.reflectors_stay(gather, sphere)
    }

    pub(super) fn emitters_stay(&self, gather: &Gather, sphere: Sphere) -> bool {
        let tree = gather.emitters.tree;
        !self.new_emitters && !tree.disturbed(&self.change.disturbed, sphere)
    }

    pub(super) fn reflectors_stay(&self, gather: &Gather, sphere: Sphere) -> bool {
        let tree = gather.reflectors.tree;
        !self.new_reflectors && !tree.disturbed(&self.change.disturbed, sphere)
    }

    pub(super) fn emitters(&self, old: &SharpLight) -> Shares {
        let gradients = old.gradients.as_ref();
        let gradients = gradients.map(|g| g.emitters.clone());
        (self.translate(&old.emitters), gradients.unwrap_or_default())
    }

    pub(super) fn reflectors(&self, old: &SharpLight) -> Shares {
        let gradients = old.gradients.as_ref();
        let gradients = gradients.map(|g| g.reflectors.clone());
        (
            self.translate(&old.reflectors),
            gradients.unwrap_or_default(),
        )
    }

    pub(super) fn translate(&self, shares: &Arc<[(u32, Share)]>) -> Arc<[(u32, Share)]> {
        if self.change.same_elements {
            return shares.clone();
        }
        let shares = shares.iter();
        shares
            .map(|&(e, share)| (self.change.translate(e), share))
            .collect()
    }
}
