//! Form factors: how much of what leaves one element arrives at another.
//!
//! `F_ij` is the share of the light leaving element *i* that reaches element *j*; by reciprocity
//! (`A_i F_ij = A_j F_ji`) it is also the weight with which the radiosity of *j* arrives at *i*.
//!
//! | file | |
//! |---|---|
//! | `method` | the methods to choose from |
//! | `hit_list` | cosine-distributed rays: the default |
//! | `hemicube` | pictures of the scene from each element |
//! | `analytic` | the closed form, times the visible share |
//! | `area_sampling` | pairs of points |
//! | `pairs` | what methods share that take one pair of elements after the other |
//! | `patch` | an element's shape: which closed form from which distance |
//! | `polygon` | the closed forms |
//! | `gauss` | quadrature |
//! | `matrix` | how rows are kept |
//! | `traced` | what a method found: rows, sky, emitters met by chance |

mod analytic;
mod area_sampling;
mod gauss;
mod hemicube;
mod hit_list;
mod matrix;
mod method;
mod pairs;
mod patch;
mod polygon;
mod traced;

use glam::Vec3;

use crate::radiosity::element::{ElementId, ElementPoint, Elements};
use crate::radiosity::emitter::Emitters;
use crate::radiosity::observer::Observer;
use crate::radiosity::occlusion::{Hit, OFFSET, Occluders};
use crate::radiosity::parallel::Cancelled;
use crate::radiosity::sampling::{cosine_hemisphere, frame, hash, sobol};
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::validate::ValidScene;

use analytic::Analytic;
use area_sampling::AreaSampling;
use hemicube::Hemicube;
#[cfg(test)]
pub(crate) use hit_list::HitList;
pub(crate) use matrix::{Matrix, Row};
pub use method::FormFactors;
pub(crate) use polygon::clip;
pub use polygon::{point_to_polygon, polygon_to_polygon};
pub(crate) use traced::{BLACK, GONE, RowsBefore, SKY, Traced};

/// What elements look at.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) occluders: Occluders<'a>,
    pub(crate) elements: &'a Elements,
    pub(crate) emitters: Emitters<'a>,
    /// Elements whose emission is sampled: what form factors find of it does not count, or in part.
    pub(crate) marks: &'a [bool],
    pub(crate) settings: &'a BakeSettings,
    /// Whether to note how far rays went.
    pub(crate) remember: bool,
}

/// A ray from an element, and what it met.
struct Cast {
    /// Where it starts: lifted off its own surface.
    origin: Vec3,
    /// The point of the element below.
    point: ElementPoint,
    direction: Vec3,
    hit: Option<Hit>,
}

impl View<'_> {
    /// What ray `i` of element `e` hits.
    pub(crate) fn hit(&self, e: usize, i: u32) -> Option<Hit> {
        self.cast(e, i).hit
    }

    /// Ray `i` of element `e`: from points spread over the element, with density cos θ / π.
    fn cast(&self, e: usize, i: u32) -> Cast {
        let id = ElementId(e as u32);
        let seed = self.elements.seed(id, self.settings.seed);
        let [u, v, s, t] = sobol(i, 0, seed);
        let point = self.elements.point(self.scene, id, u, v);
        let direction = frame(point.normal) * cosine_hemisphere(s, t);
        let origin = point.position + point.normal * OFFSET;
        let occluders = self.occluders;
        Cast {
            origin,
            point,
            direction,
            hit: occluders.closest(origin, direction, point.triangle, hash(seed, i)),
        }
    }
}

/// Finds the form factors of all elements, those that `before` does not answer. Returns how many
/// closest-hit rays that took.
pub(crate) fn form_factors(
    view: &View,
    before: Option<&RowsBefore>,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    match view.settings.form_factors {
        FormFactors::HitList => hit_list::trace(view, before, observer),
        FormFactors::Hemicube { resolution } => {
            Ok((hemicube::rows(view, resolution, observer)?, 0))
        }
        FormFactors::Analytic { visibility_rays } => {
            analytic::trace(view, visibility_rays, observer)
        }
        FormFactors::AreaSampling { samples } => area_sampling::trace(view, samples, observer),
    }
}

/// Rows found one at a time, of the methods that know how to. Rays come in half-sets instead, which
/// tell as much.
pub(crate) enum RowByRow<'a> {
    Hemicube(Box<Hemicube<'a>>),
    Analytic(Analytic<'a>),
    AreaSampling(AreaSampling<'a>),
}

impl<'a> RowByRow<'a> {
    pub(crate) fn new(view: View<'a>) -> Option<Self> {
        match view.settings.form_factors {
            FormFactors::HitList => None,
            FormFactors::Hemicube { resolution } => {
                Some(Self::Hemicube(Hemicube::new(view, resolution).into()))
            }
            FormFactors::Analytic { visibility_rays } => {
                Some(Self::Analytic(Analytic::new(view, visibility_rays)))
            }
            FormFactors::AreaSampling { samples } => {
                Some(Self::AreaSampling(AreaSampling::new(view, samples)))
            }
        }
    }

    /// The row of element `e`.
    pub(crate) fn row(&self, e: usize) -> Row {
        match self {
            Self::Hemicube(method) => method.one(e),
            Self::Analytic(method) => pairs::row(method, e),
            Self::AreaSampling(method) => pairs::row(method, e),
        }
    }
}
