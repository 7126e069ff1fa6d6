use glam::{Vec2, Vec3};

/// Blinn's formula to the letter: the unit normal of a surface with the tangents `pu`, `pv`, raised by a
/// map with the slopes `Fu`, `Fv`. `None` where the tangents span nothing.
///
/// For teaching and for tests: [`bumped_normal`](super::bumped_normal) gives the same and works where this
/// does not. Where texture coordinates are mirrored, `pu × pv` and so the result point inwards.
pub fn blinn_normal(pu: Vec3, pv: Vec3, slopes: Vec2) -> Option<Vec3> {
    let n = pu.cross(pv);
    let bumped = n + (slopes.x * n.cross(pv) - slopes.y * n.cross(pu)) / n.length();
    bumped.try_normalize().filter(|n| n.is_finite())
}
