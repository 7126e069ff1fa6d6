use std::ops::Range;

use glam::{Vec3, Vec3A};

use super::bounds::{Disturbed, Sphere};
use super::change::Change;
use super::element::{ElementId, Elements};
use super::emitter::{Emitters, Group, Receiver};
use super::form_factor::{Traced, View};
use super::gradient::Arrived;
use super::illumination::{Shadow, illumination};
use super::light::{Light, LightKind};
use super::observer::{Observer, Stage};
use super::occlusion::{OFFSET, Occluders};
use super::parallel::{Cancelled, map_chunks, map_ranges};
use super::sampling::{hash, sobol};
use super::validate::ValidScene;

/// Elements a thread takes at a time.
const CHUNK: usize = 64;

/// Points on an element at which light is tested, at least.
const POINTS: u32 = 4;

/// Emitters are tested at one point for so many samples, which are shared out among the points: where
/// a shadow's edge crosses an element, more places tell more than more samples from each.
const SAMPLES_A_POINT: u32 = 4;

/// How lights and sampled emitters reach each element, whatever their colours.
pub(crate) struct Direct {
    /// By element, then light: irradiance / π of a light of power 1.
    reached: Vec<f32>,
    /// Whether a light's column is filled in: dark lights wait until they shine.
    known: Vec<bool>,
    /// By element, from `first_sampled[e]` on: elements that shine, and irradiance / π of their
    /// unit radiance.
    sampled: Vec<(u32, f32)>,
    first_sampled: Vec<u32>,
}

/// What an earlier bake found.
pub(crate) struct DirectBefore<'a> {
    pub(crate) direct: &'a Direct,
    pub(crate) change: &'a Change,
    /// The emitters to sample are others than then.
    pub(crate) new_emitters: bool,
}

/// Samples direct light at elements.
pub(crate) struct Sampler<'a> {
    scene: &'a ValidScene,
    occluders: Occluders<'a>,
    elements: &'a Elements,
    emitters: Emitters<'a>,
    seed: u32,
}

/// Shadow rays to lights and to emitters.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ShadowRays {
    pub(crate) lights: u64,
    pub(crate) emitters: u64,
}

/// Direct light of one element: what each light brings, and the emitters.
struct AtElement {
    reached: Vec<f32>,
    sampled: Vec<(u32, f32)>,
}

impl<'a> Sampler<'a> {
    pub(crate) fn new(view: &View<'a>) -> Self {
        Self {
            scene: view.scene,
            occluders: view.occluders,
            elements: view.elements,
            emitters: view.emitters,
            seed: view.settings.seed,
        }
    }

    /// Samples lights and emitters from every element, where `before` does not answer.
    pub(crate) fn run(
        &self,
        before: Option<&DirectBefore>,
        observer: &dyn Observer,
    ) -> Result<(Direct, ShadowRays), Cancelled> {
        let known: Vec<bool> = (self.scene.lights.iter().enumerate())
            .map(|(l, light)| shines(light) || before.is_some_and(|b| b.whole(l)))
            .collect();
        let chunks = map_ranges(
            self.elements.len(),
            CHUNK,
            Stage::Direct,
            observer,
            |range| {
                let mut rays = ShadowRays::default();
                let list: Vec<AtElement> = range
                    .map(|e| self.at_element(e, &known, before, &mut rays))
                    .collect();
                (list, rays)
            },
        )?;
        let mut direct = Direct {
            reached: Vec::with_capacity(self.elements.len() * self.scene.lights.len()),
            known: known.clone(),
            sampled: Vec::new(),
            first_sampled: vec![0],
        };
        let mut rays = ShadowRays::default();
        for (list, cost) in chunks {
            rays.lights += cost.lights;
            rays.emitters += cost.emitters;
            for at in list {
                direct.reached.extend(at.reached);
                direct.sampled.extend(at.sampled);
                direct.first_sampled.push(direct.sampled.len() as u32);
            }
        }
        Ok((direct, rays))
    }

