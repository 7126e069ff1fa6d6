use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, vec2, vec3};
use serde_json::json;

use super::glb::Glb;
use super::shapes::{Shape, cuboid, quad};

/// Metres that a map covers on the floor and on the box.
const MAP: f32 = 1.5;

/// Bare shapes with the edges at which displacement tears: a floor of two triangles, a box with hard edges, a
/// ball with a seam.
pub(super) fn make() -> Vec<u8> {
    let mut glb = Glb::new("Relief");
    let ground = glb.material("Ground", [0.6, 0.58, 0.55], json!({}));
    let clay = glb.material("Clay", [0.7, 0.5, 0.4], json!({}));
    let stone = glb.material("Stone", [0.5, 0.55, 0.65], json!({}));
    let corners = [
        vec3(-3.0, 0.0, 3.0),
        vec3(3.0, 0.0, 3.0),
        vec3(3.0, 0.0, -3.0),
        vec3(-3.0, 0.0, -3.0),
    ];
    let floor = quad(corners, [1, 1]).with_uv_scale(MAP);
    let half = vec3(0.75, 0.75, 0.75);
    let block = cuboid(-half, half, [1; 3], &[]).with_uv_scale(MAP);
    let meshes = [
        ("Floor", glb.mesh("Floor", &floor, ground, true), json!({})),
        (
            "Ball",
            glb.mesh("Ball", &ball(0.9, 24, 12), clay, true),
            json!({ "translation": [-1.3, 1.0, 0.0] }),
        ),
        (
            "Box",
            glb.mesh("Box", &block, stone, true),
            json!({ "rotation": [0.0, 0.247, 0.0, 0.969], "translation": [1.3, 0.85, 0.0] }),
        ),
    ];
    for (name, mesh, placement) in meshes {
        glb.node(name, mesh, placement);
    }
    let sun = json!({ "intensity": 20_000.0, "type": "directional" });
    let down = vec3(-0.65, -0.56, -0.51).normalize();
    glb.light("Sun", sun, Vec3::Y * 5.0, down);
    glb.camera(
        vec3(0.0, 2.6, 5.2),
        vec3(0.0, -0.39, -0.92),
        0.75,
        4.0 / 3.0,
    );
    glb.finish()
}

/// A ball by longitude and latitude, the map twice around it. The last column is at the place of the first,
/// to the bit.
fn ball(radius: f32, columns: u32, rows: u32) -> Shape {
    let mut shape = Shape::default();
    for y in 0..=rows {
        for x in 0..=columns {
            let uv = vec2(x as f32 / columns as f32, y as f32 / rows as f32);
            let turn = TAU * (x % columns) as f32 / columns as f32;
            let across = if y % rows == 0 {
                0.0
            } else {
                (PI * uv.y).sin()
            };
            let out = vec3(across * turn.cos(), (PI * uv.y).cos(), -across * turn.sin());
            shape.positions.push(out * radius);
            shape.normals.push(out);
            shape.uvs.push(uv * Vec2::new(2.0, 1.0));
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let a = y * (columns + 1) + x;
            let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
            // At the poles one of the two has no area.
            if y + 1 < rows {
                shape.triangles.push([a, c, d]);
            }
            if y > 0 {
                shape.triangles.push([a, d, b]);
            }
        }
    }
    shape
}
