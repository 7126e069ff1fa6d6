// What is bound of a material, as `bind_group.rs` lays it out: by itself, or in arrays of all materials' (`BINDLESS`).
//
// Functions get the slot of the material and never a texture out of an array: neighbouring pixels may have different
// ones, and compilers see so only where the array stands.

#define_import_path bevy_fresco::bindings

#ifdef BINDLESS
#import bevy_pbr::mesh_bindings::mesh
#import bevy_pbr::pbr_bindings::{material_array, material_indices}
#import bevy_render::bindless::{bindless_samplers_filtering, bindless_textures_2d}
#else
#import bevy_pbr::pbr_bindings::material
#endif

// `BumpUniform` in `bump/settings.rs`.
struct Bump {
    // Rows of the transform of texture coordinates; w: height of the map's 1, and what it is measured in.
    row_u: vec4<f32>,
    row_v: vec4<f32>,
    // Size of the map, unit of its slopes, bits: what repeats, whether the cubic passes by texels.
    size: vec4<f32>,
    // Of heights: that of the texture's 0, and how much higher its 1 is.
    range: vec4<f32>,
    // Height of the mesh between the two, steepest slope of sight, and how much relief is left at a distance d:
    // z − w d.
    sight: vec4<f32>,
}

// `FrescoUniform` in `bind_group.rs`.
struct Fresco {
    // x: gain of baked light.
    params: vec4<f32>,
    main_bump: Bump,
    detail_bump: Bump,
}

#ifdef BINDLESS
// Where in the arrays what a material has is.
struct Indices {
    standard: array<u32, 100>,
    fresco: u32,
    bump_slopes: u32,
    bump_sampler: u32,
    bump_heights: u32,
    detail_slopes: u32,
    detail_sampler: u32,
    bump_bounds: u32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage> indices: array<Indices>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage> frescos: array<Fresco>;
#else
@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> fresco: Fresco;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var bump_slopes: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(102) var bump_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var bump_heights: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var detail_slopes: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(105) var detail_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(106) var bump_bounds: texture_2d<f32>;
#endif

// Which of the materials that are bound a mesh has.
fn slot_of(instance_index: u32) -> u32 {
#ifdef BINDLESS
    return mesh[instance_index].material_and_lightmap_bind_group_slot & 0xffffu;
#else
    return 0u;
#endif
}

// Of the standard material.
fn flags(slot: u32) -> u32 {
#ifdef BINDLESS
    return material_array[material_indices[slot].material].flags;
#else
    return material.flags;
#endif
}

fn uv_transform(slot: u32) -> mat3x3<f32> {
#ifdef BINDLESS
    return material_array[material_indices[slot].material].uv_transform;
#else
    return material.uv_transform;
#endif
}

// Of baked light.
fn gain(slot: u32) -> f32 {
#ifdef BINDLESS
    return frescos[indices[slot].fresco].params.x;
#else
    return fresco.params.x;
#endif
}

fn main_bump(slot: u32) -> Bump {
#ifdef BINDLESS
    return frescos[indices[slot].fresco].main_bump;
#else
    return fresco.main_bump;
#endif
}

fn detail_bump(slot: u32) -> Bump {
#ifdef BINDLESS
    return frescos[indices[slot].fresco].detail_bump;
#else
    return fresco.detail_bump;
#endif
}

// Means and mean squares of slopes.
fn main_moments(slot: u32, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    return textureSampleGrad(
#ifdef BINDLESS
        bindless_textures_2d[indices[slot].bump_slopes],
        bindless_samplers_filtering[indices[slot].bump_sampler],
#else
        bump_slopes,
        bump_sampler,
#endif
        uv,
        dx,
        dy,
    );
}

fn detail_moments(slot: u32, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    return textureSampleGrad(
#ifdef BINDLESS
        bindless_textures_2d[indices[slot].detail_slopes],
        bindless_samplers_filtering[indices[slot].detail_sampler],
#else
        detail_slopes,
        detail_sampler,
#endif
        uv,
        dx,
        dy,
    );
}

// Heights 0 to 1, kept as the sum of two half floats.
fn main_heights(slot: u32, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    return textureSampleGrad(
#ifdef BINDLESS
        bindless_textures_2d[indices[slot].bump_heights],
        bindless_samplers_filtering[indices[slot].bump_sampler],
#else
        bump_heights,
        bump_sampler,
#endif
        uv,
        dx,
        dy,
    );
}

fn heights_size(slot: u32) -> vec2<i32> {
#ifdef BINDLESS
    return vec2<i32>(textureDimensions(bindless_textures_2d[indices[slot].bump_heights], 0));
#else
    return vec2<i32>(textureDimensions(bump_heights, 0));
#endif
}

fn heights_levels(slot: u32) -> i32 {
#ifdef BINDLESS
    return i32(textureNumLevels(bindless_textures_2d[indices[slot].bump_heights]));
#else
    return i32(textureNumLevels(bump_heights));
#endif
}

fn heights_texel(slot: u32, at: vec2<i32>, level: i32) -> vec4<f32> {
#ifdef BINDLESS
    return textureLoad(bindless_textures_2d[indices[slot].bump_heights], at, level);
#else
    return textureLoad(bump_heights, at, level);
#endif
}

// As `bump/atlas.rs` lays them out.
fn bounds_texel(slot: u32, at: vec2<i32>) -> vec4<f32> {
#ifdef BINDLESS
    return textureLoad(bindless_textures_2d[indices[slot].bump_bounds], at, 0);
#else
    return textureLoad(bump_bounds, at, 0);
#endif
}
