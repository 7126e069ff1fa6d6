use std::ops::Range;

use bevy::prelude::*;

/// Relief that is seen from the side, on a surface that stays flat: each pixel shows what the ray of sight meets of
/// the height map (image-space displacement).
///
/// All textures of the material follow, on either set of texture coordinates; lightmaps and baked light do not. The
/// outline stays that of the mesh, and so does the depth: what touches the surface cuts it in a straight line, and
/// relief casts no shadows; but holes of masked materials let light through where the light sees them.
///
/// The march finds the first point of the surface between texels, whatever the depth and the angle, and reads
/// about as many texels as other methods take layers (`docs/bump_mapping.md`). Pixels are no finer than texels for
/// it: from afar it takes a smaller size of the map, and ends where nothing would move by half a pixel.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct Parallax {
    /// Height of the map, in its own unit, at which the mesh lies; a displaced mesh of this middle level has the
    /// same surface. `None`: its highest point, so that relief only sinks in. Below that, relief also stands out, and
    /// at borders of the mesh what would stand out beyond them is cut off.
    pub level: Option<f32>,
    /// How far rays of sight lean at most: the tangent of their angle to the normal, 0 and more. 5 is 78.7°. Beyond,
    /// relief looks shallower than it is, rather than sliding over the surface.
    pub max_slope: f32,
    /// Distances from the camera in metres at which relief begins to become shallower and at which it is flat.
    /// Orthographic views have no distances: relief is as deep everywhere.
    pub fade: Range<f32>,
}

impl Default for Parallax {
    fn default() -> Self {
        Self {
            level: None,
            max_slope: 5.0,
            fade: f32::INFINITY..f32::INFINITY,
        }
    }
}

impl Parallax {
    /// `Bump::sight` in `surface.wgsl`. `range`: the map's lowest height and how much higher its highest is;
    /// where heights are depths, the highest point is the lowest of the map.
    pub(super) fn uniform(&self, range: Vec2, are_depths: bool) -> Vec4 {
        let top = if are_depths { 0.0 } else { 1.0 };
        let level = match self.level {
            Some(level) if range.y > 0.0 => (level - range.x) / range.y,
            _ => top,
        };
        let Range { start, end } = self.fade;
        let [left, by_distance] = if end.is_finite() {
            let length = (end - start).max(1e-6);
            [end / length, 1.0 / length]
        } else {
            [1.0, 0.0]
        };
        Vec4::new(level, self.max_slope.max(1e-6), left, by_distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_lies_where_it_is_said() {
        let range = Vec2::new(-1.0, 4.0);
        let level = |level, are_depths| {
            let parallax = Parallax { level, ..default() };
            parallax.uniform(range, are_depths).x
        };
        assert_eq!(level(None, false), 1.0);
        assert_eq!(level(None, true), 0.0);
        assert_eq!(level(Some(1.0), false), 0.5);
        let flat = Parallax {
            level: Some(0.3),
            ..default()
        };
        assert_eq!(flat.uniform(Vec2::new(0.7, 0.0), false).x, 1.0);
    }

    #[test]
    fn relief_fades_with_distance() {
        let left = |fade, distance: f32| {
            let parallax = Parallax { fade, ..default() };
            let uniform = parallax.uniform(Vec2::Y, false);
            (uniform.z - uniform.w * distance).clamp(0.0, 1.0)
        };
        assert_eq!(left(10.0..20.0, 5.0), 1.0);
        assert_eq!(left(10.0..20.0, 15.0), 0.5);
        assert_eq!(left(10.0..20.0, 25.0), 0.0);
        assert_eq!(left(f32::INFINITY..f32::INFINITY, 1e6), 1.0);
        assert_eq!(left(10.0..f32::INFINITY, 1e6), 1.0);
        assert_eq!(left(10.0..10.0, 9.9), 1.0);
        assert_eq!(left(10.0..10.0, 10.1), 0.0);
    }
}
