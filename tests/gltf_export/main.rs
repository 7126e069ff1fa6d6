//! Exports small files built in code and looks at what comes out.
#![cfg(feature = "gltf")]

mod build;
mod gltf_attribute;
mod gltf_colors;
mod gltf_images;
mod gltf_kept;
mod gltf_refined;
