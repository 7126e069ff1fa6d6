use glam::{Vec3, Vec3A};

use super::matrix::Matrix;
use crate::radiosity::bounds::Reach;
use crate::radiosity::change::Change;
use crate::radiosity::element::Elements;
use crate::radiosity::report::FormFactorReport;

/// In place of an element: the ray met the sky.
pub(crate) const SKY: u32 = u32::MAX;

/// In place of an element: the ray met the black back of a surface.
pub(crate) const BLACK: u32 = u32::MAX - 1;

/// In place of an element that is no more.
pub(crate) const GONE: u32 = u32::MAX - 2;

/// What the rays of all elements found.
pub(crate) struct Traced {
    pub(crate) rows: Matrix,
    pub(crate) report: FormFactorReport,
    /// The share of each element's view that is sky.
    pub(super) sky: Vec<f32>,
    /// Rays that met sampled emitters: those of element `e` from `first_met[e]` on.
    pub(super) met: Vec<Met>,
    pub(super) first_met: Vec<u32>,
    /// By how much each row summed to more than 1 before it was scaled to it; empty if none did.
    pub(super) excess: Vec<f32>,
    /// How far each ray went; empty if nobody will ask.
    pub(super) reaches: Vec<Reach>,
}

/// A ray of an element that met a sampled emitter.
#[derive(Clone, Copy)]
pub(super) struct Met {
    /// Which ray of the element.
    pub(super) ray: u32,
    pub(super) element: u32,
    /// How much of the emitter's light counts.
    pub(super) weight: f32,
}

/// What an earlier bake's rays found, of which much is still true.
pub(crate) struct RowsBefore<'a> {
    pub(crate) traced: &'a Traced,
    pub(crate) change: &'a Change,
    /// The emitters to sample are others than then.
    pub(crate) new_emitters: bool,
}

impl Traced {
    /// From a matrix and each element's share of sky.
    pub(super) fn of_matrix(rows: Matrix, sky: Vec<f32>, report: FormFactorReport) -> Self {
        Self {
            met: Vec::new(),
            first_met: vec![0; rows.len() + 1],
            rows,
            report,
            sky,
            excess: Vec::new(),
            reaches: Vec::new(),
        }
    }

    /// What scaling took from a row, beside what it left.
    pub(crate) fn excess(&self, e: usize) -> f32 {
        self.excess.get(e).copied().unwrap_or(0.0)
    }

    pub(super) fn met_of(&self, e: usize) -> &[Met] {
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
        let per_ray = match &self.rows {
            Matrix::Hits(hits) => hits.per_ray(e),
            Matrix::Rows(_) => 0.0,
        };
        sky * self.sky[e] + sampled * per_ray + loose
    }

    /// Light of `seen` elements and of sky that arrives over a row.
    pub(crate) fn light(&self, e: usize, seen: &[Vec3A], sky: Vec3) -> Vec3 {
        self.rows.gather(e, seen).as_vec3() + sky * self.sky[e]
    }

    /// Light of `seen` elements, of sky and of emitters at an element, as each half of its rays
    /// tells it; `None` without rays, or with one alone.
    pub(crate) fn halves(
        &self,
        e: usize,
        elements: &Elements,
        seen: &[Vec3A],
        sky: Vec3,
    ) -> Option<[Vec3; 2]> {
        let Matrix::Hits(hits) = &self.rows else {
            return None;
        };
        let row = hits.row(e);
        let middle = row.len() / 2;
        let sum = |ids: &[u32], met: &[Met]| {
            let light = |&id: &u32| match id {
                SKY => sky.into(),
                id => seen.get(id as usize).copied().unwrap_or(Vec3A::ZERO),
            };
            let light: Vec3A = ids.iter().map(light).sum();
            let met = met.iter();
            let met: Vec3 = met
                .map(|m| elements.emission[m.element as usize] * m.weight)
                .sum();
            (Vec3::from(light) + met) / ids.len() as f32
        };
        let met = self.met_of(e);
        let met = met.split_at(met.partition_point(|m| (m.ray as usize) < middle));
        let (first, second) = row.split_at(middle);
        (middle > 0).then(|| [sum(first, met.0), sum(second, met.1)])
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
        let Matrix::Hits(hits) = &self.rows else {
            return (&[], &self.reaches);
        };
        (hits.ids(), &self.reaches)
    }
}
