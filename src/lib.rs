//! Relief and baked light for Bevy.
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod mesh;
pub mod radiosity;
