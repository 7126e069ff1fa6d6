use glam::{Vec2, Vec3};

use super::direction::directions;
use super::frame::{Frame, Frames};
use super::normals::{Normals, unit_normals};
use super::{Base, DisplacementSettings, base};
use crate::displacement::DisplacementError;
use crate::mesh::{PositionClasses, SurfacePoint};

/// The meshes given, made ready to be raised: welded, with a direction for every place and with what normals
/// are made from.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    pub(super) sheets: Vec<Sheet<'a>>,
    /// Vertices this near to each other are one place.
    pub(super) tolerance: f32,
    /// Triangles without area.
    pub(super) zero_area: u64,
    /// Normals that were given and are none.
    pub(super) mended_normals: u64,
    /// Places where normals cancel out, so that there is no way to go.
    pub(super) undirected: u64,
}

/// One of the meshes.
#[derive(Debug)]
pub(super) struct Sheet<'a> {
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) uvs: &'a [Vec2],
    /// Of each vertex, that of its place.
    pub(super) positions: Vec<Vec3>,
    /// Which place each vertex is at.
    pub(super) places: Vec<u32>,
    /// Of each vertex, that of its place.
    pub(super) directions: Vec<Vec3>,
    /// Of each vertex, of length one.
    normals: Vec<Vec3>,
    frames: Frames,
}

/// Weld tolerance in spacings of `f32` at the largest coordinate: what exporters lose when they write one
/// point twice.
const ULPS: f32 = 4.0;

impl<'a> Surface<'a> {
    pub(super) fn new(
        bases: &[Base<'a>],
        settings: &DisplacementSettings,
    ) -> Result<Self, DisplacementError> {
        base::check(bases)?;
        let all = || bases.iter().flat_map(|base| base.positions);
        let largest = all().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let tolerance = ULPS * f32::EPSILON * largest;
        let welded = PositionClasses::new(all().copied(), tolerance);
        let mut rest = welded.class.as_slice();
        let mut sheets: Vec<Sheet> = (bases.iter())
            .map(|base| {
                let (places, others) = rest.split_at(base.positions.len());
                rest = others;
                Sheet::new(base, places, &welded.representative)
            })
            .collect();
        let Normals { of, mended } = unit_normals(bases, &sheets, settings.crease_angle);
        for (sheet, normals) in sheets.iter_mut().zip(of) {
            sheet.normals = normals;
        }
        let places = welded.representative.len();
        let (out, undirected) = directions(&sheets, places, settings.direction);
        let mut zero_area = 0;
        for sheet in &mut sheets {
            sheet.directions = sheet.places.iter().map(|&p| out[p as usize]).collect();
            sheet.frames = Frames::new(sheet);
            zero_area += sheet.frames.zero_area;
        }
        Ok(Self {
            sheets,
            tolerance,
            zero_area,
            mended_normals: mended,
            undirected,
        })
    }
}

impl<'a> Sheet<'a> {
    /// Without directions, normals and frames.
    fn new(base: &Base<'a>, places: &[u32], representatives: &[Vec3]) -> Self {
        let position = |&place: &u32| representatives[place as usize];
        Self {
            triangles: base.triangles,
            uvs: base.uvs,
            positions: places.iter().map(position).collect(),
            places: places.to_vec(),
            directions: Vec::new(),
            normals: Vec::new(),
            frames: Frames::default(),
        }
    }

    pub(super) fn normal_of(&self, vertex: u32) -> Vec3 {
        self.normals[vertex as usize]
    }

    /// Where on the map a point is.
    pub(super) fn uv(&self, point: SurfacePoint) -> Vec2 {
        let [a, b, c] = self.corners(point).map(|v| self.uvs[v as usize]);
        let w = point.barycentrics;
        a * w.x + b * w.y + c * w.z
    }

    /// Where a point of the base is, and which way is out there.
    pub(super) fn rail(&self, point: SurfacePoint) -> [Vec3; 2] {
        let corners = self.corners(point);
        [&self.positions, &self.directions].map(|values| blend(values, corners, point))
    }

    /// The normal of the base at a point, and what changes along it.
    pub(super) fn frame(&self, point: SurfacePoint) -> (Vec3, Frame) {
        let normal = blend(&self.normals, self.corners(point), point);
        let heaviest = self.corners(point)[point.barycentrics.max_position()];
        let normal = normal
            .try_normalize()
            .unwrap_or(self.normals[heaviest as usize]);
        (normal, self.frames.at(point))
    }

    fn corners(&self, point: SurfacePoint) -> [u32; 3] {
        self.triangles[point.triangle as usize]
    }
}

/// Where a weight is 0 the order of the other two does not matter to a single bit.
fn blend(values: &[Vec3], corners: [u32; 3], point: SurfacePoint) -> Vec3 {
    let [a, b, c] = corners.map(|v| values[v as usize]);
    let w = point.barycentrics;
    a * w.x + b * w.y + c * w.z
}
