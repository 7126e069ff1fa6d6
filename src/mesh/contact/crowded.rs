//! Faces that many contacts lie on are bisected before they are cut.
//!
//! A floor of two triangles on which a rough stone lies has all points of the stone's outline joined to the
//! floor's four corners, by needles that no light can be fitted to. Halved until a few contacts are on each
//! face, it is cut into pieces that are about as wide as they are long:
//!
//! ```text
//!   ┌──────────────────┐        ┌────────┬─────────┐
//!   │\\ \  \  | / / // │        │      / │ \       │
//!   │ \\ \ _──┴─_/ //  │   ►    │   /  ┌─┴─┐   \   │
//!   │___── \____/ ──── │        ├──────┤   ├───────┤
//!   │ // / /  |  \ \ \\│        │   \  └─┬─┘   /   │
//!   └──────────────────┘        └────────┴─────────┘
//! ```

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::Surface;
use super::arrange::MAX_SEGMENTS;
use super::frame::Frame;
use super::shape::Shape;
use super::touch::Contacts;
use crate::mesh::{Bisection, Conforming, Limits, Part, RefinedMesh};

/// Contacts on a face that is not bisected first: a box on a floor, a table with its legs.
const FEW: usize = 16;

/// Halves of edges are this many tolerances long at least: shorter ones could not be cut any more.
const SHORTEST: f32 = 8.0;

/// Meshes with no more than a few contacts on each face, in the order of the surfaces; `None` for those that stay
/// as they are. Faces with more contacts than can be arranged stay, too.
pub(super) fn bisect(
    shape: &Shape,
    contacts: &Contacts,
    surfaces: &[Surface],
) -> Option<Vec<Option<RefinedMesh>>> {
    let mut middles = middles(shape, contacts);
    if middles.is_empty() {
        return None;
    }
    let parts: Vec<Part> = (surfaces.iter())
        .map(|surface| Part {
            positions: surface.positions,
            triangles: surface.triangles,
            refine: surface.cut,
        })
        .collect();
    let mut conforming = Conforming::new(&parts, shape.snap as f32);
    let limits = Limits {
        max_vertices: usize::MAX,
        max_faces: usize::MAX,
        min_edge: SHORTEST * shape.tolerance as f32,
    };
    let mut crowded: Vec<u32> = middles.keys().copied().collect();
    while let Some(face) = crowded.pop() {
        // A neighbour may have had it cut on the way.
        if !middles.contains_key(&face) {
            continue;
        }
        let told = &mut |cut: Bisection| {
            let Some(points) = middles.remove(&cut.face) else {
                return;
            };
            for (face, points) in [cut.face, cut.half].into_iter().zip(parted(&cut, points)) {
                if points.len() > FEW {
                    crowded.push(face);
                    middles.insert(face, points);
                }
            }
        };
        // One that is refused stays as it is.
        conforming.bisect(face, &limits, told);
    }
    let finer = conforming.into_parts().into_iter().zip(surfaces);
    let changed = |mesh: RefinedMesh, surface: &Surface| {
        (mesh.triangles.len() > surface.triangles.len()).then_some(mesh)
    };
    Some(
        finer
            .map(|(part, surface)| changed(part.mesh, surface))
            .collect(),
    )
}

/// The middles of contacts on faces with many, as weights of their corners.
fn middles(shape: &Shape, contacts: &Contacts) -> BTreeMap<u32, Vec<Vec3>> {
    let is_crowded = |count: usize| count > FEW && count <= MAX_SEGMENTS;
    let crowded = contacts
        .on_faces
        .iter()
        .filter(|(_, s)| is_crowded(s.len()));
    crowded
        .filter_map(|(&face, segments)| {
            let frame = Frame::new(shape.corners(face as usize))?;
            let middle = |[a, b]: &[_; 2]| {
                let weights = DVec3::from(frame.weights((*a + *b) * 0.5));
                weights.as_vec3().max(Vec3::ZERO)
            };
            Some((face, segments.iter().map(middle).collect()))
        })
        .collect()
}

/// Points of a face by the pieces that it was cut into.
fn parted(cut: &Bisection, points: Vec<Vec3>) -> [Vec<Vec3>; 2] {
    let mut pieces = [Vec::new(), Vec::new()];
    for point in points {
        let (is_in_half, weights) = cut.hand_on(point);
        pieces[usize::from(is_in_half)].push(weights);
    }
    pieces
}
