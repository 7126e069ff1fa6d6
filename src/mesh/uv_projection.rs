use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};
use thiserror::Error;

/// Corners nearer to the axis than this share of the mesh's extent are on it.
const ON_AXIS: f32 = 1e-5;

/// Sides of a box within this share of the largest component of a normal are as good as it: the first of
/// them is taken, so that faces at 45° do not fall to one side or the other by rounding.
const AS_GOOD: f32 = 1.0 - 1e-4;

/// How texture coordinates are laid on a mesh. `u` runs to the right and `v` down as seen from outside, with
/// y up, so that nothing shows mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UvProjection {
    /// Along z, as a slide projector in front of the mesh. What faces away shows mirrored, what stands on
    /// edge is smeared.
    Planar {
        /// Metres that the texture is wide and high. Limits: above 0.
        size: Vec2,
    },
    /// Each triangle along the axis that it faces most: six charts. On what faces an axis the texture has
    /// its size; elsewhere it is stretched, by √3 at most.
    Box {
        /// Metres that the texture is wide and high. Limits: above 0.
        size: f32,
    },
    /// Round the y axis. What faces along the axis more than outwards is mapped as a box is.
    Cylinder {
        /// How often the texture goes round; whole numbers leave no seam. Limits: above 0.
        repeats: f32,
        /// Metres that it is high. Limits: above 0.
        height: f32,
    },
    /// By longitude and latitude, the poles on the y axis.
    Sphere {
        /// How often the texture goes round, and from pole to pole. Limits: above 0.
        repeats: Vec2,
    },
}

/// A projection and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvSettings {
    /// What is projected.
    pub projection: UvProjection,
    /// Its centre, in metres.
    pub origin: Vec3,
    /// How it is turned.
    pub rotation: Quat,
}

/// Texture coordinates for a mesh, whose vertices are there once for every chart that they are part of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UvMesh {
    /// Of each vertex.
    pub uvs: Vec<Vec2>,
    /// Which vertex of the mesh each vertex was: its position and all other attributes are that one's.
    pub sources: Vec<u32>,
    /// In the order of the mesh's, with the same windings.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles that a pole or the axis goes through, away from their corners. No coordinates fit them: the
    /// mesh needs a vertex there.
    pub over_poles: Vec<u32>,
}

/// Why no texture coordinates can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum UvError {
    /// A triangle has a vertex that there is not.
    #[error("triangle {triangle} has vertex {vertex}, and there are {count}: the mesh is broken")]
    Index {
        /// Which triangle.
        triangle: u32,
        /// The vertex it has.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex is nowhere.
    #[error("vertex {0} has no finite position: mend the mesh")]
    Position(u32),
    /// A size, a number of repeats, or where the projection stands makes no sense.
    #[error("a projection needs sizes and repeats above 0, and a finite place and rotation")]
    Settings,
}

/// What tells the copies of a vertex apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Chart {
    /// A side of the box: axis, and whether the negative one.
    Side(u8, bool),
    /// So many turns on from where angles begin.
    Turn(i32),
    /// On the axis, where every triangle has an angle of its own.
    Pole(u32),
}

/// One corner of a triangle.
type Corner = (Chart, Vec2);

impl UvSettings {
    /// A projection at the origin.
    pub fn new(projection: UvProjection) -> Self {
        Self {
            projection,
            origin: Vec3::ZERO,
            rotation: Quat::IDENTITY,
        }
    }

    fn is_sound(&self) -> bool {
        let sizes = match self.projection {
            UvProjection::Planar { size } => [size.x, size.y],
            UvProjection::Box { size } => [size; 2],
            UvProjection::Cylinder { repeats, height } => [repeats, height],
            UvProjection::Sphere { repeats } => [repeats.x, repeats.y],
        };
        sizes.iter().all(|&s| s > 0.0 && s.is_finite())
            && self.origin.is_finite()
            && self.rotation.is_finite()
            && self.rotation.length_squared() > 0.0
    }
}

/// Lays texture coordinates on a mesh.
///
/// Vertices are copied where charts meet, where a texture comes round to its beginning, and at poles: a
/// vertex of the result belongs to one chart. Coordinates may be outside 0..1; textures have to repeat.
/// Vertices come in the order in which triangles use them first, and those that none uses are left out.
/// Triangles without area get finite coordinates.
///
/// # Errors
///
/// If an index is out of range, a position is not finite, or the settings are outside their limits.
pub fn project_uvs(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    settings: &UvSettings,
) -> Result<UvMesh, UvError> {
    if !settings.is_sound() {
        return Err(UvError::Settings);
    }
    let into = settings.rotation.normalize().inverse();
    let placed: Vec<Vec3> = positions
        .iter()
        .map(|&p| into * (p - settings.origin))
        .collect();
    if let Some(i) = placed.iter().position(|p| !p.is_finite()) {
        return Err(UvError::Position(i as u32));
    }
    let extent = placed
        .iter()
        .fold(0.0, |e: f32, p| e.max(p.abs().max_element()));
    let mut mesh = UvMesh::default();
    let mut known: HashMap<(u32, Chart), u32> = HashMap::new();
    for (index, &vertices) in (0..).zip(triangles) {
        if let Some(&vertex) = vertices.iter().find(|&&v| v as usize >= positions.len()) {
            return Err(UvError::Index {
                triangle: index,
                vertex,
                count: positions.len(),
            });
        }
        let corners = vertices.map(|v| placed[v as usize]);
        let (found, over_pole) = match settings.projection {
            UvProjection::Planar { size } => (corners.map(|p| along_z(p, size)), false),
            UvProjection::Box { size } => (side_of_box(corners, size), false),
            UvProjection::Cylinder { repeats, height } => {
                cylinder(corners, index, extent, [repeats, height])
            }
            UvProjection::Sphere { repeats } => sphere(corners, index, extent, repeats),
        };
        if over_pole {
            mesh.over_poles.push(index);
        }
        let triangle = [0, 1, 2].map(|k| {
            let (chart, uv) = found[k];
            *known.entry((vertices[k], chart)).or_insert_with(|| {
                mesh.uvs.push(uv);
                mesh.sources.push(vertices[k]);
                (mesh.uvs.len() - 1) as u32
            })
        });
        mesh.triangles.push(triangle);
    }
    Ok(mesh)
}

