use std::cell::OnceCell;
use std::sync::Arc;

use glam::Vec3;

use super::bounds::{Bounds, Reach, Sphere};
use super::change::Change;
use super::direct::{ShadowRays, add, crosses, light_seed, shines};
use super::element::{ElementId, Elements};
use super::emitter::{Emitters, Group, Receiver, ShadowsOfEmitters};
use super::form_factor::{BLACK, GONE, SKY};
use super::gathered::{
    Bundle, Gathered, GradientShare, Met, NOT_CAST, SAMPLED, SHEET, SamplePlaces, Share,
    SharpGradients, SharpLight, Shining, TriangleSamples,
};
use super::gradient::gradient_about_z;
use super::identity::object_seeds;
use super::illumination::{Shadow, arrived};
use super::light::{DirectLight, Light};
use super::occlusion::{Hit, NO_TRIANGLE, OFFSET, Occluders};
use super::receiver_mesh::{ReceiverMesh, ReceiverMeshes};
use super::sampling::{
    cosine_hemisphere, frame, hash, sobol, sobol_2d, triangle as triangle_point,
};
use super::settings::BakeSettings;
use super::spot::Spot;
use super::triangle::{area, face_normal};
use super::validate::ValidScene;

/// What the gather stage traces rays with.
pub(crate) struct Gather<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) occluders: Occluders<'a>,
    pub(crate) elements: &'a Elements,
    pub(crate) emitters: Emitters<'a>,
    /// The reflected light of elements, the brightest of them sampled.
    pub(crate) reflectors: Emitters<'a>,
    /// Elements whose emission is sampled, and those whose reflected light is.
    pub(crate) marks: [&'a [bool]; 2],
    /// For each object, whether the back of its surfaces is the side to light.
    pub(crate) lit_from_behind: &'a [bool],
    pub(crate) settings: &'a BakeSettings,
    pub(crate) density: Density,
    /// Whether to note how far rays went.
    pub(crate) remember: bool,
    pub(crate) aids: Aids,
}

/// Samples per square root of a triangle's area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Density {
    /// Of the coarse meshes.
    pub(crate) smooth: f32,
    /// Of the fine meshes, in shadows' edges.
    pub(crate) sharp: f32,
    /// The same where there is none.
    pub(crate) calm: f32,
}

/// What an earlier bake gathered, of which much is still true.
pub(crate) struct GatherBefore<'a> {
    pub(crate) gathered: &'a Gathered,
    pub(crate) change: &'a Change,
    /// For each object, which one of then has the same samples.
    pub(crate) object_before: &'a [Option<usize>],
    pub(crate) new_emitters: bool,
    pub(crate) new_reflectors: bool,
}

/// What rays and shadow rays a triangle took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GatherCost {
    pub(crate) rays: u64,
    pub(crate) shadow: ShadowRays,
}

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

/// Samples of a triangle at most, however large.
const MAX_SAMPLES: u32 = 256;

/// Samples of a triangle at least, before it is taken to be free of shadows' edges.
const FEW: u32 = 8;

/// By object: what many triangles ask for.
pub(crate) struct Aids {
    /// For each triangle of each object, its live index or [`NO_TRIANGLE`].
    live: Vec<Vec<u32>>,
    seeds: Vec<u32>,
}

impl Aids {
    pub(crate) fn new(scene: &ValidScene) -> Self {
        Self {
            live: scene.live_indices(),
            seeds: object_seeds(scene),
        }
    }

    /// The live index of a triangle of an object, or [`NO_TRIANGLE`].
    pub(crate) fn live(&self, object: usize, triangle: usize) -> u32 {
        self.live[object][triangle]
    }
}

/// Samples per square root of area, so that the mean over vertices is what the settings ask.
///
/// Large triangles see more change of light than small ones, but not in proportion.
pub(crate) fn density(receivers: &ReceiverMeshes, settings: &BakeSettings) -> f32 {
    let meshes = receivers.meshes.iter();
    let roots: f64 = meshes
        .flat_map(|m| (0..m.triangles.len()).map(|t| f64::from(area(m.corners(t))).sqrt()))
        .sum();
    let samples = f64::from(settings.samples_per_vertex) * receivers.vertex_count() as f64;
    (samples / roots.max(f64::MIN_POSITIVE)) as f32
}

