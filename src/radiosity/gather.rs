use glam::Vec3;

use super::element::Elements;
use super::emitter::{Emitters, Receiver};
use super::illumination::illumination;
use super::light::DirectLight;
use super::observer::{Observer, Stage};
use super::occlusion::{NO_TRIANGLE, OFFSET, Occluders};
use super::parallel::{Cancelled, map_ranges};
use super::receiver_mesh::{ReceiverMesh, ReceiverMeshes};
use super::sampling::{cosine_hemisphere, frame, hash, sobol, triangle as triangle_point};
use super::settings::BakeSettings;
use super::triangle::{area, face_normal};
use super::validate::ValidScene;

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

    fn add(&mut self, weight: f32, b: Vec3, sharp: Vec3, smooth: Vec3) {
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
            self.sharp[k] += sharp * (weight * b[k]);
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

/// What the gather stage reads.
pub(crate) struct Gather<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) occluders: &'a Occluders<'a>,
    pub(crate) elements: &'a Elements,
    pub(crate) emitters: Emitters<'a>,
    /// The reflected light of elements, the brightest of them sampled.
    pub(crate) reflectors: Emitters<'a>,
    /// For each object, whether the back of its surfaces is the side to light.
    pub(crate) lit_from_behind: &'a [bool],
    /// For each triangle of each object, its live index or [`NO_TRIANGLE`].
    pub(crate) live: &'a [Vec<u32>],
    pub(crate) settings: &'a BakeSettings,
}

/// A sample with more than this share of its rays on black back faces lies inside geometry.
const INSIDE: f32 = 0.25;

/// Triangles a thread takes at a time.
const CHUNK: usize = 32;

/// Samples of a triangle at most, however large.
const MAX_SAMPLES: u32 = 256;

