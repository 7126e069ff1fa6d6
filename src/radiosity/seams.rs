//! Where objects meet, one light goes on from one to the next, unless something stands between them.

use std::collections::HashMap;

use glam::Vec3;

use super::cut::TOUCHING;
use super::gather::Gather;
use super::occlusion::NO_TRIANGLE;
use super::receiver_mesh::ReceiverMeshes;

/// An unknown on a seam: where it is, and which way from there its faces are.
#[derive(Clone, Copy, Default)]
struct Member {
    place: Vec3,
    normal: Vec3,
    inward: Vec3,
}

/// How far from a seam and above it the points are that must see each other, in internal units: what
/// hovers lower counts as standing on it.
const ABOVE: f32 = TOUCHING;
const BESIDE: f32 = 2.0 * TOUCHING;

/// The unknowns at each place that are to have one light: on surfaces of different objects that go on
/// in each other, and not on either side of a wall between two rooms.
pub(crate) fn open_seams(meshes: &ReceiverMeshes, gather: &Gather) -> Vec<Vec<u32>> {
    let members = members(meshes, gather);
    let occluders = &gather.occluders;
    let sees = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|u| members[&u].beside());
        let (way, distance) = ((b - a).normalize_or_zero(), a.distance(b));
        distance == 0.0 || occluders.transmittance(a, way, distance, [NO_TRIANGLE; 2]) > 0.0
    };
    let mut open = Vec::new();
    for seam in &meshes.seams {
        let mut left = seam.clone();
        while let Some(first) = left.pop() {
            let mut group = vec![first];
            let mut next = 0;
            while next < group.len() {
                let at = group[next];
                let (seen, hidden) = left.into_iter().partition(|&u| sees(at, u));
                let seen: Vec<u32> = seen;
                group.extend(seen);
                left = hidden;
                next += 1;
            }
            if group.len() > 1 {
                group.sort_unstable();
                open.push(group);
            }
        }
    }
    open
}

fn members(meshes: &ReceiverMeshes, gather: &Gather) -> HashMap<u32, Member> {
    let on_seams = meshes.seams.iter().flatten();
    let mut members: HashMap<u32, Member> = on_seams.map(|&u| (u, Member::default())).collect();
    for (object, mesh) in meshes.meshes.iter().enumerate() {
        let side = gather.side(object);
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
            let center = (a + b + c) / 3.0;
            for &v in corners {
                let vertex = v as usize;
                if let Some(member) = members.get_mut(&mesh.unknown[vertex]) {
                    member.place = mesh.positions[vertex];
                    member.normal = mesh.normals[vertex] * side;
                    member.inward += (center - member.place).normalize_or_zero();
                }
            }
        }
    }
    members
}

impl Member {
    fn beside(&self) -> Vec3 {
        self.place + self.normal * ABOVE + self.inward.normalize_or_zero() * BESIDE
    }
}
