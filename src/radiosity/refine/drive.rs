use std::collections::BTreeSet;
use std::mem;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3};

use super::face::{FaceLight, Sample};
use super::probe::{LEAST_SHADOW_RAYS, Probe, ProbeRays};
use super::scouts::{Cluster, clusters};
use super::step::Step;
use crate::mesh::{Bisected, Bisection, Conforming, Limits, Origin, Part, Refined};
use crate::radiosity::gather::Gather;
use crate::radiosity::gathered::Shining;
use crate::radiosity::kind::{ByKind, Kind};
use crate::radiosity::level::Level;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::OFFSET;
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::receiver_mesh::{ReceiverMesh, ReceiverMeshes};
use crate::radiosity::sampling::{hash, sobol, triangle as triangle_point};
use crate::radiosity::triangle::area;
use crate::radiosity::validate::{HALF_EXTENT, ValidScene};

/// How the meshes of a scene are refined, by object; `None` where they are not.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refinement {
    /// Of the meshes given.
    pub(crate) coarse: Vec<Option<Arc<Refined>>>,
    /// Of the coarse meshes.
    pub(crate) fine: Vec<Option<Arc<Refined>>>,
    /// Relative RMSE that the meshes leave.
    pub(crate) error: ByKind<f64>,
    /// Vertices that there might have been, if there are as many.
    pub(crate) full: Option<usize>,
    /// Rays that it took.
    pub(crate) rays: u64,
}

impl Refinement {
    /// Whether the coarse meshes are the very same.
    pub(crate) fn same_coarse(&self, other: &Self) -> bool {
        let same = |(a, b): (&Option<Arc<Refined>>, &Option<Arc<Refined>>)| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.coarse.len() == other.coarse.len() && self.coarse.iter().zip(&other.coarse).all(same)
    }

    /// What of it fits the meshes of another scene, `before` telling which object was which: an object
    /// that only moved keeps its own.
    pub(crate) fn kept(
        &self,
        old: &ReceiverMeshes,
        new: &ReceiverMeshes,
        before: &[Option<usize>],
    ) -> Self {
        let fits = |o: usize, p: usize| {
            let (new, old) = (&new.meshes[o], &old.meshes[p]);
            new.triangles == old.triangles && new.positions.len() == old.positions.len()
        };
        let kept = |by: &[Option<Arc<Refined>>]| -> Vec<Option<Arc<Refined>>> {
            (before.iter().enumerate())
                .map(|(o, p)| by[(*p).filter(|&p| fits(o, p))?].clone())
                .collect()
        };
        Self {
            coarse: kept(&self.coarse),
            fine: kept(&self.fine),
            rays: 0,
            ..*self
        }
    }
}

/// Refines the meshes of a scene for one kind of light.
pub(crate) struct Refiner<'a> {
    pub(crate) gather: &'a Gather<'a>,
    pub(crate) shining: &'a Shining<'a>,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) level: Level,
    /// Edges longer than this are cut whatever the light, in internal units.
    pub(crate) max_edge: f32,
    /// When to be done at the latest.
    pub(crate) until: Option<Instant>,
}

/// What is asked of a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Relative RMSE that the meshes may leave.
    pub(crate) error: ByKind<f64>,
    pub(crate) max_vertices: usize,
}

/// What came of it.
struct Outcome {
    by: Vec<Option<Arc<Refined>>>,
    /// Relative RMSE that the mesh leaves.
    error: f64,
    /// There were as many vertices as there may be, and that was too few.
    full: bool,
}

impl Outcome {
    /// What an earlier refinement made for smooth light.
    fn kept(earlier: &Refinement) -> Self {
        Self {
            by: earlier.coarse.clone(),
            error: earlier.error.smooth,
            full: false,
        }
    }
}

/// Share of the vertices that the coarse meshes may have at first.
const COARSE: f64 = 0.4;

/// Room for vertices is filled if it is one of so many.
const WORTH_FILLING: usize = 25;

/// Halves of edges are no shorter than this, in internal units: the scene is 2048 across.
const MIN_EDGE: f32 = HALF_EXTENT / 16384.0;

