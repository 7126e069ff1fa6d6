//! What Bevy needs to know of baked light.

mod attribute;
mod material;
mod shaders;

pub use attribute::ATTRIBUTE_BAKED_LIGHT;
pub use material::{FrescoExtension, FrescoMaterial, FrescoMaterialPlugin};
