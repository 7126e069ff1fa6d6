use std::sync::Arc;

use super::patch::Patch;
use super::{Gather, GatherBefore, GatherCost};
use crate::radiosity::direct::{add, light_seed, shines};
use crate::radiosity::emitter::{Emitters, Group, ShadowsOfEmitters};
use crate::radiosity::gathered::{
    Bundle, GradientShare, SamplePlaces, Share, SharpGradients, SharpLight,
};
use crate::radiosity::illumination::{Shadow, arrived};
use crate::radiosity::light::{DirectLight, Light};
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::sampling::hash;

/// How to tell which samples of a triangle lie inside geometry.
#[derive(Clone, Copy)]
pub(crate) enum Validity<'a> {
    /// By rays from the same samples.
    Known(&'a Bundle),
    /// All are outside: no ray from around met a black back.
    Sound,
    /// By a few rays from each.
    Doubtful,
}

/// Rays that tell whether a sample lies inside geometry.
const PROBES: u32 = 16;

/// Samples of a triangle at least, before it is taken to be free of shadows' edges.
const FEW: u32 = 8;

/// By element, what its light brings, and the gradients of that, if they are asked for.
pub(super) type Shares = (Arc<[(u32, Share)]>, Arc<[GradientShare]>);

impl Gather<'_> {
    /// Shadow rays from samples of a triangle of the fine meshes, where `before` does not answer: a few
    /// samples first, and all only where these find the edge of a shadow.
    pub(crate) fn sharp(
        &self,
        mesh: &ReceiverMesh,
        object: usize,
        triangle: usize,
        validity: Validity,
        before: Option<&GatherBefore>,
        cost: &mut GatherCost,
    ) -> SharpLight {
        let Some(patch) = self.patch(mesh, object, triangle) else {
            return SharpLight::default();
        };
        let known = before.and_then(|b| Some((b, b.sharp(object, triangle)?)));
        let all = patch.samples_at(self.density.sharp);
        let few = patch.samples_at(self.density.calm).max(FEW).min(all);
        // As many as then, if nothing is new.
        let stays = known.filter(|(b, old)| b.sharp_stays(self, old, patch.sphere()));
        let first = stays.map_or(few, |(_, old)| old.samples.taken);
        let (light, calm) = self.shadows(&patch.with(first), validity, known, cost);
        if calm || first >= all {
            return light;
        }
        self.shadows(&patch.with(all), validity, known, cost).0
    }

    /// Shadow rays from all samples of a triangle, and whether those that had to be traced found no
    /// edge of a shadow.
    fn shadows(
        &self,
        patch: &Patch,
        validity: Validity,
        known: Option<(&GatherBefore, &SharpLight)>,
        cost: &mut GatherCost,
    ) -> (SharpLight, bool) {
        let known = known.filter(|(_, old)| old.samples.taken == patch.samples);
        let places = match (validity, known) {
            (Validity::Doubtful, Some((b, old))) if b.rays_stay() => old.samples.clone(),
            _ => Arc::new(self.places(patch, validity, &mut cost.rays)),
        };
        // Samples left out send no shadow rays either.
        let known = known.filter(|(_, old)| old.samples == places);
        let (valid, sphere, mut calm) = (&*places.valid, patch.sphere(), true);
        let mut gradients = SharpGradients::default();
        let mut lights = Vec::with_capacity(self.scene.lights.len());
        for (l, light) in self.scene.lights.iter().enumerate() {
            let share = known.and_then(|(b, old)| b.light(l, light, old, sphere));
            let share = share.or_else(|| {
                wanted(light).then(|| {
                    let (share, shadow) = self.light(l, patch, valid);
                    cost.shadow.lights += shadow.rays;
                    calm &= shadow.agreed().is_some();
                    share
                })
            });
            lights.push(share.map(|(light, _)| light));
            if self.settings.directional {
                gradients.lights.push(share.map(|(_, gradient)| gradient));
            }
        }
        let mut sampled = |from: &Emitters, salt| {
            let (shares, shadows) = self.sampled(from, salt, patch, valid);
            cost.shadow.emitters += shadows.rays;
            // What many elements reflect has no edges.
            calm &= shadows.calm || from.are_reflectors();
            shares
        };
        let (emitters, of_emitters) = match known {
            Some((b, old)) if b.emitters_stay(self, sphere) => b.emitters(old),
            _ => sampled(&self.emitters, 0),
        };
        let (reflectors, of_reflectors) = match known {
            Some((b, old)) if b.reflectors_stay(self, sphere) => b.reflectors(old),
            _ => sampled(&self.reflectors, 2),
        };
        gradients.emitters = of_emitters;
        gradients.reflectors = of_reflectors;
        let light = SharpLight {
            lights,
            emitters,
            reflectors,
            samples: places,
            gradients: self.settings.directional.then(|| gradients.into()),
        };
        (light, calm)
    }

    /// Which samples of a triangle count.
    fn places(&self, patch: &Patch, validity: Validity, traced: &mut u64) -> SamplePlaces {
        let all = 0..patch.samples;
        let valid = match validity {
            Validity::Known(bundle) => bundle.valid().filter(|&i| i < patch.samples).collect(),
            Validity::Sound => all.collect(),
            Validity::Doubtful => all.filter(|&i| !self.inside(patch, i, traced)).collect(),
        };
        SamplePlaces::new(patch.samples, valid, patch.area, |i| patch.place(i).0)
    }

    /// Whether a sample lies inside geometry: it sees black backs.
    fn inside(&self, patch: &Patch, i: u32, traced: &mut u64) -> bool {
        let mut probe = Bundle::default();
        let (b, place) = patch.place(i);
        for ray in 0..PROBES {
            self.ray(patch, place, i * PROBES + ray, &mut probe, traced);
        }
        probe.close(*b, PROBES as usize);
        probe.valid().next().is_none()
    }

    /// What a light brings to a triangle.
    fn light(&self, l: usize, patch: &Patch, valid: &[u32]) -> ((Share, GradientShare), Shadow) {
        let seed = hash(patch.seed, light_seed(self.scene, l));
        let (mut sum, mut gradient) = (Share::default(), GradientShare::default());
        let mut shadow = Shadow::UNKNOWN;
        let (light, asked) = (&self.scene.lights[l], self.settings.directional);
        for &i in valid {
            let &(b, ref place) = patch.place(i);
            let receiver = place.receiver(patch.live);
            let occluders = &self.occluders;
            let brings = arrived(light, occluders, &receiver, (seed, i), asked, &mut shadow);
            sum += patch.share(i, b * brings.light);
            if asked {
                gradient += patch.gradient_share(i, b, brings.gradient);
            }
        }
        ((sum, gradient), shadow)
    }

    /// What sampled elements bring to a triangle; `salt` keeps the two kinds of samples apart.
    fn sampled(
        &self,
        from: &Emitters,
        salt: u32,
        patch: &Patch,
        valid: &[u32],
    ) -> (Shares, ShadowsOfEmitters) {
        if from.tree.leaves.is_empty() {
            return (Shares::default(), ShadowsOfEmitters::NONE);
        }
        let (mut sums, mut gradients) = (Vec::new(), Vec::new());
        let seed = if salt == 0 {
            patch.seed
        } else {
            hash(patch.seed, salt)
        };
        let receiver = |&i: &u32| (patch.block(i), patch.place(i).1.receiver(patch.live));
        let receivers: Vec<_> = valid.iter().map(receiver).collect();
        let group = Group {
            receivers: &receivers,
            blocks: patch.samples,
            rays: from.samples,
            seed,
            gradients: self.settings.directional,
        };
        let shadows = from.light(
            self.elements,
            &self.occluders,
            &group,
            |k, element, brings| {
                let i = valid[k];
                let b = patch.place(i).0;
                add(&mut sums, element, patch.share(i, b * brings.light));
                if group.gradients {
                    let share = patch.gradient_share(i, b, brings.gradient);
                    add(&mut gradients, element, share);
                }
            },
        );
        let gradients = gradients.into_iter().map(|(_, share)| share);
        ((sums.into(), gradients.collect()), shadows)
    }
}

/// Whether a light's share is asked for: dark lights, and those of the engine, wait.
pub(super) fn wanted(light: &Light) -> bool {
    shines(light) && light.direct == DirectLight::Baked
}