impl Gather<'_> {
    /// Measures irradiance at samples inside every triangle of the receiving meshes.
    pub(crate) fn run(
        &self,
        receivers: &ReceiverMeshes,
        observer: &dyn Observer,
    ) -> Result<Vec<TriangleSamples>, Cancelled> {
        let list: Vec<(u32, u32)> = receivers
            .meshes
            .iter()
            .enumerate()
            .flat_map(|(o, m)| (0..m.triangles.len() as u32).map(move |t| (o as u32, t)))
            .collect();
        let density = self.density(receivers);
        let chunks = map_ranges(list.len(), CHUNK, Stage::Gather, observer, |range| {
            list[range]
                .iter()
                .map(|&(o, t)| self.triangle(&receivers.meshes[o as usize], o, t, density))
                .collect::<Vec<_>>()
        })?;
        Ok(chunks.concat())
    }

    /// Samples per square root of area, so that the mean over vertices is what the settings ask.
    ///
    /// Large triangles see more change of light than small ones, but not in proportion.
    fn density(&self, receivers: &ReceiverMeshes) -> f32 {
        let roots: f64 = receivers
            .meshes
            .iter()
            .flat_map(|m| (0..m.triangles.len()).map(|t| f64::from(area(m.corners(t))).sqrt()))
            .sum();
        let samples = f64::from(self.settings.samples_per_vertex) * receivers.vertex_count() as f64;
        (samples / roots.max(f64::MIN_POSITIVE)) as f32
    }

    fn triangle(
        &self,
        mesh: &ReceiverMesh,
        object: u32,
        triangle: u32,
        density: f32,
    ) -> TriangleSamples {
        let corners = mesh.corners(triangle as usize);
        let area = area(corners);
        let source = mesh
            .refined
            .as_ref()
            .map_or(triangle, |r| r.sources[triangle as usize]);
        let mut samples = TriangleSamples {
            area,
            unknowns: mesh.triangles[triangle as usize].map(|v| mesh.unknown[v as usize]),
            ..TriangleSamples::default()
        };
        let live = self.live[object as usize][source as usize];
        let side = if self.lit_from_behind[object as usize] {
            -1.0
        } else {
            1.0
        };
        let normal = face_normal(corners) * side;
        if live == NO_TRIANGLE || normal == Vec3::ZERO {
            return samples;
        }
        // An even number: the half-sets are of one size.
        let count = (2 * (0.5 * density * area.sqrt()).round() as u32).clamp(2, MAX_SAMPLES);
        let seed = hash(triangle, hash(object, self.settings.seed ^ 0x6A7E));
        for i in 0..count {
            let [u, v, ..] = sobol(i, 0, seed);
            let b = triangle_point(u, v);
            let place = Place::new(mesh, triangle as usize, b, normal, side);
            samples.taken += 1;
            match self.sample(&place, live, i, seed) {
                Some((sharp, smooth)) => {
                    samples.halves[(i % 2) as usize].add(area / count as f32, b, sharp, smooth);
                }
                None => samples.invalid += 1,
            }
        }
        samples
    }

    /// Light at a place: with sharp edges and gathered by rays. `None` inside geometry.
    ///
    /// The samples of a triangle share one sequence of directions, each taking a block of its own:
    /// so they are spread evenly together, and the triangle's light is far better known than that
    /// of one sample.
    fn sample(&self, place: &Place, live: u32, index: u32, seed: u32) -> Option<(Vec3, Vec3)> {
        let receiver = Receiver {
            position: place.position,
            normal: place.shading,
            triangle: live,
        };
        let smooth = self.gather_rays(place, &receiver, index, seed)?;
        let sampled = |from: &Emitters, seed| {
            let block = index * from.samples..(index + 1) * from.samples;
            from.sample(self.elements, self.occluders, &receiver, seed, block)
        };
        let mut sharp = sampled(&self.emitters, seed) + sampled(&self.reflectors, hash(seed, 2));
        for (l, light) in self.scene.lights.iter().enumerate() {
            if light.direct == DirectLight::Baked {
                let at = (hash(seed, 3 + l as u32), index);
                sharp += light.power * illumination(light, self.occluders, &receiver, at, &mut 0);
            }
        }
        Some((sharp, smooth))
    }

    fn gather_rays(
        &self,
        place: &Place,
        receiver: &Receiver,
        index: u32,
        seed: u32,
    ) -> Option<Vec3> {
        let rays = self.settings.gather_rays;
        let (mut sum, mut cast, mut inside) = (Vec3::ZERO, 0, 0);
        let around = frame(place.shading);
        for i in index * rays..(index + 1) * rays {
            let [u, v, ..] = sobol(i, 2, seed);
            let direction = around * cosine_hemisphere(u, v);
            // A smooth normal may point rays below the surface: those see nothing real, the
            // others stand in for them.
            if direction.dot(place.geometric) <= 0.0 {
                continue;
            }
            cast += 1;
            let ray_seed = hash(seed, i);
            let Some(hit) =
                self.occluders
                    .closest(place.position, direction, receiver.triangle, ray_seed)
            else {
                sum += self.scene.sky;
                continue;
            };
            let black = self.elements.at(&hit).is_none();
            // A leaf or a veil is a sheet, not the inside of anything.
            inside += u32::from(black && !self.occluders.transmits(hit.triangle));
            sum += self
                .reflectors
                .found_by_ray(self.elements, receiver, direction, &hit);
            sum += self
                .emitters
                .found_by_ray(self.elements, receiver, direction, &hit);
        }
        if cast == 0 || inside as f32 > INSIDE * cast as f32 {
            return None;
        }
        Some(sum / cast as f32)
    }
}

/// A sample's place on the surface.
struct Place {
    /// Lifted off the surface.
    position: Vec3,
    geometric: Vec3,
    /// Interpolated normal that the surface is shaded with.
    shading: Vec3,
}

impl Place {
    fn new(mesh: &ReceiverMesh, triangle: usize, b: Vec3, geometric: Vec3, side: f32) -> Self {
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
