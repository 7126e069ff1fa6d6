use glam::Vec3;

/// What became of a displacement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplacementReport {
    /// Of all parts together.
    pub vertices: u64,
    /// Of all parts together.
    pub triangles: u64,
    /// What they take in memory, as [`result_bytes`](super::result_bytes) counts it.
    pub bytes: u64,
    /// What ended it.
    pub stop: Stop,
    /// Of adaptive tessellation: the largest distance found from the raised surface to the mesh, in metres.
    pub error: Option<f32>,
    /// Of uniform tessellation: the share of the density asked for that there was room for, 1 for all of it.
    pub density: Option<f64>,
    /// The largest difference of heights at one place, in metres: where charts meet that the map does not
    /// fit, and the mean was taken.
    pub seam_gap: f32,
    /// Vertices at which the surface folds through itself.
    pub folded: u64,
    /// Vertices whose height was kept below folding.
    pub clamped: u64,
    /// Triangles of the base that have no area.
    pub zero_area: u64,
    /// Normals of the base that had no direction, and were made from faces.
    pub mended_normals: u64,
    /// Places whose normals cancel out, so that they stay where they are.
    pub undirected: u64,
    /// What all positions lie in.
    pub bounds: Bounds,
}

/// What ended a displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// It has what was asked for.
    #[default]
    Reached,
    /// There are as many triangles as there may be.
    Triangles,
    /// The result takes as much memory as it may.
    Memory,
    /// Faces are as small as they get, a sixteenth of a texel, and some are still off by more than was asked.
    Finest,
}

/// A box along the axes. Empty by default, its corners at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinates, in metres.
    pub min: Vec3,
    /// The largest.
    pub max: Vec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
        }
    }
}

impl Bounds {
    /// The smallest box with all of `points` in it.
    pub fn of(points: &[Vec3]) -> Self {
        let with = |all: Self, &p: &Vec3| all.with(Self { min: p, max: p });
        points.iter().fold(Self::default(), with)
    }

    /// The smallest box with both in it.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }
}
