//! Radiosity: the diffuse light of a scene, solved and written to vertices.
//!
//! ```text
//!   B = E + ρ Σ_j F_ij B_j        (Goral, Torrance, Greenberg and Battaile 1984)
//! ```
//!
//! The radiosity `B` of a surface element is what it emits, `E`, and what it reflects of the light
//! arriving from all others, weighted by the form factors `F`. Emission is known, so it is not
//! left for form factors to find: emitters are sampled, and the system is solved for the
//! reflected light `R`,
//!
//! ```text
//!   ┌───────────────────────────────┐
//!   │  R = ρ (H_direct + F R)       │     H = H_direct + F R arrives
//!   └───────────────────────────────┘
//! ```
//!
//! A [`Baker`] bakes again after a change. Rays depend on where things are, not on their colours,
//! so stages keep geometry and light apart: a row of hits, a light's effect at power 1, an
//! emitter's at radiance 1; colours are put in last.
//!
//! ```text
//!   view, nothing ─► ·            light moved ─► its shadow rays ─┐
//!   light's colour, emission's, reflectance ──────────────────────┴─► solve ─► put in ─► fit
//!   object moved ─► rays from it, onto it, past it ───────────────┘
//! ```
//!
//! All quantities are radiances (divided by π): `H` is irradiance / π, `R` is radiosity / π.
//!
//! The rooms, in the order a [`bake`] passes them:
//!
//! | file | what happens |
//! |---|---|
//! | `scene`, `light`, `validate`, `mend` | what goes in, checked and mended once |
//! | `surface`, `texture` | reflectance, emission and transparency of any point |
//! | `receiver_mesh` | the meshes that carry light, split and welded |
//! | `element`, `element_builder`, `cells`, `grouping` | the pieces of surface the system is solved on |
//! | `layout` | how fine they are, and how many rays each casts |
//! | `bvh`, `occlusion` | rays against the input triangles |
//! | `emitter`, `emitter_tree` | emissive surfaces: few in closed form, many sampled |
//! | `facet` | a shining polygon as a point sees it, with and without shadow |
//! | `illumination`, `direct` | light that arrives without a bounce |
//! | `form_factor` | rows of `F` as lists of ray hits |
//! | `solve`, `partial` | the system solved, by one of several methods; light on its way there |
//! | `cut` | surfaces cut where they touch or cross, before all else |
//! | `receivers`, `refine` | vertices placed by the light: a coarse mesh for smooth light, a fine one inside it |
//! | `gather`, `gathered`, `fit` | irradiance inside triangles, fitted by vertex values |
//! | `contribution` | which part of the light that is |
//! | `quality` | how sure each vertex is |
//! | `gradient` | how light changes as the normal turns, for bumps |
//! | `first_look`, `surroundings` | where elements and rays are needed, by a coarse solution |
//! | `importance`, `glare` | how much it matters what elements send; which are too bright to be left to chance |
//! | `element_error` | how far off elements of constant light are |
//! | `sampling_error` | how far off chance leaves the light of elements |
//! | `element_light` | the light of elements, to look at |
//! | `pipeline`, `stages` | all of it, one stage after the other, each resumed where it can be |
//! | `bake`, `baker` | the doors: once, and again after every change |
//! | `identity`, `change`, `bounds` | what differs from the scene before, and which rays it touched |
//! | `findings`, `report` | what it cost and how good it is |
//! | `estimate`, `speed` | what it will cost |
//! | `preview` | a picture to judge it by |

mod bake;
mod baked;
mod baker;
#[cfg(test)]
mod baker_methods_test;
#[cfg(test)]
mod baker_test;
mod bounds;
mod bvh;
mod cells;
mod change;
mod color;
mod contribution;
#[cfg(test)]
mod contribution_test;
mod cut;
mod direct;
mod element;
mod element_builder;
mod element_error;
mod element_light;
#[cfg(test)]
mod element_test;
mod emitter;
mod emitter_tree;
mod estimate;
mod facet;
mod findings;
mod first_look;
mod fit;
mod form_factor;
mod gather;
mod gathered;
mod glare;
mod gradient;
#[cfg(test)]
mod gradient_study_test;
#[cfg(test)]
mod gradient_test;
mod grouping;
mod identity;
mod illumination;
mod importance;
mod kind;
mod layout;
mod level;
mod light;
mod mend;
mod observer;
mod occlusion;
mod parallel;
mod partial;
mod pipeline;
mod preview;
mod quality;
mod receiver_mesh;
mod receivers;
mod refine;
mod report;
mod sampling;
mod sampling_error;
mod scene;
mod seams;
mod settings;
mod solve;
mod speed;
mod spot;
#[cfg(test)]
mod spot_test;
mod stages;
mod surface;
mod surroundings;
mod texture;
mod triangle;
mod validate;

pub use bake::{BakeError, bake, solve_elements};
pub use baked::{Bake, ObjectLight};
pub use baker::Baker;
pub use contribution::Contribution;
pub use cut::ContactLine;
pub use element_light::{Element, ElementLight, ElementTriangle};
pub use estimate::{Estimate, estimate, estimate_counts};
pub use form_factor::{FormFactors, point_to_polygon, polygon_to_polygon};
pub use gradient::{local_gradients, reshade};
pub use light::{DirectLight, Light, LightKind};
pub use observer::{Observer, Stage};
pub use partial::PartialLight;
pub use preview::{Camera, Picture, PreviewSettings, Projection, preview};
pub use quality::{VertexQuality, VertexSource};
pub use report::{
    Counts, EnergyBalance, ErrorEstimate, FormFactorReport, Report, SolverReport, Stopped, Work,
};
pub use scene::{
    AlphaMode, Material, MaterialId, Object, ObjectId, Scene, Texture, TextureId, TextureRef, Wrap,
};
pub use settings::{BakeSettings, InvalidSetting};
pub use solve::Solver;
pub use validate::{SceneError, ValidScene};
