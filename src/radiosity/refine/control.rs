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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Control {
    /// Relative RMSE.
    pub(crate) error: f64,
    pub(crate) rays: u64,
}

/// Points at which light is asked for.
const POINTS: usize = 2048;

/// Points a thread asks at a time.
const CHUNK: usize = 32;

/// Sums over points.
#[derive(Clone, Copy, Default)]
struct Sums {
    square: f64,
    light: f64,
    points: f64,
    rays: u64,
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
        let parts = map_ranges(POINTS, CHUNK, Stage::Error, observer, |range| {
            let mut sums = Sums::default();
            for i in range {
                let ask = Ask {
                    gather,
                    shining,
                    meshes,
                    light,
                };
                ask.point(&triangles, i, &mut sums);
            }
            sums
        })?;
        let all = parts.iter().fold(Sums::default(), |a, b| Sums {
            square: a.square + b.square,
            light: a.light + b.light,
            points: a.points + b.points,
            rays: a.rays + b.rays,
        });
        let mean = all.light / all.points.max(1.0);
        let square = (all.square / all.points.max(1.0)).max(0.0);
        Ok(Self {
            error: if mean > 0.0 {
                square.sqrt() / mean
            } else {
                0.0
            },
            rays: all.rays,
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
}

impl Ask<'_> {
    fn point(&self, triangles: &Triangles, i: usize, sums: &mut Sums) {
        let seed = hash(self.gather.settings.seed, 0xC0_57A0);
        let [pick, u, v, _] = sobol(i as u32, 0, seed);
        let Some((o, t)) = triangles.at((i as f64 + f64::from(pick)) / POINTS as f64) else {
            return;
        };
        let probe = |kind| Probe {
            gather: self.gather,
            shining: self.shining,
            kind,
            seed: hash(i as u32, seed),
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
        sums.square += (a * c).element_sum() / 3.0;
        sums.light += f64::from((gathered[0] + arrived[0]).element_sum()) / 3.0;
        sums.points += 1.0;
    }
}
