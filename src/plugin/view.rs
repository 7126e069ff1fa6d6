use bevy::prelude::*;

use super::FrescoMaterial;
use crate::radiosity::{BakeSettings, Contribution};

/// What surfaces with [`FrescoMaterial`] show in the place of their look: baked light alone, or
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

    fn shown_instead(self) -> ShownInstead {
        match self {
            Self::Shaded => ShownInstead::Nothing,
            Self::Irradiance | Self::Direct | Self::Indirect | Self::Elements => {
                ShownInstead::Irradiance
            }
            Self::Radiosity => ShownInstead::Radiosity,
            Self::Error | Self::Samples | Self::Sources => ShownInstead::Values,
            Self::Normals => ShownInstead::Normals,
        }
    }
}

/// What a material shows in the place of its look. [`FrescoView`] sets it on all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShownInstead {
    /// Its look.
    #[default]
    Nothing,
    /// Baked light.
    Irradiance,
    /// What is reflected of it, and emitted.
    Radiosity,
    /// What meshes carry in the place of light, as it is.
    Values,
    /// Normals as colours.
    Normals,
    /// Normals as they are, and roughness as alpha: for tests.
    RawNormals,
    /// Shifts of texture coordinates by parallax, depth, and as alpha texels read: for tests.
    RawParallax,
}

impl ShownInstead {
    pub(super) fn shader_def(self) -> Option<&'static str> {
        match self {
            Self::Nothing => None,
            Self::Irradiance => Some("FRESCO_SHOW_IRRADIANCE"),
            Self::Radiosity => Some("FRESCO_SHOW_RADIOSITY"),
            Self::Values => Some("FRESCO_SHOW_VALUES"),
            Self::Normals => Some("FRESCO_SHOW_NORMALS"),
            Self::RawNormals => Some("FRESCO_SHOW_RAW_NORMALS"),
            Self::RawParallax => Some("FRESCO_SHOW_RAW_PARALLAX"),
        }
    }
}

/// Whether materials may show something else than the view says.
pub(super) fn may_differ(view: Res<FrescoView>) -> bool {
    view.is_changed() || *view != FrescoView::Shaded
}

/// Has all materials show what the view says.
pub(super) fn show(view: Res<FrescoView>, mut materials: ResMut<Assets<FrescoMaterial>>) {
    let instead = view.shown_instead();
    let others = (materials.iter()).filter(|(_, material)| material.extension.instead != instead);
    let others: Vec<_> = others.map(|(id, _)| id).collect();
    for id in others {
        if let Some(mut material) = materials.get_mut(id) {
            material.extension.instead = instead;
        }
    }
}
