use glam::{Vec3, vec3};
use serde_json::json;

use super::glb::Glb;
use super::shapes::cuboid;

/// A closed room whose walls all emit 1 and reflect one half.
///
/// Whatever its shape, every point of it receives the same light: radiance is
/// 1 / (1 − 0.5) = 2 cd/m² everywhere, irradiance 2 π lx.
pub(super) fn make() -> Vec<u8> {
    let mut glb = Glb::new("Furnace");
    let glowing = glb.material(
        "Glowing",
        [0.5; 3],
        json!({ "emissiveFactor": [1.0, 1.0, 1.0] }),
    );
    let room = cuboid(Vec3::ZERO, vec3(2.0, 1.0, 3.0), [8; 3], &[]).inside_out();
    glb.object("Furnace", &room, glowing);
    glb.camera(vec3(1.0, 0.5, 2.8), Vec3::NEG_Z, 1.0, 1.0);
    glb.finish()
}
