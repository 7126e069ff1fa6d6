//! What rays and shadow rays bring to samples inside triangles of the receiving meshes.
//!
//! | file | what happens |
//! |---|---|
//! | `patch` | a triangle to sample: places, directions |
//! | `rays` | light that comes from all around: rays, and what they meet |
//! | `shadows` | light with sharp edges: shadow rays to lights and to emitters |
//! | `gradients` | how the light that rays bring changes as the normal turns |
//! | `before` | what an earlier bake gathered, and how much of it is still true |

mod before;
mod gradients;
mod patch;
mod rays;
mod shadows;

pub(crate) use self::before::GatherBefore;
pub(crate) use self::patch::Place;
pub(crate) use self::rays::KnownRays;
pub(crate) use self::shadows::Validity;

use super::direct::ShadowRays;
use super::element::Elements;
use super::emitter::Emitters;
use super::identity::object_seeds;
use super::occlusion::Occluders;
use super::receiver_mesh::ReceiverMeshes;
use super::settings::BakeSettings;
use super::triangle::area;
use super::validate::ValidScene;

/// What the gather stage traces rays with.
pub(crate) struct Gather<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) occluders: Occluders<'a>,
    pub(crate) elements: &'a Elements,
    pub(crate) emitters: Emitters<'a>,
    /// The reflected light of elements, the brightest of them sampled.
    pub(crate) reflectors: Emitters<'a>,
    /// Elements whose emission is sampled, and those whose reflected light is.
    pub(crate) marks: [&'a [bool]; 2],
    /// For each object, whether the back of its surfaces is the side to light.
    pub(crate) lit_from_behind: &'a [bool],
    pub(crate) settings: &'a BakeSettings,
    pub(crate) density: Density,
    /// Whether to note how far rays went.
    pub(crate) remember: bool,
    pub(crate) aids: Aids,
}

/// Samples per square root of a triangle's area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Density {
    /// Of the coarse meshes.
    pub(crate) smooth: f32,
    /// Of the fine meshes, in shadows' edges.
    pub(crate) sharp: f32,
    /// The same where there is none.
    pub(crate) calm: f32,
}

/// What rays and shadow rays a triangle took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GatherCost {
    pub(crate) rays: u64,
    pub(crate) shadow: ShadowRays,
}

/// By object: what many triangles ask for.
pub(crate) struct Aids {
    /// For each triangle of each object, its live index or [`NO_TRIANGLE`].
    live: Vec<Vec<u32>>,
    seeds: Vec<u32>,
}

impl Aids {
    pub(crate) fn new(scene: &ValidScene) -> Self {
        Self {
            live: scene.live_indices(),
            seeds: object_seeds(scene),
        }
    }

    /// The live index of a triangle of an object, or [`NO_TRIANGLE`].
    pub(crate) fn live(&self, object: usize, triangle: usize) -> u32 {
        self.live[object][triangle]
    }
}

/// Samples per square root of area, so that the mean over vertices is what the settings ask.
///
/// Large triangles see more change of light than small ones, but not in proportion.
pub(crate) fn density(receivers: &ReceiverMeshes, settings: &BakeSettings) -> f32 {
    let meshes = receivers.meshes.iter();
    let roots: f64 = meshes
        .flat_map(|m| (0..m.triangles.len()).map(|t| f64::from(area(m.corners(t))).sqrt()))
        .sum();
    let samples = f64::from(settings.samples_per_vertex) * receivers.vertex_count() as f64;
    (samples / roots.max(f64::MIN_POSITIVE)) as f32
}

impl Gather<'_> {
    /// The side of an object that is lit: 1 for the front, −1 for the back.
    pub(crate) fn side(&self, object: usize) -> f32 {
        if self.lit_from_behind[object] {
            -1.0
        } else {
            1.0
        }
    }
}
