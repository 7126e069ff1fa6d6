use std::borrow::Cow;
use std::ops::AddAssign;
use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::bounds::Reach;
use super::color::luminance;
use super::contribution::Contribution;
use super::element::Elements;
use super::emitter::Emitters;
use super::form_factor::{BLACK, GONE, SKY};
use super::light::{DirectLight, Light};
use super::receiver_mesh::ReceiverMesh;
use super::spot::Spot;
use super::triangle::area;

/// In place of an element: the back of a sheet that light passes in part.
pub(crate) const SHEET: u32 = GONE - 1;

/// In place of an element: it is in the list of those whose light is sampled.
pub(crate) const SAMPLED: u32 = GONE - 2;

/// In place of an element: there is no ray, it would start below the surface.
pub(crate) const NOT_CAST: u32 = GONE - 3;

/// A sample with more than this share of its rays on black back faces lies inside geometry.
const INSIDE: f32 = 0.25;

/// What was gathered for every triangle of the receiving meshes, whatever the colours of lights
/// and surfaces.
#[derive(Default)]
pub(crate) struct Gathered {
    /// Of the coarse meshes.
    pub(crate) bundles: Arc<ByTriangle<Arc<Bundle>>>,
    /// Of the fine meshes.
    pub(crate) sharp: Arc<ByTriangle<SharpLight>>,
}

/// Something for each triangle of each object.
pub(crate) struct ByTriangle<T> {
    pub(crate) list: Vec<T>,
    /// First triangle of each object, and one past the last.
    first_of_object: Vec<usize>,
}

impl<T> Default for ByTriangle<T> {
    fn default() -> Self {
        Self {
            list: Vec::new(),
            first_of_object: vec![0],
        }
    }
}

impl<T> ByTriangle<T> {
    /// Empty, for the triangles of these meshes.
    pub(crate) fn of(meshes: &[ReceiverMesh]) -> Self {
        let mut first_of_object = vec![0];
        let mut end = 0;
        for mesh in meshes {
            end += mesh.triangles.len();
            first_of_object.push(end);
        }
        Self {
            list: Vec::new(),
            first_of_object,
        }
    }

    pub(crate) fn at(&self, object: usize, triangle: usize) -> &T {
        &self.list[self.first_of_object[object] + triangle]
    }
}

impl Gathered {
    pub(crate) fn bytes(&self) -> u64 {
        self.bundles.list.iter().map(|b| b.bytes()).sum::<u64>()
            + self.sharp.list.iter().map(SharpLight::bytes).sum::<u64>()
    }
}

/// How light with sharp edges reaches one triangle: light that shadow rays are sent for.
#[derive(Clone, Default)]
pub(crate) struct SharpLight {
    pub(crate) samples: Arc<SamplePlaces>,
    /// By light of power 1; `None` where it is dark or the engine's.
    pub(crate) lights: Vec<Option<Share>>,
    /// By element of unit emission, of those sampled.
    pub(crate) emitters: Arc<[(u32, Share)]>,
    /// By element of unit reflected light, of those sampled.
    pub(crate) reflectors: Arc<[(u32, Share)]>,
    /// Gradients of all these, if they are asked for.
    pub(crate) gradients: Option<Box<SharpGradients>>,
}

/// Gradients of [`SharpLight`], in the same order.
#[derive(Clone, Default)]
pub(crate) struct SharpGradients {
    pub(crate) lights: Vec<Option<GradientShare>>,
    pub(crate) emitters: Arc<[GradientShare]>,
    pub(crate) reflectors: Arc<[GradientShare]>,
}

/// Where a triangle is sampled, as the fit needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SamplePlaces {
    /// Samples, with those inside geometry.
    pub(crate) taken: u32,
    /// Those that are not inside geometry.
    pub(crate) valid: Vec<u32>,
    /// Σ w b bᵀ of each half-set.
    grams: [[f32; 6]; 2],
}

impl SamplePlaces {
    /// Of `taken` samples, those `valid`, at `place(i)`, on a triangle of this area.
    pub(crate) fn new(
        taken: u32,
        valid: Vec<u32>,
        area: f32,
        mut place: impl FnMut(u32) -> Vec3,
    ) -> Self {
        let weight = area / taken.max(1) as f32;
        let mut grams = [[0.0; 6]; 2];
        for &i in &valid {
            add_gram(&mut grams[i as usize % 2], weight, place(i));
        }
        Self {
            taken,
            valid,
            grams,
        }
    }

    /// The samples of a triangle, before light is put into them.
    fn without_light(&self, mesh: &ReceiverMesh, triangle: usize) -> TriangleSamples {
        let mut samples = TriangleSamples::new(mesh, triangle, self.taken);
        samples.invalid = self.taken - self.valid.len() as u32;
        for (half, gram) in samples.halves.iter_mut().zip(self.grams) {
            half.gram = gram;
        }
        samples
    }
}

