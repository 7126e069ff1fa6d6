//! One triangle cut into small ones, with any number of pieces along each of its edges.

use glam::Vec3;

/// How a triangle is cut: edges into `edges` pieces, from corner 0 to 1, 1 to 2, 2 to 0; inside as if all edges
/// had `inside`.
///
/// ```text
///   edges alike             edges differ: rows inside, a strip along each edge
///
///         2                        2
///        /\                       /|\\
///       /__\                     / |_\\
///      /\  /\                   / /\  /\
///     /__\/__\                 / /__\/  \
///    /\  /\  /\               /.'  | `\__\
///   0__\/__\/__1             0_____|_____'1
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lattice {
    edges: [u32; 3],
    inside: u32,
}

impl Lattice {
    /// All `edges` are at least 1.
    pub(super) fn new(edges: [u32; 3]) -> Self {
        let most = edges.into_iter().max().unwrap_or(1);
        let inside = match edges == [most; 3] {
            true => most,
            // There has to be a point inside for strips to go to.
            false => most.max(3),
        };
        Self { edges, inside }
    }

    fn is_regular(&self) -> bool {
        self.edges == [self.inside; 3]
    }

    /// How many vertices lie inside, not on edges.
    pub(super) fn inner_vertices(&self) -> u64 {
        let n = u64::from(self.inside);
        n.saturating_sub(1) * n.saturating_sub(2) / 2
    }

    /// How many triangles it is cut into.
    pub(super) fn triangles(&self) -> u64 {
        let n = u64::from(self.inside);
        if self.is_regular() {
            return n * n;
        }
        let edges: u64 = self.edges.into_iter().map(u64::from).sum();
        (n - 3) * (n - 3) + 3 * (n - 3) + edges
    }

    /// The weights of the vertices inside, in order.
    pub(super) fn inner(&self) -> impl Iterator<Item = Vec3> {
        let n = self.inside;
        let share = move |i: u32| i as f32 / n as f32;
        (1..n.saturating_sub(1)).flat_map(move |k| {
            (1..n - k).map(move |j| Vec3::new(share(n - j - k), share(j), share(k)))
        })
    }

    /// Tells the triangles, wound as the whole. `outer` gives the vertices along an edge, both of its ends
    /// among them; those inside are numbered from `first` on.
    pub(super) fn cut(&self, outer: [&[u32]; 3], first: u32, told: &mut impl FnMut([u32; 3])) {
        if self.is_regular() {
            let rows = (0..=self.inside).map(|k| self.whole_row(k, outer, first));
            between_rows(rows, told);
            return;
        }
        let rows = (1..self.inside - 1).map(|k| self.inner_row(k, first));
        between_rows(rows, told);
        let n = self.inside;
        for (edge, outer) in outer.into_iter().enumerate() {
            // Along the edge the inner points are those one step in from it.
            let inner: Vec<u32> = (1..n - 1)
                .map(|t| {
                    let (j, k) = match edge {
                        0 => (t, 1),
                        1 => (n - 1 - t, t),
                        _ => (1, n - 1 - t),
                    };
                    self.inner_vertex(j, k, first)
                })
                .collect();
            strip(outer, &inner, n, told);
        }
    }

    /// The vertex inside with `j` and `k` steps towards corners 1 and 2.
    fn inner_vertex(&self, j: u32, k: u32, first: u32) -> u32 {
        // Row 1 has n − 2 vertices, each next one less.
        let before = (k - 1) * (self.inside - 2) - (k - 1) * k.saturating_sub(2) / 2;
        first + before + j - 1
    }

    fn inner_row(&self, k: u32, first: u32) -> Vec<u32> {
        let row = 1..self.inside - k;
        row.map(|j| self.inner_vertex(j, k, first)).collect()
    }

    /// Row `k` of vertices with those on edges, of a triangle whose edges are alike.
    fn whole_row(&self, k: u32, outer: [&[u32]; 3], first: u32) -> Vec<u32> {
        let n = self.inside;
        if k == 0 {
            return outer[0].to_vec();
        }
        let mut row = vec![outer[2][(n - k) as usize]];
        if k < n {
            if k + 1 < n {
                row.extend(self.inner_row(k, first));
            }
            row.push(outer[1][k as usize]);
        }
        row
    }
}

