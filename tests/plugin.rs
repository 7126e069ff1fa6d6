//! The Bevy side without a renderer.
#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "plugin/changes.rs"]
mod changes;
#[path = "plugin/life.rs"]
mod life;
#[path = "plugin/world.rs"]
mod world;