/// Σ w b E over the samples of each half-set, for light that is the same number at all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Share([Vec3; 2]);

impl Share {
    pub(crate) fn of_half(half: u32, sum: Vec3) -> Self {
        let mut share = Self::default();
        share.0[half as usize] = sum;
        share
    }
}

impl AddAssign for Share {
    fn add_assign(&mut self, other: Self) {
        self.0[0] += other.0[0];
        self.0[1] += other.0[1];
    }
}

/// Σ w b G over the samples of each half-set, by corner: the gradients of a [`Share`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GradientShare([[Vec3; 3]; 2]);

impl GradientShare {
    /// Of one sample: `weights` of the corners, and its gradient.
    pub(crate) fn of_half(half: u32, weights: Vec3, gradient: Vec3) -> Self {
        let mut share = Self::default();
        share.0[half as usize] = weights.to_array().map(|b| gradient * b);
        share
    }
}

impl AddAssign for GradientShare {
    fn add_assign(&mut self, other: Self) {
        for (sum, other) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *sum += *other;
        }
    }
}

/// What rays from all samples of a triangle met.
#[derive(Default)]
pub(crate) struct Bundle {
    pub(crate) samples: Vec<Sample>,
    /// [`Spot`] that each ray met, or why there is none: so many a sample.
    pub(crate) ids: Vec<u32>,
    /// How far they went; empty if nobody will ask.
    pub(crate) reaches: Vec<Reach>,
    /// Rays that met an element whose light is sampled.
    pub(crate) met: Vec<Met>,
}

/// One sample.
#[derive(Clone, Copy)]
pub(crate) struct Sample {
    /// Weights of the triangle's corners.
    pub(crate) b: Vec3,
    /// Rays cast; 0 for a sample inside geometry, which is left out.
    pub(crate) cast: u32,
    sky: u32,
}

/// A ray that met an element whose light is sampled, and how much of its light counts.
#[derive(Clone, Copy)]
pub(crate) struct Met {
    pub(crate) ray: u32,
    pub(crate) element: u32,
    pub(crate) emitted: f32,
    pub(crate) reflected: f32,
}

impl Bundle {
    pub(crate) fn push(&mut self, id: u32, reach: Option<Reach>) {
        self.ids.push(id);
        self.reaches.extend(reach);
    }

    /// Adds all of another one.
    pub(crate) fn append(&mut self, other: &Self) {
        self.samples.extend_from_slice(&other.samples);
        self.ids.extend_from_slice(&other.ids);
        self.reaches.extend_from_slice(&other.reaches);
        self.met.extend_from_slice(&other.met);
    }

    /// Ends a sample of so many rays.
    pub(crate) fn close(&mut self, b: Vec3, rays: usize) {
        let ids = &self.ids[self.ids.len() - rays..];
        let count = |what: u32| ids.iter().filter(|&&id| id == what).count() as u32;
        let cast = rays as u32 - count(NOT_CAST);
        let inside = count(BLACK) as f32 > INSIDE * cast as f32;
        self.samples.push(Sample {
            b,
            cast: if inside { 0 } else { cast },
            sky: count(SKY),
        });
    }

    /// The samples that are not inside geometry.
    pub(crate) fn valid(&self) -> impl Iterator<Item = u32> + '_ {
        let indices = 0..self.samples.len() as u32;
        indices.filter(|&i| self.samples[i as usize].cast > 0)
    }

    /// Whether any ray met the black back of a surface: the triangle may lie in part inside geometry.
    pub(crate) fn doubtful(&self) -> bool {
        self.ids.contains(&BLACK)
    }

    fn bytes(&self) -> u64 {
        (size_of::<Self>()
            + size_of_val(&*self.samples)
            + size_of_val(&*self.ids)
            + size_of_val(&*self.reaches)
            + size_of_val(&*self.met)) as u64
    }
}

impl SharpLight {
    /// Whether the same was found; shares of elements that happen to be listed in another order
    /// are the same. A light that is not wanted may be known or not.
    #[cfg(test)]
    pub(crate) fn same(&self, other: &Self) -> bool {
        let sorted = |shares: &[(u32, Share)]| {
            let mut shares = shares.to_vec();
            shares.sort_by_key(|s| s.0);
            shares
        };
        self.samples == other.samples
            && sorted(&self.emitters) == sorted(&other.emitters)
            && sorted(&self.reflectors) == sorted(&other.reflectors)
            && self.gradients.is_some() == other.gradients.is_some()
            && (self.lights.iter().zip(&other.lights))
                .all(|(a, b)| a == b || a.is_none() || b.is_none())
    }

