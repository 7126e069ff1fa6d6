//! The shaders of the material, and the one that is made from Bevy's.
//!
//! Where the shader definition `LIGHTMAP` is set, Bevy's lighting code adds the light of a lightmap
//! and leaves out what a light, a probe or the ambient light says it must not add to it; its
//! material code reads the texture, which must then be bound. Binding one to every lit entity would
//! cost a bind group for every few of them, needs a second UV set and cannot be had on skinned and
//! morphed meshes at all. So the lighting code is taken from a copy of Bevy's text in which that
//! definition has another name, and light from vertices goes where that of a texture would.
//! The copy is made when the app starts, from the text that Bevy brings: it cannot fall behind it.

use std::borrow::Cow;

use bevy::asset::uuid_handle;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::shader::{Shader, load_shader_library};

/// Passes our attributes on, beside all that Bevy's vertex shaders do.
pub(super) const VERTEX_SHADER: Handle<Shader> =
    uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a01");
/// Perturbs normals, and puts baked light where Bevy expects that of a lightmap.
pub(super) const FRAGMENT_SHADER: Handle<Shader> =
    uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a02");
/// Perturbs normals in the pass that writes them.
pub(super) const PREPASS_SHADER: Handle<Shader> =
    uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a04");
/// Bevy's `pbr_functions`, in which [`BAKED_LIGHT`] stands for `LIGHTMAP`.
const PBR_FUNCTIONS: Handle<Shader> = uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a03");

/// The shader definition under which surfaces are lit as lightmapped ones.
pub(super) const BAKED_LIGHT: &str = "FRESCO_BAKED_LIGHT";

/// The shader definition under which baked light answers to bumps, in both stages.
pub(super) const GRADIENT: &str = "VERTEX_BAKED_LIGHT_GRADIENT";

/// Where Bevy keeps the text that [`PBR_FUNCTIONS`] is made from.
const SOURCE: &str = "embedded://bevy_pbr/render/pbr_functions.wgsl";

/// What stands in for [`PBR_FUNCTIONS`] if Bevy's text is not as expected: surfaces look as if
/// nothing was baked, rather than not at all.
const UNLIT_PBR_FUNCTIONS: &str = "\
#define_import_path bevy_fresco::pbr_functions
#import bevy_pbr::{pbr_functions, pbr_types}
fn apply_pbr_lighting(in: pbr_types::PbrInput) -> vec4<f32> {
    return pbr_functions::apply_pbr_lighting(in);
}
";

/// Keeps Bevy's text loaded until the copy is made.
#[derive(Resource, Debug)]
struct Source(Handle<Shader>);

/// Adds the shaders. Without a renderer there is nothing to add.
pub(super) fn plugin(app: &mut App) {
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    load_shader_library!(app, "directional.wgsl");
    // What shaders import is found by its path, so that Bevy's `embedded_watcher` reloads it.
    load_shader_library!(app, "bump/bump.wgsl");
    load_shader_library!(app, "bump/surface.wgsl");
    app.add_systems(Startup, (add_own, load_bevys)).add_systems(
        PreUpdate,
        copy_bevys_lighting.run_if(resource_exists::<Source>),
    );
}

fn add_own(mut shaders: ResMut<Assets<Shader>>) {
    let vertex = include_str!("vertex.wgsl");
    let fragment = include_str!("fragment.wgsl");
    add(&mut shaders, &VERTEX_SHADER, "vertex.wgsl", vertex);
    add(&mut shaders, &FRAGMENT_SHADER, "fragment.wgsl", fragment);
    let prepass = include_str!("bump/prepass.wgsl");
    add(&mut shaders, &PREPASS_SHADER, "bump/prepass.wgsl", prepass);
}

fn load_bevys(mut commands: Commands, assets: Res<AssetServer>) {
    commands.insert_resource(Source(assets.load(SOURCE)));
}

/// Waits for Bevy's text and copies it. Pipelines that import the copy wait for it by themselves.
fn copy_bevys_lighting(
    mut commands: Commands,
    source: Res<Source>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    let Some(bevys) = shaders.get(&source.0) else {
        return;
    };
    let text = lit_by_vertices(bevys.source.as_str()).map_or_else(
        || {
            error!("{SOURCE} is not as bevy_fresco knows it: baked light cannot be shown");
            Cow::Borrowed(UNLIT_PBR_FUNCTIONS)
        },
        Cow::Owned,
    );
    add(&mut shaders, &PBR_FUNCTIONS, "pbr_functions.wgsl", text);
    commands.remove_resource::<Source>();
}

fn add(
    shaders: &mut Assets<Shader>,
    handle: &Handle<Shader>,
    name: &str,
    text: impl Into<Cow<'static, str>>,
) {
    let shader = Shader::from_wgsl(text, format!("bevy_fresco/plugin/{name}"));
    if let Err(error) = shaders.insert(handle, shader) {
        error!("the shader {name} could not be added: {error}");
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
