use glam::Vec3;

use super::probe::{Kind, Probe};
use crate::radiosity::gather::Gather;
use crate::radiosity::gathered::Shining;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::receiver_mesh::ReceiverMeshes;
use crate::radiosity::sampling::{hash, sobol, triangle as triangle_point};
use crate::radiosity::triangle::area;

/// How far off the light of vertices is, found at points that had no part in it.
///
/// Points are spread evenly over the surface. At each the light `E` is asked for twice, `A = E + ε_A`
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
    /// Relative RMSE.
    pub(crate) error: f64,
    /// What it is at most, give or take one standard error.
    pub(crate) bound: f64,
    pub(crate) rays: u64,
}

/// Points asked together, and how often at most.
const BATCH: usize = 1024;
const BATCHES: u32 = 8;

/// Gathering rays of either set at each point.
const RAYS: u32 = 64;

/// The standard error may be this share of the square of what is asked, or of what is found.
const CERTAIN: f64 = 0.25;

/// Points a thread asks at a time.
const CHUNK: usize = 32;

/// Sums over points.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Of (A − x)(B − x), and its square.
    square: f64,
    fourth: f64,
    light: f64,
    points: f64,
    rays: u64,
}

impl Sums {
    fn join(self, other: &Self) -> Self {
        Self {
            square: self.square + other.square,
            fourth: self.fourth + other.fourth,
            light: self.light + other.light,
            points: self.points + other.points,
            rays: self.rays + other.rays,
        }
    }

    /// Mean square error and its standard error, beside the squared mean of the light.
    fn relative(&self) -> (f64, f64) {
        let mean = self.light / self.points.max(1.0);
        if mean <= 0.0 {
            return (0.0, 0.0);
        }
        let square = self.square / self.points;
        let variance = (self.fourth / self.points - square * square).max(0.0);
        let error = (variance / self.points).sqrt();
        (square / (mean * mean), error / (mean * mean))
    }
}

impl Control {
    /// Asks for the light and compares; `light` is that of the unknowns of `meshes`.
    pub(crate) fn run(
        gather: &Gather,
        shining: &Shining,
        meshes: &ReceiverMeshes,
        light: &[Vec3],
        observer: &dyn Observer,
    ) -> Result<Self, Cancelled> {
        let triangles = Triangles::new(meshes);
        let aim = f64::from(gather.settings.error).powi(2);
        let mut sums = Sums::default();
        for batch in 0..BATCHES {
            let ask = Ask {
                gather,
                shining,
                meshes,
                light,
                seed: hash(batch, hash(gather.settings.seed, 0xC0_57A0)),
            };
            let parts = map_ranges(BATCH, CHUNK, Stage::Error, observer, |range| {
                let mut sums = Sums::default();
                for i in range {
                    ask.point(&triangles, i, &mut sums);
                }
                sums
            })?;
            sums = parts.iter().fold(sums, Sums::join);
            let (square, error) = sums.relative();
            if error <= CERTAIN * aim.max(square) {
                break;
            }
        }
        let (square, error) = sums.relative();
        Ok(Self {
            error: square.max(0.0).sqrt(),
            bound: (square.max(0.0) + error).sqrt(),
            rays: sums.rays,
        })
    }
}

/// Triangles of all meshes, to be picked by area.
struct Triangles {
    list: Vec<(u32, u32)>,
    /// Area up to and including each.
    cumulative: Vec<f64>,
}

impl Triangles {
    fn new(meshes: &ReceiverMeshes) -> Self {
        let (mut list, mut cumulative, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for (o, mesh) in meshes.meshes.iter().enumerate() {
            for t in 0..mesh.triangles.len() {
                sum += f64::from(area(mesh.corners(t)));
                list.push((o as u32, t as u32));
                cumulative.push(sum);
            }
        }
        Self { list, cumulative }
    }

    /// The triangle at a share of the whole area.
    fn at(&self, share: f64) -> Option<(usize, usize)> {
        let place = share * self.cumulative.last()?;
        let i = self.cumulative.partition_point(|&c| c <= place);
        let &(o, t) = self.list.get(i)?;
        Some((o as usize, t as usize))
    }
}

struct Ask<'a> {
    gather: &'a Gather<'a>,
    shining: &'a Shining<'a>,
    meshes: &'a ReceiverMeshes,
    light: &'a [Vec3],
    seed: u32,
}

impl Ask<'_> {
    fn point(&self, triangles: &Triangles, i: usize, sums: &mut Sums) {
        let [pick, u, v, _] = sobol(i as u32, 0, self.seed);
        let Some((o, t)) = triangles.at((i as f64 + f64::from(pick)) / BATCH as f64) else {
            return;
        };
        let probe = |kind| Probe {
            gather: self.gather,
            shining: self.shining,
            kind,
            seed: hash(i as u32, self.seed),
            rays: RAYS,
        };
        let (mesh, b) = (&self.meshes.meshes[o], triangle_point(u, v));
        let (smooth, sharp) = (probe(Kind::Smooth), probe(Kind::Sharp));
        let Some(ground) = smooth.ground(mesh, o, t) else {
            return;
        };
        let Some(gathered) = smooth.light(&ground, b, &mut sums.rays) else {
            return;
        };
        let arrived = sharp.light(&ground, b, &mut sums.rays).unwrap_or_default();
        let corners = mesh.triangles[t].map(|v| self.light[mesh.unknown[v as usize] as usize]);
        let given = corners[0] * b.x + corners[1] * b.y + corners[2] * b.z;
        let [a, c] = [0, 1].map(|set| (gathered[set] + arrived[set] - given).as_dvec3());
        let square = (a * c).element_sum() / 3.0;
        sums.square += square;
        sums.fourth += square * square;
        sums.light += f64::from((gathered[0] + arrived[0]).element_sum()) / 3.0;
        sums.points += 1.0;
    }
}