    fn bytes(&self) -> u64 {
        (size_of::<Self>()
            + size_of::<SamplePlaces>()
            + size_of_val(&*self.samples.valid)
            + size_of_val(&*self.lights)
            + size_of_val(&*self.emitters)
            + size_of_val(&*self.reflectors)
            + self.gradients.as_ref().map_or(0, |g| g.bytes())) as u64
    }
}

impl SharpGradients {
    fn bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(&*self.lights)
            + size_of_val(&*self.emitters)
            + size_of_val(&*self.reflectors)
    }
}

/// Light measured at samples inside one triangle, summed up as the vertex fit needs it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleSums {
    /// Σ w b bᵀ over the samples, upper triangle: 00, 01, 02, 11, 12, 22.
    pub(crate) gram: [f32; 6],
    /// Σ w b E, or of any other vector in the place of the light.
    pub(crate) light: [Vec3; 3],
}

impl TriangleSums {
    /// Σ w.
    pub(crate) fn weight(&self) -> f32 {
        let [xx, xy, xz, yy, yz, zz] = self.gram;
        xx + yy + zz + 2.0 * (xy + xz + yz)
    }

    pub(crate) fn add(&mut self, weight: f32, b: Vec3, light: Vec3) {
        add_gram(&mut self.gram, weight, b);
        for k in 0..3 {
            self.light[k] += light * (weight * b[k]);
        }
    }
}

fn add_gram(gram: &mut [f32; 6], weight: f32, b: Vec3) {
    let products = [
        b.x * b.x,
        b.x * b.y,
        b.x * b.z,
        b.y * b.y,
        b.y * b.z,
        b.z * b.z,
    ];
    for (sum, product) in gram.iter_mut().zip(products) {
        *sum += weight * product;
    }
}

/// The samples of one triangle: two half-sets, whose difference tells the sampling error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleSamples {
    pub(crate) halves: [TriangleSums; 2],
    /// Area in squared internal units, and unknowns of the corners.
    pub(crate) area: f32,
    pub(crate) unknowns: [u32; 3],
    pub(crate) taken: u32,
    pub(crate) invalid: u32,
}

impl TriangleSamples {
    pub(crate) fn new(mesh: &ReceiverMesh, triangle: usize, taken: u32) -> Self {
        Self {
            area: area(mesh.corners(triangle)),
            unknowns: mesh.triangles[triangle].map(|v| mesh.unknown[v as usize]),
            taken,
            ..Self::default()
        }
    }
}

/// The light that is there, to put into what was gathered.
pub(crate) struct Shining<'a> {
    /// What leaves each spot, but for what is sampled.
    seen: Vec<Vec3A>,
    /// What each element emits and reflects.
    emission: Cow<'a, [Vec3]>,
    reflected: Cow<'a, [Vec3A]>,
    pub(crate) lights: &'a [Light],
    pub(crate) sky: Vec3,
    /// Rays of a sample.
    rays: usize,
}

