//! The shaders of the material, and the one that is made from Bevy's.
//!
//! Where the shader definition `LIGHTMAP` is set, Bevy's lighting code adds the light of a lightmap
//! and leaves out what a light, a probe or the ambient light says it must not add to it; its
//! material code reads the texture, which must then be bound. Binding one to every lit entity would
//! cost a bind group for every few of them, needs a second UV set and cannot be had on skinned and
//! morphed meshes at all. So the lighting code is taken from a copy of Bevy's text in which that
//! definition has another name, and light from vertices goes where that of a texture would.
//! The copy is made when the app starts, from the text that Bevy brings: it cannot fall behind it.
//!
//! The material code is copied too, for parallax: there all of the material's textures are read where relief is
//! seen, by the gradients of the mesh's texture coordinates, which Bevy's text leaves to the hardware.

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
/// Cuts surfaces out where their relief is seen, in the other passes.
pub(super) const CUT_SHADER: Handle<Shader> = uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a06");
/// Bevy's `pbr_functions`, in which [`BAKED_LIGHT`] stands for `LIGHTMAP`.
const PBR_FUNCTIONS: Handle<Shader> = uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a03");

/// Bevy's `pbr_fragment`, reading textures where they are told to.
const PBR_FRAGMENT: Handle<Shader> = uuid_handle!("5b1d1f0e-6c1c-4a51-9a6d-3f4a5d0f5a05");

/// The shader definition under which surfaces are lit as lightmapped ones.
pub(super) const BAKED_LIGHT: &str = "FRESCO_BAKED_LIGHT";

/// The shader definition under which baked light answers to bumps, in both stages.
pub(super) const GRADIENT: &str = "VERTEX_BAKED_LIGHT_GRADIENT";

/// A module of Bevy's, and ours that is made from it.
struct Copied {
    source: &'static str,
    handle: Handle<Shader>,
    name: &'static str,
    edit: fn(&str) -> Option<String>,
    /// What stands in for it if Bevy's text is not as expected: surfaces look as if nothing was baked, or seen
    /// from the side, rather than not at all.
    instead: &'static str,
}

const COPIED: [Copied; 2] = [
    Copied {
        source: "embedded://bevy_pbr/render/pbr_functions.wgsl",
        handle: PBR_FUNCTIONS,
        name: "pbr_functions.wgsl",
        edit: lit_by_vertices,
        instead: "\
#define_import_path bevy_fresco::pbr_functions
#import bevy_pbr::{pbr_functions, pbr_types}
fn apply_pbr_lighting(in: pbr_types::PbrInput) -> vec4<f32> {
    return pbr_functions::apply_pbr_lighting(in);
}
",
    },
    Copied {
        source: "embedded://bevy_pbr/render/pbr_fragment.wgsl",
        handle: PBR_FRAGMENT,
        name: "pbr_fragment.wgsl",
        edit: read_where_told,
        instead: "\
#define_import_path bevy_fresco::pbr_fragment
#import bevy_fresco::parallax::SeenUvs
#import bevy_pbr::{pbr_fragment, pbr_types}
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::VertexOutput
#else
#import bevy_pbr::forward_io::VertexOutput
#endif
fn pbr_input_from_standard_material(in: VertexOutput, is_front: bool, seen: SeenUvs) -> pbr_types::PbrInput {
    return pbr_fragment::pbr_input_from_standard_material(in, is_front);
}
",
    },
];

/// Keeps Bevy's texts loaded until the copies are made.
#[derive(Resource, Debug)]
struct Sources([Handle<Shader>; 2]);

/// Adds the shaders. Without a renderer there is nothing to add.
pub(super) fn plugin(app: &mut App) {
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    load_shader_library!(app, "directional.wgsl");
    // What shaders import is found by its path, so that Bevy's `embedded_watcher` reloads it.
    load_shader_library!(app, "bindings.wgsl");
    load_shader_library!(app, "bump/bump.wgsl");
    load_shader_library!(app, "bump/parallax.wgsl");
    load_shader_library!(app, "bump/surface.wgsl");
    app.add_systems(Startup, (add_own, load_bevys))
        .add_systems(PreUpdate, copy_bevys.run_if(resource_exists::<Sources>));
}

fn add_own(mut shaders: ResMut<Assets<Shader>>) {
    let vertex = include_str!("vertex.wgsl");
    let fragment = include_str!("fragment.wgsl");
    add(&mut shaders, &VERTEX_SHADER, "vertex.wgsl", vertex);
    add(&mut shaders, &FRAGMENT_SHADER, "fragment.wgsl", fragment);
    let prepass = include_str!("bump/prepass.wgsl");
    add(&mut shaders, &PREPASS_SHADER, "bump/prepass.wgsl", prepass);
    let cut = include_str!("bump/cut.wgsl");
    add(&mut shaders, &CUT_SHADER, "bump/cut.wgsl", cut);
}

