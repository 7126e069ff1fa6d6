//! Relief from a height map, in the shader: [`Bump`]s of a material.
//!
//! ```text
//!  image file ──loader──► HeightImage ──gpu──► slopes, their squares, heights, bounds; every size
//!  Mesh ──insert_uv_gradients──► ∇u, ∇v at vertices (or: derivatives on the screen)
//!                                   │
//!                                   ▼      ∇F = Fu ∇u + Fv ∇v
//!  FrescoExtension { bump, detail } ──► surface.wgsl ──► normal, roughness ──► every pass
//! ```
//!
//! | file | what it does |
//! |---|---|
//! | `settings` | the bump of a material, and what of it the shader reads |
//! | `parallax` | relief that is seen from the side |
//! | `height_image`, `texels` | the asset, from whatever an image holds |
//! | `loader` | the asset from files |
//! | `atlas` | bounds of blocks of a map as one texture |
//! | `gpu` | its textures, and what stands in while there are none |
//! | `uv_gradients` | vertex attributes for bumps that need no derivatives on the screen |
//! | `warnings` | bumps that cannot be shown are told, once |
//! | `bump.wgsl` | the formulas; the twin of [`crate::bump`] |
//! | `parallax.wgsl` | where rays of sight meet relief; the twin of [`crate::bump`]'s |
//! | `surface.wgsl` | what is bound, and the bumps of a material put together |
//! | `prepass.wgsl` | the pass that writes normals |

mod atlas;
mod gpu;
mod height_image;
mod loader;
mod parallax;
mod settings;
mod texels;
mod uv_gradients;
mod warnings;

pub use gpu::{ArrivedHeightImages, FlatHeightImage, GpuHeightImage};
pub use height_image::{HeightImage, HeightImageError};
pub use loader::{HeightImageLoader, HeightImageLoaderError, HeightImageSettings};
pub use parallax::Parallax;
pub use settings::BumpKey;
pub use settings::{Bump, BumpFilter, BumpHeight};
pub use texels::HeightChannel;
pub use uv_gradients::{
    ATTRIBUTE_U_GRADIENT, ATTRIBUTE_V_GRADIENT, UvGradientsError, insert_uv_gradients,
};
pub use warnings::BumpProblem;

pub(super) use settings::BumpUniform;

use bevy::prelude::*;

/// Assets, loader and systems of bumps.
pub(super) fn plugin(app: &mut App) {
    app.init_asset::<HeightImage>()
        .register_asset_loader(HeightImageLoader)
        .register_type::<Bump>()
        .add_plugins((gpu::plugin, warnings::plugin));
}
