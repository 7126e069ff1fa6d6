use std::ops::AddAssign;

use glam::Vec3;

use super::{Emitters, Group, Light, Receiver, ShadowsOfEmitters};
use crate::radiosity::direct::add;
use crate::radiosity::element::Elements;
use crate::radiosity::emitter_tree::Leaf;
use crate::radiosity::facet::{Facet, Way};
use crate::radiosity::gradient::{Arrived, gradient_of};
use crate::radiosity::illumination::Shadow;
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::sampling::{hash, sobol_2d};

/// One of so many shadow rays is of the first round, at least.
const FIRST: u32 = 4;

/// Rays of the first round, from a group to a lamp, at least; and so many are enough.
///
/// If `n` evenly spread rays see all of a lamp of which the share `s` is hidden, which happens with
/// probability `1 − n s`, the share counts as seen: on average that is `s (1 − n s)` of its light
/// too much, `1/4n` at worst.
const AGREEING: u32 = 48;
const ENOUGH: u32 = 160;

/// Points by which the light of an emitter that is not evenly bright is shared out among its
/// elements, at least, where that takes no rays.
const SHARING: u32 = 64;

/// Few emissive triangles: in closed form but for what stands between (see [`Facet`]).
///
/// Triangles of a lamp that are equally bright count as one emitter. A point of it is drawn on
/// triangle `l` by its form factor `F_l`, and there evenly over the area `A_l` above the horizon:
///
/// ```text
///   ┌──────────────────────────────────────────┐
///   │  H = L Σ_l F_l · Σ w_i V_i / Σ w_i       │     w = g A_l / F_l
///   └──────────────────────────────────────────┘
/// ```
///
/// Of this an element gets the part of `Σ w_i V_i` that is on it, where the lamp is not evenly bright.
///
/// Rays are traced in two rounds. If all rays of the first, from all receivers of a group, find that
/// the same share of light passes, as they do everywhere but in penumbrae, it is taken to be so.
/// Were each receiver to decide for itself, those whose few rays happen to agree would stop, and
/// penumbrae would be too hard: the more rays have a say, the less that can be.
pub(super) struct Closed<'c> {
    pub(super) emitters: &'c Emitters<'c>,
    pub(super) elements: &'c Elements,
    pub(super) occluders: &'c Occluders<'c>,
    pub(super) group: &'c Group<'c>,
}

/// A lamp as a group of receivers sees it.
struct Lamp<'c> {
    leaves: &'c [Leaf],
    seed: u32,
    /// What it may bring to all of them, to be held against other lamps.
    light: f64,
    sights: Vec<Sight>,
    shadow: Shadow,
}

/// A lamp as one receiver sees it, and what rays say: `Σ w` and, by element, `Σ w V`.
struct Sight {
    /// Which of its triangles, and how they look.
    facets: Vec<(usize, Facet)>,
    factor: f64,
    whole: f64,
    seen: Vec<(u32, Seen)>,
}

/// `Σ w V`, and the same times the gradient of each way, if that is asked for.
struct Seen {
    light: f64,
    gradient: Vec3,
}

impl AddAssign for Seen {
    fn add_assign(&mut self, other: Self) {
        self.light += other.light;
        self.gradient += other.gradient;
    }
}

