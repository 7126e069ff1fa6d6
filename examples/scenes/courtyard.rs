use glam::{Vec3, vec3};
use serde_json::json;

use super::glb::{Glb, MaterialIndex};
use super::images;
use super::shapes::{Face, Shape, box_face, column, cuboid, quad};

/// How far apart vertices are, roughly, in metres.
const CELL: f32 = 0.4;

/// The materials without texture.
struct Paints {
    white: MaterialIndex,
    terracotta: MaterialIndex,
    ochre: MaterialIndex,
    stone: MaterialIndex,
    wood: MaterialIndex,
}

/// An open court of 12 m by 10 m in the afternoon sun, with an arcade, a niche and some shade.
///
/// East is +x and south +z, which is where the sun stands.
pub(super) fn make() -> Vec<u8> {
    let mut glb = Glb::new("Courtyard");
    let paints = Paints {
        white: glb.material("Whitewash", [0.8, 0.78, 0.74], json!({})),
        terracotta: glb.material("Terracotta", [0.72, 0.3, 0.17], json!({})),
        ochre: glb.material("Ochre", [0.74, 0.52, 0.22], json!({})),
        stone: glb.material("Stone", [0.6, 0.57, 0.52], json!({})),
        wood: glb.material("Wood", [0.36, 0.2, 0.1], json!({})),
    };
    add_floor(&mut glb);
    add_walls(&mut glb, &paints);
    add_arcade(&mut glb, &paints);
    add_niche(&mut glb, &paints);
    add_benches(&mut glb, &paints);
    add_fence(&mut glb);
    add_awning(&mut glb);
    add_lights(&mut glb);
    glb.camera(
        vec3(5.6, 5.4, 9.4),
        vec3(-0.52, -0.42, -0.86),
        0.9,
        16.0 / 9.0,
    );
    glb.finish()
}

fn add_floor(glb: &mut Glb) {
    let paving = glb.texture("Paving", &images::paving());
    let texture = json!({ "baseColorTexture": { "index": paving.0 } });
    let material = glb.material(
        "Paving",
        [1.0; 3],
        json!({ "pbrMetallicRoughness": texture }),
    );
    let floor = block_face([-6.0, 0.0, -5.0], [6.0, 0.0, 5.0], Face::Top);
    let mesh = glb.mesh("Floor", &floor.with_uv_scale(2.0), material, true);
    glb.node("Floor", mesh, json!({}));
}

/// Four walls of different heights, 0.3 m thick.
fn add_walls(glb: &mut Glb, paints: &Paints) {
    for (name, low, high, paint) in [
        (
            "North wall",
            [-6.3, 0.0, -5.3],
            [6.3, 4.0, -5.0],
            paints.terracotta,
        ),
        (
            "West wall",
            [-6.3, 0.0, -5.0],
            [-6.0, 3.2, 5.0],
            paints.white,
        ),
        ("East wall", [6.0, 0.0, -5.0], [6.3, 2.4, 5.0], paints.ochre),
        (
            "South wall",
            [-6.3, 0.0, 5.0],
            [6.3, 1.2, 5.3],
            paints.white,
        ),
    ] {
        glb.object(name, &block(low, high, &[Face::Bottom]), paint);
    }
}

/// A row of columns along the west wall that carries a roof.
fn add_arcade(glb: &mut Glb, paints: &Paints) {
    let shaft = column(0.2, 2.6, 16, 6);
    let mesh = glb.mesh("Column", &shaft, paints.stone, false);
    for i in 0..5 {
        let place = json!({ "translation": [-4.0, 0.0, -3.6 + 1.8 * f64::from(i)] });
        glb.node(&format!("Column {}", i + 1), mesh, place);
    }
    let roof = block(
        [-6.0, 2.6, -5.0],
        [-3.6, 2.8, 5.0],
        &[Face::West, Face::North],
    );
    glb.object("Arcade roof", &roof, paints.stone);
}

/// A dim corner in the north-east: a wall and a roof, open to the south.
fn add_niche(glb: &mut Glb, paints: &Paints) {
    let wall = block(
        [3.4, 0.0, -5.0],
        [3.6, 2.4, -2.6],
        &[Face::Bottom, Face::North],
    );
    glb.object("Niche wall", &wall, paints.white);
    let roof = block([3.4, 2.4, -5.0], [6.3, 2.6, -2.6], &[Face::North]);
    glb.object("Niche roof", &roof, paints.stone);
}

