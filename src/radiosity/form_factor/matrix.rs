use glam::{DVec3, Vec3, Vec3A};

use super::hit_list::HitList;

/// The form-factor matrix: row `e` holds `F_ej`, the share of the light leaving element `e` that
/// reaches element `j`, and so the weight with which light of `j` arrives at `e`.
pub(crate) enum Matrix {
    /// All weights the same: ids alone.
    Hits(HitList),
    /// Rows with a weight for each entry.
    Rows(Vec<KeptRow>),
}

/// A row as the matrix keeps it, in whichever form is smaller.
///
/// Rows are kept just as they are packed, one by one, where they are found: the matrix is never held
/// twice, as it would be if it were put together from them. (What is freed in a thousand small parts
/// does not come back for one large part.)
pub(crate) struct KeptRow {
    form: Form,
    /// `Σ_j F_ij`.
    sum: f64,
}

enum Form {
    /// What is not zero, with its element.
    Sparse(Box<[(u32, f32)]>),
    /// Every element.
    Dense(Box<[f32]>),
}

/// One row, as a method finds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Row {
    /// Elements, each at most once, in rising order, and their form factors.
    pub(crate) entries: Vec<(u32, f32)>,
    /// The share of the view that is sky.
    pub(crate) sky: f32,
}

impl Row {
    /// `Σ_j F_ij`.
    pub(crate) fn sum(&self) -> f64 {
        self.entries.iter().map(|e| f64::from(e.1)).sum()
    }

    /// Light of `seen` elements and of the sky that arrives over the row.
    pub(crate) fn light(&self, seen: &[Vec3A], sky: Vec3) -> Vec3 {
        let entries = self.entries.iter();
        let light: Vec3A = entries.map(|&(j, f)| seen[j as usize] * f).sum();
        Vec3::from(light) + sky * self.sky
    }

    /// The row to keep, of as many elements as there are.
    pub(crate) fn packed(self, elements: usize) -> KeptRow {
        let sum = self.sum();
        let form = if 2 * self.entries.len() < elements {
            Form::Sparse(self.entries.into())
        } else {
            let mut weights = vec![0.0; elements];
            for (id, weight) in self.entries {
                weights[id as usize] = weight;
            }
            Form::Dense(weights.into())
        };
        KeptRow { form, sum }
    }
}

impl Matrix {
    /// Keeps rows that are all there already.
    pub(crate) fn of(rows: Vec<Row>) -> Self {
        let count = rows.len();
        Self::Rows(rows.into_iter().map(|row| row.packed(count)).collect())
    }

    /// `Σ_j F_ij x_j` for element `e`.
    pub(crate) fn gather(&self, e: usize, values: &[Vec3A]) -> DVec3 {
        match self {
            Self::Hits(rows) => rows.gather(e, values),
            Self::Rows(rows) => rows[e].gather(values),
        }
    }

    /// `Σ_j F_ij` for element `e`: at most 1, and 1 where nothing escapes.
    pub(crate) fn row_sum(&self, e: usize) -> f64 {
        match self {
            Self::Hits(rows) => rows.row_sum(e),
            Self::Rows(rows) => rows[e].sum,
        }
    }

    /// Tells `found` of the entries of a row: element and weight, some elements more than once.
    pub(crate) fn each(&self, e: usize, found: impl FnMut(u32, f32)) {
        match self {
            Self::Hits(rows) => rows.each(e, found),
            Self::Rows(rows) => rows[e].each(found),
        }
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Hits(rows) => rows.len(),
            Self::Rows(rows) => rows.len(),
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Hits(rows) => rows.bytes(),
            Self::Rows(rows) => rows.iter().map(KeptRow::bytes).sum(),
        }
    }
}

impl KeptRow {
    /// From the weights of all elements.
    pub(super) fn dense(weights: Vec<f32>) -> Self {
        Self {
            sum: weights.iter().map(|&w| f64::from(w)).sum(),
            form: Form::Dense(weights.into()),
        }
    }

    /// `Σ_j F_ij`.
    pub(super) fn sum(&self) -> f64 {
        self.sum
    }

    fn gather(&self, values: &[Vec3A]) -> DVec3 {
        match &self.form {
            Form::Sparse(entries) => sparse(entries, values),
            Form::Dense(weights) => dense(weights, values),
        }
    }

    fn each(&self, mut found: impl FnMut(u32, f32)) {
        match &self.form {
            Form::Sparse(entries) => entries.iter().for_each(|&(id, w)| found(id, w)),
            Form::Dense(weights) => {
                for (id, &w) in (0..).zip(weights).filter(|(_, w)| **w != 0.0) {
                    found(id, w);
                }
            }
        }
    }

    fn bytes(&self) -> u64 {
        let entries = match &self.form {
            Form::Sparse(entries) => size_of_val(&**entries),
            Form::Dense(weights) => size_of_val(&**weights),
        };
        (size_of::<Self>() + entries) as u64
    }
}

/// Short sums in f32 lose nothing that matters; the long one is in f64.
fn sparse(entries: &[(u32, f32)], values: &[Vec3A]) -> DVec3 {
    let block = |entries: &[(u32, f32)]| {
        let terms = entries.iter().map(|&(id, w)| values[id as usize] * w);
        terms.sum::<Vec3A>().as_dvec3()
    };
    entries.chunks(16).map(block).sum()
}

fn dense(weights: &[f32], values: &[Vec3A]) -> DVec3 {
    let blocks = weights.chunks(64).zip(values.chunks(64));
    blocks
        .map(|(weights, values)| {
            let mut lanes = [Vec3A::ZERO; 4];
            let (fours, rest) = weights.as_chunks::<4>();
            let (value_fours, value_rest) = values.as_chunks::<4>();
            for (w, v) in fours.iter().zip(value_fours) {
                for k in 0..4 {
                    lanes[k] += v[k] * w[k];
                }
            }
            let rest: Vec3A = rest.iter().zip(value_rest).map(|(&w, &v)| v * w).sum();
            ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest).as_dvec3()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: u32, every: u32) -> Vec<Row> {
        let row = |e: u32| Row {
            entries: (0..count)
                .filter(|j| (j + e).is_multiple_of(every))
                .map(|j| (j, 1.0 / (1 + j + e) as f32))
                .collect(),
            sky: 0.0,
        };
        (0..count).map(row).collect()
    }

    #[test]
    fn forms_agree() {
        for (count, every) in [(150, 1), (150, 7), (1, 1)] {
            let rows = rows(count, every);
            let matrix = Matrix::of(rows.clone());
            let entries: usize = rows.iter().map(|r| r.entries.len()).sum();
            let bytes = if every == 1 { 4 } else { 8 } * entries;
            let heads = rows.len() * size_of::<KeptRow>();
            assert_eq!(matrix.bytes(), (bytes + heads) as u64);
            let values: Vec<Vec3A> = (0..count)
                .map(|j| Vec3A::new(j as f32, 1.0, -(j as f32)))
                .collect();
            for (e, row) in rows.iter().enumerate() {
                let mut sum = DVec3::ZERO;
                for &(j, w) in &row.entries {
                    sum += values[j as usize].as_dvec3() * f64::from(w);
                }
                assert!((matrix.gather(e, &values) - sum).length() < 1e-5 * sum.length());
                assert!((matrix.row_sum(e) - row.sum()).abs() < 1e-6);
                let mut found = Vec::new();
                matrix.each(e, |j, w| found.push((j, w)));
                assert_eq!(found, row.entries);
            }
        }
    }
}
