use std::time::Duration;

use bevy::prelude::*;
use bevy::reflect::reflect_remote;

use crate::radiosity::{BakeSettings, Contribution, FormFactors, Solver};

/// How and when the world's light is baked.
///
/// A change to `bake`, `sky` or `emissive_gain` starts a bake; one to the others does not. Removing the
/// resource stops the plugin: a running bake is cancelled and the light stays as it is.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct RadiositySettings {
    /// Where time is spent. The presets are [`BakeSettings::DRAFT`], [`BakeSettings::BALANCED`] (the
    /// default) and [`BakeSettings::FINAL`].
    #[reflect(remote = BakeSettingsReflect)]
    pub bake: BakeSettings,
    /// Radiance of the sky in cd/m², the same in all directions that no static mesh blocks.
    ///
    /// An ambient light (`GlobalAmbientLight`) whose `affects_lightmapped_meshes` is false is added
    /// to it: Bevy then leaves it out of lit meshes, and the bake puts it in with its shadows.
    pub sky: LinearRgba,
    /// cd/m² of an emissive surface whose `emissive` is 1, for the part that Bevy shows without the
    /// camera's exposure (`emissive_exposure_weight` below 1).
    ///
    /// 1 / exposure lets a surface light the room as brightly as it looks. The default is that of
    /// Bevy's default camera, `1.2 · 2^9.7` ≈ 998; for another, `1.0 / exposure.exposure()`.
    pub emissive_gain: f32,
    /// Whether a change in the world starts a bake.
    pub automatic: bool,
    /// A bake starts when nothing has changed for this long,
    pub debounce: Duration,
    /// or, if changes go on, this long after the first.
    pub max_delay: Duration,
    /// A bake that takes longer is cancelled and counts as failed; `None` for no limit.
    pub time_budget: Option<Duration>,
    /// What the main thread may spend a frame on putting new light into meshes. One mesh a
    /// frame is always done.
    pub apply_budget: Duration,
    /// Threads of a bake; `None` for all cores but one.
    pub threads: Option<usize>,
}

impl Default for RadiositySettings {
    fn default() -> Self {
        Self {
            bake: BakeSettings::BALANCED,
            sky: LinearRgba::NONE,
            emissive_gain: 1.0 / bevy::camera::Exposure::default().exposure(),
            automatic: true,
            debounce: Duration::from_millis(50),
            max_delay: Duration::from_millis(250),
            time_budget: None,
            apply_budget: Duration::from_micros(300),
            threads: None,
        }
    }
}

/// What reflection sees of [`BakeSettings`].
#[reflect_remote(BakeSettings)]
#[derive(Clone, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct BakeSettingsReflect {
    pub max_edge: Option<f32>,
    pub refine: bool,
    pub error: f32,
    pub max_vertices: u32,
    pub max_seconds: Option<f32>,
    pub elements: u32,
    pub adapt: bool,
    #[reflect(remote = FormFactorsReflect)]
    pub form_factors: FormFactors,
    pub element_rays: u32,
    pub gather_rays: u32,
    pub samples_per_vertex: f32,
    pub emitter_rays: u32,
    pub sample_emitters: bool,
    #[reflect(remote = ContributionReflect)]
    pub contribution: Contribution,
    pub directional: bool,
    pub vertex_quality: bool,
    #[reflect(remote = SolverReflect)]
    pub solver: Solver,
    pub solver_tolerance: f32,
    pub max_sweeps: u32,
    pub max_reflectance: f32,
    pub max_memory: u64,
    pub seed: u32,
}

/// What reflection sees of [`FormFactors`].
#[reflect_remote(FormFactors)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum FormFactorsReflect {
    #[default]
    HitList,
    Hemicube {
        resolution: u32,
    },
    Analytic {
        visibility_rays: u32,
    },
    AreaSampling {
        samples: u32,
    },
}

/// What reflection sees of [`Contribution`].
#[reflect_remote(Contribution)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum ContributionReflect {
    #[default]
    All,
    Direct,
    Indirect,
}

/// What reflection sees of [`Solver`].
#[reflect_remote(Solver)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum SolverReflect {
    #[default]
    GaussSeidelMeanField,
    GaussSeidel,
    Jacobi,
    Sor {
        omega: f32,
    },
    ProgressiveRefinement,
    ConjugateGradients,
}
