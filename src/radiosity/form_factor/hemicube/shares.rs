use super::delta::DeltaFormFactors;
use super::eye::Seen;
use super::faces::Face;
use super::places::Places;
use super::raster::{NOTHING, Picture};
use crate::radiosity::element::Elements;
use crate::radiosity::form_factor::matrix::Row;

/// What of the view belongs to whom: pixels of the pictures, added up by element.
pub(super) struct Shares {
    sums: Vec<f64>,
    /// A bit for each element that has a pixel: rows come out in order without sorting.
    met: Vec<u64>,
    sky: f64,
    resolution: usize,
    /// Of one row of pixels.
    weights: Vec<f32>,
}

impl Shares {
    pub(super) fn new(elements: usize, resolution: usize) -> Self {
        Self {
            sums: vec![0.0; elements],
            met: vec![0; elements.div_ceil(64)],
            sky: 0.0,
            resolution,
            weights: vec![0.0; resolution],
        }
    }

    /// Adds the pixels of a face, on which `seen` is drawn.
    pub(super) fn add(
        &mut self,
        face: &Face,
        picture: &Picture,
        seen: &[Seen],
        deltas: &DeltaFormFactors,
        elements: &Elements,
    ) {
        let mut weights = std::mem::take(&mut self.weights);
        for row in 0..face.rows(self.resolution) {
            deltas.row(face, row, &mut weights);
            let mut first = 0;
            for run in picture.row(row).chunk_by(|a, b| a == b) {
                let weights = &weights[first..first + run.len()];
                match run[0] {
                    NOTHING => self.sky += total(weights),
                    item => {
                        let seen = &seen[item as usize];
                        self.add_run(seen, face, row, first, weights, elements);
                    }
                }
                first += run.len();
            }
        }
        self.weights = weights;
    }

    /// Adds pixels side by side that show one triangle.
    fn add_run(
        &mut self,
        seen: &Seen,
        face: &Face,
        row: usize,
        first: usize,
        weights: &[f32],
        elements: &Elements,
    ) {
        let element = |uv| elements.side_at(seen.triangle, uv, seen.back);
        if seen.cells == 1.0 {
            if let Some(element) = element([0.0; 2]) {
                self.give(element.0, total(weights));
            }
            return;
        }
        let edges = Places::edges(seen, face, self.resolution);
        let places = Places::new(seen, &edges, row);
        let columns = first..first + weights.len();
        if places.change_often(&columns) {
            for (column, &weight) in columns.zip(weights) {
                if let Some(element) = element(places.uv(column)) {
                    self.give(element.0, weight.into());
                }
            }
            return;
        }
        let mut column = columns.start;
        while column < columns.end {
            let (uv, end) = places.run(column);
            let end = end.min(columns.end);
            if let Some(element) = element(uv) {
                self.give(element.0, total(&weights[column - first..end - first]));
            }
            column = end;
        }
    }

    fn give(&mut self, element: u32, share: f64) {
        let e = element as usize;
        self.sums[e] += share;
        self.met[e / 64] |= 1 << (e % 64);
    }

    /// The row, leaving nothing behind.
    pub(super) fn take(&mut self) -> Row {
        let count: u32 = self.met.iter().map(|bits| bits.count_ones()).sum();
        let mut entries = Vec::with_capacity(count as usize);
        for (word, bits) in self.met.iter_mut().enumerate() {
            let mut left = std::mem::take(bits);
            while left != 0 {
                let e = word * 64 + left.trailing_zeros() as usize;
                entries.push((e as u32, std::mem::take(&mut self.sums[e]) as f32));
                left &= left - 1;
            }
        }
        let sky = std::mem::take(&mut self.sky) as f32;
        Row { entries, sky }
    }
}

/// Short sums in f32 lose nothing that matters.
fn total(weights: &[f32]) -> f64 {
    let (blocks, rest) = weights.as_chunks::<8>();
    let rest: f32 = rest.iter().sum();
    if blocks.is_empty() {
        return rest.into();
    }
    let mut lanes = [0.0; 8];
    for block in blocks {
        for (lane, &weight) in lanes.iter_mut().zip(block) {
            *lane += weight;
        }
    }
    f64::from(lanes.iter().sum::<f32>() + rest)
}