    fn at_element(
        &self,
        e: usize,
        wanted: &[bool],
        before: Option<&DirectBefore>,
        rays: &mut ShadowRays,
    ) -> AtElement {
        let kept = before.and_then(|b| Some((b, b.change.element_before[e]? as usize)));
        let sphere = || self.elements.sphere(self.scene, ElementId(e as u32));
        let reached = self.scene.lights.iter().enumerate().map(|(l, light)| {
            if !wanted[l] {
                return 0.0;
            }
            let known = kept.and_then(|(b, old)| b.light(l, old));
            let still = |b: &DirectBefore| !crosses(&b.change.disturbed, light, sphere());
            match (known, kept) {
                (Some(value), Some((b, _))) if still(b) => value,
                _ => self.reached(e, l, 0..POINTS, &mut rays.lights),
            }
        });
        let reached = reached.collect();
        let still = |b: &DirectBefore| {
            !b.new_emitters && !self.emitters.tree.disturbed(&b.change.disturbed, sphere())
        };
        let sampled = match kept {
            Some((b, old)) if still(b) => b.sampled(old),
            _ => self.sampled(e, 0..self.emitter_points(), &mut rays.emitters),
        };
        AtElement { reached, sampled }
    }

    /// Mean over points spread over the element.
    fn reached(&self, e: usize, l: usize, points: Range<u32>, rays: &mut u64) -> f32 {
        let seed = self.seed(e);
        let light_seed = hash(seed, light_seed(self.scene, l));
        let light = &self.scene.lights[l];
        let count = points.len() as f32;
        let mut shadow = Shadow::UNKNOWN;
        let at = |i| {
            let receiver = self.receiver(e, i, seed);
            illumination(
                light,
                &self.occluders,
                &receiver,
                (light_seed, i),
                &mut shadow,
            )
        };
        let sum: f32 = points.map(at).sum();
        *rays += shadow.rays;
        sum / count
    }

    /// The same of emitters, by element that shines.
    fn sampled(&self, e: usize, points: Range<u32>, rays: &mut u64) -> Vec<(u32, f32)> {
        let seed = self.seed(e);
        let blocks = self.emitter_points();
        let count = points.len() as f32;
        let receivers: Vec<_> = points.map(|i| (i, self.receiver(e, i, seed))).collect();
        let group = Group {
            receivers: &receivers,
            blocks,
            rays: self.emitters.samples.div_ceil(blocks),
            seed,
            gradients: false,
        };
        let mut sums: Vec<(u32, f32)> = Vec::new();
        let found = |_, from, arrived: Arrived| add(&mut sums, from, arrived.light / count);
        *rays += (self.emitters)
            .light(self.elements, &self.occluders, &group, found)
            .rays;
        sums
    }

    /// Light of lights and sampled emitters at one element, as each half of the points tells it.
    pub(crate) fn halves(&self, e: usize, rays: &mut ShadowRays) -> [Vec3; 2] {
        [0, 1].map(|half| {
            let of = |points: u32| half * points / 2..(half + 1) * points / 2;
            let lights = self.scene.lights.iter().enumerate();
            let lit: Vec3 = lights
                .filter(|(_, light)| shines(light))
                .map(|(l, light)| light.power * self.reached(e, l, of(POINTS), &mut rays.lights))
                .sum();
            let sampled = self.sampled(e, of(self.emitter_points()), &mut rays.emitters);
            let emission =
                |&(from, light): &(u32, f32)| self.elements.emission[from as usize] * light;
            lit + sampled.iter().map(emission).sum::<Vec3>()
        })
    }

    /// Points at which emitters are tested: an even number, for halves.
    fn emitter_points(&self) -> u32 {
        POINTS.max(self.emitters.samples / SAMPLES_A_POINT / 2 * 2)
    }

    fn seed(&self, e: usize) -> u32 {
        self.elements.seed(ElementId(e as u32), hash(self.seed, 1))
    }

    fn receiver(&self, e: usize, i: u32, seed: u32) -> Receiver {
        let [u, v, ..] = sobol(i, 0, seed);
        let point = self.elements.point(self.scene, ElementId(e as u32), u, v);
        Receiver {
            position: point.position + point.normal * OFFSET,
            normal: point.normal,
            triangle: point.triangle,
        }
    }
}

/// The emission of each element that is left to form factors.
pub(crate) fn loose_emission(elements: &Elements, marks: &[bool]) -> Vec<Vec3A> {
    (elements.emission.iter().zip(marks))
        .map(|(&e, &sampled)| Vec3A::from(if sampled { Vec3::ZERO } else { e }))
        .collect()
}

