//! Radiosity.

mod baked;
mod light;
mod observer;
mod report;
mod scene;
mod settings;

pub use baked::{Bake, ObjectLight};
pub use light::{Light, LightKind};
pub use observer::{Observer, Stage};
pub use report::{Counts, EnergyBalance, Report, SolverReport};
pub use scene::{
    AlphaMode, Material, MaterialId, Object, ObjectId, Scene, Texture, TextureId, TextureRef, Wrap,
};
pub use settings::{BakeSettings, DirectLight};
