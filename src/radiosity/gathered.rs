use std::ops::AddAssign;
use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::bounds::Reach;
use super::element::Elements;
use super::form_factor::{BLACK, GONE, SKY};
use super::light::{DirectLight, Light};
use super::receiver_mesh::ReceiverMesh;
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
    pub(crate) triangles: Vec<TriangleLight>,
    /// First triangle of each object, and one past the last.
    pub(crate) first_of_object: Vec<usize>,
}

impl Gathered {
    pub(crate) fn of_object(&self, object: usize) -> &[TriangleLight] {
        &self.triangles[self.first_of_object[object]..self.first_of_object[object + 1]]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.triangles.iter().map(TriangleLight::bytes).sum()
    }
}

/// How light reaches one triangle.
#[derive(Clone, Default)]
pub(crate) struct TriangleLight {
    pub(crate) bundle: Arc<Bundle>,
    /// By light of power 1; `None` where it is dark or the engine's.
    pub(crate) lights: Vec<Option<Share>>,
    /// By element of unit emission, of those sampled.
    pub(crate) emitters: Arc<[(u32, Share)]>,
    /// By element of unit reflected light, of those sampled.
    pub(crate) reflectors: Arc<[(u32, Share)]>,
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

/// What rays from all samples of a triangle met.
#[derive(Default)]
pub(crate) struct Bundle {
    pub(crate) samples: Vec<Sample>,
    /// Element that each ray met, or why there is none: so many a sample.
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
    b: Vec3,
    /// Rays cast; 0 for a sample inside geometry, which is left out.
    cast: u32,
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

    pub(crate) fn same_samples(&self, other: &Self) -> bool {
        self.samples.len() == other.samples.len()
            && (self.samples.iter().zip(&other.samples)).all(|(a, b)| (a.cast > 0) == (b.cast > 0))
    }
}

impl TriangleLight {
    /// Whether the same was found; shares of elements that happen to be listed in another order
    /// are the same. A light that is not wanted may be known or not.
    #[cfg(test)]
    pub(crate) fn same(&self, other: &Self) -> bool {
        let sorted = |shares: &[(u32, Share)]| {
            let mut shares = shares.to_vec();
            shares.sort_by_key(|s| s.0);
            shares
        };
        self.bundle.ids == other.bundle.ids
            && self.bundle.reaches == other.bundle.reaches
            && sorted(&self.emitters) == sorted(&other.emitters)
            && sorted(&self.reflectors) == sorted(&other.reflectors)
            && (self.lights.iter().zip(&other.lights))
                .all(|(a, b)| a == b || a.is_none() || b.is_none())
    }

    fn bytes(&self) -> u64 {
        let bundle = &self.bundle;
        (size_of::<Self>()
            + size_of::<Bundle>()
            + size_of_val(&*bundle.samples)
            + size_of_val(&*bundle.ids)
            + size_of_val(&*bundle.reaches)
            + size_of_val(&*bundle.met)
            + size_of_val(&*self.lights)
            + size_of_val(&*self.emitters)
            + size_of_val(&*self.reflectors)) as u64
    }
}

/// Light measured at samples inside one triangle, summed up as the vertex fit needs it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleSums {
    /// Σ w b bᵀ over the samples, upper triangle: 00, 01, 02, 11, 12, 22.
    pub(crate) gram: [f32; 6],
    /// Σ w b E for light with sharp edges: from lights and sampled emitters.
    pub(crate) sharp: [Vec3; 3],
    /// Σ w b E for light that rays gathered: bounced light, sky, wide emitters.
    pub(crate) smooth: [Vec3; 3],
}

impl TriangleSums {
    /// Σ w b E of light with sharp edges (0) or gathered by rays (1).
    pub(crate) fn light(&self, kind: usize) -> [Vec3; 3] {
        if kind == 0 { self.sharp } else { self.smooth }
    }

    /// Σ w.
    pub(crate) fn weight(&self) -> f32 {
        let [xx, xy, xz, yy, yz, zz] = self.gram;
        xx + yy + zz + 2.0 * (xy + xz + yz)
    }

    fn add(&mut self, weight: f32, b: Vec3, smooth: Vec3) {
        let products = [
            b.x * b.x,
            b.x * b.y,
            b.x * b.z,
            b.y * b.y,
            b.y * b.z,
            b.z * b.z,
        ];
        for (sum, product) in self.gram.iter_mut().zip(products) {
            *sum += weight * product;
        }
        for k in 0..3 {
            self.smooth[k] += smooth * (weight * b[k]);
        }
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

/// The light that is there, to put into what was gathered.
pub(crate) struct Shining<'a> {
    /// What leaves each element, but for what is sampled.
    seen: Vec<Vec3A>,
    elements: &'a Elements,
    reflected: &'a [Vec3A],
    lights: &'a [Light],
    sky: Vec3,
    /// Rays of a sample.
    rays: usize,
}

impl<'a> Shining<'a> {
    pub(crate) fn new(
        elements: &'a Elements,
        reflected: &'a [Vec3A],
        (lights, sky): (&'a [Light], Vec3),
        rays: u32,
    ) -> Self {
        let leaves = |e: usize| reflected[e] + Vec3A::from(elements.emission[e]);
        Self {
            seen: (0..reflected.len()).map(leaves).collect(),
            elements,
            reflected,
            lights,
            sky,
            rays: rays as usize,
        }
    }

    /// Puts light into one triangle's rays.
    pub(crate) fn fill(
        &self,
        light: &TriangleLight,
        mesh: &ReceiverMesh,
        triangle: usize,
    ) -> TriangleSamples {
        let bundle = &light.bundle;
        let mut samples = TriangleSamples {
            area: area(mesh.corners(triangle)),
            unknowns: mesh.triangles[triangle].map(|v| mesh.unknown[v as usize]),
            taken: bundle.samples.len() as u32,
            ..TriangleSamples::default()
        };
        let weight = samples.area / samples.taken.max(1) as f32;
        let mut met = bundle.met.iter().peekable();
        for (i, sample) in bundle.samples.iter().enumerate() {
            let end = (i + 1) * self.rays;
            let mut sum = self.sum(&bundle.ids[end - self.rays..end]);
            while let Some(m) = met.next_if(|m| (m.ray as usize) < end) {
                let e = m.element as usize;
                sum += self.reflected[e] * m.reflected;
                sum += Vec3A::from(self.elements.emission[e]) * m.emitted;
            }
            if sample.cast == 0 {
                samples.invalid += 1;
                continue;
            }
            let smooth = (Vec3::from(sum) + self.sky * sample.sky as f32) / sample.cast as f32;
            samples.halves[i % 2].add(weight, sample.b, smooth);
        }
        self.add_sharp(light, &mut samples);
        samples
    }

    /// Light of the elements that rays met, four at a time because one addition takes as long as
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

    fn add_sharp(&self, light: &TriangleLight, samples: &mut TriangleSamples) {
        let mut add = |share: &Share, color: Vec3| {
            for (half, sum) in samples.halves.iter_mut().zip(share.0) {
                for k in 0..3 {
                    half.sharp[k] += color * sum[k];
                }
            }
        };
        for (share, light) in light.lights.iter().zip(self.lights) {
            let baked = light.direct == DirectLight::Baked;
            if let Some(share) = share.as_ref().filter(|_| baked) {
                add(share, light.power);
            }
        }
        for (e, share) in light.emitters.iter() {
            add(share, self.elements.emission[*e as usize]);
        }
        for (e, share) in light.reflectors.iter() {
            add(share, self.reflected[*e as usize].into());
        }
    }
}
