// Where a ray of sight meets relief: the march through the main bump's height map.
//
// The same as `src/bump/parallax.rs` of this crate, name by name; derivations are there.

#define_import_path bevy_fresco::parallax

#import bevy_fresco::bindings

// Reads of bounds at most.
const MOST_STEPS: i32 = 512;
// Cosines and slopes below this are none.
const LEAST: f32 = 1e-6;

// Texture coordinates of what is seen, after the material's transform, and what those of the mesh change by to the
// next pixels: what is seen jumps at edges of relief, and smaller sizes of textures would show there.
struct SeenUvs {
    uv: vec2<f32>,
    uv_dx: vec2<f32>,
    uv_dy: vec2<f32>,
    uv_b: vec2<f32>,
    uv_b_dx: vec2<f32>,
    uv_b_dy: vec2<f32>,
}

struct Ray {
    // Texture coordinates of the map where it meets the mesh.
    uv: vec2<f32>,
    // What they change by while it sinks from the map's highest point to its lowest.
    slide: vec2<f32>,
    // How high the mesh lies between the map's lowest point (0) and its highest (1).
    level: f32,
    is_inverted: bool,
}

struct Hit {
    // Below the mesh, the map's range being 1.
    depth: f32,
    // Texels that were read.
    reads: f32,
}

// Patches of a block: those from the first to the last before `end`, along both axes.
struct Block {
    // Where the map begins there, if it repeats.
    period: vec2<i32>,
    first: vec2<i32>,
    end: vec2<i32>,
}

// How far what is seen moves along the surface by depth.
fn slide(normal: vec3<f32>, view: vec3<f32>, up: vec3<f32>, steepest: f32) -> vec3<f32> {
    let towards = dot(view, normal);
    let upright = dot(up, normal);
    let along = view - towards * normal;
    let cosine = max(max(towards, length(along) / steepest), LEAST);
    return up - upright * normal - along * (upright / cosine);
}

// The level of a map whose texels are no larger than pixels, and larger than half of them: taken once for all of
// a ray, from what the mesh's texture coordinates change by to the next pixels. Of coarse derivatives, so that the
// four pixels of a quad take the same: llvmpipe reads the same size for them.
fn mip_of(slot: u32, dx: vec2<f32>, dy: vec2<f32>) -> i32 {
    let size = vec2<f32>(bindings::heights_size(slot));
    let texels = max(length(dx * size), length(dy * size));
    return clamp(i32(floor(log2(max(texels, 1.0)))), 0, bindings::heights_levels(slot) - 1);
}

fn remainder(i: vec2<i32>, n: vec2<i32>) -> vec2<i32> {
    let rest = i % n;
    return select(rest, rest + n, rest < vec2(0));
}

// Heights 0 to 1 are kept as the sum of two half floats.
fn share_at(slot: u32, at: vec2<i32>, mip: i32, repeats: vec2<bool>, is_inverted: bool) -> f32 {
    let size = size_of(bindings::heights_size(slot), mip);
    let inside = select(clamp(at, vec2(0), size - 1), remainder(at, size), repeats);
    let texel = bindings::heights_texel(slot, inside, mip);
    let share = texel.x + texel.y;
    return select(share, 1.0 - share, is_inverted);
}

// Size of a level of a map, in texels or blocks.
fn size_of(finest: vec2<i32>, level: i32) -> vec2<i32> {
    return max(finest >> vec2(u32(level)), vec2(1));
}

// Height that nothing in the block with this patch goes beyond. `level`: of the map; blocks of it lie where
// `atlas.rs` puts them, two a texel.
fn ceiling_of(slot: u32, block: vec2<i32>, finest: vec2<i32>, level: i32, is_inverted: bool) -> f32 {
    let above = finest.y >> u32(max(level - 1, 0));
    let row = finest.y - above + max(level - firstLeadingBit(finest.y) - 2, 0);
    let first = select(vec2(0), vec2(finest.x, row), level > 0);
    let at = first + min(block, size_of(finest, level) - 1);
    let pair = bindings::bounds_texel(slot, vec2(at.x >> 1u, at.y));
    let own = select(pair.xy, pair.zw, (at.x & 1) == 1);
    return select(own.x, own.y, is_inverted);
}

