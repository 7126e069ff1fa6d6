// Bevy's prepass fragment shader (bevy_pbr 0.19.1, render/pbr_prepass.wgsl) for surfaces with parallax that may be
// cut out, in the passes that write no normals: depth, motion vectors, shadows. They are cut where the relief is
// seen, by the eye or by the light.

#import bevy_fresco::{bindings, bump_surface}
#import bevy_pbr::{
    pbr_prepass_functions,
    pbr_functions,
    prepass_io,
}

#ifdef PREPASS_FRAGMENT
@fragment
fn fragment(in: prepass_io::VertexOutput) -> prepass_io::FragmentOutput {
    cut(in);
    var out: prepass_io::FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(
        in.world_position,
        in.previous_world_position,
    );
#endif
    return out;
}
#else
@fragment
fn fragment(in: prepass_io::VertexOutput) {
    cut(in);
}
#endif

fn cut(in: prepass_io::VertexOutput) {
#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    let on = bump_surface::surface(in);
    let on_mesh = bump_surface::channels(in, on);
    let seen = bump_surface::look(in, on, on_mesh, bindings::uv_transform(on.slot));
    pbr_prepass_functions::prepass_alpha_discard(bump_surface::moved(in, seen));
}