fn load_bevys(mut commands: Commands, assets: Res<AssetServer>) {
    commands.insert_resource(Sources(COPIED.map(|copied| assets.load(copied.source))));
}

/// Waits for Bevy's texts and copies them. Pipelines that import the copies wait for them by themselves.
fn copy_bevys(mut commands: Commands, sources: Res<Sources>, mut shaders: ResMut<Assets<Shader>>) {
    if sources.0.iter().any(|source| !shaders.contains(source)) {
        return;
    }
    for (copied, source) in COPIED.iter().zip(&sources.0) {
        let text = shaders.get(source).map(|bevys| bevys.source.as_str());
        let text = text.and_then(copied.edit).map_or_else(
            || {
                let source = copied.source;
                error!("{source} is not as bevy_fresco knows it: baked light or parallax cannot be shown");
                Cow::Borrowed(copied.instead)
            },
            Cow::Owned,
        );
        add(&mut shaders, &copied.handle, copied.name, text);
    }
    commands.remove_resource::<Sources>();
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

/// The module under our name, with a further argument that says where textures are read; `None` if the text is
/// not as expected.
///
/// Line by line: `textureSampleBias` becomes `textureSampleGrad`, its coordinates get gradients beside them and
/// the bias goes. Only coordinates of textures stand behind `_UV_B` and its `#else`.
fn read_where_told(text: &str) -> Option<String> {
    const ONCE: [(&str, &str); 4] = [
        (
            "#define_import_path bevy_pbr::pbr_fragment\n",
            "#define_import_path bevy_fresco::pbr_fragment\n#import bevy_fresco::parallax::SeenUvs\n",
        ),
        (
            "    is_front: bool,\n) -> pbr_types::PbrInput {",
            "    is_front: bool,\n    seen: SeenUvs,\n) -> pbr_types::PbrInput {",
        ),
        (
            "var uv = (uv_transform * vec3(in.uv, 1.0)).xy;",
            "var uv = seen.uv;",
        ),
        (
            "var uv_b = (uv_transform * vec3(in.uv_b, 1.0)).xy;",
            "var uv_b = seen.uv_b;",
        ),
    ];
    let text = ONCE.iter().try_fold(text.to_owned(), |text, (from, to)| {
        (text.matches(from).count() == 1).then(|| text.replace(from, to))
    })?;
    let (mut edited, mut before) = (String::with_capacity(text.len()), "");
    let (mut reads, mut places) = (0, 0);
    for line in text.lines() {
        let is_second =
            before.starts_with("#ifdef STANDARD_MATERIAL_") && before.ends_with("_UV_B");
        match line.trim() {
            "uv_b," if is_second => edited += "uv_b, seen.uv_b_dx, seen.uv_b_dy,",
            "uv," if before.starts_with("#else") => {
                places += 1;
                edited += "uv, seen.uv_dx, seen.uv_dy,";
            }
            "bias.mip_bias," => {}
            _ => {
                reads += line.matches("textureSampleBias(").count();
                edited += &line.replace("textureSampleBias(", "textureSampleGrad(");
            }
        }
        edited.push('\n');
        before = line;
    }
    (reads > 0 && reads == places).then_some(edited)
}

#[cfg(test)]
mod tests {
    use super::{lit_by_vertices, read_where_told};

    #[test]
    fn textures_are_read_where_they_are_told_to() {
        let bevys = "#define_import_path bevy_pbr::pbr_fragment\n\
                     fn f(\n    is_front: bool,\n) -> pbr_types::PbrInput {\n\
                     var uv = (uv_transform * vec3(in.uv, 1.0)).xy;\n\
                     var uv_b = (uv_transform * vec3(in.uv_b, 1.0)).xy;\n\
                     x = textureSampleBias(\n#ifdef STANDARD_MATERIAL_X_UV_B\n    uv_b,\n#else // X\n    uv,\n\
                     #endif\n    bias.mip_bias,\n);\nuv,\n";
        let ours = "#define_import_path bevy_fresco::pbr_fragment\n#import bevy_fresco::parallax::SeenUvs\n\
                    fn f(\n    is_front: bool,\n    seen: SeenUvs,\n) -> pbr_types::PbrInput {\n\
                    var uv = seen.uv;\nvar uv_b = seen.uv_b;\n\
                    x = textureSampleGrad(\n#ifdef STANDARD_MATERIAL_X_UV_B\nuv_b, seen.uv_b_dx, seen.uv_b_dy,\n\
                    #else // X\nuv, seen.uv_dx, seen.uv_dy,\n#endif\n\n);\nuv,\n";
        assert_eq!(read_where_told(bevys).as_deref(), Some(ours));
        assert_eq!(
            read_where_told(&bevys.replace("    uv,\n", "    uv + 0.0,\n")),
            None
        );
        assert_eq!(read_where_told("something else"), None);
    }

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