// Where on a line, from `s` to `out`, the ray meets a patch; 2 if it does not. `at`: place at `s` within the patch.
fn meets(at: vec2<f32>, slope: vec2<f32>, corners: vec4<f32>, s: f32, out: f32) -> f32 {
    let across = corners.y - corners.x;
    let down = corners.z - corners.x;
    let twist = corners.w - corners.y - down;
    let c = corners.x + at.x * across + at.y * down + at.x * at.y * twist - (1.0 - s);
    let b = slope.x * across + slope.y * down + (at.x * slope.y + at.y * slope.x) * twist + 1.0;
    let a = slope.x * slope.y * twist;
    let square = b * b - 4.0 * a * c;
    let below = b + sqrt(max(square, 0.0));
    let further = s - 2.0 * c / max(below, 1e-30);
    let is_met = square >= 0.0 && below > 0.0 && further <= out;
    return select(select(2.0, further, is_met), s, c >= 0.0);
}

// The block of a level that a patch is in: cut off where a map begins again.
fn block_of(patch_at: vec2<i32>, size: vec2<i32>, level: i32, repeats: vec2<bool>) -> Block {
    let period = select(vec2(0), patch_at - remainder(patch_at, size), repeats);
    let shift = vec2(u32(level));
    let first = (((patch_at - period) >> shift) << shift) + period;
    let end = first + (1i << u32(level));
    return Block(period, first, select(end, min(end, period + size), repeats));
}

// The patch at a place within a block. Never back from one that it was in: at borders rounding would let it go to
// and fro.
fn onward(place: vec2<f32>, slope: vec2<f32>, patch_at: vec2<i32>, block: Block) -> vec2<i32> {
    let at = vec2<i32>(floor(place));
    let further = select(min(at, patch_at), max(at, patch_at), slope > vec2(0.0));
    return clamp(further, block.first, block.end - 1);
}

// The first point of the surface on a ray, on level `mip` of the map.
fn march(slot: u32, repeats: vec2<bool>, ray: Ray, mip: i32) -> Hit {
    let finest = bindings::heights_size(slot);
    let size = size_of(finest, mip);
    let slope = ray.slide * vec2<f32>(size);
    let uv = select(ray.uv, ray.uv - floor(ray.uv), repeats);
    // At `start + s slope` the ray's height is `1 − s`.
    let start = uv * vec2<f32>(size) - 0.5 - slope * (1.0 - ray.level);
    let moves = abs(slope) > vec2(LEAST);
    let inverse = 1.0 / select(vec2(1.0), slope, moves);
    let coarsest = bindings::heights_levels(slot) - 1 - mip;
    var level = clamp(i32(log2(max(length(slope), 1.0))) - 3, 0, coarsest);
    var s = 0.0;
    var reads = 0.0;
    var patch_at = vec2<i32>(floor(start));
    for (var i = 0; i < MOST_STEPS; i++) {
        let block = block_of(patch_at, size, level, repeats);
        let border = vec2<f32>(select(block.first, block.end, slope > vec2(0.0)));
        let leaves = select(vec2(2.0), (border - start) * inverse, moves);
        let out = max(s, min(min(leaves.x, leaves.y), 1.0));
        let inside = clamp(patch_at - block.period, vec2(0), size - 1);
        let ceiling = ceiling_of(slot, inside >> vec2(u32(level)), finest, mip + level, ray.is_inverted);
        reads += 1.0;
        if 1.0 - out <= ceiling {
            if level > 0 {
                // Down to where the ray is as low as the block's highest point.
                s = min(max(s, 1.0 - ceiling), out);
                patch_at = onward(start + s * slope, slope, patch_at, block);
                level -= 1;
                continue;
            }
            reads += 4.0;
            let corners = vec4(
                share_at(slot, patch_at, mip, repeats, ray.is_inverted),
                share_at(slot, patch_at + vec2(1, 0), mip, repeats, ray.is_inverted),
                share_at(slot, patch_at + vec2(0, 1), mip, repeats, ray.is_inverted),
                share_at(slot, patch_at + vec2(1, 1), mip, repeats, ray.is_inverted),
            );
            let at = start + s * slope - vec2<f32>(patch_at);
            let hit = meets(at, slope, corners, s, out);
            if hit < 2.0 {
                s = hit;
                break;
            }
        }
        s = out;
        if out >= 1.0 {
            break;
        }
        let along = onward(start + s * slope, slope, patch_at, block);
        let beyond = select(block.first - 1, block.end, slope > vec2(0.0));
        let crosses_u = leaves.x <= leaves.y;
        let next = select(along, beyond, vec2(crosses_u, !crosses_u));
        // Larger blocks again where one of them begins.
        let parent = vec2(u32(level + 1));
        if any((next >> parent) != (patch_at >> parent)) {
            level = min(level + 1, coarsest);
        }
        patch_at = next;
    }
    return Hit(s - (1.0 - ray.level), reads);
}