impl<'a> Shining<'a> {
    /// As much of it as `contribution` asks for.
    pub(crate) fn new(
        elements: &'a Elements,
        reflected: &'a [Vec3A],
        (lights, sky): (&'a [Light], Vec3),
        (contribution, rays): (Contribution, u32),
    ) -> Self {
        let (emission, lights, sky) = match contribution.has_direct() {
            true => (Cow::Borrowed(&*elements.emission), lights, sky),
            false => (vec![Vec3::ZERO; elements.len()].into(), &[][..], Vec3::ZERO),
        };
        let reflected = match contribution.has_indirect() {
            true => Cow::Borrowed(reflected),
            false => vec![Vec3A::ZERO; elements.len()].into(),
        };
        let leaves = |e: usize| reflected[e] + Vec3A::from(emission[e]);
        Self {
            seen: elements.spread(&(0..reflected.len()).map(leaves).collect::<Vec<_>>()),
            emission,
            reflected,
            lights,
            sky,
            rays: rays as usize,
        }
    }

    /// What leaves a spot that a ray met: all of it, or so much of what its element emits and reflects.
    pub(crate) fn of(&self, spot: Spot, weights: Option<[f32; 2]>) -> Vec3 {
        match weights {
            None => self.seen[spot.0 as usize].into(),
            Some(weights) => self.shares(spot.element().0 as usize, weights),
        }
    }

    /// So much of what an element emits and reflects.
    fn shares(&self, e: usize, [emitted, reflected]: [f32; 2]) -> Vec3 {
        self.emission[e] * emitted + Vec3::from(self.reflected[e]) * reflected
    }

    /// What is sampled of an element.
    pub(crate) fn sampled(&self, from: &Emitters, element: u32) -> Vec3 {
        if from.are_reflectors() {
            self.reflected[element as usize].into()
        } else {
            self.emission[element as usize]
        }
    }

    /// Puts light into the rays from one triangle.
    pub(crate) fn gathered(
        &self,
        bundle: &Bundle,
        mesh: &ReceiverMesh,
        triangle: usize,
    ) -> TriangleSamples {
        let mut samples = TriangleSamples::new(mesh, triangle, bundle.samples.len() as u32);
        let weight = samples.area / samples.taken.max(1) as f32;
        let mut met = bundle.met.iter().peekable();
        for (i, sample) in bundle.samples.iter().enumerate() {
            let end = (i + 1) * self.rays;
            let mut sum = self.sum(&bundle.ids[end - self.rays..end]);
            while let Some(m) = met.next_if(|m| (m.ray as usize) < end) {
                let e = m.element as usize;
                sum += self.reflected[e] * m.reflected;
                sum += Vec3A::from(self.emission[e]) * m.emitted;
            }
            if sample.cast == 0 {
                samples.invalid += 1;
                continue;
            }
            let smooth = (Vec3::from(sum) + self.sky * sample.sky as f32) / sample.cast as f32;
            samples.halves[i % 2].add(weight, sample.b, smooth);
        }
        samples
    }

    /// The luminance that each ray of a bundle brings.
    pub(crate) fn levels(&self, bundle: &Bundle) -> Vec<f32> {
        let sky = luminance(self.sky);
        let level = |&id: &u32| match id {
            SKY => sky,
            id => (self.seen.get(id as usize)).map_or(0.0, |&seen| luminance(seen.into())),
        };
        let mut levels: Vec<f32> = bundle.ids.iter().map(level).collect();
        for m in &bundle.met {
            let light = self.shares(m.element as usize, [m.emitted, m.reflected]);
            levels[m.ray as usize] = luminance(light);
        }
        levels
    }

    /// Light of the spots that rays met, four at a time because one addition takes as long as
    /// four that do not wait for each other.
    fn sum(&self, ids: &[u32]) -> Vec3A {
        let value = |id: u32| self.seen.get(id as usize).copied().unwrap_or(Vec3A::ZERO);
        let (fours, rest) = ids.as_chunks::<4>();
        let mut partial = [Vec3A::ZERO; 4];
        for four in fours {
            for (lane, &id) in partial.iter_mut().zip(four) {
                *lane += value(id);
            }
        }
        let rest: Vec3A = rest.iter().map(|&id| value(id)).sum();
        (partial[0] + partial[1]) + (partial[2] + partial[3]) + rest
    }

    /// Puts light into what shadow rays from one triangle found.
    pub(crate) fn arrived(
        &self,
        light: &SharpLight,
        mesh: &ReceiverMesh,
        triangle: usize,
    ) -> TriangleSamples {
        let mut samples = light.samples.without_light(mesh, triangle);
        let mut add = |share: &Share, color: Vec3| {
            for (half, sum) in samples.halves.iter_mut().zip(share.0) {
                for k in 0..3 {
                    half.light[k] += color * sum[k];
                }
            }
        };
        self.of_lights(&light.lights, &mut add);
        for (e, share) in light.emitters.iter() {
            add(share, self.emission[*e as usize]);
        }
        for (e, share) in light.reflectors.iter() {
            add(share, self.reflected[*e as usize].into());
        }
        samples
    }

    /// The gradient of the luminance that [`Self::arrived`] tells of, in the place of the light.
    pub(crate) fn arrived_gradient(
        &self,
        light: &SharpLight,
        mesh: &ReceiverMesh,
        triangle: usize,
    ) -> Option<TriangleSamples> {
        let gradients = light.gradients.as_ref()?;
        let mut samples = light.samples.without_light(mesh, triangle);
        let mut add = |share: &GradientShare, color: Vec3| {
            let level = luminance(color);
            for (half, sum) in samples.halves.iter_mut().zip(&share.0) {
                for (light, sum) in half.light.iter_mut().zip(sum) {
                    *light += *sum * level;
                }
            }
        };
        self.of_lights(&gradients.lights, &mut add);
        for ((e, _), share) in light.emitters.iter().zip(&*gradients.emitters) {
            add(share, self.emission[*e as usize]);
        }
        for ((e, _), share) in light.reflectors.iter().zip(&*gradients.reflectors) {
            add(share, self.reflected[*e as usize].into());
        }
        Some(samples)
    }

    /// What each light that is baked brings, of its shares.
    fn of_lights<S>(&self, shares: &[Option<S>], add: &mut impl FnMut(&S, Vec3)) {
        for (share, light) in shares.iter().zip(self.lights) {
            let baked = light.direct == DirectLight::Baked;
            if let Some(share) = share.as_ref().filter(|_| baked) {
                add(share, light.power);
            }
        }
    }
}
