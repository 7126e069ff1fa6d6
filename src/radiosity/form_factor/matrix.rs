use glam::{DVec3, Vec3, Vec3A};

use super::hit_list::HitList;

/// The form-factor matrix: row `e` holds `F_ej`, the share of the light leaving element `e` that
/// reaches element `j`, and so the weight with which light of `j` arrives at `e`.
pub(crate) enum Matrix {
    /// All weights the same: ids alone.
    Hits(HitList),
    /// What is not zero, with its weight.
    Weighted(WeightedRows),
    /// Every pair.
    Dense(DenseRows),
}

/// Entries of each row one after the other.
pub(crate) struct WeightedRows {
    /// First entry of each row, and one past the last.
    first: Vec<usize>,
    ids: Vec<u32>,
    weights: Vec<f32>,
    sums: Vec<f32>,
}

/// All entries of each row.
pub(crate) struct DenseRows {
    count: usize,
    weights: Vec<f32>,
    sums: Vec<f32>,
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
}

impl Matrix {
    /// Keeps rows in whichever form is smaller. Each is freed as soon as it is copied.
    pub(crate) fn of(rows: Vec<Row>) -> Self {
        let entries: usize = rows.iter().map(|r| r.entries.len()).sum();
        if 2 * entries >= rows.len() * rows.len() {
            Self::Dense(DenseRows::of(rows))
        } else {
            Self::Weighted(WeightedRows::of(rows, entries))
        }
    }

    /// `Σ_j F_ij x_j` for element `e`.
    pub(crate) fn gather(&self, e: usize, values: &[Vec3A]) -> DVec3 {
        match self {
            Self::Hits(rows) => rows.gather(e, values),
            Self::Weighted(rows) => weighted(rows.row(e), values),
            Self::Dense(rows) => rows.gather(e, values),
        }
    }

    /// `Σ_j F_ij` for element `e`: at most 1, and 1 where nothing escapes.
    pub(crate) fn row_sum(&self, e: usize) -> f64 {
        match self {
            Self::Hits(rows) => rows.row_sum(e),
            Self::Weighted(rows) => rows.sums[e].into(),
            Self::Dense(rows) => rows.sums[e].into(),
        }
    }

    /// Tells `found` of the entries of a row: element and weight, some elements more than once.
    pub(crate) fn each(&self, e: usize, mut found: impl FnMut(u32, f32)) {
        match self {
            Self::Hits(rows) => rows.each(e, found),
            Self::Weighted(rows) => rows.row(e).for_each(|(id, w)| found(id, w)),
            Self::Dense(rows) => {
                for (j, &w) in rows.row(e).iter().enumerate().filter(|(_, w)| **w != 0.0) {
                    found(j as u32, w);
                }
            }
        }
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Hits(rows) => rows.len(),
            Self::Weighted(rows) => rows.sums.len(),
            Self::Dense(rows) => rows.count,
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Hits(rows) => rows.bytes(),
            Self::Weighted(rows) => (8 * (rows.ids.len() + rows.first.len())) as u64,
            Self::Dense(rows) => 4 * (rows.weights.len() + rows.sums.len()) as u64,
        }
    }
}

/// Short sums in f32 lose nothing that matters; the long one is in f64.
fn weighted(entries: impl Iterator<Item = (u32, f32)>, values: &[Vec3A]) -> DVec3 {
    let (mut sum, mut block, mut in_block) = (DVec3::ZERO, Vec3A::ZERO, 0);
    for (id, weight) in entries {
        block += values[id as usize] * weight;
        in_block += 1;
        if in_block == 16 {
            sum += block.as_dvec3();
            (block, in_block) = (Vec3A::ZERO, 0);
        }
    }
    sum + block.as_dvec3()
}

impl WeightedRows {
    fn of(rows: Vec<Row>, entries: usize) -> Self {
        let mut matrix = Self {
            first: vec![0],
            ids: Vec::with_capacity(entries),
            weights: Vec::with_capacity(entries),
            sums: Vec::with_capacity(rows.len()),
        };
        for row in rows {
            matrix.ids.extend(row.entries.iter().map(|e| e.0));
            matrix.weights.extend(row.entries.iter().map(|e| e.1));
            matrix.first.push(matrix.ids.len());
            matrix.sums.push(row.sum() as f32);
        }
        matrix
    }

    fn row(&self, e: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let range = self.first[e]..self.first[e + 1];
        let ids = self.ids[range.clone()].iter().copied();
        ids.zip(self.weights[range].iter().copied())
    }
}

impl DenseRows {
    fn of(rows: Vec<Row>) -> Self {
        let count = rows.len();
        let mut weights = vec![0.0; count * count];
        for (row, into) in rows.into_iter().zip(weights.chunks_mut(count.max(1))) {
            for (id, weight) in row.entries {
                into[id as usize] = weight;
            }
        }
        Self::new(count, weights)
    }

    /// From all entries, row after row.
    pub(crate) fn new(count: usize, weights: Vec<f32>) -> Self {
        let sum = |row: &[f32]| row.iter().map(|&w| f64::from(w)).sum::<f64>() as f32;
        Self {
            sums: weights.chunks(count.max(1)).map(sum).collect(),
            count,
            weights,
        }
    }

    fn row(&self, e: usize) -> &[f32] {
        &self.weights[e * self.count..(e + 1) * self.count]
    }

    fn gather(&self, e: usize, values: &[Vec3A]) -> DVec3 {
        let blocks = self.row(e).chunks(64).zip(values.chunks(64));
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
            assert_eq!(matches!(matrix, Matrix::Dense(_)), every == 1);
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
