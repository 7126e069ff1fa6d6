use glam::{DVec3, Vec3};

use super::baked::ObjectLight;
use super::element::SEEN_FROM_BEHIND;
use super::receiver_mesh::ReceiverMeshes;
use super::solve::Glimpse;
use super::triangle::area;
use super::validate::ValidScene;

/// Light while it is being solved for, to be shown: see
/// [`Observer::partial`](super::Observer::partial).
///
/// What surfaces have still to pass on is put in as an ambient term, the same for all (Cohen, Chen,
/// Wallace and Greenberg 1988), so that brightness is about right from the start and does not
/// grow from black. It is for display: the solution never contains it.
pub struct PartialLight<'a> {
    scene: &'a ValidScene,
    receivers: &'a ReceiverMeshes,
    glimpse: &'a Glimpse<'a>,
}

impl std::fmt::Debug for PartialLight<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("PartialLight")
            .field("sweeps", &self.sweeps())
            .field("shots", &self.shots())
            .field("unshot", &self.unshot())
            .finish_non_exhaustive()
    }
}

/// How near to a vertex its light is read, from there to the middle of a triangle.
const INWARDS: f32 = 0.03;

impl<'a> PartialLight<'a> {
    pub(crate) fn new(
        scene: &'a ValidScene,
        receivers: &'a ReceiverMeshes,
        glimpse: &'a Glimpse<'a>,
    ) -> Self {
        Self {
            scene,
            receivers,
            glimpse,
        }
    }

    /// Sweeps so far.
    pub fn sweeps(&self) -> u32 {
        self.glimpse.sweeps
    }

    /// Elements that shot their light so far, in progressive refinement.
    pub fn shots(&self) -> u64 {
        self.glimpse.shots
    }

    /// How much of the light that surfaces reflect was not passed on yet, 0..=1.
    pub fn unshot(&self) -> f64 {
        self.glimpse.unshot_share()
    }

    /// The ambient term: irradiance / π, as the light of vertices.
    pub fn ambient(&self) -> Vec3 {
        self.glimpse.ambient()
    }

    /// The light at vertices, as a [`Bake`](super::Bake) has it, but rougher: that of the elements
    /// around each vertex, as radiosity was drawn before it was fitted. With it a bake can be made
    /// up to be shown, by [`preview`](super::preview) or an engine.
    ///
    /// What casts no shadow has no elements, and gets the mean of the scene.
    pub fn objects(&self) -> Vec<ObjectLight> {
        self.receivers.object_light(&self.nodal())
    }

    /// Light by unknown: the mean over the triangles around, by area.
    fn nodal(&self) -> Vec<Vec3> {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.receivers.unknowns];
        let live = self.scene.live_indices();
        let ambient = self.ambient();
        for (o, mesh) in self.receivers.meshes.iter().enumerate() {
            let behind = self.seen_from_behind(o);
            for (t, vertices) in mesh.triangles.iter().enumerate() {
                let source = mesh.source(t);
                let places = self.places(o, t, source);
                let weight = f64::from(area(mesh.corners(t)));
                for (&v, uv) in vertices.iter().zip(places) {
                    let Some(element) = self.element(live[o][source], uv, behind) else {
                        continue;
                    };
                    let (sum, total) = &mut sums[mesh.unknown[v as usize] as usize];
                    *sum += (self.glimpse.arriving[element] + ambient).as_dvec3() * weight;
                    *total += weight;
                }
            }
        }
        let all = sums
            .iter()
            .fold((DVec3::ZERO, 0.0), |a, s| (a.0 + s.0, a.1 + s.1));
        let mean = |(sum, total): (DVec3, f64)| (sum / total.max(f64::MIN_POSITIVE)).as_vec3();
        let own_or_all = |s: (DVec3, f64)| mean(if s.1 > 0.0 { s } else { all });
        sums.into_iter()
            .map(own_or_all)
            .map(|l| l.max(Vec3::ZERO))
            .collect()
    }

    /// Near each corner of a triangle, the weights of the second and third corner of its source.
    fn places(&self, object: usize, triangle: usize, source: usize) -> [[f32; 2]; 3] {
        let mesh = &self.receivers.meshes[object];
        let sources = &self.scene.objects[object].triangles;
        let corner = |k: usize| match &mesh.refined {
            None => Vec3::AXES[k],
            Some(refined) => {
                let point = refined.vertices[mesh.triangles[triangle][k] as usize];
                let on_source = point.barycentrics_on(source as u32, sources);
                on_source.unwrap_or(Vec3::splat(1.0 / 3.0))
            }
        };
        let corners = [corner(0), corner(1), corner(2)];
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        corners.map(|corner| {
            let place = corner.lerp(middle, INWARDS);
            [place.y, place.z]
        })
    }

    /// The element at a point of a live triangle; none where light passes.
    fn element(&self, live: u32, uv: [f32; 2], behind: bool) -> Option<usize> {
        let key = self.scene.triangles.get(live as usize)?;
        if !self.scene.casts(*key) {
            return None;
        }
        let elements = self.glimpse.system.elements;
        Some(elements.side_at(live, uv, behind)?.0 as usize)
    }

    /// Whether an object's front gets next to no light beside its back: a vertex has one value.
    fn seen_from_behind(&self, object: usize) -> bool {
        let elements = self.glimpse.system.elements;
        let [front, back] = elements.light_of_sides(object, self.glimpse.arriving);
        back.1 > 0.0 && front.0 * back.1 < SEEN_FROM_BEHIND * back.0 * front.1
    }
}
