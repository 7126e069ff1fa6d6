use glam::{Vec2, Vec3, vec3};
use serde_json::json;

use super::glb::Glb;
use super::shapes::{Face, Shape, box_face, cuboid, quad};

/// Of the room, in metres. The measurements are in millimetres; these are a hundredth of the
/// numbers, so the room is ten times the size of the real one.
const SIZE: Vec3 = vec3(5.528, 5.488, 5.592);
const LAMP: [Vec3; 2] = [vec3(2.13, 5.288, 2.27), vec3(3.43, 5.388, 3.32)];
const WHITE: [f64; 3] = [0.73; 3];

/// The Cornell box: two blocks in a room with a red wall and a green one, and a lamp.
///
/// After the box that Cornell's Program of Computer Graphics measured,
/// <https://www.graphics.cornell.edu/online/box/data.html>, with one lamp in a casing and the
/// reflectances that are usual for it in RGB.
#[expect(clippy::approx_constant, reason = "3.14 m is a measurement, not π")]
pub(super) fn make() -> Vec<u8> {
    let mut glb = Glb::new("Cornell box");
    let white = glb.material("White", WHITE, json!({}));
    let red = glb.material("Red", [0.63, 0.065, 0.05], json!({}));
    let green = glb.material("Green", [0.14, 0.45, 0.091], json!({}));
    // 17, 12, 4 cd/m²: factors only go up to 1.
    let strength = json!({ "emissiveStrength": 17.0 });
    let lamp = json!({
        "emissiveFactor": [1.0, 12.0 / 17.0, 4.0 / 17.0],
        "extensions": { "KHR_materials_emissive_strength": strength },
    });
    let lamp = glb.material("Lamp", WHITE, lamp);

    for (name, face, material) in [
        ("Floor", Face::Bottom, white),
        ("Ceiling", Face::Top, white),
        ("Back wall", Face::South, white),
        ("Red wall", Face::East, red),
        ("Green wall", Face::West, green),
    ] {
        let wall = box_face(Vec3::ZERO, SIZE, [24; 3], face).inside_out();
        glb.object(name, &wall, material);
    }
    let light = box_face(LAMP[0], LAMP[1], [2; 3], Face::Bottom);
    glb.object("Lamp", &light, lamp);
    let casing = cuboid(LAMP[0], LAMP[1], [2, 1, 2], &[Face::Bottom]);
    glb.object("Lamp casing", &casing, white);
    let short = [[1.30, 0.65], [0.82, 2.25], [2.40, 2.72], [2.90, 1.14]];
    glb.object("Short block", &block(short, 1.65), white);
    let tall = [[4.23, 2.47], [2.65, 2.96], [3.14, 4.56], [4.72, 4.06]];
    glb.object("Tall block", &block(tall, 3.30), white);

    // A 25 mm square picture behind a 35 mm lens, as the real one was photographed.
    let yfov = 2.0 * (0.0125_f64 / 0.035).atan();
    let yfov = (yfov * 1e9).round() / 1e9;
    glb.camera(vec3(2.78, 2.73, -8.0), Vec3::Z, yfov, 1.0);
    glb.finish()
}

/// A block on the floor without its bottom; corners (x, z), counter-clockwise seen from above.
fn block(corners: [[f32; 2]; 4], height: f32) -> Shape {
    let corners = corners.map(Vec2::from);
    let at = |i: usize, y: f32| vec3(corners[i % 4].x, y, corners[i % 4].y);
    let top = quad([0, 1, 2, 3].map(|i| at(i, height)), [8; 2]);
    (0..4)
        .map(|i| {
            let side = [at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)];
            quad(side, [8; 2])
        })
        .fold(top, Shape::and)
}
