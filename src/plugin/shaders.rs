//! The shaders of the material, and the one that is made from Bevy's.
//!
//! Where the shader definition `LIGHTMAP` is set, Bevy's lighting code adds the light of a lightmap
//! and leaves out what a light, a probe or the ambient light says it must not add to it; its
//! material code reads the texture, which must then be bound. Binding one to every lit entity would
//! cost a bind group for every few of them, needs a second UV set and cannot be had on skinned and
//! morphed meshes at all. So the lighting code is taken from a copy of Bevy's text in which that
//! definition has another name, and light from vertices goes where that of a texture would.
//! The copy is made when the app starts, from the text that Bevy brings: it cannot fall behind it.

use bevy::asset::uuid_handle;
use bevy::prelude::*;
use bevy::shader::Shader;

/// Passes baked light on, beside all that Bevy's vertex shaders do.
pub(super) const VERTEX_SHADER: Handle<Shader> =
    uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a01");
/// Puts baked light where Bevy expects that of a lightmap.
pub(super) const FRAGMENT_SHADER: Handle<Shader> =
    uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a02");
/// Bevy's `pbr_functions`, in which [`BAKED_LIGHT`] stands for `LIGHTMAP`.
const PBR_FUNCTIONS: Handle<Shader> = uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a03");

/// The shader definition under which surfaces are lit as lightmapped ones.
pub(super) const BAKED_LIGHT: &str = "FRESCO_BAKED_LIGHT";

/// Where Bevy keeps the text that [`PBR_FUNCTIONS`] is made from.
const SOURCE: &str = "embedded://bevy_pbr/render/pbr_functions.wgsl";

/// Keeps Bevy's text loaded until the copy is made.
#[derive(Resource, Debug)]
struct Source(Handle<Shader>);

/// Adds the shaders. Without a renderer there is nothing to add.
pub(super) fn plugin(app: &mut App) {
    let Some(mut shaders) = app.world_mut().get_resource_mut::<Assets<Shader>>() else {
        return;
    };
    for (handle, name, text) in [
        (VERTEX_SHADER, "vertex.wgsl", include_str!("vertex.wgsl")),
        (
            FRAGMENT_SHADER,
            "fragment.wgsl",
            include_str!("fragment.wgsl"),
        ),
    ] {
        let shader = Shader::from_wgsl(text, format!("bevy_fresco/plugin/{name}"));
        if let Err(error) = shaders.insert(handle.id(), shader) {
            error!("the shader {name} could not be added: {error}");
        }
    }
    let source = app.world().resource::<AssetServer>().load(SOURCE);
    app.insert_resource(Source(source));
    app.add_systems(
        PreUpdate,
        copy_bevys_lighting_code.run_if(resource_exists::<Source>),
    );
}

/// Waits for Bevy's text and copies it. Pipelines that import the copy wait for it by themselves.
fn copy_bevys_lighting_code(
    mut commands: Commands,
    source: Res<Source>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    let Some(bevys) = shaders.get(&source.0) else {
        return;
    };
    commands.remove_resource::<Source>();
    let Some(text) = lit_by_vertices(bevys.source.as_str()) else {
        error!("{SOURCE} is not as bevy_fresco knows it: baked light cannot be shown");
        return;
    };
    let shader = Shader::from_wgsl(text, "bevy_fresco/plugin/pbr_functions.wgsl");
    if let Err(error) = shaders.insert(PBR_FUNCTIONS.id(), shader) {
        error!("the lighting code of bevy_fresco could not be added: {error}");
    }
}

/// The module under our name, with `LIGHTMAP` renamed; `None` if either is not found.
fn lit_by_vertices(text: &str) -> Option<String> {
    let renamed = format!("#ifdef {BAKED_LIGHT}\n");
    let edits = [
        (
            "#define_import_path bevy_pbr::pbr_functions\n",
            "#define_import_path bevy_fresco::pbr_functions\n",
        ),
        ("#ifdef LIGHTMAP\n", &*renamed),
    ];
    edits
        .into_iter()
        .try_fold(text.to_owned(), |text, (from, to)| {
            text.contains(from).then(|| text.replace(from, to))
        })
}

#[cfg(test)]
mod tests {
    use super::lit_by_vertices;

    #[test]
    fn only_two_names_change() {
        let bevys = "#define_import_path bevy_pbr::pbr_functions\n\
                     #ifdef LIGHTMAP\nx = lightmap_light;\n#endif\n#ifdef LIGHTMAP_BICUBIC\n";
        assert_eq!(
            lit_by_vertices(bevys).as_deref(),
            Some(
                "#define_import_path bevy_fresco::pbr_functions\n\
                 #ifdef FRESCO_BAKED_LIGHT\nx = lightmap_light;\n#endif\n#ifdef LIGHTMAP_BICUBIC\n"
            )
        );
        assert_eq!(lit_by_vertices("something else"), None);
    }
}