/// One mesh twice, the second a mirror image.
fn add_benches(glb: &mut Glb, paints: &Paints) {
    let cells = [6, 1, 2];
    let seat = cuboid(vec3(-1.0, 0.4, -0.25), vec3(1.0, 0.5, 0.25), cells, &[]);
    let leg = |x: f32| {
        let (low, high) = (vec3(x, 0.0, -0.2), vec3(x + 0.12, 0.4, 0.2));
        cuboid(low, high, [1, 2, 2], &[Face::Bottom, Face::Top])
    };
    // One end only, so that the mirror image is another bench.
    let arm = cuboid(
        vec3(0.9, 0.5, -0.25),
        vec3(1.0, 0.85, 0.25),
        [1, 2, 2],
        &[Face::Bottom],
    );
    let bench = seat.and(leg(-0.9)).and(leg(0.7)).and(arm);
    let mesh = glb.mesh("Bench", &bench, paints.wood, false);
    glb.node("Bench", mesh, json!({ "translation": [-0.6, 0.0, 0.2] }));
    // A quarter turn around +y.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let place = json!({
        "rotation": [0.0, half, 0.0, half],
        "scale": [-1.0, 1.0, 1.0],
        "translation": [-2.6, 0.0, 1.6],
    });
    glb.node("Bench mirrored", mesh, place);
}

/// A sheet with round holes that let the sun through.
fn add_fence(glb: &mut Glb) {
    let holes = glb.texture("Holes", &images::holes());
    let look = json!({
        "alphaCutoff": 0.5,
        "alphaMode": "MASK",
        "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": holes.0 } },
    });
    let material = glb.material("Fence", [1.0; 3], look);
    let corners = [[1.2, 0.0], [4.4, 0.0], [4.4, 1.6], [1.2, 1.6]];
    let sheet = quad(corners.map(|[x, y]| vec3(x, y, 2.4)), [8, 4]);
    let mesh = glb.mesh("Fence", &sheet.with_uv_scale(0.8), material, true);
    glb.node("Fence", mesh, json!({}));
}

/// Cloth at the north wall that lets half the light through.
fn add_awning(glb: &mut Glb) {
    let look = json!({
        "alphaMode": "BLEND",
        "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorFactor": [0.85, 0.16, 0.1, 0.5] },
    });
    let cloth = glb.material("Awning", [1.0; 3], look);
    let sheet = quad(
        [
            vec3(-2.4, 2.3, -2.8),
            vec3(2.0, 2.3, -2.8),
            vec3(2.0, 3.1, -5.0),
            vec3(-2.4, 3.1, -5.0),
        ],
        [11, 6],
    );
    glb.object("Awning", &sheet, cloth);
}

/// The sun in lux, and two lamps in candela that light the niche.
fn add_lights(glb: &mut Glb) {
    let sun = json!({ "color": [1.0, 0.93, 0.8], "intensity": 3.0, "type": "directional" });
    glb.light("Sun", sun, vec3(6.0, 10.0, 8.0), vec3(-0.5, -0.8, -0.55));
    let lamp = json!({ "color": [1.0, 0.6, 0.25], "intensity": 0.8, "type": "point" });
    glb.light("Lamp", lamp, vec3(5.3, 1.0, -4.2), Vec3::NEG_Z);
    let spot = json!({
        "color": [0.7, 0.85, 1.0],
        "intensity": 3.0,
        "spot": { "innerConeAngle": 0.3, "outerConeAngle": 0.55 },
        "type": "spot",
    });
    glb.light("Spot", spot, vec3(4.5, 2.2, -3.2), vec3(-0.15, -0.5, -0.85));
}

/// How many cells of about [`CELL`] the box between two corners has along each axis.
fn cells(low: [f32; 3], high: [f32; 3]) -> [u32; 3] {
    [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / CELL).round().max(1.0) as u32)
}

fn block(low: [f32; 3], high: [f32; 3], open: &[Face]) -> Shape {
    cuboid(low.into(), high.into(), cells(low, high), open)
}

fn block_face(low: [f32; 3], high: [f32; 3], face: Face) -> Shape {
    box_face(low.into(), high.into(), cells(low, high), face)
}
