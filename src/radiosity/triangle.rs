use glam::Vec3;

/// Area of a triangle, in the squared unit of its corners. Products in `f64`: slivers keep theirs.
pub(crate) fn area([a, b, c]: [Vec3; 3]) -> f32 {
    (0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length()) as f32
}

/// Unit normal of the side that sees the corners counter-clockwise; zero for no area.
pub(crate) fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a)
        .as_dvec3()
        .cross((c - a).as_dvec3())
        .normalize_or_zero()
        .as_vec3()
}
