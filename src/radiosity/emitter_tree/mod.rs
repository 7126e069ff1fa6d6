//! The emissive triangles that are worth sampling.
//!
//! | file | what it does |
//! |---|---|
//! | here | which triangles they are, the tree over them, what a change leaves of it |
//! | `survey` | which emissive materials fill too much of the view to be sampled |
//! | `choice` | one of many picked by what it may send to a receiver |

mod choice;
mod survey;

use std::ops::Range;

use glam::{Vec2, Vec3, Vec3A};

use super::bounds::{Disturbed, Sphere};
use super::element::{ElementId, Elements};
use super::emitter::Receiver;
use super::facet::Facet;
use super::glare::Glare;
use super::observer::Observer;
use super::occlusion::Occluders;
use super::parallel::Cancelled;
use super::settings::BakeSettings;
use super::triangle::{area, face_normal};
use super::validate::ValidScene;
pub(crate) use choice::Choices;
use survey::survey;

/// The emissive triangles that are worth sampling, in a tree that picks one by what it may send to
/// a receiver (Conty and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
/// Splitting").
pub(crate) struct EmitterTree {
    nodes: Vec<Node>,
    pub(crate) leaves: Vec<Leaf>,
    /// First leaf of each source: of each live triangle where emission is sampled, of each element
    /// where reflected light is.
    first_leaf: Vec<Option<u32>>,
}

#[derive(Clone, Copy)]
pub(crate) struct Leaf {
    pub(crate) triangle: u32,
    pub(crate) corners: [Vec3; 3],
    pub(crate) normal: Vec3,
    pub(crate) area: f32,
    pub(crate) two_sided: bool,
    /// Live triangle or element that shines.
    pub(crate) source: u32,
    /// Object that shines, or element.
    lamp: u32,
    /// How bright it is beside others, and whether everywhere.
    pub(crate) radiance: f32,
    pub(crate) even: bool,
    /// Position in the tree.
    node: u32,
}

#[derive(Clone, Copy)]
struct Node {
    center: Vec3,
    radius: f32,
    /// Mean normal, and the cosine and sine of the cone around it that holds all normals; −1 for any.
    axis: Vec3,
    cone: Vec2,
    /// Luminous power, relative.
    power: f32,
    /// A leaf, or the two halves.
    content: Content,
    parent: u32,
}

#[derive(Clone, Copy)]
enum Content {
    Leaf(u32),
    Children(u32, u32),
}

/// Above this share of all rays a material's emitters are left to be found by rays.
pub(crate) const WIDE: f32 = 0.1;

/// Up to so many leaves are taken one by one, in closed form: that costs each receiver time for every
/// leaf, where drawing one by what it may send costs the tree's depth.
const FEW: usize = 16;

/// The share of the glare that known elements must have to be good enough.
const COVERED: f64 = 0.8;

/// So many elements that glare at most, the worst.
const MOST_GLARING: usize = 4096;

impl EmitterTree {
    /// Builds the tree over the emitters that are worth sampling.
    pub(crate) fn new(
        scene: &ValidScene,
        elements: &Elements,
        occluders: &Occluders,
        settings: &BakeSettings,
        observer: &dyn Observer,
    ) -> Result<Self, Cancelled> {
        let mut leaves: Vec<Leaf> = Vec::new();
        let mut powers = Vec::new();
        if settings.sample_emitters && elements.emissive_triangles().next().is_some() {
            let views = survey(scene, elements, occluders, settings.seed, observer)?;
            for (t, two_sided) in elements.emissive_triangles() {
                let key = scene.triangles[t as usize];
                let material = scene.objects[key.object as usize].material.0 as usize;
                if views[material] > WIDE {
                    continue;
                }
                let leaf = Leaf::new(scene, elements, t, two_sided);
                powers.push(leaf.area * leaf.radiance);
                leaves.push(leaf);
            }
        }
        Ok(Self::over(leaves, &powers, scene.triangles.len()))
    }

    /// Builds the tree over elements that would make bright specks, were they left to rays.
    pub(crate) fn glaring(
        scene: &ValidScene,
        elements: &Elements,
        reflected: &[Vec3A],
        glare: &Glare,
    ) -> Self {
        let excess = |e: &u32| glare.excess(ElementId(*e));
        let mut glaring: Vec<u32> = (0..elements.len() as u32)
            .filter(|e| excess(e) > 0.0)
            .collect();
        if glaring.len() > MOST_GLARING {
            glaring.sort_by(|a, b| excess(b).total_cmp(&excess(a)).then(a.cmp(b)));
            glaring.truncate(MOST_GLARING);
        }
        let mut leaves = Vec::new();
        let mut powers = Vec::new();
        for e in glaring {
            for (triangle, corners, normal) in elements.shape(scene, ElementId(e)) {
                let radiance = reflected[e as usize].element_sum();
                powers.push(area(corners) * radiance);
                leaves.push(Leaf {
                    triangle,
                    corners,
                    normal,
                    area: area(corners),
                    two_sided: false,
                    source: e,
                    lamp: e,
                    radiance,
                    even: true,
                    node: 0,
                });
            }
        }
        Self::over(leaves, &powers, elements.len())
    }

