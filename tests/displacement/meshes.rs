//! Meshes with the seams that tear.

use std::f32::consts::{PI, TAU};

use bevy_fresco::displacement::Base;
use bevy_fresco::height_map::{HeightMap, Wrap};
use glam::{Vec2, Vec3, vec2, vec3};

/// A mesh of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn base(&self) -> Base<'_> {
        Base {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            triangles: &self.triangles,
        }
    }

    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Corners counter-clockwise.
    pub(crate) fn quad(&mut self, corners: [Vec3; 4], uvs: [Vec2; 4]) {
        let normal = (corners[1] - corners[0])
            .cross(corners[3] - corners[0])
            .normalize();
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| self.vertex(corners[i], normal, uvs[i]));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

pub(crate) const SQUARE: [Vec2; 4] = [
    vec2(0.0, 1.0),
    vec2(1.0, 1.0),
    vec2(1.0, 0.0),
    vec2(0.0, 0.0),
];

/// A square of so many metres a side in the plane z = 0, the whole map on it.
pub(crate) fn plane(side: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let corners = SQUARE.map(|uv| vec3(uv.x, 1.0 - uv.y, 0.0) * side);
    mesh.quad(corners, SQUARE);
    mesh
}

/// A cube from −1 to 1 with hard edges: 24 vertices, the map on each side.
pub(crate) fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let out = Vec3::AXES[axis] * sign;
            let right = Vec3::AXES[(axis + 1) % 3] * sign;
            let up = Vec3::AXES[(axis + 2) % 3];
            let corners = [
                out - right - up,
                out + right - up,
                out + right + up,
                out - right + up,
            ];
            mesh.quad(corners, SQUARE);
        }
    }
    mesh
}

/// A surface of `columns × rows` quads over (u, v), the last column at the place of the first, as vertices of
/// its own. Quads that end in a pole are one triangle. `v` runs down.
pub(crate) fn seamed(columns: u32, rows: u32, at: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Mesh {
    let mut mesh = Mesh::default();
    for y in 0..=rows {
        for x in 0..=columns {
            let (u, v) = (x as f32 / columns as f32, y as f32 / rows as f32);
            // The seam to the bit.
            let (position, normal) = at(if x == columns { 0.0 } else { u }, v);
            mesh.vertex(position, normal, vec2(u, v));
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let a = y * (columns + 1) + x;
            let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
            for t in [[a, c, d], [a, d, b]] {
                let [p, q, r] = t.map(|v| mesh.positions[v as usize]);
                if p != q && q != r && r != p {
                    mesh.triangles.push(t);
                }
            }
        }
    }
    mesh
}

/// Where on the unit sphere a longitude and latitude are, the poles to the bit.
pub(crate) fn on_sphere(u: f32, v: f32) -> Vec3 {
    if v == 0.0 || v == 1.0 {
        return Vec3::Y * (1.0 - 2.0 * v);
    }
    let (sin, cos) = (PI * v).sin_cos();
    let (across, along) = (TAU * u).sin_cos();
    vec3(sin * along, cos, -sin * across)
}

/// The unit sphere.
pub(crate) fn sphere(columns: u32, rows: u32) -> Mesh {
    seamed(columns, rows, |u, v| {
        let p = on_sphere(u, v);
        (p, p)
    })
}

/// A cylinder about y, of radius and height 1, without lids.
pub(crate) fn cylinder(columns: u32, rows: u32, inwards: bool) -> Mesh {
    let sign = if inwards { -1.0 } else { 1.0 };
    let mut mesh = seamed(columns, rows, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        let out = vec3(cos, 0.0, -sin);
        (out + Vec3::Y * (1.0 - v), sign * out)
    });
    if inwards {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// A map of rough noise that tiles.
pub(crate) fn noise(side: u32, seed: u32) -> HeightMap {
    map([side; 2], |x, y| {
        let mut h = x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B) ^ seed;
        h = (h ^ h >> 16).wrapping_mul(0x7FEB_352D);
        h = (h ^ h >> 15).wrapping_mul(0x846C_A68B);
        (h ^ h >> 16) as f32 / u32::MAX as f32
    })
}

pub(crate) fn map(size: [u32; 2], height: impl Fn(u32, u32) -> f32) -> HeightMap {
    let heights = (0..size[0] * size[1]).map(|i| height(i % size[0], i / size[0]));
    HeightMap::new(size, heights.collect(), [Wrap::Repeat; 2]).unwrap()
}