impl Closed<'_> {
    /// Tells `found` the light of each lamp's elements at each receiver.
    pub(super) fn light(&self, found: &mut impl FnMut(usize, u32, Arrived)) -> ShadowsOfEmitters {
        let leaves = &self.emitters.tree.leaves;
        let lamps = leaves.chunk_by(Leaf::is_one_lamp_with);
        let mut lamps: Vec<Lamp> = (0..)
            .zip(lamps)
            .map(|(k, leaves)| self.lamp(leaves, hash(self.group.seed, k)))
            .filter(|lamp| lamp.light > 0.0)
            .collect();
        let all: f64 = lamps.iter().map(|lamp| lamp.light).sum();
        let mut shadows = ShadowsOfEmitters::NONE;
        for lamp in &mut lamps {
            // Rays by what it may bring, one at least.
            let rays = (f64::from(self.group.rays) * lamp.light / all).round();
            self.rounds(lamp, rays.max(1.0) as u32);
            shadows.rays += lamp.shadow.rays;
            shadows.calm &= lamp.shadow.agreed().is_some();
            for (k, sight) in lamp.sights.iter().enumerate() {
                for (e, seen) in &sight.seen {
                    let light = (sight.factor * seen.light / sight.whole) as f32;
                    let gradient = seen.gradient * (sight.factor / sight.whole) as f32;
                    let arrived = Arrived { light, gradient };
                    found(k, *e, arrived * self.elements.coverage[*e as usize]);
                }
            }
        }
        shadows
    }

    fn lamp<'l>(&self, leaves: &'l [Leaf], seed: u32) -> Lamp<'l> {
        let mut light = 0.0;
        let mut sight = |receiver: &Receiver| {
            let seen = leaves.iter().enumerate();
            let facets: Vec<(usize, Facet)> = seen
                .filter_map(|(l, leaf)| Some((l, leaf.seen_from(receiver)?)))
                .collect();
            for (l, facet) in &facets {
                light += f64::from(leaves[*l].radiance) * facet.factor;
            }
            Sight {
                factor: facets.iter().map(|(_, facet)| facet.factor).sum(),
                facets,
                whole: 0.0,
                seen: Vec::new(),
            }
        };
        let receivers = self.group.receivers.iter();
        let sights = receivers.map(|(_, receiver)| sight(receiver)).collect();
        Lamp {
            leaves,
            seed,
            light,
            sights,
            shadow: Shadow::UNKNOWN,
        }
    }

    /// Both rounds of rays to a lamp, `rays` from each receiver.
    fn rounds(&self, lamp: &mut Lamp, rays: u32) {
        let blocks = self.group.blocks;
        let of_each = |all: u32| all.div_ceil(self.group.receivers.len() as u32);
        let first = rays
            .div_ceil(FIRST)
            .clamp(of_each(AGREEING), of_each(ENOUGH))
            .min(rays);
        self.round(lamp, 0, first, None);
        let (start, rest) = (blocks * first, rays - first);
        match lamp.shadow.agreed() {
            None => self.round(lamp, start, rest, None),
            known if lamp.leaves.iter().any(|leaf| !leaf.even) => {
                self.round(lamp, start, rest.max(SHARING), known);
            }
            Some(_) => {}
        }
    }

    /// `rays` of each receiver, from `start` of the sequence on; none are traced if it is known how
    /// much passes.
    fn round(&self, lamp: &mut Lamp, start: u32, rays: u32, known: Option<f32>) {
        for (&(block, ref receiver), sight) in self.group.receivers.iter().zip(&mut lamp.sights) {
            if sight.facets.is_empty() {
                continue;
            }
            let from = start + block * rays;
            for i in from..from + rays {
                let point = sobol_2d(i, lamp.seed);
                let Some((l, way, weight)) = sight.way(receiver.normal, point) else {
                    continue;
                };
                sight.whole += weight;
                let leaf = &lamp.leaves[l];
                let Some(element) = self.element(receiver, leaf, &way) else {
                    continue;
                };
                let passing =
                    known.unwrap_or_else(|| lamp.shadow.ray(self.passing(receiver, leaf, &way)));
                let light = weight * f64::from(passing);
                let mut gradient = Vec3::ZERO;
                if self.group.gradients && light > 0.0 {
                    gradient = gradient_of(receiver.normal, way.direction()) * light as f32;
                }
                add(&mut sight.seen, element, Seen { light, gradient });
            }
        }
    }

    fn passing(&self, receiver: &Receiver, leaf: &Leaf, way: &Way) -> f32 {
        self.occluders.transmittance(
            receiver.position,
            way.direction(),
            way.distance - OFFSET,
            [receiver.triangle, leaf.triangle],
        )
    }

    /// The element at a point of an emitter, if it shines.
    fn element(&self, receiver: &Receiver, leaf: &Leaf, way: &Way) -> Option<u32> {
        match self.emitters.light {
            Light::Reflected => Some(leaf.source),
            Light::Emission => {
                // Where all are equally bright, any of them stands for all.
                let uv = match leaf.even {
                    true => [0.0; 2],
                    false => leaf.uv(receiver.position + way.to),
                };
                let back = leaf.normal.dot(way.to) > 0.0;
                let element = self.elements.side_at(leaf.triangle, uv, back)?;
                // Whether an element emits is known as long as a tree is kept.
                let emission = self.elements.emission[element.0 as usize];
                (emission != Vec3::ZERO).then_some(element.0)
            }
        }
    }
}

impl Sight {
    /// Point `u`, `v` (each 0..1) of the lamp: on which of its triangles, the way there, and its
    /// weight.
    fn way(&self, up: Vec3, [u, v]: [f32; 2]) -> Option<(usize, Way, f64)> {
        let mut u = f64::from(u) * self.factor;
        let last = self.facets.len() - 1;
        for (k, (l, facet)) in self.facets.iter().enumerate() {
            if u < facet.factor || k == last {
                let share = (u / facet.factor).min(1.0) as f32;
                let way = facet.way(up, [share, v])?;
                let weight = f64::from(way.brings * facet.area) / facet.factor;
                return Some((*l, way, weight));
            }
            u -= facet.factor;
        }
        None
    }
}
