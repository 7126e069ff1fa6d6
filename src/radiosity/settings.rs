use super::contribution::Contribution;
use super::form_factor::FormFactors;
use super::solve::Solver;

/// How a bake is done: where it spends its time and what it stores.
///
/// Start from a preset and change what you need:
///
/// ```
/// use bevy_fresco::radiosity::BakeSettings;
///
/// let settings = BakeSettings {
///     max_edge: Some(0.5),
///     gather_rays: 512,
///     ..BakeSettings::FINAL
/// };
/// # assert!(settings.element_rays > BakeSettings::DRAFT.element_rays);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Splits mesh edges longer than this, in metres, before baking; `None` keeps the vertices
    /// as given. Limit: > 0.
    pub max_edge: Option<f32>,
    /// Puts vertices where the light needs them, until [`error`](Self::error) is met, instead of
    /// keeping those given. [`Object::refine`](super::Object::refine) says so for each object.
    pub refine: bool,
    /// The error asked for: relative RMSE of the vertex light, 0.02 for 2 %; where light is more than
    /// four times the mean, beside the light there. With [`refine`](Self::refine) the bake goes on until
    /// its own estimate is below. Limit: 0.001..=1.
    pub error: f32,
    /// Vertices of the result, all objects together, at most; those given are kept in any case.
    pub max_vertices: u32,
    /// Stops looking for less error after this many seconds, with the best result so far.
    /// Limit: > 0.
    pub max_seconds: Option<f32>,
    /// How many elements the indirect light is solved on, roughly. Surfaces are cut or merged to
    /// an even size to come near it. Limit: 1..=4,000,000.
    pub elements: u32,
    /// Places elements and rays by the light, after a first look with a quarter of them. Without it
    /// all elements have one size and cast as many rays.
    pub adapt: bool,
    /// How form factors between elements are found.
    pub form_factors: FormFactors,
    /// Rays a row of the hit list, the default [`FormFactors`]. Error of an element ≈ 3 % · (64 / rays)^0.7.
    /// Limit: 1..=4096.
    pub element_rays: u32,
    /// Rays that gather indirect light at each sample inside the mesh's triangles.
    /// Limit: 1..=4096.
    pub gather_rays: u32,
    /// Samples a mesh vertex, on average: where irradiance is measured inside the triangles.
    /// Limit: > 0.
    pub samples_per_vertex: f32,
    /// Shadow rays from a point to the emissive surfaces, all together. Limit: 1..=4096.
    pub emitter_rays: u32,
    /// Whether emissive surfaces are sampled, as they should: small ones by light trees and shadow
    /// rays. Without it lamps are left to be found by form factors and gathering rays, the way of
    /// the first radiosity programs, which takes a hundred times as many for the same error.
    pub sample_emitters: bool,
    /// Which part of the light goes into vertices.
    pub contribution: Contribution,
    /// Whether each vertex also gets the [gradient](super::ObjectLight::gradient) of its light, so that
    /// bumps can be shaded by it. Takes 10 to 20 % more time, the same rays, and 12 bytes a vertex.
    pub directional: bool,
    /// Whether each vertex also gets its [quality](super::ObjectLight::quality): how sure its light is. Takes four
    /// more fits, and 12 bytes a vertex.
    pub vertex_quality: bool,
    /// How the linear system is solved.
    pub solver: Solver,
    /// The solver stops when the residual's bound on the error, relative to the mean, is below this.
    /// Limit: > 0.
    pub solver_tolerance: f32,
    /// The solver stops after this many sweeps, and the report says that it did not converge.
    pub max_sweeps: u32,
    /// Reflectance is clamped to this, so that light dies out. Limit: 0..1, 1 excluded.
    pub max_reflectance: f32,
    /// A bake that would need more bytes than this is refused before it starts.
    pub max_memory: u64,
    /// Another seed, another noise pattern.
    pub seed: u32,
}

impl BakeSettings {
    /// For looking while working: within 6 %, or 3.6 % on the Cornell box with 1,839 given
    /// vertices.
    pub const DRAFT: Self = Self {
        max_edge: None,
        refine: true,
        error: 0.06,
        max_vertices: 30_000,
        max_seconds: None,
        elements: 4_000,
        adapt: true,
        form_factors: FormFactors::HitList,
        element_rays: 32,
        gather_rays: 24,
        samples_per_vertex: 6.0,
        emitter_rays: 8,
        sample_emitters: true,
        contribution: Contribution::All,
        directional: false,
        vertex_quality: false,
        solver: Solver::GaussSeidelMeanField,
        solver_tolerance: 1e-2,
        max_sweeps: 100,
        max_reflectance: 0.99,
        max_memory: 8 << 30,
        seed: 0,
    };

