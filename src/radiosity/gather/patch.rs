use std::cell::OnceCell;

use glam::Vec3;

use super::Gather;
use crate::radiosity::bounds::{Bounds, Sphere};
use crate::radiosity::emitter::Receiver;
use crate::radiosity::gathered::{GradientShare, Share};
use crate::radiosity::occlusion::{NO_TRIANGLE, OFFSET};
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::sampling::{cosine_direction, hash, sobol, triangle as triangle_point};
use crate::radiosity::triangle::{area, face_normal};

/// Samples of a triangle at most, however large.
const MAX_SAMPLES: u32 = 256;

/// A triangle to sample.
pub(super) struct Patch<'a> {
    pub(super) mesh: &'a ReceiverMesh,
    pub(super) triangle: usize,
    pub(super) area: f32,
    /// Unit normal of the side to light, and which that is: 1 or −1.
    normal: Vec3,
    side: f32,
    pub(super) live: u32,
    pub(super) samples: u32,
    pub(super) seed: u32,
    places: OnceCell<Vec<(Vec3, Place)>>,
}

impl Gather<'_> {
    /// A triangle of an object's mesh; `None` if no light is put on it.
    pub(super) fn patch<'m>(
        &self,
        mesh: &'m ReceiverMesh,
        object: usize,
        triangle: usize,
    ) -> Option<Patch<'m>> {
        let corners = mesh.corners(triangle);
        let live = self.aids.live[object][mesh.source(triangle)];
        let side = self.side(object);
        let normal = face_normal(corners) * side;
        if live == NO_TRIANGLE || normal == Vec3::ZERO {
            return None;
        }
        let salt = hash(self.aids.seeds[object], self.settings.seed ^ 0x6A7E);
        Some(Patch {
            mesh,
            triangle,
            area: area(corners),
            normal,
            side,
            live,
            samples: 0,
            seed: hash(triangle as u32, salt),
            places: OnceCell::new(),
        })
    }
}

impl Patch<'_> {
    pub(super) fn samples_at(&self, density: f32) -> u32 {
        // An even number: the half-sets are of one size.
        let pairs = (0.5 * density * self.area.sqrt()).round() as u32;
        (2 * pairs).clamp(2, MAX_SAMPLES)
    }

    pub(super) fn with(&self, samples: u32) -> Self {
        Self {
            samples,
            places: OnceCell::new(),
            ..*self
        }
    }

    pub(super) fn sphere(&self) -> Sphere {
        Bounds::of(self.mesh.corners(self.triangle)).sphere()
    }

    /// Sample `i`: weights of the corners, and the place.
    pub(super) fn place(&self, i: u32) -> &(Vec3, Place) {
        let place = |i| {
            let [u, v, ..] = sobol(i, 0, self.seed);
            let b = triangle_point(u, v);
            let place = Place::new(self.mesh, self.triangle, b, self.normal, self.side);
            (b, place)
        };
        let places = (self.places).get_or_init(|| (0..self.samples).map(place).collect());
        &places[i as usize]
    }

    /// Direction of a ray about +Z.
    pub(super) fn direction(&self, ray: u32) -> Vec3 {
        cosine_direction(ray, self.seed)
    }

    /// Which block of a sequence sample `i` takes: those of a half-set follow each other, so that
    /// each half is spread evenly.
    pub(super) fn block(&self, i: u32) -> u32 {
        i / 2 + i % 2 * (self.samples / 2)
    }

    /// Light at sample `i`, times the weights of the corners there, as part of the whole.
    pub(super) fn share(&self, i: u32, light: Vec3) -> Share {
        Share::of_half(i % 2, light * (self.area / self.samples as f32))
    }

    pub(super) fn gradient_share(&self, i: u32, b: Vec3, gradient: Vec3) -> GradientShare {
        GradientShare::of_half(i % 2, b * (self.area / self.samples as f32), gradient)
    }
}

/// A sample's place on the surface.
pub(crate) struct Place {
    /// Lifted off the surface.
    pub(crate) position: Vec3,
    pub(crate) geometric: Vec3,
    /// Interpolated normal that the surface is shaded with.
    pub(crate) shading: Vec3,
}

impl Place {
    /// As a receiver on a live triangle.
    pub(crate) fn receiver(&self, live: u32) -> Receiver {
        Receiver {
            position: self.position,
            normal: self.shading,
            triangle: live,
        }
    }

    /// The point `b` of a triangle, on the side of its normal `geometric`, which is `side` times that
    /// of the mesh.
    pub(crate) fn new(
        mesh: &ReceiverMesh,
        triangle: usize,
        b: Vec3,
        geometric: Vec3,
        side: f32,
    ) -> Self {
        let vertices = mesh.triangles[triangle].map(|v| v as usize);
        let [p, q, r] = vertices.map(|v| mesh.positions[v]);
        let normals = vertices.map(|v| mesh.normals[v] * side);
        let flat = p * b.x + q * b.y + r * b.z;
        let blended = normals[0] * b.x + normals[1] * b.y + normals[2] * b.z;
        let shading = blended
            .try_normalize()
            .filter(|n| n.dot(geometric) > 0.0)
            .unwrap_or(geometric);
        // Onto the curved surface that the normals tell of, so that the facets of a coarse mesh
        // do not shade themselves (Hanika 2021, "Hacking the Shadow Terminator").
        let mut lift = Vec3::ZERO;
        if shading.dot(geometric) < 0.9999 {
            for (k, corner) in [p, q, r].into_iter().enumerate() {
                lift -= normals[k] * ((flat - corner).dot(normals[k]).min(0.0) * b[k]);
            }
        }
        Self {
            position: flat + lift + geometric * OFFSET,
            geometric,
            shading,
        }
    }
}
