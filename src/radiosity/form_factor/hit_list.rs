use glam::{DVec3, Vec3, Vec3A};

use crate::radiosity::element::{ElementId, Elements, element_seed};
use crate::radiosity::emitter::{Emitters, Receiver};
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::sampling::{cosine_hemisphere, frame, hash, sobol};
use crate::radiosity::validate::ValidScene;

/// A ray that met the sky or a black back face.
const NO_ELEMENT: u32 = u32::MAX;

/// The form-factor matrix as a list of ray hits.
///
/// ```text
///   F_ij = 1/A_i ∫_Ai ∫_Ω V_ij cos θ / π dω dA ≈ 1/S #{ s : ray s of i hits j }
///   ┌───────────────────────────────────────────────────────────┐
///   │  rays with density cos θ / π: every weight is the same 1/S │
///   └───────────────────────────────────────────────────────────┘
/// ```
///
/// A row is `S` element ids. It sums to 1 − misses/S, never above 1, so that Gauss–Seidel
/// converges for any reflectance below 1.
pub(crate) struct HitList {
    rays: usize,
    ids: Vec<u32>,
    /// Rays of each row that hit an element.
    hits: Vec<u32>,
}

impl HitList {
    /// `Σ_j F_ij x_j` for element `e`.
    pub(crate) fn gather(&self, e: usize, values: &[Vec3A]) -> DVec3 {
        // A miss is beyond the end: one comparison for both.
        let value = |id: u32| values.get(id as usize).copied().unwrap_or(Vec3A::ZERO);
        let mut sum = DVec3::ZERO;
        // Short sums in f32 lose nothing that matters; the long one is in f64. Four at a time,
        // because one addition takes as long as four that do not wait for each other.
        let (blocks, rest) = self.row(e).as_chunks::<16>();
        for block in blocks {
            let mut partial = [Vec3A::ZERO; 4];
            for four in block.as_chunks::<4>().0 {
                for (lane, &id) in partial.iter_mut().zip(four) {
                    *lane += value(id);
                }
            }
            sum += ((partial[0] + partial[1]) + (partial[2] + partial[3])).as_dvec3();
        }
        for &id in rest {
            sum += value(id).as_dvec3();
        }
        sum / self.rays as f64
    }

    /// `Σ_j F_ij` for element `e`: 1 where no ray escapes.
    pub(crate) fn row_sum(&self, e: usize) -> f64 {
        f64::from(self.hits[e]) / self.rays as f64
    }

    fn row(&self, e: usize) -> &[u32] {
        &self.ids[e * self.rays..(e + 1) * self.rays]
    }

    pub(crate) fn bytes(&self) -> u64 {
        4 * (self.ids.len() + self.hits.len()) as u64
    }

    fn new(rays: usize, ids: Vec<u32>) -> Self {
        let count = |row: &[u32]| row.iter().filter(|&&id| id != NO_ELEMENT).count() as u32;
        Self {
            rays,
            hits: ids.chunks(rays).map(count).collect(),
            ids,
        }
    }

    /// A matrix given row by row, each of the same number of entries; `None` is a miss.
    #[cfg(test)]
    pub(crate) fn from_rows(rows: &[Vec<Option<u32>>]) -> Self {
        let ids = rows.iter().flatten().map(|id| id.unwrap_or(NO_ELEMENT));
        Self::new(rows[0].len(), ids.collect())
    }
}

/// What the rays of all elements found.
pub(crate) struct Traced {
    pub(crate) rows: HitList,
    /// Light of sky and emitters that rays came upon, with the weight that belongs to rays.
    pub(crate) found: Vec<Vec3>,
}

/// Elements a thread takes at a time: a few milliseconds' work.
const CHUNK: usize = 64;

/// Traces `rays` cosine-distributed rays from points spread over each element.
pub(crate) fn trace(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    rays: u32,
    seed: u32,
    observer: &dyn Observer,
) -> Result<Traced, Cancelled> {
    let chunks = map_ranges(
        elements.len(),
        CHUNK,
        Stage::FormFactors,
        observer,
        |range| {
            let mut ids = Vec::with_capacity(range.len() * rays as usize);
            let found: Vec<Vec3> = range
                .map(|e| {
                    let element = ElementId(e as u32);
                    let mut found = Vec3::ZERO;
                    for i in 0..rays {
                        let (id, light) =
                            trace_one(scene, occluders, elements, emitters, element, i, seed);
                        ids.push(id);
                        found += light;
                    }
                    found / rays as f32
                })
                .collect();
            (ids, found)
        },
    )?;
    let mut all = Vec::with_capacity(elements.len() * rays as usize);
    let mut found = Vec::with_capacity(elements.len());
    for (ids, light) in chunks {
        all.extend(ids);
        found.extend(light);
    }
    Ok(Traced {
        rows: HitList::new(rays as usize, all),
        found,
    })
}

fn trace_one(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    element: ElementId,
    i: u32,
    seed: u32,
) -> (u32, Vec3) {
    let seed = element_seed(element, seed);
    let [u, v, s, t] = sobol(i, 0, seed);
    let point = elements.point(scene, element, u, v);
    let direction = frame(point.normal) * cosine_hemisphere(s, t);
    let origin = point.position + point.normal * OFFSET;
    let Some(hit) = occluders.closest(origin, direction, point.triangle, hash(seed, i)) else {
        return (NO_ELEMENT, scene.sky);
    };
    let receiver = Receiver {
        position: origin,
        normal: point.normal,
        triangle: point.triangle,
    };
    let light = emitters.found_by_ray(elements, &receiver, direction, &hit);
    (elements.at(&hit).map_or(NO_ELEMENT, |e| e.0), light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_average_what_they_hit() {
        let rows = HitList::from_rows(&[vec![Some(1), Some(1), Some(0), None]]);
        let values = [Vec3A::splat(4.0), Vec3A::new(8.0, 0.0, 2.0)];
        assert_eq!(rows.gather(0, &values), DVec3::new(5.0, 1.0, 2.0));
        assert_eq!(rows.row_sum(0), 0.75);
    }
}
