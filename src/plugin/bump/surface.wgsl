// The bumps of a material on a surface: what `bump.wgsl` makes of what is bound.

#define_import_path bevy_fresco::bump_surface

#import bevy_fresco::{bindings, bump}
#import bevy_pbr::{
    mesh_functions,
    mesh_view_bindings::view,
}
#ifdef FRESCO_PARALLAX
#import bevy_fresco::parallax
#import bevy_pbr::pbr_functions::calculate_view
#endif
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::VertexOutput
#else
#import bevy_pbr::forward_io::VertexOutput
#endif

// What heights are measured in.
const IN_MESH: f32 = 0.0;
const IN_WORLD: f32 = 1.0;
const IN_UV: f32 = 2.0;

// Rays that move further, in texels, come from texture coordinates without sense.
const MOST_TEXELS: f32 = 1e5;

const REPEATS_U: u32 = 1u;
const REPEATS_V: u32 = 2u;
const PASSES_BY: u32 = 4u;

// A surface as it is without relief, and all that bumps need of it, found where all pixels of a quad run
// (`surface`).
struct Surface {
    // Of the material.
    slot: u32,
    // Outward, also where it is seen from behind.
    normal: vec3<f32>,
    a: vec3<f32>,
    b: vec3<f32>,
    along: bump::Dual,
    // Where the mesh's unit along its own normal comes to lie.
    up: vec3<f32>,
}

// A surface raised by bumps.
struct Raised {
    // Unit normal, outward.
    normal: vec3<f32>,
    // Of slopes that the normal does not show.
    variance: f32,
}

// Sums over bumps. Those of the mesh's own unit stand along `Surface::up`, others along the normal.
struct Sum {
    mesh: vec3<f32>,
    world: vec3<f32>,
    height_mesh: f32,
    height_world: f32,
    variance_mesh: f32,
    variance_world: f32,
}

// Texture coordinates with their gradients on the surface and what they change by to the next pixels.
struct Coordinates {
    at: vec2<f32>,
    by_u: vec3<f32>,
    by_v: vec3<f32>,
    dx: vec2<f32>,
    dy: vec2<f32>,
}

// Both texture coordinates of the mesh, as far as anything lies on them.
struct Channels {
    a: Coordinates,
    b: Coordinates,
#ifdef FRESCO_PARALLAX
    // How far what is seen lies below the mesh, the map's range being 1, and texels that were read to find it.
    depth: f32,
    reads: f32,
#endif
}

fn surface(in: VertexOutput) -> Surface {
    var found: Surface;
    found.slot = bindings::slot_of(in.instance_index);
    found.normal = normalize(in.world_normal);
    // Of differences to the camera: far from the origin they are exacter.
    let place = in.world_position.xyz - view.world_position.xyz;
    found.a = dpdxFine(place);
    found.b = dpdyFine(place);
    found.along = bump::dual(found.normal, found.a, found.b);
#ifdef SKINNED
    // Joints scale as they like.
    found.up = found.normal;
#else
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let m = mat3x3(world_from_local[0].xyz, world_from_local[1].xyz, world_from_local[2].xyz);
    found.up = m * normalize(found.normal * m);
#endif
    return found;
}

// By the derivatives on the screen.
fn on_screen(on: Surface, uv: vec2<f32>) -> Coordinates {
    let dx = dpdxFine(uv);
    let dy = dpdyFine(uv);
    return Coordinates(
        uv,
        bump::surface_gradient(on.along, vec2(dx.x, dy.x)),
        bump::surface_gradient(on.along, vec2(dx.y, dy.y)),
        dx,
        dy,
    );
}

#ifdef VERTEX_UV_GRADIENTS
// By what the mesh brings.
fn on_mesh(on: Surface, uv: vec2<f32>, by_u: vec3<f32>, by_v: vec3<f32>) -> Coordinates {
    return Coordinates(
        uv,
        by_u - on.normal * dot(by_u, on.normal),
        by_v - on.normal * dot(by_v, on.normal),
        dpdxFine(uv),
        dpdyFine(uv),
    );
}
#endif