/// Each round cuts faces that have this share of the error together.
const BULK: f64 = 0.6;

/// Errors below 0 are chance, which adds as much elsewhere: without them meshes would be refined for noise.
/// But noise hides detail as well, so that they count in part. If they all did, meshes of the Cornell box would
/// leave about twice what is asked of them; if none, there would be no end around a lamp below a ceiling.
const BY_CHANCE: f64 = 0.5;

/// Rounds at most. A round halves faces, so this many cut any face down to nothing.
const ROUNDS: usize = 60;

/// Rays of either set at a point, gathering ones and those to each light with a penumbra, beside the error
/// that meshes may leave: what noise hides cannot be found, and meshes that look for it follow the noise.
/// So many gathering ones at least: with fewer, a hot spot that one of them meets looks like detail.
const RAYS: f64 = 0.25;
const LEAST_RAYS: u32 = 40;
const MOST_RAYS: u32 = 512;

/// A vertex is at the end of a step if it is nearer than this share of the step's width.
const AT_VERTEX: f32 = 0.5;

/// Faces a thread judges at a time.
const CHUNK: usize = 16;

/// Points in a face of this area, in squared internal units (a thousandth of the scene's
/// cross-section), and as many as their square root tells in larger ones.
const POINTS: f32 = 8.0;
const AREA_OF_POINTS: f32 = HALF_EXTENT * HALF_EXTENT / 256.0;
const MOST_POINTS: u32 = 48;

/// Meshes while they are refined.
struct Work<'a> {
    refiner: &'a Refiner<'a>,
    meshes: &'a [ReceiverMesh],
    probe: Probe<'a>,
    /// Relative RMSE that they may leave.
    asked: f64,
    /// The object of each part.
    objects: Vec<usize>,
    conforming: Conforming,
    faces: Vec<FaceLight>,
    /// Faces that are to be judged.
    stale: BTreeSet<u32>,
    /// Vertices of meshes that are not refined.
    others: usize,
    /// Of each face: its part of the mean square error times the whole area, relative to the level; below 0
    /// by chance.
    errors: Vec<f64>,
    rays: u64,
}

impl Refiner<'_> {
    /// Refines the meshes of a scene: for smooth light, then inside those for light with sharp edges.
    /// What an earlier refinement made of them for smooth light is kept if it is good enough.
    pub(crate) fn refine(
        &self,
        scene: &ValidScene,
        given: &ReceiverMeshes,
        asked: &Asked,
        earlier: Option<&Refinement>,
    ) -> Result<Refinement, Cancelled> {
        let mut coarse_at_most = (COARSE * asked.max_vertices as f64) as usize;
        let earlier = earlier.filter(|e| e.error.smooth <= asked.error.smooth);
        let mut rays = 0;
        let (mut work, mut smooth) = match earlier {
            Some(earlier) => (None, Outcome::kept(earlier)),
            None => {
                let mut work = Work::new(self, given, Kind::Smooth, asked.error.smooth);
                let smooth = work.run(coarse_at_most, self.half_way())?;
                (Some(work), smooth)
            }
        };
        let sharp = loop {
            let coarse = given.refined(scene, &smooth.by);
            let mut finer = Work::new(self, &coarse, Kind::Sharp, asked.error.sharp);
            let sharp = finer.run(asked.max_vertices, self.until)?;
            rays += finer.rays;
            let used = coarse.refined(scene, &sharp.by).vertex_count();
            let room = asked.max_vertices.saturating_sub(used);
            let worth = room * WORTH_FILLING >= asked.max_vertices && !is_over(self.until);
            let Some(work) = work
                .as_mut()
                .filter(|_| smooth.full && !sharp.full && worth)
            else {
                break sharp;
            };
            // Shadows leave room that was kept for them.
            coarse_at_most += room;
            smooth = work.run(coarse_at_most, self.half_way())?;
        };
        Ok(Refinement {
            error: ByKind {
                smooth: smooth.error,
                sharp: sharp.error,
            },
            full: (smooth.full || sharp.full).then_some(asked.max_vertices),
            coarse: smooth.by,
            fine: sharp.by,
            rays: rays + work.map_or(0, |work| work.rays),
        })
    }

    /// When half of the time is over.
    fn half_way(&self) -> Option<Instant> {
        let now = Instant::now();
        self.until
            .map(|until| now + until.saturating_duration_since(now) / 2)
    }
}

