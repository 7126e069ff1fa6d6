use glam::Vec3;

use crate::radiosity::direct::shines;
use crate::radiosity::emitter::{Emitters, Group, Receiver};
use crate::radiosity::gather::{Gather, Place};
use crate::radiosity::gathered::Shining;
use crate::radiosity::gradient::Arrived;
use crate::radiosity::illumination::{Shadow, illumination};
use crate::radiosity::kind::Kind;
use crate::radiosity::light::{DirectLight, Light, LightKind};
use crate::radiosity::occlusion::NO_TRIANGLE;
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::sampling::{cosine_direction, frame, hash};
use crate::radiosity::triangle::face_normal;

/// Asks for the light at points.
///
/// Each point is told twice, by two sets of rays. Points asked with one seed share the two sets, so
/// that light differs from point to point by what is there and not by chance; what chance leaves is
/// another thing in either set.
pub(super) struct Probe<'a> {
    gather: &'a Gather<'a>,
    shining: &'a Shining<'a>,
    pub(super) kind: Kind,
    /// Of the two sets of rays.
    seed: u32,
    /// Directions of the gathering rays of either set, about +Z.
    directions: [Vec<Vec3>; 2],
    /// Shadow rays of a set to each rectangular light, and to emitters known in closed form at least.
    shadow_rays: u32,
    /// Shadow rays to other emitters, within limits.
    few_shadow_rays: u32,
}

/// How many rays a probe sends from a point, in either set.
#[derive(Clone, Copy)]
pub(super) struct ProbeRays {
    /// Gathering rays.
    pub(super) gathering: u32,
    /// Shadow rays to each rectangular light, and to emitters known in closed form at least.
    pub(super) shadow: u32,
}

/// A triangle of a receiving mesh, and the side of it that light is put on.
pub(super) struct Ground<'a> {
    mesh: &'a ReceiverMesh,
    triangle: usize,
    normal: Vec3,
    side: f32,
    live: u32,
}

/// More than this share of rays on black backs, and the point lies inside geometry.
const INSIDE: f32 = 0.25;

/// Rays that tell whether a point without any light lies inside geometry.
const PROBES: u32 = 8;

/// Shadow rays to emitters at least, in each set.
pub(super) const LEAST_SHADOW_RAYS: u32 = 8;

impl<'a> Probe<'a> {
    pub(super) fn new(
        gather: &'a Gather<'a>,
        shining: &'a Shining<'a>,
        kind: Kind,
        seed: u32,
        rays: ProbeRays,
    ) -> Self {
        // Points without any sharp light look around with a few.
        let gathering = match kind {
            Kind::Smooth => rays.gathering,
            Kind::Sharp => PROBES,
        };
        let set = |set| {
            let seed = hash(seed, set);
            (0..gathering)
                .map(|ray| cosine_direction(ray, seed))
                .collect()
        };
        Self {
            gather,
            shining,
            kind,
            seed,
            directions: [set(0), set(1)],
            shadow_rays: rays.shadow,
            few_shadow_rays: rays.gathering / 4,
        }
    }