    /// Builds the tree; leaves of one source follow each other.
    fn over(leaves: Vec<Leaf>, powers: &[f32], sources: usize) -> Self {
        let mut first_leaf = vec![None; sources];
        for (i, leaf) in leaves.iter().enumerate() {
            first_leaf[leaf.source as usize].get_or_insert(i as u32);
        }
        let mut tree = Self {
            nodes: Vec::new(),
            leaves,
            first_leaf,
        };
        let mut order: Vec<u32> = (0..tree.leaves.len() as u32).collect();
        if !order.is_empty() {
            tree.build(&mut order, powers, u32::MAX);
        }
        tree
    }

    /// The same tree over live triangles and sources of other numbers, `sources` in all.
    pub(crate) fn renumbered(
        &self,
        triangles: &[u32],
        sources_new: &[u32],
        sources: usize,
    ) -> Self {
        let leaves = self.leaves.iter().map(|leaf| Leaf {
            triangle: triangles[leaf.triangle as usize],
            source: sources_new[leaf.source as usize],
            ..*leaf
        });
        let leaves: Vec<Leaf> = leaves.collect();
        let mut first_leaf = vec![None; sources];
        for (i, leaf) in leaves.iter().enumerate() {
            first_leaf[leaf.source as usize].get_or_insert(i as u32);
        }
        Self {
            nodes: self.nodes.clone(),
            leaves,
            first_leaf,
        }
    }

    /// Whether the elements of a tree made by [`Self::glaring`] still have most of the glare.
    pub(crate) fn covers(&self, elements: &Elements, glare: &Glare) -> bool {
        let (mut all, mut covered) = (0.0_f64, 0.0_f64);
        for (e, area) in elements.iter_area().enumerate() {
            let excess = f64::from(glare.excess(ElementId(e as u32))) * area;
            all += excess;
            covered += f64::from(u8::from(self.first_leaf[e].is_some())) * excess;
        }
        covered >= COVERED * all
    }

    /// Whether it is over the elements that `old` was over, whose numbers now are `now`.
    pub(crate) fn same_leaves_as(&self, old: &Self, now: &[u32]) -> bool {
        self.leaves.len() == old.leaves.len()
            && (self.leaves.iter().zip(&old.leaves))
                .all(|(a, b)| a.source == now[b.source as usize] && a.corners == b.corners)
            && (self.nodes.iter().zip(&old.nodes)).all(|(a, b)| a.power == b.power)
    }

    /// Whether light from any emitter to any point of a sphere may be disturbed.
    pub(crate) fn disturbed(&self, disturbed: &Disturbed, to: Sphere) -> bool {
        !self.nodes.is_empty() && !disturbed.is_empty() && self.node_disturbed(disturbed, to, 0, 0)
    }

    /// Looks into a node as long as it is worth it.
    fn node_disturbed(&self, disturbed: &Disturbed, to: Sphere, node: u32, depth: u32) -> bool {
        let node = &self.nodes[node as usize];
        let from = Sphere {
            center: node.center,
            radius: node.radius,
        };
        disturbed.between(to, from)
            && match node.content {
                Content::Children(left, right) if depth < 5 => {
                    self.node_disturbed(disturbed, to, left, depth + 1)
                        || self.node_disturbed(disturbed, to, right, depth + 1)
                }
                _ => true,
            }
    }

    pub(crate) fn bytes(&self) -> u64 {
        (self.nodes.len() * size_of::<Node>()
            + self.leaves.len() * size_of::<Leaf>()
            + self.first_leaf.len() * 8) as u64
    }

    /// The leaf of a source on a live triangle.
    pub(crate) fn leaf(&self, source: u32, triangle: u32) -> Option<u32> {
        let first = self.first_leaf[source as usize]?;
        let leaves = self.leaves[first as usize..]
            .iter()
            .take_while(|l| l.source == source);
        leaves
            .zip(first..)
            .find(|(l, _)| l.triangle == triangle)
            .map(|(_, i)| i)
    }

