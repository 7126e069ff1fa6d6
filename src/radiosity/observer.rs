use super::baked::Bake;
use super::partial::PartialLight;

/// A step of a [`bake`](super::bake), in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Surfaces are cut along the lines where they touch or cross, if vertices are to be placed by the
    /// light.
    Contacts,
    /// Long edges are split; surfaces are cut and merged into elements.
    Mesh,
    /// The ray-tracing hierarchy over the input triangles is built; how much of the view each
    /// emissive material fills is measured with it.
    Occlusion,
    /// The light of a quarter of the elements is found, to place elements and rays by it.
    FirstLook,
    /// Rays from every element find the rows of the form-factor matrix.
    FormFactors,
    /// Lights and emitters are sampled from every element.
    Direct,
    /// The radiosity system is solved.
    Solve,
    /// A few elements are asked again, to tell how large the sampling error is.
    Error,
    /// Meshes get vertices where the light needs them, if asked.
    Refine,
    /// Irradiance is gathered inside the mesh's triangles.
    Gather,
    /// Light of lights and emitters is sampled inside the mesh's triangles, with its shadows.
    Shadows,
    /// Vertex values are fitted to the gathered irradiance.
    Fit,
    /// A picture of the result is drawn: not part of a bake, see [`preview`](super::preview).
    Preview,
}

impl Stage {
    /// All stages of a bake, in the order they run.
    pub const ALL: [Self; 12] = [
        Self::Contacts,
        Self::Mesh,
        Self::Occlusion,
        Self::FirstLook,
        Self::FormFactors,
        Self::Direct,
        Self::Solve,
        Self::Error,
        Self::Refine,
        Self::Gather,
        Self::Shadows,
        Self::Fit,
    ];

    /// A short name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contacts => "contacts",
            Self::Mesh => "mesh",
            Self::Occlusion => "occlusion",
            Self::FirstLook => "first look",
            Self::FormFactors => "form factors",
            Self::Direct => "direct light",
            Self::Solve => "solve",
            Self::Error => "sampling error",
            Self::Refine => "refine",
            Self::Gather => "gather",
            Self::Shadows => "shadows",
            Self::Fit => "fit vertices",
            Self::Preview => "preview",
        }
    }
}

/// Watches a [`bake`](super::bake) and can stop it.
///
/// Called from several threads at once. `()` watches nothing and never stops.
pub trait Observer: Sync {
    /// `done`, 0..=1, of `stage` is finished. Called at least with 0 and with 1 for each stage.
    fn progress(&self, stage: Stage, done: f32) {
        let _ = (stage, done);
    }

    /// Light while it is being solved for: at the start, after each sweep, and with
    /// [progressive refinement](super::Solver::ProgressiveRefinement) after 1, 2, 4, 8… shots and
    /// then eight times a sweep. The solver waits; looking costs something only if one looks.
    fn partial(&self, light: &PartialLight) {
        let _ = light;
    }

    /// A result, while a better one is looked for: a bake that refines its meshes gives a coarse one
    /// first. The last one is what the bake returns, and is not told here.
    fn so_far(&self, bake: &Bake) {
        let _ = bake;
    }

    /// Asked often (every few milliseconds); `true` ends the bake with
    /// [`BakeError::Cancelled`](super::BakeError::Cancelled).
    fn cancelled(&self) -> bool {
        false
    }
}

impl Observer for () {}