fn is_over(until: Option<Instant>) -> bool {
    until.is_some_and(|until| Instant::now() > until)
}

/// Hands the samples of faces that are cut on to their pieces, and tells which are others now.
fn hand_on(faces: &mut Vec<FaceLight>, changed: &mut BTreeSet<u32>) -> impl FnMut(Bisection) {
    |cut| {
        let half = faces[cut.face as usize].split(&cut);
        faces.push(half);
        changed.extend([cut.face, cut.half]);
    }
}

impl<'a> Work<'a> {
    /// Of meshes that may leave an error `asked`, relative RMSE.
    fn new(refiner: &'a Refiner, meshes: &'a ReceiverMeshes, kind: Kind, asked: f64) -> Self {
        let (scene, vertices) = (refiner.gather.scene, meshes.vertex_count());
        let meshes = &*meshes.meshes;
        let refines = |&o: &usize| scene.objects[o].refine && !meshes[o].triangles.is_empty();
        let objects: Vec<usize> = (0..meshes.len()).filter(refines).collect();
        let parts: Vec<Part> = (objects.iter())
            .map(|&o| Part {
                positions: &meshes[o].positions,
                triangles: &meshes[o].triangles,
                refine: true,
            })
            .collect();
        let conforming = Conforming::new(&parts, OFFSET);
        Self {
            faces: vec![FaceLight::default(); conforming.faces() as usize],
            stale: (0..conforming.faces()).collect(),
            others: vertices - conforming.vertex_count(),
            asked,
            probe: Probe::new(
                refiner.gather,
                refiner.shining,
                kind,
                refiner.gather.settings.seed,
                ProbeRays {
                    gathering: ((RAYS / asked) as u32).clamp(LEAST_RAYS, MOST_RAYS),
                    shadow: ((RAYS / asked) as u32).clamp(LEAST_SHADOW_RAYS, MOST_RAYS),
                },
            ),
            refiner,
            meshes,
            objects,
            conforming,
            errors: Vec::new(),
            rays: 0,
        }
    }

    /// Refines the meshes further, until they leave no more than was asked, all of them together have too
    /// many vertices, or it is late.
    fn run(&mut self, max_vertices: usize, until: Option<Instant>) -> Result<Outcome, Cancelled> {
        let limits = Limits {
            max_vertices: max_vertices.saturating_sub(self.others),
            max_faces: usize::MAX,
            min_edge: MIN_EDGE,
        };
        let mut full = !self.cut_long_edges(&limits);
        // Nothing was judged before.
        if self.errors.is_empty() {
            self.scout()?;
        }
        let mut error = 0.0;
        for _ in 0..ROUNDS {
            let stale = mem::take(&mut self.stale).into_iter().collect();
            self.judge(stale)?;
            self.weigh();
            error = self.error();
            let good = error <= self.asked;
            full &= !good;
            if full || good || is_over(until) {
                break;
            }
            full = !self.cut_worst(&limits);
            if self.stale.is_empty() {
                break;
            }
        }
        Ok(Outcome {
            error,
            full,
            by: self.refined(),
        })
    }

    /// Bisects a face and hands its samples on.
    fn bisect(&mut self, face: u32, limits: &Limits) -> Bisected {
        let told = &mut hand_on(&mut self.faces, &mut self.stale);
        self.conforming.bisect(face, limits, told)
    }

