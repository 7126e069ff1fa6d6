/// Which sides of faces are at the same edge: those form a ring, of one side or two or many
/// (K. Weiler, "Edge-based data structures for solid modeling in curved-surface environments",
/// IEEE Computer Graphics and Applications 5, 1985).
///
/// Side `i` of a face goes from its corner `i` to the next, and has the number `3 · face + i`.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeRings {
    /// Of each side.
    next: Vec<u32>,
}

impl EdgeRings {
    /// Adds the three sides of a face, each a ring of its own.
    pub(super) fn push_face(&mut self) {
        let first = self.next.len() as u32;
        self.next.extend([first, first + 1, first + 2]);
    }

    /// The sides at the same edge, from `side` on.
    pub(super) fn ring(&self, side: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(side), move |&at| {
            Some(self.next[at as usize]).filter(|&next| next != side)
        })
    }

    /// Makes rings of the sides with the same edge, whatever rings they were in.
    pub(super) fn link<Edge: Ord>(&mut self, sides: &mut [(Edge, u32)]) {
        sides.sort_unstable();
        for ring in sides.chunk_by(|a, b| a.0 == b.0) {
            let mut before = ring[ring.len() - 1].1;
            for &(_, side) in ring {
                self.next[before as usize] = side;
                before = side;
            }
        }
    }

    /// Puts the side `to` in the place of `from`.
    pub(super) fn replace(&mut self, from: u32, to: u32) {
        let before = self.ring(from).last().unwrap_or(from);
        let after = self.next[from as usize];
        self.next[before as usize] = to;
        self.next[to as usize] = if after == from { to } else { after };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(rings: &EdgeRings, side: u32) -> Vec<u32> {
        rings.ring(side).collect()
    }

    #[test]
    fn sides_at_one_edge_are_a_ring() {
        let mut rings = EdgeRings::default();
        (0..4).for_each(|_| rings.push_face());
        rings.link(&mut [('b', 3), ('a', 7), ('b', 1), ('b', 10), ('c', 0), ('a', 2)]);
        assert_eq!(ring(&rings, 3), [3, 10, 1]);
        assert_eq!(ring(&rings, 2), [2, 7]);
        assert_eq!([ring(&rings, 0), ring(&rings, 5)], [[0], [5]]);
    }

    #[test]
    fn a_side_takes_the_place_of_another() {
        let mut rings = EdgeRings::default();
        (0..3).for_each(|_| rings.push_face());
        rings.link(&mut [(0, 0), (0, 3), (0, 6)]);
        rings.replace(3, 8);
        assert_eq!(ring(&rings, 0), [0, 8, 6]);
        rings.replace(1, 7);
        assert_eq!(ring(&rings, 7), [7]);
    }
}
