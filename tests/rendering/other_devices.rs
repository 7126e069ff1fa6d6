//! The shaders as they are put together on devices this test does not run on.
//!
//! A picture gives the real shader definitions; those of desktops and of WebGL2 are exchanged, and
//! what comes out must be valid.

use bevy::core_pipeline::prepass::MotionVectorPrepass;
use bevy::material::descriptor::PipelineDescriptor;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::PipelineCache;
use bevy::render::renderer::RenderAdapter;
use bevy::render::settings::WgpuFeatures;
use bevy::shader::{Shader, ShaderCache, ShaderDefVal};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, Parallax};

use crate::bumps::{bump, show, waves_map};
use crate::directional::{normal_map, with_gradient, with_tangents};
use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::scenery::{add, grid, lit, show_fresco};
use crate::stage::{Stage, on_stage};

const BINDLESS: &str = "BINDLESS";
const ARRAYS: [&str; 4] = [
    "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
    "MULTIPLE_LIGHTMAPS_IN_ARRAY",
    "IRRADIANCE_VOLUMES_ARE_USABLE",
    "CLUSTERED_DECALS_ARE_USABLE",
];
const ARRAYS_AND_BINDLESS: [&str; 5] = [BINDLESS, ARRAYS[0], ARRAYS[1], ARRAYS[2], ARRAYS[3]];
const WEBGL2: [&str; 5] = [
    "WEBGL2",
    "NO_ARRAY_TEXTURES_SUPPORT",
    "NO_CUBE_ARRAY_TEXTURES_SUPPORT",
    "SIXTEEN_BYTE_ALIGNMENT",
    "SKINS_USE_UNIFORM_BUFFERS",
];

/// What shadows of the sun are drawn with where depth cannot be clamped.
const SHADOWS: &[&str] = &["UNCLIPPED_DEPTH_ORTHO_EMULATION", "PREPASS_FRAGMENT"];

/// A kind of device, and what of the scene may be added on it.
struct Device {
    name: &'static str,
    has: &'static [&'static str],
    lacks: &'static [&'static str],
    storage_buffers: u32,
    extras: &'static [&'static [&'static str]],
}

const ON_DESKTOPS: [&[&str]; 4] = [
    &[],
    &["ENVIRONMENT_MAP"],
    &["ENVIRONMENT_MAP", "IRRADIANCE_VOLUME"],
    &["OIT_ENABLED"],
];

const DEVICES: [Device; 3] = [
    Device {
        name: "desktop",
        has: &ARRAYS,
        lacks: &[BINDLESS],
        storage_buffers: 8,
        extras: &ON_DESKTOPS,
    },
    Device {
        name: "bindless desktop",
        has: &ARRAYS_AND_BINDLESS,
        lacks: &[],
        storage_buffers: 8,
        extras: &ON_DESKTOPS,
    },
    Device {
        name: "WebGL2",
        has: &WEBGL2,
        lacks: &ARRAYS_AND_BINDLESS,
        storage_buffers: 0,
        extras: &[&[], &["ENVIRONMENT_MAP"], SHADOWS],
    },
];

