use glam::Vec2;

use super::{DisplacementError, DisplacementSettings};
use crate::height_map::{HeightMap, Kernel, Relief};

/// A map as heights in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heights<'a> {
    pub(super) map: &'a HeightMap,
    pub(super) kernel: Kernel,
    pub(super) scale: f32,
    pub(super) mid_level: f32,
}

/// Positions this large are still told apart by normals and lengths.
const HIGHEST: f32 = 1e15;

impl<'a> Heights<'a> {
    pub(super) fn new(
        map: &'a HeightMap,
        settings: &DisplacementSettings,
    ) -> Result<Self, DisplacementError> {
        let heights = Self {
            map,
            kernel: settings.kernel,
            scale: settings.scale,
            mid_level: settings.mid_level,
        };
        let height = heights.highest();
        match height <= HIGHEST {
            true => Ok(heights),
            false => Err(DisplacementError::TooHigh {
                scale: settings.scale,
                height,
            }),
        }
    }

    /// The largest distance from the base that a texel asks for.
    fn highest(&self) -> f32 {
        let metres = |h: &f32| (self.scale * (h - self.mid_level)).abs();
        let heights = self.map.heights().iter().map(metres);
        // What is no number counts as higher than all.
        heights.fold(0.0, |highest, h| if h <= highest { highest } else { h })
    }

    /// From the lowest texel to the highest, in metres.
    pub(super) fn range(&self) -> f32 {
        let heights = || self.map.heights().iter().copied();
        let (low, high) = (
            heights().fold(f32::INFINITY, f32::min),
            heights().fold(f32::NEG_INFINITY, f32::max),
        );
        self.scale.abs() * (high - low)
    }

    /// Height in metres.
    pub(super) fn height(&self, uv: Vec2) -> f32 {
        self.scale * (self.map.height(uv, self.kernel) - self.mid_level)
    }

    /// Height and slopes, in metres and metres by texture coordinate.
    pub(super) fn at(&self, uv: Vec2) -> Relief {
        let relief = self.map.at(uv, self.kernel);
        Relief {
            height: self.scale * (relief.height - self.mid_level),
            slopes: self.scale * relief.slopes,
        }
    }
}
