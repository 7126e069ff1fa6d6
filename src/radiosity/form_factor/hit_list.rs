use glam::{DVec3, Vec3, Vec3A};

use crate::radiosity::bounds::Reach;
use crate::radiosity::change::Change;
use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::emitter::{Emitters, Receiver};
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::sampling::{cosine_hemisphere, frame, hash, sobol};
use crate::radiosity::validate::ValidScene;

/// In place of an element: the ray met the sky.
pub(crate) const SKY: u32 = u32::MAX;

/// In place of an element: the ray met the black back of a surface.
pub(crate) const BLACK: u32 = u32::MAX - 1;

/// In place of an element that is no more.
pub(crate) const GONE: u32 = u32::MAX - 2;

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
        let count = |row: &[u32]| row.iter().filter(|&&id| id < GONE).count() as u32;
        Self {
            rays,
            hits: ids.chunks(rays).map(count).collect(),
            ids,
        }
    }

    /// A matrix given row by row, each of the same number of entries; `None` is a miss.
    #[cfg(test)]
    pub(crate) fn from_rows(rows: &[Vec<Option<u32>>]) -> Self {
        let ids = rows.iter().flatten().map(|id| id.unwrap_or(SKY));
        Self::new(rows[0].len(), ids.collect())
    }
}

/// What the rays of all elements found.
pub(crate) struct Traced {
    pub(crate) rows: HitList,
    /// Rays of each element that met the sky.
    sky: Vec<u32>,
    /// Rays that met sampled emitters: those of element `e` from `first_met[e]` on.
    met: Vec<Met>,
    first_met: Vec<u32>,
    /// How far each ray went; empty if nobody will ask.
    reaches: Vec<Reach>,
}

/// A ray of an element that met a sampled emitter.
#[derive(Clone, Copy)]
struct Met {
    /// Which ray of the element.
    ray: u32,
    element: u32,
    /// How much of the emitter's light counts.
    weight: f32,
}

/// What an earlier bake's rays found, of which much is still true.
pub(crate) struct RowsBefore<'a> {
    pub(crate) traced: &'a Traced,
    pub(crate) change: &'a Change,
    /// The emitters to sample are others than then.
    pub(crate) new_emitters: bool,
}

/// What [`trace`] looks at.
pub(crate) struct RowTracer<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) occluders: Occluders<'a>,
    pub(crate) elements: &'a Elements,
    pub(crate) emitters: Emitters<'a>,
    /// Elements whose light is sampled.
    pub(crate) marks: &'a [bool],
    pub(crate) rays: u32,
    pub(crate) seed: u32,
    /// Whether to note how far rays went.
    pub(crate) remember: bool,
}

/// Elements a thread takes at a time: a few milliseconds' work.
const CHUNK: usize = 64;

/// The rays of some elements, one element after the other.
#[derive(Default)]
struct Rows {
    ids: Vec<u32>,
    reaches: Vec<Reach>,
    sky: Vec<u32>,
    met: Vec<Met>,
    /// How many of `met` each element has.
    met_count: Vec<u32>,
    traced: u64,
}

/// Traces cosine-distributed rays from points spread over each element, those that `before` does
/// not answer. Returns how many that were.
pub(crate) fn trace(
    tracer: &RowTracer,
    before: Option<&RowsBefore>,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    let count = tracer.elements.len();
    let chunks = map_ranges(count, CHUNK, Stage::FormFactors, observer, |range| {
        let mut rows = Rows::default();
        rows.ids.reserve_exact(range.len() * tracer.rays as usize);
        for e in range {
            let met = rows.met.len();
            let kept = before.and_then(|b| Some((b, b.change.element_before[e]?)));
            let misses = match kept {
                Some((before, old)) => tracer.row_again(e, before, old as usize, &mut rows),
                None => (0..tracer.rays).map(|i| tracer.ray(e, i, &mut rows)).sum(),
            };
            rows.sky.push(misses);
            rows.met_count.push((rows.met.len() - met) as u32);
        }
        rows
    })?;
    let rays = count * tracer.rays as usize;
    let mut ids = Vec::with_capacity(rays);
    let mut traced = Traced {
        rows: HitList::new(1, Vec::new()),
        sky: Vec::with_capacity(count),
        met: Vec::new(),
        first_met: vec![0],
        reaches: Vec::with_capacity(if tracer.remember { rays } else { 0 }),
    };
    let (mut cost, mut end) = (0, 0);
    for rows in chunks {
        ids.extend(rows.ids);
        traced.reaches.extend(rows.reaches);
        traced.sky.extend(rows.sky);
        traced.met.extend(rows.met);
        for count in rows.met_count {
            end += count;
            traced.first_met.push(end);
        }
        cost += rows.traced;
    }
    traced.rows = HitList::new(tracer.rays as usize, ids);
    Ok((traced, cost))
}