#[test]
fn shaders_are_valid_elsewhere() {
    on_stage(|stage| {
        for deferred in [false, true] {
            stage.shoot(
                |camera| {
                    if deferred {
                        camera.insert((DEFERRED, MotionVectorPrepass));
                    }
                },
                |world| {
                    let base = StandardMaterial {
                        opaque_render_method: method(deferred),
                        ..default()
                    };
                    show_fresco(world, lit(grid(), Vec3::ONE), base.clone(), default());
                    let normal_map_texture = Some(add(world, normal_map(&[[128; 4]])));
                    let base = StandardMaterial {
                        normal_map_texture,
                        ..base
                    };
                    let mesh = with_tangents(lit(grid(), Vec3::ONE));
                    let mesh = with_gradient(mesh, Vec3::Z);
                    show_fresco(world, mesh.clone(), base.clone(), default());
                    let seen = Bump {
                        parallax: Some(Parallax::default()),
                        ..bump(world, waves_map([16; 2]), BumpHeight::World(0.1))
                    };
                    let mask = StandardMaterial {
                        alpha_mode: AlphaMode::Mask(0.5),
                        ..base.clone()
                    };
                    show(world, mesh.clone(), mask, Some(seen.clone()), default());
                    show(world, mesh, base, Some(seen), default());
                    let sun = DirectionalLight {
                        shadow_maps_enabled: true,
                        ..default()
                    };
                    world.spawn((sun, Transform::default()));
                },
            );
        }
        for device in &DEVICES {
            let count = compose_for(stage, device);
            println!("{}: {count} shaders are valid", device.name);
            assert!(count >= 4 * device.extras.len());
        }
    });
}

/// Puts together all our shaders that have been drawn with; says how many were.
fn compose_for(stage: &Stage, device: &Device) -> usize {
    let app = stage.app();
    let shaders = app.world().resource::<Assets<Shader>>();
    let renderer = app.sub_app(RenderApp).world();
    let downlevel = renderer.resource::<RenderAdapter>();
    let downlevel = downlevel.get_downlevel_capabilities().flags;
    let mut cache =
        ShaderCache::<(), ()>::new((), WgpuFeatures::all(), downlevel, |_, _, _| Ok(()));
    for (id, shader) in shaders.iter() {
        let mut shader = shader.clone();
        shader.shader_defs.push(ShaderDefVal::UInt(
            "AVAILABLE_STORAGE_BUFFER_BINDINGS".into(),
            device.storage_buffers,
        ));
        cache.set_shader(id, shader);
    }
    let mut count = 0;
    for pipeline in renderer.resource::<PipelineCache>().pipelines() {
        let PipelineDescriptor::RenderPipelineDescriptor(pipeline) = &pipeline.descriptor else {
            continue;
        };
        let vertex = Some((&pipeline.vertex.shader, &pipeline.vertex.shader_defs));
        let fragment = pipeline.fragment.as_ref();
        let fragment = fragment.map(|f| (&f.shader, &f.shader_defs));
        for (handle, defs) in [vertex, fragment].into_iter().flatten() {
            let shader = shaders.get(handle).unwrap();
            if !shader.path.starts_with("bevy_fresco/") {
                continue;
            }
            for extra in device.extras {
                let draws_shadows = shader.path.ends_with("bump/cut.wgsl");
                if *extra == SHADOWS && !draws_shadows {
                    continue;
                }
                // Without binding arrays Bevy's own lightmaps do not compile there, and ours with them.
                if extra.contains(&"ENVIRONMENT_MAP")
                    && has(defs, "LIGHTMAP")
                    && !device.has.contains(&ARRAYS[0])
                {
                    continue;
                }
                let defs = definitions(defs, device, extra);
                if let Err(error) = cache.get(0, handle.id(), &defs) {
                    panic!("{}, {}, {extra:?}: {error:#?}", device.name, shader.path);
                }
                count += 1;
            }
        }
    }
    count
}

fn has(defs: &[ShaderDefVal], name: &str) -> bool {
    defs.contains(&name.into())
}

fn definitions(found: &[ShaderDefVal], device: &Device, extra: &[&str]) -> Vec<ShaderDefVal> {
    let lacks = |def: &ShaderDefVal| matches!(def, ShaderDefVal::Bool(name, _) if device.lacks.contains(&name.as_str()));
    let mut defs: Vec<_> = found.iter().filter(|def| !lacks(def)).cloned().collect();
    defs.extend(device.has.iter().chain(extra).map(|name| (*name).into()));
    if device.storage_buffers == 0 {
        defs.push(ShaderDefVal::UInt(
            "PER_OBJECT_BUFFER_BATCH_SIZE".into(),
            64,
        ));
    }
    defs
}
