use glam::{DVec3, Vec3};

use super::shape::Shape;

/// Faces in a leaf.
const LEAF: usize = 4;

/// How many faces are looked at between two questions whether to go on.
const FACES_A_QUESTION: usize = 1024;

/// A tree of bounding boxes, each split at the median of its longest axis. Unlike a grid it does
/// not mind a floor of two triangles among ten thousand small ones.
struct Tree {
    nodes: Vec<Node>,
    faces: Vec<u32>,
    /// By face.
    bounds: Vec<Bounds>,
}

#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

struct Node {
    bounds: Bounds,
    /// Of `faces`.
    start: u32,
    end: u32,
    /// The first child follows its parent; this is the second. 0 in a leaf.
    second: u32,
}

/// Calls `found` with all pairs of live faces, the lower first, whose boxes come within the
/// tolerance. `None` if `go_on` says no.
pub(super) fn pairs(
    shape: &Shape,
    go_on: &dyn Fn() -> bool,
    mut found: impl FnMut(usize, usize),
) -> Option<()> {
    let tree = Tree::new(shape);
    let mut stack = Vec::new();
    for face in 0..shape.faces.len() {
        if face % FACES_A_QUESTION == 0 && !go_on() {
            return None;
        }
        if shape.faces[face].is_live {
            tree.overlapping(face, &mut stack, |other| found(face, other));
        }
    }
    Some(())
}

impl Tree {
    fn new(shape: &Shape) -> Self {
        let live = |face: &u32| shape.faces[*face as usize].is_live;
        let mut faces: Vec<u32> = (0..shape.faces.len() as u32).filter(live).collect();
        let bounds: Vec<Bounds> = (0..shape.faces.len())
            .map(|face| Bounds::of(shape, face))
            .collect();
        let mut nodes = Vec::new();
        if !faces.is_empty() {
            build(&bounds, &mut faces, 0, &mut nodes);
        }
        Self {
            nodes,
            faces,
            bounds,
        }
    }

    /// All faces with a higher number whose boxes overlap that of `face`.
    fn overlapping(&self, face: usize, stack: &mut Vec<u32>, mut found: impl FnMut(usize)) {
        let bounds = self.bounds[face];
        stack.push(0);
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            if !node.bounds.overlaps(bounds) {
                continue;
            }
            if node.second != 0 {
                stack.extend([node.second, at + 1]);
                continue;
            }
            for &other in &self.faces[node.start as usize..node.end as usize] {
                let other = other as usize;
                if other > face && self.bounds[other].overlaps(bounds) {
                    found(other);
                }
            }
        }
    }
}

fn build(bounds: &[Bounds], faces: &mut [u32], start: u32, nodes: &mut Vec<Node>) {
    let whole = (faces.iter())
        .map(|&face| bounds[face as usize])
        .fold(Bounds::EMPTY, Bounds::union);
    let at = nodes.len();
    nodes.push(Node {
        bounds: whole,
        start,
        end: start + faces.len() as u32,
        second: 0,
    });
    if faces.len() <= LEAF {
        return;
    }
    let middle = faces.len() / 2;
    let axis = (whole.high - whole.low).max_position();
    let key = |face: &u32| {
        let Bounds { low, high } = bounds[*face as usize];
        0.5 * low[axis] + 0.5 * high[axis]
    };
    faces.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (first, second) = faces.split_at_mut(middle);
    build(bounds, first, start, nodes);
    nodes[at].second = nodes.len() as u32;
    build(bounds, second, start + middle as u32, nodes);
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
    };

    /// A face's box, half the tolerance wider on all sides, and what rounding takes.
    fn of(shape: &Shape, face: usize) -> Self {
        let [a, b, c] = shape.corners(face);
        let margin = DVec3::splat(0.5 * shape.tolerance + shape.snap);
        Self {
            low: (a.min(b).min(c) - margin).as_vec3(),
            high: (a.max(b).max(c) + margin).as_vec3(),
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn overlaps(self, other: Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}
