// Bevy's vertex shader for meshes that carry attributes of ours, for the forward, the deferred and the
// normal pass.
//
// Bevy's own two (bevy_pbr 0.19.1, render/mesh.wgsl and prepass/prepass.wgsl) cannot be imported,
// so their bodies are followed here line by line and vertex attributes are passed on. Depth must
// come out to the last bit as in Bevy's prepass, which still draws the depth of these meshes:
// positions are computed by the same functions in the same order.

#import bevy_pbr::{
    mesh_bindings::mesh,
    mesh_functions,
    morph,
    skinning,
    view_transformations::position_world_to_clip,
}
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
#import bevy_fresco::directional::gradient_to_world
#endif
#ifdef VERTEX_UV_GRADIENTS
#import bevy_render::maths::mat2x4_f32_to_mat3x3_unpack
#endif
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::Vertex
#else
#import bevy_pbr::forward_io::Vertex
#endif

// The fields of Bevy's `VertexOutput` at Bevy's locations, and ours. Structs that a stage gives
// out cannot be nested, or Bevy's would be a field of this one.
struct LitVertexOutput {
    @builtin(position) position: vec4<f32>,
#ifdef PREPASS_PIPELINE
#ifdef VERTEX_UVS_A
    @location(0) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(1) uv_b: vec2<f32>,
#endif
    @location(2) world_normal: vec3<f32>,
#ifdef VERTEX_TANGENTS
    @location(3) world_tangent: vec4<f32>,
#endif
    @location(4) world_position: vec4<f32>,
#ifdef MOTION_VECTOR_PREPASS
    @location(5) previous_world_position: vec4<f32>,
#endif
    @location(7) @interpolate(flat) instance_index: u32,
#ifdef VERTEX_COLORS
    @location(8) color: vec4<f32>,
#endif
#ifdef VISIBILITY_RANGE_DITHER
    @location(9) @interpolate(flat) visibility_range_dither: i32,
#endif
#else // PREPASS_PIPELINE
    @location(0) world_position: vec4<f32>,
    @location(1) world_normal: vec3<f32>,
#ifdef VERTEX_UVS_A
    @location(2) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(3) uv_b: vec2<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) world_tangent: vec4<f32>,
#endif
#ifdef VERTEX_COLORS
    @location(5) color: vec4<f32>,
#endif
    @location(6) @interpolate(flat) instance_index: u32,
#ifdef VISIBILITY_RANGE_DITHER
    @location(7) @interpolate(flat) visibility_range_dither: i32,
#endif
#endif // PREPASS_PIPELINE
#ifdef VERTEX_BAKED_LIGHT
    @location(10) @interpolate(perspective, centroid) baked_light: vec3<f32>,
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
    @location(11) @interpolate(perspective, centroid) baked_light_gradient: vec3<f32>,
#endif
#endif
#ifdef VERTEX_UV_GRADIENTS
    @location(12) by_u: vec3<f32>,
    @location(13) by_v: vec3<f32>,
#endif
}

#ifdef VERTEX_UV_GRADIENTS
// Gradients turn as normals do, and keep their length: so much a metre.
fn gradient_local_to_world(
    gradient: vec3<f32>,
    world_from_local: mat4x4<f32>,
    instance_index: u32,
) -> vec3<f32> {
#ifdef SKINNED
    let m = mat3x3(world_from_local[0].xyz, world_from_local[1].xyz, world_from_local[2].xyz);
    return skinning::inverse_transpose_3x3m(m) * gradient;
#else
    return mat2x4_f32_to_mat3x3_unpack(
        mesh[instance_index].local_from_world_transpose_a,
        mesh[instance_index].local_from_world_transpose_b,
    ) * gradient;
#endif
}
#endif

#ifdef MORPH_TARGETS
fn morph_vertex(vertex_in: Vertex, instance_index: u32) -> Vertex {
    var vertex = vertex_in;
    let vertex_index = vertex.index - mesh[instance_index].first_vertex_index;
    let weight_count = morph::layer_count(instance_index);
    for (var i: u32 = 0u; i < weight_count; i ++) {
        let weight = morph::weight_at(i, instance_index);
        if weight == 0.0 {
            continue;
        }
        vertex.position += weight * morph::morph_position(vertex_index, i, instance_index);
#ifdef VERTEX_NORMALS
        vertex.normal += weight * morph::morph_normal(vertex_index, i, instance_index);
#endif
#ifdef VERTEX_TANGENTS
        vertex.tangent += vec4(weight * morph::morph_tangent(vertex_index, i, instance_index), 0.0);
#endif
    }
    return vertex;
}

