use std::collections::{HashMap, VecDeque};

use glam::Vec3;

use super::validate::ValidScene;

/// Merged triangles may face this far from the first, as a cosine (about 25°).
const MERGE_COSINE: f32 = 0.9;

/// A group of less than this share of an element's area joins another, if it can.
const SLIVER: f32 = 0.5;

/// Slivers join groups that face this far from them at most, as a cosine (60°): on a surface with
/// bumps smaller than an element they would be most of all elements.
const SLIVER_COSINE: f32 = 0.5;

/// Times that slivers look for a group to join, as they grow by others joining them.
const ROUNDS: u32 = 3;

/// A connected, smooth set of live triangles that makes one element, or one triangle of any size.
pub(super) type Group = Vec<u32>;

/// Joins neighbouring small triangles.
pub(super) struct Merger<'a> {
    areas: &'a [f32],
    normals: &'a [Vec3],
    neighbours: Neighbours,
    /// Triangles that are part of a group already, or not asked about.
    taken: Vec<bool>,
    /// The group that each triangle asked about is in.
    group_of: Vec<u32>,
}

/// In no group.
const NONE: u32 = u32::MAX;

impl<'a> Merger<'a> {
    pub(super) fn new(scene: &ValidScene, areas: &'a [f32], normals: &'a [Vec3]) -> Self {
        Self {
            areas,
            normals,
            neighbours: Neighbours::new(scene),
            taken: vec![true; scene.triangles.len()],
            group_of: vec![NONE; scene.triangles.len()],
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

    /// The same, with slivers joined to groups beside them.
    pub(super) fn whole_groups(&mut self, triangles: &[u32], target: f32) -> Vec<Group> {
        let mut groups = self.groups(triangles, target);
        for (g, group) in (0..).zip(&groups) {
            for &t in group {
                self.group_of[t as usize] = g;
            }
        }
        let mut sums: Vec<Facing> = groups.iter().map(|g| self.facing(g)).collect();
        for _ in 0..ROUNDS {
            for g in 0..groups.len() {
                let sliver = !groups[g].is_empty() && sums[g].area < SLIVER * target;
                let joins = || self.beside(&groups[g], &sums, 1.5 * target);
                if let Some(to) = sliver.then(joins).flatten() {
                    let moved = std::mem::take(&mut groups[g]);
                    for &t in &moved {
                        self.group_of[t as usize] = to as u32;
                    }
                    groups[to].extend(moved);
                    let sum = sums[g];
                    sums[to].area += sum.area;
                    sums[to].normal += sum.normal;
                }
            }
        }
        for &t in triangles {
            self.group_of[t as usize] = NONE;
        }
        groups.retain(|group| !group.is_empty());
        groups
    }

    /// The group beside a sliver that faces most as it does.
    fn beside(&self, group: &[u32], sums: &[Facing], most: f32) -> Option<usize> {
        let own = self.group_of[group[0] as usize] as usize;
        let across = group.iter().flat_map(|&t| self.neighbours.of(t));
        let others = across.map(|&t| self.group_of[t as usize] as usize);
        let cosine = |g: usize| {
            let (a, b) = (sums[own].normal, sums[g].normal);
            a.normalize_or_zero().dot(b.normalize_or_zero())
        };
        others
            .filter(|&g| g != own && g != NONE as usize && sums[own].area + sums[g].area < most)
            .map(|g| (g, cosine(g)))
            .filter(|&(_, cosine)| cosine > SLIVER_COSINE)
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            .map(|(g, _)| g)
    }

    fn facing(&self, group: &[u32]) -> Facing {
        let mut sum = Facing::default();
        for &t in group {
            sum.area += self.areas[t as usize];
            sum.normal += self.normals[t as usize] * self.areas[t as usize];
        }
        sum
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

/// Area of a group, and the sum of its normals times area.
#[derive(Clone, Copy, Debug, Default)]
struct Facing {
    area: f32,
    normal: Vec3,
}

/// Live triangles of one object across each other's edges, found by position.
struct Neighbours {
    list: Vec<[u32; 3]>,
    count: Vec<u8>,
}

impl Neighbours {
    fn new(scene: &ValidScene) -> Self {
        let mut edges: HashMap<(u32, [End; 2]), u32> =
            HashMap::with_capacity(scene.triangles.len() * 2);
        let mut list = vec![[0; 3]; scene.triangles.len()];
        let mut count = vec![0_u8; scene.triangles.len()];
        for (t, &key) in scene.triangles.iter().enumerate() {
            let (corners, sides) = (scene.corners(key), scene.sides(key));
            for k in 0..3 {
                let ends = [k, (k + 1) % 3];
                let edge = (key.object, edge_key(ends.map(|k| (corners[k], sides[k]))));
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

/// Position, and the side of a line of contact: light on one side is not that on the other.
type End = ([u32; 3], u32);

fn edge_key(ends: [(Vec3, u32); 2]) -> [End; 2] {
    let mut ends = ends.map(|(p, side)| ((p + Vec3::ZERO).to_array().map(f32::to_bits), side));
    ends.sort_unstable();
    ends
}
