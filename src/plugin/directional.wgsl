// Baked light where bumps turn the normal.

#define_import_path bevy_fresco::directional

// As in Rust: src/radiosity/gradient.rs, where it is derived.
const FAINT: f32 = 0.4;
const MOST: f32 = 16.0;

// Light as it was baked for the unit normal n, at the unit bumped normal, by its gradient in world space.
fn reshade(light: vec3<f32>, gradient: vec3<f32>, n: vec3<f32>, bumped: vec3<f32>) -> vec3<f32> {
    let level = dot(light, vec3(0.2126, 0.7152, 0.0722));
    if level <= 0.0 {
        return light;
    }
    let times = 1.0 + dot(gradient, bumped - n) / level;
    let bent = FAINT * FAINT / (2.0 * FAINT - min(times, FAINT));
    return light * min(max(times, bent), MOST);
}

// A gradient in world space: turned with its mesh, as long as it was.
fn gradient_to_world(gradient: vec3<f32>, world_from_mesh: mat4x4<f32>) -> vec3<f32> {
    let m = mat3x3(world_from_mesh[0].xyz, world_from_mesh[1].xyz, world_from_mesh[2].xyz);
    return m * gradient / pow(max(abs(determinant(m)), 1e-30), 1.0 / 3.0);
}