/// Triangles between rows, each of which has one vertex less than the one before.
fn between_rows(mut rows: impl Iterator<Item = Vec<u32>>, told: &mut impl FnMut([u32; 3])) {
    let Some(mut low) = rows.next() else { return };
    for high in rows {
        for (i, &top) in high.iter().enumerate() {
            told([low[i], low[i + 1], top]);
            if let Some(&next) = high.get(i + 1) {
                told([low[i + 1], next, top]);
            }
        }
        low = high;
    }
}

/// Triangles between an edge and the points one step in from it, which are `1/n` of the edge apart.
fn strip(outer: &[u32], inner: &[u32], n: u32, told: &mut impl FnMut([u32; 3])) {
    let pieces = (outer.len() - 1) as f64;
    let (mut a, mut b) = (0, 0);
    while a + 1 < outer.len() || b + 1 < inner.len() {
        // Whichever side is behind goes on, measured at the middle of its next piece.
        let outer_next = (a as f64 + 0.5) / pieces;
        let inner_next = (b as f64 + 1.5) / f64::from(n);
        if b + 1 == inner.len() || (a + 1 < outer.len() && outer_next <= inner_next) {
            told([outer[a], outer[a + 1], inner[b]]);
            a += 1;
        } else {
            told([outer[a], inner[b + 1], inner[b]]);
            b += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Positions of all vertices in the plane, and the triangles.
    fn cut(edges: [u32; 3]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let lattice = Lattice::new(edges);
        let mut weights = Vec::from(Vec3::AXES);
        let outer: Vec<Vec<u32>> = (0..3)
            .map(|e| {
                let mut ids = vec![e as u32];
                for i in 1..edges[e] {
                    let t = i as f32 / edges[e] as f32;
                    ids.push(weights.len() as u32);
                    weights.push(Vec3::AXES[e] * (1.0 - t) + Vec3::AXES[(e + 1) % 3] * t);
                }
                ids.push((e as u32 + 1) % 3);
                ids
            })
            .collect();
        let first = weights.len() as u32;
        weights.extend(lattice.inner());
        assert_eq!(
            weights.len() as u64 - u64::from(first),
            lattice.inner_vertices()
        );
        let mut triangles = Vec::new();
        lattice.cut([&outer[0], &outer[1], &outer[2]], first, &mut |t| {
            triangles.push(t);
        });
        assert_eq!(triangles.len() as u64, lattice.triangles(), "{edges:?}");
        (weights, triangles)
    }

    /// Every edge inside has two triangles, every piece of an outer edge one, all areas are positive and sum
    /// to the whole.
    #[test]
    fn any_numbers_along_the_edges_make_a_whole() {
        let numbers = [1, 2, 3, 4, 5, 7, 8, 16];
        for a in numbers {
            for b in numbers {
                for c in numbers {
                    let (weights, triangles) = cut([a, b, c]);
                    let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
                    let mut sum = 0.0;
                    for t in &triangles {
                        let [p, q, r] = t.map(|v| weights[v as usize].truncate());
                        let area = (q - p).perp_dot(r - p);
                        assert!(area > 1e-4, "{a} {b} {c}: {t:?} has {area}");
                        sum += area;
                        for i in 0..3 {
                            let (v, w) = (t[i], t[(i + 1) % 3]);
                            *sides.entry([v.min(w), v.max(w)]).or_default() +=
                                if v < w { 1 } else { 1 << 16 };
                        }
                    }
                    assert!((sum - 1.0).abs() < 1e-4, "{a} {b} {c}: {sum}");
                    let once = sides.values().filter(|&&n| n == 1 || n == 1 << 16).count();
                    let twice = sides.values().filter(|&&n| n == (1 << 16) + 1).count();
                    assert_eq!(once as u32, a + b + c);
                    assert_eq!(
                        once + twice,
                        sides.len(),
                        "sides are wound against each other"
                    );
                }
            }
        }
    }
}
