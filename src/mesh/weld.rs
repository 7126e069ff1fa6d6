use std::collections::HashMap;

use glam::{DVec3, Vec3};

/// End of a list of classes.
const NONE: u32 = u32::MAX;

/// Vertices grouped by where they are, whatever mesh they belong to.
///
/// Hard edges and texture seams give one point of a surface several vertices; light is the same
/// for all of them, and a class is how a baker sees them as one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PositionClasses {
    /// The class of each vertex, in the order the positions came.
    pub class: Vec<u32>,
    /// The position of each class: that of its lowest vertex.
    pub representative: Vec<Vec3>,
}

impl PositionClasses {
    /// Groups vertices that are at most `tolerance` metres apart.
    ///
    /// Taken in their order, each vertex joins the first class whose representative it is within
    /// `tolerance` of, or else founds one. So no vertex is further than that from its
    /// representative, and a fine mesh does not melt into one class neighbour by neighbour; the
    /// price is that two vertices just within `tolerance` may part where a third lies between.
    ///
    /// With a tolerance of 0 positions have to be equal (0.0 and -0.0 are). Positions must not be
    /// NaN. Takes time linear in the number of vertices.
    ///
    /// # Panics
    ///
    /// If there are 2³² − 1 vertices or more.
    pub fn new(positions: impl IntoIterator<Item = Vec3>, tolerance: f32) -> Self {
        let positions = positions.into_iter();
        if tolerance > 0.0 {
            Self::within(positions, f64::from(tolerance))
        } else {
            Self::equal(positions)
        }
    }

    fn equal(positions: impl Iterator<Item = Vec3>) -> Self {
        let mut classes = Self::default();
        let mut known = HashMap::new();
        for position in positions {
            // Adding zero turns -0.0 into 0.0 and leaves everything else alone.
            let bits = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            let class = *known.entry(bits).or_insert_with(|| classes.found(position));
            classes.class.push(class);
        }
        classes
    }

    fn within(positions: impl Iterator<Item = Vec3>, tolerance: f64) -> Self {
        let mut classes = Self::default();
        let mut grid = Grid::new(tolerance);
        for position in positions {
            let class = grid
                .find(position, &classes.representative)
                .unwrap_or_else(|| {
                    let class = classes.found(position);
                    grid.insert(position);
                    class
                });
            classes.class.push(class);
        }
        classes
    }

    fn found(&mut self, position: Vec3) -> u32 {
        let class = self.representative.len();
        assert!(
            class < NONE as usize,
            "too many vertices for 32-bit classes"
        );
        self.representative.push(position);
        class as u32
    }
}

/// Cubic cells, each with the list of the classes whose representatives lie in it.
struct Grid {
    tolerance: f64,
    cell: f64,
    /// The class last added to each cell.
    heads: HashMap<[u64; 3], u32>,
    /// The class added before it, by class.
    next: Vec<u32>,
}

