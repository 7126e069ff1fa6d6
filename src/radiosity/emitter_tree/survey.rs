use glam::Vec3;

use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::{OFFSET, Occluders};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::sampling::{cosine_hemisphere, frame, hash, sobol};
use crate::radiosity::validate::ValidScene;

/// Rays of the survey that measures how much of the view each emissive material fills.
const SURVEY_RAYS: usize = 4096;

/// The share of the view that each emissive material fills, averaged over all surfaces.
pub(super) fn survey(
    scene: &ValidScene,
    elements: &Elements,
    occluders: &Occluders,
    seed: u32,
    observer: &dyn Observer,
) -> Result<Vec<f32>, Cancelled> {
    // Elements chosen evenly, each ray counted by the area it stands for.
    let rays = SURVEY_RAYS.min(16 * elements.len());
    let chunks = map_ranges(rays, 256, Stage::Occlusion, observer, |range| {
        let mut seen = vec![0.0_f32; scene.materials.len()];
        let mut total = 0.0;
        for i in range {
            let element = i * elements.len() / rays;
            let area = elements.area[element];
            total += area;
            let [u, v, s, t] = sobol(i as u32, 2, seed);
            let point = elements.point(scene, ElementId(element as u32), u, v);
            let direction = frame(point.normal) * cosine_hemisphere(s, t);
            let origin = point.position + point.normal * OFFSET;
            let Some(hit) =
                occluders.closest(origin, direction, point.triangle, hash(seed, i as u32))
            else {
                continue;
            };
            if elements.emission_at(hit.triangle, hit.uv, hit.back) != Vec3::ZERO {
                let key = scene.triangles[hit.triangle as usize];
                seen[scene.objects[key.object as usize].material.0 as usize] += area;
            }
        }
        (seen, total)
    })?;
    let total: f32 = chunks.iter().map(|c| c.1).sum();
    let mut views = vec![0.0; scene.materials.len()];
    for (seen, _) in chunks {
        for (view, seen) in views.iter_mut().zip(seen) {
            *view += seen / total.max(f32::MIN_POSITIVE);
        }
    }
    Ok(views)
}
