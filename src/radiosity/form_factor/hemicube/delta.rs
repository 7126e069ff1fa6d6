use super::faces::Face;

/// Delta form factors: the share of the view that each pixel of a hemicube covers.
///
/// A pixel is a small area at `r` from the viewpoint, and what covers it in the picture has the
/// form factor of the pixel itself. From `ΔF = cos θ cos θ′ ΔA / (π r²)`, where `θ` is the angle at
/// the viewpoint and `θ′` that at the pixel:
///
/// ```text
///   top   pixel (x, y, 1): r² = x² + y² + 1, cos θ = cos θ′ = 1/r
///   side  pixel (1, y, z): r² = 1 + y² + z², cos θ = z/r, cos θ′ = 1/r
///
///   ┌────────────────────────────────────────────────────────────────────┐
///   │  ΔF_top  =   ΔA / (π (x² + y² + 1)²)                               │
///   │  ΔF_side = z ΔA / (π (y² + z² + 1)²)      ΔA = (2/R)²              │
///   └────────────────────────────────────────────────────────────────────┘
/// ```
///
/// All of them are the view, 1; taken at pixel centres they sum to 1 + 0.5423/R², by which they are
/// divided.
///
/// The top is its own mirror image about two axes and two diagonals, a side about one axis: an
/// octant and a half are kept.
pub(super) struct DeltaFormFactors {
    half: usize,
    /// Pixel (i, j), counted from the middle, at i(i + 1)/2 + j for j ≤ i.
    top: Vec<f32>,
    /// Rows from the horizon up, columns from the middle.
    side: Vec<f32>,
}

impl DeltaFormFactors {
    pub(super) fn new(resolution: usize) -> Self {
        let (top, side, sum) = unscaled(resolution);
        let scaled = |table: Vec<f64>| table.into_iter().map(|f| (f / sum) as f32).collect();
        Self {
            half: resolution / 2,
            top: scaled(top),
            side: scaled(side),
        }
    }

    /// Those of one row of pixels of a face.
    pub(super) fn row(&self, face: &Face, row: usize, into: &mut [f32]) {
        let (left, right) = into.split_at_mut(self.half);
        if face.is_top() {
            let j = from_middle(row, self.half);
            for (i, f) in right.iter_mut().enumerate() {
                *f = self.top[octant(i, j)];
            }
        } else {
            right.copy_from_slice(&self.side[row * self.half..(row + 1) * self.half]);
        }
        for (mirrored, &f) in left.iter_mut().rev().zip(right.iter()) {
            *mirrored = f;
        }
    }
}

/// How many pixels from the middle a pixel is, 0 on both sides of it.
fn from_middle(i: usize, half: usize) -> usize {
    if i < half { half - 1 - i } else { i - half }
}

fn octant(i: usize, j: usize) -> usize {
    let (i, j) = (i.max(j), i.min(j));
    i * (i + 1) / 2 + j
}

/// Tables of top and side at pixel centres, and the sum over the whole hemicube.
fn unscaled(resolution: usize) -> (Vec<f64>, Vec<f64>, f64) {
    let half = resolution / 2;
    let size = 2.0 / resolution as f64;
    let per_area = size * size / std::f64::consts::PI;
    let at = |i: usize| (i as f64 + 0.5) * size;
    let (mut top, mut side, mut sum) = (Vec::new(), Vec::new(), 0.0);
    for i in 0..half {
        for j in 0..=i {
            let f = per_area / (at(i).powi(2) + at(j).powi(2) + 1.0).powi(2);
            sum += f * if i == j { 4.0 } else { 8.0 };
            top.push(f);
        }
    }
    for z in 0..half {
        for y in 0..half {
            let f = at(z) * per_area / (at(y).powi(2) + at(z).powi(2) + 1.0).powi(2);
            // Four sides, two halves.
            sum += 8.0 * f;
            side.push(f);
        }
    }
    (top, side, sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::form_factor::hemicube::faces::FACES;

    fn face(table: &DeltaFormFactors, face: &Face, resolution: usize) -> Vec<Vec<f32>> {
        let rows = 0..face.rows(resolution);
        rows.map(|j| {
            let mut row = vec![0.0; resolution];
            table.row(face, j, &mut row);
            row
        })
        .collect()
    }

    #[test]
    fn before_scaling_they_exceed_one_by_the_error_of_midpoints() {
        for resolution in [16, 32, 64, 128, 256, 512] {
            let excess = unscaled(resolution).2 - 1.0;
            let expected = 0.5423 / (resolution as f64).powi(2);
            assert!(
                (excess / expected - 1.0).abs() < 0.01,
                "{resolution}: {excess}"
            );
        }
    }

    #[test]
    fn the_whole_view_is_one() {
        for resolution in [16, 18, 64, 256, 512] {
            let table = DeltaFormFactors::new(resolution);
            let faces = FACES.iter().map(|f| face(&table, f, resolution));
            let sum: f64 = faces.flatten().flatten().map(f64::from).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{resolution}: {sum}");
        }
    }

    #[test]
    fn the_top_has_eight_symmetries_and_sides_have_two() {
        for resolution in [16, 30] {
            let table = DeltaFormFactors::new(resolution);
            let top = face(&table, &FACES[0], resolution);
            let last = resolution - 1;
            for i in 0..resolution {
                for j in 0..resolution {
                    for (k, l) in [(i, j), (j, i)] {
                        for k in [k, last - k] {
                            assert_eq!(top[i][j], top[k][l]);
                            assert_eq!(top[i][j], top[k][last - l]);
                        }
                    }
                }
            }
            assert!(top[0][0] < top[resolution / 2][resolution / 2]);
            for side in &FACES[1..] {
                for row in face(&table, side, resolution) {
                    assert!(row.iter().eq(row.iter().rev()));
                }
            }
        }
    }
}