impl Grid {
    fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            // Four tolerances wide: a ball of that radius touches one or two cells an axis, on
            // average 3.4 in all. Representatives keep their distance, so a cell holds few.
            cell: 4.0 * tolerance,
            heads: HashMap::new(),
            next: Vec::new(),
        }
    }

    /// The lowest class whose representative is within the tolerance.
    fn find(&self, position: Vec3, representatives: &[Vec3]) -> Option<u32> {
        let at = position.as_dvec3();
        let low = self.cell_of(at - self.tolerance);
        let high = self.cell_of(at + self.tolerance);
        let mut best = NONE;
        for corner in 0..8 {
            let pick = [corner & 1, corner >> 1 & 1, corner >> 2];
            if (0..3).any(|axis| pick[axis] == 1 && low[axis] == high[axis]) {
                continue;
            }
            let key = [0, 1, 2].map(|axis| [low, high][pick[axis]][axis]);
            let mut class = self.heads.get(&key).copied().unwrap_or(NONE);
            while class != NONE {
                let distance = representatives[class as usize].as_dvec3().distance(at);
                if distance <= self.tolerance {
                    best = best.min(class);
                }
                class = self.next[class as usize];
            }
        }
        (best != NONE).then_some(best)
    }

    /// Adds the next class, which is represented by `position`.
    fn insert(&mut self, position: Vec3) {
        let key = self.cell_of(position.as_dvec3());
        let class = self.next.len() as u32;
        self.next
            .push(self.heads.insert(key, class).unwrap_or(NONE));
    }

    /// The cell as bits of whole floats, which reach further than integers do.
    fn cell_of(&self, position: DVec3) -> [u64; 3] {
        ((position / self.cell).floor() + DVec3::ZERO)
            .to_array()
            .map(f64::to_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::random;

    fn classes(positions: &[Vec3], tolerance: f32) -> Vec<u32> {
        PositionClasses::new(positions.iter().copied(), tolerance).class
    }

    #[test]
    fn zero_tolerance_means_equal() {
        let next = f32::from_bits(1.0_f32.to_bits() + 1);
        let positions = [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(1.0, -0.0, 0.0),
            Vec3::new(next, 0.0, 0.0),
            Vec3::new(1.0, 0.0, -0.0),
        ];
        assert_eq!(classes(&positions, 0.0), [0, 0, 1, 0]);
    }

    #[test]
    fn points_on_both_sides_of_a_cell_wall_meet() {
        // Cell walls are at whole multiples of 0.5 for this tolerance, zero among them.
        for wall in [-1.0, -0.5, 0.0, 0.5, 1.0, 1000.0] {
            for sides in 0..8 {
                let offset = Vec3::from([0, 1, 2].map(|axis| {
                    let side = if sides >> axis & 1 == 1 { 1.0 } else { -1.0 };
                    side * 0.03
                }));
                let centre = Vec3::splat(wall);
                let positions = [centre - offset, centre + offset];
                assert_eq!(classes(&positions, 0.125), [0, 0], "{centre} {offset}");
            }
        }
    }

    #[test]
    fn the_lowest_vertex_represents_and_chains_stop() {
        let positions = [0.0, 0.08, 0.16, 0.09].map(|x| Vec3::new(x, 0.0, 0.0));
        let welded = PositionClasses::new(positions, 0.1);
        assert_eq!(welded.class, [0, 0, 1, 0]);
        assert_eq!(welded.representative, [positions[0], positions[2]]);
    }

    #[test]
    fn agrees_with_comparing_all_pairs() {
        let tolerance = 0.07;
        let mut random = random(7);
        let positions: Vec<Vec3> = (0..1500)
            .map(|_| Vec3::new(random(), random(), random()))
            .collect();
        let mut representatives: Vec<Vec3> = Vec::new();
        let expected: Vec<u32> = positions
            .iter()
            .map(|p| {
                let near = |r: &Vec3| r.as_dvec3().distance(p.as_dvec3()) <= f64::from(tolerance);
                let found = representatives.iter().position(near);
                found.unwrap_or_else(|| {
                    representatives.push(*p);
                    representatives.len() - 1
                }) as u32
            })
            .collect();
        assert_eq!(classes(&positions, tolerance), expected);
        assert!(representatives.len() < 1400 && representatives.len() > 100);
    }

    #[test]
    fn a_million_vertices_take_linear_time() {
        let side = 500;
        let grid = |i: usize| Vec3::new((i % side) as f32, (i / side) as f32, 3.0) * 0.01;
        let jitter = Vec3::splat(2e-6);
        let positions = (0..4 * side * side).map(|i| grid(i / 4) + jitter * (i % 2) as f32);
        let start = std::time::Instant::now();
        let welded = PositionClasses::new(positions, 1e-5);
        assert_eq!(welded.representative.len(), side * side);
        assert_eq!(welded.class.len(), 1_000_000);
        // Comparing all pairs would take hours.
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }
}