    /// Whether the leaves are few enough to be taken one by one.
    pub(crate) fn few(&self) -> bool {
        self.leaves.len() <= FEW
    }

    /// Number of emissive triangles that are sampled.
    pub(crate) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Splits at the median centroid along the longest axis; returns the node's index.
    fn build(&mut self, order: &mut [u32], powers: &[f32], parent: u32) -> u32 {
        let index = self.nodes.len() as u32;
        let mut node = self.bound(order, powers);
        node.parent = parent;
        self.nodes.push(node);
        if let [leaf] = *order {
            self.leaves[leaf as usize].node = index;
            self.nodes[index as usize].content = Content::Leaf(leaf);
            return index;
        }
        let leaves = &self.leaves;
        let centroid = |l: &u32| leaves[*l as usize].centroid();
        let (low, high) = order
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), l| {
                (lo.min(centroid(l)), hi.max(centroid(l)))
            });
        let axis = (high - low).max_position();
        order.sort_by(|a, b| {
            centroid(a)[axis]
                .total_cmp(&centroid(b)[axis])
                .then(a.cmp(b))
        });
        let (left, right) = order.split_at_mut(order.len() / 2);
        let left = self.build(left, powers, index);
        let right = self.build(right, powers, index);
        self.nodes[index as usize].content = Content::Children(left, right);
        index
    }

    fn bound(&self, order: &[u32], powers: &[f32]) -> Node {
        let members = || order.iter().map(|&l| &self.leaves[l as usize]);
        let (low, high) = members()
            .flat_map(|l| l.corners)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p), hi.max(p))
            });
        let center = 0.5 * (low + high);
        let radius = members()
            .flat_map(|l| l.corners)
            .map(|p| p.distance(center))
            .fold(0.0, f32::max);
        let axis = members()
            .map(|l| l.normal * l.area)
            .sum::<Vec3>()
            .normalize_or_zero();
        let any_way = axis == Vec3::ZERO || members().any(|l| l.two_sided);
        let cosine = members().map(|l| l.normal.dot(axis)).fold(1.0, f32::min);
        let cosine = if any_way { -1.0 } else { cosine };
        Node {
            center,
            radius,
            axis,
            cone: Vec2::new(cosine, (1.0 - cosine * cosine).max(0.0).sqrt()),
            power: order.iter().map(|&l| powers[l as usize]).sum(),
            content: Content::Leaf(0),
            parent: u32::MAX,
        }
    }
}

impl Leaf {
    fn new(scene: &ValidScene, elements: &Elements, triangle: u32, two_sided: bool) -> Self {
        let corners = scene.corners(scene.triangles[triangle as usize]);
        let brightness = |side: Range<u32>| {
            let elements_of = || side.clone().map(|e| e as usize);
            let power = elements_of().map(|e| elements.emission[e] * elements.area[e]);
            let area: f32 = elements_of().map(|e| elements.area[e]).sum();
            power.sum::<Vec3>().element_sum() / area.max(f32::MIN_POSITIVE)
        };
        Self {
            triangle,
            corners,
            normal: face_normal(corners),
            area: area(corners),
            two_sided,
            source: triangle,
            lamp: scene.triangles[triangle as usize].object,
            radiance: (elements.sides_of_triangle(triangle))
                .map(brightness)
                .fold(0.0, f32::max),
            even: elements.shines_evenly(triangle),
            node: 0,
        }
    }

    fn centroid(&self) -> Vec3 {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }

    /// Whether it and another are parts of one lamp, and equally bright but for rounding.
    pub(crate) fn is_one_lamp_with(&self, other: &Self) -> bool {
        let close = (self.radiance - other.radiance).abs() <= 1e-3 * self.radiance;
        self.lamp == other.lamp && self.even && other.even && close
    }

    /// What a receiver sees of it.
    pub(crate) fn seen_from(&self, receiver: &Receiver) -> Option<Facet> {
        let [p, q, r] = self.corners;
        let front = self.normal.dot(receiver.position - p) > 0.0;
        if self.triangle == receiver.triangle {
            None
        } else if front {
            Facet::new(receiver, [p, q, r], self.normal)
        } else if self.two_sided {
            Facet::new(receiver, [p, r, q], -self.normal)
        } else {
            None
        }
    }

    /// Weights of the second and third corner at a point of the triangle.
    pub(crate) fn uv(&self, point: Vec3) -> [f32; 2] {
        let [p, q, r] = self.corners;
        let (along, across, to) = (q - p, r - p, point - p);
        let area = along.cross(across);
        let share = |part: Vec3| part.dot(area) / area.length_squared();
        [share(to.cross(across)), share(along.cross(to))]
    }
}