// Through a transform of the material.
fn transformed(uv: Coordinates, row_u: vec3<f32>, row_v: vec3<f32>) -> Coordinates {
    return Coordinates(
        vec2(dot(row_u, vec3(uv.at, 1.0)), dot(row_v, vec3(uv.at, 1.0))),
        row_u.x * uv.by_u + row_u.y * uv.by_v,
        row_v.x * uv.by_u + row_v.y * uv.by_v,
        vec2(dot(row_u.xy, uv.dx), dot(row_v.xy, uv.dx)),
        vec2(dot(row_u.xy, uv.dy), dot(row_v.xy, uv.dy)),
    );
}

// What heights are measured in: for those of the map, how long a unit of its coordinates is on the surface.
fn width_of(uv: Coordinates, one: bindings::Bump) -> f32 {
    let width = sqrt(2.0 / max(dot(uv.by_u, uv.by_u) + dot(uv.by_v, uv.by_v), 1e-30));
    return select(1.0, width, one.row_v.w == IN_UV);
}

// Adds a bump: `relief` at `uv`.
fn add(sum: Sum, one: bindings::Bump, relief: bump::Relief, uv: Coordinates) -> Sum {
    let in_mesh = one.row_v.w == IN_MESH;
    let scale = one.row_u.w * width_of(uv, one);
    let gradient = scale * (relief.slopes.x * uv.by_u + relief.slopes.y * uv.by_v);
    let height = scale * relief.height;
    let variance = scale * scale * bump::slope_variance(relief.variance, uv.by_u, uv.by_v);
    return Sum(
        sum.mesh + select(vec3(0.0), gradient, in_mesh),
        sum.world + select(gradient, vec3(0.0), in_mesh),
        sum.height_mesh + select(0.0, height, in_mesh),
        sum.height_world + select(height, 0.0, in_mesh),
        sum.variance_mesh + select(0.0, variance, in_mesh),
        sum.variance_world + select(variance, 0.0, in_mesh),
    );
}

#ifdef FRESCO_MAIN_BUMP
#ifdef FRESCO_CUBIC
// Four texels of a row of heights.
fn row_of(slot: u32, columns: vec4<i32>, y: i32) -> vec4<f32> {
    return vec4(
        bump::height_of(bindings::heights_texel(slot, vec2(columns.x, y), 0)),
        bump::height_of(bindings::heights_texel(slot, vec2(columns.y, y), 0)),
        bump::height_of(bindings::heights_texel(slot, vec2(columns.z, y), 0)),
        bump::height_of(bindings::heights_texel(slot, vec2(columns.w, y), 0)),
    );
}

fn cubic_relief(slot: u32, uv: vec2<f32>, bits: u32) -> bump::Relief {
    let size = bindings::heights_size(slot);
    let place = uv * vec2<f32>(size) - 0.5;
    let first = vec2<i32>(floor(place));
    let columns = bump::inside(first.x + vec4(-1, 0, 1, 2), size.x, (bits & REPEATS_U) != 0u);
    let rows = bump::inside(first.y + vec4(-1, 0, 1, 2), size.y, (bits & REPEATS_V) != 0u);
    let texels = mat4x4(
        row_of(slot, columns, rows.x),
        row_of(slot, columns, rows.y),
        row_of(slot, columns, rows.z),
        row_of(slot, columns, rows.w),
    );
    return bump::cubic_relief(texels, place - floor(place), vec2<f32>(size), (bits & PASSES_BY) != 0u);
}
#endif

fn sample_bump(slot: u32, one: bindings::Bump, uv: Coordinates) -> bump::Relief {
    let bias = exp2(view.mip_bias);
    let moments = bindings::main_moments(slot, uv.at, bias * uv.dx, bias * uv.dy);
    var relief = bump::relief_of_moments(moments, one.size.z);
#ifdef FRESCO_CUBIC
    let magnified = bump::magnified(uv.dx, uv.dy, one.size.xy);
    // The first condition always holds. It stands there for Mesa 22.3's lavapipe, which crashes on conditions
    // in which it finds uniforms before it finds something else.
    if abs(relief.slopes.x) < bump::HUGE && magnified > 0.0 {
        let cubic = cubic_relief(slot, uv.at, u32(one.size.w));
        relief.slopes = mix(relief.slopes, one.range.y * cubic.slopes, magnified);
        relief.variance *= 1.0 - magnified;
    }
#else
    relief.variance *= 1.0 - bump::magnified(uv.dx, uv.dy, one.size.xy);
#endif
#ifdef FRESCO_CURVATURE
    let texel = bindings::main_heights(slot, uv.at, bias * uv.dx, bias * uv.dy);
    relief.height = one.range.x + one.range.y * bump::height_of(texel);
#endif
    return relief;
}
#endif

