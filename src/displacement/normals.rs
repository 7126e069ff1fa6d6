use glam::{DVec3, Vec3};

use super::Base;
use super::corner::corners;
use super::surface::Sheet;

/// Normals of length one for all vertices.
pub(super) struct Normals {
    pub(super) of: Vec<Vec<Vec3>>,
    /// Normals that were given and are none.
    pub(super) mended: u64,
}

/// Takes the normals given. Where there are none, or what is there has no direction, a vertex gets that of its
/// own faces, and of the faces of other vertices at its place that lean from it by no more than the crease
/// angle.
pub(super) fn unit_normals(bases: &[Base], sheets: &[Sheet], crease_angle: f32) -> Normals {
    let given = |base: &Base| -> Vec<Option<Vec3>> {
        let unit = |n: &Vec3| Vec3::try_normalize(*n).filter(|n| n.is_finite());
        match base.normals {
            [] => vec![None; base.positions.len()],
            normals => normals.iter().map(unit).collect(),
        }
    };
    let given: Vec<_> = bases.iter().map(given).collect();
    let has_normals = |&(base, _): &(&Base, &Vec<Option<Vec3>>)| !base.normals.is_empty();
    let mended = (bases.iter().zip(&given).filter(has_normals))
        .flat_map(|(_, normals)| normals)
        .filter(|n| n.is_none())
        .count();
    let complete = given.iter().flatten().all(Option::is_some);
    let made = match complete {
        true => given.iter().map(|g| vec![Vec3::Y; g.len()]).collect(),
        false => made_from_faces(sheets, crease_angle),
    };
    let either = |(given, made): (Vec<Option<Vec3>>, Vec<Vec3>)| {
        let either = |(given, made): (Option<Vec3>, Vec3)| given.unwrap_or(made);
        given.into_iter().zip(made).map(either).collect()
    };
    Normals {
        of: given.into_iter().zip(made).map(either).collect(),
        mended: mended as u64,
    }
}

fn made_from_faces(sheets: &[Sheet], crease_angle: f32) -> Vec<Vec<Vec3>> {
    let mut own: Vec<Vec<DVec3>> = (sheets.iter())
        .map(|sheet| vec![DVec3::ZERO; sheet.positions.len()])
        .collect();
    // Place, part, vertex.
    let mut here: Vec<[u32; 3]> = Vec::new();
    for (part, sheet) in (0..).zip(sheets) {
        for corner in corners(sheet) {
            own[part as usize][corner.vertex as usize] += corner.angle * corner.facet.as_dvec3();
            here.push([sheet.places[corner.vertex as usize], part, corner.vertex]);
        }
    }
    here.sort_unstable();
    here.dedup();
    let cosine = f64::from(crease_angle.cos());
    let mut made: Vec<Vec<Vec3>> = own.iter().map(|own| vec![Vec3::Y; own.len()]).collect();
    for place in here.chunk_by(|a, b| a[0] == b[0]) {
        let sums = place
            .iter()
            .map(|&[_, part, v]| own[part as usize][v as usize]);
        let sums: Vec<DVec3> = sums.collect();
        for (&[_, part, vertex], own) in place.iter().zip(&sums) {
            let near = |other: &&DVec3| {
                own.normalize_or_zero().dot(other.normalize_or_zero()) >= cosine - 1e-9
            };
            let sum: DVec3 = sums.iter().filter(near).sum();
            let normal = sum.try_normalize().unwrap_or(DVec3::Y).as_vec3();
            made[part as usize][vertex as usize] = normal;
        }
    }
    made
}
