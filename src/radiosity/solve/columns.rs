use crate::radiosity::form_factor::Matrix;
use crate::radiosity::parallel::Cancelled;

use super::glimpse::Watch;

/// The form-factor matrix by columns: for an element, who sees it and how much of it.
///
/// The light of `i` arrives at `j` with the weight `F_ji`, an entry of column `i`. By reciprocity
/// it is `A_i F_ij / A_j`, which row `i` knows; but form factors that were found from either side
/// apart obey reciprocity only nearly, and with them shooting would solve another system than
/// gathering does. So the very entries are used, sorted by columns once: 8 bytes for each that is
/// not 0, about twice the hit list, or 4 for every pair where most are not.
pub(super) enum Columns {
    Sparse {
        /// First entry of each column, and one past the last.
        first: Vec<usize>,
        ids: Vec<u32>,
        weights: Vec<f32>,
    },
    Dense {
        count: usize,
        weights: Vec<f32>,
    },
}

/// Rows between two questions whether to go on.
const BETWEEN_QUESTIONS: usize = 1024;

impl Columns {
    /// A counting sort of the entries; those of one pair become one.
    pub(super) fn new(rows: &Matrix, watch: &Watch) -> Result<Self, Cancelled> {
        let count = rows.len();
        let mut first = vec![0; count + 1];
        each_pair(rows, watch, |_, j, _, new| first[j + 1] += usize::from(new))?;
        for j in 0..count {
            first[j + 1] += first[j];
        }
        let entries = first[count];
        if 2 * entries >= count * count {
            let mut weights = vec![0.0; count * count];
            each_pair(rows, watch, |e, j, w, _| weights[j * count + e] += w)?;
            return Ok(Self::Dense { count, weights });
        }
        let mut next = first.clone();
        let (mut ids, mut weights) = (vec![0; entries], vec![0.0; entries]);
        each_pair(rows, watch, |e, j, w, new| {
            next[j] += usize::from(new);
            ids[next[j] - 1] = e as u32;
            weights[next[j] - 1] += w;
        })?;
        Ok(Self::Sparse {
            first,
            ids,
            weights,
        })
    }

    /// Tells `found` of a column: who sees the element, and its form factor to it.
    pub(super) fn each(&self, element: usize, mut found: impl FnMut(usize, f32)) {
        match self {
            Self::Sparse {
                first,
                ids,
                weights,
            } => {
                let range = first[element]..first[element + 1];
                for (&id, &w) in ids[range.clone()].iter().zip(&weights[range]) {
                    found(id as usize, w);
                }
            }
            Self::Dense { count, weights } => {
                let column = &weights[element * count..(element + 1) * count];
                for (id, &w) in column.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                    found(id, w);
                }
            }
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        let bytes = match self {
            Self::Sparse { first, ids, .. } => 8 * (first.len() + ids.len()),
            Self::Dense { weights, .. } => size_of_val(&**weights),
        };
        bytes as u64
    }
}

/// Tells `found` of all entries, row after row: row, column, weight, and whether it is the pair's
/// first.
fn each_pair(
    rows: &Matrix,
    watch: &Watch,
    mut found: impl FnMut(usize, usize, f32, bool),
) -> Result<(), Cancelled> {
    let mut last_row = vec![usize::MAX; rows.len()];
    for e in 0..rows.len() {
        if e % BETWEEN_QUESTIONS == 0 {
            watch.ask()?;
        }
        rows.each(e, |j, weight| {
            let j = j as usize;
            let new = last_row[j] != e;
            last_row[j] = e;
            found(e, j, weight, new);
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::enclosure::ALONE;
    use super::*;
    use crate::radiosity::form_factor::{HitList, Row};
    use crate::radiosity::sampling::hash;

    /// `F_ij` for `each` of rows and `each` of columns.
    fn both(rows: &Matrix) -> [Vec<Vec<f32>>; 2] {
        let columns = Columns::new(rows, &ALONE).unwrap();
        let n = rows.len();
        let (mut by_row, mut by_column) = (vec![vec![0.0; n]; n], vec![vec![0.0; n]; n]);
        for (e, row) in by_row.iter_mut().enumerate() {
            rows.each(e, |j, w| row[j as usize] += w);
            let mut seen = Vec::new();
            columns.each(e, |i, w| {
                by_column[i][e] += w;
                seen.push(i);
            });
            assert!(
                seen.is_sorted_by(|a, b| a < b),
                "each at most once: {seen:?}"
            );
        }
        [by_row, by_column]
    }

    #[test]
    fn columns_hold_the_entries_of_rows() {
        let n = 40;
        for rays in [3, 200] {
            let hit = |e: u32, i: u32| Some(hash(e, i) % n).filter(|id| !id.is_multiple_of(7));
            let row = |e: u32| (0..rays).map(|i| hit(e, i)).collect();
            let ids: Vec<Vec<Option<u32>>> = (0..n).map(row).collect();
            let hits = Matrix::Hits(HitList::from_rows(&ids));
            let dense = matches!(Columns::new(&hits, &ALONE).unwrap(), Columns::Dense { .. });
            assert_eq!(dense, rays == 200);
            let [by_row, by_column] = both(&hits);
            assert_eq!(by_row, by_column);
            let weighted = |row: &Vec<f32>| Row {
                entries: (0..n)
                    .zip(row.iter().copied())
                    .filter(|e| e.1 > 0.0)
                    .collect(),
                sky: 0.0,
            };
            let rows: Vec<Row> = by_row.iter().map(weighted).collect();
            assert_eq!(both(&Matrix::of(rows)), [by_row, by_column]);
        }
        assert_eq!(
            both(&Matrix::of(Vec::new())),
            [Vec::<Vec<f32>>::new(), Vec::new()]
        );
    }
}
