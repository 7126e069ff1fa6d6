//! How far a displaced square is from its map, measured point by point.

use bevy_fresco::displacement::{Displaced, DisplacementSettings};
use bevy_fresco::height_map::HeightMap;
use glam::{Vec2, Vec3};

/// The distance of a square in the plane z = 0 that was raised from its map, measured at a dense grid of
/// points: from each the distance to the nearest triangle over it or beside it.
pub(crate) fn error_of_plane(
    displaced: &Displaced,
    map: &HeightMap,
    settings: &DisplacementSettings,
    samples: u32,
) -> f32 {
    let part = &displaced.parts[0];
    let cells = 512;
    let mut over: Vec<Vec<u32>> = vec![Vec::new(); cells * cells];
    let cell = |x: f32| ((x * cells as f32).floor().max(0.0) as usize).min(cells - 1);
    for (i, t) in (0..).zip(&part.mesh.triangles) {
        let [a, b, c] = t.map(|v| part.positions[v as usize]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for y in cell(low.y - 1e-3)..=cell(high.y + 1e-3) {
            for x in cell(low.x - 1e-3)..=cell(high.x + 1e-3) {
                over[y * cells + x].push(i);
            }
        }
    }
    let mut worst = 0.0_f32;
    for j in 0..=samples {
        for i in 0..=samples {
            let [x, y] = [i, j].map(|k| k as f32 / samples as f32);
            let height = settings.scale
                * (map.height(Vec2::new(x, 1.0 - y), settings.kernel) - settings.mid_level);
            let p = Vec3::new(x, y, height);
            let near = over[cell(y) * cells + cell(x)].iter().map(|&t| {
                let t = part.mesh.triangles[t as usize];
                distance(p, t.map(|v| part.positions[v as usize]))
            });
            worst = worst.max(near.fold(f32::INFINITY, f32::min));
        }
    }
    worst
}

/// Of a point from a triangle: from its plane if it is over it, else from its sides.
fn distance(p: Vec3, corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(p0, p1)| (*p1 - *p0).cross(p - *p0).dot(n) >= 0.0);
    if inside {
        return ((p - a).dot(n) / n.length()).abs();
    }
    let to_side = |(q, r): (Vec3, Vec3)| {
        let along = ((p - q).dot(r - q) / (r - q).length_squared()).clamp(0.0, 1.0);
        p.distance(q + along * (r - q))
    };
    [(a, b), (b, c), (c, a)]
        .map(to_side)
        .into_iter()
        .fold(f32::INFINITY, f32::min)
}
