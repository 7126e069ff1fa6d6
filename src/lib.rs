//! Baked diffuse light for [Bevy](https://bevyengine.org), in the vertices of your meshes.
//!
//! A scene goes in, the light that every vertex receives comes out: direct light with its shadows
//! and all that bounces between surfaces, solved as *radiosity*. There are no lightmap textures, no
//! second UV set and no round trip through another program.
//!
//! # From the command line
//!
//! ```text
//! cargo bake room.glb --preview room.png
//! ```
//!
//! gives the file back with its light in the vertex attribute `_BAKED_LIGHT`, and a picture of it.
//! `fresco displace` raises the meshes of a file by a height map first. See the README for the options and
//! `docs/file_formats.md` for the contract of the file.
//!
//! # From Rust
//!
//! ```
//! use bevy_fresco::radiosity::{BakeSettings, Light, LightKind, Material, MaterialId, Object, Scene, bake};
//! use glam::Vec3;
//!
//! let floor = Object {
//!     name: "floor".into(),
//!     positions: vec![Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X],
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     material: MaterialId(0),
//!     ..Object::default()
//! };
//! let sun = Light {
//!     name: "sun".into(),
//!     power: Vec3::splat(10_000.0), // lux
//!     kind: LightKind::Directional { direction: Vec3::NEG_Y },
//!     ..Light::default()
//! };
//! let scene = Scene {
//!     objects: vec![floor],
//!     materials: vec![Material::default()],
//!     lights: vec![sun],
//!     ..Scene::default()
//! };
//! let bake = bake(&scene.validate()?, &BakeSettings::DRAFT, &())?;
//! // Irradiance / π: what a white surface would show.
//! assert!((bake.objects[0].light[0].x - 10_000.0 / std::f32::consts::PI).abs() < 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # In Bevy
//!
//! Add `plugin::FrescoPlugins` and put `StaticLighting` on what does not move:
//!
//! ```text
//! App::new().add_plugins((DefaultPlugins, FrescoPlugins));
//! commands.spawn((WorldAssetRoot(room), StaticLighting::default()));
//! ```
//!
//! The light is baked in the background and again when a lamp, a wall or a block changes, each time
//! from the stage that the change calls for. `docs/bevy.md` is the manual.
//!
//! `Displacement` on an entity raises its mesh by a height map, in the background too; baked light then falls on
//! what it became. `docs/displacement.md` tells more.
//!
//! # Modules and features
//!
//! | module | what it does | feature |
//! |---|---|---|
//! | [`radiosity`] | scene, elements, form factors, solver, vertex light; no engine in it | always |
//! | [`mesh`] | refinement that keeps shared edges together, position classes, texture coordinates | always |
//! | [`height_map`] | height maps from photos; heights and slopes between their texels | always |
//! | [`displacement`] | meshes raised by a height map, evenly or where the relief asks for vertices | always |
//! | [`bump`] | normals of a surface raised by a height map, in plain Rust | always |
#![cfg_attr(
    feature = "gltf",
    doc = "| [`gltf`] | glTF in and out, without Bevy | `gltf` |"
)]
#![cfg_attr(feature = "cli", doc = "| [`cli`] | the `fresco` command | `cli` |")]
#![cfg_attr(
    feature = "bevy",
    doc = "| [`plugin`] | baked light in a running Bevy app: plugins, components, the material that shows it | `bevy` |"
)]
//!
//! The feature `parallel` bakes on all cores; results are the same bytes with and without it.
//!
//! # If something looks wrong
//!
//! The first things to look at; `docs/troubleshooting.md` has more.
//!
//! - **It is black.** Read the notes of the report: it says so when no light reaches any surface,
//!   which is mostly a one-sided lamp that faces the wrong way.
//! - **It is blotchy.** The report's sampling error is above a percent or two: use a finer preset.
//! - **Shadows are coarse.** Vertices are put where the light needs them, to the error asked for: ask for
//!   a smaller [`error`](radiosity::BakeSettings::error), and see what the report says it stopped at.
//! - **Shadows are missing on one object.** It may be one that keeps its vertices: see
//!   [`Object::refine`](radiosity::Object::refine).
//! - **Light leaks under a wall.** Faces are cut where others touch them. A wall that hovers higher
//!   than a two-thousandth of the scene's size lets light through, as it would.

pub mod bump;
#[cfg(feature = "cli")]
pub mod cli;
pub mod displacement;
#[cfg(any(feature = "gltf", feature = "bevy"))]
mod file;
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod height_map;
pub mod mesh;
#[cfg(feature = "panel")]
pub mod panel;
mod parallel;
#[cfg(feature = "bevy")]
pub mod plugin;
pub mod radiosity;
#[cfg(any(feature = "cli", feature = "panel"))]
mod text;
