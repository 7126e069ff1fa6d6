use glam::{DVec3, Vec3};

use super::face::{FaceLight, Sample};
use super::scouts::{Cluster, clusters};
use super::step::Step;
use super::work::Work;
use crate::radiosity::kind::Kind;
use crate::radiosity::observer::Stage;
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::sampling::{hash, sobol, triangle as triangle_point};
use crate::radiosity::triangle::area;
use crate::radiosity::validate::HALF_EXTENT;

/// Errors below 0 are chance, which adds as much elsewhere: without them meshes would be refined for noise.
/// But noise hides detail as well, so that they count in part. If they all did, meshes of the Cornell box would
/// leave about twice what is asked of them; if none, there would be no end around a lamp below a ceiling.
const BY_CHANCE: f64 = 0.5;

/// Faces a thread judges at a time.
const CHUNK: usize = 16;

/// Points in a face of this area, in squared internal units (a thousandth of the scene's
/// cross-section), and as many as their square root tells in larger ones. Linear light has three unknowns: six points
/// find errors as well as eight, and with four hardly anything is left over to tell of one.
const POINTS: f32 = 6.0;
const AREA_OF_POINTS: f32 = HALF_EXTENT * HALF_EXTENT / 256.0;
const MOST_POINTS: u32 = 48;

impl Work<'_> {
    /// Judges some of the small faces, and where these are good enough, leaves the others alone.
    pub(super) fn scout(&mut self) -> Result<(), Cancelled> {
        let clusters = clusters(&self.conforming);
        self.judge(clusters.iter().flat_map(Cluster::scouts).collect())?;
        for cluster in clusters {
            for scout in cluster.scouts() {
                self.stale.remove(&scout);
            }
            let aim = (self.probe.kind, &self.refiner.level, self.asked);
            if let Some(verdict) = cluster.verdict(&self.faces, aim) {
                for face in cluster.faces {
                    if self.stale.remove(&face) {
                        let area = area(self.conforming.corners(face));
                        self.faces[face as usize] = verdict.of(area);
                    }
                }
            }
        }
        Ok(())
    }

    /// Asks for the light of faces, and judges them.
    pub(super) fn judge(&mut self, faces: Vec<u32>) -> Result<(), Cancelled> {
        let observer = self.refiner.observer;
        let asked = map_ranges(faces.len(), CHUNK, Stage::Refine, observer, |range| {
            let mut rays = 0;
            let judged = faces[range].iter().map(|&f| self.judged(f, &mut rays));
            (judged.collect::<Vec<_>>(), rays)
        })?;
        let judged = asked.into_iter().flat_map(|(judged, rays)| {
            self.rays += rays;
            judged
        });
        for (face, light) in faces.into_iter().zip(judged.collect::<Vec<_>>()) {
            self.faces[face as usize] = light;
        }
        Ok(())
    }

    /// A face with as many points as it needs.
    fn judged(&self, face: u32, rays: &mut u64) -> FaceLight {
        let mut light = self.faces[face as usize].clone();
        let object = self.objects[self.conforming.part(face) as usize];
        let source = self.conforming.source(face) as usize;
        let Some(ground) = self.probe.ground(&self.meshes[object], object, source) else {
            return FaceLight::default();
        };
        let area = area(self.conforming.corners(face));
        let corners = self.conforming.barycentrics(face);
        let seed = hash(face, self.refiner.gather.settings.seed ^ 0xFACE);
        let points = (POINTS * (area / AREA_OF_POINTS).sqrt()).max(POINTS) as u32;
        let missing = points
            .min(MOST_POINTS)
            .saturating_sub(light.samples.len() as u32);
        let new: Vec<Vec3> = (light.asked..light.asked + missing)
            .map(|i| {
                let [u, v, ..] = sobol(i, 0, seed);
                triangle_point(u, v)
            })
            .collect();
        let on_source = |b: &Vec3| corners[0] * b.x + corners[1] * b.y + corners[2] * b.z;
        let places: Vec<Vec3> = new.iter().map(on_source).collect();
        let told = self.probe.light(&ground, &places, rays);
        light.samples.extend(
            (new.into_iter().zip(told)).filter_map(|(b, light)| Some(Sample { b, light: light? })),
        );
        light.asked += missing;
        light.area = f64::from(area);
        light.judge();
        light.step = match self.probe.kind {
            Kind::Sharp if light.misfit > 0.0 => {
                Step::find(&self.probe, &ground, corners, &light.samples, rays)
            }
            _ => None,
        };
        light
    }

    /// Relative RMSE that the mesh leaves, as far as it stands out from noise.
    pub(super) fn error(&self) -> f64 {
        let area: f64 = self.faces.iter().map(|f| f.area).sum();
        let counts = |&error: &f64| {
            if error > 0.0 {
                error
            } else {
                BY_CHANCE * error
            }
        };
        let square = self.errors.iter().map(counts).sum::<f64>() / area.max(f64::MIN_POSITIVE);
        square.max(0.0).sqrt()
    }

    /// Finds the errors of all faces: what is left when the light of each is linear, and when it is one
    /// at the vertices that they share. Without the latter a shadow whose edge runs along edges of the
    /// mesh would be followed by no vertex.
    pub(super) fn weigh(&mut self) {
        let corners = self.corners();
        let shared = self.shared(&corners);
        let level = &self.refiner.level;
        let error = |(face, corners): (&FaceLight, &[usize; 3])| {
            let at = corners.map(|vertex| shared[vertex]);
            let strain = face.strain([0, 1].map(|set| at.map(|sets| sets[set])));
            level.relative(face.misfit + strain, face.mean) * face.area
        };
        self.errors = self.faces.iter().zip(&corners).map(error).collect();
    }

    /// The light of each set at vertices: mean of what fits the faces around them, by area.
    fn shared(&self, corners: &[[usize; 3]]) -> Vec<[DVec3; 2]> {
        let mut sums = vec![([DVec3::ZERO; 2], 0.0); self.conforming.vertex_count()];
        for (face, corners) in self.faces.iter().zip(corners) {
            let Some(fits) = face.fits else { continue };
            for (i, &vertex) in corners.iter().enumerate() {
                let (sum, area) = &mut sums[vertex];
                *sum = [0, 1].map(|set| sum[set] + face.area * fits[set][i]);
                *area += face.area;
            }
        }
        (sums.into_iter())
            .map(|(sum, area)| sum.map(|light| light / f64::max(area, f64::MIN_POSITIVE)))
            .collect()
    }
}
