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

use crate::radiosity::element::Elements;
use crate::radiosity::emitter::Emitters;
use crate::radiosity::observer::Observer;
use crate::radiosity::occlusion::Occluders;
use crate::radiosity::parallel::Cancelled;
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::validate::ValidScene;

#[cfg(test)]
pub(crate) use hit_list::HitList;
pub(crate) use matrix::{Matrix, Row};
pub use method::FormFactors;
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
