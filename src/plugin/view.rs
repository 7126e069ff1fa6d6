use bevy::prelude::*;
use bevy::shader::Shader;

use super::shaders::FRAGMENT_SHADER;
use crate::radiosity::{BakeSettings, Contribution};

/// What surfaces with [`FrescoMaterial`](super::FrescoMaterial) show in the place of their look: baked light alone, or
/// how it was found.
///
/// For finding faults. Surfaces that carry no baked light and no relief keep their look, and so does what is drawn
/// by the deferred renderer. Another view may ask another part of the light of the bake, which takes no new ray.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_fresco::plugin::FrescoView;
/// fn look_at_light(mut view: ResMut<FrescoView>) {
///     *view = FrescoView::Irradiance;
/// }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Resource, Default, Debug, Clone, PartialEq, Hash)]
pub enum FrescoView {
    /// As they are.
    #[default]
    Shaded,
    /// Baked light, as a white surface would show it.
    Irradiance,
    /// Baked light that surfaces reflect, and what they emit.
    Radiosity,
    /// The direct part of baked light, as a white surface would show it.
    Direct,
    /// The indirect part.
    Indirect,
    /// The elements that light is solved on, each with the light that arrives there. Every other one is a little
    /// darker, to tell them apart.
    Elements,
    /// What chance leaves in the light of each vertex, beside that light: blue for nothing, green for the error asked
    /// for, red for four times as much.
    Error,
    /// Samples of light for each square metre: green for the mean, blue for an eighth of it, red for eight times as
    /// many.
    Samples,
    /// Where the light of vertices is from: grey from samples, yellow from neighbours because the samples lie inside
    /// geometry, red from nowhere.
    Sources,
    /// Normals as they are shaded by, with relief: x, y, z of the world as red, green, blue, 0.5 for 0.
    Normals,
}

impl FrescoView {
    /// All of them, with names to show.
    pub const ALL: [(Self, &'static str); 10] = [
        (Self::Shaded, "Shaded"),
        (Self::Irradiance, "Irradiance"),
        (Self::Radiosity, "Radiosity"),
        (Self::Direct, "Direct light"),
        (Self::Indirect, "Indirect light"),
        (Self::Elements, "Elements"),
        (Self::Error, "Sampling error"),
        (Self::Samples, "Sampling density"),
        (Self::Sources, "Invalid vertices"),
        (Self::Normals, "Normals"),
    ];

    /// Has a bake find what is shown.
    pub(super) fn ask(self, bake: &mut BakeSettings) {
        match self {
            Self::Direct => bake.contribution = Contribution::Direct,
            Self::Indirect => bake.contribution = Contribution::Indirect,
            Self::Error | Self::Samples | Self::Sources => bake.vertex_quality = true,
            Self::Shaded | Self::Irradiance | Self::Radiosity | Self::Elements | Self::Normals => {}
        }
    }

    /// Whether meshes carry something else than their light for it.
    pub(super) fn replaces_light(self) -> bool {
        matches!(
            self,
            Self::Elements | Self::Error | Self::Samples | Self::Sources
        )
    }

    /// Whether meshes carry all of their light with it.
    pub(super) fn keeps_light(self) -> bool {
        !self.replaces_light() && !matches!(self, Self::Direct | Self::Indirect)
    }

    fn shader_def(self) -> Option<&'static str> {
        match self {
            Self::Shaded => None,
            Self::Irradiance | Self::Direct | Self::Indirect | Self::Elements => {
                Some("FRESCO_VIEW_IRRADIANCE")
            }
            Self::Radiosity => Some("FRESCO_VIEW_RADIOSITY"),
            Self::Error | Self::Samples | Self::Sources => Some("FRESCO_VIEW_VALUES"),
            Self::Normals => Some("FRESCO_VIEW_NORMALS"),
        }
    }
}

/// Shows another view: our pipelines are made anew.
pub(super) fn show(view: Res<FrescoView>, mut shaders: ResMut<Assets<Shader>>) {
    let defs: Vec<_> = view.shader_def().into_iter().map(Into::into).collect();
    let Some(shader) = shaders.get(&FRAGMENT_SHADER) else {
        return;
    };
    if shader.shader_defs != defs
        && let Some(mut shader) = shaders.get_mut(&FRAGMENT_SHADER)
    {
        shader.shader_defs = defs;
    }
}