    /// Cuts a face along a step of light: at either end of it, the one far from the lone corner first, so
    /// that no new edge crosses the step.
    ///
    /// ```text
    ///         /\                 /\                 /\
    ///        /  \               /  \               /__\    two rows of vertices,
    ///    ---/----\--- step     /    \             /_/__\   the step between them
    ///      /      \           /______\           /______\
    ///     /        \         /   __.-'\         /   __.-'\
    ///    /__________\       /_.-'______\       /_.-'______\
    /// ```
    ///
    /// An end that a vertex is at already is not cut.
    fn follow(&mut self, mut face: u32, step: Step, limits: &Limits) -> Bisected {
        let mut outcome = Bisected::Refused;
        // What is left of the two edges, beside all of them.
        let mut left = [1.0_f32; 2];
        for (end, edge) in [(1, 0), (1, 1), (0, 0), (0, 1)] {
            let [low, high] = step.ends[edge];
            let at = step.ends[edge][end];
            if at.min(left[edge] - at) < AT_VERTEX * (high - low) {
                continue;
            }
            let share = at / left[edge];
            let lone = step.lone;
            let mut cut_off = face;
            let told = &mut hand_on(&mut self.faces, &mut self.stale);
            let told = &mut |cut: Bisection| {
                told(cut);
                // An edge that ends at the lone corner leaves it to the other piece.
                if cut.face == face && edge == 1 {
                    cut_off = cut.half;
                }
            };
            let cut = match edge {
                0 => (self.conforming).cut_edge((face, lone), share, limits, told),
                _ => (self.conforming).cut_edge((face, (lone + 2) % 3), 1.0 - share, limits, told),
            };
            match cut {
                Bisected::Done => (outcome, left[edge], face) = (Bisected::Done, at, cut_off),
                Bisected::Refused => {}
                Bisected::Full => return Bisected::Full,
            }
        }
        outcome
    }

    /// Cuts what is longer than the longest edge allowed. Whether there was room.
    fn cut_long_edges(&mut self, limits: &Limits) -> bool {
        let mut face = 0;
        while face < self.conforming.faces() {
            let [a, b, c] = self.conforming.corners(face);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if longest > self.refiner.max_edge {
                match self.bisect(face, limits) {
                    Bisected::Done => continue,
                    Bisected::Full => return false,
                    Bisected::Refused => {}
                }
            }
            face += 1;
        }
        true
    }

    /// Cuts the worst faces. Whether there was room.
    fn cut_worst(&mut self, limits: &Limits) -> bool {
        let mut worst: Vec<(u32, f64)> = (0..)
            .zip(self.errors.iter().copied())
            .filter(|(_, error)| *error > 0.0)
            .collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let all: f64 = worst.iter().map(|(_, error)| error).sum();
        let mut cut = 0.0;
        for (face, error) in worst {
            if cut >= BULK * all {
                break;
            }
            if self.stale.contains(&face) {
                cut += error;
                continue;
            }
            let followed = match self.faces[face as usize].step {
                Some(step) => self.follow(face, step, limits),
                None => Bisected::Refused,
            };
            let bisected = match followed {
                Bisected::Refused => self.bisect(face, limits),
                done => done,
            };
            match bisected {
                Bisected::Done => cut += error,
                Bisected::Refused => {}
                Bisected::Full => return false,
            }
        }
        true
    }

    /// Judges some of the small faces, and where these are good enough, leaves the others alone.
    fn scout(&mut self) -> Result<(), Cancelled> {
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
    fn judge(&mut self, faces: Vec<u32>) -> Result<(), Cancelled> {
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
    fn error(&self) -> f64 {
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
    fn weigh(&mut self) {
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

    /// The corners of all faces as vertices of all parts, one part's after the other's.
    fn corners(&self) -> Vec<[usize; 3]> {
        let first = self.conforming.first_vertices();
        let corners = |f: u32| {
            let first = first[self.conforming.part(f) as usize];
            (self.conforming.vertices(f)).map(|vertex| first + vertex as usize)
        };
        (0..self.conforming.faces()).map(corners).collect()
    }

    /// The meshes as they are now.
    fn refined(&self) -> Vec<Option<Arc<Refined>>> {
        let mut by = vec![None; self.meshes.len()];
        for (&object, refined) in self
            .objects
            .iter()
            .zip(self.conforming.clone().into_parts())
        {
            let is_new = |o: &Origin| matches!(o, Origin::Between(_));
            if refined.origins.iter().any(is_new) {
                by[object] = Some(Arc::new(refined));
            }
        }
        by
    }
}