/// By element, what its light brings, and the gradients of that, if they are asked for.
type Shares = (Arc<[(u32, Share)]>, Arc<[GradientShare]>);

/// A triangle to sample.
struct Patch<'a> {
    mesh: &'a ReceiverMesh,
    triangle: usize,
    area: f32,
    /// Unit normal of the side to light, and which that is: 1 or −1.
    normal: Vec3,
    side: f32,
    live: u32,
    samples: u32,
    seed: u32,
    places: OnceCell<Vec<(Vec3, Place)>>,
}

impl Gather<'_> {
    /// Rays from all samples of a triangle of the coarse meshes, those that may have changed traced
    /// again.
    pub(crate) fn bundle(
        &self,
        mesh: &ReceiverMesh,
        object: usize,
        triangle: usize,
        before: Option<&GatherBefore>,
        traced: &mut u64,
    ) -> Arc<Bundle> {
        let Some(patch) = self.patch(mesh, object, triangle) else {
            return Arc::default();
        };
        let patch = patch.with(patch.samples_at(self.density.smooth));
        let known = before.and_then(|b| Some((b, &**b.bundle(object, triangle)?)));
        let known = known.filter(|(_, old)| old.samples.len() == patch.samples as usize);
        match known {
            Some((b, _)) if b.rays_stay() => {
                b.bundle(object, triangle).cloned().unwrap_or_default()
            }
            _ => self.rays(&patch, known, traced).into(),
        }
    }

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

    fn patch<'m>(
        &self,
        mesh: &'m ReceiverMesh,
        object: usize,
        triangle: usize,
    ) -> Option<Patch<'m>> {
        let corners = mesh.corners(triangle);
        let live = self.aids.live[object][mesh.source(triangle)];
        let side = self.side(object);
        let normal = face_normal(corners) * side;
        if live == NO_TRIANGLE || normal == Vec3::ZERO {
            return None;
        }
        let salt = hash(self.aids.seeds[object], self.settings.seed ^ 0x6A7E);
        Some(Patch {
            mesh,
            triangle,
            area: area(corners),
            normal,
            side,
            live,
            samples: 0,
            seed: hash(triangle as u32, salt),
            places: OnceCell::new(),
        })
    }

    /// The gradient of the luminance that rays from a triangle gathered, in the place of the light.
    ///
    /// Directions are not kept: they follow from the seed, and a rebake asks for them again. Of light that
    /// is the same from everywhere, `L`, the gradient is `L/2 n`, so that rays need only tell how theirs
    /// differs from the mean `L` of the triangle,
    ///
    /// ```text
    ///   ┌────────────────────────────────────────┐
    ///   │  G = L/2 n + 1/S Σ_i (L_i − L) g(ω_i)    │
    ///   └────────────────────────────────────────┘
    /// ```
    ///
    /// and the large `g` of rays that graze the surface count only where there is something to see.
    pub(crate) fn gathered_gradient(
        &self,
        bundle: &Bundle,
        mesh: &ReceiverMesh,
        object: usize,
        triangle: usize,
        shining: &Shining,
    ) -> TriangleSamples {
        let taken = bundle.samples.len() as u32;
        let mut samples = TriangleSamples::new(mesh, triangle, taken);
        let Some(patch) = self.patch(mesh, object, triangle) else {
            return samples;
        };
        let patch = patch.with(taken);
        let weight = samples.area / taken.max(1) as f32;
        let rays = self.settings.gather_rays;
        let levels = shining.levels(bundle);
        let cast: u32 = bundle.samples.iter().map(|sample| sample.cast).sum();
        let valid = |&(i, _): &(usize, &f32)| bundle.samples[i / rays as usize].cast > 0;
        let all: f32 = (levels.iter().enumerate().filter(valid))
            .map(|(_, level)| level)
            .sum();
        let mean = all / cast.max(1) as f32;
        for (i, sample) in bundle.samples.iter().enumerate() {
            if sample.cast == 0 {
                samples.invalid += 1;
                continue;
            }
            let first = i as u32 * rays;
            let mut sum = Vec3::Z * (0.5 * mean * rays as f32);
            for ray in first..first + rays {
                // Those not cast see the mean.
                if bundle.ids[ray as usize] != NOT_CAST {
                    let apart = levels[ray as usize] - mean;
                    sum += gradient_about_z(patch.direction(ray)) * apart;
                }
            }
            let around = frame(patch.place(i as u32).1.shading);
            let gradient = around * sum / rays as f32;
            samples.halves[i % 2].add(weight, sample.b, gradient);
        }
        samples
    }

    fn rays(
        &self,
        patch: &Patch,
        known: Option<(&GatherBefore, &Bundle)>,
        traced: &mut u64,
    ) -> Bundle {
        let mut bundle = Bundle::default();
        let rays = (patch.samples * self.settings.gather_rays) as usize;
        bundle.ids.reserve_exact(rays);
        bundle
            .reaches
            .reserve_exact(if self.remember { rays } else { 0 });
        bundle.samples.reserve_exact(patch.samples as usize);
        for i in 0..patch.samples {
            let &(b, ref place) = patch.place(i);
            match known {
                None => {
                    let rays = self.settings.gather_rays;
                    for k in 0..rays {
                        self.ray(patch, place, i * rays + k, &mut bundle, traced);
                    }
                }
                Some(known) => self.rays_again(patch, place, i, known, &mut bundle, traced),
            }
            bundle.close(b, self.settings.gather_rays as usize);
        }
        bundle.met.shrink_to_fit();
        bundle
    }

    /// The rays of one sample, again where they may have changed.
    fn rays_again(
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
    fn ray(&self, patch: &Patch, place: &Place, ray: u32, bundle: &mut Bundle, traced: &mut u64) {
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

    /// The side of an object that is lit: 1 for the front, −1 for the back.
    pub(crate) fn side(&self, object: usize) -> f32 {
        if self.lit_from_behind[object] {
            -1.0
        } else {
            1.0
        }
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

impl<'a> GatherBefore<'a> {
    fn bundle(&self, object: usize, triangle: usize) -> Option<&'a Arc<Bundle>> {
        let before = self.object_before[object]?;
        Some(self.gathered.bundles.at(before, triangle))
    }

    fn sharp(&self, object: usize, triangle: usize) -> Option<&'a SharpLight> {
        let before = self.object_before[object]?;
        Some(self.gathered.sharp.at(before, triangle))
    }

    fn rays_stay(&self) -> bool {
        self.change.disturbed.is_empty()
            && self.change.same_elements
            && !self.new_emitters
            && !self.new_reflectors
    }

    /// What a light that is still as it was brought to a triangle.
    fn light(
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

    fn sharp_stays(&self, gather: &Gather, old: &SharpLight, sphere: Sphere) -> bool {
        let mut lights = gather.scene.lights.iter().enumerate();
        lights.all(|(l, light)| !wanted(light) || self.light(l, light, old, sphere).is_some())
            && self.emitters_stay(gather, sphere)
            && self.reflectors_stay(gather, sphere)
    }

    fn emitters_stay(&self, gather: &Gather, sphere: Sphere) -> bool {
        let tree = gather.emitters.tree;
        !self.new_emitters && !tree.disturbed(&self.change.disturbed, sphere)
    }

    fn reflectors_stay(&self, gather: &Gather, sphere: Sphere) -> bool {
        let tree = gather.reflectors.tree;
        !self.new_reflectors && !tree.disturbed(&self.change.disturbed, sphere)
    }

    fn emitters(&self, old: &SharpLight) -> Shares {
        let gradients = old.gradients.as_ref();
        let gradients = gradients.map(|g| g.emitters.clone());
        (self.translate(&old.emitters), gradients.unwrap_or_default())
    }

    fn reflectors(&self, old: &SharpLight) -> Shares {
        let gradients = old.gradients.as_ref();
        let gradients = gradients.map(|g| g.reflectors.clone());
        (
            self.translate(&old.reflectors),
            gradients.unwrap_or_default(),
        )
    }

    fn translate(&self, shares: &Arc<[(u32, Share)]>) -> Arc<[(u32, Share)]> {
        if self.change.same_elements {
            return shares.clone();
        }
        let shares = shares.iter();
        shares
            .map(|&(e, share)| (self.change.translate(e), share))
            .collect()
    }
}

/// Whether a light's share is asked for: dark lights, and those of the engine, wait.
fn wanted(light: &Light) -> bool {
    shines(light) && light.direct == DirectLight::Baked
}

impl Patch<'_> {
    fn samples_at(&self, density: f32) -> u32 {
        // An even number: the half-sets are of one size.
        let pairs = (0.5 * density * self.area.sqrt()).round() as u32;
        (2 * pairs).clamp(2, MAX_SAMPLES)
    }

    fn with(&self, samples: u32) -> Self {
        Self {
            samples,
            places: OnceCell::new(),
            ..*self
        }
    }

    fn sphere(&self) -> Sphere {
        Bounds::of(self.mesh.corners(self.triangle)).sphere()
    }

    /// Sample `i`: weights of the corners, and the place.
    fn place(&self, i: u32) -> &(Vec3, Place) {
        let place = |i| {
            let [u, v, ..] = sobol(i, 0, self.seed);
            let b = triangle_point(u, v);
            let place = Place::new(self.mesh, self.triangle, b, self.normal, self.side);
            (b, place)
        };
        let places = (self.places).get_or_init(|| (0..self.samples).map(place).collect());
        &places[i as usize]
    }

    /// Direction of a ray about +Z.
    fn direction(&self, ray: u32) -> Vec3 {
        let [u, v] = sobol_2d(ray, self.seed);
        cosine_hemisphere(u, v)
    }

    /// Which block of a sequence sample `i` takes: those of a half-set follow each other, so that
    /// each half is spread evenly.
    fn block(&self, i: u32) -> u32 {
        i / 2 + i % 2 * (self.samples / 2)
    }

    /// Light at sample `i`, times the weights of the corners there, as part of the whole.
    fn share(&self, i: u32, light: Vec3) -> Share {
        Share::of_half(i % 2, light * (self.area / self.samples as f32))
    }

    fn gradient_share(&self, i: u32, b: Vec3, gradient: Vec3) -> GradientShare {
        GradientShare::of_half(i % 2, b * (self.area / self.samples as f32), gradient)
    }
}

/// A sample's place on the surface.
pub(crate) struct Place {
    /// Lifted off the surface.
    pub(crate) position: Vec3,
    pub(crate) geometric: Vec3,
    /// Interpolated normal that the surface is shaded with.
    pub(crate) shading: Vec3,
}

impl Place {
    /// As a receiver on a live triangle.
    pub(crate) fn receiver(&self, live: u32) -> Receiver {
        Receiver {
            position: self.position,
            normal: self.shading,
            triangle: live,
        }
    }

    /// The point `b` of a triangle, on the side of its normal `geometric`, which is `side` times that
    /// of the mesh.
    pub(crate) fn new(
        mesh: &ReceiverMesh,
        triangle: usize,
        b: Vec3,
        geometric: Vec3,
        side: f32,
    ) -> Self {
        let vertices = mesh.triangles[triangle].map(|v| v as usize);
        let [p, q, r] = vertices.map(|v| mesh.positions[v]);
        let normals = vertices.map(|v| mesh.normals[v] * side);
        let flat = p * b.x + q * b.y + r * b.z;
        let blended = normals[0] * b.x + normals[1] * b.y + normals[2] * b.z;
        let shading = blended
            .try_normalize()
            .filter(|n| n.dot(geometric) > 0.0)
            .unwrap_or(geometric);
        // Onto the curved surface that the normals tell of, so that the facets of a coarse mesh
        // do not shade themselves (Hanika 2021, "Hacking the Shadow Terminator").
        let mut lift = Vec3::ZERO;
        if shading.dot(geometric) < 0.9999 {
            for (k, corner) in [p, q, r].into_iter().enumerate() {
                lift -= normals[k] * ((flat - corner).dot(normals[k]).min(0.0) * b[k]);
            }
        }
        Self {
            position: flat + lift + geometric * OFFSET,
            geometric,
            shading,
        }
    }
}
