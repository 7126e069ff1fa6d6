use glam::Vec3;

/// How a live triangle is cut into elements: into `n²` cells, each of which may be cut further into
/// `m²`. So cells can be finer where light differs much, and the element of a ray's hit follows from
/// the triangle and the barycentrics in two steps, however fine they are.
///
/// ```text
///   |\            a triangle of n = 2 cells along an edge,
///   | \           one of which is cut into m = 3 along an edge
///   |__\
///   |\▼|\\
///   | \|▲▼\
///   |__\▲▼▲\
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// Cells along an edge.
    pub(super) n: u16,
    /// Elements on one side.
    pub(super) count: u32,
    /// Element of the first cell on the front and on the back; the others follow.
    pub(super) front: u32,
    pub(super) back: Option<u32>,
    /// Where the cuts of its cells start, or [`WHOLE`].
    pub(super) cuts: u32,
}

/// No cell of the triangle is cut further.
pub(super) const WHOLE: u32 = u32::MAX;

/// How one cell of a triangle is cut further.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellCut {
    /// Its first element, counted from the triangle's first.
    pub(super) first: u32,
    /// Parts along an edge.
    pub(super) m: u16,
}

/// A part of a triangle: of its `n²` cells one, of whose `m²` parts one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) n: u16,
    pub(super) m: u16,
    pub(super) cell: u32,
    pub(super) sub: u32,
}

impl Default for Cells {
    fn default() -> Self {
        Self {
            n: 1,
            count: 0,
            front: 0,
            back: None,
            cuts: WHOLE,
        }
    }
}

impl Cells {
    /// The element at a point, counted from the triangle's first.
    #[inline]
    pub(super) fn at(&self, uv: [f32; 2], cuts: &[CellCut]) -> u32 {
        self.within(uv, cuts).0
    }

    /// The same, and where in it the point is.
    #[inline]
    pub(super) fn within(&self, uv: [f32; 2], cuts: &[CellCut]) -> (u32, [f32; 2]) {
        if self.n <= 1 {
            return (0, uv);
        }
        let (cell, within) = cell_of(uv, self.n);
        if self.cuts == WHOLE {
            return (cell, within);
        }
        let cut = cuts[(self.cuts + cell) as usize];
        let (part, within) = cell_of(within, cut.m);
        (cut.first + part, within)
    }
}

impl Part {
    /// The triangle's barycentrics of a point given by its barycentrics in the part.
    pub(super) fn point(&self, within: Vec3) -> Vec3 {
        in_cell(in_cell(within, self.sub, self.m), self.cell, self.n)
    }

    /// Its share of the triangle's area.
    pub(super) fn share(&self) -> f32 {
        1.0 / (f32::from(self.n) * f32::from(self.m)).powi(2)
    }
}

/// Which of a triangle's `n²` cells a point lies in, and where in it.
///
/// ```text
///   v        row i holds 2(n − i) − 1 cells, upright (▲) and
///   |\       inverted (▼) by turns, so rows 0..i hold i(2n − i),
///   |▲\      and cell = i(2n − i) + 2j + (1 if inverted).
///   |▼▲\
///   +---\ u
/// ```
#[inline]
pub(super) fn cell_of(uv: [f32; 2], n: u16) -> (u32, [f32; 2]) {
    if n <= 1 {
        return (0, uv);
    }
    let n = u32::from(n);
    let [x, y] = uv.map(|c| (c * n as f32).max(0.0));
    let i = (x as u32).min(n - 1);
    let j = (y as u32).min(n - 1 - i);
    let (u, v) = (x - i as f32, y - j as f32);
    let inverted = u + v > 1.0 && j + 1 < n - i;
    let within = if inverted { [1.0 - u, 1.0 - v] } else { [u, v] };
    (i * (2 * n - i) + 2 * j + u32::from(inverted), within)
}

/// The triangle's barycentrics of a point given by its barycentrics in one of `n²` cells.
pub(super) fn in_cell(point: Vec3, cell: u32, n: u16) -> Vec3 {
    if n <= 1 {
        return point;
    }
    let n = u32::from(n);
    // Rows from i on hold (n − i)² cells: the row is the largest i with n² − cell ≤ (n − i)².
    let left = n * n - cell;
    let mut rows = left.isqrt();
    if rows * rows < left {
        rows += 1;
    }
    let i = n - rows;
    let within = cell - i * (2 * n - i);
    let (j, inverted) = (within / 2, within % 2 == 1);
    let (u, v) = if inverted {
        (1.0 - point.y, 1.0 - point.z)
    } else {
        (point.y, point.z)
    };
    let (u, v) = ((i as f32 + u) / n as f32, (j as f32 + v) / n as f32);
    Vec3::new(1.0 - u - v, u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_are_inverse() {
        for n in [1_u16, 2, 3, 7, 50] {
            let count = u32::from(n).pow(2);
            for cell in 0..count {
                for b in [
                    Vec3::splat(1.0 / 3.0),
                    Vec3::new(0.9, 0.05, 0.05),
                    Vec3::new(0.1, 0.8, 0.1),
                ] {
                    let p = in_cell(b, cell, n);
                    assert!((p.element_sum() - 1.0).abs() < 1e-5 && p.min_element() > -1e-6);
                    assert_eq!(cell_of([p.y, p.z], n).0, cell, "n {n} point {p}");
                }
            }
        }
    }

    #[test]
    fn every_corner_lies_in_a_cell() {
        for n in [2_u16, 5, 1000] {
            for uv in [
                [0.0, 0.0],
                [1.0, 0.0],
                [0.0, 1.0],
                [0.5, 0.5],
                [-1e-7, 1.0],
                [1.0, 1e-7],
            ] {
                assert!(cell_of(uv, n).0 < u32::from(n).pow(2));
            }
        }
    }

    /// A triangle of `n²` cells, each cut into as many parts as `m` says.
    fn two_levels(n: u16, m: impl Fn(u32) -> u16) -> (Cells, Vec<CellCut>, Vec<Part>) {
        let (mut cuts, mut parts) = (Vec::new(), Vec::new());
        for cell in 0..u32::from(n).pow(2) {
            let (first, m) = (parts.len() as u32, m(cell));
            cuts.push(CellCut { first, m });
            let part = |sub| Part { n, m, cell, sub };
            parts.extend((0..u32::from(m).pow(2)).map(part));
        }
        let cells = Cells {
            n,
            count: parts.len() as u32,
            cuts: 0,
            ..Cells::default()
        };
        (cells, cuts, parts)
    }

    #[test]
    fn points_of_parts_are_found_in_them() {
        let (cells, cuts, parts) = two_levels(7, |cell| [1, 2, 3, 8][cell as usize % 4]);
        for (number, part) in (0..).zip(&parts) {
            for within in [
                Vec3::splat(1.0 / 3.0),
                Vec3::new(0.9, 0.05, 0.05),
                Vec3::new(0.1, 0.8, 0.1),
            ] {
                let p = part.point(within);
                assert!((p.element_sum() - 1.0).abs() < 1e-5 && p.min_element() > -1e-6);
                assert_eq!(cells.at([p.y, p.z], &cuts), number, "{part:?}");
            }
        }
        let whole: f32 = parts.iter().map(Part::share).sum();
        assert!((whole - 1.0).abs() < 1e-5);
        for uv in [[0.0, 0.0], [1.0, 0.0], [-1e-7, 1.0], [0.5, 0.5]] {
            assert!(cells.at(uv, &cuts) < cells.count);
        }
    }
}
