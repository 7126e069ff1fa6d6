use glam::Vec3;

use super::probe::{Probe, ProbeRays};
use crate::radiosity::fit::Fit;
use crate::radiosity::gather::Gather;
use crate::radiosity::gathered::Shining;
use crate::radiosity::kind::{ByKind, Kind};
use crate::radiosity::level::Level;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::receiver_mesh::ReceiverMeshes;
use crate::radiosity::sampling::{hash, sobol, triangle as triangle_point};
use crate::radiosity::triangle::area;

/// How far off the light of vertices is, found at points that had no part in it.
///
/// Half of the points are spread evenly over the surface, half go where light changes most within a
/// triangle, for errors do not get much larger than that: without these the narrow strips along hard
/// shadows would hardly ever be asked about. At each point the light `E` is asked for twice, `A = E + ε_A`
/// and `B = E + ε_B`, by rays that have nothing to do with each other or with the bake, and held
/// against the light `x` that the vertices give there:
///
/// ```text
///                                  ┌──────────────────────────────────┐
///   mean (A − x)(B − x)  =         │  error² = mean (E − x)²           │
///                                  └──────────────────────────────────┘
/// ```
///
/// because the noise of the two drops out of the mean. What interpolation leaves out and what chance
/// left in the vertices are both in it; what elements and solver leave is in `E` too and is not.
///
/// The mean of `n` points is itself uncertain, by the standard error of its terms; so much is added to
/// it, and points are asked until that is a small part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Control {
    pub(crate) found: Found,
    /// Of either kind of light alone.
    pub(crate) by_kind: ByKind<Found>,
    pub(crate) rays: u64,
}

/// An error, beside the mean of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Found {
    /// Mean square, and its standard error.
    pub(crate) square: f64,
    pub(crate) uncertain: f64,
}

impl Found {
    /// RMSE at most, give or take one standard error.
    pub(crate) fn bound(&self) -> f64 {
        (self.square.max(0.0) + self.uncertain).sqrt()
    }

    /// RMSE at least, give or take one standard error.
    fn sure(&self) -> f64 {
        (self.square - self.uncertain).max(0.0).sqrt()
    }
}

/// Points asked together, and how often at most.
const BATCH: usize = 1024;
const BATCHES: u32 = 8;

/// Gathering rays of either set at each point, beside the error asked for; so many at least and most.
/// The noise of a point goes down faster with its rays than that of the mean with the number of points.
const RAYS: f32 = 2.5;
const RAYS_LIMITS: (u32, u32) = (64, 512);

/// The standard error may be this share of the square of what is aimed at, or of what is found.
const CERTAIN: f64 = 0.15;

/// Points a thread asks at a time.
const CHUNK: usize = 32;

/// What was found at one point: (A − x)(B − x) of all its light and of either kind, and that light.
#[derive(Clone, Copy)]
struct Point {
    /// Surface that it stands for, beside that of other points.
    weight: f64,
    whole: f64,
    by_kind: ByKind<f64>,
    light: f64,
}

/// Errors at points.
#[derive(Default)]
struct Points {
    list: Vec<Point>,
    level: Level,
}

impl Points {
    fn add(&mut self, points: impl Iterator<Item = Point>) {
        self.list.extend(points);
        self.level = Level::of(self.list.iter().map(|p| (p.weight, p.light)));
    }

    fn found(&self, square: impl Fn(&Point) -> f64) -> Found {
        let count = self.list.len().max(1) as f64;
        let (mut first, mut second) = (0.0, 0.0);
        for point in &self.list {
            let square = point.weight * self.level.relative(square(point), point.light);
            first += square / count;
            second += square * square / count;
        }
        Found {
            square: first,
            uncertain: ((second - first * first).max(0.0) / count).sqrt(),
        }
    }
}

impl Control {
    /// Asks for the light and compares it with that of the unknowns of `meshes`, until that tells whether
    /// they are within `aim` (relative RMSE): another pass takes far longer than more points.
    pub(crate) fn run(
        gather: &Gather,
        shining: &Shining,
        meshes: &ReceiverMeshes,
        fitted: &Fit,
        aim: f64,
        observer: &dyn Observer,
    ) -> Result<Self, Cancelled> {
        let triangles = Triangles::new(meshes, &fitted.light);
        let (mut points, mut rays) = (Points::default(), 0);
        for batch in 0..BATCHES {
            let ask = Ask {
                gather,
                shining,
                meshes,
                fitted,
                seed: hash(batch, hash(gather.settings.seed, 0xC0_57A0)),
            };
            let parts = map_ranges(BATCH, CHUNK, Stage::Error, observer, |range| {
                let mut rays = 0;
                let points = range.filter_map(|i| ask.point(&triangles, i, &mut rays));
                (points.collect::<Vec<_>>(), rays)
            })?;
            rays += parts.iter().map(|part| part.1).sum::<u64>();
            points.add(parts.into_iter().flat_map(|part| part.0));
            let found = points.found(|p| p.whole);
            let certain = found.uncertain <= CERTAIN * found.square.max(aim * aim);
            let decided = found.bound() <= aim || found.sure() > aim;
            if certain && decided {
                break;
            }
        }
        Ok(Self {
            found: points.found(|p| p.whole),
            by_kind: ByKind {
                smooth: points.found(|p| p.by_kind.smooth),
                sharp: points.found(|p| p.by_kind.sharp),
            },
            rays,
        })
    }
}

