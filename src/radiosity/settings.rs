/// How a bake is done: where it spends its time and what it stores.
///
/// Start from a preset and change what you need:
///
/// ```
/// use bevy_fresco::radiosity::{BakeSettings, DirectLight};
///
/// let settings = BakeSettings {
///     max_edge: Some(0.5),
///     direct: DirectLight::Realtime,
///     ..BakeSettings::FINAL
/// };
/// # assert!(settings.element_rays > BakeSettings::DRAFT.element_rays);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Splits mesh edges longer than this, in metres, before baking; `None` keeps the vertices
    /// as given. Limit: > 0.
    pub max_edge: Option<f32>,
    /// How many elements the indirect light is solved on, roughly. Surfaces are cut or merged to
    /// an even size to come near it. Limit: 1..=4,000,000.
    pub elements: u32,
    /// Rays a row of the form-factor matrix. Error of an element ≈ 3 % · (64 / rays)^0.7.
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
    /// The solver stops when the residual's bound on the error, relative to the mean, is below this.
    /// Limit: > 0.
    pub solver_tolerance: f32,
    /// The solver stops after this many sweeps, and the report says that it did not converge.
    pub max_sweeps: u32,
    /// Reflectance is clamped to this, so that light dies out. Limit: 0..1, 1 excluded.
    pub max_reflectance: f32,
    /// Whether direct light of [`Light`](super::Light)s goes into the result.
    pub direct: DirectLight,
    /// Another seed, another noise pattern.
    pub seed: u32,
}

/// Whether the direct light of point, spot and directional lights is part of the baked light.
///
/// Light of emissive surfaces and of the sky, and all that bounces, is baked either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectLight {
    /// Direct and indirect light are baked; the engine must not light these surfaces again.
    #[default]
    Baked,
    /// Only bounced light is baked; the engine adds direct light and shadows in real time.
    Realtime,
}

impl BakeSettings {
    /// For looking while working: about 5 % error on the Cornell box.
    pub const DRAFT: Self = Self {
        max_edge: None,
        elements: 1_000,
        element_rays: 32,
        gather_rays: 16,
        samples_per_vertex: 4.0,
        emitter_rays: 4,
        solver_tolerance: 1e-2,
        max_sweeps: 100,
        max_reflectance: 0.99,
        direct: DirectLight::Baked,
        seed: 0,
    };

    /// The default.
    pub const BALANCED: Self = Self {
        elements: 2_000,
        element_rays: 128,
        gather_rays: 64,
        samples_per_vertex: 8.0,
        emitter_rays: 16,
        solver_tolerance: 1e-3,
        ..Self::DRAFT
    };

    /// For shipping.
    pub const FINAL: Self = Self {
        elements: 8_000,
        element_rays: 256,
        gather_rays: 256,
        samples_per_vertex: 16.0,
        emitter_rays: 32,
        solver_tolerance: 1e-4,
        ..Self::BALANCED
    };
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self::BALANCED
    }
}
