// Bevy's fragment shader (bevy_pbr 0.19.1, render/pbr.wgsl) with relief, and with baked light in the
// place of a lightmap, for the forward and the deferred pass.
//
// `bevy_fresco::pbr_functions` is Bevy's `pbr_functions`, lighting as if there were a lightmap
// without one being bound: see `shaders.rs`.

#import bevy_pbr::{
    pbr_types,
    pbr_functions::alpha_discard,
    decal::clustered::apply_decals,
}

#ifdef PREPASS_PIPELINE
#import bevy_pbr::{
    prepass_io::{VertexOutput, FragmentOutput},
    pbr_deferred_functions::deferred_output,
}
#else
#import bevy_pbr::{
    mesh_view_bindings::view,
    forward_io::{VertexOutput, FragmentOutput},
    pbr_functions::main_pass_post_lighting_processing,
}
#ifdef FRESCO_BAKED_LIGHT
#import bevy_fresco::pbr_functions::apply_pbr_lighting
#else
#import bevy_pbr::pbr_functions::apply_pbr_lighting
#endif
#endif

#import bevy_fresco::bindings
#ifdef FRESCO_BUMP
#import bevy_fresco::{bump, bump_surface}
#endif
#ifdef FRESCO_PARALLAX
#import bevy_fresco::pbr_fragment::pbr_input_from_standard_material
#else
#import bevy_pbr::pbr_fragment::pbr_input_from_standard_material
#endif

#ifdef VERTEX_BAKED_LIGHT_GRADIENT
#import bevy_fresco::directional::reshade
#endif

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

#ifdef OIT_ENABLED
#import bevy_core_pipeline::oit::oit_draw
#endif

@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
#ifdef VERTEX_BAKED_LIGHT
    // At centroids: with multisampling the middle of a pixel may lie outside the triangle, where light would go on to
    // any value, below 0 too.
    @location(10) @interpolate(perspective, centroid) baked_light: vec3<f32>,
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
    @location(11) @interpolate(perspective, centroid) baked_light_gradient: vec3<f32>,
#endif
#endif
#ifdef VERTEX_UV_GRADIENTS
    @location(12) by_u: vec3<f32>,
    @location(13) by_v: vec3<f32>,
#endif
) -> FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif

#ifdef FRESCO_BUMP
    let on = bump_surface::surface(in);
    let on_mesh = bump_surface::channels(
        in,
#ifdef VERTEX_UV_GRADIENTS
        by_u,
        by_v,
#endif
        on,
    );
#ifdef FRESCO_PARALLAX
    let uv_transform = bindings::uv_transform(on.slot);
    let seen = bump_surface::look(in, on, on_mesh, uv_transform);
    let seen_uvs = bump_surface::seen_uvs(seen, uv_transform);
    var pbr_input = pbr_input_from_standard_material(in, is_front, seen_uvs);
#else
    let seen = on_mesh;
    var pbr_input = pbr_input_from_standard_material(in, is_front);
#endif
#else
    var pbr_input = pbr_input_from_standard_material(in, is_front);
#endif

    // The unit normal of the surface without relief, on the side that is seen.
    let double_sided = (pbr_input.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_DOUBLE_SIDED_BIT) != 0u;
    let side = select(1.0, -1.0, double_sided && !is_front);
    let n = side * normalize(in.world_normal);

#ifdef FRESCO_BUMP
#ifdef FRESCO_NORMAL_MAP
    let mapped = side * pbr_input.N;
#else
    let mapped = side * n;
#endif
    let raised = bump_surface::raise(on, seen, pbr_input.material.uv_transform, mapped);
    // Else it is the prepass's, which has the relief already.
#ifndef LOAD_PREPASS_NORMALS
    pbr_input.N = bump::facing(side * raised.normal, n, pbr_input.V);
#endif
    pbr_input.material.perceptual_roughness = bump::roughened(
        pbr_input.material.perceptual_roughness,
        raised.variance,
    );
#endif

    pbr_input.material.base_color = alpha_discard(pbr_input.material, pbr_input.material.base_color);
    apply_decals(&pbr_input);

    let is_lit = (pbr_input.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u;
    // The deferred pass would add it to unlit surfaces too.
#ifdef VERTEX_BAKED_LIGHT
    if is_lit {
        let gain = bindings::gain(bindings::slot_of(in.instance_index));
        pbr_input.lightmap_light = gain * max(baked_light, vec3(0.0));
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
        // It belongs to the normals of the mesh: either side shows the same light.
        let gradient = side * gain * baked_light_gradient;
        pbr_input.lightmap_light = reshade(pbr_input.lightmap_light, gradient, n, pbr_input.N);
#endif
    }
#endif

#ifdef PREPASS_PIPELINE
    // Exposure and diffuse colour are multiplied in there.
    var out = deferred_output(in, pbr_input);
#ifdef FRESCO_BUMP
#ifdef NORMAL_PREPASS
    // Bevy's is that of the vertices.
    out.normal = vec4(pbr_input.N * 0.5 + vec3(0.5), 1.0);
#endif
#endif
#else
    var out: FragmentOutput;
    if is_lit {
        out.color = apply_pbr_lighting(pbr_input);
    } else {
        out.color = pbr_input.material.base_color;
    }
#ifdef FRESCO_SHOW_IRRADIANCE
    out.color = vec4(pbr_input.lightmap_light * view.exposure, pbr_input.material.base_color.a);
#endif
#ifdef FRESCO_SHOW_RADIOSITY
    let reflectance = pbr_input.material.base_color.rgb * (1.0 - pbr_input.material.metallic);
    out.color = vec4(
        pbr_input.lightmap_light * view.exposure * reflectance + pbr_input.material.emissive.rgb,
        pbr_input.material.base_color.a,
    );
#endif
    out.color = main_pass_post_lighting_processing(pbr_input, out.color);
#ifdef FRESCO_SHOW_VALUES
#ifdef VERTEX_BAKED_LIGHT
    out.color = vec4(max(baked_light, vec3(0.0)), 1.0);
#endif
#endif
#ifdef FRESCO_SHOW_NORMALS
    out.color = vec4(pbr_input.N * 0.5 + vec3(0.5), 1.0);
#endif
#ifdef FRESCO_SHOW_RAW_NORMALS
    out.color = vec4(pbr_input.N, pbr_input.material.perceptual_roughness);
#endif
#ifdef FRESCO_SHOW_RAW_PARALLAX
#ifdef FRESCO_PARALLAX
    out.color = vec4(seen.a.at - on_mesh.a.at, seen.depth, seen.reads);
#endif
#endif

#ifdef OIT_ENABLED
    let alpha_mode = pbr_input.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    if alpha_mode != pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE {
        // Drawn later, when the transparent fragments are resolved.
        oit_draw(in.position, out.color);
        discard;
    }
#endif
#endif // PREPASS_PIPELINE

    return out;
}