impl RowTracer<'_> {
    /// Takes over a row, tracing again what may have changed. Returns how many rays met the sky.
    fn row_again(&self, e: usize, before: &RowsBefore, old: usize, rows: &mut Rows) -> u32 {
        let sphere = self.elements.sphere(self.scene, ElementId(e as u32));
        let disturbed = before.change.disturbed.from(sphere);
        let traced = before.traced;
        let mut met = traced.met_of(old).iter().peekable();
        let first = old * self.rays as usize;
        let mut sky = 0;
        for i in 0..self.rays {
            let known = met.next_if(|m| m.ray == i);
            let reach = traced.reaches[first + i as usize];
            let id = before.change.translate(traced.rows.ids[first + i as usize]);
            let other = before.new_emitters
                && (known.is_some() || self.marks.get(id as usize).is_some_and(|&m| m));
            if id == GONE || other || disturbed.ray(reach) {
                sky += self.ray(e, i, rows);
                continue;
            }
            sky += u32::from(id == SKY);
            rows.ids.push(id);
            rows.reaches.push(reach);
            rows.met.extend(known.map(|m| Met { element: id, ..*m }));
        }
        sky
    }

    /// Traces a ray. Returns 1 if it met the sky.
    fn ray(&self, e: usize, i: u32, rows: &mut Rows) -> u32 {
        let seed = self.elements.seed(ElementId(e as u32), self.seed);
        let [u, v, s, t] = sobol(i, 0, seed);
        let point = self.elements.point(self.scene, ElementId(e as u32), u, v);
        let direction = frame(point.normal) * cosine_hemisphere(s, t);
        let origin = point.position + point.normal * OFFSET;
        let hit = self
            .occluders
            .closest(origin, direction, point.triangle, hash(seed, i));
        rows.traced += 1;
        if self.remember {
            let distance = hit.map_or(f32::INFINITY, |h| h.distance);
            rows.reaches.push(Reach::new(direction, distance));
        }
        let Some(hit) = hit else {
            rows.ids.push(SKY);
            return 1;
        };
        let element = self.elements.at(&hit);
        rows.ids.push(element.map_or(BLACK, |e| e.0));
        if let Some(element) = element.filter(|e| self.marks[e.0 as usize]) {
            let receiver = Receiver {
                position: origin,
                normal: point.normal,
                triangle: point.triangle,
            };
            rows.met.push(Met {
                ray: i,
                element: element.0,
                weight: self
                    .emitters
                    .ray_weight(element, &receiver, direction, &hit),
            });
        }
        0
    }
}

impl Traced {
    fn met_of(&self, e: usize) -> &[Met] {
        &self.met[self.first_met[e] as usize..self.first_met[e + 1] as usize]
    }

    /// Light of sky and emitters that the rays of an element came upon, with the weight that
    /// belongs to rays. `loose` is the emission that is not sampled, `None` if there is none.
    pub(crate) fn found(
        &self,
        e: usize,
        elements: &Elements,
        loose: Option<&[Vec3A]>,
        sky: Vec3,
    ) -> Vec3 {
        let met = self.met_of(e).iter();
        let sampled: Vec3 = met
            .map(|m| elements.emission[m.element as usize] * m.weight)
            .sum();
        let loose = loose.map_or(Vec3::ZERO, |l| self.rows.gather(e, l).as_vec3());
        (sky * self.sky[e] as f32 + sampled) / self.rows.rays as f32 + loose
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.rows.bytes()
            + (4 * (self.sky.len() + self.first_met.len())
                + size_of_val(&*self.met)
                + size_of_val(&*self.reaches)) as u64
    }

    /// What every ray met and how far off: for tests.
    #[cfg(test)]
    pub(crate) fn hits(&self) -> (&[u32], &[Reach]) {
        (&self.rows.ids, &self.reaches)
    }
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
