use glam::Vec2;

use super::{Content, EmitterTree, Node};
use crate::radiosity::emitter::Receiver;

impl EmitterTree {
    /// Walks down the tree by `u`.
    fn choose(&self, receiver: &Receiver, mut u: f32) -> Option<Chosen> {
        let (mut index, mut probability) = (0, 1.0);
        loop {
            let (left, right) = match self.nodes[index as usize].content {
                Content::Leaf(leaf) => {
                    return Some(Chosen {
                        leaf,
                        probability,
                        u,
                    });
                }
                Content::Children(left, right) => (left, right),
            };
            let share = self.left_share(receiver, left, right)?;
            if u < share {
                (index, probability, u) = (left, probability * share, u / share);
            } else {
                (index, probability, u) = (
                    right,
                    probability * (1.0 - share),
                    (u - share) / (1.0 - share),
                );
            }
        }
    }

    /// The probability with which [`Self::choose`] finds a leaf.
    pub(crate) fn probability(&self, receiver: &Receiver, leaf: u32) -> f32 {
        let mut index = self.leaves[leaf as usize].node;
        let mut probability = 1.0;
        while self.nodes[index as usize].parent != u32::MAX {
            let parent = self.nodes[index as usize].parent;
            let Content::Children(left, right) = self.nodes[parent as usize].content else {
                return 0.0;
            };
            let Some(share) = self.left_share(receiver, left, right) else {
                return 0.0;
            };
            probability *= if index == left { share } else { 1.0 - share };
            index = parent;
        }
        probability
    }

    fn left_share(&self, receiver: &Receiver, left: u32, right: u32) -> Option<f32> {
        let [l, r] = [left, right].map(|n| self.nodes[n as usize].importance(receiver));
        (l + r > 0.0).then(|| l / (l + r))
    }
}

/// A leaf that was chosen.
pub(crate) struct Chosen {
    pub(crate) leaf: u32,
    /// With which it was.
    pub(crate) probability: f32,
    /// What is left of the number that chose it: uniform again.
    pub(crate) u: f32,
}

/// How one receiver chooses among the emitters: the same distribution for all its samples.
pub(crate) enum Choices {
    /// Few emitters: all leaves with a chance, each with the sum of probabilities up to it and its
    /// own. Finds the same leaf as walking down the tree would, at a fraction of the cost.
    Table(Vec<(u32, f32, f32)>),
    /// Many: walk down the tree each time.
    Walk,
}

/// Up to so many emitters a table is cheaper than walking.
const TABLE: usize = 128;

impl Choices {
    pub(crate) fn new(tree: &EmitterTree, receiver: &Receiver) -> Self {
        if tree.leaves.len() > TABLE {
            return Self::Walk;
        }
        let mut table = Vec::with_capacity(tree.leaves.len());
        // A tree of one leaf has no choice to make, but may still be out of sight.
        if tree.nodes[0].importance(receiver) > 0.0 {
            Self::fill(tree, receiver, 0, 1.0, &mut table);
        }
        Self::Table(table)
    }

    fn fill(
        tree: &EmitterTree,
        receiver: &Receiver,
        node: u32,
        probability: f32,
        table: &mut Vec<(u32, f32, f32)>,
    ) {
        match tree.nodes[node as usize].content {
            Content::Leaf(leaf) => {
                let before = table.last().map_or(0.0, |entry| entry.1);
                table.push((leaf, before + probability, probability));
            }
            Content::Children(left, right) => {
                let Some(share) = tree.left_share(receiver, left, right) else {
                    return;
                };
                for (child, share) in [(left, share), (right, 1.0 - share)] {
                    if share > 0.0 {
                        Self::fill(tree, receiver, child, probability * share, table);
                    }
                }
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        matches!(self, Self::Table(table) if table.is_empty())
    }

    /// The leaf that `u`, 0..1, falls on.
    pub(crate) fn choose(&self, tree: &EmitterTree, receiver: &Receiver, u: f32) -> Option<Chosen> {
        match self {
            Self::Walk => tree.choose(receiver, u),
            Self::Table(table) => {
                // Parts of the tree that cannot be seen leave the sum below 1: their share is dark.
                let &(leaf, end, probability) = table.iter().find(|entry| u < entry.1)?;
                let u = 1.0 - (end - u) / probability;
                Some(Chosen {
                    leaf,
                    probability,
                    u,
                })
            }
        }
    }
}

impl Node {
    /// An estimate, zero only where it is sure, of the light a node can send to a receiver: its power over
    /// `d²`, times the largest cosines there can be at either end.
    ///
    /// Each of these is `cos max(0, θ − α)`, of an angle `θ` to the middle of the node and the half angle
    /// `α` of what lies around it: the sphere that holds the node, seen under `sin α = r / d`, and at its own
    /// end the cone of its normals as well. A walk down the tree asks often, so that all is kept as multiples
    /// of `d` and one division ends it.
    fn importance(&self, receiver: &Receiver) -> f32 {
        let to = self.center - receiver.position;
        let (square, radius) = (to.length_squared(), self.radius);
        // Of the half angle under which the node is seen: cosine and sine, times d.
        let rest = square - radius * radius;
        if rest <= 0.0 {
            return self.power / (radius * radius).max(f32::MIN_POSITIVE);
        }
        let spread = Vec2::new(rest.sqrt(), radius);
        let receives = cosine_minus(receiver.normal.dot(to), spread, square);
        // Of the sum of both angles.
        let both = spread.rotate(self.cone);
        let sends = if self.cone.x <= -1.0 || both.y < 0.0 {
            square
        } else {
            cosine_minus(-self.axis.dot(to), both, square)
        };
        let inverse = 1.0 / square;
        self.power * (receives.max(0.0) * inverse) * (sends.max(0.0) * inverse) * inverse
    }
}

/// `d² cos max(0, θ − α)`, from `d cos θ`, `d` times the cosine and sine of `α`, and `d²`; both angles in 0..π.
fn cosine_minus(cosine: f32, angle: Vec2, square: f32) -> f32 {
    if cosine >= angle.x {
        return square;
    }
    let sine = (square - cosine * cosine).max(0.0).sqrt();
    cosine * angle.x + sine * angle.y
}