/// Triangles of all meshes, to be picked by area and by how much light changes in them.
struct Triangles {
    list: Vec<Triangle>,
    /// Chance of being picked, of all up to and including each.
    cumulative: Vec<f64>,
}

#[derive(Clone, Copy)]
struct Triangle {
    object: u32,
    triangle: u32,
    /// Its share of the surface, beside its chance of being picked.
    weight: f64,
}

impl Triangles {
    fn new(meshes: &ReceiverMeshes, light: &[Vec3]) -> Self {
        let mut triangles = Vec::new();
        for (object, mesh) in (0..).zip(&meshes.meshes) {
            for (t, corners) in (0..).zip(&mesh.triangles) {
                let area = f64::from(area(mesh.corners(t as usize)));
                let [a, b, c] = corners.map(|v| light[mesh.unknown[v as usize] as usize]);
                let change = (a - b).length_squared().max((b - c).length_squared());
                let change = f64::from(change.max((c - a).length_squared()));
                triangles.push((object, t, area, area * change));
            }
        }
        let all: f64 = triangles.iter().map(|t| t.2).sum();
        let change: f64 = triangles.iter().map(|t| t.3).sum();
        let (mut list, mut cumulative, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for (object, triangle, area, changing) in triangles {
            let even = area / all.max(f64::MIN_POSITIVE);
            let chance = match change > 0.0 {
                true => 0.5 * (even + changing / change),
                false => even,
            };
            sum += chance;
            cumulative.push(sum);
            let weight = even / chance.max(f64::MIN_POSITIVE);
            list.push(Triangle {
                object,
                triangle,
                weight,
            });
        }
        Self { list, cumulative }
    }

    /// The triangle at a share of all chances.
    fn at(&self, share: f64) -> Option<Triangle> {
        let place = share * self.cumulative.last()?;
        let i = self.cumulative.partition_point(|&c| c <= place);
        self.list.get(i).copied()
    }
}

struct Ask<'a> {
    gather: &'a Gather<'a>,
    shining: &'a Shining<'a>,
    meshes: &'a ReceiverMeshes,
    fitted: &'a Fit,
    seed: u32,
}

impl Ask<'_> {
    /// The error at point `i` of a batch; `None` where there is nothing to light.
    fn point(&self, triangles: &Triangles, i: usize, rays: &mut u64) -> Option<Point> {
        let [pick, u, v, _] = sobol(i as u32, 0, self.seed);
        let picked = triangles.at((i as f64 + f64::from(pick)) / BATCH as f64)?;
        let (o, t) = (picked.object as usize, picked.triangle as usize);
        let rays_by_error = (RAYS / self.gather.settings.error) as u32;
        let gathering = rays_by_error.clamp(RAYS_LIMITS.0, RAYS_LIMITS.1);
        let rays_of_set = ProbeRays {
            gathering,
            shadow: gathering / 4,
        };
        let seed = hash(i as u32, self.seed);
        let probe = |kind| Probe::new(self.gather, self.shining, kind, seed, rays_of_set);
        let (mesh, b) = (&self.meshes.meshes[o], triangle_point(u, v));
        let (smooth, sharp) = (probe(Kind::Smooth), probe(Kind::Sharp));
        let ground = smooth.ground(mesh, o, t)?;
        let gathered = smooth.light(&ground, &[b], rays)[0]?;
        let arrived = sharp.light(&ground, &[b], rays)[0].unwrap_or_default();
        let given = |light: &[Vec3]| {
            let corners = mesh.triangles[t].map(|v| light[mesh.unknown[v as usize] as usize]);
            corners[0] * b.x + corners[1] * b.y + corners[2] * b.z
        };
        let wrong = |told: [Vec3; 2], given: Vec3| {
            let [a, c] = told.map(|light| (light - given).as_dvec3());
            (a * c).element_sum() / 3.0
        };
        let whole = given(&self.fitted.light);
        let smooth = given(&self.fitted.gathered);
        let both = [0, 1].map(|set| gathered[set] + arrived[set]);
        Some(Point {
            weight: picked.weight,
            whole: wrong(both, whole),
            by_kind: ByKind {
                smooth: wrong(gathered, smooth),
                sharp: wrong(arrived, whole - smooth),
            },
            light: f64::from((both[0] + both[1]).element_sum()) / 6.0,
        })
    }
}
