//! The Bevy side without a renderer.
#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "plugin/baked_scene.rs"]
mod baked_scene;
#[path = "plugin/changes.rs"]
mod changes;
#[path = "plugin/displaced.rs"]
mod displaced;
#[path = "plugin/displaced_light.rs"]
mod displaced_light;
#[path = "plugin/life.rs"]
mod life;
#[path = "plugin/light_bake.rs"]
mod light_bake;
#[path = "plugin/views.rs"]
mod views;
#[path = "plugin/world.rs"]
mod world;