/// Adds to the entry of an element, of which there are few.
pub(crate) fn add<T: std::ops::AddAssign>(sums: &mut Vec<(u32, T)>, element: u32, value: T) {
    match sums.iter_mut().find(|s| s.0 == element) {
        Some(sum) => sum.1 += value,
        None => sums.push((element, value)),
    }
}

/// Whether a light is on.
pub(crate) fn shines(light: &Light) -> bool {
    light.power != Vec3::ZERO
}

/// Apart from other lights', whatever other lights there are.
pub(crate) fn light_seed(scene: &ValidScene, l: usize) -> u32 {
    let key = scene.lights[l].key;
    hash(0x11_6A7, hash(key as u32, (key >> 32) as u32))
}

/// Whether light on its way to any point of a sphere may be disturbed.
pub(crate) fn crosses(disturbed: &Disturbed, light: &Light, to: Sphere) -> bool {
    if disturbed.is_empty() {
        return false;
    }
    let from = |center, radius| Sphere { center, radius };
    match light.kind {
        LightKind::Directional { direction } => disturbed.towards(-direction, to),
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
            disturbed.between(to, from(position, 0.0))
        }
        LightKind::Rect {
            position,
            width,
            height,
            ..
        } => disturbed.between(to, from(position, 0.5 * width.hypot(height))),
    }
}

impl DirectBefore<'_> {
    /// Whether all of a light's column is known, so that it costs nothing to keep.
    fn whole(&self, l: usize) -> bool {
        self.change.disturbed.is_empty()
            && self.change.same_elements
            && self.change.light_before[l].is_some_and(|p| self.direct.known[p])
    }

    /// What a light that is still as it was brought to an element.
    fn light(&self, l: usize, old: usize) -> Option<f32> {
        let before = self.change.light_before[l]?;
        let lights = self.direct.known.len();
        self.direct.known[before].then(|| self.direct.reached[old * lights + before])
    }

    fn sampled(&self, old: usize) -> Vec<(u32, f32)> {
        let entries = self.direct.sampled_at(old).iter();
        entries
            .map(|&(from, light)| (self.change.translate(from), light))
            .collect()
    }
}

impl Direct {
    fn sampled_at(&self, e: usize) -> &[(u32, f32)] {
        &self.sampled[self.first_sampled[e] as usize..self.first_sampled[e + 1] as usize]
    }

    /// Whether all lights that shine are known, and where they were.
    pub(crate) fn knows(&self, lights: &[Light], before: &[Option<usize>]) -> bool {
        let same = before.iter().copied().eq((0..self.known.len()).map(Some));
        same && (lights.iter().zip(&self.known)).all(|(light, &known)| known || !shines(light))
    }

    /// Direct light (irradiance / π) at each element, with what form-factor rays found of sky and
    /// emitters. `marks` says which elements' emission is sampled.
    pub(crate) fn arriving(
        &self,
        scene: &ValidScene,
        elements: &Elements,
        traced: &Traced,
        marks: &[bool],
    ) -> Vec<Vec3> {
        let loose = loose_emission(elements, marks);
        let any = loose.iter().any(|&l| l != Vec3A::ZERO);
        let loose = any.then_some(&*loose);
        let lights = scene.lights.len();
        let at = |e: usize| {
            let reached = &self.reached[e * lights..(e + 1) * lights];
            let lit: Vec3 = (scene.lights.iter().zip(reached))
                .map(|(light, &r)| light.power * r)
                .sum();
            let sampled: Vec3 = (self.sampled_at(e).iter())
                .map(|&(from, light)| elements.emission[from as usize] * light)
                .sum();
            traced.found(e, elements, loose, scene.sky) + lit + sampled
        };
        let parts = map_chunks(elements.len(), 1024, |r| r.map(at).collect::<Vec<_>>());
        parts.concat()
    }

    /// Whether the same was found; a light that is dark may be known or not.
    #[cfg(test)]
    pub(crate) fn same(&self, other: &Self) -> bool {
        let lights = self.known.len();
        let both = |i: usize| self.known[i % lights] && other.known[i % lights];
        self.sampled == other.sampled
            && (self.reached.iter().zip(&other.reached).enumerate())
                .all(|(i, (a, b))| a == b || !both(i))
    }

    pub(crate) fn bytes(&self) -> u64 {
        (4 * (self.reached.len() + self.first_sampled.len()) + 8 * self.sampled.len()) as u64
    }
}
