use std::sync::Arc;

use glam::Vec3;

use super::patch::Patch;
use super::{Gather, GatherBefore, Place};
use crate::radiosity::bounds::{Reach, Sphere};
use crate::radiosity::element::ElementId;
use crate::radiosity::emitter::{Emitters, Receiver};
use crate::radiosity::form_factor::{BLACK, GONE, SKY};
use crate::radiosity::gathered::{Bundle, ByTriangle, Met, NOT_CAST, SAMPLED, SHEET};
use crate::radiosity::occlusion::Hit;
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::sampling::{frame, hash};
use crate::radiosity::spot::Spot;

/// Rays that need not be traced.
#[derive(Clone, Copy)]
pub(crate) enum KnownRays<'a> {
    None,
    /// Those of an earlier bake, where nothing came between.
    Before(&'a GatherBefore<'a>),
    /// Those of the same bake, of as many samples or fewer.
    Fewer(&'a ByTriangle<Arc<Bundle>>),
}

impl Gather<'_> {
    /// Rays from all samples of a triangle of the coarse meshes, those that are `known` not traced again.
    pub(crate) fn bundle(
        &self,
        mesh: &ReceiverMesh,
        object: usize,
        triangle: usize,
        known: KnownRays,
        traced: &mut u64,
    ) -> Arc<Bundle> {
        let Some(patch) = self.patch(mesh, object, triangle) else {
            return Arc::default();
        };
        let patch = patch.with(patch.samples_at(self.density.smooth));
        let samples = patch.samples as usize;
        match known {
            KnownRays::Before(before) => match before.bundle(object, triangle) {
                Some(old) if old.samples.len() == samples && before.rays_stay() => old.clone(),
                Some(old) if old.samples.len() == samples => {
                    self.rays_again(&patch, (before, old), traced).into()
                }
                _ => self.rays(&patch, None, traced).into(),
            },
            KnownRays::Fewer(bundles) => {
                let first = bundles.at(object, triangle);
                if first.samples.len() == samples {
                    first.clone()
                } else {
                    self.rays(&patch, Some(first), traced).into()
                }
            }
            KnownRays::None => self.rays(&patch, None, traced).into(),
        }
    }

    /// How many rays the samples of a triangle take.
    pub(crate) fn rays_of(&self, mesh: &ReceiverMesh, object: usize, triangle: usize) -> u64 {
        let samples = (self.patch(mesh, object, triangle))
            .map_or(0, |patch| patch.samples_at(self.density.smooth));
        u64::from(samples) * u64::from(self.settings.gather_rays)
    }

    /// Rays from all samples, of which a bundle may have the first: places and directions are points of
    /// sequences.
    fn rays(&self, patch: &Patch, first: Option<&Bundle>, traced: &mut u64) -> Bundle {
        let rays = self.settings.gather_rays;
        let mut bundle = self.room(patch);
        if let Some(first) = first {
            bundle.append(first);
        }
        for i in bundle.samples.len() as u32..patch.samples {
            let &(b, ref place) = patch.place(i);
            for k in 0..rays {
                self.ray(patch, place, i * rays + k, &mut bundle, traced);
            }
            bundle.close(b, rays as usize);
        }
        bundle.met.shrink_to_fit();
        bundle
    }

    /// Rays from all samples, those of an earlier bake where they cannot have changed.
    fn rays_again(&self, patch: &Patch, old: (&GatherBefore, &Bundle), traced: &mut u64) -> Bundle {
        let mut bundle = self.room(patch);
        for i in 0..patch.samples {
            let &(b, ref place) = patch.place(i);
            self.sample_again(patch, place, i, old, &mut bundle, traced);
            bundle.close(b, self.settings.gather_rays as usize);
        }
        bundle.met.shrink_to_fit();
        bundle
    }

    /// An empty bundle with room for the rays of all samples.
    fn room(&self, patch: &Patch) -> Bundle {
        let mut bundle = Bundle::default();
        let rays = (patch.samples * self.settings.gather_rays) as usize;
        bundle.ids.reserve_exact(rays);
        bundle
            .reaches
            .reserve_exact(if self.remember { rays } else { 0 });
        bundle.samples.reserve_exact(patch.samples as usize);
        bundle
    }

    /// The rays of one sample, again where they may have changed.
    fn sample_again(
        &self,
        patch: &Patch,
        place: &Place,
        sample: u32,
        (before, old): (&GatherBefore, &Bundle),
        bundle: &mut Bundle,
        traced: &mut u64,
    ) {
        let change = before.change;
        let disturbed = change.disturbed.from(Sphere {
            center: place.position,
            radius: 0.0,
        });
        let other = before.new_emitters || before.new_reflectors;
        let rays = self.settings.gather_rays;
        let first = sample * rays;
        let start = old.met.partition_point(|m| m.ray < first);
        let mut met = old.met[start..].iter().peekable();
        for ray in first..first + rays {
            let (id, reach) = (old.ids[ray as usize], old.reaches[ray as usize]);
            let known = met.next_if(|m| m.ray == ray);
            if id == NOT_CAST {
                bundle.push(id, Some(reach));
                continue;
            }
            let spot = Spot(id);
            let now = match known {
                Some(m) => change.translate(m.element),
                None if spot.is_one() => change.translate(spot.element().0),
                None => id,
            };
            let marked = || {
                self.marks
                    .iter()
                    .any(|m| m.get(now as usize) == Some(&true))
            };
            let stale = now == GONE || (other && (known.is_some() || marked()));
            if stale || disturbed.ray(reach) {
                self.ray(patch, place, ray, bundle, traced);
                continue;
            }
            let found = match known {
                Some(_) => SAMPLED,
                None if spot.is_one() => spot.of(now).0,
                None => now,
            };
            bundle.push(found, Some(reach));
            bundle.met.extend(known.map(|m| Met { element: now, ..*m }));
        }
    }

    /// Traces a ray. The samples of a triangle share one sequence of directions, each taking a
    /// block of its own: so they are spread evenly together, and the triangle's light is far better
    /// known than that of one sample.
    pub(super) fn ray(
        &self,
        patch: &Patch,
        place: &Place,
        ray: u32,
        bundle: &mut Bundle,
        traced: &mut u64,
    ) {
        let direction = frame(place.shading) * patch.direction(ray);
        let reach = |distance| self.remember.then(|| Reach::new(direction, distance));
        // A smooth normal may point rays below the surface: those see nothing real, the others
        // stand in for them.
        if direction.dot(place.geometric) <= 0.0 {
            return bundle.push(NOT_CAST, reach(0.0));
        }
        *traced += 1;
        let seed = hash(patch.seed, ray);
        let hit = (self.occluders).closest(place.position, direction, patch.live, seed);
        let Some(hit) = hit else {
            return bundle.push(SKY, reach(f32::INFINITY));
        };
        let reach = reach(hit.distance);
        let Some(spot) = self.elements.spot_at(&hit) else {
            // A leaf or a veil is a sheet, not the inside of anything.
            let sheet = self.occluders.transmits(hit.triangle);
            return bundle.push(if sheet { SHEET } else { BLACK }, reach);
        };
        let (element, receiver) = (spot.element(), place.receiver(patch.live));
        let Some([emitted, reflected]) = self.weights(element, &receiver, direction, &hit) else {
            return bundle.push(spot.0, reach);
        };
        bundle.push(SAMPLED, reach);
        bundle.met.push(Met {
            ray,
            element: element.0,
            emitted,
            reflected,
        });
    }

    /// How much counts of what an element emits and reflects, that a ray met; `None` if all of it does
    /// because neither is sampled.
    pub(crate) fn weights(
        &self,
        element: ElementId,
        receiver: &Receiver,
        direction: Vec3,
        hit: &Hit,
    ) -> Option<[f32; 2]> {
        if !self.marks.iter().any(|m| m[element.0 as usize]) {
            return None;
        }
        let weight = |mark: usize, from: &Emitters| {
            if self.marks[mark][element.0 as usize] {
                from.ray_weight(element, receiver, direction, hit)
            } else {
                1.0
            }
        };
        Some([weight(0, &self.emitters), weight(1, &self.reflectors)])
    }
}
