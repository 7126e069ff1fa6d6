//! What reflection sees of the core's settings.

use bevy::prelude::*;
use bevy::reflect::reflect_remote;

use crate::displacement::{Direction, DisplacementSettings, Spacing, Tessellation};
use crate::height_map::Kernel;

/// What reflection sees of [`DisplacementSettings`].
#[reflect_remote(DisplacementSettings)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct DisplacementSettingsReflect {
    pub scale: f32,
    pub mid_level: f32,
    #[reflect(remote = KernelReflect)]
    pub kernel: Kernel,
    #[reflect(remote = DirectionReflect)]
    pub direction: Direction,
    #[reflect(remote = TessellationReflect)]
    pub tessellation: Tessellation,
    pub max_triangles: u32,
    pub max_bytes: u64,
    pub crease_angle: f32,
    pub clamp_folds: bool,
}

/// What reflection sees of [`Kernel`].
#[reflect_remote(Kernel)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum KernelReflect {
    Bilinear,
    Forward,
    Central,
    HalfCentral,
    BSpline,
    #[default]
    CatmullRom,
}

/// What reflection sees of [`Direction`].
#[reflect_remote(Direction)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum DirectionReflect {
    #[default]
    Smooth,
    FaceNormal,
}

/// What reflection sees of [`Tessellation`].
#[reflect_remote(Tessellation)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
pub enum TessellationReflect {
    Base,
    Uniform(#[reflect(remote = SpacingReflect)] Spacing),
    Adaptive { tolerance: f32 },
}

/// What reflection sees of [`Spacing`].
#[reflect_remote(Spacing)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
pub enum SpacingReflect {
    Texels(f32),
    Metres(f32),
}
