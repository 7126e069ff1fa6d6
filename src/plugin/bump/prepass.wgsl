// Bevy's prepass fragment shader (bevy_pbr 0.19.1, render/pbr_prepass.wgsl) with relief, for the pass that
// writes normals.

#import bevy_fresco::{bindings, bump, bump_surface}
#import bevy_render::bindless::{bindless_samplers_filtering, bindless_textures_2d}
#import bevy_pbr::{
    pbr_prepass_functions,
    pbr_bindings,
    pbr_types,
    pbr_functions,
    prepass_io::{VertexOutput, FragmentOutput},
    mesh_view_bindings::view,
}
#ifdef BINDLESS
#import bevy_pbr::pbr_bindings::material_indices
#endif

@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
#ifdef VERTEX_UV_GRADIENTS
    @location(12) by_u: vec3<f32>,
    @location(13) by_v: vec3<f32>,
#endif
) -> FragmentOutput {
    let on = bump_surface::surface(in);
    let flags = bindings::flags(on.slot);
    let uv_transform = bindings::uv_transform(on.slot);

#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    let double_sided = (flags & pbr_types::STANDARD_MATERIAL_FLAGS_DOUBLE_SIDED_BIT) != 0u;
    let side = select(1.0, -1.0, double_sided && !is_front);
    let n = side * normalize(in.world_normal);

    let on_mesh = bump_surface::channels(
        in,
#ifdef VERTEX_UV_GRADIENTS
        by_u,
        by_v,
#endif
        on,
    );
#ifdef FRESCO_PARALLAX
    let seen = bump_surface::look(in, on, on_mesh, uv_transform);
    let seen_uvs = bump_surface::seen_uvs(seen, uv_transform);
#else
    let seen = on_mesh;
#endif

#ifdef FRESCO_NORMAL_MAP
#ifdef FRESCO_PARALLAX
    let Nt = textureSampleGrad(
#ifdef BINDLESS
        bindless_textures_2d[material_indices[on.slot].normal_map_texture],
        bindless_samplers_filtering[material_indices[on.slot].normal_map_sampler],
#else
        pbr_bindings::normal_map_texture,
        pbr_bindings::normal_map_sampler,
#endif
#ifdef STANDARD_MATERIAL_NORMAL_MAP_UV_B
        seen_uvs.uv_b, seen_uvs.uv_b_dx, seen_uvs.uv_b_dy,
#else
        seen_uvs.uv, seen_uvs.uv_dx, seen_uvs.uv_dy,
#endif
    ).rgb;
#else // FRESCO_PARALLAX
#ifdef STANDARD_MATERIAL_NORMAL_MAP_UV_B
    let uv = (uv_transform * vec3(in.uv_b, 1.0)).xy;
#else
    let uv = (uv_transform * vec3(in.uv, 1.0)).xy;
#endif
    let Nt = textureSampleBias(
#ifdef BINDLESS
        bindless_textures_2d[material_indices[on.slot].normal_map_texture],
        bindless_samplers_filtering[material_indices[on.slot].normal_map_sampler],
#else
        pbr_bindings::normal_map_texture,
        pbr_bindings::normal_map_sampler,
#endif
        uv,
        view.mip_bias,
    ).rgb;
#endif // FRESCO_PARALLAX
    let TBN = pbr_functions::calculate_tbn_mikktspace(in.world_normal, in.world_tangent);
    let mapped = side * pbr_functions::apply_normal_mapping(flags, TBN, double_sided, is_front, Nt);
#else
    let mapped = side * n;
#endif

    let raised = bump_surface::raise(on, seen, uv_transform, mapped);
    let V = pbr_functions::calculate_view(in.world_position, view.clip_from_view[3].w == 1.0);
    let bumped = bump::facing(side * raised.normal, n, V);

    // Cut out where it is seen.
#ifdef FRESCO_PARALLAX
    pbr_prepass_functions::prepass_alpha_discard(bump_surface::moved(in, seen));
#else
    pbr_prepass_functions::prepass_alpha_discard(in);
#endif

    var out: FragmentOutput;
    // Unlit surfaces have the normals of their vertices.
    let is_lit = (flags & pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u;
    out.normal = vec4(select(in.world_normal, bumped, is_lit) * 0.5 + vec3(0.5), 1.0);
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(
        in.world_position,
        in.previous_world_position,
    );
#endif
    return out;
}
