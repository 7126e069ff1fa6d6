use std::f32::consts::PI;

use super::DisplacementError;
use crate::height_map::Kernel;

/// How a surface is raised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplacementSettings {
    /// Metres that a height of 1 stands out. Negative digs. Limits: finite.
    pub scale: f32,
    /// The height that stays where it is: 0 raises all, 0.5 raises what is brighter than the middle and
    /// lowers what is darker. Limits: finite.
    pub mid_level: f32,
    /// How heights and slopes are found between texels.
    pub kernel: Kernel,
    /// Which way is out.
    pub direction: Direction,
    /// Where vertices are put.
    pub tessellation: Tessellation,
    /// Triangles of the result at most, all parts together; those of the base are kept in any case.
    pub max_triangles: u32,
    /// Bytes of the result at most, as [`result_bytes`] counts them; the base's are kept in any case.
    pub max_bytes: u64,
    /// Normals of the base that differ by no more than this angle, in radians, are one smooth surface where
    /// vertices meet; beyond it the edge is hard. Limits: 0 to π.
    pub crease_angle: f32,
    /// Whether heights are kept below where the surface would fold through itself.
    pub clamp_folds: bool,
}

/// Which way a surface is raised. Whatever it is, one place has one direction, and between the corners of a
/// triangle directions change linearly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Along the mean of the normals around: round things stay round. Edges of boxes are raised less than
    /// their sides, because the mean leans.
    #[default]
    Smooth,
    /// By the height along the normal of every face: at edges the direction is the mitre, longer than one,
    /// so that a box raised evenly is a larger box. At edges sharper than 60° mitres stop at twice the
    /// height.
    FaceNormal,
}

/// Where vertices are put.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tessellation {
    /// Those of the base and no more.
    Base,
    /// Evenly, this far apart. If there is no room for so many they are further apart all over.
    Uniform(Spacing),
    /// Where the relief asks for them: faces are bisected while the raised surface is further from them than
    /// this many metres. If there is no room, the largest errors are mended first. Limits: finite, above 0.
    Adaptive {
        /// The largest distance from the surface to the mesh that is asked for, in metres.
        tolerance: f32,
    },
}

/// How far apart evenly placed vertices are. Limits: finite, above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// In texels of the map, along `u` or `v`, whichever changes more. One is the resolution of the map.
    Texels(f32),
    /// In metres on the base.
    Metres(f32),
}

impl Default for DisplacementSettings {
    /// One vertex a texel; heights of 0 stay, those of 1 stand out by 5 cm.
    fn default() -> Self {
        Self {
            scale: 0.05,
            mid_level: 0.0,
            kernel: Kernel::default(),
            direction: Direction::default(),
            tessellation: Tessellation::Uniform(Spacing::Texels(1.0)),
            max_triangles: 20_000_000,
            max_bytes: 2 << 30,
            crease_angle: PI / 6.0,
            clamp_folds: false,
        }
    }
}

impl DisplacementSettings {
    pub(super) fn check(&self) -> Result<(), DisplacementError> {
        let wrong = |what, value, limits| {
            Err(DisplacementError::Setting {
                what,
                value,
                limits,
            })
        };
        let above_zero = |value: f32| value.is_finite() && value > 0.0;
        if !self.scale.is_finite() {
            return wrong("scale", self.scale, "finite");
        }
        if !self.mid_level.is_finite() {
            return wrong("mid-level", self.mid_level, "finite");
        }
        if !(0.0..=PI).contains(&self.crease_angle) {
            return wrong("crease angle", self.crease_angle, "0 to π");
        }
        match self.tessellation {
            Tessellation::Uniform(Spacing::Texels(s) | Spacing::Metres(s)) if !above_zero(s) => {
                wrong("spacing", s, "finite and above 0")
            }
            Tessellation::Adaptive { tolerance } if !above_zero(tolerance) => {
                wrong("tolerance", tolerance, "finite and above 0")
            }
            _ => Ok(()),
        }
    }

    pub(super) fn budget(&self) -> Budget {
        Budget {
            triangles: u64::from(self.max_triangles.min(MOST_TRIANGLES)),
            bytes: self.max_bytes,
        }
    }
}

/// Sides of triangles are numbered with 32 bits.
const MOST_TRIANGLES: u32 = u32::MAX / 3;

/// Room for a result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub(super) triangles: u64,
    pub(super) bytes: u64,
}

/// What a displaced mesh takes in memory: 40 bytes a vertex (position, normal, where on the base it is) and
/// 16 a triangle (three indices, which triangle of the base it was).
pub const fn result_bytes(vertices: u64, triangles: u64) -> u64 {
    40 * vertices + 16 * triangles
}
