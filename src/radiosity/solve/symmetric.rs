use crate::radiosity::form_factor::{Matrix, Row};
use crate::radiosity::parallel::Cancelled;

use super::columns::Columns;
use super::glimpse::Watch;
use super::system::{System, map_elements};

/// Form factors that obey reciprocity, as near to the given ones as they may be.
///
/// With `G = A F` reciprocity says `G = Gᵀ`. Found from either side apart, `F_ij` and `F_ji` are two
/// estimates of one number, and `½ (G + Gᵀ)` is their mean. But its rows do not sum up to what the
/// given ones do: some elements would receive more light than there is, others less, and at ρ near
/// 1 a hundred bounces make a large error of a small one. So rows and columns are scaled by the
/// same factors `d` until rows sum up as given (Sinkhorn and Knopp 1967; Knight and Ruiz 2013),
///
/// ```text
///   d_i ← √( d_i · A_i rowsum_i / Σ_j G_ij d_j )
///   ┌──────────────────────────────────────┐
///   │  F'_ij = d_i ½ (G_ij + G_ji) d_j / A_i │
///   └──────────────────────────────────────┘
/// ```
///
/// the root because both ends of an entry correct it. There are matrices that no factors close
/// (two groups that only see each other, one seeing more of the other): then each side gives way.
pub(super) fn symmetrized(system: &System, watch: &Watch) -> Result<Matrix, Cancelled> {
    let means = means(system, watch)?;
    let factors = factors(system, &means, watch)?;
    let rows = scaled(system, means, &factors);
    Ok(Matrix::of(rows))
}

/// The closest rows come to their sums, and the most steps towards it.
const CLOSE: f64 = 1e-6;
const STEPS: u32 = 50;

/// Rows of `½ (G + Gᵀ) / A`. Elements without area, who are not seen, keep theirs.
fn means(system: &System, watch: &Watch) -> Result<Vec<Row>, Cancelled> {
    let columns = Columns::new(system.rows, watch)?;
    let area = |e: usize| f64::from(system.elements.area[e]);
    let count = system.len();
    let parts = map_elements(count, watch, |range| {
        let mut sums = vec![0.0_f64; count];
        let mut met = Vec::new();
        let row = |i: usize| {
            let mut add = |j: usize, weight: f64| {
                if sums[j] == 0.0 {
                    met.push(j as u32);
                }
                sums[j] += weight;
            };
            let share = if area(i) > 0.0 { 0.5 } else { 1.0 };
            system
                .rows
                .each(i, |j, w| add(j as usize, share * f64::from(w)));
            if area(i) > 0.0 {
                columns.each(i, |j, w| add(j, 0.5 * f64::from(w) * area(j) / area(i)));
            }
            met.sort_unstable();
            met.dedup();
            let take = |j: u32| (j, std::mem::take(&mut sums[j as usize]) as f32);
            Row {
                entries: met.drain(..).map(take).collect(),
                sky: 0.0,
            }
        };
        range.map(row).collect::<Vec<Row>>()
    })?;
    Ok(parts.into_iter().flatten().collect())
}

/// `d`.
fn factors(system: &System, means: &[Row], watch: &Watch) -> Result<Vec<f64>, Cancelled> {
    let mut factors = vec![1.0_f64; means.len()];
    for _ in 0..STEPS {
        let stretch = map_elements(means.len(), watch, |range| {
            let sum = |i: usize| -> f64 {
                let entries = means[i].entries.iter();
                entries
                    .map(|&(j, w)| f64::from(w) * factors[j as usize])
                    .sum()
            };
            let stretch = |i: usize| {
                let is = factors[i] * sum(i);
                if is > 0.0 {
                    system.rows.row_sum(i) / is
                } else {
                    1.0
                }
            };
            range.map(stretch).collect::<Vec<f64>>()
        })?
        .concat();
        for (d, s) in factors.iter_mut().zip(&stretch) {
            *d *= s.sqrt();
        }
        if stretch.iter().all(|s| (s - 1.0).abs() < CLOSE) {
            break;
        }
    }
    Ok(factors)
}

/// Rows times `d` on both sides. Where that would let light grow, or last much longer than it did,
/// all are scaled down alike.
fn scaled(system: &System, mut rows: Vec<Row>, factors: &[f64]) -> Vec<Row> {
    let mut largest: f64 = 0.0;
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, weight) in &mut row.entries {
            *weight = (f64::from(*weight) * factors[i] * factors[*j as usize]) as f32;
        }
        largest = largest.max(system.reflectance(i).max_element() * row.sum());
    }
    // At least half as much is lost on each bounce as was.
    let limit = 0.5 * (1.0 + system.contraction());
    if largest > limit {
        let down = (limit / largest) as f32;
        for (_, weight) in rows.iter_mut().flat_map(|r| &mut r.entries) {
            *weight *= down;
        }
    }
    rows
}