fn along_z(p: Vec3, size: Vec2) -> Corner {
    (Chart::Side(2, false), Vec2::new(p.x, -p.y) / size)
}

/// Which axis a triangle faces most, and whether against it. Triangles without area face z.
fn facing(corners: [Vec3; 3]) -> (u8, bool) {
    let [a, b, c] = corners;
    // Triangles may be micrometres or kilometres large: products of their edges stay near 1.
    let (b, c) = (b - a, c - a);
    let longest = b.abs().max(c.abs()).max_element();
    let normal = (b / longest).cross(c / longest);
    let largest = normal.abs().max_element();
    let axis = (0..3).find(|&k| largest > 0.0 && normal[k].abs() >= AS_GOOD * largest);
    axis.map_or((2, false), |k| (k as u8, normal[k] < 0.0))
}

fn side_of_box(corners: [Vec3; 3], size: f32) -> [Corner; 3] {
    let (axis, negative) = facing(corners);
    let sign = if negative { -1.0 } else { 1.0 };
    corners.map(|p| {
        let uv = match axis {
            0 => Vec2::new(-sign * p.z, -p.y),
            1 => Vec2::new(p.x, sign * p.z),
            _ => Vec2::new(sign * p.x, -p.y),
        };
        (Chart::Side(axis, negative), uv / size)
    })
}

/// Coordinates on a cylinder, and whether the axis goes through the triangle.
fn cylinder(
    corners: [Vec3; 3],
    triangle: u32,
    extent: f32,
    [repeats, height]: [f32; 2],
) -> ([Corner; 3], bool) {
    if facing(corners).0 == 1 {
        return (side_of_box(corners, height), false);
    }
    let (turns, over_pole) = angles(corners, triangle, extent);
    let uv = |k: usize| Vec2::new(repeats * turns[k].1, -corners[k].y / height);
    ([0, 1, 2].map(|k| (turns[k].0, uv(k))), over_pole)
}

/// Coordinates on a sphere, and whether the axis goes through the triangle.
fn sphere(corners: [Vec3; 3], triangle: u32, extent: f32, repeats: Vec2) -> ([Corner; 3], bool) {
    let (turns, over_pole) = angles(corners, triangle, extent);
    let uv = |k: usize| {
        let p = corners[k];
        // From the pole above; the centre counts as on the equator.
        let down = match p == Vec3::ZERO {
            true => 0.5 * PI,
            false => Vec2::new(p.x, p.z).length().atan2(p.y),
        };
        repeats * Vec2::new(turns[k].1, down / PI)
    };
    ([0, 1, 2].map(|k| (turns[k].0, uv(k))), over_pole)
}

/// Angles of the corners round y, in turns from z towards x: within half a turn of each other, their middle
/// in −½..½, and whether the axis goes through the triangle, so that there is no such way to turn them.
/// Corners on the axis take the mean of the others.
fn angles(corners: [Vec3; 3], triangle: u32, extent: f32) -> ([(Chart, f32); 3], bool) {
    let on_axis = |p: Vec3| Vec2::new(p.x, p.z).length() <= ON_AXIS * extent;
    let known = corners.map(|p| (!on_axis(p)).then(|| p.x.atan2(p.z) / TAU));
    let Some(first) = known.into_iter().flatten().next() else {
        return ([(Chart::Pole(triangle), 0.0); 3], false);
    };
    // Whole turns that bring an angle within half a turn of the first.
    let near = known.map(|angle| angle.map(|a| a + (first - a).round()));
    let found = near.into_iter().flatten();
    let spread = found.clone().fold(first, f32::max) - found.clone().fold(first, f32::min);
    if spread > 0.5 {
        return (
            near.map(|a| (Chart::Pole(triangle), a.unwrap_or(first))),
            true,
        );
    }
    let middle = found.clone().sum::<f32>() / found.count() as f32;
    let back = middle.round();
    let corner = |k: usize| match (near[k], known[k]) {
        (Some(near), Some(angle)) => {
            let turns = (near - angle - back).round();
            (Chart::Turn(turns as i32), angle + turns)
        }
        _ => (Chart::Pole(triangle), middle - back),
    };
    ([0, 1, 2].map(corner), false)
}