#ifdef MOTION_VECTOR_PREPASS
fn morph_prev_vertex(vertex_in: Vertex, instance_index: u32) -> Vertex {
    var vertex = vertex_in;
    let vertex_index = vertex.index - mesh[instance_index].first_vertex_index;
    let weight_count = morph::layer_count(instance_index);
    for (var i: u32 = 0u; i < weight_count; i ++) {
        let weight = morph::prev_weight_at(i, instance_index);
        if weight == 0.0 {
            continue;
        }
        vertex.position += weight * morph::morph_position(vertex_index, i, instance_index);
    }
    return vertex;
}
#endif
#endif // MORPH_TARGETS

@vertex
fn vertex(
    vertex_no_morph: Vertex,
#ifdef VERTEX_BAKED_LIGHT
    @location(8) baked_light: vec3<f32>,
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
    @location(9) baked_light_gradient: vec3<f32>,
#endif
#endif
#ifdef VERTEX_UV_GRADIENTS
    @location(12) by_u: vec3<f32>,
    @location(13) by_v: vec3<f32>,
#endif
) -> LitVertexOutput {
    var out: LitVertexOutput;

    // Taken from the vertex as it came in and handed to every function, as Bevy does: read from the
    // morphed copy it is wrong on DX12 (https://github.com/gfx-rs/naga/issues/2416).
    let instance_index = vertex_no_morph.instance_index;

#ifdef MORPH_TARGETS
    var vertex = morph_vertex(vertex_no_morph, instance_index);
#else
    var vertex = vertex_no_morph;
#endif

    let mesh_world_from_local = mesh_functions::get_world_from_local(instance_index);
#ifdef SKINNED
    var world_from_local = skinning::skin_model(
        vertex.joint_indices,
        vertex.joint_weights,
        instance_index,
    );
#else
    var world_from_local = mesh_world_from_local;
#endif

#ifdef VERTEX_POSITIONS
    out.world_position = mesh_functions::mesh_position_local_to_world(
        world_from_local,
        vec4<f32>(vertex.position, 1.0),
    );
    out.position = position_world_to_clip(out.world_position.xyz);
#endif

#ifdef VERTEX_NORMALS
#ifdef SKINNED
    out.world_normal = skinning::skin_normals(world_from_local, vertex.normal);
#else
    out.world_normal = mesh_functions::mesh_normal_local_to_world(vertex.normal, instance_index);
#endif
#endif

#ifdef VERTEX_TANGENTS
    out.world_tangent = mesh_functions::mesh_tangent_local_to_world(
        world_from_local,
        vertex.tangent,
        instance_index,
    );
#endif

#ifdef VERTEX_UVS_A
    out.uv = vertex.uv;
#endif
#ifdef VERTEX_UVS_B
    out.uv_b = vertex.uv_b;
#endif
#ifdef VERTEX_COLORS
    out.color = vertex.color;
#endif

#ifdef PREPASS_PIPELINE
#ifdef MOTION_VECTOR_PREPASS
#ifdef HAS_PREVIOUS_MORPH
    let prev_vertex = morph_prev_vertex(vertex_no_morph, instance_index);
#else
    let prev_vertex = vertex_no_morph;
#endif
#ifdef HAS_PREVIOUS_SKIN
    let prev_model = skinning::skin_prev_model(
        prev_vertex.joint_indices,
        prev_vertex.joint_weights,
        instance_index,
    );
#else
    let prev_model = mesh_functions::get_previous_world_from_local(instance_index);
#endif
    out.previous_world_position = mesh_functions::mesh_position_local_to_world(
        prev_model,
        vec4<f32>(prev_vertex.position, 1.0),
    );
#endif // MOTION_VECTOR_PREPASS
#endif // PREPASS_PIPELINE

    out.instance_index = instance_index;
#ifdef VISIBILITY_RANGE_DITHER
    out.visibility_range_dither = mesh_functions::get_visibility_range_dither_level(
        instance_index,
        mesh_world_from_local[3],
    );
#endif

#ifdef VERTEX_BAKED_LIGHT
    out.baked_light = baked_light;
#ifdef VERTEX_BAKED_LIGHT_GRADIENT
    out.baked_light_gradient = gradient_to_world(baked_light_gradient, world_from_local);
#endif
#endif
#ifdef VERTEX_UV_GRADIENTS
    out.by_u = gradient_local_to_world(by_u, world_from_local, instance_index);
    out.by_v = gradient_local_to_world(by_v, world_from_local, instance_index);
#endif
    return out;
}
