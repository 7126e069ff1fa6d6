use glam::Vec3;

use super::refined::RefinedMesh;

/// A mesh that is refined together with others.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    pub positions: &'a [Vec3],
    pub triangles: &'a [[u32; 3]],
    /// Whether its triangles may be cut at all.
    pub refine: bool,
}

/// Several meshes refined together by longest-edge bisection.
#[derive(Clone, Debug)]
pub struct Conforming {}

/// One bisection that was done: `face` keeps its number and became the half with the corners
/// before the cut; `half` is the new face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bisection {
    pub face: u32,
    pub half: u32,
    /// Which edge was cut, by its corners in `face` as it was: `edge` and `(edge + 1) % 3`.
    /// In `face` the corner `(edge + 1) % 3` is replaced by the midpoint, in `half` the corner `edge`.
    pub edge: u8,
}

/// What became of a request to bisect a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bisected {
    /// It was cut, with what conformity asks for.
    Done,
    /// It, or a neighbour that would have to be cut with it, may not be cut, or has edges below the limit.
    Refused,
    /// There would be too many vertices. Nothing was done.
    Full,
}

/// Where a vertex of a refined part comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A vertex of the part as given.
    Given(u32),
    /// The midpoint of two vertices of the refined part, both with lower numbers.
    Midpoint([u32; 2]),
}

/// One part, refined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    pub mesh: RefinedMesh,
    /// Of each vertex.
    pub origins: Vec<Origin>,
}
