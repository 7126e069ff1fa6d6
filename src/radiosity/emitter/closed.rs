use glam::Vec3;

use super::{Emitters, Group, Light, Receiver};
use crate::radiosity::direct::add;
use crate::radiosity::element::Elements;
use crate::radiosity::emitter_tree::Leaf;
use crate::radiosity::facet::{Facet, Way};
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::sampling::{hash, sobol};

/// One of so many shadow rays is of the first round, at least.
const FIRST: u32 = 4;

/// Rays of the first round, from a group to a lamp, at least.
///
/// If `n` evenly spread rays see all of a lamp of which the share `s` is hidden, which happens with
/// probability `1 − n s`, the share counts as seen: on average that is `s (1 − n s)` of its light
/// too much, `1/4n` at worst.
const AGREEING: u32 = 40;

/// Points by which an emitter's light is shared out among several elements, at least, where that
/// takes no rays: the elements' form factors, as good as is wanted.
const SHARING: u32 = 64;

/// Few emitters: each in closed form, but for what stands between (see [`Facet`]).
///
/// Rays are traced in two rounds. If all rays of the first, from all receivers of a group to all
/// emitters of a lamp, find that the same share of light passes, as they do everywhere but in
/// penumbrae, it is taken to be so. Were each receiver to decide for itself, those whose few rays
/// happen to agree would stop, and penumbrae would be too hard: the more rays have a say, the less
/// that can be.
pub(super) struct Closed<'c> {
    pub(super) emitters: &'c Emitters<'c>,
    pub(super) elements: &'c Elements,
    pub(super) occluders: &'c Occluders<'c>,
    pub(super) group: &'c Group<'c>,
}

/// The least and the most of nothing.
const NOTHING: (f32, f32) = (f32::INFINITY, f32::NEG_INFINITY);

/// An emitter as a group of receivers sees it.
struct View<'c> {
    leaf: &'c Leaf,
    seed: u32,
    /// What it may bring to all of them, to be held against other emitters.
    light: f64,
    /// Shadow rays of each receiver: by that light, one at least.
    rays: u32,
    sights: Vec<Sight>,
    /// The least and the most light that rays found to pass.
    passing: (f32, f32),
}

/// An emitter as one receiver sees it, and what rays say: `Σ g` and, by element, `Σ g V`.
struct Sight {
    facet: Option<Facet>,
    whole: f64,
    seen: Vec<(u32, f64)>,
}

impl Closed<'_> {
    /// Tells `found` the light of each emitter's elements at each receiver. Returns how many shadow
    /// rays that took.
    pub(super) fn light(&self, found: &mut impl FnMut(usize, u32, f32)) -> u64 {
        let mut views: Vec<View> = (0..self.emitters.tree.leaves.len() as u32)
            .map(|leaf| self.view(leaf))
            .filter(|view| view.light > 0.0)
            .collect();
        let all: f64 = views.iter().map(|view| view.light).sum();
        for view in &mut views {
            let share = f64::from(self.group.rays) * view.light / all;
            view.rays = share.round().max(1.0) as u32;
        }
        let lamps = views.chunk_by_mut(|a, b| a.leaf.lamp == b.leaf.lamp);
        let traced = lamps.map(|lamp| self.lamp(lamp)).sum();
        for view in &views {
            for (k, sight) in view.sights.iter().enumerate() {
                let factor = sight.facet.as_ref().map_or(0.0, |f| f.factor);
                for &(e, seen) in &sight.seen {
                    let light = factor * seen / sight.whole;
                    found(k, e, light as f32 * self.elements.coverage[e as usize]);
                }
            }
        }
        traced
    }

    fn view(&self, leaf: u32) -> View<'_> {
        let tree = self.emitters.tree;
        let (seed, leaf) = (hash(self.group.seed, leaf), &tree.leaves[leaf as usize]);
        let receivers = self.group.receivers.iter();
        let sights: Vec<Sight> = receivers
            .map(|(_, receiver)| Sight {
                facet: leaf.seen_from(receiver),
                whole: 0.0,
                seen: Vec::new(),
            })
            .collect();
        let factors = sights.iter().flat_map(|s| &s.facet).map(|f| f.factor);
        View {
            leaf,
            seed,
            light: f64::from(tree.radiance(leaf)) * factors.sum::<f64>(),
            rays: 0,
            sights,
            passing: NOTHING,
        }
    }

    /// Both rounds of rays to the emitters of a lamp.
    fn lamp(&self, views: &mut [View]) -> u64 {
        let blocks = self.group.blocks;
        let all: u32 = views.iter().map(|view| view.rays).sum();
        let least = AGREEING.div_ceil(blocks).max(all.div_ceil(FIRST));
        let first = |view: &View| (view.rays * least).div_ceil(all).min(view.rays);
        let mut traced = 0;
        for view in &mut *views {
            traced += self.round(view, 0, first(view), None);
        }
        let passing = views.iter().map(|view| view.passing);
        let (least, most) = passing.fold(NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let agreed = (least == most).then_some(least);
        for view in views {
            let (start, rest) = (blocks * first(view), view.rays - first(view));
            if agreed.is_none() {
                traced += self.round(view, start, rest, None);
            } else if self.several(view.leaf) {
                self.round(view, start, rest.max(SHARING), agreed);
            }
        }
        traced
    }

    /// `rays` of each receiver, from `start` of the sequence on; none are traced if it is known how
    /// much passes.
    fn round(&self, view: &mut View, start: u32, rays: u32, known: Option<f32>) -> u64 {
        let mut traced = 0;
        for (&(block, ref receiver), sight) in self.group.receivers.iter().zip(&mut view.sights) {
            let Some(facet) = &sight.facet else {
                continue;
            };
            let from = start + block * rays;
            for i in from..from + rays {
                let [u, v, ..] = sobol(i, 1, view.seed);
                let Some(way) = facet.way(receiver.normal, [u, v]) else {
                    continue;
                };
                sight.whole += f64::from(way.brings);
                let Some(element) = self.element(receiver, view.leaf, &way) else {
                    continue;
                };
                let passing = known.unwrap_or_else(|| {
                    traced += 1;
                    self.passing(receiver, view.leaf, &way)
                });
                let (least, most) = view.passing;
                view.passing = (least.min(passing), most.max(passing));
                add(&mut sight.seen, element, f64::from(way.brings * passing));
            }
        }
        traced
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
                let uv = leaf.uv(receiver.position + way.to);
                let back = leaf.normal.dot(way.to) > 0.0;
                let element = self.elements.side_at(leaf.triangle, uv, back)?;
                // Whether an element emits is known as long as a tree is kept.
                let emission = self.elements.emission[element.0 as usize];
                (emission != Vec3::ZERO).then_some(element.0)
            }
        }
    }

    /// Whether a leaf shows several elements on a side.
    fn several(&self, leaf: &Leaf) -> bool {
        let sides = if leaf.two_sided { 2 } else { 1 };
        let elements = || self.elements.of_triangle(leaf.triangle);
        self.emitters.light == Light::Emission && elements().count() > sides
    }
}
