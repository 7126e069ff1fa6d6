//! Exports small files built in code and looks at what comes out.
#![cfg(feature = "gltf")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod build;
mod gltf_attribute;
mod gltf_broken;
mod gltf_colors;
mod gltf_gradient;
mod gltf_images;
mod gltf_kept;
mod gltf_projected;
mod gltf_refined;