    /// The default: within 3 %, or 2.7 % on that box.
    pub const BALANCED: Self = Self {
        error: 0.03,
        max_vertices: 100_000,
        elements: 8_000,
        element_rays: 48,
        gather_rays: 64,
        samples_per_vertex: 10.0,
        emitter_rays: 24,
        solver_tolerance: 1e-3,
        ..Self::DRAFT
    };

    /// For shipping: within 1.5 %, or 2.4 % on that box, where 2.2 % is the least its vertices can
    /// carry.
    pub const FINAL: Self = Self {
        error: 0.015,
        max_vertices: 300_000,
        elements: 16_000,
        element_rays: 128,
        gather_rays: 256,
        samples_per_vertex: 24.0,
        emitter_rays: 64,
        solver_tolerance: 1e-4,
        ..Self::BALANCED
    };
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self::BALANCED
    }
}

/// A setting outside its limits.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{setting} is {value}, outside its limits: {limits}")]
pub struct InvalidSetting {
    /// Name of the field.
    pub setting: &'static str,
    /// What it was.
    pub value: f32,
    /// What it may be.
    pub limits: &'static str,
}

impl BakeSettings {
    /// Whether the light of elements is solved for the same way.
    pub(crate) fn same_solution(&self, other: &Self) -> bool {
        let same = Self {
            contribution: other.contribution,
            vertex_quality: other.vertex_quality,
            ..self.clone()
        };
        same == *other
    }

    /// Rays from each element; none where form factors are not made of rays.
    pub(crate) fn rays_of_element(&self) -> u32 {
        match self.form_factors {
            FormFactors::HitList => self.element_rays,
            _ => 0,
        }
    }

    /// Checks the limits that the fields document.
    pub(crate) fn check(&self) -> Result<(), InvalidSetting> {
        let check = |setting, value: f32, ok: bool, limits| {
            if ok {
                Ok(())
            } else {
                Err(InvalidSetting {
                    setting,
                    value,
                    limits,
                })
            }
        };
        let rays = |setting, value: u32| {
            check(
                setting,
                value as f32,
                (1..=4096).contains(&value),
                "1 to 4096",
            )
        };
        rays("element_rays", self.element_rays)?;
        rays("gather_rays", self.gather_rays)?;
        rays("emitter_rays", self.emitter_rays)?;
        let elements = (1..=4_000_000).contains(&self.elements);
        check("elements", self.elements as f32, elements, "1 to 4,000,000")?;
        match self.form_factors {
            FormFactors::HitList => {}
            FormFactors::Hemicube { resolution } => check(
                "resolution of the hemicube",
                resolution as f32,
                (16..=512).contains(&resolution) && resolution.is_multiple_of(2),
                "an even number, 16 to 512",
            )?,
            FormFactors::Analytic { visibility_rays } => check(
                "visibility_rays",
                visibility_rays as f32,
                (1..=16384).contains(&visibility_rays),
                "1 to 16,384",
            )?,
            FormFactors::AreaSampling { samples } => check(
                "samples of area sampling",
                samples as f32,
                (1..=16384).contains(&samples),
                "1 to 16,384",
            )?,
        }
        if let Solver::Sor { omega } = self.solver {
            let ok = omega > 0.0 && omega < 2.0;
            check("omega", omega, ok, "above 0, below 2")?;
        }
        let samples = self.samples_per_vertex;
        check(
            "samples_per_vertex",
            samples,
            samples > 0.0 && samples <= 1e4,
            "above 0, up to 10,000",
        )?;
        let tolerance = self.solver_tolerance;
        check(
            "solver_tolerance",
            tolerance,
            tolerance > 0.0 && tolerance.is_finite(),
            "above 0",
        )?;
        let brightest = self.max_reflectance;
        check(
            "max_reflectance",
            brightest,
            (0.0..1.0).contains(&brightest),
            "0 up to, not including, 1",
        )?;
        let edge = self.max_edge.unwrap_or(1.0);
        check(
            "max_edge",
            edge,
            edge > 0.0 && edge.is_finite(),
            "above 0 metres",
        )
    }
}
