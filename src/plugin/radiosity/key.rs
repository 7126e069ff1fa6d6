//! What tells one state of the static world from another.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;

use super::lights::FoundLight;
use super::settings::RadiositySettings;
use super::survey::{FoundObject, Survey};
use crate::plugin::FrescoView;
use crate::radiosity::{BakeSettings, DirectLight, LightKind, Solver};

/// The key of a survey: of all that the bake reads, and of nothing else.
pub(super) fn key(survey: &Survey, settings: &RadiositySettings, view: FrescoView) -> u64 {
    let mut state = FixedHasher.build_hasher();
    for object in &survey.objects {
        hash_object(&mut state, object);
    }
    for light in &survey.lights {
        hash_light(&mut state, light);
    }
    hash_vector(&mut state, survey.sky);
    hash_floats(&mut state, &[settings.emissive_gain]);
    hash_settings(&mut state, &settings.bake);
    if view.replaces_light() {
        view.hash(&mut state);
    }
    state.finish()
}

fn hash_object(state: &mut impl Hasher, o: &FoundObject) {
    (o.entity, o.mesh.version, o.material.version, o.effect).hash(state);
    for image in [&o.images.base_color, &o.images.emissive, &o.images.metallic] {
        image.as_ref().map(|i| i.version).hash(state);
    }
    hash_floats(state, &o.transform.to_cols_array());
}

fn hash_light(state: &mut impl Hasher, light: &FoundLight) {
    (light.entity, light.direct == DirectLight::Baked).hash(state);
    hash_vector(state, light.power);
    std::mem::discriminant(&light.kind).hash(state);
    match light.kind {
        LightKind::Point { position, range } => {
            hash_vector(state, position);
            hash_floats(state, &[range]);
        }
        LightKind::Spot {
            position,
            direction,
            inner_angle,
            outer_angle,
            range,
        } => {
            hash_vector(state, position);
            hash_vector(state, direction);
            hash_floats(state, &[inner_angle, outer_angle, range]);
        }
        LightKind::Directional { direction } => hash_vector(state, direction),
        LightKind::Rect {
            position,
            direction,
            right,
            width,
            height,
            range,
        } => {
            hash_vector(state, position);
            hash_vector(state, direction);
            hash_vector(state, right);
            hash_floats(state, &[width, height, range]);
        }
    }
}

fn hash_settings(state: &mut impl Hasher, bake: &BakeSettings) {
    // Named one by one: a setting that is new has to be put here.
    let BakeSettings {
        max_edge,
        refine,
        error,
        max_vertices,
        max_seconds,
        elements,
        adapt,
        form_factors,
        element_rays,
        gather_rays,
        samples_per_vertex,
        emitter_rays,
        sample_emitters,
        contribution,
        directional,
        vertex_quality,
        solver,
        solver_tolerance,
        max_sweeps,
        max_reflectance,
        max_memory,
        seed,
    } = *bake;
    let counts = [
        max_vertices,
        elements,
        element_rays,
        gather_rays,
        emitter_rays,
        max_sweeps,
        seed,
    ];
    counts.hash(state);
    (form_factors, contribution).hash(state);
    let flags = [refine, adapt, sample_emitters, directional, vertex_quality];
    flags.hash(state);
    max_memory.hash(state);
    std::mem::discriminant(&solver).hash(state);
    if let Solver::Sor { omega } = solver {
        hash_floats(state, &[omega]);
    }
    [max_edge, max_seconds]
        .map(|s| s.map(f32::to_bits))
        .hash(state);
    hash_floats(
        state,
        &[error, samples_per_vertex, solver_tolerance, max_reflectance],
    );
}

fn hash_vector(state: &mut impl Hasher, v: Vec3) {
    hash_floats(state, &v.to_array());
}

fn hash_floats(state: &mut impl Hasher, values: &[f32]) {
    for value in values {
        // −0 is 0.
        state.write_u32((value + 0.0).to_bits());
    }
}
