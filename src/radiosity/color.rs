use glam::{DVec3, Vec3};

/// Luminance of linear RGB with the primaries of sRGB (Rec. 709).
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// `a / b` channel by channel; 0 where `b` is not above 0.
pub(crate) fn divide(a: DVec3, b: DVec3) -> Vec3 {
    let one = |a: f64, b: f64| if b > 0.0 { (a / b) as f32 } else { 0.0 };
    Vec3::new(one(a.x, b.x), one(a.y, b.y), one(a.z, b.z))
}