    /// The triangle of an object's mesh; `None` if no light is put on it.
    pub(super) fn ground(
        &self,
        mesh: &'a ReceiverMesh,
        object: usize,
        triangle: usize,
    ) -> Option<Ground<'a>> {
        let live = self.gather.aids.live(object, mesh.source(triangle));
        let side = self.gather.side(object);
        let normal = face_normal(mesh.corners(triangle)) * side;
        (live != NO_TRIANGLE && normal != Vec3::ZERO).then_some(Ground {
            mesh,
            triangle,
            normal,
            side,
            live,
        })
    }

    /// Light (irradiance / π) at points of a triangle, as the two sets of rays tell it; `None` inside
    /// geometry. `traced` counts rays.
    pub(super) fn light(
        &self,
        ground: &Ground,
        points: &[Vec3],
        traced: &mut u64,
    ) -> Vec<Option<[Vec3; 2]>> {
        let places: Vec<Place> = points.iter().map(|&b| ground.place(b)).collect();
        let sets = match self.kind {
            Kind::Smooth => [0, 1].map(|set| -> Vec<Option<Vec3>> {
                let light = |place| self.gathered(ground, place, set, traced);
                places.iter().map(light).collect()
            }),
            Kind::Sharp => {
                let sets = [0, 1].map(|set| self.sharp(ground, &places, set, traced));
                let dark = |i: usize| sets.iter().all(|set| set[i] == Vec3::ZERO);
                let inside: Vec<bool> = (places.iter().enumerate())
                    .map(|(i, place)| dark(i) && self.gathered(ground, place, 0, traced).is_none())
                    .collect();
                sets.map(|set| {
                    let known = set.into_iter().zip(&inside);
                    known
                        .map(|(light, &inside)| (!inside).then_some(light))
                        .collect()
                })
            }
        };
        let [a, b] = sets;
        a.into_iter().zip(b).map(|(a, b)| Some([a?, b?])).collect()
    }

    /// Mean of what rays meet.
    fn gathered(
        &self,
        ground: &Ground,
        place: &Place,
        set: usize,
        traced: &mut u64,
    ) -> Option<Vec3> {
        let gather = self.gather;
        let receiver = place.receiver(ground.live);
        let seed = hash(self.seed, set as u32);
        let around = frame(place.shading);
        let (mut sum, mut cast, mut black) = (Vec3::ZERO, 0_u32, 0_u32);
        for (ray, &direction) in (0..).zip(&self.directions[set]) {
            let direction = around * direction;
            if direction.dot(place.geometric) <= 0.0 {
                continue;
            }
            cast += 1;
            let chance = hash(seed, ray);
            let occluders = &gather.occluders;
            let Some(hit) = occluders.closest(place.position, direction, ground.live, chance)
            else {
                sum += self.shining.sky;
                continue;
            };
            match gather.elements.spot_at(&hit) {
                None => black += u32::from(!occluders.transmits(hit.triangle)),
                Some(spot) => {
                    let weights = gather.weights(spot.element(), &receiver, direction, &hit);
                    sum += self.shining.of(spot, weights);
                }
            }
        }
        *traced += u64::from(cast);
        let inside = black as f32 > INSIDE * cast as f32;
        (cast > 0 && !inside).then(|| sum / cast as f32)
    }

    /// What lights and sampled emitters bring to places, by one of two sets of shadow rays.
    fn sharp(&self, ground: &Ground, places: &[Place], set: usize, traced: &mut u64) -> Vec<Vec3> {
        let gather = self.gather;
        let receivers: Vec<(u32, Receiver)> = (places.iter())
            .map(|place| (0, place.receiver(ground.live)))
            .collect();
        let seed = hash(self.seed, hash(set as u32, 0x5AA9));
        let mut sums = vec![Vec3::ZERO; places.len()];
        for light in self.shining.lights {
            if light.direct == DirectLight::Baked && shines(light) {
                for (sum, (_, receiver)) in sums.iter_mut().zip(&receivers) {
                    *sum += light.power * self.shadowed(light, receiver, seed, traced);
                }
            }
        }
        for from in [&gather.emitters, &gather.reflectors] {
            let group = Group {
                receivers: &receivers,
                // All take the same rays.
                blocks: 1,
                rays: self.shadow_rays(from),
                seed,
                gradients: false,
            };
            let brings = |k: usize, e, arrived: Arrived| {
                sums[k] += self.shining.sampled(from, e) * arrived.light;
            };
            *traced += from
                .light(gather.elements, &gather.occluders, &group, brings)
                .rays;
        }
        sums
    }

    /// A light at a receiver. As many rays everywhere: to stop where the first few agree would make
    /// penumbrae harder than they are.
    fn shadowed(&self, light: &Light, receiver: &Receiver, seed: u32, traced: &mut u64) -> f32 {
        let mut shadow = Shadow::UNKNOWN;
        let (mut sum, mut blocks) = (0.0, 0);
        let rays = match light.kind {
            LightKind::Rect { .. } => self.shadow_rays.into(),
            _ => 1,
        };
        // A light that does not reach the receiver takes no ray.
        while blocks == 0 || (1..rays).contains(&shadow.rays) {
            let occluders = &self.gather.occluders;
            sum += illumination(light, occluders, receiver, (seed, blocks), &mut shadow);
            blocks += 1;
        }
        *traced += shadow.rays;
        sum / blocks as f32
    }

    /// Shadow rays of either set from each point: the usual number where emitters are known in closed
    /// form, because most faces do with the first few of them, and a penumbra needs all.
    fn shadow_rays(&self, from: &Emitters) -> u32 {
        let usual = from.samples.max(LEAST_SHADOW_RAYS);
        if from.tree.few() {
            usual.max(self.shadow_rays)
        } else {
            self.few_shadow_rays.clamp(LEAST_SHADOW_RAYS, usual)
        }
    }
}

impl Ground<'_> {
    fn place(&self, b: Vec3) -> Place {
        Place::new(self.mesh, self.triangle, b, self.normal, self.side)
    }
}
