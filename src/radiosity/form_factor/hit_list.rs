use glam::{DVec3, Vec3A};

use crate::radiosity::bounds::Reach;
use crate::radiosity::element::ElementId;
use crate::radiosity::emitter::Receiver;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::report::FormFactorReport;

use super::matrix::Matrix;
use super::traced::{BLACK, GONE, Met, RowsBefore, SKY, Traced};
use super::{Cast, View};

/// The form-factor matrix as a list of ray hits.
///
/// ```text
///   F_ij = 1/A_i ∫_Ai ∫_Ω V_ij cos θ / π dω dA ≈ 1/S #{ s : ray s of i hits j }
///   ┌───────────────────────────────────────────────────────────┐
///   │  rays with density cos θ / π: every weight is the same 1/S │
///   └───────────────────────────────────────────────────────────┘
/// ```
///
/// A row is `S` element ids, as many as its element casts rays. It sums to 1 − misses/S, never above
/// 1, so that Gauss–Seidel converges for any reflectance below 1.
pub(crate) struct HitList {
    ids: Vec<u32>,
    /// Where each row starts, and one past the last ends.
    first: Vec<usize>,
    /// Rays of each row that hit an element.
    hits: Vec<u32>,
}

impl HitList {
    /// `Σ_j F_ij x_j` for element `e`.
    pub(crate) fn gather(&self, e: usize, values: &[Vec3A]) -> DVec3 {
        let row = self.row(e);
        // A miss is beyond the end: one comparison for both.
        let value = |id: u32| values.get(id as usize).copied().unwrap_or(Vec3A::ZERO);
        let mut sum = DVec3::ZERO;
        // Short sums in f32 lose nothing that matters; the long one is in f64. Four at a time,
        // because one addition takes as long as four that do not wait for each other.
        let (blocks, rest) = row.as_chunks::<16>();
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
        sum / row.len() as f64
    }

    /// `Σ_j F_ij` for element `e`: 1 where no ray escapes.
    pub(crate) fn row_sum(&self, e: usize) -> f64 {
        f64::from(self.hits[e]) / self.row(e).len() as f64
    }

    pub(super) fn row(&self, e: usize) -> &[u32] {
        &self.ids[self.first[e]..self.first[e + 1]]
    }

    /// Where the rays of a row start among all.
    pub(super) fn first(&self, e: usize) -> usize {
        self.first[e]
    }

    /// The weight of each ray of a row.
    pub(crate) fn per_ray(&self, e: usize) -> f32 {
        1.0 / self.row(e).len() as f32
    }

    /// Tells `found` of every hit of a row.
    pub(super) fn each(&self, e: usize, mut found: impl FnMut(u32, f32)) {
        let weight = self.per_ray(e);
        for &id in self.row(e).iter().filter(|&&id| id < GONE) {
            found(id, weight);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.hits.len()
    }

    /// What every ray met.
    #[cfg(test)]
    pub(super) fn ids(&self) -> &[u32] {
        &self.ids
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(&*self.ids) + size_of_val(&*self.first) + size_of_val(&*self.hits)) as u64
    }

    /// From what all rays met, and how many rays each row has.
    fn new(ids: Vec<u32>, lengths: impl Iterator<Item = usize>) -> Self {
        let mut first = vec![0];
        first.extend(lengths.scan(0, |end, length| {
            *end += length;
            Some(*end)
        }));
        let count = |row: &[usize]| {
            let row = &ids[row[0]..row[1]];
            row.iter().filter(|&&id| id < GONE).count() as u32
        };
        Self {
            hits: first.windows(2).map(count).collect(),
            first,
            ids,
        }
    }

    /// A matrix given row by row; `None` is a miss.
    #[cfg(test)]
    pub(crate) fn from_rows(rows: &[Vec<Option<u32>>]) -> Self {
        let ids = rows.iter().flatten().map(|id| id.unwrap_or(SKY));
        Self::new(ids.collect(), rows.iter().map(Vec::len))
    }
}

/// Elements a thread takes at a time: a few milliseconds' work.
const CHUNK: usize = 64;

/// The rays of some elements, one element after the other.
#[derive(Default)]
struct Rows {
    ids: Vec<u32>,
    reaches: Vec<Reach>,
    sky: Vec<f32>,
    met: Vec<Met>,
    /// How many of `met` each element has.
    met_count: Vec<u32>,
    traced: u64,
}

/// Traces cosine-distributed rays from points spread over each element, those that `before` does
/// not answer. Returns how many that were.
pub(crate) fn trace(
    view: &View,
    before: Option<&RowsBefore>,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    let count = view.elements.len();
    let chunks = map_ranges(count, CHUNK, Stage::FormFactors, observer, |range| {
        let mut rows = Rows::default();
        let rays = view.elements.rays[range.clone()].iter();
        rows.ids.reserve_exact(rays.map(|&r| usize::from(r)).sum());
        for e in range {
            let met = rows.met.len();
            let kept = before.and_then(|b| Some((b, b.change.element_before[e]?)));
            let rays = view.elements.rays[e].into();
            let misses: u32 = match kept {
                Some((before, old)) => view.row_again(e, before, old as usize, &mut rows),
                None => (0..rays).map(|i| view.ray(e, i, &mut rows)).sum(),
            };
            rows.sky.push(misses as f32 * (1.0 / rays as f32));
            rows.met_count.push((rows.met.len() - met) as u32);
        }
        rows
    })?;
    let lengths = view.elements.rays.iter().map(|&rays| usize::from(rays));
    let rays = lengths.clone().sum();
    let mut ids = Vec::with_capacity(rays);
    let mut traced = Traced {
        rows: Matrix::Rows(Vec::new()),
        report: FormFactorReport::default(),
        sky: Vec::with_capacity(count),
        met: Vec::new(),
        first_met: vec![0],
        excess: Vec::new(),
        reaches: Vec::with_capacity(if view.remember { rays } else { 0 }),
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
    let rows = HitList::new(ids, lengths);
    let sums = (0..count).map(|e| rows.row_sum(e));
    traced.report.largest_row_sum = sums.fold(0.0, f64::max);
    traced.rows = Matrix::Hits(rows);
    Ok((traced, cost))
}

impl View<'_> {
    /// Takes over a row, tracing again what may have changed. Returns how many rays met the sky.
    fn row_again(&self, e: usize, before: &RowsBefore, old: usize, rows: &mut Rows) -> u32 {
        let sphere = self.elements.sphere(self.scene, ElementId(e as u32));
        let disturbed = before.change.disturbed.from(sphere);
        let traced = before.traced;
        let rays = self.elements.rays[e].into();
        // The same element casts as many rays as it did.
        let Matrix::Hits(hits) = &traced.rows else {
            return (0..rays).map(|i| self.ray(e, i, rows)).sum();
        };
        let mut met = traced.met_of(old).iter().peekable();
        let first = hits.first(old);
        let mut sky = 0;
        for i in 0..rays {
            let known = met.next_if(|m| m.ray == i);
            let reach = traced.reaches[first + i as usize];
            let id = before.change.translate(hits.ids[first + i as usize]);
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
        let Cast {
            origin,
            point,
            direction,
            hit,
        } = self.cast(e, i);
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
