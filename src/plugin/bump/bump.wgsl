// Bump mapping by surface gradients: the formulas, without anything bound.
//
// The same as `src/bump` of this crate in Rust, name by name; tests compare the two. Derivations are there.

#define_import_path bevy_fresco::bump

// Steeper relief counts as so steep (89.55°).
const MAX_SLOPE: f32 = 128.0;
// Steps whose area is less than this share of a square of the longer one span nothing.
const FLAT: f32 = 1e-6;
// Beyond every number that means something: infinities and what is no number fail to be below it.
const HUGE: f32 = 3e38;
// Cosine to the viewer that what is seen has at least.
const LEAST_TOWARDS: f32 = 1e-3;
// Share of a mean square that half floats may get wrong: not taken for variance.
const ROUNDING: f32 = 0.002;

// Dual to two steps along a surface: gradients are sums of them.
struct Dual {
    a: vec3<f32>,
    b: vec3<f32>,
}

// What is known of a height map at a place. Slopes by texture coordinate of the map, heights in its unit.
struct Relief {
    height: f32,
    slopes: vec2<f32>,
    // Of the slopes, within the footprint of a pixel.
    variance: vec2<f32>,
}

fn longest(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// `(b × N, N × a) / (N · a × b)`; nothing where the steps span no area.
fn dual(normal: vec3<f32>, a: vec3<f32>, b: vec3<f32>) -> Dual {
    let nothing = Dual(vec3(0.0), vec3(0.0));
    let longer = max(longest(a), longest(b));
    if !(longer > 0.0 && longer < HUGE) {
        return nothing;
    }
    let p = a / longer;
    let q = b / longer;
    // Never the area in texture coordinates: that may be nothing or negative.
    let area = dot(normal, cross(p, q));
    if !(abs(area) > FLAT * max(dot(p, p), dot(q, q))) {
        return nothing;
    }
    let scale = 1.0 / area / longer;
    return Dual(cross(q, normal) * scale, cross(normal, p) * scale);
}

// Gradient of what changes by so much along the steps.
fn surface_gradient(along: Dual, changes: vec2<f32>) -> vec3<f32> {
    return changes.x * along.a + changes.y * along.b;
}

// `gradient`, not steeper than can be shown, and nothing if it is no number.
fn clamped(gradient: vec3<f32>) -> vec3<f32> {
    // Written so that what is no number fails it, component by component.
    let is_number = all(abs(gradient) < vec3(HUGE));
    let known = select(vec3(0.0), gradient, is_number);
    let most = max(longest(known), 1e-30);
    let direction = known / most;
    let size = length(direction);
    return direction * min(most, MAX_SLOPE / max(size, 1e-30));
}

// Normal of a surface raised by a height of this gradient.
fn bumped_normal(normal: vec3<f32>, gradient: vec3<f32>) -> vec3<f32> {
    return normalize(normal - clamped(gradient));
}

// The same with nothing left out: `a` and `b` are steps, `normal_a` and `normal_b` changes of the unit normal
// along them.
fn displaced_normal(
    normal: vec3<f32>,
    a: vec3<f32>,
    b: vec3<f32>,
    normal_a: vec3<f32>,
    normal_b: vec3<f32>,
    height: f32,
    changes: vec2<f32>,
) -> vec3<f32> {
    let longer = max(longest(a), longest(b));
    if !(longer > 0.0 && longer < HUGE) {
        return normal;
    }
    let raised_a = (a + normal_a * height + normal * changes.x) / longer;
    let raised_b = (b + normal_b * height + normal * changes.y) / longer;
    let outwards = sign(dot(normal, cross(a / longer, b / longer)));
    let raised = cross(raised_a, raised_b) * outwards;
    let size = dot(raised, raised);
    if !(size > 1e-24 && size < HUGE) {
        return normal;
    }
    return raised * inverseSqrt(size);
}

// Gradient of the surface that another unit normal belongs to, so that it can be added to others.
fn gradient_of_normal(normal: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let outwards = dot(normal, other);
    return (normal * outwards - other) / max(outwards, 1.0 / MAX_SLOPE);
}

// `bumped`, bent as far as it must be to be seen from `view`, as its base `normal` is: relief that leans away
// further would be hidden by relief before it.
fn facing(bumped: vec3<f32>, normal: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    let towards = dot(bumped, view);
    if towards >= LEAST_TOWARDS || dot(normal, view) <= LEAST_TOWARDS {
        return bumped;
    }
    return normalize(bumped + view * (LEAST_TOWARDS - towards));
}

// Variance of slopes on the surface, metres a metre, squared.
fn slope_variance(variance: vec2<f32>, by_u: vec3<f32>, by_v: vec3<f32>) -> f32 {
    return variance.x * dot(by_u, by_u) + variance.y * dot(by_v, by_v);
}

// Perceptual roughness of a surface whose slopes vary: `α² + variance`, with `α` its square.
fn roughened(perceptual: f32, variance: f32) -> f32 {
    let alpha = perceptual * perceptual;
    return sqrt(sqrt(min(alpha * alpha + variance, 1.0)));
}

// Weights of the texels −1, 0, 1, 2 at `t` from texel 0 towards 1: Catmull–Rom, through the texels.
fn through_texels(t: f32) -> vec4<f32> {
    let t2 = t * t;
    let t3 = t2 * t;
    return 0.5 * vec4(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2);
}

// The slope of the same, by texel.
fn through_texels_slope(t: f32) -> vec4<f32> {
    let t2 = t * t;
    return 0.5 * vec4(-3.0 * t2 + 4.0 * t - 1.0, 9.0 * t2 - 10.0 * t, -9.0 * t2 + 8.0 * t + 1.0, 3.0 * t2 - 2.0 * t);
}

// The same of the cubic B-spline, which passes by the texels: smoother.
fn past_texels(t: f32) -> vec4<f32> {
    let r = 1.0 - t;
    let t2 = t * t;
    let t3 = t2 * t;
    return vec4(r * r * r, 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3) / 6.0;
}

fn past_texels_slope(t: f32) -> vec4<f32> {
    let r = 1.0 - t;
    let t2 = t * t;
    return 0.5 * vec4(-r * r, 3.0 * t2 - 4.0 * t, -3.0 * t2 + 2.0 * t + 1.0, t2);
}

// Where texels beyond the border of `n` are taken from.
fn inside(i: vec4<i32>, n: i32, repeats: bool) -> vec4<i32> {
    let rest = i % n;
    let repeated = select(rest, rest + n, rest < vec4(0));
    return select(clamp(i, vec4(0), vec4(n - 1)), repeated, repeats);
}

// Heights are kept as the sum of two half floats: one alone has steps that show.
fn height_of(texel: vec4<f32>) -> f32 {
    return texel.x + texel.y;
}

// Height and slopes between texels by a cubic, for magnified maps. `texels`: heights −1 to 2, each row a column of
// the matrix; `t`: from those at 0 towards 1; `size`: of the map.
fn cubic_relief(texels: mat4x4<f32>, t: vec2<f32>, size: vec2<f32>, passes_by: bool) -> Relief {
    let across = select(through_texels(t.x), past_texels(t.x), passes_by);
    let down = select(through_texels(t.y), past_texels(t.y), passes_by);
    let across_slope = select(through_texels_slope(t.x), past_texels_slope(t.x), passes_by);
    let down_slope = select(through_texels_slope(t.y), past_texels_slope(t.y), passes_by);
    let by_row = across * texels;
    let slopes = vec2(dot(across_slope * texels, down), dot(by_row, down_slope));
    return Relief(dot(by_row, down), slopes * size, vec2(0.0));
}

// Slopes and their variance from means and mean squares, of which `steepest` is the unit.
fn relief_of_moments(moments: vec4<f32>, steepest: f32) -> Relief {
    let variance = max(moments.zw - moments.xy * moments.xy - ROUNDING * moments.zw, vec2(0.0));
    return Relief(0.0, moments.xy * steepest, variance * steepest * steepest);
}

// How much a map is magnified, from 0 (a pixel is a texel or more) to 1 (half a texel or less). `dx`, `dy`: what
// its coordinates change by to the next pixels.
fn magnified(dx: vec2<f32>, dy: vec2<f32>, size: vec2<f32>) -> f32 {
    let texels = max(length(dx * size), length(dy * size));
    return 1.0 - smoothstep(0.5, 1.0, texels);
}
