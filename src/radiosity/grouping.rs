use std::collections::{HashMap, VecDeque};

use glam::Vec3;

use super::validate::ValidScene;

/// Merged triangles may face this far from the first, as a cosine (about 25°).
const MERGE_COSINE: f32 = 0.9;

/// A connected, smooth set of live triangles that makes one element, or one triangle of any size.
pub(super) type Group = Vec<u32>;

/// Joins neighbouring small triangles.
pub(super) struct Merger<'a> {
    areas: &'a [f32],
    normals: &'a [Vec3],
    neighbours: Neighbours,
    /// Triangles that are part of a group already, or not asked about.
    taken: Vec<bool>,
}

impl<'a> Merger<'a> {
    pub(super) fn new(scene: &ValidScene, areas: &'a [f32], normals: &'a [Vec3]) -> Self {
        Self {
            areas,
            normals,
            neighbours: Neighbours::new(scene),
            taken: vec![true; scene.triangles.len()],
        }
    }

    /// Puts `triangles` into groups of about the area `target`, breadth first.
    pub(super) fn groups(&mut self, triangles: &[u32], target: f32) -> Vec<Group> {
        for &t in triangles {
            self.taken[t as usize] = false;
        }
        let mut groups = Vec::new();
        for &seed in triangles {
            if !std::mem::replace(&mut self.taken[seed as usize], true) {
                groups.push(self.group(seed, target));
            }
        }
        groups
    }

    fn group(&mut self, seed: u32, target: f32) -> Group {
        let (areas, normals) = (self.areas, self.normals);
        let mut group = vec![seed];
        let mut filled = areas[seed as usize];
        let mut queue = VecDeque::from([seed]);
        while let Some(t) = queue.pop_front().filter(|_| filled < target) {
            for &other in self.neighbours.of(t) {
                let smooth = normals[other as usize].dot(normals[seed as usize]) > MERGE_COSINE;
                let fits = filled + areas[other as usize] < 1.5 * target;
                if !self.taken[other as usize] && smooth && fits {
                    self.taken[other as usize] = true;
                    filled += areas[other as usize];
                    group.push(other);
                    queue.push_back(other);
                }
            }
        }
        group
    }
}

/// Live triangles of one object across each other's edges, found by position.
struct Neighbours {
    list: Vec<[u32; 3]>,
    count: Vec<u8>,
}

impl Neighbours {
    fn new(scene: &ValidScene) -> Self {
        let mut edges: HashMap<(u32, [u32; 6]), u32> =
            HashMap::with_capacity(scene.triangles.len() * 2);
        let mut list = vec![[0; 3]; scene.triangles.len()];
        let mut count = vec![0_u8; scene.triangles.len()];
        for (t, &key) in scene.triangles.iter().enumerate() {
            let corners = scene.corners(key);
            for k in 0..3 {
                let edge = (key.object, edge_key(corners[k], corners[(k + 1) % 3]));
                // A third triangle on an edge takes the place of the pair: no more neighbours.
                let Some(other) = edges.remove(&edge) else {
                    edges.insert(edge, t as u32);
                    continue;
                };
                for (a, b) in [(t as u32, other), (other, t as u32)] {
                    let slot = &mut count[a as usize];
                    if *slot < 3 {
                        list[a as usize][usize::from(*slot)] = b;
                        *slot += 1;
                    }
                }
            }
        }
        Self { list, count }
    }

    fn of(&self, t: u32) -> &[u32] {
        &self.list[t as usize][..usize::from(self.count[t as usize])]
    }
}

fn edge_key(a: Vec3, b: Vec3) -> [u32; 6] {
    let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let (a, b) = (bits(a), bits(b));
    let ([x0, y0, z0], [x1, y1, z1]) = if a < b { (a, b) } else { (b, a) };
    [x0, y0, z0, x1, y1, z1]
}