// For entry points, where all pixels of a quad run: the texture coordinates there.
fn channels(
    in: VertexOutput,
#ifdef VERTEX_UV_GRADIENTS
    by_u: vec3<f32>,
    by_v: vec3<f32>,
#endif
    on: Surface,
) -> Channels {
    var found: Channels;
#ifdef FRESCO_UV_A
#ifdef VERTEX_UV_GRADIENTS
    found.a = on_mesh(on, in.uv, by_u, by_v);
#else
    found.a = on_screen(on, in.uv);
#endif
#endif
#ifdef FRESCO_UV_B
    found.b = on_screen(on, in.uv_b);
#endif
    return found;
}

// Through the transform of the standard material.
fn by_material(uv: Coordinates, m: mat3x3<f32>) -> Coordinates {
    return transformed(uv, vec3(m[0].x, m[1].x, m[2].x), vec3(m[0].y, m[1].y, m[2].y));
}

#ifdef FRESCO_MAIN_BUMP
// The main bump's own texture coordinates.
fn on_main_bump(one: bindings::Bump, at: Channels, uv_transform: mat3x3<f32>) -> Coordinates {
#ifdef FRESCO_MAIN_UV_B
    let uv = by_material(at.b, uv_transform);
#else
    let uv = by_material(at.a, uv_transform);
#endif
    return transformed(uv, one.row_u.xyz, one.row_v.xyz);
}
#endif

#ifdef FRESCO_PARALLAX
// Moves texture coordinates from where the ray of sight meets the mesh to where it meets the relief.
fn look(in: VertexOutput, on: Surface, mesh: Channels, uv_transform: mat3x3<f32>) -> Channels {
    let one = bindings::main_bump(on.slot);
    let uv = on_main_bump(one, mesh, uv_transform);
    let is_orthographic = view.clip_from_view[3].w == 1.0;
    let V = calculate_view(in.world_position, is_orthographic);
    // Whichever way triangles are wound or mirrored, and whatever Bevy takes for the front.
    let face = cross(on.a, on.b);
    let is_behind = (dot(face, V) < 0.0) != (dot(face, on.normal) < 0.0);
    let side = select(1.0, -1.0, is_behind);
    let up = side * select(on.normal, on.up, one.row_v.w == IN_MESH);
    let slide = parallax::slide(side * on.normal, V, up, one.sight.y);

    let width = width_of(uv, one);
    let away = distance(in.world_position.xyz, view.world_position.xyz);
    // Nothing is far away in an orthographic view, as directional lights have.
    let left = select(clamp(one.sight.z - one.sight.w * away, 0.0, 1.0), 1.0, is_orthographic);
    let bias = exp2(view.mip_bias);
    let mip = parallax::mip_of(on.slot, bias * dpdxCoarse(uv.at), bias * dpdyCoarse(uv.at));
    let depth = abs(one.row_u.w) * width * one.range.y * left;
    let by_depth = depth * vec2(dot(uv.by_u, slide), dot(uv.by_v, slide));
    // What moves by less than half a texel, and so by less than half a pixel, is left out, and comes in by and by.
    let finest = bindings::heights_size(on.slot);
    let texels = length(by_depth * vec2<f32>(parallax::size_of(finest, mip)));
    let shown = smoothstep(0.5, 1.0, texels);

    let is_inverted = is_behind != (one.row_u.w < 0.0);
    let level = select(one.sight.x, 1.0 - one.sight.x, is_inverted);
    let bits = u32(one.size.w);
    let repeats = vec2((bits & REPEATS_U) != 0u, (bits & REPEATS_V) != 0u);
    // Always true, and so is the first condition below. They stand there for Mesa 22.3's lavapipe, as in
    // `sample_bump`: nothing that the march branches on may come from uniforms before it comes from something else.
    let always = abs(on.normal.x) < bump::HUGE;
    let ray = parallax::Ray(
        select(vec2(0.0), uv.at, always),
        select(vec2(0.0), shown * by_depth, always),
        select(0.0, level, always),
        select(false, is_inverted, always),
    );
    var seen = mesh;
    // Written so that what is no number fails it.
    if abs(on.normal.y) < bump::HUGE && shown > 0.0 && texels < MOST_TEXELS {
        let hit = parallax::march(
            on.slot,
            select(vec2(false), repeats, always),
            ray,
            select(0, mip, always),
        );
        seen.depth = shown * hit.depth;
        seen.reads = hit.reads;
    }
    let moved = slide * (depth * seen.depth);
    seen.a.at += vec2(dot(mesh.a.by_u, moved), dot(mesh.a.by_v, moved));
    seen.b.at += vec2(dot(mesh.b.by_u, moved), dot(mesh.b.by_v, moved));
    return seen;
}

