// The formulas of `bump.wgsl`, which is put before this, on many triangles.

struct Case {
    a: vec4<f32>,
    b: vec4<f32>,
    // w: height
    normal: vec4<f32>,
    // Of texture coordinates along a and b.
    uv: vec4<f32>,
    // Slopes of the map, roughness, variance.
    slopes: vec4<f32>,
    normal_a: vec4<f32>,
    normal_b: vec4<f32>,
}

struct Result {
    // w: roughness
    bumped: vec4<f32>,
    displaced: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> cases: array<Case>;
@group(0) @binding(1) var<storage, read_write> results: array<Result>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cases) {
        return;
    }
    let it = cases[id.x];
    let along = dual(it.normal.xyz, it.a.xyz, it.b.xyz);
    let by_u = surface_gradient(along, it.uv.xz);
    let by_v = surface_gradient(along, it.uv.yw);
    let bumped = bumped_normal(it.normal.xyz, it.slopes.x * by_u + it.slopes.y * by_v);
    let changes = vec2(dot(it.slopes.xy, it.uv.xy), dot(it.slopes.xy, it.uv.zw));
    let displaced = displaced_normal(
        it.normal.xyz, it.a.xyz, it.b.xyz, it.normal_a.xyz, it.normal_b.xyz, it.normal.w, changes,
    );
    results[id.x] = Result(vec4(bumped, roughened(it.slopes.z, it.slopes.w)), vec4(displaced, 0.0));
}
