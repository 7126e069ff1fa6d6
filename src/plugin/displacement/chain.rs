//! The way back from what is shown to what it was made from.

use bevy::prelude::*;

use super::DisplacedMesh;
use crate::plugin::radiosity::BakedLighting;

/// What an entity shows, less its light.
pub(super) fn unlit<'a>(
    shown: &'a Handle<Mesh>,
    baked: Option<&'a BakedLighting>,
) -> &'a Handle<Mesh> {
    match baked {
        Some(baked) if baked.lit == *shown => &baked.source,
        _ => shown,
    }
}

/// Whether what is shown is what this plugin has made, lit or not.
pub(super) fn is_displaced(unlit: &Handle<Mesh>, displaced: Option<&DisplacedMesh>) -> bool {
    displaced.is_some_and(|d| d.displaced == *unlit)
}

/// Where the chain begins.
pub(super) fn source<'a>(
    shown: &'a Handle<Mesh>,
    displaced: Option<&'a DisplacedMesh>,
    baked: Option<&'a BakedLighting>,
) -> &'a Handle<Mesh> {
    let unlit = unlit(shown, baked);
    let displaced = displaced.filter(|_| is_displaced(unlit, displaced));
    displaced.map_or(unlit, |displaced| &displaced.source)
}