// What is drawn as if it lay where it is seen.
fn moved(in: VertexOutput, seen: Channels) -> VertexOutput {
    var out = in;
#ifdef VERTEX_UVS_A
    out.uv = seen.a.at;
#endif
#ifdef VERTEX_UVS_B
    out.uv_b = seen.b.at;
#endif
    return out;
}

// For Bevy's own textures.
fn seen_uvs(seen: Channels, uv_transform: mat3x3<f32>) -> parallax::SeenUvs {
    let a = by_material(seen.a, uv_transform);
    let b = by_material(seen.b, uv_transform);
    let bias = exp2(view.mip_bias);
    return parallax::SeenUvs(a.at, bias * a.dx, bias * a.dy, b.at, bias * b.dx, bias * b.dy);
}
#endif // FRESCO_PARALLAX

// For entry points, before anything is discarded and where all pixels of a quad run: the relief at what is seen.
fn raise(
    on: Surface,
    seen: Channels,
    uv_transform: mat3x3<f32>,
    // Unit normal of Bevy's normal map, outward.
    mapped: vec3<f32>,
) -> Raised {
    var sum = Sum(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, 0.0);
#ifdef FRESCO_MAIN_BUMP
    let main = bindings::main_bump(on.slot);
    let uv = on_main_bump(main, seen, uv_transform);
    sum = add(sum, main, sample_bump(on.slot, main, uv), uv);
#endif
#ifdef FRESCO_DETAIL_BUMP
#ifdef FRESCO_DETAIL_UV_B
    let detail_on = by_material(seen.b, uv_transform);
#else
    let detail_on = by_material(seen.a, uv_transform);
#endif
    let detail = bindings::detail_bump(on.slot);
    let detail_uv = transformed(detail_on, detail.row_u.xyz, detail.row_v.xyz);
    let bias = exp2(view.mip_bias);
    let moments = bindings::detail_moments(on.slot, detail_uv.at, bias * detail_uv.dx, bias * detail_uv.dy);
    sum = add(sum, detail, bump::relief_of_moments(moments, detail.size.z), detail_uv);
#endif

    // The mesh's own unit may be longer than a metre, and stand aslant where it is scaled unevenly. A surface
    // raised by F along d has the normal N (1 + ∇F · d) − ∇F (N · d), d · N apart.
    let upright = dot(on.up, on.normal);
    let aslant = max(1.0 + dot(sum.mesh, on.up - upright * on.normal), 1.0 / bump::MAX_SLOPE);
    let stretch = upright / aslant;
    var gradient = sum.world / aslant + stretch * sum.mesh;

    var raised: Raised;
    raised.variance = sum.variance_mesh * stretch * stretch + sum.variance_world / (aslant * aslant);
    gradient += bump::gradient_of_normal(on.normal, mapped);
#ifdef FRESCO_CURVATURE
    gradient = bump::clamped(gradient);
    raised.normal = bump::displaced_normal(
        on.normal,
        on.a,
        on.b,
        dpdxFine(on.normal),
        dpdyFine(on.normal),
        sum.height_world + upright * sum.height_mesh,
        vec2(dot(gradient, on.a), dot(gradient, on.b)),
    );
#else
    raised.normal = bump::bumped_normal(on.normal, gradient);
#endif
    return raised;
}
